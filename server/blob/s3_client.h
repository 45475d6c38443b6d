/** Objects of one S3 bucket (or of what speaks its protocol) under a prefix, by libcurl, which
 * signs each request (AWS Signature Version 4).
 *
 *  Every function may be called from any thread and waits for the network: up to 10 s for a
 *  connection, and 30 s for each pause in which no byte comes. A request that meets a 5xx, 429, a
 *  reset or a time-out is signed and sent again, up to six times, after pauses that double from .1
 * s and are shortened at random. Failures are VOR_E_IO with the status and the code that S3 gave;
 * vor_error_storage_away and vor_error_storage_refused tell what kind they are.
 *
 *  Keys are made of letters, digits and "._/-", so that nothing in a URL needs an escape. */
#ifndef VOR_SERVER_BLOB_S3_CLIENT_H
#define VOR_SERVER_BLOB_S3_CLIENT_H

#include "core/base/status.h"

#include <stdint.h>

struct vor_s3;
struct vor_blob_watch;   /* driver.h */
struct vor_blob_reading; /* driver.h */
struct vor_text;

enum { VOR_S3_KEY_MAX = 128 }; /**< bytes of a key behind the prefix */

/** Reads the URL and the environment: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and
 *  AWS_SESSION_TOKEN, each also as the file that VARIABLE_FILE names; AWS_REGION. Asks nobody.
 *
 *  @param[in] url  http[s]://HOST[:PORT]/BUCKET[/PREFIX][?style=host]: with style=host the bucket
 *                  becomes a part of the host's name (https://BUCKET.HOST/KEY), as pgBackRest
 *                  calls it; else it is the first part of the path
 *
 *  @retval VOR_E_PARAM the URL is none of those, or a key is missing
 *  @retval VOR_E_IO    libcurl or a file cannot be had
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_s3_open(struct vor_s3 **out, const char *url, struct vor_error *err);

/** s3 may be NULL. */
void vor_s3_close(struct vor_s3 *s3);

/** Puts the first size bytes of a file in place of what was there; of large ones each part by
 *  itself, tried again by itself (s3_multipart.h).
 *
 *  @param[in] sha256  of the bytes, 64 digits: S3 compares */
VOR_NODISCARD vor_status vor_s3_put(struct vor_s3 *s3, const char *key, int fd, uint64_t size,
                                    const char *sha256, struct vor_error *err);

/** Copies an object inside the bucket. */
VOR_NODISCARD vor_status vor_s3_copy(struct vor_s3 *s3, const char *from, const char *to,
                                     struct vor_error *err);

/** Writes the bytes of an object to an empty file.
 *
 *  @param[in]  fd     -1: the object is only looked for
 *  @param[in]  watch  may be NULL
 *  @param[out] found  0 when there is none */
VOR_NODISCARD vor_status vor_s3_get(struct vor_s3 *s3, const char *key, int fd,
                                    const struct vor_blob_watch *watch, uint64_t *size, int *found,
                                    struct vor_error *err);

/** Writes the URL by which anybody can read an object for VOR_BLOB_LINK_SECONDS. Asks nobody.
 *
 *  @param[in] base  "https://HOST[/PATH]": where the bucket is found
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_s3_link(struct vor_s3 *s3, const char *base, const char *key,
                                     const struct vor_blob_reading *reading, struct vor_text *out,
                                     struct vor_error *err);

/** Removes an object; it is no error when there is none. */
VOR_NODISCARD vor_status vor_s3_delete(struct vor_s3 *s3, const char *key, struct vor_error *err);

/** Asks S3 for a list in which there is nothing: once, for 5 s at most. */
VOR_NODISCARD vor_status vor_s3_probe(struct vor_s3 *s3, struct vor_error *err);

/** VOR_OK while S3 answers, as of the last request that can tell; else why it does not. Asks
 *  nobody.
 *
 *  @param[out] age  seconds since the last answer; may be NULL */
VOR_NODISCARD vor_status vor_s3_state(struct vor_s3 *s3, double *age, struct vor_error *err);

struct vor_s3_object {
    const char *key; /**< behind what was listed */
    uint64_t size;
    int64_t modified_ms; /**< since 1970 */
};

/** Calls each for every object whose key begins so, in the order of keys; a key that is longer than
 *  VOR_S3_KEY_MAX or has other bytes is left out. each may call these functions. */
VOR_NODISCARD vor_status vor_s3_list(struct vor_s3 *s3, const char *begin,
                                     void (*each)(void *ctx, const struct vor_s3_object *object),
                                     void *ctx, struct vor_error *err);

#endif
