/** Blobs as files of a directory: PATH/keep/ID.NAME. What is being written is in PATH/tmp, and
 *  PATH/lock says that nobody else writes there, so that whatever is in tmp at the start is left
 *  over from a crash.
 *
 *  Cost of a commit: fsync, rename, fsync of the directory; 0.5 ms for 1 KB, 40 ms for 12 MB. */
#ifndef VOR_SERVER_BLOB_DIR_H
#define VOR_SERVER_BLOB_DIR_H

#include "server/blob/driver.h"

extern const struct vor_blob_driver vor_blob_dir;

#endif
