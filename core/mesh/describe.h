/** What a mesh is like, for the report. */
#ifndef VOR_MESH_DESCRIBE_H
#define VOR_MESH_DESCRIBE_H

#include "core/mesh/complex.h"
#include "core/mesh/rims.h"
#include "core/report.h"

/** Sets quality and angle of a record: those of the triangles over points xyz. O(n), one thread. */
void vor_mesh_note(struct vor_record *record, const struct vor_complex *complex, const float *xyz);

/** Sets triangles, points, Euler characteristic, closed, manifold, quality, angle, loops
 *  and what is not sure.
 *
 *  @param[in] complex  turned
 *  @param[in] rims     its loops
 *
 *  @retval VOR_E_NOMEM 4 bytes a triangle do not fit
 *
 *  O(n log n), one thread. */
VOR_NODISCARD vor_status vor_mesh_describe(struct vor_report *report,
                                           const struct vor_complex *complex,
                                           const struct vor_rims *rims,
                                           const struct vor_sheet *sheet, struct vor_error *err);

#endif
