/** Which holes of an input are filled.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 5.6, which lets the user choose. So does this; unless told which, it takes the
 *  loops that are holes by VOR_LOOPS_HOLE_TURNS and shorter than holeMax. */
#ifndef VOR_INPUT_HOLES_H
#define VOR_INPUT_HOLES_H

#include "core/input/domain.h"
#include "core/spec.h"

/** Fills the holes that the request says, and notes in domain->known.holes what became of each.
 *
 *  @param[in,out] domain  gets the new points; lists and neighbours that it has are of the old ones
 *  @param[in]     seen    the same input, as the process inspect sees it, with lists: holes have
 * the numbers that it tells. It may be a domain of its own, of the same frame
 *  @param[in]     origin  of the input's positions, for the note
 *  @param[in]     spec    read: holes, holeMax
 *
 *  @retval VOR_E_HOLES  there is no hole of a number in the request; the message says which there
 *                       are
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED; the domain is to be freed
 *
 *  As vor_loops_find and vor_fill_hole; on the run's pool. The same for any number of threads. */
VOR_NODISCARD vor_status vor_holes_fill(struct vor_domain *domain, const struct vor_domain *seen,
                                        const double origin[3], const struct vor_spec *spec,
                                        const struct vor_run *run, struct vor_error *err);

#endif
