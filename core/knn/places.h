/** Points by the place that they are in, where many share one. */
#ifndef VOR_KNN_PLACES_H
#define VOR_KNN_PLACES_H

#include "core/base/memory.h"
#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** The places of points, in the order of the first point of each; owns its arrays. All zero where
 *  no place is crowded. */
struct vor_places {
    struct vor_memory *memory;
    size_t n;        /**< places */
    float *xyz;      /**< n x 3 */
    uint32_t *first; /**< n + 1: the points of place i begin at first[i] in `point` */
    uint32_t *point; /**< all points by place, those of a place in their order */
};

/** Finds the places of n points (n x 3 floats, all finite). Points whose distances square to
 * nothing in float32 may be told as in one place.
 *
 *  @param[out] out   free with vor_places_free; all zero if no place has more than `many` points,
 * or on failure
 *  @param[in]  many  most points of a place that is not crowded
 *
 *  @retval VOR_E_NOMEM  24 n bytes while it runs, or 20 n of places, do not fit
 *
 *  O(n), one thread. Of points whose hashes were made to collide some in one place may be told as
 * in several. */
VOR_NODISCARD vor_status vor_places_find(struct vor_places *out, const float *xyz, size_t n,
                                         size_t many, struct vor_memory *memory,
                                         struct vor_error *err);

/** Frees the arrays; places may be all zero. */
void vor_places_free(struct vor_places *places);

#endif
