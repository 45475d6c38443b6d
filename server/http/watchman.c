/* The thread that watches connections. libmicrohttpd's own time-out starts again with every byte,
 * and it does not look at a suspended connection at all; so every connection is listed here: one
 * thread cuts what is late, wakes a waiting request whose peer has left, and those whose timer is
 * over. */
#define _GNU_SOURCE /* EPOLLRDHUP, struct tcp_info */
#include "server/http/watchman.h"

#include "server/base/clock.h"
#include "server/base/machine.h"
#include "server/http/crowd.h"

#include <errno.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <poll.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

/* Wakes are paced: the library walks all suspended connections of a thread whenever it resumes some
 * (0.9.75), and serves what is woken before anybody else. 4,000 streams of one job, woken at once,
 * kept /livez waiting for 640 ms (p99); paced so for 8 ms, and 10,000 idle ones for 15 ms, on two
 * cores that were busy besides. Half the pause doubles what streams may take of a core, a third. */
enum { WAKES = 32, WAKE_PAUSE_MS = 5 };

enum { TICK_MS = 100, DEPARTURES = 64 };
static const double look_seconds = 0.5;

/* --- who is to be woken ----------------------------------------------------------------------- */

static size_t take_due(struct vor_watchman *watchman, struct vor_waker *wakers[WAKES])
{
    size_t n = 0;

    while (n < WAKES && watchman->due_first != NULL) {
        struct vor_peer *peer = watchman->due_first;

        wakers[n++] = vor_waker_hold(peer->waker);
        vor_crowd_not_due(watchman, peer);
    }
    return n;
}

/* Wakers are called without the lock. */
static void wake(struct vor_waker *wakers[WAKES], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        vor_waker_wake(wakers[i]);
        vor_waker_drop(wakers[i]);
    }
}

/* --- who has left ----------------------------------------------------------------------------- */

/* A peer leaves the epoll under the lock before it is freed, so none of these is gone. */
static void note_departures(struct vor_watchman *watchman)
{
    struct epoll_event events[DEPARTURES];
    int n;

    do {
        n = epoll_wait(watchman->departures, events, DEPARTURES, 0);
        for (int i = 0; i < n; i++) {
            struct vor_peer *peer = events[i].data.ptr;

            peer->left = true;
            if (!peer->waiting || peer->waker == NULL)
                continue;
            peer->waiting = false;
            vor_waker_gone(peer->waker);
            vor_crowd_due(watchman, peer);
        }
    } while (n == DEPARTURES);
}

/* Reads what a refused client still sends. Closing a socket with unread bytes resets the
 * connection, and the client may lose the reply. */
static void drain_lingering(struct vor_watchman *watchman, double now)
{
    static const size_t pieces_max = 64;
    unsigned kept = 0;
    char bytes[16384];

    for (unsigned i = 0; i < watchman->lingering_count; i++) {
        struct vor_lingering *at = &watchman->lingering[i];
        ssize_t got = 1;

        for (size_t k = 0; k < pieces_max && got > 0; k++)
            got = recv(at->fd, bytes, sizeof bytes, MSG_DONTWAIT);
        if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR) || now > at->until)
            (void)close(at->fd);
        else
            watchman->lingering[kept++] = *at;
    }
    watchman->lingering_count = kept;
}

/* --- who is late ------------------------------------------------------------------------------ */

/* A reply is late when its reader has taken less than the rate since it was first looked at. What
 * lies in the socket's buffers does not count: only what the peer acknowledged. */
