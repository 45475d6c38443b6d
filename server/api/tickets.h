/** Tickets: links to one result that need no key, for a short time. A ticket says what it is good
 *  for, and is signed: nothing is kept of it but the secret of this start of the daemon, so that a
 *  restart ends all of them; or that of the store, so that each daemon takes those of the others.
 */
#ifndef VOR_SERVER_API_TICKETS_H
#define VOR_SERVER_API_TICKETS_H

#include "core/base/status.h"
#include "server/base/base64.h"
#include "server/base/uuid.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    VOR_TICKET_SECONDS = 60, /**< for which a ticket is good */
    VOR_TICKET_OUTPUT_MAX = 32,
    VOR_TICKET_BYTES_MAX = 160,
    VOR_TICKET_SIZE = VOR_BASE64_SIZE(VOR_TICKET_BYTES_MAX) /**< of the text, with its NUL */
};

struct vor_tickets;

/** @retval VOR_E_IO     the kernel gives no random numbers
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_tickets_create(struct vor_tickets **out, struct vor_error *err);

/** Signs with the secret of a store (vor_store_secret) from now on, if it has one, and goes by the
 *  wall clock. Before other threads know the tickets. */
void vor_tickets_share(struct vor_tickets *tickets, const char *secret);

/** The second that it is for tickets. */
double vor_tickets_now(const struct vor_tickets *tickets);

/** tickets may be NULL. */
void vor_tickets_destroy(struct vor_tickets *tickets);

/** Writes a ticket to an output (VOR_TICKET_OUTPUT_MAX - 1 bytes at most) of a job. `now` is
 *  vor_tickets_now: where no other daemon takes it, no jump of the wall clock makes a ticket longer
 *  or shorter. Returns out. */
const char *vor_ticket_write(const struct vor_tickets *tickets, const struct vor_uuid *job,
                             const char *output, double now, char out[VOR_TICKET_SIZE]);

/** True when it is a ticket of ours to this output of this job, and not over. */
bool vor_ticket_check(const struct vor_tickets *tickets, const char *ticket,
                      const struct vor_uuid *job, const char *output, size_t length, double now);

#endif
