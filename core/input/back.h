/** Where a surface bends back on itself, as at the rim of a blade, both of whose faces are in one
 *  list of neighbours: which of the points around face alike (geom/implicit.h). */
#ifndef VOR_INPUT_BACK_H
#define VOR_INPUT_BACK_H

#include "core/geom/graph.h"
#include "core/geom/implicit.h"
#include "core/input/domain.h"

/** What is known of a point. */
enum vor_back_at {
    VOR_BACK_NOT,
    VOR_BACK,       /**< the surface bends back on itself there */
    VOR_BACK_BESIDE /**< it does beside it, where no quadratic is fitted: its normal may be one
                         between both faces */
};

/** Points of which it is told where that is. */
struct vor_back {
    const struct vor_domain *on;
    const struct vor_graph *graph; /**< of those */
    float *normal;                 /**< n x 3 */
    unsigned char *at;             /**< n: an enum vor_back_at */
    float *rough;  /**< n: how far, in spacings, a point is off what was fitted to it; of
                        VOR_BACK the share of those around that contradict its fit */
    size_t points; /**< how many are VOR_BACK */
};

/** Fits to the domain's points nearest to x.
 *
 *  @return as vor_implicit_fit
 *
 *  O(log n), 20 us. Cannot fail. Thread-safe. */
int vor_back_fit(struct vor_implicit *out, const struct vor_domain *domain, const float x[3]);

/** Cosine between a normal at x and the quadratic's. O(1). */
double vor_back_along(const struct vor_implicit *implicit, const float x[3], const float normal[3]);

/** Fits to the points nearest to point i and takes its normal from there. Returns whether it did.
 */
int vor_back_take(const struct vor_back *back, size_t i);

/** Takes to VOR_BACK the points that have such in their lists and can be fitted likewise, with
 * their normals, in at most so many rounds; those that cannot are VOR_BACK_BESIDE.
 *
 *  @retval VOR_E_NOMEM n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n most), and a fit for each that is beside one, on the run's pool. The same for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_back_grow(struct vor_back *back, unsigned rounds,
                                       const struct vor_run *run, struct vor_error *err);

/** Sets the edges of the points that are VOR_BACK to what their fits say, the dearer the more of
 * those around contradict: of a fit that is wrong most do.
 *
 *  @param[in,out] edge  as of vor_span_make
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(points most^2), on the run's pool. The same for any number of threads. */
VOR_NODISCARD vor_status vor_back_edges(struct vor_back *back, unsigned char *edge,
                                        const struct vor_run *run, struct vor_error *err);

#endif
