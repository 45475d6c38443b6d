/** SHA-256, computed while bytes stream by, and what is made of it. The only door to the library
 * that does it. */
#ifndef VOR_SERVER_BASE_DIGEST_H
#define VOR_SERVER_BASE_DIGEST_H

#include <stddef.h>
#include <stdint.h>

/** 64 lower-case hexadecimal digits and their NUL. */
#define VOR_DIGEST_SIZE 65

/** A digest under way: the library's state. A copy goes on by itself. */
struct vor_digest {
    uint64_t state[14];
};

void vor_digest_begin(struct vor_digest *digest);
void vor_digest_update(struct vor_digest *digest, const void *bytes, size_t size);

/** Writes the digest of everything so far; updating may go on. */
void vor_digest_hex(const struct vor_digest *digest, char out[VOR_DIGEST_SIZE]);

/** The digest of bytes that are all there; and as a strong entity tag: 64 digits in quotes. */
void vor_digest_text(const void *bytes, size_t size, char out[VOR_DIGEST_SIZE]);
#define VOR_ETAG_SIZE (VOR_DIGEST_SIZE + 2)
void vor_digest_etag(const void *bytes, size_t size, char out[VOR_ETAG_SIZE]);

/** The digest of bytes that are all there, as bytes. */
#define VOR_DIGEST_BYTES 32
void vor_digest_of(const void *bytes, size_t size, uint8_t out[VOR_DIGEST_BYTES]);

/** The digest of `size` bytes of a file. False when they cannot be read, or memory is out.
 *
 *  Cost: reads them; not for HTTP threads. */
int vor_digest_file(int fd, uint64_t from, uint64_t size, char out[VOR_DIGEST_SIZE]);

/** HMAC-SHA-256 (RFC 2104) of bytes under a key of any length. */
void vor_digest_hmac(const void *key, size_t key_size, const void *bytes, size_t size,
                     uint8_t out[VOR_DIGEST_BYTES]);

/** True when both are the same, in a time that does not depend on what they are. */
int vor_digest_same(const uint8_t a[VOR_DIGEST_BYTES], const uint8_t b[VOR_DIGEST_BYTES]);

/** True for 64 such digits. */
int vor_digest_is_one(const char *text);

#endif
