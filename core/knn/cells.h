/** Points that come one by one, by cubes of space in a hash table: whether one is near a place. */
#ifndef VOR_KNN_CELLS_H
#define VOR_KNN_CELLS_H

#include "core/base/memory.h"
#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** All zero but for memory and wide: no points. Owns its arrays. */
struct vor_cells {
    struct vor_memory *memory;
    double wide; /**< side of a cube, > 0 */
    size_t n, room;
    float *xyz;      /**< room x 3 */
    uint32_t *next;  /**< room: the next point whose cube has the same hash */
    size_t entries;  /**< of the table: a power of two, at least as many as there is room */
    uint32_t *first; /**< entries */
};

/** Makes room for so many points, that the table need not be made again until then.
 *
 *  @retval VOR_E_NOMEM  20 to 24 bytes a point do not fit; there are the points of before
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_cells_reserve(struct vor_cells *cells, size_t room,
                                           struct vor_error *err);

/** Adds a point.
 *
 *  @retval VOR_E_NOMEM  as vor_cells_reserve
 *
 *  O(1) in the mean over many. */
VOR_NODISCARD vor_status vor_cells_add(struct vor_cells *cells, const float x[3],
                                       struct vor_error *err);

/** Whether a point is nearer to x than radius. O(1) where that is about `wide`, and few points
 * share a cube. */
int vor_cells_has(const struct vor_cells *cells, const float x[3], double radius);

void vor_cells_free(struct vor_cells *cells);

#endif
