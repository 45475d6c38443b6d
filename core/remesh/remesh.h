/** The method `isotropic`: a triangulation of the points is remeshed until its edges are about
 *  equally long.
 *
 *  Source: Lv, Lin and Zhao 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec.
 *  4.1, after Botsch and Kobbelt 2004, "A remeshing approach to multiresolution modeling". A step
 *  splits edges longer than 4/3 of a length l, collapses those shorter than 4/5 of it, flips edges
 *  so that points come nearer to six neighbours, and moves points along the surface.
 *
 *  Departure: the paper's text splits above 1.6 l, its authors' program above 4/3.
 *  Departure: the paper starts at the points of the input and adapts l from step to step until the
 *  number of points is right. Here the points start evenly by area (seeds/start.h), exactly as many
 *  as asked for, and a step collapses as many edges as it splits, shortest and longest first: the
 *  number is exact after each, and l is where as many edges are too short as too long.
 *  Departure: points move to where the triangles around them are best (mesh/relax.h), not to the
 *  mean of their neighbours. Those on the border of the triangles only move as edges are split.
 *  Departure: the triangulation is that of an advancing front (mesh/front.h), which joins no two
 *  sheets, instead of one in each tangent plane.
 *
 *  Departure: on a smooth closed surface only the coarsest of ever finer sets of points is remeshed
 *  (seeds/coarse.h): a step of all further ones is that every edge is split. Igea to 20,000, points
 *  without six neighbours 9.5 / 3.4 %, CPU 4.4 / 1.4 s (all remeshed / so).
 *
 *  With a density (Sec. 4.2) lengths are those over the spacing wanted at the place. Up to
 *  VOR_AROUND_MOST points stay where they start: the polish spreads them. */
#ifndef VOR_REMESH_REMESH_H
#define VOR_REMESH_REMESH_H

#include "core/method.h"

/** A vor_method's run (core/method.h). Goes through the stages ITERATE and POLISH.
 *
 *  @param[out] out   free with vor_seeds_free; untouched on failure
 *  @param[in]  spec  read: seed, boundary, patch, iterations, delta, eta, seconds, polish, evenness
 *
 *  @retval VOR_E_DEGENERATE  triangles cannot join most of the points, as in a cloud without a
 *                            surface
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM  beside the seeds, 260 bytes a point do not fit
 *
 *  O(n log n) an iteration, on the run's pool, half of it on one thread. The same points for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_remesh_run(struct vor_seeds *out, struct vor_outcome *told,
                                        const struct vor_domain *domain, size_t n,
                                        const struct vor_spec *spec, const struct vor_run *run,
                                        struct vor_error *err);

#endif
