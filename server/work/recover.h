/** Putting back in order what a former life of the daemon left. */
#ifndef VOR_SERVER_WORK_RECOVER_H
#define VOR_SERVER_WORK_RECOVER_H

#include "server/work/live.h"

/** Puts what waited or ran back into the queue, and drops bytes that no row needs. Before any other
 *  thread knows the worker.
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_worker_recover(struct vor_worker *worker, struct vor_error *err);

#endif
