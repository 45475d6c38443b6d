/** Blobs as objects on another machine: keep/ID.NAME, and the digests of its pieces piece/ID.NAME.
 * A folder of this process has the files under way and copies of what was written or read recently.
 *
 *  A commit is durable once the other machine has answered. */
#ifndef VOR_SERVER_BLOB_REMOTE_H
#define VOR_SERVER_BLOB_REMOTE_H

#include "server/blob/driver.h"

/** Of a bucket of S3; of a PostgreSQL database. */
extern const struct vor_blob_driver vor_blob_s3, vor_blob_postgres;

#endif