static bool reads_slowly(const struct vor_watchman *watchman, struct vor_peer *peer, double now)
{
    const struct vor_watch_limits *limits = &watchman->limits;
    double age = now - peer->sampled_at;
    struct tcp_info info;
    socklen_t size = sizeof info;

    if (now < peer->look_at)
        return false;
    peer->look_at = now + look_seconds;
    if (peer->sampled_at > 0 && age <= limits->body_idle_seconds)
        return false;
    memset(&info, 0, sizeof info);
    if (getsockopt(peer->fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 ||
        size < offsetof(struct tcp_info, tcpi_bytes_acked) + sizeof info.tcpi_bytes_acked)
        return false; /* no TCP, or a kernel before 4.1 */
    if (peer->sampled_at > 0)
        return (double)(info.tcpi_bytes_acked - peer->bytes) < limits->reply_rate * age;
    peer->sampled_at = now;
    peer->bytes = info.tcpi_bytes_acked;
    return false;
}

static bool is_late(const struct vor_watchman *watchman, struct vor_peer *peer, double now)
{
    const struct vor_watch_limits *limit = &watchman->limits;
    double age = now - peer->since;

    switch (peer->phase) {
    case VOR_PHASE_HEAD:
        return age > limit->header_seconds;
    case VOR_PHASE_IDLE:
        return age > limit->keep_seconds;
    case VOR_PHASE_BODY:
        return age > limit->body_seconds || now - peer->last > limit->body_idle_seconds ||
               (age > limit->body_idle_seconds && (double)peer->bytes < limit->body_rate * age);
    case VOR_PHASE_SEND:
        return reads_slowly(watchman, peer, now);
    case VOR_PHASE_SERVE:
    case VOR_PHASE_STREAM:
    case VOR_PHASE_COUNT:
        break;
    }
    return false;
}

/* The library uses edge-triggered events and misses a close that arrives together with the last
 * bytes. Nothing is cut while the library may still work on those bytes. */
static bool has_left(struct vor_peer *peer, double now)
{
    bool receives = peer->phase == VOR_PHASE_HEAD || peer->phase == VOR_PHASE_BODY ||
                    peer->phase == VOR_PHASE_IDLE;
    char byte;

    if (!peer->left || !receives || now < peer->look_at)
        return false;
    peer->look_at = now + look_seconds;
    return now - peer->since > look_seconds && now - peer->last > look_seconds &&
           recv(peer->fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

static void check_row(struct vor_watchman *watchman, const struct vor_row *row, double now)
{
    struct vor_peer *next;

    for (struct vor_peer *peer = row->first; peer != NULL; peer = next) {
        bool late = peer->row != VOR_ROW_CUT && is_late(watchman, peer, now);

        next = peer->next; /* a cut one changes its row */
        /* A client that keeps sending can hide the end of reading from the library, which finds
         * bytes each time it looks. From now on such bytes are answered with a reset. */
        if (peer->row == VOR_ROW_CUT && now >= peer->look_at)
            (void)shutdown(peer->fd, SHUT_RDWR);
        if (peer->wake_at > 0 && now >= peer->wake_at) {
            peer->wake_at = 0;
            vor_crowd_due(watchman, peer);
        }
        if (late || (peer->row != VOR_ROW_CUT && has_left(peer, now)))
            vor_crowd_cut(watchman, peer, late);
    }
}

/* --- the thread ------------------------------------------------------------------------------- */

static bool anybody(const struct vor_watchman *watchman)
{
    for (int i = 0; i < VOR_ROWS; i++)
        if (watchman->rows[i].count > 0)
            return true;
    return watchman->lingering_count > 0;
}

/* Sleeps until something happens or it is time to look. */
static void pause_sweep(struct vor_watchman *watchman)
{
    struct pollfd polls[2 + VOR_LINGERING_MAX];
    nfds_t n = 0;
    uint64_t pokes;
    int timeout;

    (void)pthread_mutex_lock(&watchman->lock);
    polls[n++] = (struct pollfd){watchman->poke, POLLIN, 0};
    polls[n++] = (struct pollfd){watchman->departures, POLLIN, 0};
    for (unsigned i = 0; i < watchman->lingering_count; i++)
        polls[n++] = (struct pollfd){watchman->lingering[i].fd, POLLIN, 0};
    watchman->awake = anybody(watchman);
    timeout = watchman->due_first != NULL ? WAKE_PAUSE_MS : watchman->awake ? TICK_MS : -1;
    (void)pthread_mutex_unlock(&watchman->lock);
    (void)poll(polls, n, timeout);
    if (polls[0].revents != 0 && read(watchman->poke, &pokes, sizeof pokes) < 0)
        return;
}

static void *sweep(void *arg)
{
    static const double pause = WAKE_PAUSE_MS / 1e3, tick = TICK_MS / 1e3;
    struct vor_watchman *watchman = arg;
    double check_at = 0, wake_at = 0;
    bool stop = false;

    while (!stop) {
        struct vor_waker *wakers[WAKES];
        size_t n = 0;
        double now;

        pause_sweep(watchman);
        now = vor_clock_seconds();
        (void)pthread_mutex_lock(&watchman->lock);
        note_departures(watchman);
        drain_lingering(watchman, now);
        if (now >= check_at) {
            for (int i = 0; i < VOR_ROWS; i++)
                check_row(watchman, &watchman->rows[i], now);
            check_at = now + tick * 0.9;
        }
        if (now >= wake_at) {
            n = take_due(watchman, wakers);
            wake_at = now + pause;
        }
        stop = watchman->stop;
        (void)pthread_mutex_unlock(&watchman->lock);
        wake(wakers, n);
    }
    return NULL;
}

static void release(struct vor_watchman *watchman)
{
    for (unsigned i = 0; i < watchman->lingering_count; i++)
        (void)close(watchman->lingering[i].fd);
    if (watchman->poke >= 0)
        (void)close(watchman->poke);
    if (watchman->departures >= 0)
        (void)close(watchman->departures);
    (void)pthread_mutex_destroy(&watchman->lock);
    free(watchman);
}

vor_status vor_watchman_start(struct vor_watchman **out, const struct vor_watch_limits *limits,
                              struct vor_error *err)
{
    struct vor_watchman *watchman = calloc(1, sizeof *watchman);

    if (watchman == NULL)
        return vor_fail(err, VOR_E_NOMEM, "no memory to watch connections");
    watchman->limits = *limits;
    if (getrandom(&watchman->salt, sizeof watchman->salt, GRND_NONBLOCK) < 0)
        watchman->salt = (uint64_t)(uintptr_t)watchman;
    watchman->poke = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    watchman->departures = epoll_create1(EPOLL_CLOEXEC);
    (void)pthread_mutex_init(&watchman->lock, NULL);
    if (watchman->poke < 0 || watchman->departures < 0 ||
        vor_machine_thread(&watchman->thread, "vor-connections", sweep, watchman) != 0) {
        release(watchman);
        return vor_fail(err, VOR_E_NOMEM, "no thread to watch connections");
    }
    *out = watchman;
    return VOR_OK;
}

void vor_watchman_stop(struct vor_watchman *watchman)
{
    if (watchman == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    watchman->stop = true;
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_crowd_poke(watchman);
    (void)pthread_join(watchman->thread, NULL);
    release(watchman);
}

/* --- all of them ------------------------------------------------------------------------------ */

void vor_watchman_cut_slow(struct vor_watchman *watchman)
{
    static const enum vor_phase slow[] = {VOR_PHASE_HEAD, VOR_PHASE_BODY, VOR_PHASE_SEND,
                                          VOR_PHASE_IDLE};

    (void)pthread_mutex_lock(&watchman->lock);
    for (size_t i = 0; i < sizeof slow / sizeof slow[0]; i++)
        while (watchman->rows[slow[i]].first != NULL)
            vor_crowd_cut(watchman, watchman->rows[slow[i]].first, true);
    (void)pthread_mutex_unlock(&watchman->lock);
}

unsigned vor_watchman_count(struct vor_watchman *watchman)
{
    unsigned count;

    (void)pthread_mutex_lock(&watchman->lock);
    count = vor_crowd_size(watchman);
    (void)pthread_mutex_unlock(&watchman->lock);
    return count;
}

unsigned vor_watchman_unread(struct vor_watchman *watchman)
{
    static const enum vor_phase silent[] = {VOR_PHASE_HEAD, VOR_PHASE_IDLE};
    unsigned count = 0;

    (void)pthread_mutex_lock(&watchman->lock);
    for (size_t i = 0; i < sizeof silent / sizeof silent[0]; i++)
        for (struct vor_peer *peer = watchman->rows[silent[i]].first; peer != NULL;
             peer = peer->next)
            count += vor_peer_has_unread(peer);
    (void)pthread_mutex_unlock(&watchman->lock);
    return count;
}

void vor_watchman_wake_all(struct vor_watchman *watchman)
{
    struct vor_waker **wakers;
    size_t n = 0, most = 0;

    (void)pthread_mutex_lock(&watchman->lock);
    for (int i = 0; i < VOR_ROWS; i++)
        most += watchman->rows[i].count;
    wakers = calloc(most + 1, sizeof(struct vor_waker *));
    for (int i = 0; i < VOR_ROWS && wakers != NULL; i++)
        for (struct vor_peer *peer = watchman->rows[i].first; peer != NULL; peer = peer->next)
            if (peer->waker != NULL)
                wakers[n++] = vor_waker_hold(peer->waker);
    (void)pthread_mutex_unlock(&watchman->lock);
    for (size_t i = 0; i < n; i++) {
        vor_waker_wake(wakers[i]);
        vor_waker_drop(wakers[i]);
    }
    free(wakers);
}
