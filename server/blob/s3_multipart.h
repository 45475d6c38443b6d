/** Large files, which S3 takes as parts of one object (multipart upload). */
#ifndef VOR_SERVER_BLOB_S3_MULTIPART_H
#define VOR_SERVER_BLOB_S3_MULTIPART_H

#include "server/blob/s3_request.h"

/** Bytes of a part but the last; what has no more than one is put as it is. S3 takes 10,000 parts:
 *  640 GiB. */
#define VOR_S3_PART ((uint64_t)64 << 20)

/** Puts the first size bytes of a file as an object, part by part. Each part is sent with its
 *  SHA-256, which S3 compares. The parts of one that fails are removed.
 *
 *  @param[in] url  of the object
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM  as the functions of objects.h */
VOR_NODISCARD vor_status vor_s3_put_parts(struct vor_s3 *s3, const char *url,
                                          const struct vor_object_bytes *bytes,
                                          struct vor_error *err);

#endif
