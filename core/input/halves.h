/** A domain, every second of its points, every fourth and so on, each with an index: where noise is
 *  wide, as many neighbours reach as far among fewer points. Points are left out in Morton order,
 *  and so evenly by density. */
#ifndef VOR_INPUT_HALVES_H
#define VOR_INPUT_HALVES_H

#include "core/input/domain.h"

enum { VOR_HALVES_SIZE = 16 };

/** Point i of level l is point i << l of the domain. */
struct vor_halves {
    struct vor_memory *memory;
    unsigned levels; /**< at least 1 */
    struct {
        size_t n;
        const float *xyz; /**< n x 3; that of the domain is borrowed */
        const struct vor_knn *knn;
    } level[VOR_HALVES_SIZE];
    float *own[VOR_HALVES_SIZE];
    struct vor_knn *index[VOR_HALVES_SIZE];
};

/** The domain alone, which is indexed and stays as it is while this lives. Cannot fail. */
void vor_halves_init(struct vor_halves *out, const struct vor_domain *domain);

/** Adds a level. Adds none if it would have fewer than `least` points or there are as many as can
 *  be.
 *
 *  @retval VOR_E_NOMEM 32 bytes a point of the level do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(points of the level), on the run's pool. */
VOR_NODISCARD vor_status vor_halves_add(struct vor_halves *halves, size_t least,
                                        const struct vor_run *run, struct vor_error *err);

void vor_halves_free(struct vor_halves *halves);

#endif
