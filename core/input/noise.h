/** How wide the noise of an input is, region by region, where it is as wide as the neighbourhoods
 *  that fits take and hides the surface from them.
 *
 *  Source: none of the papers. At places spread over the input quadrics are fitted to 20, 30, 45,
 *  70, 100 and 150 points. On a plane with noise the rms height t over such a quadric, over its
 *  reach, follows from the deviation over the reach alone, whatever the number: 0.15, 0.2, 0.25 and
 *  0.28 where that is 0.156, 0.215, 0.295 and 0.35; above, neighbourhoods are balls. Few neighbours
 *  of thick noise say nothing, many see edges and other sheets, which only add: the deviation is
 *  the least that any number gives at a third of the 32 places around. Regions that differ by less
 *  than half from the median of all have that median: regions estimate worse than all. */
#ifndef VOR_INPUT_NOISE_H
#define VOR_INPUT_NOISE_H

#include "core/input/halves.h"
#include "core/input/neighbors.h"

enum {
    VOR_NOISE_PLACES = VOR_NEIGHBORS_PLACES,
    VOR_NOISE_HIDDEN = VOR_NOISE_PLACES / 10, /**< places that may show nothing but balls */
    VOR_NOISE_LEAST = VOR_NEIGHBORS_ROOM * VOR_LADDER_LAST /**< points of a domain or a level */
};

/** Deviations that a fit reaches which moves points out of wide noise. With such fits at all
 * points, of a gear with noise of 0.77 spacings, rms off the surface over that of the input: at 3
 * / 3.5 / 4.5: 0.69 / 0.56 / 0.52. */
#define VOR_NOISE_REACH 4.5

struct vor_noise {
    int wide;                           /**< it is, somewhere */
    unsigned hidden;                    /**< places where no number of neighbours shows a surface,
                                             if more than VOR_NOISE_HIDDEN; else 0 */
    float xyz[3 * VOR_NOISE_PLACES];    /**< normalised */
    double deviation[VOR_NOISE_PLACES]; /**< of the noise around each place; 0 where it is
                                             not wide */
    double reach[VOR_NOISE_PLACES];     /**< distance to the 150th nearest point
                                             where noise is wide */
};

/** Noise is wide where the nearest 20 points show no surface, and where the number of neighbours
 *  that fits take, which stays small where the shape is in the way, does not reach
 *  VOR_NOISE_REACH deviations. Adds the levels to `halves` that it needs; a domain of fewer than
 *  1,200 points has no wide noise.
 *
 *  @param[in] neighbors  chosen for the domain
 *
 *  @retval VOR_E_NOMEM 50 KB and what vor_halves_add needs do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  20 ms, on the run's pool, where there is no wide noise, else O(n). The same for any number of
 * threads. */
VOR_NODISCARD vor_status vor_noise_find(struct vor_noise *out, struct vor_halves *halves,
                                        const struct vor_neighbors *neighbors,
                                        const struct vor_run *run, struct vor_error *err);

/** The place nearest to x (normalised). 0.5 us. */
size_t vor_noise_place(const struct vor_noise *noise, const float x[3]);

#endif
