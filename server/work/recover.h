/** Recovery: puts in order what a former life of the daemon left. Jobs come first, before anybody
 *  is answered; files are tidied up later, on the sweeper's thread. */
#ifndef VOR_SERVER_WORK_RECOVER_H
#define VOR_SERVER_WORK_RECOVER_H

#include "server/work/live.h"

/** Every row that ran in another life waits again when this returns, in its place, however many the
 *  queue takes. One whose bytes are gone, or whose request cannot be read, fails once it is
 * claimed. Also notes which blobs there are, for vor_worker_drop_strays. Call before any other
 * thread knows the worker.
 *
 *  On a disk without a byte rows cannot be put in order. Then they stay as they are, which the log
 *  says, nothing is accepted, and vor_worker_recover_late does it later.
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM
 *
 *  Cost: a change of the store and a read, however many jobs wait. */
VOR_NODISCARD vor_status vor_worker_recover(struct vor_worker *worker, struct vor_error *err);

/** Does that if there is room by now. The sweeper's, each time it looks. */
void vor_worker_recover_late(struct vor_worker *worker);

/** Drops the blobs that were there at the start and that no row needs; or sets them aside, with a
 *  warning, when the store has lost rows: it says so itself, or there are more results without any
 *  row than a crash leaves. Rows of uploads that are missing, or not whole, keep none from then on.
 *  Ends early when the daemon goes down; the next start does the rest.
 *
 *  Cost: a read of the store for each blob, and of the rows that keep uploads. */
void vor_worker_drop_strays(struct vor_worker *worker);

#endif
