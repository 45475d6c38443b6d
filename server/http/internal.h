/** What the http*.c files share. Included by them only; MHD types appear as opaque tags. */
#ifndef VOR_SERVER_HTTP_INTERNAL_H
#define VOR_SERVER_HTTP_INTERNAL_H

#include "server/http/http.h"

#include <pthread.h>
#include <stdbool.h>

struct MHD_Connection;
struct MHD_Daemon;

enum {
    VOR_TARGET_MAX = 8192,       /**< bytes of a request target */
    VOR_FIELDS_MAX = 100,        /**< header fields of a request */
    VOR_HEADER_MAX = 32768,      /**< bytes of a header block, request line and all */
    VOR_QUERY_MAX = 64,          /**< pairs of a query */
    VOR_REPLY_FIELDS_MAX = 24,   /**< header fields of a reply */
    VOR_CONNECTION_BYTES = 49152 /**< what libmicrohttpd keeps for a connection: the longest header
                                    block, and room to read a body and to answer */
};

struct vor_field {
    const char *name, *value;
};

/* --- http_gate.c: what a request must look like before anybody acts on it ----------------------
 */

/** A header block as it came; strings are borrowed for the request. */
struct vor_head {
    const char *target; /**< raw, as on the request line */
    const char *version;
    size_t field_count; /**< VOR_FIELDS_MAX + 1 when there were more */
    struct vor_field fields[VOR_FIELDS_MAX];
};

/** First value of a field by name (any case), or NULL. */
const char *vor_head_find(const struct vor_head *head, const char *name);

/** The slug of the problem ("smuggled-framing", "malformed-request") and its sentence, or NULL when
 *  the head is sound. Never looks at the body. */
const char *vor_gate_check(const struct vor_head *head, const char **detail);

/** Declared length of the body: -1 chunked, 0 none. head has passed the gate. */
int64_t vor_gate_length(const struct vor_head *head);

/** Splits and decodes the query in place: pairs point into text. Returns how many there are, or -1
 *  when an escape is malformed, a control byte is hidden in one, or there are more than max. */
int vor_query_split(char *text, struct vor_field *pairs, int max);

/** A name for a request: sane (may be NULL) if it is, else a random UUID. */
void vor_request_id_make(char out[72], const char *sane);

/* --- the request: http_request.c reads it, http_reply.c writes its reply, http.c drives it ------
 */

enum vor_request_stage {
    VOR_AT_NEW,    /**< the request line is in */
    VOR_AT_HEAD,   /**< the head passed; the handler has not seen it */
    VOR_AT_BODY,   /**< pieces go to the sink */
    VOR_AT_WAIT,   /**< the handler waits to be woken */
    VOR_AT_REPLIED /**< a reply is recorded */
};

enum vor_reply_kind { VOR_REPLY_NONE, VOR_REPLY_BYTES, VOR_REPLY_FILE, VOR_REPLY_STREAM };

/** A reply as the handler described it; http.c turns it into the library's. */
struct vor_reply {
    enum vor_reply_kind kind;
    int http;
    struct vor_field fields[VOR_REPLY_FIELDS_MAX]; /**< names borrowed, values owned */
    unsigned field_count;
    const char *media_type;
    char *bytes; /**< owned */
    uint64_t size;
    int fd; /**< owned, -1 for none */
    uint64_t offset;
    long (*read)(void *ctx, struct vor_request *request, char *out, size_t size);
    void *ctx;
    bool close;
};

struct vor_request {
    struct vor_http *http;
    struct MHD_Connection *connection;
    struct vor_peer *peer; /**< NULL when not watched */
    struct vor_waker *waker;
    struct vor_head head;
    char *target, *path, *query; /**< owned; path is target up to '?', query is decoded in place */
    struct vor_field pairs[VOR_QUERY_MAX];
    int pair_count;
    enum vor_method method;
    enum vor_request_stage stage;
    char id[72];
    char job[40];        /**< that it is about, or "" */
    const char *problem; /**< slug of the problem replied, or NULL; static */
    const struct vor_route *route;
    double began;
    int64_t length;
    struct vor_body_sink sink;
    uint64_t limit, received, sent;
    void *state;
    void (*release)(void *state);
    struct vor_reply reply;
};

/** The method of that word; VOR_METHOD_COUNT when no route knows it. */
enum vor_method vor_method_find(const char *word);

/** Cuts the target into path and query and decodes the pairs; false when vor_query_split does not
 *  take them. */
bool vor_request_split(struct vor_request *request);

