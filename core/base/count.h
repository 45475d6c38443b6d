/** Counting rows of data that are at fault, on the pool. */
#ifndef VOR_BASE_COUNT_H
#define VOR_BASE_COUNT_H

#include "core/base/run.h"

/** Whether row i is to be counted; threads of the pool ask. */
typedef int (*vor_is_counted)(const void *ctx, size_t i);

/** Counts the rows of 0 .. n - 1 of which `is` is true.
 *
 *  @param[out] count, first  how many, and the first one, or n
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n). The same for any number of threads. */
VOR_NODISCARD vor_status vor_count(size_t *count, size_t *first, size_t n, vor_is_counted is,
                                   const void *ctx, const struct vor_run *run,
                                   struct vor_error *err);

#endif
