/** Limits how fast wanted spacings grow from place to place (input/density.h). */
#ifndef VOR_INPUT_GRADING_H
#define VOR_INPUT_GRADING_H

#include "core/geom/graph.h"

/** The ways that a limit goes: from each point to those that have it in their lists. */
struct vor_grading {
    struct vor_memory *memory;
    const float *xyz; /**< n x 3; borrowed */
    size_t n;
    size_t *first;   /**< n + 1: those of point j are to[first[j]] .. to[first[j + 1] - 1] */
    uint32_t *to;    /**< as many as the lists have entries */
    uint32_t *queue; /**< n x 2 */
};

/** Makes ready. The graph is not needed afterwards.
 *
 *  @param[out] out  free with vor_grading_free; untouched on failure
 *  @param[in]  xyz  graph->n x 3; must stay as it is while *out lives
 *
 *  @retval VOR_E_NOMEM 16 bytes a point and 4 an entry of a list do not fit
 *
 *  O(n most), one thread. */
VOR_NODISCARD vor_status vor_grading_init(struct vor_grading *out, const struct vor_graph *graph,
                                          const float *xyz, struct vor_error *err);

/** Lowers values until none exceeds that of a point in its list by more than `steepest` times their
 *  distance. They become the largest that do not, whatever the order of the work.
 *
 *  @param[in,out] value  n, finite
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; some values are lowered
 *
 *  O(n (most + log n)), one thread. The same values for any number of threads. */
VOR_NODISCARD vor_status vor_grading_apply(const struct vor_grading *grading, float *value,
                                           double steepest, const struct vor_run *run,
                                           struct vor_error *err);

/** grading may be all zero. */
void vor_grading_free(struct vor_grading *grading);

#endif
