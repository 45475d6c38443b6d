/** The loops of edges that have one triangle. */
#ifndef VOR_MESH_RIMS_H
#define VOR_MESH_RIMS_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Loops; loop l goes through point[start[l]] .. point[start[l + 1] - 1] and back to the first. */
struct vor_rims {
    struct vor_memory *memory;
    size_t count;
    size_t *start;   /**< count + 1 */
    uint32_t *point; /**< start[count] */
};

/** Finds the loops. Where several meet at a point, each goes on to the edge across the gap that it
 *  came along, as seen in the tangent plane.
 *
 *  @param[out] out  free with vor_rims_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 4 bytes a point and 21 for each edge of a loop do not fit
 *
 *  O(n), one thread. */
VOR_NODISCARD vor_status vor_rims_find(struct vor_rims *out, const struct vor_complex *complex,
                                       const struct vor_sheet *sheet, struct vor_error *err);

/** rims may be all zero. */
void vor_rims_free(struct vor_rims *rims);

#endif
