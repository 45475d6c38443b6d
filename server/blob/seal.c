/* Are bytes still what was written? Seals, and digests of files. */
#include "server/blob/blob.h"

#include <string.h>

/* What stands behind sealed bytes. */
struct seal {
    char mark[8];
    char sha256[64]; /* without a NUL */
};

_Static_assert(sizeof(struct seal) == VOR_BLOB_SEAL_SIZE, "no padding in the file");

static const char mark[8] = {'\n', 's', 'h', 'a', '2', '5', '6', ' '};

vor_status vor_blob_seal(struct vor_blob_writer *writer, struct vor_error *err)
{
    char sha256[VOR_DIGEST_SIZE];
    struct seal seal;

    vor_blob_sha256(writer, sha256);
    memcpy(seal.mark, mark, sizeof mark);
    memcpy(seal.sha256, sha256, sizeof seal.sha256);
    return vor_blob_append(writer, &seal, sizeof seal, err);
}

static vor_status damaged(const char *name, struct vor_error *err)
{
    return vor_fail(err, VOR_E_DAMAGED,
                    "the stored file %s is damaged: its SHA-256 is not the one that was recorded "
                    "when it was written",
                    name);
}

vor_status vor_blob_unseal(const uint8_t *bytes, size_t *size, const char *name,
                           struct vor_error *err)
{
    char found[VOR_DIGEST_SIZE];
    struct seal seal;

    if (*size < sizeof seal || memcmp(bytes + *size - sizeof seal, mark, sizeof mark) != 0)
        return VOR_OK;
    memcpy(&seal, bytes + *size - sizeof seal, sizeof seal);
    vor_digest_text(bytes, *size - sizeof seal, found);
    if (memcmp(found, seal.sha256, sizeof seal.sha256) != 0)
        return damaged(name, err);
    *size -= sizeof seal;
    return VOR_OK;
}

vor_status vor_blob_compare(int fd, uint64_t size, const char *sha256, const char *name,
                            struct vor_error *err)
{
    char found[VOR_DIGEST_SIZE];

    if (!vor_digest_is_one(sha256))
        return VOR_OK;
    if (!vor_digest_file(fd, 0, size, found) || strcmp(found, sha256) != 0)
        return damaged(name, err);
    return VOR_OK;
}

vor_status vor_blob_recheck(const struct vor_blob_writer *writer, struct vor_error *err)
{
    if (!writer->is_whole)
        return VOR_OK;
    return vor_blob_compare(writer->fd, writer->size, writer->sha256, "of the other job", err);
}
