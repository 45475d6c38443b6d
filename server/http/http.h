/** Requests in, answers out: the door to this room. Nothing in this header shows the library under
 *  it.
 *
 *  A handler is a function called one step after another, always on one of the HTTP threads, never
 *  twice at a time for one request, and never allowed to block:
 *
 *    HEAD  the header block is in and passed the request check (framing, Host, Origin, limits)
 *    BODY  the body is in, if the answer to HEAD was VOR_NEXT_BODY
 *    WAKE  vor_waker_wake was called, or the peer left, after VOR_NEXT_WAIT or VOR_NEXT_STAY
 *
 *  and says what comes next. Waiting costs no thread: the connection is suspended. */
#ifndef VOR_SERVER_HTTP_H
#define VOR_SERVER_HTTP_H

#include "core/base/status.h"
#include "server/base/address.h"
#include "server/base/principal.h"
#include "server/base/span.h"
#include "server/http/request_check.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

struct vor_http;
struct vor_request;
struct vor_conn;
struct MHD_Connection;
struct vor_waker;
struct vor_app;   /**< server/api/app.h */
struct vor_route; /**< server/api/route_table.h */

enum vor_method { VOR_GET, VOR_HEAD, VOR_POST, VOR_DELETE, VOR_OPTIONS, VOR_METHOD_COUNT };

enum vor_step { VOR_STEP_HEAD, VOR_STEP_BODY, VOR_STEP_WAKE };

enum vor_next {
    VOR_NEXT_REPLY, /**< one of vor_reply_* was called */
    VOR_NEXT_BODY,  /**< only from HEAD, after vor_request_take_body */
    VOR_NEXT_WAIT,  /**< call me when woken, or when the peer leaves */
    VOR_NEXT_STAY   /**< call me when woken; the peer may leave, or have left, all the same */
};

typedef enum vor_next (*vor_handler)(struct vor_request *request, enum vor_step step);

/** Why the HTTP layer itself ends a request. */
struct vor_refusal {
    int http;
    const char *slug;    /**< "smuggled-framing", "malformed-request", "too-many-bytes" ... */
    const char *detail;  /**< one sentence */
    uint64_t limit, got; /**< too-many-bytes; else 0 */
};

/** Which headers trusted proxies set; those of the other kind are the client's own. In the order of
 *  the setting's words (server/base/config.h). */
enum vor_proxy_headers { VOR_PROXY_X_FORWARDED, VOR_PROXY_FORWARDED };

/** Who sent a request and by which address it was reached, as far as the peer and the trusted
 *  proxies before it tell (server/http/forwarded.h). */
struct vor_via {
    char client[VOR_ADDRESS_TEXT];   /**< "" when the connection has no address */
    const char *scheme;              /**< "http" or "https", static; NULL: no proxy said */
    char host[VOR_HOST_MAX + 1];     /**< sound; "": no proxy said */
    char prefix[VOR_PREFIX_MAX + 1]; /**< path before ours, "" or "/a/b"; sound */
};

/** Limits and deadlines of connections; seconds unless named otherwise. */
struct vor_conn_limits {
    unsigned connections; /**< as many at a time, without streams; when they are more, the oldest
                               silent ones are cut, and 32 more are let in for health checks */
    unsigned each;        /**< connections of one address, if not loopback's or a trusted proxy's */
    double header_seconds;    /**< from accept, or from the request line on a kept connection */
    double keep_seconds;      /**< a kept connection may idle this long */
    double body_seconds;      /**< for the whole body */
    double body_idle_seconds; /**< between two pieces of it */
    double body_rate;         /**< bytes a second on average, after body_idle_seconds */
    double reply_rate;        /**< the same of who reads a reply, streams excepted */
    double beat_seconds;      /**< between two signs of life of a stream */
    double grace_seconds;     /**< a silent one stays so long when room is to be made, as long as
                                   the reserve lasts */
    const struct vor_networks *trusted; /**< proxies that are believed; borrowed; may be NULL */
};

struct vor_http_options {
    const char *host; /**< numeric address or name to bind */
    unsigned port;    /**< 0: any free one */
    const char *path; /**< of a Unix socket instead; NULL or "" for none */
    unsigned mode;    /**< of that socket: who may connect, 0660 */
    unsigned threads;
    struct vor_conn_limits limits;
    unsigned streams; /**< connections besides those of the limits */
    enum vor_proxy_headers proxy_headers;
    vor_handler handler; /**< the first one; routes.c hands on to the others */
    struct vor_app *app; /**< of each request */
    /** Makes the reply of a refusal, with one of vor_reply_bytes. */
    void (*refuse)(struct vor_request *request, const struct vor_refusal *refusal);
    /** Called once a request is over, with what the log wants to know. */
    void (*done)(const struct vor_request *request);
    /** A line of the library's own log. */
    void (*log)(const char *line);
};

