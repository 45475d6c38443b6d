/** The worker's state: the jobs that wait or run, and how many run. The files of this room share
 *  it; nobody else includes this. */
#ifndef VOR_SERVER_WORK_LIVE_H
#define VOR_SERVER_WORK_LIVE_H

#include "server/work/worker.h"

#include <pthread.h>
#include <stdatomic.h>

#define VOR_WORKER_JOBS_MAX 64

/** What jobs take (capacity.h). */
struct vor_capacity {
    int64_t waiting, booked; /* jobs; waiting may be 1 too few while one of them is claimed */
    uint64_t bytes;          /* of decoded inputs, of those that wait or are being stored */
    size_t running;
    uint64_t used;  /* bytes of memory, of what runs */
    int runs_alone; /* what runs is to have nothing beside it */
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

/** A thread that runs jobs, one after the other. */
struct vor_runner {
    struct vor_worker *worker;
    pthread_t thread;
    struct vor_job *job; /* NULL while it has none */
    uint32_t attempt;    /* of it, as it was claimed */
};

/** Jobs wait in the store, and nowhere else. Live ones run, or are followed while they wait. Locks
 *  are taken in this order: `claim`, a job's change, the store's, `mutex`, a job's state. */
struct vor_worker {
    struct vor_worker_config config;
    struct vor_uuid owner;    /* in the rows that run in this life */
    struct vor_crew *crew;    /* for what HTTP threads hand over */
    struct vor_crew *readers; /* for what reads the store alone, which waits for no fsync */
    pthread_mutex_t claim;    /* a job begins to run, waits again, or is dismissed while it waits */
    pthread_mutex_t mutex;    /* everything below */
    pthread_cond_t changed;   /* running, draining, aborting; on the monotonic clock */
    pthread_cond_t ready;     /* something waits, or may run, that could not before: `news` */
    unsigned news;
    void *live; /* struct vor_job, as a tree of search.h */
    struct vor_capacity capacity;
    int draining; /* nothing is claimed or accepted any more */
    int aborting; /* what runs was asked to end; its rows go back to accepted */
    struct vor_runner runners[VOR_WORKER_JOBS_MAX];
    unsigned runner_count;
    pthread_t sweeper, keeper;
    int sweeper_started, keeper_started;
    struct vor_found found; /* the sweeper's, once it runs, as all below */
    struct vor_calendar calendar;
    int is_away;               /* the blobs are, and the log says so */
    int is_full;               /* the store has no reserve, and the log says so */
    int has_failed;            /* config.failed was called */
    double renewed;            /* when the lease was */
    double busy;               /* when there was a job last */
    double reaped;             /* when the leases of others were looked at */
    double unreached;          /* when the store was away last, or not known */
    atomic_int may_be_unheard; /* a claim failed, or nobody knows whether it did */
    atomic_int is_late; /* the disk was full at the start: what a former life left waits for room */
};

/** The live job of that id with a reference for the caller, NULL when there is none. */
struct vor_job *vor_worker_find(struct vor_worker *worker, const struct vor_uuid *id);

/** The live job of a row that is not over, with a reference for the caller: a new one where there
 *  is none. NULL when memory is out. */
struct vor_job *vor_worker_enliven(struct vor_worker *worker, const struct vor_job_view *row);

/** All live jobs, with a reference to each for the caller, who frees the list (malloc); some are
 *  left out when memory is out. */
struct vor_job **vor_worker_live(struct vor_worker *worker, size_t *count);

/** Takes a job off the live ones, or all once no thread is left. It may have been taken off before.
 */
void vor_worker_forget(struct vor_worker *worker, const struct vor_job *job);
void vor_worker_forget_all(struct vor_worker *worker);

/** A runner has no job any more. */
void vor_worker_let_go(struct vor_runner *runner);

/** True when a runner has the job. */
int vor_worker_is_running(struct vor_worker *worker, const struct vor_job *job);

/** Makes the lease on what runs longer, if that is due, and ends the runs that have lost theirs.
 * For one thread. */
void vor_worker_renew(struct vor_worker *worker);

/** Waits up to `seconds`; returns at once when the daemon goes down. True when it does. */
int vor_worker_pause(struct vor_worker *worker, double seconds);

/** The view of a job that ends now, up to its message and its expiry. */
void vor_worker_ending(struct vor_worker *worker, struct vor_job *job, enum vor_job_status status,
                       struct vor_job_view *out);

/** Writes the last row of a frozen job, and its events, then ends the job.
 *
 *  @param[in]  lease    as vor_store_finish
 *  @param[out] changed  0 when the row was over: the job is not ended
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM  the job is not ended */
VOR_NODISCARD vor_status vor_worker_finish(struct vor_worker *worker, struct vor_job *job,
                                           const struct vor_job_view *row,
                                           const struct vor_lease *lease, const char *report,
                                           int *changed, struct vor_error *err);

/** Adds the events of a running job that the store has not yet to those it has.
 *
 *  @param[out] changed  0 when the attempt is not the lease's owner's any more */
VOR_NODISCARD vor_status vor_worker_store_events(struct vor_worker *worker, struct vor_job *job,
                                                 const struct vor_lease *lease, int *changed,
                                                 struct vor_error *err);

/** Removes a blob that nobody needs any more. A failure is logged; the next start removes it. */
void vor_worker_drop(struct vor_worker *worker, const struct vor_uuid *id, const char *name);

/** What a job has among the blobs. */
enum {
    VOR_HAS_UPLOADS = 1, /**< kept */
    VOR_HAS_OUTPUTS = 2, /**< in every format */
    VOR_HAS_CHECKPOINT = 4
};

/** Likewise: the inputs that came along, and what a run that was lost may have left. */
static inline unsigned vor_has_inputs(const struct vor_job_view *row)
{
    return row->inputs << 3 | (row->attempt > 1 ? VOR_HAS_CHECKPOINT : 0);
}

/** Removes those of a job of that process, outputs of its first attempts; those of a process that
 *  this version does not know are left to the next start. */
void vor_worker_drop_all(struct vor_worker *worker, const struct vor_uuid *id, const char *process,
                         uint32_t attempts, unsigned what);

/** How many attempts have left outputs that nobody needs: all, or all before the last one. */
static inline uint32_t vor_attempts_gone(enum vor_job_status status, uint32_t attempt)
{
    int is_needed = !vor_job_status_over(status) || status == VOR_JOB_SUCCESSFUL;

    return is_needed && attempt > 0 ? attempt - 1 : attempt;
}

/** Takes from jobs what they keep as far as the time or a quota of the configuration wants it
 *  (vor_store_evict), with its bytes.
 *
 *  Cost: a read of the store as long as a quota holds. */
VOR_NODISCARD vor_status vor_worker_evict(struct vor_worker *worker, enum vor_evict why,
                                          struct vor_error *err);

/** The same; a failure is logged, and the next call tries again. */
void vor_worker_keep_quota(struct vor_worker *worker, enum vor_evict why);

#endif
