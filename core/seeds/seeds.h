/** The seeds, their neighbours among themselves, and what every method computes for one of them:
 * local surface, patch, restricted Voronoi cell. */
#ifndef VOR_SEEDS_H
#define VOR_SEEDS_H

#include "core/base/run.h"
#include "core/geom/boundary.h"
#include "core/input/domain.h"
#include "core/knn/input_lists.h"
#include "core/knn/point_lists.h"
#include "core/seeds/scratch.h"
#include "core/spec.h"

#define VOR_SEEDS_BLOCK 256    /* seeds a task; also the unit of the sums */
#define VOR_SEEDS_LISTED 20    /* neighbours in the list of each seed */
#define VOR_SEEDS_MORE_MAX 256 /* neighbours looked at when those do not secure a cell */

/** What is kept of a seed's last fit. */
struct vor_last_fit {
    struct vor_surface surface;
    float place[3];             /**< where the seed was */
    uint16_t k;                 /**< input points it was fitted to, or is to be; 0: not known yet */
    unsigned char interior : 1; /**< no border of the input is near that place */
    unsigned char layered : 1;  /**< fitted to one sheet of several */
    unsigned char refined : 1;  /**< a finer fit was tried */
};

/** How the cells of all seeds are made; chosen once. */
struct vor_seeds_policy {
    int keep_border; /**< cells end where the input ends, and points stay inside it */
    double widen;    /**< patches are this many times as wide as usual */
};

/** n points on the domain, in its normalised coordinates. */
struct vor_seeds {
    const struct vor_domain *domain; /**< that surfaces are fitted to: the whole, or some of it */
    const struct vor_domain *whole;  /**< that the seeds are to end on */
    struct vor_run run; /**< that a stop does not cut short; loops that it may, have their own */
    size_t n;
    struct vor_seeds_policy policy;
    float *xyz;                         /**< n x 3 */
    struct vor_input_lists input_lists; /**< candidates among the input, for each seed */
    struct vor_last_fit *last_fit;      /**< n */
    struct vor_point_lists point_lists; /**< neighbours among the seeds */
    struct vor_point_lists_view view;   /**< of xyz, as of the last index */
    double area; /**< of the surface, from the draw that these seeds were started from */
    struct vor_disc flat, disc, fine; /**< patches, by how much they bend */
    struct vor_scratch *scratch;      /**< one for each thread of the pool */
};

/** n >= 1 seeds with unset positions. A fit takes as many points as domain->known says, lowered to
 *  the size of the domain. The domain must outlive them, and so must run's watches.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_seeds_init(struct vor_seeds *out, const struct vor_domain *domain,
                                        size_t n, struct vor_seeds_policy policy,
                                        const struct vor_run *run, struct vor_error *err);

/** Cells as a request wants them. */
static inline struct vor_seeds_policy vor_seeds_policy_of(const struct vor_spec *spec)
{
    return (struct vor_seeds_policy){spec->value[VOR_PARAM_BOUNDARY] == VOR_BOUNDARY_KEEP, 1};
}

/** seeds may be all zero. */
void vor_seeds_free(struct vor_seeds *seeds);

/** From now on surfaces are fitted to `domain`: the whole one, or at least seeds->input_lists.wide
 * of its points. What is known of the input around the seeds is forgotten, what they know of each
 * other stays. */
void vor_seeds_onto(struct vor_seeds *seeds, const struct vor_domain *domain);

/** Takes note of where the seeds are now, and makes their lists anew where too many moved too far
 * for the old ones; positions must not change while cells are computed.
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for */
VOR_NODISCARD vor_status vor_seeds_index(struct vor_seeds *seeds, const struct vor_run *run,
                                         struct vor_error *err);

/** Gathers scratch->here for seed i, wherever that is by now. Only one thread at a time may ask for
 * i. */
enum vor_surface_kind vor_seeds_fit(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i);

/** When a last fit still serves. */
struct vor_recall {
    double radius;  /**< no edge within it, then none is looked for */
    double slack;   /**< input spacings that a seed may move from its last fit */
    int keep_holes; /**< holes are told from gaps of the sampling (vor_attach) */
    int refine;     /**< vor_seeds_refine is tried */
};

/** As vor_seeds_fit, but content with the last fit where that found the seed inside the input, no
 *  border within how->radius of it, and it moved by at most how->slack since; scratch->interior
 *  says so, and then scratch->here.near is not set. scratch->onto is the fit, refined where
 *  how->refine asks for it. */
enum vor_surface_kind vor_seeds_recall(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                       size_t i, const struct vor_recall *how);

/** Fits *surface, that of scratch->here around seed i, to fewer neighbours where k allows it and
 *  vor_surface_refine finds that better. Returns whether it did. */
int vor_seeds_refine(const struct vor_seeds *seeds, const struct vor_scratch *scratch, size_t i,
                     struct vor_surface *surface);

/** scratch->crowd, as of the last index. Only one thread at a time may ask for i. */
void vor_seeds_crowd(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i);

/** The same, but content with those within `distance`, in no order. */
void vor_seeds_within(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                      double distance);

/** The cell of seed i in scratch->cell, from scratch->here and scratch->crowd: out of a patch as
 * fine as the surface bends, or where `flat` out of the tangent plane. */
void vor_seeds_clip(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i, int flat);

/** vor_seeds_fit, vor_seeds_crowd and vor_seeds_clip, unless the kind is NONE. */
enum vor_surface_kind vor_seeds_cell(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                     size_t i);

/** The mesh for a patch of scratch->radius on the surface of scratch->here. */
const struct vor_disc *vor_seeds_disc(const struct vor_seeds *seeds,
                                      const struct vor_scratch *scratch);

/** Gathers a place of the scratch, there or foot, around any x, by a search of its own. */
enum vor_surface_kind vor_seeds_fit_at(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                                       struct vor_place *place, const double x[3]);

/** A tangential offset of about that length for two seeds that lie at the same place, opposite for
 *  (j, i), so that they part: from what i and j are, nothing else. */
void vor_seeds_part(size_t i, size_t j, double length, double offset[2]);

/** Sums over the workers. */
struct vor_counts vor_seeds_counts(const struct vor_seeds *seeds);

/** What is known of the border around x, where `place`, here or there, was gathered. */
void vor_seeds_border(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                      const struct vor_place *place, struct vor_border *border, const double x[3]);

/** Moves x, near seed i, which scratch->here was gathered around, straight back towards the input
 * where it lies too far into a hole or beyond an edge of a regular input. Returns whether it did.
 */
int vor_seeds_hold(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                   double x[3]);

/** Whether surfaces are fitted to all of what the seeds are to end on. */
static inline int vor_seeds_on_whole(const struct vor_seeds *seeds)
{
    return seeds->domain == seeds->whole;
}

/** Position of seed i in double. */
static inline void vor_seeds_position(const struct vor_seeds *seeds, size_t i, double x[3])
{
    for (size_t c = 0; c < 3; c++)
        x[c] = (double)seeds->xyz[3 * i + c];
}

#endif
