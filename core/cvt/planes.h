/** What stands still in an inner loop of cvt/descend.h: the tangent plane of each seed, its metric,
 *  patch and wall, and the seeds around it.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 4.2 and 4.3.3.
 *
 *  Departure: the patch is a little narrower than the paper's, which reaches beyond borders, and
 *  longer where the metric is stretched, whose cells it would cut. A seed does not go far from the
 *  middle of its patch while that stands still.
 *
 *  Lengths are in spacings of an even spread, so that powers of eight stay near 1. */
#ifndef VOR_CVT_PLANES_H
#define VOR_CVT_PLANES_H

#include "core/cvt/crosses.h"
#include "core/geom/energy.h"
#include "core/seeds/seeds.h"

/** A seed's plane. */
struct vor_plane {
    struct vor_energy_plane flat; /**< its radius is 0 where the seed has no surface, and stays */
    double reach;                 /**< how far from the middle the seed may go */
};

/** The planes of n seeds; owns its arrays. */
struct vor_planes {
    struct vor_seeds *seeds;
    int crossed;    /**< axes follow crosses */
    double spacing; /**< of an even spread, normalised: the unit here */
    struct vor_crosses crosses;
    struct vor_plane *plane; /**< n */
    double *middle;          /**< n x 3: where the seeds were */
    double *axes;            /**< n x 9: two tangents and the normal */
    uint32_t *near;          /**< n x width, the nearest first */
    unsigned width;
    double *place; /**< n x 3: of the seeds, in space, as of the last vor_planes_place */
};

/** Makes room. The seeds must outlive it; `crossed`: axes follow the directions of curvature.
 *
 *  @param[out] out  free with vor_planes_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 420 n bytes do not fit */
VOR_NODISCARD vor_status vor_planes_init(struct vor_planes *out, struct vor_seeds *seeds,
                                         int crossed, struct vor_error *err);

/** planes may be all zero. */
void vor_planes_free(struct vor_planes *planes);

/** Takes the planes where the seeds are now, with the power p, even.
 *
 *  @param[out] y  n x 2: places in the planes, 0 but for seeds that share a place
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same for any number of threads. */
VOR_NODISCARD vor_status vor_planes_set(struct vor_planes *planes, unsigned power, double *y,
                                        const struct vor_run *run, struct vor_error *err);

/** Sets the place in space of seed i, which is at y (n x 2) in the planes. O(1). */
void vor_planes_place(struct vor_planes *planes, const double *y, size_t i);

/** The places of the `width` seeds around seed i in the coordinates of its plane. O(width). */
void vor_planes_localize(double (*other)[3], const struct vor_planes *planes, size_t i);

#endif
