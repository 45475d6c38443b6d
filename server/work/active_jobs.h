/** The state of the job service: the jobs that wait or run, and how many run. The files of this
 * room share it; nobody else includes this. */
#ifndef VOR_SERVER_WORK_ACTIVE_JOBS_H
#define VOR_SERVER_WORK_ACTIVE_JOBS_H

#include "server/work/job_service.h"

#include <pthread.h>
#include <stdatomic.h>

#define VOR_RUNNING_JOBS_MAX 64

/** What jobs take. */
struct vor_capacity {
    int64_t waiting, booked; /* jobs; waiting may be 1 too few while one of them is claimed */
    uint64_t bytes;          /* of decoded inputs, of those that wait or are being stored */
    size_t running;
    uint64_t used;  /* bytes of memory, of what runs */
    int runs_alone; /* what runs is to have nothing beside it */
};

/** The blobs that were there at the start, or at a look for those that no job needs. */
struct vor_found {
    struct vor_blob_list list;
    int is_first;          /**< before this daemon wrote any, and there is no other */
    size_t counted;        /**< so many were looked at; of these, at the front of the list: */
    size_t strays;         /**< that no row needed then */
    size_t looked;         /**< and that were looked at again, and dropped unless one does now */
    size_t orphans, files; /**< results without a row; what no row needs */
    size_t kept;           /**< of files, because the table of jobs is damaged; their bytes */
    uint64_t bytes;
};

void vor_found_free(struct vor_found *found);

/** What is known of the wall clock; milliseconds. */
struct vor_expiry_clock {
    int64_t wall, steady; /**< both clocks at the last look */
    int64_t newest;       /**< time in the store at the start; 0 for none */
    int64_t began;        /**< steady, at the start */
    int unsure;           /**< the clock does not continue the store */
};

/** A thread that runs jobs, one after the other. */
struct vor_runner {
    struct vor_job_service *service;
    pthread_t thread;
    struct vor_job *job; /* NULL while it has none */
    uint32_t attempt;    /* of it, as it was claimed */
};

/** Jobs wait in the store, and nowhere else. Live ones run, or are followed while they wait. Locks
 *  are taken in this order: `claim`, a job's change, the store's, `mutex`, a job's state. */
struct vor_job_service {
    struct vor_job_service_config config;
    struct vor_uuid owner;           /* in the rows that run in this life */
    struct vor_thread_pool *pool;    /* for what HTTP threads hand over */
    struct vor_thread_pool *readers; /* for what reads the store alone, which waits for no fsync */
    pthread_mutex_t claim;  /* a job begins to run, waits again, or is dismissed while it waits */
    pthread_mutex_t mutex;  /* everything below */
    pthread_cond_t changed; /* running, draining, aborting; on the monotonic clock */
    pthread_cond_t ready;   /* something waits, or may run, that could not before: `news` */
    unsigned news;
    void *live; /* struct vor_job, as a tree of search.h */
    struct vor_capacity capacity;
    int draining; /* nothing is claimed or accepted any more */
    int aborting; /* what runs was asked to end; its rows go back to accepted */
    int has_news; /* another daemon says so (vor_store_listen), and nobody has looked yet */
    struct vor_runner runners[VOR_RUNNING_JOBS_MAX];
    unsigned runner_count;
    pthread_t sweeper, keeper;
    int sweeper_started, keeper_started;
    struct vor_found found; /* the sweeper's, once it runs, as all below */
    struct vor_expiry_clock expiry_clock;
    int is_away;               /* the blobs are, and the log says so */
    int is_full;               /* the store has no reserve, and the log says so */
    int gives_back;            /* the store has more room that rows have left */
    int has_failed;            /* config.failed was called */
    double renewed;            /* when the lease was */
    double busy;               /* when there was a job last */
    double reaped;             /* when the leases of others were looked at */
    double unreached;          /* when the store was away last, or not known */
    atomic_int has_grown;      /* more is kept than before: the sweeper is to look at the quotas */
    atomic_int may_be_unheard; /* a claim failed, or nobody knows whether it did */
    atomic_int is_late; /* the disk was full at the start: what a former life left waits for room */
};

/** The live job of that id with a reference for the caller, NULL when there is none. */
struct vor_job *vor_job_service_find(struct vor_job_service *service, const struct vor_uuid *id);

/** The live job of a row that is not over, with a reference for the caller: a new one where there
 *  is none. NULL when memory is out. */
struct vor_job *vor_job_service_enliven(struct vor_job_service *service,
                                        const struct vor_job_view *row);

/** All live jobs, with a reference to each for the caller, who frees the list (malloc); some are
 *  left out when memory is out. */
struct vor_job **vor_job_service_live(struct vor_job_service *service, size_t *count);

/** Takes a job off the live ones, or all once no thread is left. It may have been taken off before.
 */
void vor_job_service_forget(struct vor_job_service *service, struct vor_job *job);
void vor_job_service_forget_all(struct vor_job_service *service);

/** True when a runner has the job. */
int vor_job_service_is_running(struct vor_job_service *service, const struct vor_job *job);

