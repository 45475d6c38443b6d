/** What placing points does without a fit, once the time of a run is over by far
 *  (vor_run_is_late): a search for a few neighbours takes 1 us, a fit to 500 of them 100 us.
 * Functions cannot fail and are thread-safe. */
#ifndef VOR_SEEDS_HURRIED_H
#define VOR_SEEDS_HURRIED_H

#include "core/geom/plane.h"
#include "core/input/domain.h"

/** Area of the surface, in squared normalised units, over the number of input points, around input
 *  point x: that of a disc which reaches as far as its neighbours, over their number. 0 where they
 *  coincide. */
double vor_hurried_area(const struct vor_domain *domain, const float x[3]);

/** Sets *out to a place between input point x and one of its neighbours, no farther from x than
 * half the way.
 *
 *  @param[in] unit  two random numbers of [0, 1): which neighbour, and how far */
void vor_hurried_draw(float out[3], const struct vor_domain *domain, const float x[3],
                      const double unit[2]);

/** Moves x towards the nearest input point if it is farther from that than `far`. Returns whether
 * it moved. */
int vor_hurried_hold(float x[3], const struct vor_domain *domain, double far);

#endif
