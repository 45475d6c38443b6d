#include "proto/gzip.h"

#include <string.h>

#define ZLIB_CONST /* what zlib reads, it does not change */
#include <zlib.h>

enum {
    BLOCK = 32768,      /* bytes inflated at a time */
    FEED = 1 << 30,     /* bytes given to zlib at a time, which counts them in 32 bits */
    WINDOW = MAX_WBITS, /* any that gzip allows */
    GZIP_ONLY = 16,     /* added to WINDOW: neither zlib's own format nor raw deflate */
    MAGIC_1 = 0x1f,     /* the bytes that a member begins with */
    MAGIC_2 = 0x8b
};

struct inflation {
    z_stream stream;
    const struct vor_sink *sink;
    const uint8_t *bytes;
    size_t size, given;        /* given: how many of them zlib has got or had */
    uint64_t asked, most, out; /* most: asked, or less by the ratio */
    uint8_t block[BLOCK];
};

/* Of the body: how far zlib has read. */
static size_t position(const struct inflation *z)
{
    return z->given - z->stream.avail_in;
}

static vor_status refuse(const struct inflation *z, const char *what, struct vor_error *err)
{
    (void)vor_fail(err, VOR_E_REQUEST, "the gzip body %s at byte %zu of %zu", what, position(z),
                   z->size);
    if (err != NULL)
        err->byte_offset = (int64_t)position(z);
    return VOR_E_REQUEST;
}

/* Inflates up to a block. */
static vor_status step(struct inflation *z, int *done, struct vor_error *err)
{
    uint64_t room = z->most - z->out + 1; /* one more than may come, to see whether it does */
    size_t got;
    int code;

    if (z->stream.avail_in == 0) {
        size_t left = z->size - z->given;
        uInt piece = left < FEED ? (uInt)left : FEED;

        z->stream.next_in = z->bytes + z->given;
        z->stream.avail_in = piece;
        z->given += piece;
    }
    z->stream.next_out = z->block;
    z->stream.avail_out = room < BLOCK ? (uInt)room : BLOCK;
    code = inflate(&z->stream, Z_NO_FLUSH);
    got = (size_t)(z->stream.next_out - z->block);
    if (got == room) {
        if (z->most < z->asked)
            (void)vor_fail(err, VOR_E_BYTES,
                           "the gzip body of %zu bytes inflates to more than %llu bytes, want "
                           "at most %d times its size or 1 MiB, whichever is more",
                           z->size, (unsigned long long)z->most, VOR_GZIP_RATIO_MAX);
        else
            (void)vor_fail(err, VOR_E_BYTES,
                           "the gzip body of %zu bytes inflates to more than %llu bytes", z->size,
                           (unsigned long long)z->most);
        return vor_fail_over(err, VOR_E_BYTES, z->most, z->most + 1);
    }
    z->out += got;
    if (got > 0 && z->sink->write(z->sink->ctx, z->block, got) != 0)
        return vor_fail(err, VOR_E_IO, "the decompressed body cannot be stored");
    if (code == Z_STREAM_END) {
        size_t at = position(z);

        /* Behind the end of a member: another one begins, or the body is over. */
        *done = at == z->size;
        if (*done)
            return VOR_OK;
        if (z->size - at < 2 || z->bytes[at] != MAGIC_1 || z->bytes[at + 1] != MAGIC_2)
            return refuse(z, "has data after its end", err);
        return inflateReset(&z->stream) == Z_OK ? VOR_OK : refuse(z, "cannot be read", err);
    }
    if (code == Z_MEM_ERROR)
        return vor_fail(err, VOR_E_NOMEM, "decompressing a gzip body");
    if (code == Z_BUF_ERROR && position(z) == z->size)
        return refuse(z, "is cut short", err);
    if (code != Z_OK && code != Z_BUF_ERROR)
        return refuse(z, position(z) < 10 ? "is not gzip" : "is damaged", err);
    return VOR_OK;
}

vor_status vor_gzip_inflate(const struct vor_sink *sink, const uint8_t *bytes, size_t size,
                            uint64_t most, struct vor_error *err)
{
    struct inflation z;
    vor_status status = VOR_OK;
    int done = 0;
    uint64_t ratio;

    if (size == 0)
        return vor_fail(err, VOR_E_EMPTY, "the gzip body is empty: 0 bytes");
    memset(&z, 0, sizeof z);
    z.sink = sink;
    z.bytes = bytes;
    z.size = size;
    z.asked = most;
    ratio = (uint64_t)size * VOR_GZIP_RATIO_MAX;
    if (ratio < VOR_GZIP_FREE)
        ratio = VOR_GZIP_FREE;
    z.most = ratio < most ? ratio : most;
    if (inflateInit2(&z.stream, WINDOW + GZIP_ONLY) != Z_OK)
        return vor_fail(err, VOR_E_NOMEM, "decompressing a gzip body");
    while (status == VOR_OK && !done)
        status = step(&z, &done, err);
    (void)inflateEnd(&z.stream);
    return status;
}
