/** Objects of S3 that are deleted by a thread of their own, one after the other, so that nobody
 * waits for it. What is not deleted when the process ends is found at the next start, as are all
 * files that belong to no job. The thread also looks whether S3 answers (vor_s3_state).
 * Thread-safe. */
#ifndef VOR_SERVER_BLOB_S3_DROPS_H
#define VOR_SERVER_BLOB_S3_DROPS_H

#include "server/blob/s3_client.h"

struct vor_s3_drops;

/** @param[in] s3  borrowed
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_s3_drops_create(struct vor_s3_drops **out, struct vor_s3 *s3,
                                             struct vor_error *err);

/** Deletes what is left, up to the first failure. drops may be NULL. */
void vor_s3_drops_destroy(struct vor_s3_drops *drops);

/** @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_s3_drop(struct vor_s3_drops *drops, const char *key,
                                     struct vor_error *err);

/** The key is about to be written: it will not be deleted, and is not being deleted any more. */
void vor_s3_keep(struct vor_s3_drops *drops, const char *key);

#endif
