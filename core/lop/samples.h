/** Oriented points: what the projection makes and the insertion adds to. */
#ifndef VOR_LOP_SAMPLES_H
#define VOR_LOP_SAMPLES_H

#include "core/base/memory.h"

#include <stddef.h>

/** Spacings that points keep from each other. The projection's repulsion is a share of less than a
 *  half of the distance, so that two points which the same data draw come nearer with each step
 * until they are one: 522 of 20,000 of autzen by ear, 3,061 nearer than 0.1 spacings; with this
 * bound 0 and 316. Nearer to another, a point no longer stays on an edge (of scannet to 20,000, 53
 * points for 187 are nearer than 0.1), and one at a border is pushed out all the same when points
 * are evened out, as it lies at the rim of a cluster (29 for 169 of autzen). At 0.3,
 * 0.4 and 0.5 for the three / at 0.4, points nearer than 0.1 and 0.3 spacings to another: autzen
 * and scannet to 8,000 6, 71 and 6, 42 / 10, 74 and 2, 48, kitti to 5,000 35, 175 / 33, 180. */
#define VOR_LOP_CLOSE 0.4

/** Fewest points that others are inserted between, and fewest of one side, each itself among them,
 *  that say where it runs. */
enum { VOR_LOP_FEWEST = 4 };

/** Points, each itself among them, to the farthest of which the area around it is measured. */
enum { VOR_LOP_AREA_OF = 12 };

/** Coordinates are those of the domain; normals are unit vectors that face outwards. */
struct vor_lop_samples {
    struct vor_memory *memory;
    size_t n, room; /**< points that there are, and that fit */
    float *xyz;     /**< room x 3 */
    float *normal;  /**< room x 3 */
    float *area;    /**< of data (lop/normals.h), n; else NULL */
};

/** Makes room for points; there are none yet.
 *
 *  @param[out] out  free with vor_lop_samples_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 24 room bytes do not fit */
VOR_NODISCARD vor_status vor_lop_samples_init(struct vor_lop_samples *out, size_t room,
                                              struct vor_memory *memory, struct vor_error *err);

/** Frees the points; samples may be all zero. */
void vor_lop_samples_free(struct vor_lop_samples *samples);

#endif
