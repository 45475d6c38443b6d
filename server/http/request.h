/** One request: what came, where it stands, and the reply that the handler described. Its functions
 *  that handlers call are in http.h. */
#ifndef VOR_SERVER_HTTP_REQUEST_H
#define VOR_SERVER_HTTP_REQUEST_H

#include "server/http/http.h"
#include "server/http/request_check.h"

#include <stdbool.h>

struct MHD_Connection;

enum { VOR_REPLY_FIELDS_MAX = 24 }; /**< header fields of a reply */

enum vor_request_stage {
    VOR_AT_NEW,    /**< the request line is in */
    VOR_AT_HEAD,   /**< the head passed; the handler has not seen it */
    VOR_AT_BODY,   /**< pieces go to the sink */
    VOR_AT_WAIT,   /**< the handler waits to be woken */
    VOR_AT_REPLIED /**< a reply is recorded */
};

enum vor_reply_kind { VOR_REPLY_NONE, VOR_REPLY_BYTES, VOR_REPLY_FILE, VOR_REPLY_STREAM };

/** A reply as the handler described it; exchange.c turns it into the library's. */
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
    struct vor_conn *conn; /**< NULL when not guarded */
    struct vor_waker *waker;
    struct vor_head head;
    char *target, *path, *query; /**< owned; path is target up to '?', query is decoded in place */
    const char *block;           /**< where the library has the target; valid in the first step */
    const char *line; /**< and the request line; NULL: not known, or what follows was given back */
    struct vor_field pairs[VOR_QUERY_MAX];
    int pair_count;
    enum vor_method method;
    enum vor_request_stage stage;
    char id[72];
    struct vor_span span;
    struct vor_address from; /**< of the connection */
    struct vor_via via;
    struct vor_principal principal; /**< nobody until the router has found out */
    char job[40];                   /**< that it is about, or "" */
    const char *problem;            /**< slug of the problem replied, or NULL; static */
    const struct vor_route *route;
    double began;
    int64_t length;
    struct vor_body_sink sink;
    uint64_t limit, received, sent;
    bool whole; /**< the body was taken and is in */
    void *state;
    void (*release)(void *state);
    struct vor_reply reply;
};

/** The method of that word; VOR_METHOD_COUNT when no route knows it. */
enum vor_method vor_method_find(const char *word);

/** Takes in the header traceparent. */
void vor_request_trace(struct vor_request *request);

/** Cuts the target into path and query and decodes the pairs; false when vor_query_split does not
 *  take them. */
bool vor_request_split(struct vor_request *request);

#endif
