/** Objects with keys on another machine: a table of functions, one table for each kind of place.
 *  The drivers of remote.c make blobs of them.
 *
 *  Every function may be called from any thread and waits for the network. A request that fails for
 *  a reason that may pass is sent again, up to six times in all and within a minute (within 10 s
 *  while others fail too), after pauses that double from .1 s and are shortened at random. Failures
 * are VOR_E_IO with the reason; vor_error_storage_away and vor_error_storage_refused tell what kind
 * they are.
 *
 *  Keys are made of letters, digits and "._/-". */
#ifndef VOR_SERVER_BLOB_OBJECTS_H
#define VOR_SERVER_BLOB_OBJECTS_H

#include "server/blob/driver.h"

#include <pthread.h>

enum {
    VOR_OBJECT_KEY_MAX = 128 /**< bytes of a key */
};

/** The objects of a kind begin with this. */
struct vor_objects {
    const struct vor_objects_kind *kind;
    pthread_mutex_t mutex;  /**< of what follows, and of the kind's idle connections */
    struct vor_error state; /**< VOR_OK while they answer; else why they do not */
    double answered;        /**< when they did last */
    atomic_int is_closing;  /**< nothing is waited for any more */
};

/** What is put: the first size bytes of a file, whose digest is sha256. */
struct vor_object_bytes {
    int fd;
    uint64_t size;
    const char *sha256;
    const struct vor_blob_patience *patience; /**< borrowed; its is_wanted counts */
};

/** Who takes the bytes of an object, and which: from `from` up to `to`, or UINT64_MAX for all. */
struct vor_object_reader {
    uint64_t from, to;
    /** Gets them in order, with the place of the first; others may come as well. Where a request is
     *  sent again they come again from the first on. False: no more are wanted, and the get fails.
     */
    int (*take)(void *ctx, uint64_t at, const void *bytes, size_t size);
    void *ctx;
};

struct vor_objects_kind {
    const char *scheme; /**< for the metrics */
    /** Asks nobody. */
    vor_status (*open)(struct vor_objects **out, const char *place, struct vor_error *err);
    void (*close)(struct vor_objects *objects);
    /** Puts bytes in place of what was there. */
    vor_status (*put)(struct vor_objects *objects, const char *key,
                      const struct vor_object_bytes *bytes, struct vor_error *err);
    /** Reads an object; reader NULL: it is only looked for, and *size is its size. */
    vor_status (*get)(struct vor_objects *objects, const char *key,
                      const struct vor_object_reader *reader, uint64_t *size, int *found,
                      struct vor_error *err);
    /** It is no error when there is none. */
    vor_status (*remove)(struct vor_objects *objects, const char *key, struct vor_error *err);
    /** Calls each for every object whose key begins so, in the order of keys, with the rest of its
     *  key. each may call these functions. */
    vor_status (*list)(struct vor_objects *objects, const char *begin,
                       void (*each)(void *ctx, const char *key), void *ctx, struct vor_error *err);
    /** Asks whether they are there: once, and soon over. */
    vor_status (*probe)(struct vor_objects *objects, struct vor_error *err);
    /** As vor_blob_link, for the bucket at `base`; or NULL. */
    vor_status (*link)(struct vor_objects *objects, const char *base, const char *key,
                       const struct vor_blob_reading *reading, struct vor_text *out,
                       struct vor_error *err);
};

void vor_objects_init(struct vor_objects *objects, const struct vor_objects_kind *kind);
void vor_objects_destroy(struct vor_objects *objects);

/** VOR_OK while they answer, as of the last request that can tell; else why they do not. Asks
 *  nobody.
 *
 *  @param[out] age  seconds since the last answer; may be NULL */
VOR_NODISCARD vor_status vor_objects_state(struct vor_objects *objects, double *age,
                                           struct vor_error *err);

/** For the kinds: notes how a request ended, which is what vor_objects_state tells. One that was
 *  refused says nothing of others: a probe does. */
void vor_objects_note(struct vor_objects *objects, const struct vor_error *failure, int is_probe);

/** For the kinds: is the answer to a request still waited for, that was sent then? patience may be
 *  NULL. */
int vor_objects_are_wanted(struct vor_objects *objects, const struct vor_blob_patience *patience,
                           double sent);

/** For the kinds: true when a request, of which `attempt` came to nothing (from 0 on), is to be
 * sent again; waits before that. It was first sent at `began`. */
int vor_objects_again(struct vor_objects *objects, int attempt, double began);

/** Objects as rows of a PostgreSQL database, in pieces of 1 MiB, each with its SHA-256: every piece
 *  is compared before it is passed on. The tables voronoid_file and voronoid_piece stand in the
 *  first schema of the search path, and are made if missing. The place is a connection string or
 * URI as libpq has it.
 *
 *  A put is one transaction; a get reads piece by piece and is begun anew where the object was
 *  replaced meanwhile. Works through pgbouncer in transaction mode. libpq is loaded when such a
 * place is opened. */
extern const struct vor_objects_kind vor_postgres_objects;

/** Objects of one S3 bucket (or of what speaks its protocol) under a prefix, by libcurl, which
 *  signs each request (AWS Signature Version 4).
 *
 *  A request waits up to 10 s for a connection, and 30 s for each pause in which no byte comes.
 * 5xx, 429, resets and time-outs may pass; each try is signed anew. A failure has the status and
 * the code that S3 gave. A put sends the digest, and S3 compares; large objects are put part by
 * part, each tried again by itself (s3_multipart.h). Nothing in the URL of a key needs an escape.
 *
 *  The place is http[s]://HOST[:PORT]/BUCKET[/PREFIX][?style=host]: with style=host the bucket
 *  becomes a part of the host's name (https://BUCKET.HOST/KEY), as pgBackRest calls it; else it is
 *  the first part of the path. The environment has the rest: AWS_ACCESS_KEY_ID,
 *  AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN, each also as the file that VARIABLE_FILE names;
 *  AWS_REGION. */
extern const struct vor_objects_kind vor_s3_objects;

#endif
