/** ^C and its like: from vor_interrupt_catch on, SIGINT and SIGTERM only leave a note. While there
 * is a best result to keep, the first SIGINT asks for it, and only a second one cancels. */
#ifndef VOR_CLI_INTERRUPT_H
#define VOR_CLI_INTERRUPT_H

#include "core/base/status.h"

/** From here on SIGINT and SIGTERM only leave a note. */
void vor_interrupt_catch(void);

/** The signal that cancels, or 0. Cheap; any thread. */
int vor_interrupt_seen(void);

/** From here on the first SIGINT asks to stop and keep the best result; one that came before has
 *  cancelled. */
void vor_interrupt_keep_best(void);

/** True once a SIGINT has asked for the best result. Cheap; any thread. */
int vor_interrupt_stops(void);

/** Fails as cancelled.
 *
 *  @retval VOR_E_CANCELLED always */
VOR_NODISCARD vor_status vor_interrupt_fail(struct vor_error *err);

#endif
