/* The front sends a request for each child, with the child's end of its channel and one end of a
 * second pair, the watch, which the zygote keeps: it tells there that the child was forked and,
 * once it has ended, how. The front closing its end of the watch is the order to kill. So no call
 * needs a lock, none waits for another's child, and a child that is let go of is gone. */
#define _GNU_SOURCE /* close_range, wait4 */
#include "server/proc/zygote.h"

#include "server/base/disk.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* What the front asks: descriptors are the child's channel, the zygote's end of the watch, then
 * those for the child. */
struct request {
    unsigned kind;
};

/* What the zygote tells on the watch: first this, then struct vor_child_end. */
struct started {
    pid_t pid;
    int error; /* errno; 0 when pid is one */
};

enum { AT_CHANNEL, AT_WATCH, AT_GIVEN };

enum { FIRST_FD = STDERR_FILENO + 1 };

/* Of the zygote itself. */
struct children {
    const struct vor_child_kind *kinds;
    unsigned kind_count;
    int socket, signals; /* signals: readable when a child has ended */
    unsigned count;
    struct {
        pid_t pid;
        int watch;
        int killed; /* the front has let go of it: its watch has no more to show */
    } child[VOR_CHILDREN];
};

/* --- in the child ----------------------------------------------------------------------------- */

/* Moves descriptors to FIRST_FD and those behind it, in order, and closes all others but the three
 * standard ones; where the kernel, before 5.9, has no call for that, those that we can have. */
static void keep_fds(int *fds, unsigned count)
{
    enum {
        ASIDE = FIRST_FD + VOR_CHANNEL_FDS, /* above all places that they go to */
        OLD_KERNEL_FDS = 4096
    };

    for (unsigned i = 0; i < count; i++)
        fds[i] = fcntl(fds[i], F_DUPFD, ASIDE);
    for (unsigned i = 0; i < count; i++) {
        int to = FIRST_FD + (int)i;

        if (fds[i] < 0 || dup3(fds[i], to, O_CLOEXEC) < 0)
            _exit(EXIT_FAILURE);
        fds[i] = to;
    }
    if (close_range(FIRST_FD + count, ~0u, 0) != 0)
        for (unsigned fd = FIRST_FD + count; fd < OLD_KERNEL_FDS; fd++)
            (void)close((int)fd);
}

/* Dies with its parent, also where that has died already. */
static void die_with(pid_t parent)
{
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)
        _exit(EXIT_FAILURE);
}

static _Noreturn void be_child(const struct children *children, pid_t parent,
                               const struct request *request, struct vor_message *message)
{
    const struct vor_child_kind *kind = &children->kinds[request->kind];
    int *fds = &message->fds[AT_WATCH]; /* not for the child: the channel takes its place */
    unsigned count = message->fd_count - AT_WATCH;
    sigset_t none;

    die_with(parent);
    fds[0] = message->fds[AT_CHANNEL];
    keep_fds(fds, count);
    (void)sigemptyset(&none);
    (void)sigprocmask(SIG_SETMASK, &none, NULL);
    (void)prctl(PR_SET_NAME, kind->name, 0, 0, 0);
    _exit(kind->run(fds[0], &fds[1], count - 1));
}

/* --- in the zygote ---------------------------------------------------------------------------- */

/* A front that has gone meanwhile is found when the watch is polled. */
static void tell(int watch, const void *bytes, size_t size)
{
    if (vor_channel_send(watch, bytes, size, NULL, 0, NULL) != VOR_OK)
        return;
}

/* Forks a child; errno, or 0. */
static int spawn(struct children *children, const struct request *request,
                 struct vor_message *message, pid_t *out)
{
    pid_t self = getpid(), pid;

    if (request->kind >= children->kind_count)
        return EINVAL;
    if (children->count == VOR_CHILDREN)
        return EAGAIN;
    pid = fork();
    if (pid == 0)
        be_child(children, self, request, message);
    if (pid < 0)
        return errno;
    children->child[children->count].pid = pid;
    children->child[children->count].killed = 0;
    children->child[children->count++].watch = message->fds[AT_WATCH];
    *out = pid;
    return 0;
}

/* Answers one request; false once the front has gone. */
static int serve_request(struct children *children)
{
    struct request request = {0};
    struct vor_message message = {.bytes = &request, .capacity = sizeof request};
    struct started started = {0};

    if (vor_channel_receive(children->socket, &message, -1) != VOR_CHANNEL_MESSAGE)
        return 0;
    if (message.size != sizeof request || message.fd_count < AT_GIVEN) {
        vor_message_close(&message);
        return 1;
    }
    started.error = spawn(children, &request, &message, &started.pid);
    tell(message.fds[AT_WATCH], &started, sizeof started);
    for (unsigned i = 0; i < message.fd_count; i++)
        if (i != AT_WATCH || started.error != 0)
            (void)close(message.fds[i]);
    return 1;
}

