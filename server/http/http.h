/** Requests in, answers out: the door to this room. Nothing in this header shows the library under
 *  it.
 *
 *  A handler is a function called one step after another, always on one of the HTTP threads, never
 *  twice at a time for one request, and never allowed to block:
 *
 *    HEAD  the header block is in and passed the gate (framing, Host, Origin, limits)
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

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

struct vor_http;
struct vor_request;
struct vor_waker;
struct vor_route; /**< server/api/routes.h */

enum vor_method { VOR_GET, VOR_HEAD, VOR_POST, VOR_DELETE, VOR_OPTIONS, VOR_METHOD_COUNT };

enum vor_step { VOR_STEP_HEAD, VOR_STEP_BODY, VOR_STEP_WAKE };

enum vor_next {
    VOR_NEXT_REPLY, /**< one of vor_reply_* was called */
    VOR_NEXT_BODY,  /**< only from HEAD, after vor_request_take_body */
    VOR_NEXT_WAIT,  /**< call me when woken, or when the peer leaves */
    VOR_NEXT_STAY   /**< call me when woken; the peer may leave, or have left, all the same */
};

typedef enum vor_next (*vor_handler)(void *ctx, struct vor_request *request, enum vor_step step);

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

/** Limits and deadlines; seconds unless named otherwise. */
struct vor_http_options {
    const char *host; /**< numeric address or name to bind */
    unsigned port;    /**< 0: any free one */
    const char *path; /**< of a Unix socket instead; NULL or "" for none */
    unsigned mode;    /**< of that socket: who may connect, 0660 */
    unsigned threads;
    unsigned connections; /**< as many at a time, without streams; when they are more, the oldest
                               silent ones are cut, and 32 more are let in for health checks */
    unsigned streams;     /**< as many besides */
    unsigned each;        /**< connections of one address, if not loopback's or a trusted proxy's */
    double header_seconds;    /**< from accept, or from the request line on a kept connection */
    double keep_seconds;      /**< a kept connection may idle this long */
    double body_seconds;      /**< for the whole body */
    double body_idle_seconds; /**< between two pieces of it */
    double body_rate;         /**< bytes a second on average, after body_idle_seconds */
    double reply_rate;        /**< the same of who reads a reply, streams excepted */
    double beat_seconds;      /**< between two signs of life of a stream */
    const struct vor_networks *trusted; /**< proxies that are believed; borrowed */
    enum vor_proxy_headers proxy_headers;
    vor_handler handler; /**< the first one; routes.c hands on to the others */
    void *ctx;
    /** Makes the reply of a refusal, with one of vor_reply_bytes. */
    void (*refuse)(void *ctx, struct vor_request *request, const struct vor_refusal *refusal);
    /** Called once a request is over, with what the log wants to know. */
    void (*done)(void *ctx, const struct vor_request *request);
    /** A line of the library's own log. */
    void (*log)(void *ctx, const char *line);
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

/* --- what a handler reads --------------------------------------------------------------------- */

/** VOR_METHOD_COUNT for a method that no route has. */
enum vor_method vor_request_method(const struct vor_request *request);

/** Raw path as sent, without the query; it begins with '/'. */
const char *vor_request_path(const struct vor_request *request);

/** First value of a header (any case), or NULL. */
const char *vor_request_header(const struct vor_request *request, const char *name);

/** The next value of a header that may come on several lines; *index starts at 0. NULL after the
 *  last. */
const char *vor_request_header_next(const struct vor_request *request, const char *name,
                                    unsigned *index);

/** Decoded query pair number `index`; NULL past the last. */
const char *vor_request_query_name(const struct vor_request *request, unsigned index);
const char *vor_request_query_value(const struct vor_request *request, unsigned index);

/** First value of a query name, or NULL. */
const char *vor_request_query(const struct vor_request *request, const char *name);

/** X-Request-Id if the client sent a sane one (1 .. 64 of [A-Za-z0-9._-]), else one of ours. */
const char *vor_request_id(const struct vor_request *request);

/** Our step of the trace that the header traceparent names; none where there is no sound one, or
 *  several. Never NULL. */
const struct vor_span *vor_request_span(const struct vor_request *request);

/** Never NULL; of a request whose head is malformed it has the peer's address alone. */
const struct vor_via *vor_request_via(const struct vor_request *request);

/** Declared Content-Length, or -1. */
int64_t vor_request_length(const struct vor_request *request);

/** True once the peer has closed its side. A reply must be made all the same. */
int vor_request_gone(const struct vor_request *request);

/** The limit that keeps this request from being served, connections or each of vor_http_options; 0
 *  when there is room. */
unsigned vor_request_excess(const struct vor_request *request);

/** True once vor_http_close_waiting was called: wait no longer. */
int vor_request_closing(const struct vor_request *request);

/** For the router and the log. */
void vor_request_set_route(struct vor_request *request, const struct vor_route *route);
const struct vor_route *vor_request_route(const struct vor_request *request);
/** Notes who sent the request (copied). Until then it is a caller without name and scopes. */
void vor_request_set_principal(struct vor_request *request, const struct vor_principal *principal);
const struct vor_principal *vor_request_principal(const struct vor_request *request);
/** Notes which job the request is about; the text (up to 39 bytes) is copied. "" until then. */
void vor_request_set_job(struct vor_request *request, const char *job);
const char *vor_request_job(const struct vor_request *request);
/** Notes the slug of the problem that is replied (a static text); NULL until then. */
void vor_request_set_problem(struct vor_request *request, const char *slug);
const char *vor_request_problem(const struct vor_request *request);
int vor_request_status(const struct vor_request *request);
uint64_t vor_request_bytes_in(const struct vor_request *request);
uint64_t vor_request_bytes_out(const struct vor_request *request);
double vor_request_seconds(const struct vor_request *request);

/** The handler's own state, freed by `release` (may be NULL) once the request is over or gets
 *  another state. */
void vor_request_set_state(struct vor_request *request, void *state, void (*release)(void *state));
void *vor_request_state(const struct vor_request *request);

/** What the conditions of a GET or HEAD (RFC 9110, 13.2.2) leave of a reply of 200 with this entity
 *  tag: 200, 304 or 412. Each such reply that has an ETag becomes that by itself, 304 with the
 * headers of the 200; handlers ask where they would do in vain what it takes. */
int vor_request_condition(const struct vor_request *request, const char *etag);

/* --- the body --------------------------------------------------------------------------------- */

/** Where a body goes, piece by piece, on the HTTP thread. write returns 0; or it ends the request
 *  while the body is still arriving, by an HTTP status (507), which is answered as that problem, or
 *  by -1 after one of vor_reply_bytes. */
struct vor_body_sink {
    void *ctx;
    int (*write)(void *ctx, const void *bytes, size_t size);
};

/** Asks for the body: pieces go to sink, at most `limit` bytes. A longer one, declared or not, is
 *  a 413 at once. Call in HEAD and return VOR_NEXT_BODY. sink->ctx must live as long as the state.
 */
void vor_request_take_body(struct vor_request *request, const struct vor_body_sink *sink,
                           uint64_t limit);

/* --- waiting ---------------------------------------------------------------------------------- */

/** What another thread holds to call a waiting request back. It outlives the request: waking one
 *  whose request is over does nothing. Take one for each holder. */
struct vor_waker *vor_request_waker(struct vor_request *request);
void vor_waker_wake(struct vor_waker *waker);
void vor_waker_drop(struct vor_waker *waker); /**< waker may be NULL */

/** Wakes the request that many seconds from now (to a tenth of a second), once; of several calls
 * the earliest counts. Of many requests that are due together some wake a little later, so that new
 *  ones are served in between. From any thread, as long as the request lives. */
void vor_request_wake_after(struct vor_request *request, double seconds);

/* --- answering: exactly one of these, from within a step -------------------------------------- */

/** Adds a header to the reply; values with control bytes are dropped whole. */
void vor_reply_header(struct vor_request *request, const char *name, const char *value);

/** Closes the connection after the reply. */
void vor_reply_close(struct vor_request *request);

/** size bytes of media type (NULL for none); the bytes are copied. */
void vor_reply_bytes(struct vor_request *request, int http, const char *media_type,
                     const void *bytes, size_t size);

/** length bytes of a file from offset; the descriptor is taken over. */
void vor_reply_file(struct vor_request *request, int http, const char *media_type, int fd,
                    uint64_t offset, uint64_t length);

/** A stream of so many bytes, or of VOR_LENGTH_UNKNOWN. read fills up to size bytes and returns how
 *  many; 0: nothing yet (it is asked again once a waker wakes the request), -1: the end, which cuts
 *  a reply whose length is known. It runs on an HTTP thread and must not block; the request's state
 *  is alive throughout. */
#define VOR_LENGTH_UNKNOWN UINT64_MAX
void vor_reply_stream(struct vor_request *request, int http, const char *media_type,
                      uint64_t length,
                      long (*read)(void *ctx, struct vor_request *request, char *out, size_t size),
                      void *ctx);

#endif
