/** A smooth map from the plane to space through given points: the polyharmonic spline, a sum of
 *  |u - u_i|^3 over its points and a quadric.
 *
 *  Source: Duchon 1977, "Splines minimizing rotation-invariant semi-norms in Sobolev spaces": of
 * all maps through the points it bends least. The cube of the distance is smoother than the thin
 * plate (r^2 log r), carries curvature on into a hole, and needs no logarithm, whose bits would
 * differ between machines. */
#ifndef VOR_GEOM_SPLINE_H
#define VOR_GEOM_SPLINE_H

#include "core/base/memory.h"
#include "core/base/status.h"

#include <stddef.h>

/** Terms of the quadric: 1, u, v, uu, uv, vv. */
enum { VOR_SPLINE_TERMS = 6 };

/** All zero: no spline. */
struct vor_spline {
    struct vor_memory *memory;
    size_t n;
    double *at;     /**< n x 2: places of the points */
    double *weight; /**< (n + VOR_SPLINE_TERMS) x 3: of the points, then of the quadric */
};

/** Fits a spline to n points.
 *
 *  @param[out] out     free with vor_spline_free; untouched on failure
 *  @param[in]  at      n x 2: where the map is known, in [-1, 1]; no two at one place
 *  @param[in]  value   n x 3: and what it is there
 *  @param[in]  smooth  0: through the points; the cube of a distance in `at`: detail much smaller
 *                      than that is smoothed
 *
 *  @retval VOR_E_DEGENERATE fewer than VOR_SPLINE_TERMS points, or they lie on a line or circle
 *  @retval VOR_E_NOMEM      8 n^2 bytes do not fit
 *
 *  O(n^3), one thread. Depends on nothing but its arguments. */
VOR_NODISCARD vor_status vor_spline_fit(struct vor_spline *out, const double *at,
                                        const double *value, size_t n, double smooth,
                                        struct vor_memory *memory, struct vor_error *err);

/** The map at u. O(n). Cannot fail. */
void vor_spline_at(const struct vor_spline *spline, const double u[2], double out[3]);

/** spline may be all zero. */
void vor_spline_free(struct vor_spline *spline);

#endif