/** Reply as raw HTTP/1.1, head and bytes, for a socket that the library cannot answer on any more;
 *  NULL when memory is short. The caller frees it. */
char *vor_reply_raw(const struct vor_request *request);

/** The refusals of a body that is too long (detail is the room for its sentence) and of one that
 *  the sink cannot keep. */
void vor_refusal_excess(char *detail, size_t size, struct vor_refusal *refusal, uint64_t limit,
                        uint64_t got);
void vor_refusal_sink(struct vor_refusal *refusal, int http);

/** Drops the reply but for its first `fields` header fields. */
void vor_reply_clear(struct vor_request *request, unsigned fields);

/* --- http_listen.c ------------------------------------------------------------------------------
 */

/** A socket that listens on options->host and port, non-blocking.
 *
 *  @retval VOR_E_PARAM the address cannot be bound */
VOR_NODISCARD vor_status vor_listen(int *out, const struct vor_http_options *options,
                                    struct vor_error *err);

/** "127.0.0.1:43125" or "[::1]:8080" of a bound socket. */
void vor_listen_address(int fd, char out[80]);

/* --- http_peer.c: deadlines and departures, which the library does not watch -------------------
 */

enum vor_phase {
    VOR_PHASE_HEAD,  /**< since accept, or since the request line on a kept connection */
    VOR_PHASE_BODY,  /**< body is arriving */
    VOR_PHASE_SERVE, /**< a handler or the reply's writer has it */
    VOR_PHASE_IDLE   /**< kept, between requests */
};

/** One accepted connection. Every member is guarded by the watch's lock. */
struct vor_peer {
    struct vor_peer *next, *previous;
    uint64_t serial;
    int fd;
    enum vor_phase phase;
    double since;            /**< the phase began */
    double last;             /**< last piece of the body */
    double look_at;          /**< when to look next whether it has left */
    uint64_t bytes;          /**< of this body */
    bool waiting;            /**< its request is suspended: watch for the peer leaving */
    bool cut;                /**< shut down by the sweeper */
    bool linger;             /**< read on after the close, so that the reply is not reset away */
    double wake_at;          /**< 0: no timer */
    struct vor_waker *waker; /**< of the request under way, or NULL */
    char *late;              /**< raw 408 to send when the body is late, or NULL */
    bool told_late;          /**< and it was */
};

/** All connections and the thread that sweeps them. */
struct vor_watchman;

struct vor_deadlines {
    double header_seconds, keep_seconds, body_seconds, body_idle_seconds, body_rate;
};

VOR_NODISCARD vor_status vor_watchman_start(struct vor_watchman **out,
                                            const struct vor_deadlines *deadlines,
                                            struct vor_error *err);
/** Stops the thread; every peer must have left. */
void vor_watchman_stop(struct vor_watchman *watchman);

/** A connection comes and goes. NULL when memory is short: then it is not watched. */
struct vor_peer *vor_peer_enter(struct vor_watchman *watchman, int fd);
void vor_peer_leave(struct vor_watchman *watchman, struct vor_peer *peer);

void vor_peer_phase(struct vor_watchman *watchman, struct vor_peer *peer, enum vor_phase phase);
void vor_peer_received(struct vor_watchman *watchman, struct vor_peer *peer, size_t bytes);

/** The request under way on this connection begins to wait, goes on, or there is none (waker NULL).
 *  The peer keeps a hold of its own on the waker. */
void vor_peer_wait(struct vor_watchman *watchman, struct vor_peer *peer, bool waiting);
void vor_peer_request(struct vor_watchman *watchman, struct vor_peer *peer,
                      struct vor_waker *waker);
void vor_peer_timer(struct vor_watchman *watchman, struct vor_peer *peer, double seconds);
void vor_peer_late(struct vor_watchman *watchman, struct vor_peer *peer, char *late);
void vor_peer_linger(struct vor_watchman *watchman, struct vor_peer *peer);

/** The request is over. True when it was cut because its body was late. */
bool vor_peer_end(struct vor_watchman *watchman, struct vor_peer *peer);

/** Cuts idle connections; from now on those that become idle too. */
void vor_watchman_quiesce(struct vor_watchman *watchman);
unsigned vor_watchman_count(struct vor_watchman *watchman);

/** Wakes every request under way. */
void vor_watchman_wake_all(struct vor_watchman *watchman);

/** Extra hold on a waker; marks that the peer left. */
struct vor_waker *vor_waker_hold(struct vor_waker *waker);
void vor_waker_gone(struct vor_waker *waker);

#endif
