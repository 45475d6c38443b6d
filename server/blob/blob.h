/** Bytes that outlive a request, by job and name: decoded uploads and results. The door to
 *  whichever driver --blobs names.
 *
 *  Which blob of a job is which of its artefacts:
 *
 *    "input"       the input cloud: decoded and checked (vor_dump_write), kept until the job ends
 *    "input-NAME"  the input of that name, likewise
 *    "input-checkpoint"  what its run goes on from if it is lost; no input has that name
 *    "upload"      the input cloud as it came, kept for whoever wants it again
 *    "upload-NAME" the input of that name, likewise
 *    "NAME"        the output of that name: a cloud in its format or a document in JSON, kept until
 *                  the job expires or is removed
 *    "NAME-try-K"  the same of attempt K, from 2 on
 *    "store" of the job whose identifier is all zeros: whose blobs these are (vor_blobs_claim)
 *    "NAME-as-FORMAT"  that cloud in another format, and behind it the SHA-256 of its bytes in 64
 *                  digits; kept as long, and made anew when asked for
 *
 *  So no output is called "input" or "upload", nor anything that begins with one of these and a
 *  hyphen. */
#ifndef VOR_SERVER_BLOB_H
#define VOR_SERVER_BLOB_H

#include "proto/codec.h"
#include "server/blob/driver.h"

/** In place of an input's name: the last checkpoint of the run. */
#define VOR_BLOB_CHECKPOINT "checkpoint"

/** The name of the blob of an input, as above. Returns out.
 *
 *  @param[in] input  the input's name, at most VOR_BLOB_NAME_MAX - 6 bytes */
const char *vor_blob_of_input(const char *input, char out[VOR_BLOB_NAME_MAX + 1]);

/** The same for an input as it came, and whether a blob is one. */
const char *vor_blob_of_upload(const char *input, char out[VOR_BLOB_NAME_MAX + 1]);
int vor_blob_is_upload(const char *name);

/** The name of the blob of an output, as above: an attempt that has lost its job replaces nothing
 * of the one that has it. Returns out.
 *
 *  @param[in] output  the output's name, at most 20 bytes
 *  @param[in] attempt  of the row */
const char *vor_blob_of_output(const char *output, uint32_t attempt,
                               char out[VOR_BLOB_NAME_MAX + 1]);

/** The name of the blob of an output in another format, as above. Returns out.
 *
 *  @param[in] output  the output's name, at most VOR_BLOB_NAME_MAX - 4 bytes less than the format's
 */
const char *vor_blob_of_converted(const char *output, const char *format,
                                  char out[VOR_BLOB_NAME_MAX + 1]);

/** Bytes of the disk that stay free unless vor_blobs_set_reserve says otherwise, so that jobs under
 *  way can end. */
#define VOR_BLOBS_RESERVE ((uint64_t)16 << 20)

/** Opens "SCHEME:PLACE" ("dir:PATH": made if missing; "s3:URL"; "postgres:URI" or
 *  "postgresql://..."), takes the lock of its folder and
 *  removes what unfinished writes left there, and whatever else is no blob.
 *
 *  @param[in]  cache   for a driver whose blobs are elsewhere: made if missing
 *  @param[out] holder  as vor_storage_lock
 *
 *  @retval VOR_E_IO no driver has this scheme, another process has it (holder is not 0), or the
 * disk refuses */
VOR_NODISCARD vor_status vor_blobs_open(struct vor_blobs **out, const char *where,
                                        const struct vor_blob_cache *cache, long *holder,
                                        struct vor_error *err);

/** Notes whose blobs these are, or compares: two stores with the same blobs would take each other's
 *  for strays.
 *
 *  @param[in] store     of the jobs: a secret; "" where it has none, and nothing is noted
 *  @param[in] is_joined other daemons use the store now: a folder that notes nothing is not theirs
 *
 *  @retval VOR_E_IO they are another store's, or that is not known */
VOR_NODISCARD vor_status vor_blobs_claim(struct vor_blobs *blobs, const char *store, int is_joined,
                                         struct vor_error *err);

/** From now on blobs of few bytes in files of this machine are kept there: a commit of one waits
 * for no disk, and is durable with the next durable change of a row. Once, before other threads
 * know the blobs.
 *
 *  @param[in] small  borrowed; NULL for none
 *
 *  @retval VOR_E_IO also when there are small files already, and these blobs cannot be any */
VOR_NODISCARD vor_status vor_blobs_keep_small(struct vor_blobs *blobs,
                                              const struct vor_small_files *small,
                                              struct vor_error *err);

/** blobs may be NULL; no writer may be open. */
void vor_blobs_close(struct vor_blobs *blobs);

/** Bytes an ordinary user can still write, and the size of the disk.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blobs_space(struct vor_blobs *blobs, uint64_t *available,
                                         uint64_t *total, struct vor_error *err);

/** Bytes of all blobs, and the scheme of their driver ("dir"). No cost: it is counted along. */
uint64_t vor_blobs_bytes(const struct vor_blobs *blobs);
const char *vor_blobs_scheme(const struct vor_blobs *blobs);