/** Binds and listens; nobody is answered yet. A Unix socket that a daemon of before left behind is
 *  replaced; one that somebody answers on is not, nor a file that is no socket.
 *
 *  @retval VOR_E_IO    cannot listen on the address (message: address and reason)
 *  @retval VOR_E_NOMEM threads or memory are short */
VOR_NODISCARD vor_status vor_http_open(struct vor_http **out,
                                       const struct vor_http_options *options,
                                       struct vor_error *err);

/** Starts the threads: from here on handlers are called, with whatever their ctx needs in place.
 *
 *  @retval VOR_E_NOMEM threads or memory are short */
VOR_NODISCARD vor_status vor_http_start(struct vor_http *http, struct vor_error *err);

/** "127.0.0.1:43125", "[::1]:8080", "unix:/run/voronoid.sock": what is bound. Owned by http. */
const char *vor_http_address(const struct vor_http *http);

/** Stops accepting; requests under way go on, and kept connections are told with their next answer
 *  that it is the last. Call once. */
void vor_http_quiesce(struct vor_http *http);

/** Requests under way (streams and uploads included, and heads of which bytes wait to be read), and
 *  open connections but for streams. */
unsigned vor_http_busy(const struct vor_http *http);
unsigned vor_http_connections(const struct vor_http *http);

/** Cuts every connection that is still slow, its request or the answer being on its way, and those
 *  that are kept. */
void vor_http_cut_slow(struct vor_http *http);

/** Seconds that a thread has been busy with one step of a request, the longest there is: more than
 *  some tenths mean that it waits for what it should not. */
double vor_http_stuck(const struct vor_http *http);

/** Wakes every waiting request once. */
void vor_http_wake_all(struct vor_http *http);

/** Wakes every waiting request. From now on vor_request_closing is true. */
void vor_http_close_waiting(struct vor_http *http);

/** Stops at once and frees; http may be NULL. Handlers of waiting requests run once more, with
 *  vor_request_closing true, and must reply. */
void vor_http_stop(struct vor_http *http);

/* --- a request: what came, where it stands, and the reply that the handler described ---------- */

enum { VOR_REPLY_FIELDS_MAX = 24 }; /**< header fields of a reply */

enum vor_request_stage {
    VOR_AT_NEW,    /**< the request line is in */
    VOR_AT_HEAD,   /**< the head passed; the handler has not seen it */
    VOR_AT_BODY,   /**< pieces go to the sink */
    VOR_AT_WAIT,   /**< the handler waits to be woken */
    VOR_AT_REPLIED /**< a reply is recorded */
};

enum vor_reply_kind { VOR_REPLY_NONE, VOR_REPLY_BYTES, VOR_REPLY_FILE, VOR_REPLY_STREAM };

/** A reply as the handler described it; mhd_callbacks.c turns it into the library's. */
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
    long (*read)(struct vor_request *request, char *out, size_t size);
    bool close; /**< the connection, after the reply; a handler may set it */
};

/** Where a body goes, piece by piece, on the HTTP thread. write returns 0; or it ends the request
 *  while the body is still arriving, by an HTTP status (507), which is answered as that problem, or
 *  by -1 after one of vor_reply_bytes. */
struct vor_body_sink {
    void *ctx;
    int (*write)(void *ctx, const void *bytes, size_t size);
};

struct vor_request {
    /* What handlers read, but must not change. */
    struct vor_app *app;    /**< of vor_http_options */
    enum vor_method method; /**< VOR_METHOD_COUNT for one that no route has */
    char *path;             /**< raw as sent, without the query; it begins with '/' */
    struct vor_field pairs[VOR_QUERY_MAX]; /**< of the query, decoded */
    int pair_count;
    char id[72];          /**< X-Request-Id if the client sent a sane one (1 .. 64 of
                               [A-Za-z0-9._-]), else one of ours */
    struct vor_span span; /**< our step of the trace that the header traceparent names; none where
                               there is no sound one, or several */
    struct vor_via via;   /**< of a request whose head is malformed: the peer's address alone */
    int64_t length;       /**< declared Content-Length; -1: chunked */
    double began;
    uint64_t received, sent; /**< bytes of bodies */
    void *state;             /**< the handler's own (vor_request_set_state) */

    /* What the router and handlers set, for the log. */
    const struct vor_route *route;
    struct vor_principal principal; /**< nobody until the router has found out */
    char job[40];                   /**< that it is about, or "" */
    const char *problem;            /**< slug of the problem replied, or NULL; static */

