/** Centroidal Voronoi tessellation on local quadrics by Lloyd's method with Anderson acceleration.
 *
 *  Source: Xiao et al. 2024, Algorithm 1 and Sec. IV. Each iteration: local surface and restricted
 *  Voronoi cell of every seed, its centroid, projected; the Anderson mix of the last iterates; of
 * the two the more even one.
 *
 *  Departure: of Eq. 12 the smaller delta is taken, as the text says and the formula does not.
 *  Departure: the mix keeps to the tangent plane at the projected centroid and within half a
 * spacing of it; points at the border take no part. Departure: the result is the most even iterate
 * of all.
 *
 *  Not done here: density, anisotropy, other norms. */
#ifndef VOR_METHOD_CVT_H
#define VOR_METHOD_CVT_H

#include "core/engine.h"
#include "core/method/seeds.h"

/** What the loop reports back; lengths in the cloud's unit. */
struct vor_cvt_result {
    uint32_t iterations;
    enum vor_stopped stopped;
    uint64_t held, held_ever, fallback_plane, fallback_left;
    double area;
};

/** Moves the seeds until a stop of the request (iterations, delta, seconds, plateau) or the watch
 * ends it, and leaves the most even positions in seeds->xyz.
 *
 *  @param[in] spec   read: iterations, delta, seconds, anderson, boundary
 *  @param[in] start  the clock's reading when the run began: the records and the budget count from
 * it
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM
 *
 *  O(iterations n log n). The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_cvt_run(struct vor_seeds *seeds, struct vor_cvt_result *out,
                                     const struct vor_spec *spec, double start,
                                     struct vor_error *err);

#endif
