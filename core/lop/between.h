/** Points put between others without looking at the rest: for an insertion that has no more time.
 *
 *  Source: Boubekeur and Alexa 2008, "Phong Tessellation", Eq. 2, with alpha = 1/2: a place on the
 *  line between two points goes half of the way to where their planes have it, which is exact on a
 *  circle up to third order. Departure: between normals at right angles and more an edge lies, and
 *  the point stays on the plane of its own side. */
#ifndef VOR_LOP_BETWEEN_H
#define VOR_LOP_BETWEEN_H

#include "core/base/run.h"
#include "core/lop/samples.h"

/** Adds points until there are n, as many beside each, no farther than half the way to one of its
 *  nearest. Nothing where there are as many.
 *
 *  @param[in,out] samples  at least 2, with room for n
 *  @param[in]     seed     of random numbers: how far
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  the points added are lost
 *  @retval VOR_E_NOMEM  an index of the points that there were does not fit
 *
 *  O(n) and a search for each point that is added, on the run's pool. The same points for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_lop_between(struct vor_lop_samples *samples, size_t n, uint64_t seed,
                                         const struct vor_run *run, struct vor_error *err);

#endif