    /* Of this room. */
    struct vor_http *http;
    struct MHD_Connection *connection;
    struct vor_conn *conn; /**< NULL when not guarded */
    struct vor_waker *waker;
    struct vor_head head;
    char *target, *query; /**< owned; path is target up to '?', query is decoded in place */
    const char *block;    /**< where the library has the target; valid in the first step */
    const char *line; /**< and the request line; NULL: not known, or what follows was given back */
    enum vor_request_stage stage;
    struct vor_address from; /**< of the connection */
    struct vor_body_sink sink;
    bool (*waits)(void *ctx); /**< NULL: the reply does not begin before the body is in */
    uint64_t limit;
    bool whole;    /**< the body was taken and is in */
    bool is_held;  /**< the first byte of the next piece was taken before */
    bool is_ended; /**< the last piece of an early reply is made */
    char *early;   /**< what is sent next of a reply that began before; NULL: it has not */
    size_t early_size, early_at;
    void (*release)(void *state);
    struct vor_reply reply;
};

/** First value of a header (any case), or NULL. */
const char *vor_request_header(const struct vor_request *request, const char *name);

/** The next value of a header that may come on several lines; *index starts at 0. NULL after the
 *  last. */
const char *vor_request_header_next(const struct vor_request *request, const char *name,
                                    unsigned *index);

/** First value of a query name, or NULL. */
const char *vor_request_query(const struct vor_request *request, const char *name);

/** True once the peer has closed its side. A reply must be made all the same. */
int vor_request_gone(const struct vor_request *request);

/** The limit that keeps this request from being served, connections or each of vor_http_options; 0
 *  when there is room. */
unsigned vor_request_excess(const struct vor_request *request);

/** True once vor_http_close_waiting was called: wait no longer. */
int vor_request_closing(const struct vor_request *request);

/** The handler's own state, freed by `release` (may be NULL) once the request is over or gets
 *  another state. */
void vor_request_set_state(struct vor_request *request, void *state, void (*release)(void *state));

/** Bytes of the reply's body; of a stream, those sent. */
uint64_t vor_request_bytes_out(const struct vor_request *request);

/** What the conditions of a GET or HEAD (RFC 9110, 13.2.2) leave of a reply of 200 with this entity
 *  tag: 200, 304 or 412. Each such reply that has an ETag becomes that by itself, 304 with the
 * headers of the 200; handlers ask where they would do in vain what it takes. */
int vor_request_condition(const struct vor_request *request, const char *etag);

/* --- the body --------------------------------------------------------------------------------- */

/** Asks for the body: pieces go to sink, at most `limit` bytes. A longer one, declared or not, is
 *  a 413 at once. Call in HEAD and return VOR_NEXT_BODY. sink->ctx must live as long as the state.
 */
void vor_request_take_body(struct vor_request *request, const struct vor_body_sink *sink,
                           uint64_t limit);

/** Lets the reply begin while the body arrives: write of the sink may call vor_reply_stream, and is
 *  called without bytes when the request is woken while waits is true. Not all clients and proxies
 *  go on sending once a reply has begun. What ends such a request before the body is in cuts the
 *  reply. Call after vor_request_take_body. False, and nothing of that: HTTP/1.0. */
bool vor_request_reply_early(struct vor_request *request, bool (*waits)(void *ctx));

/* --- waiting ---------------------------------------------------------------------------------- */

/** What another thread holds to call a waiting request back. It outlives the request: waking one
 *  whose request is over does nothing. Take a hold for each holder. */
struct vor_waker *vor_waker_hold(struct vor_waker *waker);
void vor_waker_wake(struct vor_waker *waker);
void vor_waker_drop(struct vor_waker *waker); /**< waker may be NULL */

/** Wakes the request that many seconds from now (to a tenth of a second), once; of several calls
 * the earliest counts. Of many requests that are due together some wake a little later, so that new
 *  ones are served in between. From any thread, as long as the request lives. */
void vor_request_wake_after(struct vor_request *request, double seconds);

/* --- answering: exactly one of these, from within a step -------------------------------------- */

/** Adds a header to the reply; values with control bytes are dropped whole. */
void vor_reply_header(struct vor_request *request, const char *name, const char *value);

/** size bytes of media type (NULL for none); the bytes are copied. */
void vor_reply_bytes(struct vor_request *request, int http, const char *media_type,
                     const void *bytes, size_t size);

/** length bytes of a file from offset; the descriptor is taken over. */
void vor_reply_file(struct vor_request *request, int http, const char *media_type, int fd,
                    uint64_t offset, uint64_t length);

/** A stream of so many bytes, or of VOR_LENGTH_UNKNOWN. read fills up to size bytes and returns how
 *  many; 0: nothing yet (it is asked again once a waker wakes the request), -1: the end, which cuts
 *  a reply whose length is known; VOR_STREAM_CUT cuts any. It runs on an HTTP thread and must not
 *  block; the request's state is alive throughout. */
#define VOR_LENGTH_UNKNOWN UINT64_MAX
enum { VOR_STREAM_CUT = -2 };
void vor_reply_stream(struct vor_request *request, int http, const char *media_type,
                      uint64_t length,
                      long (*read)(struct vor_request *request, char *out, size_t size));

#endif
