/** What every loop that moves points shares: the most even positions so far, and the stops that the
 *  request asks for. */
#ifndef VOR_OPT_KEEP_BEST_H
#define VOR_OPT_KEEP_BEST_H

#include "core/base/memory.h"
#include "core/spec.h"

/** The most even positions of n points so far. */
struct vor_keep_best {
    struct vor_memory *memory;
    size_t n;
    float *xyz;   /**< n x 3 */
    double delta; /**< of them; infinite before the first */
};

/** @retval VOR_E_NOMEM 12 n bytes do not fit */
VOR_NODISCARD vor_status vor_keep_best_init(struct vor_keep_best *out, size_t n,
                                            struct vor_memory *memory, struct vor_error *err);

/** best may be all zero. */
void vor_keep_best_free(struct vor_keep_best *best);

/** Takes in positions that are more even than any before; others are passed over. */
void vor_keep_best_offer(struct vor_keep_best *best, const float *xyz, double delta);

/** Takes in positions whatever came before: what did no longer counts. */
void vor_keep_best_restart(struct vor_keep_best *best, const float *xyz, double delta);

/** Whether the request asks for a delta, and that one is low enough. */
int vor_stop_even_enough(const struct vor_spec *spec, double delta);

/** Whether the request limits the time, and `share` of it is over before another step ends that
 *  takes as long as the last one.
 *
 *  @param[in] seconds  since the run began
 *  @param[in] took     the last step */
int vor_stop_out_of_time(const struct vor_spec *spec, double share, double seconds, double took);

#endif
