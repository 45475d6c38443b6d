/** The first handler of every request: who may ask, and which handler answers (route_table.h). */
#ifndef VOR_SERVER_API_ROUTES_H
#define VOR_SERVER_API_ROUTES_H

#include "server/api/route_table.h"

#include <stdio.h>

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

#endif
