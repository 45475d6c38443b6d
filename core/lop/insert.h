/** Edge-preserving upsampling (the stage `insert` of a run): points are inserted one by one where
 *  the samples leave the most room, and put onto the surface that these describe, up to its edges.
 *
 *  Source: Huang et al. 2013, "Edge-aware point set resampling", Sec. 5. Each step takes, of all
 *  pairs of near points, the one with the largest priority P = (2 - n_i . n_j)^rho C, where C is
 *  the orthogonal clearance of its midpoint: the distance to the nearest line through a point along
 *  its normal. The point is put onto the latent surface from there (lop/latent.h). One queue holds
 *  all pairs. While normals stand, priorities only fall, so that the first pair of the queue whose
 *  priority still holds is the one: nothing else is computed anew. Of equal priorities comes the
 *  pair whose later point came first, then that with the smaller partner. A pair whose base no side
 *  of the latent surface holds (lop/latent.h) comes after all others; unless gaps are filled, also
 *  one whose point would hang in the air (lop/beside.h). Of 30 rows of shapes with edges, noise of
 *  0.3 spacings, points facing inward without / with this 462 / 367.
 *
 *  Departure: normals more than 90 degrees apart count as 90 in P: most of them are those of bad
 *  fits, which came first.
 *  Departure: a pair belongs to its later point. Points inserted look for partners within
 *  VOR_LOP_PARTNERS clearances, not sigma_p, and each keeps its VOR_LOP_PAIRS best: what is near
 * enough to matter, however dense the points become. Points that face away from both of a pair do
 * not count: those of the other side of a thin plate.
 *
 *  The order of insertion is the definition, so that insertion runs on one thread; the first pairs
 *  are found on all. */
#ifndef VOR_LOP_INSERT_H
#define VOR_LOP_INSERT_H

#include "core/input/domain.h"
#include "core/lop/beside.h"
#include "core/lop/samples.h"
#include "core/seeds/outcome.h"

enum {
    /** Pairs that a point keeps. At 4 / 6 / 12, fandisk, 22,000 to 120,000: delta 0.097 / 0.093 /
     *  0.090, CPU 1.0 / 1.15 / 1.3 s. */
    VOR_LOP_PAIRS = 6
};

/** Clearances within which a point inserted looks for partners, and spacings of the samples within
 *  which these do: the gap along an edge is about two wide. At 1.8 / 2.2 / 2.5 for the first, as
 *  above: delta 0.097 / 0.093 / 0.094, CPU 0.98 / 1.15 / 1.25 s. Spacings are local, but no less
 *  than that of an even spread: fandisk30k_noise2 to 120,000, from the true edge to the nearest
 *  point 1.58e-3, and 1.63e-3 by local ones alone. */
#define VOR_LOP_PARTNERS 2.2
/** Those of samples where gaps are filled. */
#define VOR_LOP_REACH_FILL 6.0
/** Two samples have no pair if one of them reaches no more than this part of the way: a stray far
 * from all others has a wide spacing, and the others are none of its neighbours. */
#define VOR_LOP_REACH_PART 0.5
/** Part of a pair's length along the mean of its normals, above which one point lies on a sheet
 * over the other's. On a sphere it is 0, and up to 0.71 over an edge of 90 degrees. */
#define VOR_LOP_STACKED 0.72

/** How points are inserted. */
struct vor_lop_insert_how {
    double rho;      /**< >= 0: how much more edges get than faces; 0: as much */
    double sigma_n;  /**< radians, up to pi / 2: normals that far apart belong to two sides */
    double spacing;  /**< of the samples, at least; they have clusters with gaps between them */
    double sigma_p;  /**< > 0: radius within which samples say where the surface is */
    int fill;        /**< gaps of a few spacings are filled; else only what the spacing spans */
    uint32_t polish; /**< steps that even the points out in the end (lop/even.h) */
    const struct vor_spec *spec;  /**< read: seed; delta and seconds, by the polish */
    struct vor_lop_beside beside; /**< where points that hang in the air are put, each time
                                     before the polish lists neighbours and in the end */
};

/** Inserts points until there are n, or none if there are as many. The points before stay as they
 *  are, but for the polish. Once the run is stopped, what is missing is put between neighbours
 *  (lop/between.h), and nothing is polished.
 *
 *  @param[in,out] samples  at least 4 points, within [-1, 1]; their arrays grow as needed
 *  @param[in]     domain   read for the unit of what is told
 *  @param[in,out] told     the stages are added, of INSERT the points that were not put between;
 *                          stopped, which may be so already
 *  @param[in]     run      may be stopped
 *
 *  @retval VOR_E_CANCELLED  the watch answered VOR_CANCEL
 *  @retval VOR_E_DEGENERATE no two points are far enough apart to have one between them
 *  @retval VOR_E_NOMEM      240 n bytes do not fit
 *
 *  O(n log n). The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lop_insert(struct vor_lop_samples *samples, size_t n,
                                        const struct vor_lop_insert_how *how,
                                        const struct vor_domain *domain, struct vor_outcome *told,
                                        const struct vor_run *run, struct vor_error *err);

#endif
