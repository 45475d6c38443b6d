/** Where other daemons share the store: what they do to jobs is seen here. */
#ifndef VOR_SERVER_WORK_MIRROR_H
#define VOR_SERVER_WORK_MIRROR_H

#include "server/work/live.h"

/** A live job that no runner here has becomes what its row says; ended and off the live ones if
 * that is over. */
VOR_NODISCARD vor_status vor_worker_mirror(struct vor_worker *worker, struct vor_job *job,
                                           struct vor_error *err);

/** The same with all live jobs; makes jobs wait again whose leases have ended, and counts what
 *  waits. For the sweeper; nothing where nobody shares the store. */
void vor_worker_follow_others(struct vor_worker *worker);

#endif
