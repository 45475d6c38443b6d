/** Bytes that outlive a request: decoded uploads and results, by job and kind. */
#ifndef VOR_SERVER_BLOB_H
#define VOR_SERVER_BLOB_H

#include "core/base/status.h"
#include "proto/codec.h"
#include "server/base/digest.h"
#include "server/base/uuid.h"

#include <stdint.h>

/** What a job keeps: identifier, suffix of the file. */
#define VOR_BLOB_TABLE(X)                                                                          \
    X(INPUT, "input") /* the decoded, checked cloud (vor_dump_write); until the job ends */        \
    X(CLOUD, "cloud") /* the encoded result; until the job expires or is removed */

enum vor_blob_kind {
#define VOR_BLOB_ENUM(name, suffix) VOR_BLOB_##name,
    VOR_BLOB_TABLE(VOR_BLOB_ENUM)
#undef VOR_BLOB_ENUM
        VOR_BLOB_KINDS
};

/** All blobs of a daemon. Thread-safe. */
struct vor_blobs;

/** Opens "dir:PATH" (made if missing), takes its lock and removes what unfinished writes left.
 *
 *  @param[out] holder  as vor_storage_lock
 *
 *  @retval VOR_E_PARAM no "dir:" in front
 *  @retval VOR_E_IO    another process has it (holder is not 0), or the disk refuses */
VOR_NODISCARD vor_status vor_blobs_open(struct vor_blobs **out, const char *where, long *holder,
                                        struct vor_error *err);

/** blobs may be NULL; no writer may be open. */
void vor_blobs_close(struct vor_blobs *blobs);

/** Bytes an ordinary user can still write, and the size of the disk.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blobs_space(struct vor_blobs *blobs, uint64_t *available,
                                         uint64_t *total, struct vor_error *err);

/** A file being written, with its size and SHA-256 so far. One thread at a time. It is nothing
 * until committed: a crash leaves a temporary file that the next vor_blobs_open removes. */
struct vor_blob_writer;

/** @retval VOR_E_IO (vor_error_storage_full tells a full disk apart), VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_blob_create(struct vor_blobs *blobs, struct vor_blob_writer **out,
                                         struct vor_error *err);

/** @retval VOR_E_IO the bytes were not taken; the writer can only be discarded */
VOR_NODISCARD vor_status vor_blob_append(struct vor_blob_writer *writer, const void *bytes,
                                         size_t size, struct vor_error *err);

/** The same as a sink for codecs. When a codec then fails with VOR_E_IO, vor_blob_failure has the
 *  reason. */
struct vor_sink vor_blob_sink(struct vor_blob_writer *writer);

/** Fills err with the first failure of an append and returns its status, VOR_OK when there was
 *  none. */
vor_status vor_blob_failure(const struct vor_blob_writer *writer, struct vor_error *err);

uint64_t vor_blob_size(const struct vor_blob_writer *writer);
void vor_blob_sha256(const struct vor_blob_writer *writer, char out[VOR_DIGEST_SIZE]);

/** The file, for reading (pread, mmap); borrowed until commit or discard. */
int vor_blob_fd(const struct vor_blob_writer *writer);

/** Makes the bytes durable under (id, kind), replacing what was there: fsync, rename, fsync of the
 *  directory. The writer is gone either way.
 *
 *  @retval VOR_E_IO nothing (or the former blob) is there
 *
 *  Cost: 0.5 ms for 1 KB, 40 ms for 12 MB: not for HTTP threads. */
VOR_NODISCARD vor_status vor_blob_commit(struct vor_blob_writer *writer, const struct vor_uuid *id,
                                         enum vor_blob_kind kind, struct vor_error *err);

/** Removes the temporary file. writer may be NULL. */
void vor_blob_discard(struct vor_blob_writer *writer);

/** Opens a blob for reading; the caller closes *fd, which stays readable after a drop.
 *
 *  @param[out] found  0 when there is none; *fd is then -1
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_get(struct vor_blobs *blobs, const struct vor_uuid *id,
                                      enum vor_blob_kind kind, int *fd, uint64_t *size, int *found,
                                      struct vor_error *err);

/** Removes a blob; that there is none is fine.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_drop(struct vor_blobs *blobs, const struct vor_uuid *id,
                                       enum vor_blob_kind kind, struct vor_error *err);

/** Drops every blob that keep answers 0 for, and every file that is no blob.
 *
 *  @param[out] dropped  how many
 *
 *  @retval VOR_E_IO the directory cannot be read */
VOR_NODISCARD vor_status vor_blobs_sweep(struct vor_blobs *blobs,
                                         int (*keep)(void *ctx, const struct vor_uuid *id,
                                                     enum vor_blob_kind kind),
                                         void *ctx, size_t *dropped, struct vor_error *err);

#endif
