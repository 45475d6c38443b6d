/** The energy of all seeds' flat cells while their planes, metrics, patches and walls stand still,
 *  as a function of the places of the seeds in their planes: what core/opt/lbfgs.h minimises.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 * methods", Sec. 4.2 and 4.3.3; the energy of a cell is that of geom/energy.h. Departure: the patch
 * is PATCH times as wide as the paper's, as its seed may leave the middle, and wider where the
 * metric is stretched. A seed does not go farther from the middle than REACH.
 *
 *  Lengths are in spacings of an even spread, so that powers of eight stay near 1. */
#ifndef VOR_CVT_FROZEN_H
#define VOR_CVT_FROZEN_H

#include "core/cvt/crosses.h"
#include "core/geom/energy.h"
#include "core/seeds/seeds.h"

/** Seeds around that may cut a cell. */
#define VOR_FROZEN_NEAR 40
/** Most of them that do: the gradient leaves out others. */
#define VOR_FROZEN_CUT 16

/** A seed's plane. */
struct vor_frozen_plane {
    struct vor_energy_plane flat; /**< its radius is 0 where the seed has no surface, and stays */
    double reach;                 /**< how far from the middle the seed may go */
};

/** Sums over all cells, of which lengths are in spacings, and over the ways that seeds went. */
struct vor_frozen_sums {
    double area, energy; /**< the energy is Xiao's: p is 2, M is 1 */
    double moved;        /**< longest way of a seed; normalised */
    uint64_t plane, left, held;
};

/** Flags of a seed: held back at the border, now and ever. */
enum { VOR_FROZEN_HELD = 1, VOR_FROZEN_HELD_EVER = 2 };

/** The function. Owns its arrays. */
struct vor_frozen {
    struct vor_seeds *seeds;
    const struct vor_run *run; /**< of the evaluations: a stop may end them */
    unsigned power;            /**< p */
    int crossed;               /**< axes follow crosses */
    int set;                   /**< times that planes were set; 0: crosses are unknown */
    int bent;                  /**< bend is that of these planes */
    double spacing;            /**< of an even spread, normalised: the unit here */
    struct vor_crosses crosses;
    struct vor_frozen_plane *plane; /**< n */
    double *middle;                 /**< n x 3: where the seeds were */
    double *axes;                   /**< n x 9: two tangents and the normal */
    uint32_t *near;                 /**< n x width, the nearest first */
    unsigned width;
    double *bend;    /**< n x 2: about the second derivatives, from the first evaluation on */
    double *place;   /**< n x 3: of the seeds, in space */
    double *value;   /**< n: of each cell; after vor_frozen_take its aspect, the root of the ratio
                          of its second moments */
    uint32_t *cut;   /**< n x VOR_FROZEN_CUT: seeds that a cell depends on */
    double (*by)[2]; /**< n x VOR_FROZEN_CUT: gradient in their places in their planes */
    unsigned char *cuts;          /**< n: how many */
    struct vor_frozen_sums *sums; /**< of blocks */
};

/** Makes room. The seeds must outlive it; `crossed`: axes follow the directions of curvature.
 *
 *  @param[out] out  free with vor_frozen_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 800 n bytes do not fit */
VOR_NODISCARD vor_status vor_frozen_init(struct vor_frozen *out, struct vor_seeds *seeds,
                                         int crossed, struct vor_error *err);

/** frozen may be all zero. */
void vor_frozen_free(struct vor_frozen *frozen);

/** Takes planes, metrics, patches and walls where the seeds are now. The places in the planes are
 *  then 0, but for seeds that share a place.
 *
 *  @param[in]  power  p, even, 2 .. VOR_ENERGY_POWER_MAX
 *  @param[out] y      n x 2: places in the planes
 *  @param[in]  run    of this and of the evaluations that follow
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n). The same for any number of threads. */
VOR_NODISCARD vor_status vor_frozen_set(struct vor_frozen *frozen, unsigned power, double *y,
                                        const struct vor_run *run, struct vor_error *err);

/** Computes the energy and its gradient (n x 2) at y, a vor_lbfgs_function's at; ctx is the
 *  vor_frozen. O(n), on the run's pool. The same bits for any number of threads.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_frozen_at(void *ctx, const double *y, double *value, double *gradient,
                                       struct vor_error *err);

/** A vor_lbfgs_function's shorten: no seed leaves its reach. */
void vor_frozen_shorten(void *ctx, const double *y, double *step);

/** Moves the seeds to y, onto the surface around there and inside the input.
 *
 *  @param[in,out] held  n flags: VOR_FROZEN_HELD and the other
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  the seeds are in a state between */
VOR_NODISCARD vor_status vor_frozen_take(struct vor_frozen *frozen, const double *y,
                                         unsigned char *held, struct vor_frozen_sums *sums,
                                         struct vor_error *err);

#endif
