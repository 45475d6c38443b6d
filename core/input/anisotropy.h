/** The metric that a request asks for, turned into a field of tensors (input/tensor.h).
 *
 *  Source: Chen 2018, "Point cloud resampling using centroidal Voronoi tessellation methods", Sec.
 *  5.3. With `anisotropic` cells are the longer along the direction of least curvature, by the root
 *  of the ratio of the principal curvatures without their signs, each at least 1e-4 over the
 *  diagonal of the input. With an attribute the metric is that of the input's own tensors, as far
 *  as they lie in the tangent plane.
 *
 *  Departure: everywhere the tensor has determinant 1, so that areas stay even (or as a density
 *  asks), and an aspect of at most `maxAspect`.
 *  Departure: the curvature is averaged as a tensor, with its sign, before its absolute value is
 *  taken, and one smaller than what the fit leaves uncertain counts as that: noise, and what
 *  float32 rounds off on a flat face, have no direction. */
#ifndef VOR_INPUT_ANISOTROPY_H
#define VOR_INPUT_ANISOTROPY_H

#include "core/input/domain.h"
#include "core/spec.h"

/** Checks that the attribute that the request names as metric may be one: NAME_xx, NAME_xy,
 *  NAME_xz, NAME_yy, NAME_yz and NAME_zz, a scalar each, or NAME of six components in that order,
 *  finite and at each point a positive definite tensor. Does nothing if the request names none.
 *
 *  @retval VOR_E_METRIC  it may not; the message has the names there, or the first point at fault
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_anisotropy_check(const struct vor_cloud *in,
                                              const struct vor_spec *spec,
                                              const struct vor_run *run, struct vor_error *err);

/** Makes domain->tensors for n points of the result. Does nothing if the request asks for no
 *  metric.
 *
 *  @param[in] in    the cloud that the domain was made of; its attribute was checked
 *  @param[in] spec  read: metric, maxAspect
 *  @param[in] run   a stop must not interrupt this: pass vor_run_unstoppable
 *
 *  @retval VOR_E_NOMEM 280 bytes for each point of the field do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same field for any number of threads. */
VOR_NODISCARD vor_status vor_anisotropy_make(struct vor_domain *domain, const struct vor_cloud *in,
                                             size_t n, const struct vor_spec *spec,
                                             const struct vor_run *run, struct vor_error *err);

#endif
