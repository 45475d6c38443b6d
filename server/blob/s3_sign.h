/** Presigned URLs for S3 (AWS Signature Version 4): the signature is in the query, so no key is
 *  needed to use one. libcurl can only sign headers. */
#ifndef VOR_SERVER_BLOB_S3_SIGN_H
#define VOR_SERVER_BLOB_S3_SIGN_H

#include "proto/text.h"

#include <stdint.h>

struct vor_s3_signing {
    const char *method;
    const char *url;   /**< "https://HOST/KEY", in which nothing needs an escape */
    const char *query; /**< "&NAME=VALUE" in the order of names, behind "X-Amz", with escapes */
    const char *key_id, *secret, *region;
    const char *token; /**< of a session; "" for none */
    int64_t at;        /**< seconds since 1970 */
    unsigned seconds;  /**< for which it is good */
};

/** Appends the signed URL. The scheme's own port goes, as clients leave it out of their Host.
 *
 *  Source: https://docs.aws.amazon.com/AmazonS3/latest/API/sigv4-query-string-auth.html */
void vor_s3_sign(const struct vor_s3_signing *signing, struct vor_text *out);

#endif
