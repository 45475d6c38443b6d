/** Blobs as files of a directory: PATH/keep/ID.NAME. What is being written is in PATH/tmp, and
 *  PATH/lock says that nobody else writes there, so that whatever is in tmp at the start is left
 *  over from a crash. Processes that share the directory, be it of a file system of several
 *  machines, share the lock, and each locks its files in tmp: those that nobody has locked are left
 *  over.
 *
 *  Small blobs of one daemon are no files, but stand beside the rows (vor_blobs_keep_small); until
 *  it is known how large one is, it is in memory.
 *
 *  Cost of a commit: fsync, rename, fsync of the directory; 0.5 ms for 1 KB, 40 ms for 12 MB. */
#ifndef VOR_SERVER_BLOB_DIR_H
#define VOR_SERVER_BLOB_DIR_H

#include "server/blob/driver.h"

extern const struct vor_blob_driver vor_blob_dir;

/** Its blobs. Those of a driver that keeps copies in such a directory begin with it, so that the
 *  functions of vor_blob_dir work on them. */
struct vor_blob_directory {
    struct vor_blobs base;
    int lock, parent, keep, tmp; /**< file descriptors, -1 before it is opened */
    int is_shared;               /**< set it before the opening */
};

/** Opens PATH and what is below it, as above. Close it in any case.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_blob_directory_open(struct vor_blob_directory *directory,
                                                 const char *path, long *holder,
                                                 struct vor_error *err);
void vor_blob_directory_close(struct vor_blob_directory *directory);

/** Functions of vor_blob_dir that such a driver has as they are. */
VOR_NODISCARD vor_status vor_blob_directory_space(struct vor_blobs *blobs, uint64_t *available,
                                                  uint64_t *total, struct vor_error *err);
VOR_NODISCARD vor_status vor_blob_directory_create(struct vor_blobs *blobs,
                                                   struct vor_blob_writer **out,
                                                   struct vor_error *err);
void vor_blob_directory_discard(struct vor_blob_writer *writer);

/** The name of the blob that a file holds, and its job; NULL when the file is no blob. */
const char *vor_blob_of_file(struct vor_uuid *id, const char *file);

#endif
