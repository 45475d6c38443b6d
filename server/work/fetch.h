/** Files that are on another machine, brought here before a request reads them: HTTP threads do not
 *  wait for it. Thread-safe. */
#ifndef VOR_SERVER_WORK_FETCH_H
#define VOR_SERVER_WORK_FETCH_H

#include "server/blob/blob.h"
#include "server/work/asker.h"

struct vor_fetcher;

/** @param[in] blobs  borrowed
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_fetcher_create(struct vor_fetcher **out, struct vor_blobs *blobs,
                                            struct vor_error *err);

/** Wakes the requests that still wait. fetcher may be NULL. */
void vor_fetcher_destroy(struct vor_fetcher *fetcher);

enum vor_fetched {
    VOR_FETCH_NEAR, /**< vor_blob_get does not wait for another machine */
    VOR_FETCH_NONE, /**< there is no such blob */
    VOR_FETCH_WAIT, /**< asker->wake will be called, at most once; then ask again */
    VOR_FETCH_FAILED
};

/** Brings a blob here, once for all who ask for it meanwhile. A failure, or that there is none,
 *  holds for a few seconds. err says why it failed. */
enum vor_fetched vor_fetch(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                           const struct vor_asker *asker, struct vor_error *err);

#endif
