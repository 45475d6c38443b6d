/** Seeds joined by triangles: the front advances, and loops that it leaves are closed. */
#ifndef VOR_MESH_JOIN_H
#define VOR_MESH_JOIN_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Adds triangles.
 *
 *  @param[in,out] complex  over the seeds of the sheet; a manifold, as it was
 *  @param[in,out] sheet    receives `crowded` (mesh/crowded.h)
 *  @param[in]     times    that the front advances, anew around loops that could not be closed
 *  @param[in,out] filled   the triangles that closed loops are added to it
 *
 *  @retval VOR_E_NOMEM 190 bytes a seed do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool, half of it on one thread. The same triangles for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_join(struct vor_complex *complex, struct vor_sheet *sheet, int times,
                                  uint64_t *filled, struct vor_error *err);

#endif
