#define _GNU_SOURCE /* MSG_CMSG_CLOEXEC */
#include "server/proc/channel.h"

#include "server/base/clock.h"
#include "server/base/disk.h"

#include <assert.h>
#include <errno.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* Room for the descriptors of a message, aligned as their header must be. */
union control {
    struct cmsghdr align;
    char bytes[CMSG_SPACE(VOR_CHANNEL_FDS * sizeof(int))];
};

vor_status vor_channel_pair(int out[2], struct vor_error *err)
{
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, out) != 0)
        return vor_fail_errno(err, errno, "a channel between processes");
    return VOR_OK;
}

vor_status vor_channel_send(int channel, const void *bytes, size_t size, const int *fds,
                            unsigned fd_count, struct vor_error *err)
{
    const union {
        const void *ours;
        void *taken; /* an iovec has no const, whichever way its bytes go */
    } from = {.ours = bytes};
    struct iovec part = {.iov_base = from.taken, .iov_len = size};
    struct msghdr head = {.msg_iov = &part, .msg_iovlen = 1};
    union control control;
    ssize_t sent;

    assert(size >= 1 && size <= VOR_CHANNEL_BYTES && fd_count <= VOR_CHANNEL_FDS);
    if (fd_count > 0) {
        struct cmsghdr *at;

        memset(&control, 0, sizeof control);
        head.msg_control = control.bytes;
        head.msg_controllen = CMSG_SPACE(fd_count * sizeof *fds);
        at = CMSG_FIRSTHDR(&head);
        assert(at != NULL); /* there is room */
        at->cmsg_level = SOL_SOCKET;
        at->cmsg_type = SCM_RIGHTS;
        at->cmsg_len = CMSG_LEN(fd_count * sizeof *fds);
        memcpy(CMSG_DATA(at), fds, fd_count * sizeof *fds);
    }
    do
        sent = sendmsg(channel, &head, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    if (sent < 0)
        return vor_fail_errno(err, errno, "sending to another process");
    return VOR_OK;
}

/* Waits until there is something to receive; false once the time has passed. */
static int wait_readable(int channel, double seconds)
{
    double until = vor_clock_seconds() + seconds;
    struct pollfd wait = {.fd = channel, .events = POLLIN};

    for (;;) {
        double left = until - vor_clock_seconds();
        int ms = seconds < 0 ? -1 : left <= 0 ? 0 : left > 1e6 ? 1000000000 : (int)(left * 1e3) + 1;
        int count = poll(&wait, 1, ms);

        if (count > 0)
            return 1;
        if (count < 0 && errno != EINTR)
            return 1; /* what is wrong shows when it is received */
        if (seconds >= 0 && vor_clock_seconds() >= until)
            return 0;
    }
}

enum vor_channel_event vor_channel_receive(int channel, struct vor_message *message, double seconds)
{
    struct iovec part = {.iov_base = message->bytes, .iov_len = message->capacity};
    union control control;
    struct msghdr head = {.msg_iov = &part,
                          .msg_iovlen = 1,
                          .msg_control = control.bytes,
                          .msg_controllen = sizeof control.bytes};
    ssize_t got;

    message->size = 0;
    message->fd_count = 0;
    if (!wait_readable(channel, seconds))
        return VOR_CHANNEL_LATE;
    /* A side that closes with messages unread resets the channel, which is told once, before what
     * it has sent. */
    do
        got = recvmsg(channel, &head, MSG_CMSG_CLOEXEC);
    while (got < 0 && (errno == EINTR || errno == ECONNRESET));
    if (got < 0)
        return VOR_CHANNEL_GONE;
    for (struct cmsghdr *at = CMSG_FIRSTHDR(&head); at != NULL; at = CMSG_NXTHDR(&head, at)) {
        size_t count;

        if (at->cmsg_level != SOL_SOCKET || at->cmsg_type != SCM_RIGHTS)
            continue;
        count = (at->cmsg_len - CMSG_LEN(0)) / sizeof message->fds[0];
        assert(message->fd_count + count <= VOR_CHANNEL_FDS); /* there was room for no more */
        memcpy(&message->fds[message->fd_count], CMSG_DATA(at), count * sizeof message->fds[0]);
        message->fd_count += (unsigned)count;
    }
    if (got == 0 || (head.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0)
        vor_message_close(message);
    if (got == 0 || (head.msg_flags & MSG_TRUNC) != 0)
        return VOR_CHANNEL_GONE;
    message->size = (size_t)got;
    return VOR_CHANNEL_MESSAGE;
}

void vor_message_close(struct vor_message *message)
{
    while (message->fd_count > 0)
        (void)close(message->fds[--message->fd_count]);
}
