/* Who must go when there are too many connections: the oldest of those that have not sent a whole
 * head, then the oldest kept ones between two requests. Those which are being served stay; for them
 * the limit is one of requests, which the router answers. */
#include "server/http/crowd.h"

#include "server/base/clock.h"

#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    RESERVE = 32,      /* connections beyond the limit, for health checks */
    UNREAD_LOOKED = 16 /* silent peers that are asked whether bytes of theirs wait, before one goes
                          that has some */
};
static const double linger_seconds = 5;

void vor_crowd_poke(const struct vor_watchman *watchman)
{
    uint64_t one = 1;

    /* A write to a full counter fails, but then a poke is pending already. */
    if (write(watchman->poke, &one, sizeof one) < 0)
        return;
}

void vor_crowd_due(struct vor_watchman *watchman, struct vor_peer *peer)
{
    if (peer->due || peer->waker == NULL)
        return;
    peer->due = true;
    peer->due_previous = watchman->due_last;
    peer->due_next = NULL;
    if (watchman->due_last != NULL)
        watchman->due_last->due_next = peer;
    else
        watchman->due_first = peer;
    watchman->due_last = peer;
}

void vor_crowd_not_due(struct vor_watchman *watchman, struct vor_peer *peer)
{
    if (!peer->due)
        return;
    peer->due = false;
    if (peer->due_previous != NULL)
        peer->due_previous->due_next = peer->due_next;
    else
        watchman->due_first = peer->due_next;
    if (peer->due_next != NULL)
        peer->due_next->due_previous = peer->due_previous;
    else
        watchman->due_last = peer->due_previous;
}

void vor_crowd_linger(struct vor_watchman *watchman, int fd)
{
    if (watchman->lingering_count == VOR_LINGERING_MAX) {
        (void)close(fd);
        return;
    }
    watchman->lingering[watchman->lingering_count++] =
        (struct vor_lingering){fd, vor_clock_seconds() + linger_seconds};
    vor_crowd_poke(watchman);
}

/* --- rows ------------------------------------------------------------------------------------- */

void vor_row_take(struct vor_watchman *watchman, struct vor_peer *peer)
{
    struct vor_row *row = &watchman->rows[peer->row];

    if (peer->previous != NULL)
        peer->previous->next = peer->next;
    else
        row->first = peer->next;
    if (peer->next != NULL)
        peer->next->previous = peer->previous;
    else
        row->last = peer->previous;
    peer->next = peer->previous = NULL;
    row->count--;
}

static void append(struct vor_watchman *watchman, struct vor_peer *peer, int to)
{
    struct vor_row *row = &watchman->rows[to];

    peer->row = to;
    peer->previous = row->last;
    if (row->last != NULL)
        row->last->next = peer;
    else
        row->first = peer;
    row->last = peer;
    row->count++;
}

void vor_row_move(struct vor_watchman *watchman, struct vor_peer *peer, int row)
{
    if (peer->row >= 0)
        vor_row_take(watchman, peer);
    append(watchman, peer, row);
}

unsigned vor_crowd_busy(const struct vor_watchman *watchman)
{
    return watchman->rows[VOR_PHASE_BODY].count + watchman->rows[VOR_PHASE_SERVE].count +
           watchman->rows[VOR_PHASE_SEND].count;
}

unsigned vor_crowd_size(const struct vor_watchman *watchman)
{
    return vor_crowd_busy(watchman) + watchman->rows[VOR_PHASE_HEAD].count +
           watchman->rows[VOR_PHASE_IDLE].count;
}

/* It was made when the body began. */
static void date_again(char *reply)
{
    static const char name[] = "\r\nDate: ";
    char *at = strstr(reply, name), date[VOR_HTTP_DATE_SIZE];

    vor_clock_http_date(date);
    if (at != NULL)
        memcpy(at + sizeof name - 1, date, sizeof date - 1);
}

void vor_crowd_cut(struct vor_watchman *watchman, struct vor_peer *peer, bool is_late)
{
    if (peer->phase == VOR_PHASE_BODY && peer->late != NULL) {
        peer->told_late = is_late;
        date_again(peer->late);
        (void)send(peer->fd, peer->late, strlen(peer->late), MSG_DONTWAIT | MSG_NOSIGNAL);
        peer->linger = true;
        (void)shutdown(peer->fd, SHUT_RD);
    } else {
        (void)shutdown(peer->fd, SHUT_RDWR);
    }
    peer->look_at = vor_clock_seconds() + linger_seconds;
    vor_row_move(watchman, peer, VOR_ROW_CUT);
}

