/* One thread closes what is late, wakes waiting requests whose client has left, and those whose
 * timer is over. */
#define _GNU_SOURCE /* EPOLLRDHUP, struct tcp_info, TCP_USER_TIMEOUT, TCP_QUICKACK */
#include "server/http/conn_guard.h"

#include "server/base/clock.h"
#include "server/base/machine.h"
#include "server/http/conn_table.h"
#include "server/http/state.h"

#include <errno.h>
#include <fcntl.h>
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

enum { TICK_MS = 100, DEPARTURES = 64, TIMEOUT_MS = 20000, BEAT_TIMEOUT_MS = 1000 /* at least */ };
static const double look_seconds = 0.5;

static void lock(struct vor_conn_guard *guard)
{
    (void)pthread_mutex_lock(&guard->lock);
}

static void unlock(struct vor_conn_guard *guard)
{
    (void)pthread_mutex_unlock(&guard->lock);
}

/* --- what is told of a connection ------------------------------------------------------------- */

/* A client that has vanished without a word is given up once bytes stay unanswered so long. */
static void set_timeout(int fd, double timeout_ms)
{
    unsigned most = timeout_ms > TIMEOUT_MS        ? TIMEOUT_MS
                    : timeout_ms > BEAT_TIMEOUT_MS ? (unsigned)timeout_ms
                                                   : BEAT_TIMEOUT_MS;

    (void)setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &most, sizeof most);
}

struct vor_conn *vor_conn_enter(struct vor_conn_guard *guard, int fd,
                                const struct vor_address *from)
{
    struct vor_conn *conn = calloc(1, sizeof *conn);
    struct epoll_event departure = {.events = EPOLLRDHUP | EPOLLET, .data.ptr = conn};

    set_timeout(fd, TIMEOUT_MS);
    if (conn == NULL)
        return NULL;
    conn->guard = guard;
    conn->fd = fd;
    conn->queue = -1;
    conn->since = vor_clock_seconds();
    lock(guard);
    (void)epoll_ctl(guard->departures, EPOLL_CTL_ADD, fd, &departure);
    vor_conn_move(conn, VOR_PHASE_HEAD);
    vor_conn_count(conn, from);
    vor_conns_make_room(conn);
    if (!guard->is_awake)
        vor_conn_poke(guard);
    unlock(guard);
    return conn;
}

void vor_conn_leave(struct vor_conn *conn)
{
    int rest;

    if (conn == NULL)
        return;
    lock(conn->guard);
    vor_conn_move(conn, -1);
    vor_conn_not_due(conn);
    vor_conn_uncount(conn);
    (void)epoll_ctl(conn->guard->departures, EPOLL_CTL_DEL, conn->fd, NULL);
    rest = conn->lingers ? fcntl(conn->fd, F_DUPFD_CLOEXEC, 0) : -1;
    if (rest >= 0)
        vor_conn_read_on(conn->guard, rest);
    unlock(conn->guard);
    vor_waker_drop(conn->waker);
    free(conn->late);
    free(conn);
}

enum vor_conn_excess vor_conn_excess(struct vor_conn_guard *guard, const struct vor_conn *conn)
{
    const struct vor_conn_limits *limits = &guard->limits;
    enum vor_conn_excess excess = VOR_EXCESS_NONE;

    lock(guard);
    if (vor_conns_busy(guard) > limits->connections)
        excess = VOR_EXCESS_ALL;
    else if (conn->caller != NULL && conn->caller->count > limits->each)
        excess = VOR_EXCESS_ADDRESS;
    unlock(guard);
    return excess;
}

