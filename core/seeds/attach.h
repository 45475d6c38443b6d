/** Attaches the seeds to the input: moves those that lie outside onto it, and all of them onto the
 *  whole of a thinned input. */
#ifndef VOR_SEEDS_ATTACH_H
#define VOR_SEEDS_ATTACH_H

#include "core/seeds/seeds.h"

/** After the iterations: moves seeds that lie outside the input to VOR_OUTSIDE_IN_RESULT spacings
 *  of it, and, unless the holes are gaps of the sampling, seeds in holes back to their rims
 *  (geom/boundary.h, OUTSIDE and HOLE). Does nothing where seeds->policy.keep_border is not set.
 *
 *  @param[out] keep_holes  whether holes are kept open (HOLE); the steps after this need it
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n log n) at worst, on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_attach(struct vor_seeds *seeds, int *keep_holes,
                                    struct vor_error *err);

/** Moves seeds from a thinned domain to the whole one: projects them onto its surface and applies
 *  OUTSIDE and HOLE as vor_attach does. Does nothing where they are on the whole domain.
 *
 *  @param[in] keep_holes  as vor_attach found it
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n log n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_attach_to_whole(struct vor_seeds *seeds, int keep_holes,
                                             struct vor_error *err);

/** After evening out: moves seeds that are still outside to VOR_OUTSIDE_IN_RESULT spacings of the
 *  input, where spacing is that of the sparsest part (vor_domain.sparse). Does nothing where
 *  seeds->policy.keep_border is not set.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_attach_last(struct vor_seeds *seeds, struct vor_error *err);

/** Moves seeds that hang in the air beside the input, as fits at a tip or a sharp edge leave them,
 *  back to it: those farther from it than VOR_HOLE_INSIDE spacings (of input and result, the
 *  larger), where the way from the nearest input point is at most 60 degrees (VOR_SAME_WAY)
 *  from the normal of the nearest ones, and the input does not go on that way. They end
 *  VOR_HOLE_MARGIN spacings from that point. Where the input has sheets, only points of the seed's
 *  own count. Of eight solids and sheets from a modeller's vertices 365 points lay so, of which 299
 *  were more than .5 spacings off the surface and 25 within .15; of the 6,059 others as far from
 *  the input 298 and 5,037. Of nine shapes sampled evenly, unevenly and by scanning 18 of 40,000
 *  points lay so. Does nothing where seeds->policy.keep_border is not set.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_attach_steep(struct vor_seeds *seeds, struct vor_error *err);

/** Before triangles are made: moves seeds that hang in the air beside the input, as fits at a tip
 * or a sharp edge leave them, back to it. They are VOR_HOLE_INSIDE spacings (of input and result,
 * the larger) away, and see all of it on one side; they end VOR_HOLE_MARGIN spacings from the
 * nearest point. Of points that were that far off, of four shapes with as many input points, those
 * that saw it on one side were .3 to 1.2 spacings off the surface, the others 0 to .3. Does nothing
 * where seeds->policy.keep_border is not set.
 *
 *  @param[in] stays  n: those that stay; NULL: none
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_attach_hanging(struct vor_seeds *seeds, const unsigned char *stays,
                                            struct vor_error *err);

/** vor_attach that lets seeds lie in holes, which takes most of its time to tell, and does without
 *  vor_attach_near: for a run whose time is over, and for methods that project points on their own.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach_fast(struct vor_seeds *seeds, struct vor_error *err);

/** Of fewer seeds than the input has points, on an input without sheets, where
 *  seeds->policy.near_input is set: if x is farther from the input than half a spacing of
 *  the result, moves it onto the plane around its nearest input point where that halves the
 *  distance. From beyond the end of the input it goes back to half a spacing of the result from it
 *  or VOR_OUTSIDE_BEYOND of the input's, the larger. Where the input surrounds x, it goes towards
 *  that point until it is as near, or VOR_HOLE_MARGIN of half a spacing off the surface around
 *  that: in gaps of white noise it stays. scratch->here was gathered around x, or near it; uses
 *  scratch->foot. Returns whether x was moved.
 *
 *  Why: in scans a fit takes in points of two sheets, or a few points of a face that was seen at a
 *  grazing angle, and what is beyond their end, or between them, is a guess. In scans of a block
 *  with bores and of an octahedron a quarter of the points were farther than half a spacing from
 *  the input, with 86 % of the squared distance to the surface. Without / with what is done where
 *  the input surrounds x: of those two, a screw and a room that distance over the input's is 1.71
 *  / 1.30, delta of kitti 0.372 / 0.379. vor_attach, each step of the polish and vor_attach_last
 *  ask for it: asked at the end alone, it leaves crowds.
 *
 *  One search where x is that far, else O(k). */
int vor_attach_near(const struct vor_seeds *seeds, struct vor_scratch *scratch, double x[3]);

/** Distance from the input beyond which vor_attach_last asks vor_attach_near for a seed,
 * normalised: INFINITY where it asks for none. O(1). */
double vor_attach_allowed(const struct vor_seeds *seeds);

/** Moves seeds on an input of very few points back to near its box, if the border is kept. No lists
 *  are made anew: call it last. O(n). */
void vor_attach_to_box(struct vor_seeds *seeds);

#endif
