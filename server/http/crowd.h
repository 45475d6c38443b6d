/** All connections, in rows by where they stand, and who of them must go when there are too many.
 *  Shared by peer, which is told of one, and watchman, the thread; nobody else includes this. Every
 *  member is guarded by the watchman's lock; functions here are called with it held. */
#ifndef VOR_SERVER_HTTP_CROWD_H
#define VOR_SERVER_HTTP_CROWD_H

#include "server/http/phases.h"
#include "server/http/waker.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    VOR_ROW_CUT = VOR_PHASE_COUNT, /**< shut down, and not closed yet by the library */
    VOR_ROWS,
    VOR_CALLERS = 1024, /**< chains of the table of addresses */
    VOR_LINGERING_MAX = 64
};

/** How many connections one address has: an IPv4 address, or the first 64 bits of an IPv6 one,
 *  which is what one caller has at least (RFC 6177). */
struct vor_crowd_address {
    struct vor_crowd_address *next;
    struct vor_address address;
    unsigned count;
};

struct vor_peer {
    struct vor_peer *next, *previous; /**< in its row */
    struct vor_peer *due_next, *due_previous;
    int row; /**< its phase, or VOR_ROW_CUT */
    int fd;
    enum vor_phase phase;
    struct vor_crowd_address *caller; /**< NULL: not counted */
    double since;                     /**< the phase began */
    double last;                      /**< last piece of the body */
    double look_at;          /**< when to look next whether it has left, how fast it reads, or
                              whether one that is cut is gone */
    uint64_t bytes;          /**< of this body; of a reply, those acknowledged at sampled_at */
    double sampled_at;       /**< 0: not yet */
    bool waiting;            /**< its request is suspended: watch for the peer leaving */
    bool left;               /**< it has closed its side */
    bool linger;             /**< read on after the close, so that the reply is not reset away */
    bool due;                /**< its request is to be woken: it is in that queue */
    double wake_at;          /**< 0: no timer */
    struct vor_waker *waker; /**< of the request under way, or NULL */
    char *late;              /**< raw 408 to send when the body is late, or NULL */
    bool told_late;          /**< and it was */
};

/** Peers in the order in which they came here. */
struct vor_row {
    struct vor_peer *first, *last;
    unsigned count;
};

struct vor_lingering {
    int fd;
    double until;
};

struct vor_watchman {
    pthread_mutex_t lock;
    pthread_t thread;
    struct vor_watch_limits limits;
    struct vor_row rows[VOR_ROWS];
    struct vor_peer *due_first, *due_last;
    struct vor_crowd_address *callers[VOR_CALLERS];
    uint64_t salt; /**< of the table, so that nobody can choose addresses for one chain */
    struct vor_lingering lingering[VOR_LINGERING_MAX];
    unsigned lingering_count;
    int poke;       /**< eventfd: look again */
    int departures; /**< epoll of all connections */
    bool stop;
    bool awake; /**< the sweeper looks every tick */
};

/** Has the sweeper look again. */
void vor_crowd_poke(const struct vor_watchman *watchman);

/** Queues a peer whose request is to be woken. */
void vor_crowd_due(struct vor_watchman *watchman, struct vor_peer *peer);

/** Takes a peer out of that queue; one that is not there is fine. */
void vor_crowd_not_due(struct vor_watchman *watchman, struct vor_peer *peer);

/** Moves a peer to the end of a row; take only takes it out. */
void vor_row_move(struct vor_watchman *watchman, struct vor_peer *peer, int row);
void vor_row_take(struct vor_watchman *watchman, struct vor_peer *peer);

/** Connections that count, neither streams nor cut; and those of them that have a request under way
 *  whose head is in. */
unsigned vor_crowd_size(const struct vor_watchman *watchman);
unsigned vor_crowd_busy(const struct vor_watchman *watchman);

/** True when the peer has sent bytes that nobody has read yet. */
bool vor_peer_has_unread(const struct vor_peer *peer);

/** Shuts a connection down; the library closes it soon. Tells the peer why when its body is late.
 */
void vor_crowd_cut(struct vor_watchman *watchman, struct vor_peer *peer, bool is_late);

/** Reads on for some seconds what comes on this descriptor, then closes it. */
void vor_crowd_linger(struct vor_watchman *watchman, int fd);

/** Counts a new peer of that address (NULL for none), and takes its count back. */
void vor_crowd_count(struct vor_watchman *watchman, struct vor_peer *peer,
                     const struct vor_address *from);
void vor_crowd_uncount(struct vor_watchman *watchman, struct vor_peer *peer);

/** Cuts somebody if the peer that just came makes too many. */
void vor_crowd_make_room(struct vor_watchman *watchman, struct vor_peer *newcomer);

#endif
