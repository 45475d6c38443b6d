/** SHA-256, computed while bytes stream by. The only door to the library that does it. */
#ifndef VOR_SERVER_BASE_DIGEST_H
#define VOR_SERVER_BASE_DIGEST_H

#include <stddef.h>

/** 64 lower-case hexadecimal digits and their NUL. */
#define VOR_DIGEST_SIZE 65

struct vor_digest;

/** A fresh digest, NULL when memory is out. */
struct vor_digest *vor_digest_create(void);
void vor_digest_update(struct vor_digest *digest, const void *bytes, size_t size);

/** Writes the digest of everything so far; updating may go on. */
void vor_digest_hex(const struct vor_digest *digest, char out[VOR_DIGEST_SIZE]);

/** The digest of bytes that are all there, as a strong entity tag: 64 digits in quotes. */
#define VOR_ETAG_SIZE (VOR_DIGEST_SIZE + 2)
void vor_digest_etag(const void *bytes, size_t size, char out[VOR_ETAG_SIZE]);

/** True for 64 such digits. */
int vor_digest_is_one(const char *text);

/** digest may be NULL. */
void vor_digest_destroy(struct vor_digest *digest);

#endif
