#include "server/base/digest.h"

#include <errno.h>
#include <nettle/base16.h>
#include <nettle/hmac.h>
#include <nettle/memops.h>
#include <nettle/sha2.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct vor_digest {
    struct sha256_ctx state;
};

static void write_hex(struct sha256_ctx *state, char out[VOR_DIGEST_SIZE])
{
    uint8_t bytes[SHA256_DIGEST_SIZE];

    sha256_digest(state, sizeof bytes, bytes);
    base16_encode_update(out, sizeof bytes, bytes);
    out[VOR_DIGEST_SIZE - 1] = '\0';
}

struct vor_digest *vor_digest_create(void)
{
    struct vor_digest *digest = malloc(sizeof *digest);

    if (digest != NULL)
        sha256_init(&digest->state);
    return digest;
}

void vor_digest_update(struct vor_digest *digest, const void *bytes, size_t size)
{
    sha256_update(&digest->state, size, bytes);
}

void vor_digest_hex(const struct vor_digest *digest, char out[VOR_DIGEST_SIZE])
{
    struct sha256_ctx state = digest->state; /* reading the digest would reset it */

    write_hex(&state, out);
}

void vor_digest_etag(const void *bytes, size_t size, char out[VOR_ETAG_SIZE])
{
    struct sha256_ctx state;

    sha256_init(&state);
    sha256_update(&state, size, bytes);
    out[0] = '"';
    write_hex(&state, out + 1);
    out[VOR_ETAG_SIZE - 2] = '"';
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
    struct sha256_ctx state;
    uint8_t *block = malloc(BLOCK);

    sha256_init(&state);
    while (block != NULL && from < end) {
        ssize_t got =
            pread(fd, block, end - from < BLOCK ? (size_t)(end - from) : BLOCK, (off_t)from);

        if (got == 0 || (got < 0 && errno != EINTR))
            break;
        if (got < 0)
            continue;
        sha256_update(&state, (size_t)got, block);
        from += (uint64_t)got;
    }
    free(block);
    write_hex(&state, out);
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

void vor_digest_destroy(struct vor_digest *digest)
{
    free(digest);
}