/** Makes the lease on what runs longer, if that is due, and ends the runs that have lost theirs.
 * For one thread. */
void vor_job_service_renew(struct vor_job_service *service);

/** Has a job of ours wait again (vor_store_hand_back). False when the store fails, as the log says.
 */
VOR_NODISCARD int vor_job_service_hand_back(struct vor_job_service *service,
                                            const struct vor_uuid *id, struct vor_hand_back *back);

/** Has the runners look for a job: one may run that could not before. */
void vor_job_service_news(struct vor_job_service *service);

/** Where the store is shared: stores the events of what runs here that it has not, so that others
 *  see them though the next one is long in coming. */
void vor_job_service_store_late(struct vor_job_service *service);

/** Waits up to `seconds`; returns at once when the daemon goes down. True when it does. */
int vor_job_service_pause(struct vor_job_service *service, double seconds);

/** The view of a job that ends now, up to its message and its expiry. */
void vor_job_service_ending(struct vor_job_service *service, struct vor_job *job,
                            enum vor_job_status status, struct vor_job_view *out);

/** Writes the last row of a frozen job, and its events, then ends the job.
 *
 *  @param[in]  lease    as vor_store_finish
 *  @param[out] changed  0 when the row was over: the job is not ended
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM  the job is not ended */
VOR_NODISCARD vor_status vor_job_service_finish(struct vor_job_service *service,
                                                struct vor_job *job, const struct vor_job_view *row,
                                                const struct vor_lease *lease, const char *report,
                                                int *changed, struct vor_error *err);

/** Adds the events of a running job that the store has not yet to those it has.
 *
 *  @param[out] changed  0 when the attempt is not the lease's owner's any more */
VOR_NODISCARD vor_status vor_job_service_store_events(struct vor_job_service *service,
                                                      struct vor_job *job,
                                                      const struct vor_lease *lease, int *changed,
                                                      struct vor_error *err);

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
void vor_job_service_drop_all(struct vor_job_service *service, const struct vor_uuid *id,
                              const char *process, uint32_t attempts, unsigned what);

/** Takes from jobs what they keep as far as the time or a quota of the configuration wants it
 *  (vor_store_evict), with its bytes.
 *
 *  Cost: a read of the store as long as a quota holds. */
VOR_NODISCARD vor_status vor_job_service_evict(struct vor_job_service *service, enum vor_evict why,
                                               struct vor_error *err);

/* What jobs take of the daemon, and whether there is room for one more: places in the queue, bytes
 * of decoded inputs that wait, memory of what runs. A job books a place while its inputs are
 * decoded, waits, runs, and waits again or is over: each step is counted here. What a principal may
 * have is counted by the store (struct vor_ledger). vor_job_service_room, _book, _unbook and _load
 * are in job_service.h. */

/** A former life of the daemon has left so much that waits. */
void vor_capacity_begin(struct vor_job_service *service, const struct vor_waiting *waiting);

/** A row waits from now on (1), or does no longer (-1); tells the runners. */
void vor_capacity_wait(struct vor_job_service *service, const struct vor_job_view *row, int by);

/** What may be claimed beside what runs; false when nothing may. */
VOR_NODISCARD int vor_capacity_claim(struct vor_job_service *service, struct vor_claim *claim);

/** A row that was claimed runs from now on, or does no longer; the mutex is held. */
void vor_capacity_run(struct vor_job_service *service, const struct vor_job_view *row);
void vor_capacity_leave(struct vor_job_service *service, const struct vor_job_view *row);

/* The sweeper (sweeper.c). */

/** Every row that ran in another life waits again when this returns, in its place, however many the
 *  queue takes. One whose bytes are gone, or whose request cannot be read, fails once it is
 * claimed. Also notes which blobs there are, of which the sweeper drops those that no row needs.
 * Call before any other thread knows the job service.
 *
 *  On a disk without a byte rows cannot be put in order. Then they stay as they are, which the log
 *  says, nothing is accepted, and the sweeper does it later.
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM
 *
 *  Cost: a change of the store and a read, however many jobs wait. */
VOR_NODISCARD vor_status vor_job_service_recover(struct vor_job_service *service,
                                                 struct vor_error *err);

/** The sweeper's thread, which gets the job service. */
void *vor_job_service_sweep_on(void *service);

/* Where other daemons share the store: what they do to jobs is seen here. */

/** A live job that no runner here has becomes what its row says; ended and off the live ones if
 * that is over. */
VOR_NODISCARD vor_status vor_job_service_mirror(struct vor_job_service *service,
                                                struct vor_job *job, struct vor_error *err);

/** The same with all live jobs; makes jobs wait again whose leases have ended, and counts what
 *  waits. For the sweeper; where nobody shares the store it only counts, if that may be wrong. */
void vor_job_service_follow_others(struct vor_job_service *service);

/* One run of one job: from its claim to its last row. */

/** Runs and ends the job of a runner; row is what the claim returned. Returns when it is over, or
 *  waits again: its process has ended, or the daemon goes down. */
void vor_job_service_run(struct vor_runner *runner, const struct vor_job_view *row);

#endif
