/** The connections of a guard, in queues by their phase, and which is closed when there are too
 *  many. Of conn_guard.c; nobody else includes this. Every member is guarded by the lock; functions
 *  here are called with it held. */
#ifndef VOR_SERVER_HTTP_CONN_TABLE_H
#define VOR_SERVER_HTTP_CONN_TABLE_H

#include "server/http/conn.h"
#include "server/http/waker.h"

#include <pthread.h>
#include <stdint.h>
#include <sys/queue.h>

enum {
    VOR_QUEUE_CLOSED = VOR_PHASE_COUNT, /**< shut down, and not closed yet by the library */
    VOR_QUEUES,
    VOR_CALLERS = 1024, /**< chains of the table of addresses */
    VOR_LINGERING_MAX = 64
};

/** How many connections one address has: an IPv4 address, or the first 64 bits of an IPv6 one,
 *  which is what one caller has at least (RFC 6177). */
struct vor_conn_caller {
    struct vor_conn_caller *next;
    struct vor_address address;
    unsigned count;
};

struct vor_conn {
    struct vor_conn_guard *guard;
    TAILQ_ENTRY(vor_conn) queued, due;
    int queue; /**< its phase, or VOR_QUEUE_CLOSED */
    int fd;
    enum vor_phase phase;
    struct vor_conn_caller *caller; /**< NULL: not counted */
    double since;                   /**< the phase began */
    double last;                    /**< last piece of the body */
    double look_at;          /**< when to look next whether it has left, how fast it reads, or
                                  whether one that was shut down is gone */
    uint64_t bytes;          /**< of this body; of a reply, those acknowledged at sampled_at */
    double sampled_at;       /**< 0: not yet */
    bool is_waiting;         /**< its request is suspended: watch for the client leaving */
    bool has_left;           /**< the client has closed its side */
    int skips;               /**< so few unread bytes are no news: those that end a chunk */
    bool has_news;           /**< more have come since vor_conn_news */
    bool lingers;            /**< read on after the close, so that the reply is not reset away */
    bool is_due;             /**< its request is to be woken: it is in that queue */
    double wake_at;          /**< 0: no timer */
    struct vor_waker *waker; /**< of the request under way, or NULL */
    char *late;              /**< raw 408 to send when the body is late, or NULL */
    bool told_late;          /**< and it was */
};

TAILQ_HEAD(vor_conn_list, vor_conn);

/** Connections in the order in which they came here. */
struct vor_conn_queue {
    struct vor_conn_list list;
    unsigned count;
};

struct vor_conn_guard {
    pthread_mutex_t lock;
    pthread_t thread;
    struct vor_conn_limits limits;
    struct vor_conn_queue queues[VOR_QUEUES];
    struct vor_conn_list due;
    struct vor_conn_caller *callers[VOR_CALLERS];
    uint64_t salt; /**< of the table, so that nobody can choose addresses for one chain */
    struct {
        int fd;
        double until;
    } lingering[VOR_LINGERING_MAX];
    unsigned lingering_count;
    int poke;       /**< eventfd: look again */
    int departures; /**< epoll of all connections */
    bool stop;
    bool is_awake; /**< the thread looks every tick */
};

/** Has the thread look again. */
void vor_conn_poke(const struct vor_conn_guard *guard);

/** Queues a connection whose request is to be woken; takes it out of that queue. */
void vor_conn_set_due(struct vor_conn *conn);
void vor_conn_not_due(struct vor_conn *conn);

/** Moves a connection to the end of a queue; -1: only takes it out. */
void vor_conn_move(struct vor_conn *conn, int queue);

/** Connections that count, neither streams nor shut down; and those of them that have a request
 *  under way whose head is in. */
unsigned vor_conns_open(const struct vor_conn_guard *guard);
unsigned vor_conns_busy(const struct vor_conn_guard *guard);

/** Shuts a connection down; the library closes it soon. Tells the client why when its body is late.
 */
void vor_conn_close(struct vor_conn *conn, bool is_late);

/** Reads on for some seconds what comes on this descriptor, then closes it. */
void vor_conn_read_on(struct vor_conn_guard *guard, int fd);

/** Counts a new connection of that address (NULL for none), and takes its count back. */
void vor_conn_count(struct vor_conn *conn, const struct vor_address *from);
void vor_conn_uncount(struct vor_conn *conn);

/** Closes a connection if the one that just came makes too many. */
void vor_conns_make_room(struct vor_conn *newcomer);

#endif
