/* The zygote and its children: what they are given, how their ends are told, and that nothing of
 * them is left, however the front ends. */
#include "server/base/disk.h"
#include "server/proc/zygote.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const double PATIENCE = 20; /* seconds */

/* --- kinds of children ------------------------------------------------------------------------ */

/* Sends each message back, with the descriptors that it had. */
static int echo(int channel, const int *fds, unsigned fd_count)
{
    char bytes[VOR_CHANNEL_BYTES];
    struct vor_message message = {.bytes = bytes, .capacity = sizeof bytes};

    (void)fds;
    (void)fd_count;
    while (vor_channel_receive(channel, &message, -1) == VOR_CHANNEL_MESSAGE) {
        if (vor_channel_send(channel, bytes, message.size, message.fds, message.fd_count, NULL) !=
            VOR_OK)
            return 1;
        vor_message_close(&message);
    }
    return 7;
}

/* Sends what its first descriptor holds, and then which descriptors are open. */
static int tell_fds(int channel, const int *fds, unsigned fd_count)
{
    char text[4096] = "";
    ssize_t size = fd_count == 2 ? read(fds[0], text, sizeof text) : -1;
    DIR *open_fds = opendir("/proc/self/fd");
    size_t length = 0;
    struct dirent *entry;

    if (size <= 0 || open_fds == NULL ||
        vor_channel_send(channel, text, (size_t)size, NULL, 0, NULL) != VOR_OK)
        return 1;
    while ((entry = readdir(open_fds)) != NULL) {
        int fd = atoi(entry->d_name);

        if (entry->d_name[0] != '.' && fd > STDERR_FILENO && fd != dirfd(open_fds) &&
            (fd != channel || channel != 3) && (fd != fds[0] || fds[0] != 4) &&
            (fd != fds[1] || fds[1] != 5))
            length += (size_t)snprintf(text + length, sizeof text - length, " %d", fd);
    }
    closedir(open_fds);
    text[length++] = '.';
    return vor_channel_send(channel, text, length, NULL, 0, NULL) == VOR_OK ? 0 : 1;
}

static int spin(int channel, const int *fds, unsigned fd_count)
{
    volatile unsigned long turns = 0;

    (void)channel;
    (void)fds;
    (void)fd_count;
    for (;;)
        turns++;
    return 0;
}

static int crash(int channel, const int *fds, unsigned fd_count)
{
    (void)channel;
    (void)fds;
    (void)fd_count;
    (void)signal(SIGABRT, SIG_DFL);
    return raise(SIGABRT);
}

enum { ECHO, TELL_FDS, SPIN, CRASH, KINDS };

static const struct vor_child_kind kinds[KINDS] = {
    [ECHO] = {"t-echo", echo},
    [TELL_FDS] = {"t-fds", tell_fds},
    [SPIN] = {"t-spin", spin},
    [CRASH] = {"t-crash", crash},
};

/* --- messages --------------------------------------------------------------------------------- */

VT_TEST_LOOP(a_message_arrives_whole_with_its_descriptors, 3)
{
    static char sent[VOR_CHANNEL_BYTES], bytes[VOR_CHANNEL_BYTES];
    struct vor_message message = {.bytes = bytes, .capacity = sizeof bytes};
    size_t size = _i == 0 ? 1 : _i == 1 ? 1000 : sizeof sent;
    int ends[2], pipes[2], given[VOR_CHANNEL_FDS];

    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    ck_assert_int_eq(pipe(pipes), 0);
    for (size_t i = 0; i < size; i++)
        sent[i] = (char)(i * 31 + 7);
    for (int i = 0; i < VOR_CHANNEL_FDS; i++)
        given[i] = pipes[1];
    vt_assert_ok(
        vor_channel_send(ends[0], sent, size, given, (unsigned)_i * VOR_CHANNEL_FDS / 2, &vt_err));
    ck_assert_int_eq(vor_channel_receive(ends[1], &message, PATIENCE), VOR_CHANNEL_MESSAGE);
    ck_assert_uint_eq(message.size, size);
    ck_assert_mem_eq(bytes, sent, size);
    ck_assert_uint_eq(message.fd_count, (unsigned)_i * VOR_CHANNEL_FDS / 2);
    for (unsigned i = 0; i < message.fd_count; i++)
        ck_assert_int_eq(write(message.fds[i], "x", 1), 1);
    vor_message_close(&message);
    ck_assert_int_eq(vor_channel_receive(ends[1], &message, 0), VOR_CHANNEL_LATE);
    close(ends[0]);
    ck_assert_int_eq(vor_channel_receive(ends[1], &message, PATIENCE), VOR_CHANNEL_GONE);
    vt_assert_fails(VOR_E_IO, vor_channel_send(ends[1], "x", 1, NULL, 0, &vt_err));
    close(ends[1]);
    close(pipes[0]);
    close(pipes[1]);
}

