/** Blobs as objects of an S3 bucket: PREFIX/keep/ID.NAME, and what was set aside
 * PREFIX/lost/ID.NAME. A folder of this process has the files under way and copies of what was
 * written or read recently.
 *
 *  A commit is durable once S3 has answered. A digest is sent with the bytes, and S3 compares. */
#ifndef VOR_SERVER_BLOB_S3_H
#define VOR_SERVER_BLOB_S3_H

#include "server/blob/driver.h"

extern const struct vor_blob_driver vor_blob_s3;

#endif
