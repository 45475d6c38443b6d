/* What a supervisor is told, and when a thread counts as stuck. */
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include "server/base/notify.h"
#include "server/http/watchdog.h"

#include <pthread.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

/* A supervisor's socket at that address, which NOTIFY_SOCKET then names; "@" is an abstract name.
 */
static int listen_at(const char *name)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);

    ck_assert_int_ge(fd, 0);
    memcpy(at.sun_path, name, strlen(name));
    if (name[0] == '@')
        at.sun_path[0] = '\0';
    ck_assert_int_eq(bind(fd, (const struct sockaddr *)&at,
                          (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(name))),
                     0);
    ck_assert_int_eq(setenv("NOTIFY_SOCKET", name, 1), 0);
    return fd;
}

static const char *heard(int fd)
{
    static char text[256];
    ssize_t got = recv(fd, text, sizeof text - 1, 0);

    text[got > 0 ? got : 0] = '\0';
    return text;
}

VT_TEST_LOOP(a_supervisor_hears_what_it_is_told, 2)
{
    const char *text;
    char name[64];
    int fd;

    (void)snprintf(name, sizeof name, _i == 0 ? "/tmp/vt-notify-%ld" : "@vt-notify-%ld",
                   (long)getpid());
    fd = listen_at(name);
    vor_notify("READY=1\nSTATUS=x");
    ck_assert_str_eq(heard(fd), "READY=1\nSTATUS=x");
    vor_notify_reloading();
    text = heard(fd);
    ck_assert_msg(strncmp(text, "RELOADING=1\nMONOTONIC_USEC=", 27) == 0, "%s", text);
    ck_assert_int_gt(atoll(text + 27), 0);
    (void)close(fd);
    (void)unlink(name);
}

/* A supervisor listens where each of these names would lead if it were cut, or taken as it is. */
VT_TEST(nobody_is_told_where_nobody_asked)
{
    static const char *const wrong[] = {"", "@", "vt-relative", "/no/such/socket"};
    char longest[sizeof((struct sockaddr_un *)0)->sun_path], longer[sizeof longest + 1];
    const char *dir = vt_dir_make();
    int cut, relative;

    (void)snprintf(longest, sizeof longest, "@vt-longest-%0*ld", (int)sizeof longest - 13,
                   (long)getpid());
    (void)snprintf(longer, sizeof longer, "%sx", longest);
    ck_assert_int_eq(chdir(dir), 0);
    relative = listen_at("vt-relative");
    cut = listen_at(longest);
    vor_notify("READY=1");
    ck_assert_str_eq(heard(cut), "READY=1");
    ck_assert_int_eq(setenv("NOTIFY_SOCKET", longer, 1), 0);
    vor_notify("READY=1");
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        ck_assert_int_eq(setenv("NOTIFY_SOCKET", wrong[i], 1), 0);
        vor_notify("READY=1");
    }
    ck_assert_int_eq(unsetenv("NOTIFY_SOCKET"), 0);
    vor_notify("READY=1");
    ck_assert_str_eq(heard(cut), "");
    ck_assert_str_eq(heard(relative), "");
    (void)close(cut);
    (void)close(relative);
    ck_assert_int_eq(chdir("/"), 0);
}

/* What its buffer does not hold is dropped, and what comes once it reads again is not. */
VT_TEST(a_supervisor_that_does_not_read_stops_nothing)
{
    enum { SENT = 5000 };
    int fd, kept = 0;
    char name[64];

    (void)snprintf(name, sizeof name, "@vt-deaf-%ld", (long)getpid());
    fd = listen_at(name);
    for (int i = 0; i < SENT; i++)
        vor_notify("WATCHDOG=1");
    while (strcmp(heard(fd), "WATCHDOG=1") == 0)
        kept++;
    ck_assert_int_gt(kept, 0);
    ck_assert_int_lt(kept, SENT);
    vor_notify("READY=1");
    ck_assert_str_eq(heard(fd), "READY=1");
    (void)close(fd);
}

VT_TEST(the_watchdog_is_fed_twice_as_often_as_it_asks)
{
    static const struct {
        const char *allowed;
        int ours;
        double seconds;
    } cases[] = {{"30000000", 1, 15}, {"1", 1, 5e-7}, {"30000000", 0, 0}, {"", 1, 0},
                 {"-5", 1, 0},        {"3x", 1, 0},   {"0", 1, 0}};
    char pid[32];

    ck_assert_int_eq(unsetenv("WATCHDOG_USEC"), 0);
    ck_assert(vor_notify_watchdog() == 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        (void)snprintf(pid, sizeof pid, "%ld", (long)getpid() + (cases[i].ours ? 0 : 1));
        ck_assert_int_eq(setenv("WATCHDOG_PID", pid, 1), 0);
        ck_assert_int_eq(setenv("WATCHDOG_USEC", cases[i].allowed, 1), 0);
        ck_assert_double_eq_tol(vor_notify_watchdog(), cases[i].seconds, 1e-9);
    }
    ck_assert_int_eq(unsetenv("WATCHDOG_PID"), 0);
    ck_assert_int_eq(setenv("WATCHDOG_USEC", "4000000", 1), 0);
    ck_assert_double_eq_tol(vor_notify_watchdog(), 2, 1e-9);
}

static struct vor_watchdog watchdog;

static void *hang(void *ctx)
{
    pthread_barrier_t *barrier = ctx;

    vor_watchdog_enter(&watchdog);
    pthread_barrier_wait(barrier); /* it hangs */
    pthread_barrier_wait(barrier);
    vor_watchdog_leave(&watchdog);
    return NULL;
}

VT_TEST(a_thread_that_hangs_is_seen_beside_one_that_does_not)
{
    pthread_barrier_t barrier;
    pthread_t thread;

    ck_assert(vor_watchdog_longest(&watchdog) == 0);
    ck_assert_int_eq(pthread_barrier_init(&barrier, NULL, 2), 0);
    ck_assert_int_eq(pthread_create(&thread, NULL, hang, &barrier), 0);
    pthread_barrier_wait(&barrier);
    for (int i = 0; i < 100; i++) {
        vor_watchdog_enter(&watchdog);
        vor_watchdog_leave(&watchdog);
    }
    (void)usleep(20000);
    ck_assert_double_ge(vor_watchdog_longest(&watchdog), 0.02);
    pthread_barrier_wait(&barrier);
    pthread_join(thread, NULL);
    ck_assert(vor_watchdog_longest(&watchdog) == 0);
}
