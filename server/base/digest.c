#include "server/base/digest.h"

#include <errno.h>
#include <nettle/base16.h>
#include <nettle/hmac.h>
#include <nettle/memops.h>
#include <nettle/sha2.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

_Static_assert(sizeof(struct sha256_ctx) <= sizeof(struct vor_digest), "its state has room");

#define OF(digest) ((struct sha256_ctx *)(digest)->state)

void vor_digest_begin(struct vor_digest *digest)
{
    sha256_init(OF(digest));
}

void vor_digest_update(struct vor_digest *digest, const void *bytes, size_t size)
{
    sha256_update(OF(digest), size, bytes);
}

void vor_digest_hex(const struct vor_digest *digest, char out[VOR_DIGEST_SIZE])
{
    struct vor_digest copy = *digest; /* reading the digest resets it */
    uint8_t bytes[SHA256_DIGEST_SIZE];

    sha256_digest(OF(&copy), sizeof bytes, bytes);
    base16_encode_update(out, sizeof bytes, bytes);
    out[VOR_DIGEST_SIZE - 1] = '\0';
}

void vor_digest_text(const void *bytes, size_t size, char out[VOR_DIGEST_SIZE])
{
    struct vor_digest digest;

    vor_digest_begin(&digest);
    vor_digest_update(&digest, bytes, size);
    vor_digest_hex(&digest, out);
}

void vor_digest_etag(const void *bytes, size_t size, char out[VOR_ETAG_SIZE])
{
    vor_digest_text(bytes, size, out + 1);
    out[0] = out[VOR_ETAG_SIZE - 2] = '"';
    out[VOR_ETAG_SIZE - 1] = '\0';
}

void vor_digest_of(const void *bytes, size_t size, uint8_t out[VOR_DIGEST_BYTES])
{
    struct sha256_ctx state;

    sha256_init(&state);
    sha256_update(&state, size, bytes);
    sha256_digest(&state, VOR_DIGEST_BYTES, out);
}

int vor_digest_file(int fd, uint64_t from, uint64_t size, char out[VOR_DIGEST_SIZE])
{
    enum { BLOCK = 1 << 18 }; /* bytes */
    const uint64_t end = from + size;
    struct vor_digest digest;
    uint8_t *block = malloc(BLOCK);

    vor_digest_begin(&digest);
    while (block != NULL && from < end) {
        ssize_t got =
            pread(fd, block, end - from < BLOCK ? (size_t)(end - from) : BLOCK, (off_t)from);

        if (got == 0 || (got < 0 && errno != EINTR))
            break;
        if (got < 0)
            continue;
        vor_digest_update(&digest, block, (size_t)got);
        from += (uint64_t)got;
    }
    free(block);
    vor_digest_hex(&digest, out);
    return block != NULL && from == end;
}

void vor_digest_hmac(const void *key, size_t key_size, const void *bytes, size_t size,
                     uint8_t out[VOR_DIGEST_BYTES])
{
    struct hmac_sha256_ctx state;

    hmac_sha256_set_key(&state, key_size, key);
    hmac_sha256_update(&state, size, bytes);
    hmac_sha256_digest(&state, VOR_DIGEST_BYTES, out);
}

int vor_digest_same(const uint8_t a[VOR_DIGEST_BYTES], const uint8_t b[VOR_DIGEST_BYTES])
{
    return memeql_sec(a, b, VOR_DIGEST_BYTES);
}

int vor_digest_is_one(const char *text)
{
    return strlen(text) == VOR_DIGEST_SIZE - 1 &&
           strspn(text, "0123456789abcdef") == VOR_DIGEST_SIZE - 1;
}