/* --- by address ------------------------------------------------------------------------------- */

static bool is_counted(const struct vor_watchman *watchman, const struct vor_address *address)
{
    static const struct vor_networks loopback = {
        .count = 2, .list = {{{{[10] = 0xff, [11] = 0xff, [12] = 127}}, 104}, {{{[15] = 1}}, 128}}};

    return watchman->limits.each > 0 && !vor_networks_hold(&loopback, address) &&
           (watchman->limits.trusted == NULL ||
            !vor_networks_hold(watchman->limits.trusted, address));
}

static struct vor_crowd_address **place_of(struct vor_watchman *watchman,
                                           const struct vor_address *address)
{
    static const uint64_t prime = 1099511628211u; /* of FNV-1a with 64 bits */
    uint64_t hash = watchman->salt;
    struct vor_crowd_address **at;

    for (size_t i = 0; i < sizeof address->bytes; i++)
        hash = (hash ^ address->bytes[i]) * prime;
    at = &watchman->callers[(hash >> 32) % VOR_CALLERS];
    while (*at != NULL && memcmp(&(*at)->address, address, sizeof *address) != 0)
        at = &(*at)->next;
    return at;
}

static struct vor_address network_of(const struct vor_address *from)
{
    static const struct vor_networks four = {.count = 1,
                                             .list = {{{{[10] = 0xff, [11] = 0xff}}, 96}}};
    struct vor_address address = *from;

    if (!vor_networks_hold(&four, from))
        memset(address.bytes + 8, 0, 8);
    return address;
}

void vor_crowd_count(struct vor_watchman *watchman, struct vor_peer *peer,
                     const struct vor_address *from)
{
    struct vor_address address;
    struct vor_crowd_address **at, *caller;

    if (from == NULL || !is_counted(watchman, from))
        return;
    address = network_of(from);
    at = place_of(watchman, &address);
    caller = *at;
    if (caller == NULL) {
        caller = calloc(1, sizeof *caller);
        if (caller == NULL)
            return;
        caller->address = address;
        *at = caller;
    }
    caller->count++;
    peer->caller = caller;
}

void vor_crowd_uncount(struct vor_watchman *watchman, struct vor_peer *peer)
{
    struct vor_crowd_address *caller = peer->caller;

    if (caller == NULL || --caller->count > 0)
        return;
    *place_of(watchman, &caller->address) = caller->next;
    free(caller);
}

/* --- too many --------------------------------------------------------------------------------- */

bool vor_peer_has_unread(const struct vor_peer *peer)
{
    int unread = 0;

    return ioctl(peer->fd, FIONREAD, &unread) != 0 || unread > 0;
}

/* The oldest of a row, without the newcomer, that has been silent for long enough and of whom no
 * bytes wait to be read; else NULL, or with `any` the oldest. */
static struct vor_peer *oldest(const struct vor_watchman *watchman, enum vor_phase row,
                               const struct vor_peer *newcomer, bool any)
{
    double since = newcomer->since - watchman->limits.grace_seconds;
    struct vor_peer *found = NULL, *peer = watchman->rows[row].first;

    for (int i = 0; peer != NULL && i < UNREAD_LOOKED; i++, peer = peer->next) {
        if (peer == newcomer)
            continue;
        if (peer->since <= since && !vor_peer_has_unread(peer))
            return peer;
        if (found == NULL && any)
            found = peer;
    }
    return found;
}

void vor_crowd_make_room(struct vor_watchman *watchman, struct vor_peer *newcomer)
{
    const struct vor_watch_limits *limits = &watchman->limits;
    unsigned count = vor_crowd_size(watchman);
    bool full = count > limits->connections + RESERVE;
    struct vor_peer *goes;

    if (newcomer->caller != NULL && newcomer->caller->count > limits->each + RESERVE) {
        vor_crowd_cut(watchman, newcomer, false);
        return;
    }
    if (count <= limits->connections)
        return;
    goes = oldest(watchman, VOR_PHASE_HEAD, newcomer, full);
    if (goes == NULL)
        goes = oldest(watchman, VOR_PHASE_IDLE, newcomer, full);
    if (goes == NULL && full)
        goes = newcomer;
    if (goes != NULL)
        vor_crowd_cut(watchman, goes, false);
}
