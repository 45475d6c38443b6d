/** ^C and its like: from vor_interrupt_catch on, SIGINT and SIGTERM only leave a note. */
#ifndef VOR_CLI_INTERRUPT_H
#define VOR_CLI_INTERRUPT_H

#include "core/base/status.h"

/** From here on SIGINT and SIGTERM only leave a note. */
void vor_interrupt_catch(void);

/** The signal that came since, or 0. Cheap; any thread. */
int vor_interrupt_seen(void);

/** Fails as cancelled.
 *
 *  @retval VOR_E_CANCELLED always */
VOR_NODISCARD vor_status vor_interrupt_fail(struct vor_error *err);

#endif
