/** The density that a request asks for, turned into a field of wanted spacings (input/field.h).
 *
 *  Source: Chen 2018, "Resampling point clouds by centroidal Voronoi tessellation", Sec. 4 and 5.2.
 *  The density rho is that of an attribute of the input, or the sum of the principal curvatures
 *  without their signs, each at least 1e-4 over the diagonal of the input, evened out among
 *  neighbours. Where each cell has the same share of the energy, the spacing goes with rho^(-1/4).
 *
 *  That of edges, which is ours, is 1 at the points of the field nearest to those of the input that
 *  lie on a sharp edge (input/edges.h) and 0 elsewhere: the spacing is smallest along edges, and
 *  grows away from them as grading allows, up to contrast times as much.
 *
 *  With groups, those of Lv 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec.
 *  4.2, Eq. 10: the points of the field are put into groups of equal area by their density, or by
 *  the distance from the nearest edge, and all points of a group have one spacing. The paper does
 *  not say where groups end; its authors' program has the same number of points in each. Of the
 *  paper's lists of spacings, the widest ones are used; less contrast comes within 0.05 of the
 *  others. Grading smooths the steps between groups, where the paper averages neighbours (Eq. 8).
 *  Measured on 200,000 points of armadillo to 10,000 by curvature, none / 3 / 5: largest and mean
 *  geometric error (metrics/mls_error.h) over those of an even spread 0.75 / 0.72 / 0.64 and 0.91 /
 *  1.00 / 0.99.
 *  The mean cannot fall far: of the even spread's, the flattest fifth of the surface still has 0.46
 *  times the mean, the most bent one 2.1 times, and were errors as the square of spacings, the best
 *  spread would have 0.93 and the three lists of five 1.37, 1.00 and 0.95. The second list, by
 *  contrast=1.875, has 0.79 and 0.93.
 *
 *  Departure: the paper takes densities as they are. Those of curvature span six decades, and no
 *  spacing can follow that: the largest spacing is at most `contrast` times the smallest one, and
 *  from one place to another it changes by at most `grading` times their distance.
 *  Departure: the field has about two points for each one of the result: a dense input is thinned
 *  for it. A finer one would show what the result cannot follow. */
#ifndef VOR_INPUT_DENSITY_H
#define VOR_INPUT_DENSITY_H

#include "core/input/domain.h"
#include "core/spec.h"

/** Checks that the attribute that the request names as density may be one: a scalar for each point,
 *  finite and not negative, some of them not 0. Does nothing if the request names none.
 *
 *  @retval VOR_E_DENSITY  it may not; the message has the names there, or the first point at fault
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_density_check(const struct vor_cloud *in, const struct vor_spec *spec,
                                           const struct vor_run *run, struct vor_error *err);

/** Makes domain->field for n points of the result. Does nothing if the request asks for an even
 *  spread.
 *
 *  @param[in] in    the cloud that the domain was made of; its attribute was checked
 *  @param[in] spec  read: density, groups, contrast, grading
 *  @param[in] run   a stop must not interrupt this: pass vor_run_unstoppable
 *
 *  @retval VOR_E_DENSITY  that of edges is asked for, and the input has none
 *  @retval VOR_E_NOMEM 190 bytes for each point of the field do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool but for grading, which is one thread's. Once the run is late, the
 *  field asks for about n points and is not fitted again. The same field for any number of threads.
 */
VOR_NODISCARD vor_status vor_density_make(struct vor_domain *domain, const struct vor_cloud *in,
                                          size_t n, const struct vor_spec *spec,
                                          const struct vor_run *run, struct vor_error *err);

#endif
