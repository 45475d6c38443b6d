/** The input made ready for the methods: normalised, sorted, without coincident points, indexed. */
#ifndef VOR_INPUT_DOMAIN_H
#define VOR_INPUT_DOMAIN_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/input/conditioning.h"
#include "core/knn/knn.h"

/** Point i of the domain is point source[i] of the input (the first of those that coincide); the
 *  input's relative position is xyz * unit + shift. unit is a power of two, so that scaling loses
 *  nothing; every |xyz| <= 1. */
struct vor_domain {
    struct vor_memory *memory;
    size_t n;
    float *xyz;       /**< n x 3, in Morton order */
    uint32_t *source; /**< n */
    double shift[3];
    double unit;
    double sparse;       /**< the input is hardly anywhere sparser: distance to the sixth neighbour,
                              the 999th of 1,000 of an even sample */
    struct vor_knn *knn; /**< over xyz */
    struct vor_conditioning known; /**< of the input that these points are, or are some of */
};

/** Normalises, sorts and indexes a cloud. Nothing is known of it yet: a fit takes
 *  VOR_NEIGHBORS_FEWEST points. On the run's pool; the domain allocates from the run's memory and
 *  keeps neither the run nor in.
 *
 *  @retval VOR_E_DEGENERATE fewer than four distinct points, or all on a line
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n). The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_domain_init(struct vor_domain *out, const struct vor_cloud *in,
                                         const struct vor_run *run, struct vor_error *err);

/** Indexes the n >= 1 points that are in xyz, and finds how sparse they are.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_domain_index(struct vor_domain *domain, const struct vor_run *run,
                                          struct vor_error *err);

/** True where positions are as the input has them, and not moved off a lattice. */
static inline int vor_domain_is_exact(const struct vor_domain *domain)
{
    return domain->known.off_lattice == 0;
}

void vor_domain_free(struct vor_domain *domain);

#endif
