/* Which connection is closed when there are too many: the oldest of those that have not sent a
 * whole head, then the oldest kept ones between two requests. Those which are being served stay;
 * for them the limit is one of requests, which the router answers. */
#include "server/http/conn_table.h"

#include "server/base/clock.h"

#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    RESERVE = 32,      /* connections beyond the limit, for health checks */
    UNREAD_LOOKED = 16 /* connections of a queue that are checked for unread bytes; if all of these
                          have some, one of them is closed anyway when the table is full */
};
static const double linger_seconds = 5;

void vor_conn_poke(const struct vor_conn_guard *guard)
{
    uint64_t one = 1;

    /* A write to a full counter fails, but then a poke is pending already. */
    if (write(guard->poke, &one, sizeof one) < 0)
        return;
}

void vor_conn_set_due(struct vor_conn *conn)
{
    if (conn->is_due || conn->waker == NULL)
        return;
    conn->is_due = true;
    TAILQ_INSERT_TAIL(&conn->guard->due, conn, due);
}

void vor_conn_not_due(struct vor_conn *conn)
{
    if (conn->is_due)
        TAILQ_REMOVE(&conn->guard->due, conn, due);
    conn->is_due = false;
}

void vor_conn_read_on(struct vor_conn_guard *guard, int fd)
{
    if (guard->lingering_count == VOR_LINGERING_MAX) {
        (void)close(fd);
        return;
    }
    guard->lingering[guard->lingering_count].fd = fd;
    guard->lingering[guard->lingering_count++].until = vor_clock_seconds() + linger_seconds;
    vor_conn_poke(guard);
}

void vor_conn_move(struct vor_conn *conn, int queue)
{
    struct vor_conn_queue *queues = conn->guard->queues;

    if (conn->queue >= 0) {
        TAILQ_REMOVE(&queues[conn->queue].list, conn, queued);
        queues[conn->queue].count--;
    }
    conn->queue = queue;
    if (queue >= 0) {
        TAILQ_INSERT_TAIL(&queues[queue].list, conn, queued);
        queues[queue].count++;
    }
}

unsigned vor_conns_busy(const struct vor_conn_guard *guard)
{
    return guard->queues[VOR_PHASE_BODY].count + guard->queues[VOR_PHASE_SERVE].count +
           guard->queues[VOR_PHASE_SEND].count;
}

unsigned vor_conns_open(const struct vor_conn_guard *guard)
{
    return vor_conns_busy(guard) + guard->queues[VOR_PHASE_HEAD].count +
           guard->queues[VOR_PHASE_IDLE].count;
}

void vor_conn_close(struct vor_conn *conn, bool is_late)
{
    static const char name[] = "\r\nDate: ";
    char date[VOR_HTTP_DATE_SIZE], *at;

    if (conn->phase == VOR_PHASE_BODY && conn->late != NULL) {
        conn->told_late = is_late;
        at = strstr(conn->late, name); /* the reply was made when the body began */
        vor_clock_http_date(date);
        if (at != NULL)
            memcpy(at + sizeof name - 1, date, sizeof date - 1);
        (void)send(conn->fd, conn->late, strlen(conn->late), MSG_DONTWAIT | MSG_NOSIGNAL);
        conn->lingers = true;
        (void)shutdown(conn->fd, SHUT_RD);
    } else {
        (void)shutdown(conn->fd, SHUT_RDWR);
    }
    conn->look_at = vor_clock_seconds() + linger_seconds;
    vor_conn_move(conn, VOR_QUEUE_CLOSED);
}

/* Where the entry of an address hangs, or would. */
static struct vor_conn_caller **place_of(struct vor_conn_guard *guard,
                                         const struct vor_address *address)
{
    static const uint64_t prime = 1099511628211u; /* of FNV-1a with 64 bits */
    uint64_t hash = guard->salt;
    struct vor_conn_caller **at;

    for (size_t i = 0; i < sizeof address->bytes; i++)
        hash = (hash ^ address->bytes[i]) * prime;
    at = &guard->callers[(hash >> 32) % VOR_CALLERS];
    while (*at != NULL && memcmp(&(*at)->address, address, sizeof *address) != 0)
        at = &(*at)->next;
    return at;
}

void vor_conn_count(struct vor_conn *conn, const struct vor_address *from)
{
    static const struct vor_networks loopback = {
        .count = 2, .list = {{{{[10] = 0xff, [11] = 0xff, [12] = 127}}, 104}, {{{[15] = 1}}, 128}}};
    static const struct vor_networks four = {.count = 1,
                                             .list = {{{{[10] = 0xff, [11] = 0xff}}, 96}}};
    const struct vor_conn_limits *limits = &conn->guard->limits;
    struct vor_conn_caller **at, *caller;
    struct vor_address address;

    if (from == NULL || limits->each == 0 || vor_networks_hold(&loopback, from) ||
        (limits->trusted != NULL && vor_networks_hold(limits->trusted, from)))
        return;
    address = *from;
    if (!vor_networks_hold(&four, from))
        memset(address.bytes + 8, 0, 8);
    at = place_of(conn->guard, &address);
    caller = *at != NULL ? *at : calloc(1, sizeof *caller);
    if (caller == NULL)
        return;
    caller->address = address;
    caller->count++;
    conn->caller = *at = caller;
}

void vor_conn_uncount(struct vor_conn *conn)
{
    struct vor_conn_caller *caller = conn->caller;

    if (caller == NULL || --caller->count > 0)
        return;
    *place_of(conn->guard, &caller->address) = caller->next;
    free(caller);
}

bool vor_conn_has_unread(const struct vor_conn *conn)
{
    int unread = 0;

    return ioctl(conn->fd, FIONREAD, &unread) != 0 || unread > conn->skips;
}

/* The oldest of a queue, without the newcomer, that has been silent for long enough and of whom no
 * bytes wait to be read; else NULL, or with `any` the oldest. */
static struct vor_conn *oldest(const struct vor_conn *newcomer, enum vor_phase queue, bool any)
{
    double since = newcomer->since - newcomer->guard->limits.grace_seconds;
    struct vor_conn *found = NULL, *conn = TAILQ_FIRST(&newcomer->guard->queues[queue].list);

    for (int i = 0; conn != NULL && i < UNREAD_LOOKED; i++, conn = TAILQ_NEXT(conn, queued)) {
        if (conn == newcomer)
            continue;
        if (conn->since <= since && !vor_conn_has_unread(conn))
            return conn;
        if (found == NULL && any)
            found = conn;
    }
    return found;
}

void vor_conns_make_room(struct vor_conn *newcomer)
{
    const struct vor_conn_limits *limits = &newcomer->guard->limits;
    unsigned count = vor_conns_open(newcomer->guard);
    bool is_full = count > limits->connections + RESERVE;
    struct vor_conn *goes = NULL;

    if (newcomer->caller != NULL && newcomer->caller->count > limits->each + RESERVE)
        goes = newcomer;
    if (goes == NULL && count > limits->connections)
        goes = oldest(newcomer, VOR_PHASE_HEAD, is_full);
    if (goes == NULL && count > limits->connections)
        goes = oldest(newcomer, VOR_PHASE_IDLE, is_full);
    if (goes == NULL && is_full)
        goes = newcomer;
    if (goes != NULL)
        vor_conn_close(goes, false);
}
