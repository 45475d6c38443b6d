/** The energy of all seeds' flat cells while their planes stand still, as a function of the places
 * of the seeds in these: what core/opt/lbfgs.h minimises.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 4.3.3; the energy of a cell is that of geom/energy.h. Lengths are in spacings, as
 *  those of the planes. */
#ifndef VOR_CVT_FROZEN_H
#define VOR_CVT_FROZEN_H

#include "core/cvt/planes.h"

/** Sums over all cells, of which lengths are in spacings, and over the ways that seeds went. */
struct vor_frozen_sums {
    double area, energy; /**< the energy is Xiao's: p is 2, M is 1 */
    double moved;        /**< longest way of a seed; normalised */
    uint64_t plane, left, held;
};

/** Flags of a seed: held back at the border, now and ever. */
enum { VOR_FROZEN_HELD = 1 << 0, VOR_FROZEN_HELD_EVER = 1 << 1 };

/** The function. Owns its arrays. */
struct vor_frozen {
    struct vor_seeds *seeds;
    struct vor_planes planes;
    const struct vor_run *run; /**< of the evaluations: a stop may end them */
    int bent;                  /**< bend is that of these planes */
    double *bend;    /**< n x 2: about the second derivatives, from the first evaluation on */
    double *value;   /**< n: of each cell; after vor_frozen_take its aspect, the root of the ratio
                          of its second moments */
    uint32_t *cut;   /**< n x VOR_POLYGON_MAX: seeds that a cell depends on */
    double (*by)[2]; /**< n x VOR_POLYGON_MAX: gradient in their places in their planes */
    unsigned char *cuts;          /**< n: how many */
    struct vor_frozen_sums *sums; /**< of blocks */
};

/** Makes room. The seeds must outlive it; `crossed`: axes follow the directions of curvature.
 *
 *  @param[out] out  free with vor_frozen_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 960 n bytes do not fit */
VOR_NODISCARD vor_status vor_frozen_init(struct vor_frozen *out, struct vor_seeds *seeds,
                                         int crossed, struct vor_error *err);

/** frozen may be all zero. */
void vor_frozen_free(struct vor_frozen *frozen);

/** Takes planes, metrics, patches and walls where the seeds are now. The places in the planes are
 *  then 0, but for seeds that share a place.
 *
 *  @param[in]  power  p, even
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
