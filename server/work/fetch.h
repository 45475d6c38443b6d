/** Files that are on another machine, brought here before a request reads them: HTTP threads do not
 *  wait for it. Thread-safe. */
#ifndef VOR_SERVER_WORK_FETCH_H
#define VOR_SERVER_WORK_FETCH_H

#include "server/blob/blob.h"
#include "server/work/thread_pool.h"

struct vor_fetcher;

/** @param[in] blobs  borrowed
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_fetcher_create(struct vor_fetcher **out, struct vor_blobs *blobs,
                                            struct vor_error *err);

/** Wakes the requests that still wait. fetcher may be NULL. */
void vor_fetcher_destroy(struct vor_fetcher *fetcher);

enum vor_fetched {
    VOR_FETCH_NEAR,  /**< vor_blob_get does not wait for another machine */
    VOR_FETCH_NONE,  /**< there is no such blob */
    VOR_FETCH_WAIT,  /**< asker->wake will be called, at most once; then ask again */
    VOR_FETCH_FLOWS, /**< the first bytes are here, and may be read while the others come */
    VOR_FETCH_FAILED
};

/** The bytes of a blob that are here already. */
struct vor_flow;

/** Brings a blob here, once for all who ask for it meanwhile. A failure, that there is none, or a
 *  part, holds for a few seconds. err says why it failed.
 *
 *  @param[in]  part  which bytes are wanted, and may flow, if not all of them come; any borders do.
 *                    NULL: the whole blob, and VOR_FETCH_FLOWS is not answered
 *  @param[out] flow  of VOR_FETCH_FLOWS: end it with vor_flow_drop */
enum vor_fetched vor_fetch(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                           const struct vor_blob_part *part, const struct vor_asker *asker,
                           struct vor_flow **flow, struct vor_error *err);

/** Reads up to size bytes from `at` of the blob on, each of a piece that is as it was written.
 * Those behind them may never come.
 *
 *  @param[in]  asker  woken at most once after 0 was returned
 *  @param[out] whole  1 when all have come, so that 0 is the end and nobody is woken
 *
 *  @return how many; 0: none yet; -1: they cannot be had */
long vor_flow_read(struct vor_flow *flow, uint64_t at, void *out, size_t size,
                   const struct vor_asker *asker, int *whole);

/** flow may be NULL. */
void vor_flow_drop(struct vor_flow *flow);

#endif