VT_TEST(a_message_longer_than_its_room_breaks_the_channel_and_leaks_nothing)
{
    char bytes[8] = "kept";
    struct vor_message message = {.bytes = bytes, .capacity = 3};
    int ends[2], before = dup(STDERR_FILENO), after;

    close(before);
    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    vt_assert_ok(vor_channel_send(ends[0], "12345", 5, ends, 2, &vt_err));
    ck_assert_int_eq(vor_channel_receive(ends[1], &message, PATIENCE), VOR_CHANNEL_GONE);
    ck_assert_int_eq(bytes[3], 't');
    ck_assert_uint_eq(message.fd_count, 0);
    close(ends[0]);
    close(ends[1]);
    after = dup(STDERR_FILENO);
    close(after);
    ck_assert_int_eq(before, after);
}

VT_TEST(what_was_sent_arrives_also_from_a_side_that_closed_with_messages_unread)
{
    char bytes[8];
    struct vor_message message = {.bytes = bytes, .capacity = sizeof bytes};
    int ends[2];

    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    vt_assert_ok(vor_channel_send(ends[0], "unread", 6, NULL, 0, &vt_err));
    vt_assert_ok(vor_channel_send(ends[1], "last", 4, NULL, 0, &vt_err));
    close(ends[1]);
    ck_assert_int_eq(vor_channel_receive(ends[0], &message, PATIENCE), VOR_CHANNEL_MESSAGE);
    ck_assert_mem_eq(bytes, "last", 4);
    ck_assert_int_eq(vor_channel_receive(ends[0], &message, PATIENCE), VOR_CHANNEL_GONE);
    close(ends[0]);
}

/* --- children --------------------------------------------------------------------------------- */

static struct vor_zygote start(void)
{
    struct vor_zygote zygote;

    vt_assert_ok(vor_zygote_start(&zygote, kinds, KINDS, &vt_err));
    return zygote;
}

static struct vor_child spawn(struct vor_zygote *zygote, unsigned kind)
{
    struct vor_child child;

    vt_assert_ok(vor_zygote_spawn(&child, zygote, kind, NULL, 0, &vt_err));
    return child;
}

VT_TEST(a_child_answers_until_its_channel_is_closed)
{
    struct vor_zygote zygote = start();
    struct vor_child child = spawn(&zygote, ECHO);
    struct vor_child_end end;
    char bytes[100];
    struct vor_message message = {.bytes = bytes, .capacity = sizeof bytes};

    for (int i = 0; i < 3; i++) {
        vt_assert_ok(vor_channel_send(child.channel, "over there", 10, &child.channel, 1, &vt_err));
        ck_assert_int_eq(vor_channel_receive(child.channel, &message, PATIENCE),
                         VOR_CHANNEL_MESSAGE);
        ck_assert_uint_eq(message.size, 10);
        ck_assert_uint_eq(message.fd_count, 1);
        ck_assert_mem_eq(bytes, "over there", 10);
        vor_message_close(&message);
    }
    ck_assert(!vor_child_wait(&child, &end, 0));
    close(child.channel);
    child.channel = -1;
    ck_assert(vor_child_wait(&child, &end, PATIENCE));
    ck_assert_int_eq(end.signal, 0);
    ck_assert_int_eq(end.status, 7);
    ck_assert_uint_gt(end.peak, 0);
    vor_child_free(&child);
    vor_zygote_stop(&zygote);
}

