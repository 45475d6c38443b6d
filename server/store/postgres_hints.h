/** Daemons that share the tables tell each other by NOTIFY that something has changed. That is only
 *  a hint: a daemon that misses one, or has no such connection, finds the change by polling. The
 *  connection is a separate one, because a NOTIFY inside a change would make all changes on the
 *  server wait for each other. It is direct, because poolers in transaction mode lose track of
 * which client listens. Only the other files of the driver include this. Thread-safe. */
#ifndef VOR_SERVER_STORE_POSTGRES_HINTS_H
#define VOR_SERVER_STORE_POSTGRES_HINTS_H

#include "core/base/status.h"

struct vor_postgres_hints;

/** Connects, and listens on a thread of its own. A connection that breaks is made again after 1 s;
 *  as long as the server refuses, the pauses double, up to 30 s.
 *
 *  @param[out] out    free with vor_postgres_hints_close
 *  @param[in]  where  as --store has it; copied
 *  @param[in]  heard  called on that thread when another daemon has sent a hint, or may have
 *
 *  @retval VOR_E_IO the server refuses (message: its reason, never a password)
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_postgres_hints_open(struct vor_postgres_hints **out, const char *where,
                                                 void (*heard)(void *ctx), void *ctx,
                                                 struct vor_error *err);

/** `heard` is not called after that; hints may be NULL. */
void vor_postgres_hints_close(struct vor_postgres_hints *hints);

/** Sends the other daemons a hint at once, but at most one in 250 ms. Does not wait. */
void vor_postgres_hints_tell(struct vor_postgres_hints *hints);

#endif
