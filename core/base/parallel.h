/** One pool of threads, shared fairly by all running jobs. */
#ifndef VOR_BASE_PARALLEL_H
#define VOR_BASE_PARALLEL_H

#include "core/base/status.h"
#include "core/base/watch.h"

#include <stddef.h>

struct vor_pool;

/** Most threads of a pool. */
#define VOR_THREADS_MAX 256

/** Starts a pool of 1 .. VOR_THREADS_MAX threads.
 *
 *  @param[out] out  free with vor_pool_destroy; untouched on failure
 *
 *  @retval VOR_E_PARAM threads is out of range
 *  @retval VOR_E_NOMEM the threads cannot be started */
VOR_NODISCARD vor_status vor_pool_create(struct vor_pool **out, unsigned threads,
                                         struct vor_error *err);

/** Waits for the threads to end, and frees the pool. No loop may be running. pool may be NULL. */
void vor_pool_destroy(struct vor_pool *pool);

/** How many threads the pool has. */
unsigned vor_pool_threads(const struct vor_pool *pool);

/** Does rows begin .. end - 1 of a loop. worker, 0 .. threads - 1, is the index of the scratch
 *  space to use. Writes only what belongs to its rows or to its worker. */
typedef void (*vor_task)(void *ctx, size_t begin, size_t end, unsigned worker);

/** Runs task over rows 0 .. n - 1 in blocks of `block` rows on the pool, and waits. Blocks start at
 *  multiples of `block`, so what a block computes does not depend on the number of threads. Loops
 *  that run at the same time take turns, a block each. The calling thread works, too, where a
 *  thread of the pool would have to be woken: as many blocks are in work as the pool has threads.
 *
 *  @param[in] watch  may be NULL; its poll is called before every block, and an answer other than
 *                    VOR_CONTINUE ends the loop before the next block
 *
 *  @return VOR_CONTINUE when every row ran, else the answer that ended the loop */
VOR_NODISCARD enum vor_answer vor_parallel_for(struct vor_pool *pool, const struct vor_watch *watch,
                                               size_t n, size_t block, vor_task task, void *ctx);

/** Does row i of a loop, with the scratch space of a worker: a task that does each row by itself.
 */
typedef void (*vor_row_task)(void *ctx, size_t i, unsigned worker);

/** As vor_parallel_for, a row after the other. A call a row: not for rows of a few additions. */
VOR_NODISCARD enum vor_answer vor_parallel_rows(struct vor_pool *pool,
                                                const struct vor_watch *watch, size_t n,
                                                size_t block, vor_row_task task, void *ctx);

/** How many blocks of `block` rows n rows have. */
static inline size_t vor_blocks_of(size_t n, size_t block)
{
    return (n + block - 1) / block;
}

/** Replaces the counts of n blocks by the sum of those before each. Returns the sum of all. */
static inline size_t vor_running_sum(size_t *count, size_t n)
{
    size_t sum = 0;

    for (size_t i = 0; i < n; i++) {
        size_t here = count[i];

        count[i] = sum;
        sum += here;
    }
    return sum;
}

#endif
