#define _GNU_SOURCE /* sched_getaffinity, strsep */
#include "server/base/machine.h"

#include "core/base/parallel.h"

#include <limits.h>
#include <malloc.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

unsigned vor_machine_cores(void)
{
    cpu_set_t set;

    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return 1;
    return CPU_COUNT(&set) > VOR_THREADS_MAX ? VOR_THREADS_MAX : (unsigned)CPU_COUNT(&set);
}

static size_t read_limit(const char *path)
{
    FILE *file = fopen(path, "re");
    unsigned long long value = 0;

    if (file == NULL)
        return 0;
    if (fscanf(file, "%llu", &value) != 1) /* "max" */
        value = 0;
    (void)fclose(file);
    return (size_t)value;
}

/* The lesser of two limits, of which 0 is none. */
static size_t lesser(size_t a, size_t b)
{
    if (a == 0 || b == 0)
        return a + b;
    return a < b ? a : b;
}

/* The least limit of a group of that path and of those around it. A container sees its own group as
 * the outermost one, by whatever path the machine knows it. */
static size_t limit_up_from(const char *top, const char *group, const char *name)
{
    size_t length = strlen(group), limit = 0;
    char path[PATH_MAX];

    for (;;) {
        while (length > 0 && group[length - 1] == '/')
            length--;
        if (snprintf(path, sizeof path, "%s%.*s/%s", top, (int)length, group, name) <
            (int)sizeof path)
            limit = lesser(limit, read_limit(path));
        if (length == 0)
            return limit;
        while (length > 0 && group[length - 1] != '/')
            length--;
    }
}

/* True when the list of controllers, between the colons of a line, has memory. */
static int has_memory(char *controllers)
{
    char *rest = controllers;

    for (char *one; (one = strsep(&rest, ",")) != NULL;)
        if (strcmp(one, "memory") == 0)
            return 1;
    return 0;
}

size_t vor_machine_group_memory(const char *groups, const char *root)
{
    FILE *file = fopen(groups, "re");
    char line[PATH_MAX + 64], top[PATH_MAX];
    size_t limit = 0;

    /* Where /proc tells nothing, the outermost groups of both kinds. */
    (void)snprintf(top, sizeof top, "%s/memory", root);
    limit = lesser(limit_up_from(root, "", "memory.max"),
                   limit_up_from(top, "", "memory.limit_in_bytes"));
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        char *rest = line, *number = strsep(&rest, ":"), *controllers = strsep(&rest, ":");

        if (rest == NULL || strstr(rest, "..") != NULL) /* a group that cannot be seen from here */
            continue;
        rest[strcspn(rest, "\n")] = '\0';
        if (strcmp(number, "0") == 0 && controllers[0] == '\0')
            limit = lesser(limit, limit_up_from(root, rest, "memory.max"));
        else if (has_memory(controllers))
            limit = lesser(limit, limit_up_from(top, rest, "memory.limit_in_bytes"));
    }
    if (file != NULL)
        (void)fclose(file);
    return limit;
}

size_t vor_machine_memory(void)
{
    size_t memory = (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE);

    return lesser(memory, vor_machine_group_memory("/proc/self/cgroup", "/sys/fs/cgroup"));
}

void vor_machine_set_oom_score(int score)
{
    FILE *file = fopen("/proc/self/oom_score_adj", "we");

    if (file == NULL)
        return;
    (void)fprintf(file, "%d", score);
    (void)fclose(file); /* which may fail: not everybody may */
}

/* Bytes. What a daemon holds more after lists of 1,000 jobs (1 MB each), 120 of them by four
 * clients: 0.8 / 0.9 / 1.0 MB at half, this and double, 1.8 at four times as much, 5.5 as the C
 * library is by itself. */
enum { LARGE_PIECE = 256 << 10 };

void vor_machine_give_back(void)
{
    (void)mallopt(M_MMAP_THRESHOLD, LARGE_PIECE);
    (void)mallopt(M_TRIM_THRESHOLD, LARGE_PIECE);
}

int vor_machine_thread(pthread_t *thread, const char *name, void *(*run)(void *arg), void *arg)
{
    int error = pthread_create(thread, NULL, run, arg);

    if (error == 0)
        (void)pthread_setname_np(*thread, name);
    return error;
}
