/** Where a surface bends back on itself, as at the rim of a blade, both of whose faces are in one
 *  list of neighbours: which of the points around face alike (geom/implicit.h). */
#ifndef VOR_INPUT_BACK_H
#define VOR_INPUT_BACK_H

#include "core/geom/graph.h"
#include "core/geom/implicit.h"
#include "core/geom/span.h"
#include "core/input/domain.h"

/** What is known of a point. */
enum vor_back_at {
    VOR_BACK_NOT,
    VOR_BACK,       /**< the surface bends back on itself there */
    VOR_BACK_FEW,   /**< likewise, but too few points do for a rim: normals are by a fit to both
                         faces, edges are not */
    VOR_BACK_BESIDE /**< it does beside it, where neither a quadratic nor one height is fitted: its
                         normal may be one between both faces */
};

/** Points of which it is told where that is. */
struct vor_back {
    const struct vor_domain *on;
    const struct vor_graph *graph; /**< of those */
    float *normal;                 /**< n x 3 */
    const float *rough;            /**< n: how far, in spacings, a point is off one height */
    unsigned char *at;             /**< n: an enum vor_back_at */
};

/** Fits to the domain's points nearest to x.
 *
 *  @return as vor_implicit_fit
 *
 *  O(log n), 20 us. Cannot fail. Thread-safe. */
int vor_back_fit(struct vor_implicit *out, const struct vor_domain *domain, const float x[3]);

/** Cosine between a normal at x and the quadratic's. O(1). */
double vor_back_along(const struct vor_implicit *implicit, const float x[3], const float normal[3]);

/** Finds the points that are VOR_BACK and gives them the normals of their fits: those of which
 *  most neighbours can be fitted likewise, as all along a rim, while at corners, across gaps and in
 *  noise single ones can; and, in so many rounds, those beside such that can be.
 *
 *  @param[in,out] back  `at` is not VOR_BACK_NOT where a fit is to be tried
 *
 *  @retval VOR_E_NOMEM n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n most), and two fits for each that is found, on the run's pool. The same for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_back_find(struct vor_back *back, unsigned rounds,
                                       const struct vor_run *run, struct vor_error *err);

/** Sets the edges of the points that are VOR_BACK to what their fits say. Where the fits of more
 * than one point around contradict, a point is VOR_BACK_BESIDE from then on.
 *
 *  @param[in,out] edge  as of vor_span_make
 *
 *  @retval VOR_E_NOMEM n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n most^2), and a fit for each that is VOR_BACK, on the run's pool. The same for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_back_edges(struct vor_back *back, unsigned char *edge,
                                        const struct vor_run *run, struct vor_error *err);

/** Makes points VOR_BACK_FEW that are VOR_BACK, of components where no more are than `wide` times
 *  the root of all. A rim is as long as a surface is wide; an acute edge has some such points too.
 *
 *  @param[out] dropped  how many points' edges are to be made again
 *
 *  @retval VOR_E_NOMEM 8 bytes for each component do not fit
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_back_drop(size_t *dropped, struct vor_back *back,
                                       const struct vor_span *span, double wide,
                                       struct vor_error *err);

#endif
