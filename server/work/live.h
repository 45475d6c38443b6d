/** The worker's state: the jobs that wait or run, and how many run. The files of this room share
 *  it; nobody else includes this. */
#ifndef VOR_SERVER_WORK_LIVE_H
#define VOR_SERVER_WORK_LIVE_H

#include "server/jobs/queue.h"
#include "server/work/worker.h"

#include <pthread.h>
#include <stdatomic.h>

#define VOR_WORKER_JOBS_MAX 64

/** A job that waits or runs. */
struct vor_live {
    struct vor_job *job;
    const char *id; /* of the job */
    int running;
    uint64_t bytes; /* of its decoded inputs */
    struct vor_live *next, *before;
};

/** The blobs that were there at the start. */
struct vor_found_blob {
    struct vor_uuid id;
    char name[VOR_BLOB_NAME_MAX + 1];
};

struct vor_found {
    struct vor_found_blob *blobs; /**< owned */
    size_t count, capacity;
};

void vor_found_free(struct vor_found *found);

/** What is known of the wall clock (calendar.h); milliseconds. */
struct vor_calendar {
    int64_t wall, steady; /**< both clocks at the last look */
    int64_t newest;       /**< time in the store at the start; 0 for none */
    int64_t began;        /**< steady, at the start */
    int unsure;           /**< the clock does not continue the store */
};

/** Locks are taken in this order: a job's change, the store's, `mutex`, a job's state, the queue's.
 */
struct vor_worker {
    struct vor_worker_config config;
    struct vor_queue *queue;
    struct vor_turns turns;   /* of the jobs that run */
    struct vor_crew *crew;    /* for what HTTP threads hand over */
    struct vor_crew *readers; /* for what reads the store alone, which waits for no fsync */
    pthread_mutex_t mutex;    /* everything below */
    pthread_cond_t changed;   /* running, draining, aborting; on the monotonic clock */
    struct vor_live *live;
    void *live_by_id;       /* the same, as a tree of search.h */
    uint64_t waiting_bytes; /* sum of those on the list that do not run */
    size_t running;
    int draining; /* nothing is claimed or accepted any more */
    int aborting; /* what runs was asked to end; its rows go back to accepted */
    pthread_t runners[VOR_WORKER_JOBS_MAX];
    unsigned runner_count;
    pthread_t sweeper;
    int sweeper_started;
    struct vor_found found; /* the sweeper's, once it runs, as all below */
    struct vor_calendar calendar;
    int is_full;        /* the store has no reserve, and the log says so */
    int has_failed;     /* config.failed was called */
    int is_reset;       /* rows that a former life left running are accepted again */
    atomic_int is_late; /* the disk was full at the start: what a former life left waits for room */
};

/** The live job of that id with a reference for the caller, NULL when there is none. */
struct vor_job *vor_worker_find(struct vor_worker *worker, const struct vor_uuid *id);

/** Adds a job to the list of live ones, or takes it off. The list has a reference of its own.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_worker_remember(struct vor_worker *worker, struct vor_job *job,
                                             struct vor_error *err);

void vor_worker_forget(struct vor_worker *worker, const struct vor_job *job);

/** Notes how many bytes the decoded inputs of a remembered job have, unless those that wait would
 *  have more than `most` together; then it answers false. */
int vor_worker_charge(struct vor_worker *worker, const struct vor_job *job, uint64_t bytes,
                      uint64_t most);

/** Bytes of the decoded inputs of all jobs that wait. */
uint64_t vor_worker_waiting_bytes(struct vor_worker *worker);

/** Puts a job that did not get to its end back into the queue, in its place. */
void vor_worker_requeue(struct vor_worker *worker, struct vor_job *job);

/** Counts a job as running, until vor_worker_leave. False when the daemon goes down; the job must
 *  not be run then. */
int vor_worker_enter(struct vor_worker *worker, const struct vor_job *job);
void vor_worker_leave(struct vor_worker *worker);

/** Waits until something changed or the deadline (vor_clock_seconds) is over; the mutex is held.
 *  True when it is over. */
int vor_worker_wait_until(struct vor_worker *worker, double deadline);

/** Waits up to `seconds`; returns at once when the daemon goes down. True when it does. */
int vor_worker_pause(struct vor_worker *worker, double seconds);

/** The view of a job that ends now, up to its message and its expiry. */
void vor_worker_ending(struct vor_worker *worker, struct vor_job *job, enum vor_job_status status,
                       struct vor_job_view *out);

/** Writes the last row of a frozen job, and its trace, then ends the job.
 *
 *  @param[in]  attempt  as vor_store_finish
 *  @param[out] changed  0 when the row was over: the job is not ended
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM  the job is not ended */
VOR_NODISCARD vor_status vor_worker_finish(struct vor_worker *worker, struct vor_job *job,
                                           const struct vor_job_view *row, uint32_t attempt,
                                           const char *report, int *changed, struct vor_error *err);

/** Removes a blob that nobody needs any more. A failure is logged; the next start removes it. */
void vor_worker_drop(struct vor_worker *worker, const struct vor_uuid *id, const char *name);

/** The same for the inputs, the uploads that are kept, and the outputs in every format, of a job of
 *  that process; those of a process that this version does not know are left to the next start. */
void vor_worker_drop_inputs(struct vor_worker *worker, const struct vor_uuid *id,
                            const char *process);
void vor_worker_drop_uploads(struct vor_worker *worker, const struct vor_uuid *id,
                             const char *process);
void vor_worker_drop_outputs(struct vor_worker *worker, const struct vor_uuid *id,
                             const char *process);

/** Takes from jobs what they keep as far as the time or a quota of the configuration wants it
 *  (vor_store_evict), with its bytes.
 *
 *  Cost: a read of the store as long as a quota holds. */
VOR_NODISCARD vor_status vor_worker_evict(struct vor_worker *worker, enum vor_evict why,
                                          struct vor_error *err);

/** The same; a failure is logged, and the next call tries again. */
void vor_worker_keep_quota(struct vor_worker *worker, enum vor_evict why);

#endif