static double seconds_of(const struct timeval *time)
{
    return (double)time->tv_sec + (double)time->tv_usec * 1e-6;
}

/* Tells of the children that have ended, and forgets them. */
static void reap(struct children *children)
{
    struct rusage used;
    int status;
    pid_t pid;

    while ((pid = wait4(-1, &status, WNOHANG, &used)) > 0) {
        struct vor_child_end end = {.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
                                    .status = WIFEXITED(status) ? WEXITSTATUS(status) : 0};
        unsigned i = 0;

        while (i < children->count && children->child[i].pid != pid)
            i++;
        if (i == children->count)
            continue;
        end.cpu_seconds = seconds_of(&used.ru_utime) + seconds_of(&used.ru_stime);
        end.peak = (uint64_t)used.ru_maxrss * 1024;
        tell(children->child[i].watch, &end, sizeof end);
        (void)close(children->child[i].watch);
        children->child[i] = children->child[--children->count];
    }
}

/* Looks after children until the front has gone. */
static void supervise(struct children *children)
{
    static struct pollfd wait[2 + VOR_CHILDREN];
    struct signalfd_siginfo told;

    for (;;) {
        unsigned count = children->count;

        wait[0] = (struct pollfd){.fd = children->socket, .events = POLLIN};
        wait[1] = (struct pollfd){.fd = children->signals, .events = POLLIN};
        /* The front sends nothing on a watch: what shows there is that it was closed. */
        for (unsigned i = 0; i < count; i++)
            wait[2 + i] = (struct pollfd){
                .fd = children->child[i].killed ? -1 : children->child[i].watch, .events = POLLIN};
        if (poll(wait, 2 + count, -1) < 0)
            continue;
        for (unsigned i = 0; i < count; i++)
            if (wait[2 + i].revents != 0) {
                (void)kill(children->child[i].pid, SIGKILL);
                children->child[i].killed = 1;
            }
        if (wait[1].revents != 0 && read(children->signals, &told, sizeof told) > 0)
            reap(children);
        if (wait[0].revents != 0 && !serve_request(children))
            return;
    }
}

static _Noreturn void be_zygote(struct children *children, pid_t parent)
{
    static const int ignored[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGPIPE};
    sigset_t child;
    int null;

    die_with(parent);
    keep_fds(&children->socket, 1);
    /* Nothing is read from standard input nor written to standard output. */
    null = open("/dev/null", O_RDWR | O_CLOEXEC);
    (void)dup2(null, STDIN_FILENO);
    (void)dup2(null, STDOUT_FILENO);
    if (null > STDERR_FILENO)
        (void)close(null);
    for (size_t i = 0; i < sizeof ignored / sizeof ignored[0]; i++)
        (void)signal(ignored[i], SIG_IGN);
    (void)signal(SIGCHLD, SIG_DFL);
    (void)sigemptyset(&child);
    (void)sigaddset(&child, SIGCHLD);
    (void)sigprocmask(SIG_SETMASK, &child, NULL);
    children->signals = signalfd(-1, &child, SFD_CLOEXEC | SFD_NONBLOCK);
    (void)prctl(PR_SET_NAME, "vor-zygote", 0, 0, 0);
    if (children->signals >= 0)
        supervise(children);
    for (unsigned i = 0; i < children->count; i++)
        (void)kill(children->child[i].pid, SIGKILL);
    while (wait(NULL) > 0)
        continue;
    _exit(EXIT_SUCCESS);
}

/* --- in the front ----------------------------------------------------------------------------- */

vor_status vor_zygote_start(struct vor_zygote *out, const struct vor_child_kind *kinds,
                            unsigned kind_count, struct vor_error *err)
{
    static struct children children; /* of the zygote; empty in the front */
    pid_t self = getpid(), pid;
    int ends[2];
    vor_status status = vor_channel_pair(ends, err);

    if (status != VOR_OK)
        return status;
    pid = fork();
    if (pid < 0) {
        status = vor_fail_errno(err, errno, "starting the process that forks others");
        (void)close(ends[0]);
        (void)close(ends[1]);
        return status;
    }
    if (pid == 0) {
        children = (struct children){.kinds = kinds, .kind_count = kind_count, .socket = ends[1]};
        be_zygote(&children, self);
    }
    (void)close(ends[1]);
    *out = (struct vor_zygote){.socket = ends[0], .pid = pid};
    return VOR_OK;
}

