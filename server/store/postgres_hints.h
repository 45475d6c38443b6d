/** Daemons that share the tables tell each other that something has changed, by NOTIFY. It is a
 * hint: whoever misses one, or has no such connection, polls. The connection is one of its own,
 * because a NOTIFY within a change would have all changes of the server wait for each other, and a
 * direct one, because poolers in transaction mode forget who listens. Only the other files of the
 * driver include this. Thread-safe. */
#ifndef VOR_SERVER_STORE_POSTGRES_HINTS_H
#define VOR_SERVER_STORE_POSTGRES_HINTS_H

#include "core/base/status.h"

struct vor_postgres_hints;

/** Connects, and listens on a thread of its own. Once that connection breaks it is made anew, after
 *  1 s, and ever more up to 30 s, as long as the server refuses.
 *
 *  @param[out] out    free with vor_postgres_hints_close
 *  @param[in]  where  as --store has it; copied
 *  @param[in]  heard  called on that thread when another daemon has told something, or may have
 *
 *  @retval VOR_E_IO the server refuses (message: its reason, never a password)
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_postgres_hints_open(struct vor_postgres_hints **out, const char *where,
                                                 void (*heard)(void *ctx), void *ctx,
                                                 struct vor_error *err);

/** Nothing is heard after that; hints may be NULL. */
void vor_postgres_hints_close(struct vor_postgres_hints *hints);

/** Has all others told that something has changed: at once, but at most once in 250 ms. Quick. */
void vor_postgres_hints_tell(struct vor_postgres_hints *hints);

#endif
