/** Moves the points of an input onto the surfaces among them where noise is so wide that the points
 *  around a place form a ball and show none, or reach no farther than the noise (input/noise.h).
 *
 *  Source: none of the papers; moving least squares as in input/mls.h, with two departures. The
 *  reach is in deviations of the noise, not in neighbours. Points count the less the farther they
 *  are from the quadric, none beyond 2.3 deviations, so that other sheets and walls do not count.
 *  Also tried: the widest of three quadrics that narrower ones agree with (Xu and Foi 2021): rms
 *  over the input's 0.45 and 0.39 of a gear and of three sheets, 0.46 and 0.43 without.
 *
 *  Only every second, fourth or eighth point and so on moves so, as many as lie densely within the
 *  reach of a fit: the representatives. All others then move onto the plane of the nearest of them.
 *  With all points as representatives a gear, a bowl and four sheets keep 0.445, 0.228 and 0.271,
 *  for two to three times the time, with these 0.448, 0.231 and 0.267.
 *
 *  A first quadric is searched from the plane of the points around. Between sheets and beside edges
 *  that plane lies across them. So there are three passes, each over what the pass before moved;
 *  after the first, a representative also tries the planes on which those nearest to it have come
 *  to lie, and takes the one with the most points. None goes farther from where it was than the
 *  reach of a fit: it stays there then.
 *
 *  Noise also carries points past the end of an open surface. Spread evenly they fill that fringe:
 *  of four sheets a seventh of the result lay there, with two thirds of its squared distance to the
 *  surface. So points also move back along the surface to where it ends, which the mean of those
 *  around them says. At sharp edges this takes off what lies beyond them.
 *
 *  More points of the same surface leave no more of the noise: neighbours are taken from fewer of
 *  them (input/halves.h) where the most that a fit takes do not reach far enough. */
#ifndef VOR_INPUT_SETTLE_H
#define VOR_INPUT_SETTLE_H

#include "core/input/domain.h"

/** Moves the points of a domain that lie in wide noise, and indexes it again. Others stay. Reads
 *  known.neighbors, sets known.hidden.
 *
 *  @param[out] moved  whether there were any
 *
 *  @retval VOR_E_NOMEM 90 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain may have to be freed
 *
 *  O(n), on the run's pool; 60 us of CPU a representative and pass, 2 us any other point, 20 near
 *  ends; 20 ms where there is no wide noise. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_settle(struct vor_domain *domain, int *moved,
                                    const struct vor_run *run, struct vor_error *err);

#endif
