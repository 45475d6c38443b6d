/** What all loops that move points share: the most even positions so far, and the stops that the
 *  request asks for. */
#ifndef VOR_OPT_KEEP_BEST_H
#define VOR_OPT_KEEP_BEST_H

#include "core/base/memory.h"
#include "core/report.h"

/** The most even positions of n points so far; owns them. */
struct vor_keep_best {
    struct vor_memory *memory;
    size_t n;
    float *xyz;           /**< n x 3 */
    struct vor_record at; /**< of these positions; delta is infinite before the first */
};

/** @retval VOR_E_NOMEM 12 n bytes do not fit */
VOR_NODISCARD vor_status vor_keep_best_init(struct vor_keep_best *out, size_t n,
                                            struct vor_memory *memory, struct vor_error *err);

/** Frees the positions; best may be all zero. */
void vor_keep_best_free(struct vor_keep_best *best);

/** Keeps the positions (n x 3), of which the record is, if they are more even than those before.
 *  O(n). */
void vor_keep_best_offer(struct vor_keep_best *best, const float *xyz, const struct vor_record *at);

/** Keeps the positions (n x 3), of which the record is, however even; those before no longer count.
 *  O(n). */
void vor_keep_best_restart(struct vor_keep_best *best, const float *xyz,
                           const struct vor_record *at);

/** Copies the positions kept to xyz (n x 3) and returns their record. O(n). */
struct vor_record vor_keep_best_recall(const struct vor_keep_best *best, float *xyz);

/** Writes into the members best of a record what the positions kept are like. */
void vor_keep_best_tell(const struct vor_keep_best *best, struct vor_record *record);

/** Whether the request asks for a delta and this one is low enough. */
int vor_stop_even_enough(const struct vor_spec *spec, double delta);

/** Whether the request asks for moves as short as this one, in spacings of an even spread. */
int vor_stop_still(const struct vor_spec *spec, double move);

/** Whether the request limits the time, and another step as long as the last one would end after
 *  `share` of it.
 *
 *  @param[in] seconds  since the run began
 *  @param[in] took     by the last step */
int vor_stop_out_of_time(const struct vor_spec *spec, double share, double seconds, double took);

#endif
