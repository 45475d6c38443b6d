/** The folder of bytes whose jobs are not known any more, because the table of jobs was damaged:
 * kept for people to look at, for some time and up to some size. */
#ifndef VOR_SERVER_BLOB_DIR_LOST_H
#define VOR_SERVER_BLOB_DIR_LOST_H

#include "core/base/status.h"
#include "server/blob/driver.h"

/** Moves a file out of `keep` into `lost` beside it (made if missing), dated now.
 *
 *  @param[in] parent  descriptor of the folder that both are in
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_dir_set_aside(int parent, int keep, const char *file,
                                           struct vor_error *err);

/** Drops what was set aside before `oldest_ms`, and of the rest the oldest while they are more than
 *  `bytes`. Then moves the dates of those left by shift_ms, as the wall clock has moved.
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_dir_trim_lost(int parent, const struct vor_lost_bounds *bounds,
                                           struct vor_error *err);

#endif
