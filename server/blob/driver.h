/** What a store of blobs is made of: a table of functions, one table for each kind of place. A
 *  driver's own header declares its table, and blob.c lists it. Callers include blob.h.
 *
 *  A blob is written to a file and read from a file, whatever the driver does with it in between:
 *  codecs map it, and HTTP sends it without a copy. Every function may be called from any thread.
 */
#ifndef VOR_SERVER_BLOB_DRIVER_H
#define VOR_SERVER_BLOB_DRIVER_H

#include "core/base/status.h"
#include "proto/text.h"
#include "server/base/digest.h"
#include "server/base/small_files.h"
#include "server/base/uuid.h"

#include <stdatomic.h>
#include <stdint.h>

enum {
    VOR_BLOB_NAME_MAX = 40, /**< bytes of a blob's name */
    VOR_BLOB_FILE_SIZE = 36 + 1 + VOR_BLOB_NAME_MAX + 1
};

/** A driver's blobs begin with this; the door fills it in. */
struct vor_blobs {
    const struct vor_blob_driver *driver;
    uint64_t reserve;          /**< bytes of the disk that stay free */
    const char *public_url;    /**< where clients find the blobs; "" or NULL: nowhere. Borrowed */
    atomic_int is_broken;      /**< an fsync failed */
    _Atomic uint64_t promised; /**< bytes that writers may still write (vor_blob_promise) */
    _Atomic uint64_t refused;  /**< bytes that there was no room for, since the last look */
    _Atomic uint64_t bytes;    /**< of all blobs; the driver's */
    const struct vor_small_files *small; /**< NULL: small blobs are files as well; borrowed */
};

/** A blob that is there, and its digest. */
struct vor_blob_source {
    struct vor_uuid id;
    char name[VOR_BLOB_NAME_MAX + 1];
    char sha256[VOR_DIGEST_SIZE];
};

/** Who waits for a commit; all may be NULL. */
struct vor_blob_patience {
    /** Lets time pass while the blobs are away: true when it is to be tried again. NULL: it is not.
     */
    int (*may_wait)(void *ctx, const struct vor_error *why);
    int (*is_wanted)(void *ctx); /**< asked once a second or more often; NULL: it is */
    void *ctx;
};

/** A blob being written. A driver's writer begins with this; the driver opens fd, the door does the
 *  rest. */
struct vor_blob_writer {
    struct vor_blobs *blobs;
    int fd; /**< open for reading and writing; the driver closes it */
    uint64_t size;
    int is_lazy;                  /**< the commit need not be durable */
    int is_in_memory;             /**< fd is no file of a disk, as long as its bytes are few */
    int is_promised;              /**< every byte needs a promise (vor_blob_promise) */
    uint64_t promised;            /**< bytes that are still to come */
    int is_whole;                 /**< the bytes are those of another blob, or all there */
    struct vor_digest digest;     /**< else */
    char sha256[VOR_DIGEST_SIZE]; /**< then */
    struct vor_blob_patience patience;
    struct vor_error failure; /**< of the first append that failed; else its status is VOR_OK */
};

/** Where a driver whose blobs are elsewhere keeps files under way, and copies; and who else has the
 *  blobs. */
struct vor_blob_cache {
    const char *data; /**< they are in its folder "cache" */
    uint64_t bytes;   /**< that copies may take */
    int is_shared;    /**< other processes may use the same folder at the same time */
};

/** Bytes of a piece, each of which has a digest of its own where blobs are on another machine. */
enum { VOR_BLOB_PIECE = 1 << 20 };

/** Which bytes of a blob are wanted: from a piece's first on, up to a piece's last, or UINT64_MAX
 * for all of them. */
struct vor_blob_part {
    uint64_t from, to;
    uint64_t size;                /**< of the blob */
    char sha256[VOR_DIGEST_SIZE]; /**< of the blob; "" where it is not known */
};

/** Who is told of the bytes of a blob as they come from another machine, piece by piece: those from
 *  part.from up to `have` are right, and stand in fd, which is the caller's, from its beginning on.
 *  Of a blob without digests of its pieces nothing is told. */
struct vor_blob_watch {
    void (*came)(void *ctx, int fd, uint64_t have);
    void *ctx;
    struct vor_blob_part part;
};

enum { VOR_BLOB_LINK_SECONDS = 120 }; /**< for which a link to a blob is good */

/** Who reads a blob where it lies, and how the answer is to name it. */
struct vor_blob_reading {
    const char *method; /**< "GET" or "HEAD": the link is good for that alone */
    const char *media_type, *disposition;
};

/** The functions of a driver. Each does what the function of blob.h with its name promises. A file
 *  is the blob of a job: "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11.input". */
struct vor_blob_driver {
    const char *scheme; /**< "dir": what stands before the colon of --blobs */
    const char *place;  /**< "PATH": what stands after it, for messages */
    vor_status (*open)(struct vor_blobs **out, const char *place,
                       const struct vor_blob_cache *cache, long *holder, struct vor_error *err);
    void (*close)(struct vor_blobs *blobs);
    vor_status (*space)(struct vor_blobs *blobs, uint64_t *available, uint64_t *total,
                        struct vor_error *err);
    /** Makes a writer with its fd. */
    vor_status (*create)(struct vor_blobs *blobs, struct vor_blob_writer **out,
                         struct vor_error *err);
    /** Makes a writer whose fd reads that blob, and whose size is its size. */
    vor_status (*reopen)(struct vor_blobs *blobs, const char *file, struct vor_blob_writer **out,
                         int *found, struct vor_error *err);
    /** Gives a writer that is in memory, and to whose fd nobody else holds on, a file for what it
     * has and what comes. */
    vor_status (*spill)(struct vor_blob_writer *writer, struct vor_error *err);
    /** Makes its bytes durable, unless it is lazy; discard follows in any case. */
    vor_status (*commit)(struct vor_blob_writer *writer, const char *file, struct vor_error *err);
    /** Frees the writer, and removes its bytes unless they were committed. */
    void (*discard)(struct vor_blob_writer *writer);
    vor_status (*get)(struct vor_blobs *blobs, const char *file, int *fd, uint64_t *size,
                      int *found, struct vor_error *err);
    /** NULL where a get never waits for another machine. */
    vor_status (*bring)(struct vor_blobs *blobs, const char *file,
                        const struct vor_blob_watch *watch, int *found, struct vor_error *err);
    /** False when a get would wait for another machine; NULL: it never does. */
    int (*is_near)(struct vor_blobs *blobs, const char *file);
    /** NULL: blobs are never away. */
    vor_status (*reach)(struct vor_blobs *blobs, struct vor_error *err);
    /** NULL: none ever waits for another machine. */
    void (*hurry)(struct vor_blobs *blobs);
    /** NULL: clients cannot read blobs where they lie. */
    vor_status (*link)(struct vor_blobs *blobs, const char *file,
                       const struct vor_blob_reading *reading, struct vor_text *out,
                       struct vor_error *err);
    vor_status (*drop)(struct vor_blobs *blobs, const char *file, struct vor_error *err);
    vor_status (*list)(struct vor_blobs *blobs, void (*each)(void *ctx, const char *file),
                       void *ctx, struct vor_error *err);
};

/** Of a bucket of S3; of a PostgreSQL database. Blobs are objects on another machine: keep/ID.NAME,
 * and the digests of its pieces piece/ID.NAME. A folder of this process has the files under way and
 * copies of what was written or read recently.
 *
 *  A commit is durable once the other machine has answered. */
extern const struct vor_blob_driver vor_blob_s3, vor_blob_postgres;

#endif
