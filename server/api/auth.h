/** Who sent a request, by the key or the ticket that came with it, and whether he may send it. */
#ifndef VOR_SERVER_API_AUTH_H
#define VOR_SERVER_API_AUTH_H

#include "server/api/app.h"
#include "server/base/address.h"

/** Finds out who sent a request for a route of that scope (request->principal from then on): the
 *  owner of the key in "Authorization: Bearer KEY" or "X-API-Key: KEY"; the holder of a ticket to
 *  the result that is asked for; anybody if the daemon has no keys, or the route needs none.
 *
 *  @return true, or false after a problem has been replied: unauthorized (no key, or none of ours),
 *          forbidden (the key lacks the scope, which is named) */
bool vor_auth_check(struct vor_request *request, enum vor_scope scope);

/** Whose jobs a request is about: the name of its key; NULL when it sees the jobs of all. */
const char *vor_auth_tenant(const struct vor_request *request);

/** With whom the caller shares threads: callers with a key share by key, the others by address. */
struct vor_fairness_key vor_auth_fairness_key(const struct vor_request *request);

#endif
