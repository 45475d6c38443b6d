#include "server/base/fault.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS};

enum { FAULTS = sizeof faults / sizeof faults[0] };

/* A handler has no other way to know them. */
static char mark_name[4096];
static pid_t owner;
static struct sigaction before[FAULTS];

/* A symbolic link needs neither a descriptor nor room on the disk for data. What faulted faults
 * again when this returns, what was sent is sent again: both as if there were no handler. */
static void on_fault(int number, siginfo_t *info, void *context)
{
    (void)context;
    if (getpid() == owner)
        (void)!symlink("crashed", mark_name);
    for (int i = 0; i < FAULTS; i++)
        if (faults[i] == number)
            (void)sigaction(number, &before[i], NULL);
    if (info->si_code <= 0)
        (void)raise(number);
}

void vor_fault_arm(const char *mark)
{
    struct sigaction action = {.sa_sigaction = on_fault, .sa_flags = SA_SIGINFO};
    int again = owner == getpid();

    (void)snprintf(mark_name, sizeof mark_name, "%s", mark);
    owner = getpid();
    (void)sigemptyset(&action.sa_mask);
    for (int i = 0; i < FAULTS; i++)
        (void)sigaction(faults[i], &action, again ? NULL : &before[i]);
}

int vor_fault_left(const char *mark)
{
    struct stat info;

    return lstat(mark, &info) == 0;
}

void vor_fault_clear(const char *mark)
{
    (void)unlink(mark);
}
