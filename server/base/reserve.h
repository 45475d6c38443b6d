/** A file that keeps room on a disk, to be given up by halves when the disk is full: what must be
 * written then (that a job ended, was removed, goes back into line) finds room, and so does the
 * start after it. Thread-safe. */
#ifndef VOR_SERVER_BASE_RESERVE_H
#define VOR_SERVER_BASE_RESERVE_H

#include "core/base/status.h"

#include <stdint.h>

struct vor_reserve;

/** A reserve at `path`, of the size that a file there has, if there is one; no file is made.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_reserve_open(struct vor_reserve **out, const char *path,
                                          struct vor_error *err);

/** The file stays; of one that is spent, what an opening takes is made again. reserve may be NULL.
 */
void vor_reserve_close(struct vor_reserve *reserve);

/** Asks for a file of `bytes` (0: none, and one that is there goes) and makes it if there is room.
 */
void vor_reserve_want(struct vor_reserve *reserve, uint64_t bytes);

/** Makes the file if it is missing and there is twice the room, so that what was given up is not
 *  taken back from whoever it was given up for.
 *
 *  @retval VOR_OK    it is there, or none is wanted
 *  @retval VOR_E_IO  it is not (vor_error_storage_full tells a full disk apart)
 *
 *  Cost: none when it is there; else that of allocating it: not for HTTP threads. */
VOR_NODISCARD vor_status vor_reserve_make(struct vor_reserve *reserve, struct vor_error *err);

/** True when something failed because the disk is full, and there is room for another try now: half
 * of the reserve was given up. It may be NULL.
 *
 *  @param[in] is_opening  takes the last part too, which is left to the next opening otherwise */
int vor_reserve_made_room(struct vor_reserve *reserve, int is_opening, vor_status status,
                          const struct vor_error *err);

/** @retval VOR_E_IO as vor_reserve_make, without trying: for HTTP threads. reserve may be NULL */
VOR_NODISCARD vor_status vor_reserve_check(struct vor_reserve *reserve, struct vor_error *err);

#endif