void vor_conn_phase(struct vor_conn *conn, enum vor_phase phase)
{
    const int on = 1;

    lock(conn->guard);
    if (conn->phase != phase) {
        conn->phase = phase;
        conn->since = conn->last = vor_clock_seconds();
        conn->bytes = 0;
        conn->sampled_at = 0;
        if (conn->queue != VOR_QUEUE_CLOSED)
            vor_conn_move(conn, (int)phase);
        /* A stream's client is missed at the next sign of life, and given up before the one after
         * it. */
        if (phase == VOR_PHASE_STREAM)
            set_timeout(conn->fd, conn->guard->limits.beat_seconds * 800);
        /* Many clients send head and body in two pieces, and by Nagle's algorithm the second only
         * once the first is acknowledged, which a kernel puts off by 40 ms where it expects an
         * answer to carry it. */
        if (phase == VOR_PHASE_BODY)
            (void)setsockopt(conn->fd, IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
    }
    unlock(conn->guard);
}

void vor_conn_watch(struct vor_conn *conn, bool is_chunked)
{
    struct epoll_event events = {.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET,
                                 .data.ptr = conn};

    lock(conn->guard);
    conn->skips = is_chunked ? 2 : 0;
    unlock(conn->guard);
    (void)epoll_ctl(conn->guard->departures, EPOLL_CTL_MOD, conn->fd, &events);
}

bool vor_conn_news(struct vor_conn *conn)
{
    bool news;

    lock(conn->guard);
    news = conn->has_news;
    conn->has_news = false;
    unlock(conn->guard);
    return news;
}

void vor_conn_received(struct vor_conn *conn, size_t bytes)
{
    lock(conn->guard);
    conn->bytes += bytes;
    conn->last = vor_clock_seconds();
    unlock(conn->guard);
}

void vor_conn_wait(struct vor_conn *conn, bool waiting)
{
    lock(conn->guard);
    conn->is_waiting = waiting && !conn->has_left;
    if (waiting && conn->has_left && conn->waker != NULL)
        vor_waker_gone(conn->waker);
    unlock(conn->guard);
}

void vor_conn_request(struct vor_conn *conn, struct vor_waker *waker)
{
    struct vor_waker *before;

    lock(conn->guard);
    before = conn->waker;
    conn->waker = waker != NULL ? vor_waker_hold(waker) : NULL;
    conn->is_waiting = false;
    conn->wake_at = 0;
    vor_conn_not_due(conn);
    unlock(conn->guard);
    vor_waker_drop(before);
}

void vor_conn_wake_after(struct vor_conn *conn, double seconds)
{
    double at = vor_clock_seconds() + seconds;

    lock(conn->guard);
    if (conn->wake_at == 0 || at < conn->wake_at)
        conn->wake_at = at;
    unlock(conn->guard);
}

void vor_conn_late(struct vor_conn *conn, char *late)
{
    char *before;

    lock(conn->guard);
    before = conn->late;
    conn->late = late;
    unlock(conn->guard);
    free(before);
}

void vor_conn_linger(struct vor_conn *conn)
{
    lock(conn->guard);
    conn->lingers = true;
    unlock(conn->guard);
}

bool vor_conn_end(struct vor_conn *conn)
{
    bool told;

    lock(conn->guard);
    told = conn->told_late;
    unlock(conn->guard);
    vor_conn_request(conn, NULL);
    vor_conn_late(conn, NULL);
    vor_conn_phase(conn, VOR_PHASE_IDLE);
    return told;
}

/* --- who has left ----------------------------------------------------------------------------- */

/* A connection leaves the epoll under the lock before it is freed, so none of these is gone. */
static void note_departures(struct vor_conn_guard *guard)
{
    struct epoll_event events[DEPARTURES];
    int n;

    do {
        n = epoll_wait(guard->departures, events, DEPARTURES, 0);
        for (int i = 0; i < n; i++) {
            struct vor_conn *conn = events[i].data.ptr;
            bool leaves = (events[i].events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0;

            conn->has_left |= leaves;
            conn->has_news |= (events[i].events & EPOLLIN) != 0 && vor_conn_has_unread(conn);
            if (conn->waker == NULL || (leaves && !conn->is_waiting))
                continue;
            if (leaves) {
                conn->is_waiting = false;
                vor_waker_gone(conn->waker);
            }
            vor_conn_set_due(conn);
        }
    } while (n == DEPARTURES);
}

/* Reads what a refused client still sends. Closing a socket with unread bytes resets the
 * connection, and the client may lose the reply. */
static void drain_lingering(struct vor_conn_guard *guard, double now)
{
    static const size_t pieces_max = 64;
    unsigned kept = 0;
    char bytes[16384];

    for (unsigned i = 0; i < guard->lingering_count; i++) {
        int fd = guard->lingering[i].fd;
        ssize_t got = 1;

        for (size_t k = 0; k < pieces_max && got > 0; k++)
            got = recv(fd, bytes, sizeof bytes, MSG_DONTWAIT);
        if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR) ||
            now > guard->lingering[i].until)
            (void)close(fd);
        else
            guard->lingering[kept++] = guard->lingering[i];
    }
    guard->lingering_count = kept;
}

/* --- who is late ------------------------------------------------------------------------------ */

/* A reply is late when its reader has taken less than the rate since it was first looked at. What
 * lies in the socket's buffers does not count: only what the conn acknowledged. */
