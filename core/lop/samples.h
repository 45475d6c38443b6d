/** Oriented points: what the projection makes and the insertion adds to. */
#ifndef VOR_LOP_SAMPLES_H
#define VOR_LOP_SAMPLES_H

#include "core/base/memory.h"

#include <stddef.h>

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
