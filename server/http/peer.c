/* Deadlines and departures. libmicrohttpd's own time-out starts again with every byte, and it does
 * not look at a suspended connection at all; so every connection is listed here and one thread
 * walks the list: it cuts what is late and wakes a waiting request whose peer has left. */
#define _GNU_SOURCE /* POLLRDHUP */
#include "server/http/peer.h"

#include "server/base/clock.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

enum { LINGER_MAX = 64, PEER_TIMEOUT_MS = 20000 };
static const double linger_seconds = 5, look_seconds = 0.5;
static const int tick_ms = 100;

/* Every member is guarded by the watchman's lock. */
struct vor_peer {
    struct vor_peer *next, *previous;
    uint64_t serial;
    int fd;
    enum vor_phase phase;
    double since;            /* the phase began */
    double last;             /* last piece of the body */
    double look_at;          /* when to look next whether it has left */
    uint64_t bytes;          /* of this body */
    bool waiting;            /* its request is suspended: watch for the peer leaving */
    bool cut;                /* shut down by the sweeper */
    bool linger;             /* read on after the close, so that the reply is not reset away */
    double wake_at;          /* 0: no timer */
    struct vor_waker *waker; /* of the request under way, or NULL */
    char *late;              /* raw 408 to send when the body is late, or NULL */
    bool told_late;          /* and it was */
};

struct lingering {
    int fd;
    double until;
};

/* A waker to call once the lock is released. */
struct call {
    struct vor_waker *waker;
    bool gone;
};

struct vor_watchman {
    pthread_mutex_t lock;
    pthread_t thread;
    struct vor_deadlines deadlines;
    struct vor_peer *peers;
    unsigned count;
    uint64_t serial;
    struct lingering lingering[LINGER_MAX];
    unsigned lingering_count;
    int poke; /* eventfd: look again */
    bool stop, quiesced;
    struct pollfd *polls; /* only the sweeper's: poke, lingering, then waiting peers */
    uint64_t *serials;    /* of the waiting peers */
    struct call *calls;
    size_t capacity, poll_count, watched, call_count;
};

static void poke(const struct vor_watchman *watchman)
{
    uint64_t one = 1;

    /* A write to a full counter fails, but then a poke is pending already. */
    if (write(watchman->poke, &one, sizeof one) < 0)
        return;
}

/* Makes room to poll and to call every peer. When memory is out, the newest peers are not watched.
 */
static void grow(struct vor_watchman *watchman)
{
    size_t want = watchman->count + LINGER_MAX + 1;
    struct pollfd *polls;
    uint64_t *serials;
    struct call *calls;

    if (want <= watchman->capacity)
        return;
    want *= 2;
    polls = realloc(watchman->polls, want * sizeof *polls);
    if (polls != NULL)
        watchman->polls = polls;
    serials = realloc(watchman->serials, want * sizeof *serials);
    if (serials != NULL)
        watchman->serials = serials;
    calls = realloc(watchman->calls, want * sizeof *calls);
    if (calls != NULL)
        watchman->calls = calls;
    if (polls != NULL && serials != NULL && calls != NULL)
        watchman->capacity = want;
}

static void collect(struct vor_watchman *watchman)
{
    size_t n = 0;

    grow(watchman);
    watchman->polls[n++] = (struct pollfd){watchman->poke, POLLIN, 0};
    for (unsigned i = 0; i < watchman->lingering_count; i++)
        watchman->polls[n++] = (struct pollfd){watchman->lingering[i].fd, POLLIN, 0};
    watchman->watched = 0;
    for (struct vor_peer *peer = watchman->peers; peer != NULL; peer = peer->next) {
        if (!peer->waiting || n == watchman->capacity)
            continue;
        watchman->serials[watchman->watched++] = peer->serial;
        watchman->polls[n++] = (struct pollfd){peer->fd, POLLRDHUP, 0};
    }
    watchman->poll_count = n;
}

static void call_later(struct vor_watchman *watchman, struct vor_peer *peer, bool gone)
{
    if (peer->waker == NULL || watchman->call_count == watchman->capacity)
        return;
    watchman->calls[watchman->call_count++] = (struct call){vor_waker_hold(peer->waker), gone};
}

static struct vor_peer *find_serial(struct vor_watchman *watchman, uint64_t serial)
{
    struct vor_peer *peer = watchman->peers;

    while (peer != NULL && peer->serial != serial)
        peer = peer->next;
    return peer;
}

/* A descriptor may have been closed and reused since it was collected; the serial number tells. */
static void note_departures(struct vor_watchman *watchman)
{
    size_t first = watchman->poll_count - watchman->watched;

    for (size_t i = 0; i < watchman->watched; i++) {
        struct vor_peer *peer;

        if ((watchman->polls[first + i].revents & (POLLRDHUP | POLLERR | POLLHUP)) == 0)
            continue;
        peer = find_serial(watchman, watchman->serials[i]);
        if (peer == NULL || !peer->waiting)
            continue;
        peer->waiting = false;
        call_later(watchman, peer, true);
    }
}

/* Reads what a refused client still sends. Closing a socket with unread bytes resets the
 * connection, and the client may lose the reply. */