static bool reads_slowly(struct vor_conn *conn, double now)
{
    const struct vor_conn_limits *limits = &conn->guard->limits;
    double age = now - conn->sampled_at;
    struct tcp_info info;
    socklen_t size = sizeof info;

    if (now < conn->look_at)
        return false;
    conn->look_at = now + look_seconds;
    if (conn->sampled_at > 0 && age <= limits->body_idle_seconds)
        return false;
    memset(&info, 0, sizeof info);
    if (getsockopt(conn->fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 ||
        size < offsetof(struct tcp_info, tcpi_bytes_acked) + sizeof info.tcpi_bytes_acked)
        return false; /* no TCP, or a kernel before 4.1 */
    if (conn->sampled_at > 0)
        return (double)(info.tcpi_bytes_acked - conn->bytes) < limits->reply_rate * age;
    conn->sampled_at = now;
    conn->bytes = info.tcpi_bytes_acked;
    return false;
}

static bool is_late(struct vor_conn *conn, double now)
{
    const struct vor_conn_limits *limit = &conn->guard->limits;
    double age = now - conn->since;

    switch (conn->phase) {
    case VOR_PHASE_HEAD:
        return age > limit->header_seconds;
    case VOR_PHASE_IDLE:
        return age > limit->keep_seconds;
    case VOR_PHASE_BODY:
        return age > limit->body_seconds || now - conn->last > limit->body_idle_seconds ||
               (age > limit->body_idle_seconds && (double)conn->bytes < limit->body_rate * age);
    case VOR_PHASE_SEND:
        return reads_slowly(conn, now);
    case VOR_PHASE_SERVE:
    case VOR_PHASE_STREAM:
    case VOR_PHASE_COUNT:
        break;
    }
    return false;
}

/* The library uses edge-triggered events and misses a close that arrives together with the last
 * bytes. Nothing is cut while the library may still work on those bytes. */
static bool has_left(struct vor_conn *conn, double now)
{
    bool receives = conn->phase == VOR_PHASE_HEAD || conn->phase == VOR_PHASE_BODY ||
                    conn->phase == VOR_PHASE_IDLE;
    char byte;

    if (!conn->has_left || !receives || now < conn->look_at)
        return false;
    conn->look_at = now + look_seconds;
    return now - conn->since > look_seconds && now - conn->last > look_seconds &&
           recv(conn->fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

/* Looks at every connection; one that is closed changes its queue. */
static void check_all(struct vor_conn_guard *guard, double now)
{
    struct vor_conn *conn, *next;

    for (int i = 0; i < VOR_QUEUES; i++)
        for (conn = TAILQ_FIRST(&guard->queues[i].list); conn != NULL; conn = next) {
            bool is_open = conn->queue != VOR_QUEUE_CLOSED;
            bool late = is_open && is_late(conn, now);

            next = TAILQ_NEXT(conn, queued);
            /* A client that keeps sending can hide the end of reading from the library, which finds
             * bytes each time it looks. From now on such bytes are answered with a reset. */
            if (!is_open && now >= conn->look_at)
                (void)shutdown(conn->fd, SHUT_RDWR);
            if (conn->wake_at > 0 && now >= conn->wake_at) {
                conn->wake_at = 0;
                vor_conn_set_due(conn);
            }
            if (late || (is_open && has_left(conn, now)))
                vor_conn_close(conn, late);
        }
}

/* --- the thread ------------------------------------------------------------------------------- */

/* Sleeps until something happens or it is time to look. */
static void pause_guard(struct vor_conn_guard *guard)
{
    struct pollfd polls[2 + VOR_LINGERING_MAX];
    nfds_t n = 0;
    uint64_t pokes;
    int timeout;

    lock(guard);
    polls[n++] = (struct pollfd){guard->poke, POLLIN, 0};
    polls[n++] = (struct pollfd){guard->departures, POLLIN, 0};
    for (unsigned i = 0; i < guard->lingering_count; i++)
        polls[n++] = (struct pollfd){guard->lingering[i].fd, POLLIN, 0};
    guard->is_awake = guard->lingering_count > 0;
    for (int i = 0; i < VOR_QUEUES; i++)
        guard->is_awake |= guard->queues[i].count > 0;
    timeout = !TAILQ_EMPTY(&guard->due) ? WAKE_PAUSE_MS : guard->is_awake ? TICK_MS : -1;
    unlock(guard);
    (void)poll(polls, n, timeout);
    if (polls[0].revents != 0 && read(guard->poke, &pokes, sizeof pokes) < 0)
        return;
}

static void *run(void *arg)
{
    static const double pause = WAKE_PAUSE_MS / 1e3, tick = TICK_MS / 1e3;
    struct vor_conn_guard *guard = arg;
    double check_at = 0, wake_at = 0;
    struct vor_conn *due;
    bool stop = false;

    while (!stop) {
        struct vor_waker *wakers[WAKES];
        size_t n = 0;
        double now;

        pause_guard(guard);
        now = vor_clock_seconds();
        lock(guard);
        note_departures(guard);
        drain_lingering(guard, now);
        if (now >= check_at) {
            check_all(guard, now);
            check_at = now + tick * 0.9;
        }
        if (now >= wake_at) {
            while (n < WAKES && (due = TAILQ_FIRST(&guard->due)) != NULL) {
                wakers[n++] = vor_waker_hold(due->waker);
                vor_conn_not_due(due);
            }
            wake_at = now + pause;
        }
        stop = guard->stop;
        unlock(guard);
        for (size_t i = 0; i < n; i++) { /* without the lock */
            vor_waker_wake(wakers[i]);
            vor_waker_drop(wakers[i]);
        }
    }
    return NULL;
}

static void release(struct vor_conn_guard *guard)
{
    for (unsigned i = 0; i < guard->lingering_count; i++)
        (void)close(guard->lingering[i].fd);
    if (guard->poke >= 0)
        (void)close(guard->poke);
    if (guard->departures >= 0)
        (void)close(guard->departures);
    (void)pthread_mutex_destroy(&guard->lock);
    free(guard);
}

vor_status vor_conn_guard_start(struct vor_conn_guard **out, const struct vor_conn_limits *limits,
                                struct vor_error *err)
{
    struct vor_conn_guard *guard = calloc(1, sizeof *guard);

    if (guard == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the HTTP threads");
    guard->limits = *limits;
    TAILQ_INIT(&guard->due);
    for (int i = 0; i < VOR_QUEUES; i++)
        TAILQ_INIT(&guard->queues[i].list);
    if (getrandom(&guard->salt, sizeof guard->salt, GRND_NONBLOCK) < 0)
        guard->salt = (uint64_t)(uintptr_t)guard;
    guard->poke = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    guard->departures = epoll_create1(EPOLL_CLOEXEC);
    (void)pthread_mutex_init(&guard->lock, NULL);
    if (guard->poke < 0 || guard->departures < 0 ||
        vor_machine_thread(&guard->thread, "vor-connections", run, guard) != 0) {
        release(guard);
        return vor_fail(err, VOR_E_NOMEM,
                        "cannot start the thread that watches connections: too little memory, or a "
                        "limit on the number of processes");
    }
    *out = guard;
    return VOR_OK;
}

void vor_conn_guard_stop(struct vor_conn_guard *guard)
{
    if (guard == NULL)
        return;
    lock(guard);
    guard->stop = true;
    unlock(guard);
    vor_conn_poke(guard);
    (void)pthread_join(guard->thread, NULL);
    release(guard);
}

/* --- all of them ------------------------------------------------------------------------------ */

void vor_http_cut_slow(struct vor_http *http)
{
    static const enum vor_phase slow[] = {VOR_PHASE_HEAD, VOR_PHASE_BODY, VOR_PHASE_SEND,
                                          VOR_PHASE_IDLE};
    struct vor_conn_guard *guard = http->guard;
    struct vor_conn *conn;

    lock(guard);
    for (size_t i = 0; i < sizeof slow / sizeof slow[0]; i++)
        while ((conn = TAILQ_FIRST(&guard->queues[slow[i]].list)) != NULL)
            vor_conn_close(conn, true);
    unlock(guard);
}

unsigned vor_conn_guard_count(struct vor_conn_guard *guard)
{
    unsigned count;

    lock(guard);
    count = vor_conns_open(guard);
    unlock(guard);
    return count;
}

/* Besides requests under way, connections without one that have sent bytes which nobody has read.
 */
unsigned vor_http_busy(const struct vor_http *http)
{
    static const enum vor_phase silent[] = {VOR_PHASE_HEAD, VOR_PHASE_IDLE};
    struct vor_conn_guard *guard = http->guard;
    struct vor_conn *conn;
    unsigned count = atomic_load(&http->busy);

    lock(guard);
    for (size_t i = 0; i < sizeof silent / sizeof silent[0]; i++)
        TAILQ_FOREACH(conn, &guard->queues[silent[i]].list, queued)
    count += vor_conn_has_unread(conn);
    unlock(guard);
    return count;
}

void vor_http_wake_all(struct vor_http *http)
{
    struct vor_conn_guard *guard = http->guard;
    struct vor_waker **wakers;
    size_t n = 0, most = 0;
    struct vor_conn *conn;

    lock(guard);
    for (int i = 0; i < VOR_QUEUES; i++)
        most += guard->queues[i].count;
    wakers = calloc(most + 1, sizeof(struct vor_waker *));
    for (int i = 0; i < VOR_QUEUES && wakers != NULL; i++)
        TAILQ_FOREACH(conn, &guard->queues[i].list, queued)
    if (conn->waker != NULL)
        wakers[n++] = vor_waker_hold(conn->waker);
    unlock(guard);
    for (size_t i = 0; i < n; i++) {
        vor_waker_wake(wakers[i]);
        vor_waker_drop(wakers[i]);
    }
    free(wakers);
}
