/** Which handler answers which method at which path: one table, which openapi.yaml is compared
 *  with; and the handlers that come before all others. */
#ifndef VOR_SERVER_API_ROUTE_TABLE_H
#define VOR_SERVER_API_ROUTE_TABLE_H

#include "server/api/app.h"

#include <stdio.h>

#define VOR_CODES_SUBMIT                                                                           \
    "200 201 400 401 403 404 406 408 409 410 413 415 422 429 500 503 507" /* of every way to start \
                                                                             a job */

#define VOR_CODES_FRAMES "200 400 401 403 404 406 408 410 413 415 422 429 500 503 507"

/** Routes: method, path, scope of the key that they need (OPEN: none), handler, statuses besides
 *  those that the HTTP layer may give to any request (400 framing, 403 Host and Origin, 503
 *  connections). A {segment} matches anything but nothing. GET brings HEAD along, every path
 *  OPTIONS. Each process that HTTP offers (VOR_PROCESS_TABLE) has a route POST /v1/PROCESS besides.
 *  A row without statuses is the route of the path without the slash under another name, which
 *  openapi.yaml cannot have: what makes clients of it takes no path that ends in a slash. */
#define VOR_ROUTE_TABLE(X)                                                                         \
    X(GET, "/", OPEN, vor_handle_root, "200 304")                                                  \
    X(GET, "/assets/{asset}", OPEN, vor_handle_asset, "200 304 404")                               \
    X(GET, "/livez", OPEN, vor_handle_livez, "200")                                                \
    X(GET, "/readyz", OPEN, vor_handle_readyz, "200 503")                                          \
    X(GET, "/version", OPEN, vor_handle_version, "200")                                            \
    X(GET, "/openapi.yaml", OPEN, vor_handle_openapi, "200 304")                                   \
    X(GET, "/openapi.json", OPEN, vor_handle_openapi, "200 304")                                   \
    X(GET, "/docs", OPEN, vor_handle_docs, "200")                                                  \
    X(GET, "/problems/{slug}", OPEN, vor_handle_problem, "200 404")                                \
    X(GET, "/v1", READ, vor_handle_landing, "200 401 403")                                         \
    X(GET, "/v1/", READ, vor_handle_landing, "")                                                   \
    X(GET, "/v1/processes", READ, vor_handle_processes, "200 401 403")                             \
    X(GET, "/v1/processes/{processID}", READ, vor_handle_process, "200 401 403 404")               \
    X(POST, "/v1/processes/{processID}/execution", SUBMIT, vor_handle_submit, VOR_CODES_SUBMIT)    \
    X(POST, "/v1/processes/{processID}/frames", SUBMIT, vor_handle_sequence, VOR_CODES_FRAMES)     \
    X(GET, "/v1/jobs", READ, vor_handle_jobs, "200 400 401 403 503")                               \
    X(GET, "/v1/jobs/{jobID}", READ, vor_handle_job, "200 304 401 403 404 410 503")                \
    X(DELETE, "/v1/jobs/{jobID}", SUBMIT, vor_handle_dismiss, "200 401 403 404 503 507")           \
    X(POST, "/v1/jobs/{jobID}/stop", SUBMIT, vor_handle_stop, "202 401 403 404 409 503")           \
    X(GET, "/v1/jobs/{jobID}/events", READ, vor_handle_events, "200 204 400 401 403 404 503")      \
    X(GET, "/v1/events", READ, vor_handle_events_of_many, "200 204 400 401 403")                   \
    X(GET, "/v1/jobs/{jobID}/input", READ, vor_handle_input,                                       \
      "200 206 304 401 403 404 410 416 500 503")                                                   \
    X(GET, "/v1/jobs/{jobID}/preview", READ, vor_handle_preview, "200 304 400 401 403 404 503")    \
    X(GET, "/v1/jobs/{jobID}/results", READ, vor_handle_results,                                   \
      "200 400 401 403 404 406 410 413 422 500 503")                                               \
    X(GET, "/v1/jobs/{jobID}/results/{output}", READ, vor_handle_result,                           \
      "200 206 304 307 400 401 403 404 406 410 413 416 422 429 500 503 507")                       \
    X(POST, "/v1/jobs/{jobID}/tickets", READ, vor_handle_ticket,                                   \
      "201 400 401 403 404 410 413 422 500 503")                                                   \
    X(GET, "/v1/jobs/{jobID}/trace", READ, vor_handle_trace, "200 401 403 404 503")

#define VOR_ROUTE_HANDLER(method, path, scope, handler, codes)                                     \
    enum vor_next handler(struct vor_request *request, enum vor_step step);
VOR_ROUTE_TABLE(VOR_ROUTE_HANDLER)
#undef VOR_ROUTE_HANDLER

struct vor_route {
    enum vor_method method;
    const char *path;
    enum vor_scope scope; /**< of the key that it needs */
    vor_handler handler;
    const char *codes;
};

/** "METHOD PATH SCOPE CODE CODE ..." a line. */
void vor_routes_print(FILE *out);

/** The first handler of every request: Host, Origin, CORS, method and path, key; then the route's.
 */
enum vor_next vor_route_dispatch(struct vor_request *request, enum vor_step step);

/** A refusal of the HTTP layer as a problem, and the line of the access log. */
void vor_route_refuse(struct vor_request *request, const struct vor_refusal *refusal);
void vor_route_done(const struct vor_request *request);

/* The second listener, for the operator: GET of /livez, /readyz and /metrics, and nothing else. It
 * has threads and connections of its own, so it answers while the first one is overrun. */

/** From then on a thread that speaks HTTP counts as stuck: /livez says so, and systemd's watchdog
 * is not told that all is well. No step of a request takes a hundredth of it. */
enum { VOR_STUCK_SECONDS = 10 };

/** Handler of the second listener. */
enum vor_next vor_admin_dispatch(struct vor_request *request, enum vor_step step);

/** Its line in the log: of level debug, as every look at it makes one. */
void vor_admin_done(const struct vor_request *request);

#endif