/** How many bytes stay free. Before other threads know the blobs. */
void vor_blobs_set_reserve(struct vor_blobs *blobs, uint64_t bytes);

/** Is there room for so many bytes more, besides those that stay free and those promised to others?
 *
 *  @retval VOR_E_IO there is not (vor_error_storage_full; message: bytes, free ones, reserve), or
 * as vor_blobs_space */
VOR_NODISCARD vor_status vor_blobs_room(struct vor_blobs *blobs, uint64_t bytes,
                                        struct vor_error *err);

/** True when there was no room for some bytes since the last call, and there still is none. */
int vor_blobs_lack_room(struct vor_blobs *blobs);

/** @retval VOR_E_IO since a commit failed with EIO: nothing is known about the disk any more */
VOR_NODISCARD vor_status vor_blobs_check(struct vor_blobs *blobs, struct vor_error *err);

/** VOR_OK while the machine that has the blobs answers and lets us in, as was last seen; for
 *  /readyz, and before work is begun. Asks nobody.
 *
 *  @retval VOR_E_IO vor_error_storage_away or vor_error_storage_refused: it may come back */
VOR_NODISCARD vor_status vor_blobs_reach(struct vor_blobs *blobs, struct vor_error *err);

/** The process ends: from now on no request to another machine takes more than two seconds, those
 * under way included. */
void vor_blobs_hurry(struct vor_blobs *blobs);

/** Begins a blob, of which size and SHA-256 are known as it grows. A writer belongs to one thread
 *  at a time. Nothing of it is kept until it is committed, not after a crash either.
 *
 *  @retval VOR_E_IO (vor_error_storage_full tells a full disk apart), VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_blob_create(struct vor_blobs *blobs, struct vor_blob_writer **out,
                                         struct vor_error *err);

/** Has room kept for bytes that will come, until they have come or the writer ends. From now on the
 *  writer never takes what is to stay free: bytes beyond a promise have room kept for them as they
 *  come, and fail for a full disk where there is none. Call once, before the first byte.
 *
 *  @param[in] bytes  how many are known to come; 0 for none
 *
 *  @retval VOR_E_IO as vor_blobs_room */
VOR_NODISCARD vor_status vor_blob_promise(struct vor_blob_writer *writer, uint64_t bytes,
                                          struct vor_error *err);

/** Begins a blob with the bytes of another one, to which nothing can be appended. They stay there
 *  for this writer when the other one is dropped, and take no room of their own where the driver
 * can share them.
 *
 *  @param[out] found  0 when there is no such blob; *out is then NULL
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM
 *
 *  Cost: none but opening a file; the commit copies the bytes where they cannot be shared. */
VOR_NODISCARD vor_status vor_blob_reopen(struct vor_blobs *blobs,
                                         const struct vor_blob_source *from,
                                         struct vor_blob_writer **out, int *found,
                                         struct vor_error *err);

/** So many bytes, or nearly, will come by its descriptor (vor_blob_fd, vor_blob_adopt) and not by
 *  appending. Before the first one, and before anybody has the descriptor.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_expect(struct vor_blob_writer *writer, uint64_t bytes,
                                         struct vor_error *err);

/** @retval VOR_E_IO the bytes were not taken; the writer can only be discarded */
VOR_NODISCARD vor_status vor_blob_append(struct vor_blob_writer *writer, const void *bytes,
                                         size_t size, struct vor_error *err);

/** Appends bytes of a file, from a place on.
 *
 *  @retval VOR_E_IO also when the file has not so many */
VOR_NODISCARD vor_status vor_blob_append_file(struct vor_blob_writer *writer, int fd, uint64_t from,
                                              uint64_t size, struct vor_error *err);

/** The same as a sink for codecs. When a codec fails with VOR_E_IO, vor_blob_failure has the
 *  reason. */
struct vor_sink vor_blob_sink(struct vor_blob_writer *writer);

/** Fills err with the first failure of an append and returns its status, VOR_OK when there was
 *  none. */
vor_status vor_blob_failure(const struct vor_blob_writer *writer, struct vor_error *err);

uint64_t vor_blob_size(const struct vor_blob_writer *writer);
void vor_blob_sha256(const struct vor_blob_writer *writer, char out[VOR_DIGEST_SIZE]);

/** VOR_E_DAMAGED when the writer has the bytes of another blob, and they are not those of its
 * digest any more. Cost: one pass of SHA-256 over those. */
VOR_NODISCARD vor_status vor_blob_recheck(const struct vor_blob_writer *writer,
                                          struct vor_error *err);

/** Bytes of a seal: a digest without its NUL. */
#define VOR_BLOB_SEAL_SIZE (VOR_DIGEST_SIZE - 1)

/** Puts a seal behind the bytes: their digest. For blobs whose digest stands nowhere else; call
 * once, then commit.
 *
 *  @retval VOR_E_IO as vor_blob_append */
VOR_NODISCARD vor_status vor_blob_seal(struct vor_blob_writer *writer, struct vor_error *err);

