/** When results expire, whatever is done to the wall clock. Rows say it in wall time, which jumps.
 *
 *  While the daemon lives it knows how much time has passed: when the wall clock moves by more than
 *  that, the expiry of every row, and the date of every lost file, is moved along, so that each
 *  keeps the time that it had left.
 *
 *  A start knows only the newest time in the store. If the clock is an hour ahead of that, the
 *  daemon was down that long, or the clock is wrong; if it is behind, it is wrong. Then nothing
 *  expires, and nothing is moved, until the clock fits, or an hour has passed and it is believed.
 *
 *  The functions are for the sweeper's thread. */
#ifndef VOR_SERVER_WORK_CALENDAR_H
#define VOR_SERVER_WORK_CALENDAR_H

#include "server/work/live.h"

/** At the start, before the first row is changed.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_calendar_begin(struct vor_worker *worker, struct vor_error *err);

/** Looks for a jump and moves what it would expire. True when rows may expire now.
 *
 *  Cost: none without a jump; else a change of every row. */
int vor_calendar_look(struct vor_worker *worker);

#endif
