/** The input made ready for the methods: normalised, sorted, without coincident points, indexed. */
#ifndef VOR_INPUT_DOMAIN_H
#define VOR_INPUT_DOMAIN_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
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
    int sheets;          /**< fits look for layers; set by vor_sheets_find */
    int rounded;         /**< its points were moved off a lattice, and so are not exact; set by
                              vor_lattice_smooth */
};

/** On the run's pool; the domain allocates from the run's memory and keeps neither the run nor in.
 *
 *  @retval VOR_E_DEGENERATE fewer than four distinct points, or all on a line
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_domain_init(struct vor_domain *out, const struct vor_cloud *in,
                                         const struct vor_run *run, struct vor_error *err);

/** Some of the points of `in`, with an index of their own: a gap (normalised) from
 * those kept before them in the order, every other one within a gap of a kept one. Where
 * that are more than half of them, *out is empty. The same points for any number of threads. O(n).
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_domain_thin(struct vor_domain *out, const struct vor_domain *in,
                                         double gap, const struct vor_run *run,
                                         struct vor_error *err);

void vor_domain_free(struct vor_domain *domain);

#endif
