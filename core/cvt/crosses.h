/** A cross at each seed: the directions of least and greatest curvature, without telling them
 * apart.
 *
 *  Where the surface bends alike in all directions, or hardly, curvature shows no directions, or
 *  those of noise. There the crosses of the seeds around decide, by a weighted mean that is taken
 *  again and again. A cross is kept as the fourfold of its angle in the plane of its seed, as a
 *  vector: cos 4a and sin 4a times its certainty. So the sign and the order of the directions do
 *  not matter, and crosses may be added up.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 * methods", Sec. 5.3, takes the principal directions as they are. Departure: they are completed as
 * "N-way rotational symmetry" fields are: Palacios and Zhang 2007, "Rotational symmetry field
 * design on surfaces". */
#ifndef VOR_CVT_CROSSES_H
#define VOR_CVT_CROSSES_H

#include "core/base/run.h"
#include "core/geom/surface.h"

/** Crosses of n seeds; owns everything. */
struct vor_crosses {
    struct vor_memory *memory;
    size_t n;
    double *own;  /**< n x 3: what curvature says, times its weight, and the weight */
    double *now;  /**< n x 2 */
    double *next; /**< n x 2: after a round */
    float *kept;  /**< n x 3: one direction in space, as long as it is certain; 0 at first */
};

/** @param[out] out  free with vor_crosses_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 68 n bytes do not fit */
VOR_NODISCARD vor_status vor_crosses_init(struct vor_crosses *out, size_t n,
                                          struct vor_memory *memory, struct vor_error *err);

/** crosses may be all zero. */
void vor_crosses_free(struct vor_crosses *crosses);

/** The surface around a seed. */
struct vor_cross_fit {
    const struct vor_surface *surface;
    unsigned k;   /**< points that it was fitted to */
    double at[3]; /**< the seed, in the surface's local coordinates */
};

/** Sets what the surface around seed i says of its cross, and the cross to what it was before, or
 *  to that the first time.
 *
 *  @param[in] axes  two orthonormal tangents and the normal at the seed, in world axes
 *
 *  O(1). Depends on nothing but its arguments and the cross before. */
void vor_crosses_set(struct vor_crosses *crosses, size_t i, const struct vor_cross_fit *fit,
                     const double axes[9]);

/** Takes means with the crosses around, once: at 4 and 16 times, and more the first time, the
 * middle of wide flat faces changes by less than with the seed.
 *
 *  @param[in] axes   n x 9, those that the crosses were set with
 *  @param[in] near   n x width, of each seed those around it; the first `take` of them count
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(take n), on the run's pool. The same crosses for any number of threads. */
VOR_NODISCARD vor_status vor_crosses_smooth(struct vor_crosses *crosses, const double *axes,
                                            const uint32_t *near, unsigned width, unsigned take,
                                            const struct vor_run *run, struct vor_error *err);

/** Turns the two tangents in axes, those that cross i was set with, into its directions, and keeps
 *  them for the next time. O(1). */
void vor_crosses_turn(struct vor_crosses *crosses, size_t i, double axes[9]);

#endif
