/** Iterations that minimise an energy for which the centroids of cells are no answer: of a power p
 *  above 2, or of a metric over Euclidean cells.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 * methods", Sec. 4.3.3 and 5.3. An iteration takes tangent planes, five steps of L-BFGS
 * (opt/lbfgs.h) while these stand still (cvt/frozen.h), and puts the seeds back onto the surface.
 * With p of 8 and the principal directions as axes, cells become squares along them.
 *
 *  Departure: p begins at 2 and is doubled, because from an uneven start the energy of a high power
 *  is that of a few large cells.
 *  Departure: where the curvature shows no directions, those around decide (cvt/crosses.h).
 *
 *  No polish may follow: it evens distances out towards hexagons (seeds/repel.h). */
#ifndef VOR_CVT_DESCEND_H
#define VOR_CVT_DESCEND_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** Moves the seeds until a stop of the request (iterations, delta, moveStop, seconds) or the watch
 *  ends it. seeds->xyz ends as the positions after the last whole iteration.
 *
 *  @param[in,out] told  this stage is added
 *  @param[in]     spec  read: metric, cells, p, iterations, delta, moveStop, seconds
 *  @param[in]     run   may be stopped
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM  about 1,100 n bytes do not fit
 *
 *  O(iterations n log n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_descend_run(struct vor_seeds *seeds, struct vor_outcome *told,
                                         const struct vor_spec *spec, const struct vor_run *run,
                                         struct vor_error *err);

#endif
