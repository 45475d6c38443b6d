/** Holds points back where the cloud ends.
 *
 *  Source: Xiao et al. 2024, Sec. IV-E. Departure: the paper holds a point still when it is farther
 *  from the input than a global threshold; measured, that freezes closed clouds, since nearly half of
 *  a white-noise surface is farther than the mean spacing from every input point. Here a place is
 *  outside only where all its neighbours lie to one side of it, and then may be at most one local
 *  spacing away from the nearest; a point that would go farther stops there instead of standing
 *  still. Holes narrower than the neighbourhood have neighbours all around and fill as in the
 *  paper. */
#ifndef VOR_GEOM_BOUNDARY_H
#define VOR_GEOM_BOUNDARY_H

#include "core/geom/surface.h"

/** True when all k neighbours (k x 3 floats) lie to one side of the local point, seen along the
 *  surface: the direction looked along is that to their mean. O(k). */
int vor_boundary_one_sided(const struct vor_surface *surface, const float *near, unsigned k,
                           const double local[3]);

/** Given the k input points nearest to x (nearest first) and the surface fitted to them: true when x
 *  lies outside the cloud by more than one local spacing, and then x is moved back to that
 *  distance. */
int vor_boundary_restrict(const struct vor_surface *surface, const float *near, unsigned k,
                          double x[3]);

#endif