VT_TEST(a_child_has_its_own_descriptors_from_3_on_and_no_others)
{
    struct vor_zygote zygote;
    struct vor_child child, other;
    struct vor_child_end end;
    char bytes[4096];
    struct vor_message message = {.bytes = bytes, .capacity = sizeof bytes};
    int before = open("/dev/null", O_RDONLY), pipes[2];

    zygote = start();
    other = spawn(&zygote, ECHO);
    ck_assert_int_eq(pipe(pipes), 0);
    ck_assert_int_eq(write(pipes[1], "in a pipe", 9), 9);
    vt_assert_ok(vor_zygote_spawn(&child, &zygote, TELL_FDS, pipes, 2, &vt_err));
    ck_assert_int_eq(vor_channel_receive(child.channel, &message, PATIENCE), VOR_CHANNEL_MESSAGE);
    ck_assert_uint_eq(message.size, 9);
    ck_assert_mem_eq(bytes, "in a pipe", 9);
    ck_assert_int_eq(vor_channel_receive(child.channel, &message, PATIENCE), VOR_CHANNEL_MESSAGE);
    ck_assert_msg(message.size == 1 && bytes[0] == '.', "open besides: %.*s", (int)message.size,
                  bytes);
    ck_assert(vor_child_wait(&child, &end, PATIENCE));
    ck_assert_int_eq(end.status, 0);
    vor_child_free(&child);
    vor_child_free(&other);
    vor_zygote_stop(&zygote);
    close(before);
    close(pipes[0]);
    close(pipes[1]);
}

VT_TEST(a_child_that_crashes_or_is_killed_is_told_with_its_signal)
{
    struct vor_zygote zygote = start();
    struct vor_child crashed = spawn(&zygote, CRASH), spins = spawn(&zygote, SPIN);
    struct vor_child_end end;

    ck_assert(vor_child_wait(&crashed, &end, PATIENCE));
    ck_assert_int_eq(end.signal, SIGABRT);
    ck_assert(!vor_child_wait(&spins, &end, 0.05));
    vor_child_kill(&spins);
    ck_assert(vor_child_wait(&spins, &end, PATIENCE));
    ck_assert_int_eq(end.signal, SIGKILL);
    ck_assert_double_gt(end.cpu_seconds, 0);
    vor_child_free(&crashed);
    vor_child_free(&spins);
    vor_zygote_stop(&zygote);
}

VT_TEST(an_unknown_kind_and_too_many_children_are_refused_and_the_rest_lives_on)
{
    static struct vor_child many[VOR_CHILDREN];
    struct vor_zygote zygote = start();
    struct vor_child child;
    struct vor_child_end end;

    vt_assert_fails(VOR_E_IO, vor_zygote_spawn(&child, &zygote, KINDS, NULL, 0, &vt_err));
    for (unsigned i = 0; i < VOR_CHILDREN; i++)
        many[i] = spawn(&zygote, ECHO);
    vt_assert_fails(VOR_E_IO, vor_zygote_spawn(&child, &zygote, ECHO, NULL, 0, &vt_err));
    vor_child_kill(&many[0]);
    ck_assert(vor_child_wait(&many[0], &end, PATIENCE));
    child = spawn(&zygote, ECHO);
    vor_child_free(&child);
    for (unsigned i = 0; i < VOR_CHILDREN; i++)
        vor_child_free(&many[i]);
    vor_zygote_stop(&zygote);
}

static void *spawn_many(void *ctx)
{
    enum { TIMES = 20 };
    char bytes[4];
    struct vor_message message = {.bytes = bytes, .capacity = sizeof bytes};
    struct vor_child_end end;

    for (int i = 0; i < TIMES; i++) {
        struct vor_child child;
        struct vor_error err;

        if (vor_zygote_spawn(&child, ctx, ECHO, NULL, 0, &err) != VOR_OK ||
            vor_channel_send(child.channel, &i, sizeof i, NULL, 0, &err) != VOR_OK ||
            vor_channel_receive(child.channel, &message, PATIENCE) != VOR_CHANNEL_MESSAGE ||
            memcmp(bytes, &i, sizeof i) != 0)
            return ctx;
        vor_child_kill(&child);
        if (!vor_child_wait(&child, &end, PATIENCE) || end.signal != SIGKILL)
            return ctx;
        vor_child_free(&child);
    }
    return NULL;
}