static void drain_lingering(struct vor_watchman *watchman, double now)
{
    static const size_t pieces_max = 64;
    unsigned kept = 0;
    char bytes[16384];

    for (unsigned i = 0; i < watchman->lingering_count; i++) {
        struct lingering *at = &watchman->lingering[i];
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

static bool is_late(const struct vor_watchman *watchman, const struct vor_peer *peer, double now)
{
    const struct vor_deadlines *limit = &watchman->deadlines;
    double age = now - peer->since;

    switch (peer->phase) {
    case VOR_PHASE_HEAD:
        return age > limit->header_seconds;
    case VOR_PHASE_IDLE:
        return watchman->quiesced || age > limit->keep_seconds;
    case VOR_PHASE_BODY:
        return age > limit->body_seconds || now - peer->last > limit->body_idle_seconds ||
               (age > limit->body_idle_seconds && (double)peer->bytes < limit->body_rate * age);
    case VOR_PHASE_SERVE:
        break;
    }
    return false;
}

/* The library uses edge-triggered events and misses a close that arrives together with the last
 * bytes. Nothing is cut while the library may still work on those bytes. */
static bool has_left(struct vor_peer *peer, double now)
{
    char byte;

    if (peer->phase == VOR_PHASE_SERVE || now < peer->look_at)
        return false;
    peer->look_at = now + look_seconds;
    return now - peer->since > look_seconds && now - peer->last > look_seconds &&
           recv(peer->fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

static void cut(struct vor_peer *peer, bool is_late)
{
    if (peer->phase == VOR_PHASE_BODY && peer->late != NULL) {
        peer->told_late = is_late;
        (void)send(peer->fd, peer->late, strlen(peer->late), MSG_DONTWAIT | MSG_NOSIGNAL);
        peer->linger = true;
        (void)shutdown(peer->fd, SHUT_RD);
    } else {
        (void)shutdown(peer->fd, SHUT_RDWR);
    }
    peer->cut = true;
}

static void check_clocks(struct vor_watchman *watchman, double now)
{
    for (struct vor_peer *peer = watchman->peers; peer != NULL; peer = peer->next) {
        bool late = !peer->cut && is_late(watchman, peer, now);

        if (late || (!peer->cut && has_left(peer, now)))
            cut(peer, late);
        if (peer->wake_at > 0 && now >= peer->wake_at) {
            peer->wake_at = 0;
            call_later(watchman, peer, false);
        }
    }
}

static void make_calls(struct vor_watchman *watchman)
{
    for (size_t i = 0; i < watchman->call_count; i++) {
        if (watchman->calls[i].gone)
            vor_waker_gone(watchman->calls[i].waker);
        vor_waker_wake(watchman->calls[i].waker);
        vor_waker_drop(watchman->calls[i].waker);
    }
    watchman->call_count = 0;
}

static void *sweep(void *arg)
{
    struct vor_watchman *watchman = arg;
    bool stop = false;

    while (!stop) {
        uint64_t pokes;
        int timeout;

        (void)pthread_mutex_lock(&watchman->lock);
        collect(watchman);
        timeout = watchman->count + watchman->lingering_count > 0 ? tick_ms : -1;
        (void)pthread_mutex_unlock(&watchman->lock);
        (void)poll(watchman->polls, (nfds_t)watchman->poll_count, timeout);
        if (watchman->polls[0].revents != 0 && read(watchman->poke, &pokes, sizeof pokes) < 0)
            pokes = 0;
        (void)pthread_mutex_lock(&watchman->lock);
        note_departures(watchman);
        drain_lingering(watchman, vor_clock_seconds());
        check_clocks(watchman, vor_clock_seconds());
        stop = watchman->stop;
        (void)pthread_mutex_unlock(&watchman->lock);
        make_calls(watchman);
    }
    return NULL;
}

vor_status vor_watchman_start(struct vor_watchman **out, const struct vor_deadlines *deadlines,
                              struct vor_error *err)
{
    struct vor_watchman *watchman = calloc(1, sizeof *watchman);

    if (watchman == NULL)
        return vor_fail(err, VOR_E_NOMEM, "no memory to watch connections");
    watchman->deadlines = *deadlines;
    watchman->poke = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    (void)pthread_mutex_init(&watchman->lock, NULL);
    grow(watchman);
    if (watchman->poke < 0 || watchman->capacity == 0 ||
        pthread_create(&watchman->thread, NULL, sweep, watchman) != 0) {
        if (watchman->poke >= 0)
            (void)close(watchman->poke);
        free(watchman->polls);
        free(watchman->serials);
        free(watchman->calls);
        free(watchman);
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
    poke(watchman);
    (void)pthread_join(watchman->thread, NULL);
    for (unsigned i = 0; i < watchman->lingering_count; i++)
        (void)close(watchman->lingering[i].fd);
    (void)close(watchman->poke);
    (void)pthread_mutex_destroy(&watchman->lock);
    free(watchman->polls);
    free(watchman->serials);
    free(watchman->calls);
    free(watchman);
}

struct vor_peer *vor_peer_enter(struct vor_watchman *watchman, int fd)
{
    struct vor_peer *peer = calloc(1, sizeof *peer);
    unsigned timeout_ms = PEER_TIMEOUT_MS;

    /* A peer that has vanished without a word is given up once bytes stay unanswered so long. */
    (void)setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &timeout_ms, sizeof timeout_ms);
    if (peer == NULL)
        return NULL;
    peer->fd = fd;
    peer->since = vor_clock_seconds();
    (void)pthread_mutex_lock(&watchman->lock);
    peer->serial = ++watchman->serial;
    peer->next = watchman->peers;
    if (peer->next != NULL)
        peer->next->previous = peer;
    watchman->peers = peer;
    if (watchman->count++ == 0)
        poke(watchman);
    (void)pthread_mutex_unlock(&watchman->lock);
    return peer;
}

void vor_peer_leave(struct vor_watchman *watchman, struct vor_peer *peer)
{
    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    if (peer->previous != NULL)
        peer->previous->next = peer->next;
    else
        watchman->peers = peer->next;
    if (peer->next != NULL)
        peer->next->previous = peer->previous;
    watchman->count--;
    if (peer->linger && watchman->lingering_count < LINGER_MAX) {
        int fd = fcntl(peer->fd, F_DUPFD_CLOEXEC, 0);

        if (fd >= 0)
            watchman->lingering[watchman->lingering_count++] =
                (struct lingering){fd, vor_clock_seconds() + linger_seconds};
        poke(watchman);
    }
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_waker_drop(peer->waker);
    free(peer->late);
    free(peer);
}

void vor_peer_phase(struct vor_watchman *watchman, struct vor_peer *peer, enum vor_phase phase)
{
    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    if (peer->phase != phase) {
        peer->phase = phase;
        peer->since = peer->last = vor_clock_seconds();
        peer->bytes = 0;
    }
    (void)pthread_mutex_unlock(&watchman->lock);
}

void vor_peer_received(struct vor_watchman *watchman, struct vor_peer *peer, size_t bytes)
{
    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    peer->bytes += bytes;
    peer->last = vor_clock_seconds();
    (void)pthread_mutex_unlock(&watchman->lock);
}

void vor_peer_wait(struct vor_watchman *watchman, struct vor_peer *peer, bool waiting)
{
    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    peer->waiting = waiting;
    (void)pthread_mutex_unlock(&watchman->lock);
}

void vor_peer_request(struct vor_watchman *watchman, struct vor_peer *peer, struct vor_waker *waker)
{
    struct vor_waker *before;

    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    before = peer->waker;
    peer->waker = waker != NULL ? vor_waker_hold(waker) : NULL;
    peer->waiting = false;
    peer->wake_at = 0;
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_waker_drop(before);
}

void vor_peer_timer(struct vor_watchman *watchman, struct vor_peer *peer, double seconds)
{
    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    peer->wake_at = vor_clock_seconds() + seconds;
    (void)pthread_mutex_unlock(&watchman->lock);
}

void vor_peer_late(struct vor_watchman *watchman, struct vor_peer *peer, char *late)
{
    if (peer == NULL) {
        free(late);
        return;
    }
    (void)pthread_mutex_lock(&watchman->lock);
    free(peer->late);
    peer->late = late;
    (void)pthread_mutex_unlock(&watchman->lock);
}

bool vor_peer_end(struct vor_watchman *watchman, struct vor_peer *peer)
{
    bool told;

    if (peer == NULL)
        return false;
    (void)pthread_mutex_lock(&watchman->lock);
    told = peer->told_late;
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_peer_request(watchman, peer, NULL);
    vor_peer_late(watchman, peer, NULL);
    vor_peer_phase(watchman, peer, VOR_PHASE_IDLE);
    return told;
}

void vor_peer_linger(struct vor_watchman *watchman, struct vor_peer *peer)
{
    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    peer->linger = true;
    (void)pthread_mutex_unlock(&watchman->lock);
}

void vor_watchman_quiesce(struct vor_watchman *watchman)
{
    (void)pthread_mutex_lock(&watchman->lock);
    watchman->quiesced = true;
    (void)pthread_mutex_unlock(&watchman->lock);
    poke(watchman);
}

unsigned vor_watchman_count(struct vor_watchman *watchman)
{
    unsigned count;

    (void)pthread_mutex_lock(&watchman->lock);
    count = watchman->count;
    (void)pthread_mutex_unlock(&watchman->lock);
    return count;
}

void vor_watchman_wake_all(struct vor_watchman *watchman)
{
    struct vor_waker **wakers;
    size_t n = 0;

    (void)pthread_mutex_lock(&watchman->lock);
    wakers = calloc(watchman->count + 1, sizeof(struct vor_waker *));
    for (struct vor_peer *peer = watchman->peers; peer != NULL && wakers != NULL; peer = peer->next)
        if (peer->waker != NULL)
            wakers[n++] = vor_waker_hold(peer->waker);
    (void)pthread_mutex_unlock(&watchman->lock);
    for (size_t i = 0; i < n; i++) {
        vor_waker_wake(wakers[i]);
        vor_waker_drop(wakers[i]);
    }
    free(wakers);
}
