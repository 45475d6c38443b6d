/* Are bytes still what was written? Seals, and digests of files. */
#include "server/blob/blob.h"

#include <string.h>

vor_status vor_blob_seal(struct vor_blob_writer *writer, struct vor_error *err)
{
    char sha256[VOR_DIGEST_SIZE];

    vor_blob_sha256(writer, sha256);
    return vor_blob_append(writer, sha256, VOR_BLOB_SEAL_SIZE, err);
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

    if (*size < VOR_BLOB_SEAL_SIZE)
        return damaged(name, err);
    *size -= VOR_BLOB_SEAL_SIZE;
    vor_digest_text(bytes, *size, found);
    return memcmp(found, bytes + *size, VOR_BLOB_SEAL_SIZE) == 0 ? VOR_OK : damaged(name, err);
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
