/** The points around a loop (input/loops.h), laid out in a plane: where a hole is to be filled, the
 *  layout says over which part of the plane, and the points say how the surface comes in.
 *
 *  Where the surface around the hole lies over the plane of the loop without folds, the layout is
 *  the projection onto that plane. Else, at the end of a tube or a wide hole in a ball, the loop
 *  becomes a circle as long as itself, and each point lies as far outside of the circle as it is
 *  from the loop: the surface is unrolled. */
#ifndef VOR_INPUT_BAND_H
#define VOR_INPUT_BAND_H

#include "core/geom/polygon.h"
#include "core/input/domain.h"
#include "core/input/loops.h"

/** Spacings around a loop within which points say how the surface comes in. At 4 / 6 / 9, holes of
 *  ten spacings in igea (24 in four clouds, 30,000 points): rms distance to the true surface 0.206
 * / 0.206 / 0.209 spacings. */
#define VOR_BAND_WIDTH 6.0

/** Room for the search of bands, for one domain. */
struct vor_band_search {
    uint32_t *seen;  /**< n: the last search that took the point */
    uint32_t *point; /**< n: what it took */
    uint32_t *from;  /**< n: the loop's point that it came from */
    uint32_t searches;
};

/** A loop and the points around it. */
struct vor_band {
    struct vor_memory *memory;
    size_t rim, count;          /**< points of the loop; of the band, among which they are */
    uint32_t *point;            /**< count: numbers of the domain's points */
    double *outline;            /**< rim x 2: the loop in the plane, in the domain's unit */
    struct vor_polygon polygon; /**< of the outline */
    double *at;                 /**< count x 2: the points there */
    double middle[3];           /**< of the loop */
    double up[3];               /**< unit normal of the plane of the loop */
    int unrolled;               /**< the loop is a circle */
};

/** @retval VOR_E_NOMEM 12 bytes a point of the domain do not fit */
VOR_NODISCARD vor_status vor_band_search_init(struct vor_band_search *out, size_t n,
                                              struct vor_memory *memory, struct vor_error *err);
void vor_band_search_free(struct vor_band_search *search, struct vor_memory *memory);

/** Finds the points around a loop along the lists of the domain's graph, which there must be, and
 *  lays them out.
 *
 *  @param[out] out    free with vor_band_free; untouched on failure
 *  @param[in]  which  0 .. loops->count - 1
 *
 *  @retval VOR_E_NOMEM 36 bytes a point of the band and 100 one of the loop do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(points of the band times the logarithm of those of the loop), on the run's pool but for the
 *  search. The same band for any number of threads. */
VOR_NODISCARD vor_status vor_band_find(struct vor_band *out, struct vor_band_search *search,
                                       const struct vor_domain *domain,
                                       const struct vor_loops *loops, size_t which,
                                       const struct vor_run *run, struct vor_error *err);

/** band may be all zero. */
void vor_band_free(struct vor_band *band);

#endif
