/** Keeps the last checkpoint of a run (core/seeds/checkpoint.h) beside its job, for the attempt
 * that follows if this one is lost. Only one of them matters, and a run has the same result with
 * any or none: so a checkpoint for which there is no room, or no time, is left out, and one of an
 * attempt that has lost its lease may take the place of a later one. */
#ifndef VOR_SERVER_WORK_KEEPER_H
#define VOR_SERVER_WORK_KEEPER_H

#include "server/blob/blob.h"
#include "server/store/row.h"

#include <pthread.h>
#include <stdatomic.h>

/** Belongs to the thread that follows the run. */
struct vor_keeper {
    struct vor_blobs *blobs; /* borrowed */
    struct vor_uuid id;
    double pause;                   /* seconds from one that is kept to the next file */
    double next;                    /* when the next file may be had */
    struct vor_blob_writer *writer; /* of a file that the run has, or that is being stored */
    pthread_t thread;               /* stores it */
    int is_storing;
    atomic_int is_stored, is_closing;
    double until; /* for which a store is waited for that is closing */
    int has_kept; /* something was */
};

/** @param[in] pause  seconds between two checkpoints, and before the first; 0: 10, so that short
 *                    runs have none */
void vor_keeper_open(struct vor_keeper *out, struct vor_blobs *blobs, const struct vor_uuid *id,
                     double pause);

/** An empty file for a checkpoint, -1 if the run is to have none now. Call vor_keeper_take once the
 *  run has written it. Quick. */
int vor_keeper_file(struct vor_keeper *keeper);

/** Has a thread store what the run wrote: file->bytes is 0 when it could not. Quick. */
void vor_keeper_take(struct vor_keeper *keeper, const struct vor_job_output *file);

/** Ends, and waits for about so long until what was taken is stored. True when something was, or
 * may have been. */
int vor_keeper_close(struct vor_keeper *keeper, double seconds);

#endif
