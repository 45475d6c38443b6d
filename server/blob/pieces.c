#include "server/blob/pieces.h"

#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WHOLE = VOR_DIGEST_SIZE - 1 };

/* Inputs have seals, and other formats of an output their digests behind them. */
int vor_pieces_are_for(const char *file)
{
    return strstr(file, ".input") == NULL && strstr(file, "-as-") == NULL;
}

vor_status vor_piece_read(int fd, uint64_t at, void *out, size_t size, struct vor_error *err)
{
    for (size_t have = 0; have < size;) {
        ssize_t got = pread(fd, (char *)out + have, size - have, (off_t)(at + have));

        if (got == 0 || (got < 0 && errno != EINTR))
            return vor_fail_errno(err, got < 0 ? errno : EIO, "a temporary file");
        have += got > 0 ? (size_t)got : 0;
    }
    return VOR_OK;
}

static size_t piece_size(uint64_t at, uint64_t end)
{
    return end - at < VOR_BLOB_PIECE ? (size_t)(end - at) : VOR_BLOB_PIECE;
}

vor_status vor_pieces_write(struct vor_text *out, int fd, uint64_t size, const char *sha256,
                            struct vor_error *err)
{
    struct vor_digest whole;
    uint8_t *piece = malloc(VOR_BLOB_PIECE), found[VOR_DIGEST_BYTES];
    char read_sha256[VOR_DIGEST_SIZE] = "";
    vor_status status =
        piece != NULL ? VOR_OK : vor_fail(err, VOR_E_NOMEM, "the checksum of a file");

    vor_digest_begin(&whole);
    vor_text_add(out, sha256, WHOLE);
    for (uint64_t at = 0; status == VOR_OK && at < size; at += VOR_BLOB_PIECE) {
        status = vor_piece_read(fd, at, piece, piece_size(at, size), err);
        if (status != VOR_OK)
            break;
        vor_digest_update(&whole, piece, piece_size(at, size));
        vor_digest_of(piece, piece_size(at, size), found);
        vor_text_add(out, found, sizeof found);
    }
    VOR_THEN(status, vor_text_status(out, err));
    if (status == VOR_OK) {
        vor_digest_hex(&whole, read_sha256);
        vor_digest_of(out->data, out->size, found);
        vor_text_add(out, found, sizeof found);
        status = strcmp(read_sha256, sha256) == 0
                     ? vor_text_status(out, err)
                     : vor_fail(err, VOR_E_DAMAGED,
                                "a temporary file does not contain what was written to it");
    }
    free(piece);
    return status;
}

const uint8_t *vor_pieces_of(const struct vor_text *text, const struct vor_blob_part *part)
{
    const uint8_t *bytes = (const uint8_t *)text->data;
    const uint64_t pieces = (part->size + VOR_BLOB_PIECE - 1) / VOR_BLOB_PIECE;
    uint8_t found[VOR_DIGEST_BYTES];

    if (text->failed || text->size != WHOLE + (pieces + 1) * sizeof found ||
        memcmp(bytes, part->sha256, WHOLE) != 0)
        return NULL;
    vor_digest_of(bytes, text->size - sizeof found, found);
    return memcmp(bytes + text->size - sizeof found, found, sizeof found) == 0 ? bytes + WHOLE
                                                                               : NULL;
}

/* --- arrivals --------------------------------------------------------------------------------- */

int vor_arrival_is_part(const struct vor_arrival *arrival)
{
    return arrival->digest != NULL && arrival->watch->part.to != UINT64_MAX;
}

static int put(struct vor_arrival *arrival, uint64_t at, const char *bytes, size_t size)
{
    for (size_t done = 0; done < size;) {
        ssize_t wrote = pwrite(arrival->fd, bytes + done, size - done, (off_t)(at + done));

        if (wrote < 0 && errno != EINTR) {
            (void)vor_fail_errno(&arrival->failure, errno, "a temporary file");
            return 0;
        }
        done += wrote > 0 ? (size_t)wrote : 0;
    }
    return 1;
}

static int refuse(struct vor_arrival *arrival)
{
    uint64_t piece = arrival->at / VOR_BLOB_PIECE;

    vor_log(VOR_LOG_ERROR, "stored bytes are damaged", VOR_TEXT("key", arrival->name),
            VOR_COUNT("piece", piece));
    vor_metric_add(VOR_METRIC_BLOB_ERRORS, 1, VOR_LABELS("damaged"));
    (void)vor_fail(&arrival->failure, VOR_E_DAMAGED,
                   "the stored file %s is damaged: the SHA-256 of a piece is not the one that was "
                   "recorded when it was written",
                   arrival->name);
    return 0;
}

static int pass_on(struct vor_arrival *arrival)
{
    const struct vor_blob_watch *watch = arrival->watch;
    uint8_t found[VOR_DIGEST_BYTES];

    vor_digest_of(arrival->piece, arrival->have, found);
    if (memcmp(found, arrival->digest + arrival->at / VOR_BLOB_PIECE * sizeof found,
               sizeof found) != 0)
        return refuse(arrival);
    if (!put(arrival, arrival->at - watch->part.from, (const char *)arrival->piece, arrival->have))
        return 0;
    arrival->at += arrival->have;
    arrival->have = 0;
    watch->came(watch->ctx, arrival->fd, arrival->at);
    return 1;
}

int vor_arrival_take(void *ctx, uint64_t at, const void *from, size_t size)
{
    struct vor_arrival *arrival = ctx;
    const char *bytes = from;

    if (arrival->digest == NULL) {
        /* What an attempt has written is no part of the next one. */
        if (at == 0 && ftruncate(arrival->fd, 0) != 0) {
            (void)vor_fail_errno(&arrival->failure, errno, "a temporary file");
            return 0;
        }
        return put(arrival, at, bytes, size);
    }
    if (arrival->at == arrival->end)
        return 1;
    if (at <= arrival->at) { /* the first ones, or of another attempt */
        size_t skipped = arrival->at - at < size ? (size_t)(arrival->at - at) : size;

        bytes += skipped;
        size -= skipped;
        arrival->have = 0;
    } else if (at != arrival->at + arrival->have) { /* some are missing */
        return refuse(arrival);
    }
    while (size > 0 && arrival->at < arrival->end) {
        size_t whole = piece_size(arrival->at, arrival->end);
        size_t more = size < whole - arrival->have ? size : whole - arrival->have;

        memcpy(arrival->piece + arrival->have, bytes, more);
        arrival->have += more;
        bytes += more;
        size -= more;
        if (arrival->have == whole && !pass_on(arrival))
            return 0;
    }
    return 1;
}

vor_status vor_arrival_end(struct vor_arrival *arrival)
{
    if (arrival->digest != NULL && arrival->at < arrival->end)
        (void)refuse(arrival);
    return arrival->failure.status;
}
