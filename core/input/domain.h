/** The input made ready for the methods: normalised, sorted, without coincident points, indexed. */
#ifndef VOR_INPUT_DOMAIN_H
#define VOR_INPUT_DOMAIN_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/geom/graph.h"
#include "core/input/conditioning.h"
#include "core/input/field.h"
#include "core/input/previous.h"
#include "core/input/tensor.h"
#include "core/knn/knn.h"

/** Parts of the input with few points, clear of all others (input/islands.h). Island i has points
 *  member[first[i]] .. member[first[i + 1] - 1] of the domain. */
struct vor_islands {
    size_t count, points; /**< islands, and the points that they hold */
    uint32_t *first;      /**< count + 1 */
    uint32_t *member;     /**< points */
};

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
    double sparse;       /**< largest spacing that is believed: a quantile of the distances to the
                              sixth neighbour, lone points left out (SPARSE_SHARE and LONE_GAP in
                              domain.c) */
    double usual6;       /**< median of the distances to the sixth neighbour */
    struct vor_knn *knn; /**< over xyz */
    struct vor_graph graph;        /**< neighbours on the same sheet, where they were asked for
                                        (input/adjacency.h) */
    struct vor_islands islands;    /**< that were taken out: their points follow the n others in xyz
                                      and source, unless all of the input is islands */
    struct vor_field field;        /**< spacing wanted, where a density was asked for; of the whole
                                        input only (input/density.h) */
    struct vor_tensors tensors;    /**< metric, where one was asked for; likewise
                                        (input/anisotropy.h) */
    struct vor_previous previous;  /**< points of an earlier result, where they were given; of the
                                        whole input only */
    struct vor_conditioning known; /**< of the input; a thinned domain has that of the whole, and
                                        sheets of its own */
};

/** Normalises, sorts and indexes a cloud. `known` says that a fit takes VOR_NEIGHBORS_FEWEST
 *  points, and nothing else. The domain allocates from the run's memory and refers to neither run
 *  nor in.
 *
 *  @param[out] out  free with vor_domain_free; untouched on failure
 *  @param[in]  in   checked (vor_cloud_check); borrowed for the call
 *
 *  @retval VOR_E_DEGENERATE fewer than four distinct points, or all on a line
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool; 60 bytes a point. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_domain_init(struct vor_domain *out, const struct vor_cloud *in,
                                         const struct vor_run *run, struct vor_error *err);

/** Indexes the n >= 1 points in xyz, and sets sparse and usual6.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. */
VOR_NODISCARD vor_status vor_domain_index(struct vor_domain *domain, const struct vor_run *run,
                                          struct vor_error *err);

/** Checks that the points span more than a line.
 *
 *  @retval VOR_E_DEGENERATE fewer than four points, or all on a line
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_domain_check(const struct vor_domain *domain,
                                          const struct vor_run *run, struct vor_error *err);

/** Where point i is. */
static inline const float *vor_domain_point(const struct vor_domain *domain, size_t i)
{
    return &domain->xyz[3 * i];
}

/** k points, or all if they are fewer. */
static inline unsigned vor_domain_most(const struct vor_domain *domain, unsigned k)
{
    return k < domain->n ? k : (unsigned)domain->n;
}

/** Where a point of the input, given by its relative position, lies in the domain's frame; in float
 *  as vor_domain_init has it. */
static inline void vor_domain_normalise(const struct vor_domain *domain, const float in[3],
                                        float out[3])
{
    double inverse = 1 / domain->unit; /* exact: a power of two, and not the smallest */

    for (int c = 0; c < 3; c++)
        out[c] = (float)(((double)in[c] - domain->shift[c]) * inverse);
}

/** Gives the points new positions, and indexes them again. They stay in their order, which should
 *  still be about that of Morton.
 *
 *  @param[in] xyz  domain->n x 3, allocated from domain->memory; the domain's from now on, whatever
 *                  is returned
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED  the domain is to be freed
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_domain_move(struct vor_domain *domain, float *xyz,
                                         const struct vor_run *run, struct vor_error *err);

/** True if no point was moved off a lattice: positions are those of the input. */
static inline int vor_domain_is_exact(const struct vor_domain *domain)
{
    return domain->known.off_lattice == 0;
}

/** Most places of a domain that say what is usual in it, at equal steps along its order: shares and
 *  medians are then within a percent. Points whose sixth neighbour is searched (vor_domain.sparse),
 * at 1024 / 4096 / 16384: the largest distance of the result to the input is 1.37 / 1.39 / 1.97
 *  spacings on autzen, 7.3 / 7.3 / 8.4 on kitti: all points leave more lone ones in. */
enum { VOR_DOMAIN_SAMPLED = 4096 };

/** Fewer points show neither outliers, as the neighbours of one are a tenth of all, nor a lattice:
 * a few gaps are multiples of some cell by chance. */
enum { VOR_DOMAIN_FEW = 200 };

/** Adds points to a domain without lists, sorts and indexes it again.
 *
 *  @param[in] xyz, source  count x 3 and count: as the domain has its own; copied
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED  the domain is to be freed
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_domain_add(struct vor_domain *domain, const float *xyz,
                                        const uint32_t *source, size_t count,
                                        const struct vor_run *run, struct vor_error *err);

/** Takes the points of an earlier result as domain->previous (vor_previous_take, which fails as
 *  said there). Does nothing if previous is NULL.
 *
 *  @param[in] in  the cloud that the domain was made of */
VOR_NODISCARD vor_status vor_domain_continue(struct vor_domain *domain, const struct vor_cloud *in,
                                             const struct vor_cloud *previous,
                                             struct vor_error *err);

/** Frees the points and the index; domain may be all zero. */
void vor_domain_free(struct vor_domain *domain);

#endif
