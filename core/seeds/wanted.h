/** The spacing that each seed is to have, where the request has a density (input/density.h), and
 *  how evenly the seeds follow it.
 *
 *  With a density, uniformity is that of the distances to the nearest neighbour over the value of
 *  the field there. They are lengths: the distances that an even spread of as many points would
 *  have. */
#ifndef VOR_SEEDS_WANTED_H
#define VOR_SEEDS_WANTED_H

#include "core/input/field.h"
#include "core/metrics/uniformity.h"

#include <string.h>

/** The field around each seed; owns the arrays. All zero: no density. */
struct vor_wanted {
    const struct vor_field *field; /**< borrowed */
    size_t n;
    struct vor_field_near *near; /**< n */
    float *value;                /**< n: value at each seed, as of the last vor_wanted_renew */
    float *scratch;              /**< n */
};

/** Makes room for n seeds; does nothing where field is all zero.
 *
 *  @param[out] out  free with vor_wanted_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 40 n bytes do not fit */
VOR_NODISCARD vor_status vor_wanted_init(struct vor_wanted *out, const struct vor_field *field,
                                         size_t n, struct vor_memory *memory,
                                         struct vor_error *err);

/** wanted may be all zero. */
void vor_wanted_free(struct vor_wanted *wanted, struct vor_memory *memory);

/** Takes the values at xyz (n x 3); searches the field anew for seeds that have left the place that
 *  theirs was found at. Does nothing without a density.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n) at worst, mostly O(n), on the run's pool. The same values for any number of threads.
 */
VOR_NODISCARD vor_status vor_wanted_renew(struct vor_wanted *wanted, const float *xyz,
                                          const struct vor_run *run, struct vor_error *err);

/** Value of the field at seed i, as of the last vor_wanted_renew; 1 without a density. */
static inline double vor_wanted_at(const struct vor_wanted *wanted, size_t i)
{
    return wanted->value != NULL ? (double)wanted->value[i] : 1;
}

/** Computes how even seeds at xyz (n x 3), near those of the last vor_wanted_renew, are from their
 *  distances to the nearest neighbour. There is a density. O(n). Cannot fail. */
void vor_wanted_uniformity(struct vor_uniformity *out, const struct vor_wanted *wanted,
                           const float *nearest, const float *xyz);

#endif
