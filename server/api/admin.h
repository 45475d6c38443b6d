/** The second listener, for the operator: GET of /livez, /readyz and /metrics, and nothing else. It
 *  has threads and connections of its own, so it answers while the first one is overrun. */
#ifndef VOR_SERVER_API_ADMIN_H
#define VOR_SERVER_API_ADMIN_H

#include "server/api/app.h"

/** From then on a thread that speaks HTTP counts as stuck: /livez says so, and systemd's watchdog
 * is not told that all is well. No step of a request takes a hundredth of it. */
enum { VOR_STUCK_SECONDS = 10 };

/** Handler of the second listener. */
enum vor_next vor_admin_dispatch(struct vor_request *request, enum vor_step step);

/** Its line in the log: of level debug, as every look at it makes one. */
void vor_admin_done(const struct vor_request *request);

#endif