/** Takes the seal off the bytes of a blob and compares: *size becomes that of what was sealed.
 *
 *  @param[in] name  of the blob, for the message
 *
 *  @retval VOR_E_DAMAGED they are not what was sealed
 *  @retval VOR_E_NOMEM
 *
 *  Cost: one pass of SHA-256. */
VOR_NODISCARD vor_status vor_blob_unseal(const uint8_t *bytes, size_t *size, const char *name,
                                         struct vor_error *err);

/** VOR_E_DAMAGED unless the first `size` bytes of a blob have this digest; VOR_OK if it is none.
 *  Cost: reads them; not for HTTP threads. */
VOR_NODISCARD vor_status vor_blob_compare(int fd, uint64_t size, const char *sha256,
                                          const char *name, struct vor_error *err);

/** The commit will not wait for the disk: a crash of the machine soon after it may leave less of
 * the bytes than there were, or none. For bytes whose digest is checked when they are read, and
 * that no job needs. */
void vor_blob_be_lazy(struct vor_blob_writer *writer);

/** For a commit that waits for another machine: whether it is tried again while vor_blobs_reach
 * fails, and whether it is still wanted, at any moment; else it fails as if they were away. */
void vor_blob_be_patient(struct vor_blob_writer *writer, const struct vor_blob_patience *patience);

/** The file, for reading (pread, mmap); borrowed until commit or discard. */
int vor_blob_fd(const struct vor_blob_writer *writer);

/** A writer of an open file that no driver knows, for a process that was given nothing but a
 *  descriptor: it appends and digests, and cannot be committed. fd stays the caller's. NULL when
 *  memory is out. */
struct vor_blob_writer *vor_blob_borrow(int fd);

/** Takes bytes that another process has written to a writer's file for bytes that were appended to
 *  it. Nothing was appended before, and nothing can be after.
 *
 *  @retval VOR_E_INTERNAL the file does not have that size; the writer can only be discarded
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_adopt(struct vor_blob_writer *writer, uint64_t size,
                                        const char sha256[VOR_DIGEST_SIZE], struct vor_error *err);

/** Makes the bytes durable as `name` of job id, in place of what was there. The writer is gone
 *  either way.
 *
 *  @param[in] name  1 .. VOR_BLOB_NAME_MAX of a-z, 0-9, '-' and '_', as everywhere below
 *
 *  @retval VOR_E_IO nothing (or the former blob) is there
 *
 *  Cost: waits for the disk; not for HTTP threads. */
VOR_NODISCARD vor_status vor_blob_commit(struct vor_blob_writer *writer, const struct vor_uuid *id,
                                         const char *name, struct vor_error *err);

/** Ends a writer and leaves nothing. writer may be NULL. */
void vor_blob_discard(struct vor_blob_writer *writer);

/** Opens a blob for reading; the caller closes *fd, which stays readable after a drop.
 *
 *  @param[out] fd     NULL: it is not opened, only looked for
 *  @param[out] found  0 when there is none; *fd is then -1
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_get(struct vor_blobs *blobs, const struct vor_uuid *id,
                                      const char *name, int *fd, uint64_t *size, int *found,
                                      struct vor_error *err);

/** False when vor_blob_get would wait for another machine, as it does for a blob that was not read
 *  here lately: then it is not for HTTP threads. */
int vor_blob_is_near(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name);

/** Makes a blob near, and tells of its bytes meanwhile. Where only a part is wanted, and the pieces
 *  have digests, that part is told of, and the blob is no nearer.
 *
 *  @param[out] found  0 when there is none
 *
 *  @retval VOR_E_DAMAGED a piece is not what was written; those before it were told of
 *  @retval VOR_E_IO, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_blob_bring(struct vor_blobs *blobs, const struct vor_uuid *id,
                                        const char *name, const struct vor_blob_watch *watch,
                                        int *found, struct vor_error *err);

/** Where clients find the blobs, as --blobs-public-url says ("": nowhere); borrowed. Before other
 *  threads know the blobs. */
void vor_blobs_set_public_url(struct vor_blobs *blobs, const char *url);

/** Writes the URL by which anybody can read a blob where it lies, for a short time. Asks nobody:
 * the blob may not be there. Nothing is checked for the reader, who knows its digest from
 * elsewhere.
 *
 *  @param[out] out  nothing is added where there is no such URL
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_blob_link(struct vor_blobs *blobs, const struct vor_uuid *id,
                                       const char *name, const struct vor_blob_reading *reading,
                                       struct vor_text *out, struct vor_error *err);

/** Removes a blob; it is no error when there is none.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_drop(struct vor_blobs *blobs, const struct vor_uuid *id,
                                       const char *name, struct vor_error *err);

/** Blobs of jobs, by their names. */
struct vor_blob_list {
    struct vor_blob_entry {
        struct vor_uuid id;
        char name[VOR_BLOB_NAME_MAX + 1];
    } * entry; /**< the list's owner frees it */
    size_t count, capacity;
};

/** Adds every blob that there is to a list, in any order.
 *
 *  @retval VOR_E_IO the blobs cannot be listed
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_blobs_list(struct vor_blobs *blobs, struct vor_blob_list *out,
                                        struct vor_error *err);

#endif
