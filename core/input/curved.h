/** The places that a field over the surface is computed at, and the fits there that its curvature
 *  is taken of.
 *
 *  Departure from Chen 2018, Sec. 5.2, which takes them at all points of the input: there are a few
 *  for each point of the result. More would show what the result cannot follow. */
#ifndef VOR_INPUT_CURVED_H
#define VOR_INPUT_CURVED_H

#include "core/geom/surface.h"
#include "core/input/domain.h"
#include "core/input/field.h"

/** Neighbours of a place: their disc gives its area, values are averaged with theirs. */
enum { VOR_CURVED_LISTED = VOR_FIELD_AROUND };

/** The places; owns what it made. */
struct vor_curved {
    struct vor_domain thin;          /**< or empty */
    const struct vor_domain *domain; /**< of which the places are the points: thin, or the whole */
    unsigned least;                  /**< points that a curvature is taken of, at least */
    double even;  /**< spacing of the points of the result, spread evenly; normalised */
    double floor; /**< a surface that bends less counts as bent so much: 1e-4 over the diagonal of
                       the input (the unit is from the paper's errata), normalised */
};

/** Picks the places for a result of n points.
 *
 *  @param[in]  domain  must outlive *out
 *  @param[out] out     free with vor_curved_free; untouched on failure
 *  @param[in]  each    places for each point of the result where the input has more, and more of
 *                      them where fits take more neighbours than the fewest; 0: as many as the
 *                      iterations have of a dense input (vor_domain_thin_for)
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED  as vor_domain_thin
 *
 *  O(n) of the input, on the run's pool. */
VOR_NODISCARD vor_status vor_curved_init(struct vor_curved *out, const struct vor_domain *domain,
                                         size_t n, double each, const struct vor_run *run,
                                         struct vor_error *err);

/** curved may be all zero. */
void vor_curved_free(struct vor_curved *curved);

/** Fits a surface to the points around place i.
 *
 *  @param[out] near  3 * VOR_NEIGHBORS_MAX floats: those points, the nearest first
 *
 *  @return number of these points
 *
 *  O(k log n). Cannot fail. Thread-safe. */
unsigned vor_curved_fit(struct vor_surface *out, float *near, const struct vor_curved *curved,
                        size_t i);

#endif
