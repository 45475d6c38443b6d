/** What proxies say of a request: who sent it, and by which address it was reached.
 *
 *  The proxies that are believed are those of the given networks; what anybody else says is ignored
 *  wholly. The hops are walked from the last one: as long as the address at hand is such a proxy's,
 *  the entry that it added tells who came before it. So the client is the rightmost address that is
 *  no trusted proxy's, and what a client writes into these headers itself is never reached.
 *
 *  An entry that cannot be read, or that hides its address (`unknown`, `_name`), ends the walk: the
 *  client is then the last proxy that could be named. nginx's real_ip_recursive does the same
 *  (1.22.1, asked with the lists of tests/unit/forwarded_test.c). A line of Forwarded that breaks
 *  its grammar is ignored, with all lines before it; so are a scheme other than http and https, a
 *  host and a prefix that are none, as tusd does. A request is never refused for these headers:
 *  they are the proxy's, and its client could not mend them.
 *
 *  Pure functions on strings. */
#ifndef VOR_SERVER_HTTP_FORWARDED_H
#define VOR_SERVER_HTTP_FORWARDED_H

#include "server/base/address.h"
#include "server/http/http.h"
#include "server/http/request_check.h"

enum { VOR_HOPS_MAX = 16 /**< entries that are looked at, from the last one */ };

/** Fills *out for a request with this head, which has passed the request check, that came from
 * `peer`.
 *
 *  x-forwarded: X-Forwarded-For is walked; of -Proto, -Host and -Prefix the last entry counts,
 * which is the one that the peer itself wrote or let through. forwarded (RFC 7239): of `proto` and
 * `host` those that the outermost trusted proxy gave; there is no prefix. The headers of the other
 * family are not looked at: a proxy that sets one lets its client's other one through.
 *
 *  O(bytes of the head). */
void vor_forwarded_read(struct vor_via *out, const struct vor_head *head,
                        const struct vor_address *peer, const struct vor_networks *trusted,
                        enum vor_proxy_headers family);

#endif
