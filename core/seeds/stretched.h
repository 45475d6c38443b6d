/** The metric at each seed, where the request has one (input/anisotropy.h).
 *
 *  The distance of two seeds is that in the mean of their metrics; a cell is clipped in the metric
 *  of its own seed (geom/stretch.h). */
#ifndef VOR_SEEDS_STRETCHED_H
#define VOR_SEEDS_STRETCHED_H

#include "core/base/run.h"
#include "core/geom/stretch.h"
#include "core/input/tensor.h"
#include "core/knn/point_lists.h"

/** Spacings, in the metric if there is one, that hard repulsion extends to (seeds/repel.h), and
 *  within which a list holds all seeds. The force beyond it is below a 290th of that at one
 * spacing. At 1.25 / 1.5 / 2 only searches change: on autzen 192 / 198 / 214 thousand. */
#define VOR_HARD_REACH 1.5

/** The metric around each seed; owns the array. All zero: lengths count the same everywhere. */
struct vor_stretched {
    const struct vor_tensors *field; /**< borrowed */
    size_t n;
    struct vor_tensor_near *near; /**< n, as of the last vor_stretched_renew */
};

/** True when there is a metric. */
static inline int vor_stretched_are(const struct vor_stretched *stretched)
{
    return stretched->near != NULL;
}

/** Makes room for n seeds; does nothing where field is all zero.
 *
 *  @param[out] out  free with vor_stretched_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 56 n bytes do not fit */
VOR_NODISCARD vor_status vor_stretched_init(struct vor_stretched *out,
                                            const struct vor_tensors *field, size_t n,
                                            struct vor_memory *memory, struct vor_error *err);

/** stretched may be all zero. */
void vor_stretched_free(struct vor_stretched *stretched, struct vor_memory *memory);

/** Takes the metric at xyz (n x 3): anew for seeds that have left the place that theirs was found
 *  at. Does nothing without a metric.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n) at worst, mostly O(n), on the run's pool. The same for any number of threads. */
VOR_NODISCARD vor_status vor_stretched_renew(struct vor_stretched *stretched, const float *xyz,
                                             const struct vor_run *run, struct vor_error *err);

/** Seeds that a list must hold to have all that are near in the metric, where `listed` do without
 *  one: at most VOR_POINT_LISTS_LISTED_MAX. */
unsigned vor_stretched_listed(const struct vor_tensors *field, unsigned listed);

/** Replaces the distances of seed i to its neighbours by those in the mean of the two metrics; does
 *  nothing without a metric. O(neighbours). Cannot fail. Thread-safe. */
void vor_stretched_distances(struct vor_crowd *crowd, const struct vor_stretched *stretched,
                             const float *xyz, size_t i);

/** Replaces the neighbours of seed i by those of them that are nearest in its metric, with their
 *  distances there.
 *
 *  @param[in,out] crowd    nearest first, before and after; at most NEAR_IN_METRIC (stretched.c)
 *                          are left
 *  @param[in]     xyz      positions of the seeds
 *  @param[in]     surface  around seed i
 *  @param[in]     stretch  of that surface for the metric of seed i
 *
 *  O(neighbours). Cannot fail. Thread-safe. */
void vor_stretched_crowd(struct vor_crowd *crowd, const float *xyz, size_t i,
                         const struct vor_surface *surface, const struct vor_stretch *stretch);

/** How much longer than in the metric a distance from seed i may be, for the seeds beside it; 1
 *  without a metric. */
static inline double vor_stretched_longest(const struct vor_stretched *stretched, size_t i)
{
    return stretched->near != NULL ? sqrt((double)stretched->near[i].aspect) : 1;
}

/** The same for any two seeds; also how much shorter the mean distance to the nearest seed may be
 *  than without a metric. */
static inline double vor_stretched_longest_of_all(const struct vor_stretched *stretched)
{
    return stretched->near != NULL ? sqrt(stretched->field->most) : 1;
}

/** Square of the length of the offset d from seed i to seed j; of d alone without a metric. */
static inline double vor_stretched_length2(const struct vor_stretched *stretched, size_t i,
                                           size_t j, const double d[3])
{
    const float *a, *b;
    double g[6] = {0};

    if (stretched->near == NULL)
        return vor_dot(d, d);
    a = stretched->near[i].tensor;
    b = stretched->near[j].tensor;
    for (int c = 0; c < 6; c++)
        g[c] = ((double)a[c] + (double)b[c]) / 2;
    return vor_metric_length2(g, d);
}

#endif
