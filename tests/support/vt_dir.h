/** A directory of a test's own, and clouds as files, for what the daemon keeps on disk. */
#ifndef VT_DIR_H
#define VT_DIR_H

#include "server/base/log.h"
#include "server/blob/blob.h"
#include "server/store/store.h"

#include <stddef.h>

/** A program whose daemons log no more than that. */
#define VT_LOG(level)                                                                              \
    void vt_suite(Suite *suite VOR_UNUSED)                                                         \
    {                                                                                              \
        vor_log_open(2, level);                                                                    \
    }

/** Makes an empty directory under $TMPDIR or /tmp. It goes, with everything in it, when the process
 *  that made it exits, be it by a failed test. */
const char *vt_dir_make(void);

/** Files in path/name, or -1 when it is no directory. */
int vt_dir_count(const char *path, const char *name);

/** Blobs and store of a daemon with that data directory; fails the test when they cannot be opened.
 *  The blobs are of the driver that $VT_BLOBS names, likewise.
 *  The store is of the driver that $VT_STORE names, by its scheme, or of the first one; with
 *  $VT_LISTEN, a server without a pooler, it is shared, and listens there. */
struct vor_blobs *vt_dir_blobs(const char *path);
struct vor_blobs *vt_dir_small_blobs(const char *path); /**< small ones in a store of its own */
struct vor_store *vt_dir_store(const char *path);

/** The same with a driver of the table instead of the one that a daemon has by default. */
struct vor_store *vt_dir_store_of(const struct vor_store_driver *driver, const char *path);

/** The bytes of a cloud as PLY in an upload. */
struct vor_blob_writer *vt_upload_cloud(struct vor_blobs *blobs, const struct vor_cloud *cloud);

/** Any bytes in an upload. */
struct vor_blob_writer *vt_upload(struct vor_blobs *blobs, const void *bytes, size_t size);

/** Text as a blob; what a blob holds, "" when there is none, static. */
void vt_blob_put(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                 const char *text);
const char *vt_blob_text(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name);

/** A row to insert: id fresh, `points` asked for of a cloud of 100. */
struct vor_job_view vt_row(unsigned points);

/** The row of a job that there is. */
struct vor_job_view vt_stored(struct vor_store *store, const struct vor_uuid *id);

/** Who claims here, and his lease of an attempt. */
#define VT_OWNER "a former life"
#define VT_LEASE(number) (&(struct vor_lease){VT_OWNER, number})

/** Claims the job that is next: its attempt, or 0 when there is none. id, if it is not NULL, is the
 *  one that it must be. */
uint32_t vt_claim(struct vor_store *store, const struct vor_uuid *id);

/** Appends event number `last`, whose piece is the letter of that place from "a" on, and notes the
 *  progress; true when the lease holds. */
int vt_append(struct vor_store *store, struct vor_job_view row, int progress,
              const struct vor_lease *lease, uint32_t last);

/** The pieces of an attempt after an event, as "2:c ": number of the last and bytes, 0 for NUL. */
void vt_events(struct vor_store *store, const struct vor_uuid *id, uint32_t attempt, uint32_t after,
               char *out);

/** Runs act(ctx) in a child that must die by its own SIGKILL. */
void vt_killed(void (*act)(void *ctx), void *ctx);

#endif
