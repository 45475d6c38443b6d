/** Points of an earlier result, which a run continues: where they were, and which they are. */
#ifndef VOR_INPUT_PREVIOUS_H
#define VOR_INPUT_PREVIOUS_H

#include "core/cloud/cloud.h"

/** n points in the domain's frame. All zero: there is no earlier result. */
struct vor_previous {
    struct vor_memory *memory;
    size_t n;
    float *xyz;      /**< n x 3 */
    uint32_t *track; /**< n */
    float *bent;     /**< n: how far the surface took them apart from one motion of all */
    uint32_t unused; /**< the first number greater than each of them */
};

/** Takes the points of an earlier result.
 *
 *  The attribute "track" says which points they are, in whole numbers from 0 to 2147483649, each
 *  once. Without it point i is number i.
 *
 *  @param[out] out       free with vor_previous_free; untouched on failure
 *  @param[in]  from      checked (vor_cloud_check)
 *  @param[in]  middle    in the result, (x - middle) / unit stands for x
 *
 *  @retval VOR_E_PARAM the attribute has other values
 *  @retval VOR_E_NOMEM 28 bytes a point do not fit
 *
 *  O(n log n), on one thread. */
VOR_NODISCARD vor_status vor_previous_take(struct vor_previous *out, const struct vor_cloud *from,
                                           const double middle[3], double unit,
                                           struct vor_memory *memory, struct vor_error *err);

/** previous may be all zero. */
void vor_previous_free(struct vor_previous *previous);

#endif
