/** What store and blobs share: errors of the disk, directories, locks. */
#ifndef VOR_SERVER_BASE_DISK_H
#define VOR_SERVER_BASE_DISK_H

#include "core/base/status.h"

/** VOR_E_IO with "WHAT: REASON"; `got` keeps the errno, so that a full disk can be told apart. */
vor_status vor_fail_errno(struct vor_error *err, int number, const char *what);

/** The same for a file or folder that may not be written, or a folder that may not be made. When
 *  that is forbidden (EACCES, EPERM), says whose it is, or whose the folder above it is, which user
 *  this process is, and the chown, chmod or install that mends it. */
vor_status vor_fail_access(struct vor_error *err, int number, const char *path);

/** True when err is the VOR_E_IO of a full disk or quota: 507 rather than 503. */
int vor_error_storage_full(const struct vor_error *err);

/** True when err is the VOR_E_IO of a storage on another machine that does not answer now (EAGAIN:
 *  503), that refuses our keys or does not have our place (EKEYREJECTED: 500), or one of both. */
int vor_error_storage_away(const struct vor_error *err);
int vor_error_storage_refused(const struct vor_error *err);
int vor_error_storage_absent(const struct vor_error *err);

/** True when err is the VOR_E_IO of a change whose answer was lost (EINPROGRESS): it may have been
 *  made, or may yet be. */
int vor_error_may_be_done(const struct vor_error *err);

/** What follows "SCHEME:" in `where`, as in "sqlite:PATH"; NULL when `where` has another scheme or
 *  nothing follows. Borrowed from `where`. */
const char *vor_storage_place(const char *where, const char *scheme);

/** Makes a directory and its parents, mode 0700, unless they exist.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_storage_directory(const char *path, struct vor_error *err);

/** Takes the lock file at path for this process (flock: gone with the process, whatever ends it)
 *  and writes our process id into it; is_shared: together with others that share it, and says
 * nothing of who has it.
 *
 *  @param[out] fd      to be closed when the lock is to be given back
 *  @param[out] holder  0, or the process that has the lock (-1 when it has not said which it is)
 *
 *  @retval VOR_E_IO somebody has it (holder is not 0), or the file cannot be made */
VOR_NODISCARD vor_status vor_storage_lock(int *fd, const char *path, int is_shared, long *holder,
                                          struct vor_error *err);

#endif