void vor_zygote_stop(struct vor_zygote *zygote)
{
    if (zygote->pid == 0)
        return;
    (void)close(zygote->socket);
    while (waitpid(zygote->pid, NULL, 0) < 0 && errno == EINTR)
        continue;
    *zygote = (struct vor_zygote){.socket = -1};
}

int vor_zygote_died(struct vor_zygote *zygote)
{
    if (zygote->pid == 0 || waitpid(zygote->pid, NULL, WNOHANG) != zygote->pid)
        return zygote->pid == 0;
    zygote->pid = 0; /* its socket stays: others may send to it */
    return 1;
}

/* Sends the request; the ends of the zygote and the child are closed here. */
static vor_status ask(const struct vor_zygote *zygote, unsigned kind, const int *fds,
                      unsigned fd_count, int channel, int watch, struct vor_error *err)
{
    struct request request = {kind};
    int sent[VOR_CHANNEL_FDS] = {[AT_CHANNEL] = channel, [AT_WATCH] = watch};
    vor_status status;

    if (fd_count > 0)
        memcpy(&sent[AT_GIVEN], fds, fd_count * sizeof *fds);
    status =
        vor_channel_send(zygote->socket, &request, sizeof request, sent, AT_GIVEN + fd_count, err);
    (void)close(channel);
    (void)close(watch);
    return status;
}

/* Waits until the child was forked. */
static vor_status wait_started(struct vor_child *child, struct vor_error *err)
{
    struct started started = {0};
    struct vor_message message = {.bytes = &started, .capacity = sizeof started};

    if (vor_channel_receive(child->watch, &message, -1) != VOR_CHANNEL_MESSAGE ||
        message.size != sizeof started) {
        vor_message_close(&message);
        return vor_fail_errno(err, EPIPE,
                              "starting a process: the process that forks others has ended");
    }
    if (started.error != 0)
        return vor_fail_errno(err, started.error, "starting a process");
    child->pid = started.pid;
    return VOR_OK;
}

vor_status vor_zygote_spawn(struct vor_child *out, struct vor_zygote *zygote, unsigned kind,
                            const int *fds, unsigned fd_count, struct vor_error *err)
{
    struct vor_child child;
    int channel[2], watch[2];
    vor_status status = vor_channel_pair(channel, err);

    assert(fd_count <= VOR_CHILD_FDS);
    if (status != VOR_OK)
        return status;
    status = vor_channel_pair(watch, err);
    if (status != VOR_OK) {
        (void)close(channel[0]);
        (void)close(channel[1]);
        return status;
    }
    child = (struct vor_child){.channel = channel[0], .watch = watch[0]};
    status = ask(zygote, kind, fds, fd_count, channel[1], watch[1], err);
    VOR_THEN(status, wait_started(&child, err));
    if (status != VOR_OK) {
        vor_child_free(&child);
        return status;
    }
    *out = child;
    return VOR_OK;
}

int vor_child_wait(struct vor_child *child, struct vor_child_end *end, double seconds)
{
    struct vor_child_end told;
    struct vor_message message = {.bytes = &told, .capacity = sizeof told};

    switch (vor_channel_receive(child->watch, &message, seconds)) {
    case VOR_CHANNEL_LATE:
        return 0;
    case VOR_CHANNEL_MESSAGE:
        if (message.size == sizeof told) {
            *end = told;
            return 1;
        }
        break;
    default:
        break;
    }
    vor_message_close(&message);
    *end = (struct vor_child_end){.signal = SIGKILL};
    return 1;
}

void vor_child_kill(struct vor_child *child)
{
    (void)shutdown(child->watch, SHUT_WR);
}

enum vor_child_reaped vor_child_reap(struct vor_child *child, struct vor_child_end *end,
                                     double seconds)
{
    static const double gone_seconds = 10;

    *end = (struct vor_child_end){0};
    if (vor_child_wait(child, end, seconds))
        return VOR_CHILD_ENDED;
    vor_child_kill(child);
    return vor_child_wait(child, end, gone_seconds) ? VOR_CHILD_KILLED : VOR_CHILD_STUCK;
}

void vor_child_free(struct vor_child *child)
{
    (void)close(child->channel);
    (void)close(child->watch);
    child->channel = child->watch = -1;
}
