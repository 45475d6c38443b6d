/* What the exchange tells of a connection. */
#define _GNU_SOURCE /* TCP_USER_TIMEOUT, TCP_QUICKACK */
#include "server/http/peer.h"

#include "server/base/clock.h"
#include "server/http/crowd.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/socket.h>

enum { PEER_TIMEOUT_MS = 20000, BEAT_TIMEOUT_MS = 1000 /* at least */ };

/* A peer that has vanished without a word is given up once bytes stay unanswered so long. */
static void set_timeout(int fd, unsigned timeout_ms)
{
    (void)setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &timeout_ms, sizeof timeout_ms);
}

/* A stream's peer is missed at the next sign of life, and given up before the one after it. */
static unsigned stream_timeout(double beat_seconds)
{
    double most = beat_seconds * 800;

    if (most > PEER_TIMEOUT_MS)
        return PEER_TIMEOUT_MS;
    return most > BEAT_TIMEOUT_MS ? (unsigned)most : BEAT_TIMEOUT_MS;
}

/* Many clients send head and body in two pieces, and by Nagle's algorithm the second only once the
 * first is acknowledged, which a kernel puts off by 40 ms where it expects an answer to carry it.
 */
static void acknowledge_now(int fd)
{
    const int on = 1;

    (void)setsockopt(fd, IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
}

struct vor_peer *vor_peer_enter(struct vor_watchman *watchman, int fd,
                                const struct vor_address *from)
{
    struct vor_peer *peer = calloc(1, sizeof *peer);
    struct epoll_event departure = {.events = EPOLLRDHUP | EPOLLET, .data.ptr = peer};

    set_timeout(fd, PEER_TIMEOUT_MS);
    if (peer == NULL)
        return NULL;
    peer->fd = fd;
    peer->row = -1;
    peer->since = vor_clock_seconds();
    (void)pthread_mutex_lock(&watchman->lock);
    (void)epoll_ctl(watchman->departures, EPOLL_CTL_ADD, fd, &departure);
    vor_row_move(watchman, peer, VOR_PHASE_HEAD);
    vor_crowd_count(watchman, peer, from);
    vor_crowd_make_room(watchman, peer);
    if (!watchman->awake)
        vor_crowd_poke(watchman);
    (void)pthread_mutex_unlock(&watchman->lock);
    return peer;
}

void vor_peer_leave(struct vor_watchman *watchman, struct vor_peer *peer)
{
    int rest;

    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    vor_row_take(watchman, peer);
    vor_crowd_not_due(watchman, peer);
    vor_crowd_uncount(watchman, peer);
    (void)epoll_ctl(watchman->departures, EPOLL_CTL_DEL, peer->fd, NULL);
    rest = peer->linger ? fcntl(peer->fd, F_DUPFD_CLOEXEC, 0) : -1;
    if (rest >= 0)
        vor_crowd_linger(watchman, rest);
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_waker_drop(peer->waker);
    free(peer->late);
    free(peer);
}

enum vor_crowd vor_peer_crowd(struct vor_watchman *watchman, const struct vor_peer *peer)
{
    const struct vor_watch_limits *limits = &watchman->limits;
    enum vor_crowd crowd = VOR_CROWD_NONE;

    (void)pthread_mutex_lock(&watchman->lock);
    if (vor_crowd_busy(watchman) > limits->connections)
        crowd = VOR_CROWD_ALL;
    else if (peer != NULL && peer->caller != NULL && peer->caller->count > limits->each)
        crowd = VOR_CROWD_ADDRESS;
    (void)pthread_mutex_unlock(&watchman->lock);
    return crowd;
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
        peer->sampled_at = 0;
        if (peer->row != VOR_ROW_CUT)
            vor_row_move(watchman, peer, (int)phase);
        if (phase == VOR_PHASE_STREAM)
            set_timeout(peer->fd, stream_timeout(watchman->limits.beat_seconds));
        if (phase == VOR_PHASE_BODY)
            acknowledge_now(peer->fd);
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
    peer->waiting = waiting && !peer->left;
    if (waiting && peer->left && peer->waker != NULL)
        vor_waker_gone(peer->waker);
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
    vor_crowd_not_due(watchman, peer);
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_waker_drop(before);
}

void vor_peer_turn(struct vor_watchman *watchman, struct vor_peer *peer)
{
    (void)pthread_mutex_lock(&watchman->lock);
    vor_crowd_due(watchman, peer);
    (void)pthread_mutex_unlock(&watchman->lock);
    vor_crowd_poke(watchman);
}

void vor_peer_timer(struct vor_watchman *watchman, struct vor_peer *peer, double seconds)
{
    double at = vor_clock_seconds() + seconds;

    if (peer == NULL)
        return;
    (void)pthread_mutex_lock(&watchman->lock);
    if (peer->wake_at == 0 || at < peer->wake_at)
        peer->wake_at = at;
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
