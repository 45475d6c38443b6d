/** Objects of one S3 bucket (or of what speaks its protocol) under a prefix, by libcurl, which
 *  signs each request (AWS Signature Version 4).
 *
 *  A request waits up to 10 s for a connection, and 30 s for each pause in which no byte comes.
 * 5xx, 429, resets and time-outs may pass; each try is signed anew. A failure has the status and
 * the code that S3 gave. A put sends the digest, and S3 compares; large objects are put part by
 * part, each tried again by itself (s3_multipart.h). Nothing in the URL of a key needs an escape.
 *
 *  The place is http[s]://HOST[:PORT]/BUCKET[/PREFIX][?style=host]: with style=host the bucket
 *  becomes a part of the host's name (https://BUCKET.HOST/KEY), as pgBackRest calls it; else it is
 *  the first part of the path. The environment has the rest: AWS_ACCESS_KEY_ID,
 *  AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN, each also as the file that VARIABLE_FILE names;
 *  AWS_REGION. */
#ifndef VOR_SERVER_BLOB_S3_CLIENT_H
#define VOR_SERVER_BLOB_S3_CLIENT_H

#include "server/blob/objects.h"

extern const struct vor_objects_kind vor_s3_objects;

#endif
