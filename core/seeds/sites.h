/** Points of a result along the borders of the input and its sharp edges: they do not move, and the
 *  cells of the others end at theirs.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 5.5: the input's border points are fixed virtual sites that clip cells; after the
 *  iterations, midpoints of border samples that follow each other are projected onto the border,
 *  and join the result where no sample is near.
 *  Departure: the sites are samples, evenly spaced along each loop (input/loops.h), as far apart as
 *  those inside come to be. They count among the points asked for. The midpoints of the paper
 *  depend on where the samples nearest to the border happen to be: their distances differ by a
 *  factor of two, and their number is not known before.
 *
 *  Sites on sharp edges (input/ridges.h) likewise, as Sec. 6 suggests: evenly from one end of a
 * line to the other. Where lines meet, sites nearer than VOR_SITES_APART spacings to one before are
 * left out.
 *
 *  A site on a border has half a cell. So n points, f of them on borders of length L, have the
 *  spacing h of n - f / 2 whole cells on the area A, where f = L / h. */
#ifndef VOR_SEEDS_SITES_H
#define VOR_SEEDS_SITES_H

#include "core/input/domain.h"
#include "core/input/loops.h"

/** Spacings of the result between points of one edge, at least: sites, and those that ear puts
 * there (lop/edges.h, whose figures at 0.65 / 0.8 are 0.86e-3 / 0.97e-3, 0.048 / 0.045). */
#define VOR_SITES_APART 0.7

/** Sites; all zero: none. */
struct vor_sites {
    struct vor_memory *memory;
    size_t n, half; /**< half: of these, on borders, where they have half a cell; the first */
    double spacing; /**< of the sites; with a density, over the value of the field */
    float *xyz;     /**< n x 3, normalised */
    size_t places;  /**< along the lines: the sites, and halfway from one to the next */
    float *place;   /**< places x 3 */
    float *outward; /**< places x 3: across a border, out of the input; 0 along edges */
};

/** What sites are for. */
struct vor_sites_for {
    size_t n;           /**< points of the result */
    double area;        /**< of the surface, normalised */
    int borders, edges; /**< where sites go */
};

/** Places the sites of a result, fewer than there are points.
 *
 *  @param[out] out   free with vor_sites_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED  as vor_loops_find, vor_edges_find
 *
 *  As vor_loops_find and vor_edges_find; O(n) more, fits on the run's pool. The same sites for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_sites_find(struct vor_sites *out, const struct vor_domain *domain,
                                        const struct vor_sites_for *wanted,
                                        const struct vor_run *run, struct vor_error *err);

/** sites may be all zero. */
void vor_sites_free(struct vor_sites *sites);

#endif