VT_TEST(threads_that_spawn_beside_each_other_get_a_child_of_their_own_each)
{
    enum { THREADS = 4 };
    struct vor_zygote zygote = start();
    pthread_t threads[THREADS];
    void *failed;

    for (int i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, spawn_many, &zygote), 0);
    for (int i = 0; i < THREADS; i++) {
        ck_assert_int_eq(pthread_join(threads[i], &failed), 0);
        ck_assert_ptr_null(failed);
    }
    vor_zygote_stop(&zygote);
}

/* --- ends ------------------------------------------------------------------------------------- */

VT_TEST(a_zygote_that_died_is_told_by_every_call)
{
    struct vor_zygote zygote = start();
    struct vor_child child = spawn(&zygote, SPIN), none;
    struct vor_child_end end;

    ck_assert(!vor_zygote_died(&zygote));
    ck_assert_int_eq(kill(zygote.pid, SIGKILL), 0);
    ck_assert(vor_child_wait(&child, &end, PATIENCE));
    ck_assert_int_eq(end.signal, SIGKILL);
    vt_assert_fails(VOR_E_IO, vor_zygote_spawn(&none, &zygote, ECHO, NULL, 0, &vt_err));
    vor_child_free(&child);
    while (!vor_zygote_died(&zygote))
        continue;
    ck_assert(vor_zygote_died(&zygote));
    vor_zygote_stop(&zygote);
}

/* A front with the lock of a store and two children; says who they are and waits to be killed. */
static void be_front(const char *lock, int out)
{
    pid_t pids[3];
    struct vor_zygote zygote = start();
    struct vor_child echoes = spawn(&zygote, ECHO), spins = spawn(&zygote, SPIN);
    long holder;
    int fd;

    vt_assert_ok(vor_storage_lock(&fd, lock, 0, &holder, &vt_err));
    pids[0] = zygote.pid;
    pids[1] = echoes.pid;
    pids[2] = spins.pid;
    ck_assert_int_eq(write(out, pids, sizeof pids), (ssize_t)sizeof pids);
    for (;;)
        pause();
}

/* SIGTERM and the like, sent to all of them as a terminal or a supervisor does, end none. */
static void signal_all(const pid_t pids[3])
{
    static const int numbers[] = {SIGTERM, SIGINT, SIGHUP};
    struct timespec moment = {.tv_nsec = 20000000};

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            ck_assert_int_eq(kill(pids[i], numbers[k]), 0);
    nanosleep(&moment, NULL);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(kill(pids[i], 0), 0);
}

VT_TEST(a_front_that_is_killed_leaves_no_process_and_no_lock)
{
    const char *dir = vt_dir_make();
    char lock[300];
    int pipes[2], fd, status;
    pid_t front, pids[3];
    long holder;

    (void)snprintf(lock, sizeof lock, "%s/lock", dir);
    ck_assert_int_eq(pipe(pipes), 0);
    ck_assert_int_eq(prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0), 0);
    front = fork();
    if (front == 0)
        be_front(lock, pipes[1]);
    ck_assert_int_eq(read(pipes[0], pids, sizeof pids), (ssize_t)sizeof pids);
    signal_all(pids);
    ck_assert_int_eq(kill(front, SIGKILL), 0);
    /* What is left of it falls to this process, which waits until there is nothing more. */
    while (wait(&status) > 0)
        continue;
    ck_assert_int_eq(errno, ECHILD);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(kill(pids[i], 0), -1);
    vt_assert_ok(vor_storage_lock(&fd, lock, 0, &holder, &vt_err));
    close(fd);
    close(pipes[0]);
    close(pipes[1]);
}
