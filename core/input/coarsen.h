/** Thins an input whose noise is as wide as the fits: the most neighbours that a fit takes then
 * form a ball, and no surface.
 *
 *  Source: none of the papers; Huang 2013, Sec. 4, raises sigma_p with the noise, which sums over
 *  all points within it. Among fewer points the same number of neighbours reaches farther, and as
 *  many of them average out as much of the noise. Every second point is left out, in Morton order
 *  and so evenly by density, until neighbourhoods are flat; then those that belong to no surface
 *  (input/outliers.h), which hide among the others before.
 *
 *  Measured: fandisk, 163,000 points with noise of up to 2 % of the diagonal and 1 % outliers
 *  (tests/by_hand/bench/ear_clouds.py), to 40,000 by ear: near edges, 99th percentile 9.8e-3 of the
 *  diagonal before and 7.2e-3 now, median of normals 35 degrees and 7.5, elsewhere rms
 *  2.9e-2 and 3.6e-3; points farther off than the noise 7,158 and 18. */
#ifndef VOR_INPUT_COARSEN_H
#define VOR_INPUT_COARSEN_H

#include "core/input/domain.h"

/** Takes fewer points of `in`, indexes them and chooses how many a fit takes. Leaves *out empty
 *  where fits to `in` show a surface, or fits to fewer of its points do not either.
 *
 *  @param[out] out  free with vor_domain_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool; where there is a surface, a millisecond. The same points for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_domain_coarsen(struct vor_domain *out, const struct vor_domain *in,
                                            const struct vor_run *run, struct vor_error *err);

/** Takes every second point of `in`, indexes them and chooses how many a fit takes. Leaves *out
 *  untouched where too few would be left.
 *
 *  @param[out] out  free with vor_domain_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_domain_halve(struct vor_domain *out, const struct vor_domain *in,
                                          const struct vor_run *run, struct vor_error *err);

#endif
