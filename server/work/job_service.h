/** The life of jobs from acceptance to expiry: the one door for handlers.
 *
 *  A job is accepted (row durable), waits in the store, is claimed and run by one of `jobs` runner
 *  threads on the shared pool, and ends with its row: result bytes are durable before the row says
 * successful. What handlers see is the live job while there is one, and its row after that. */
#ifndef VOR_SERVER_WORK_JOB_SERVICE_H
#define VOR_SERVER_WORK_JOB_SERVICE_H

#include "server/blob/blob.h"
#include "server/jobs/job.h"
#include "server/store/store.h"
#include "server/work/admit.h"
#include "server/work/run_executor.h"
#include "server/work/thread_pool.h"

#include <stddef.h>

struct vor_job_service;

struct vor_job_service_config {
    struct vor_store *store; /**< borrowed, as the next two */
    struct vor_blobs *blobs;
    struct vor_run_executor *executor;
    unsigned jobs;            /**< run at the same time, 1 .. 64 */
    size_t queue;             /**< wait at most, at least 1 */
    uint64_t queue_bytes;     /**< of decoded inputs, of those that wait */
    size_t memory;            /**< bytes a job may have */
    double job_seconds;       /**< a job may run; 0 for any */
    double ttl_seconds;       /**< results live this long after the job's end */
    uint64_t results;         /**< bytes of results that are kept; of those that ended first,
                                   less */
    uint64_t keep;            /**< bytes of uploads that are kept; 0 for none */
    uint64_t budget;          /**< bytes all running jobs may have, as estimated; 0 for any */
    uint64_t checkpoint_work; /**< as vor_run.every, and vor_keeper_open: 0 but for tests */
    double checkpoint_seconds;
    double tidy_seconds; /**< between two looks for files that no job needs; 0: 6 hours */
    unsigned faults_max; /**< a job fails that ran alone in so many crashes of its process */
    /** Called once, on a thread of the job service, when a disk has failed: what is on it is not
     * known any more, and only a restart helps. May be NULL. */
    void (*failed)(void *ctx, const struct vor_error *why);
    void *failed_ctx;
    double idle_seconds; /**< after so long without a job SIGTERM is raised; 0: never */
    const char *listen;  /**< as vor_store_listen; "" or NULL: it polls alone; borrowed */
};

/** Has every job that a former life of the daemon left running wait again, in its place; then
 * starts the threads. The sweeper then removes expired results and bytes that no job needs.
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM
 *
 *  Cost: a change of the store and a read, however many jobs wait. */
VOR_NODISCARD vor_status vor_job_service_create(struct vor_job_service **out,
                                                const struct vor_job_service_config *config,
                                                struct vor_error *err);

/** Stops claiming and accepting (VOR_DRAINING from here on), gives running jobs `seconds` to end,
 *  then cancels the rest, whose rows go back to accepted. Blocks. */
void vor_job_service_drain(struct vor_job_service *service, double seconds);

/** Drains with 0 seconds if not done yet, ends the threads. service may be NULL. */
void vor_job_service_destroy(struct vor_job_service *service);

/** Can jobs be taken, run and ended? For /readyz: the store is in order, its reserve is there, the
 *  blobs can be reached, and the disk has room besides what stays free.
 *
 *  @retval VOR_E_IO and the reason, after --store or --blobs (vor_error_storage_full tells a full
 * disk apart) */
VOR_NODISCARD vor_status vor_job_service_ready(struct vor_job_service *service,
                                               struct vor_error *err);

/** Jobs that wait, and that run; when the one that is next was accepted, 0 when none waits. */
struct vor_job_service_load {
    size_t waiting, running;
    uint64_t reserved, budget; /**< bytes: of memory, for what runs, as estimated, and in all */
    int64_t oldest_ms;
};
void vor_job_service_load(struct vor_job_service *service, struct vor_job_service_load *out);

/** What a job is called, and what makes it the same when it is asked for again; each may be NULL.
 */
struct vor_job_label {
    const char *name;              /**< as vor_job_view.name */
    const struct vor_job_key *key; /**< of no job: vor_job_service_find_key says VOR_UNKNOWN; its
                                        principal is whose the job is */
    const struct vor_span *span;   /**< the step of a trace that asks for it */
    uint64_t
        jobs_max; /**< jobs of that principal that may wait or run, this one included; 0: any */
    uint64_t bytes_max;  /**< that it may have stored, uploads of this one included; 0: any */
    uint64_t points_max; /**< of each of its inputs; 0: any */
    int booked;          /**< a place is kept for it, which is used or given back */
};

/** Would a job be taken now that uploads so many bytes, as far as they are known? For an early
 *  answer: uploads at the same time do not see each other, and vor_job_service_submit decides. A
 * label whose key has a job passes: it asks for no other.
 *
 *  @param[in] label  NULL: of nobody, who has no quota
 *
 *  @retval VOR_DONE, VOR_FULL, VOR_DRAINING
 *  @retval VOR_CROWDED, VOR_OVER_BYTES  the principal has what it may; err has the numbers
 *  @retval VOR_FAILED
 *
 *  Cost: with a quota, a read of one row of the store. */
enum vor_job_outcome vor_job_service_room(struct vor_job_service *service,
                                          const struct vor_job_label *label, uint64_t bytes,
                                          struct vor_error *err);

/** Keeps a place in the queue for a job whose inputs are all here and are yet to be decoded, so
 * that one for which there is none is refused before that. It goes with vor_job_label.booked, or is
 * given back by vor_job_service_unbook. Quick.
 *
 *  @retval VOR_DONE, VOR_FULL, VOR_DRAINING */
enum vor_job_outcome vor_job_service_book(struct vor_job_service *service);
void vor_job_service_unbook(struct vor_job_service *service);

/** Accepts a job for inputs that vor_admit_file took in: the row is durable when this returns.
 *
 *  @param[in]  admitted  its blobs are dropped unless VOR_DONE is returned
 *  @param[in]  spec      checked (vor_spec_check); a format not given becomes that of the main
 * input where the process takes one
 *  @param[in]  label     may be NULL
 *  @param[out] out       the job's first view; may be NULL
 *
 *  @retval VOR_DONE, VOR_FULL, VOR_DRAINING
 *  @retval VOR_CROWDED, VOR_OVER_BYTES  the principal has what it may; err has the numbers
 *  @retval VOR_FAILED  err: VOR_E_LIMIT an input has too many points; VOR_E_BYTES its decoded
 * inputs alone are more than may wait; VOR_E_PARAM an input that the process does not take, or as
 * vor_spec_check_inputs; VOR_E_TARGET as vor_spec_check_target, but for spacing, which only the run
 * can tell; VOR_E_ORIGIN as vor_write_check; VOR_E_IO; VOR_E_NOMEM, with limit and got where the
 * job needs more than the budget; VOR_E_WORK as vor_time_estimate_check
 *
 *  Cost: an fsync; not for HTTP threads. */
VOR_NODISCARD enum vor_job_outcome
vor_job_service_submit(struct vor_job_service *service, const struct vor_admitted *admitted,
                       const struct vor_spec *spec, const struct vor_job_label *label,
                       struct vor_job_view *out, struct vor_error *err);

/** The job that has a key, as its row was.
 *
 *  @retval VOR_DONE      *out is the job, and the key's fingerprint is its own
 *  @retval VOR_CONFLICT  the job of this key was asked for something else
 *  @retval VOR_UNKNOWN   no job has the key
 *  @retval VOR_FAILED */
VOR_NODISCARD enum vor_job_outcome vor_job_service_find_key(struct vor_job_service *service,
                                                            const struct vor_job_key *key,
                                                            struct vor_job_view *out,
                                                            struct vor_error *err);

/** What is known about a job of this principal (NULL: of any), live or from its row.
 *
 *  @retval VOR_DONE, VOR_UNKNOWN, VOR_FAILED */
VOR_NODISCARD enum vor_job_outcome vor_job_service_get(struct vor_job_service *service,
                                                       const struct vor_uuid *id,
                                                       const char *tenant, struct vor_job_view *out,
                                                       struct vor_error *err);

/** vor_store_list with what is live brought up to date. each must not call the job service. */
VOR_NODISCARD vor_status vor_job_service_list(
    struct vor_job_service *service, const struct vor_job_filter *filter,
    int (*each)(void *ctx, const struct vor_job_view *row), void *ctx, struct vor_error *err);

/** A job for as long as somebody follows it. */
struct vor_followed {
    struct vor_job *job;     /**< NULL when it was not live; else the caller's, who releases it */
    struct vor_job_view row; /**< as it was at the beginning */
};

/** Where another daemon runs a live job: takes in its preview, if it has a newer one. Waits for a
 * row of the store. */
VOR_NODISCARD vor_status vor_job_service_mirror_preview(struct vor_job_service *service,
                                                        struct vor_job *job, struct vor_error *err);

/** Begins to follow a job of this principal (NULL: of any). One that waits or runs is live from
 * then on.
 *
 *  @retval VOR_DONE, VOR_UNKNOWN, VOR_FAILED
 *
 *  Cost: a read of the store for a job that is not live. */
VOR_NODISCARD enum vor_job_outcome
vor_job_service_follow(struct vor_job_service *service, const struct vor_uuid *id,
                       const char *tenant, struct vor_followed *out, struct vor_error *err);

/** The job as it is now. Asks the store for its place in the queue while it waits, and nothing
 * else: a job that is not live does not change. */
void vor_job_service_followed(struct vor_job_service *service, const struct vor_followed *followed,
                              struct vor_job_view *out);

/** Reads events that the store has, of the attempt of a row, and END if the row is over. What a
 *  live job has besides them, vor_job_read tells. A job without a trace (it expired, or ended
 * before it began) has nothing but its END.
 *
 *  Cost: a read of the store, of about as many events as are wanted. */
VOR_NODISCARD vor_status vor_job_service_stored_events(struct vor_job_service *service,
                                                       const struct vor_job_view *row,
                                                       struct vor_event_batch *batch,
                                                       struct vor_error *err);

/** DELETE: a job that waits or runs becomes dismissed at once (its cores are free within a block of
 *  work); one that is over is removed with its bytes. *out (may be NULL) then says dismissed.
 *
 *  @param[in] why  a short sentence for its message: "dismissed by the caller"
 *
 *  @retval VOR_DONE, VOR_UNKNOWN, VOR_FAILED
 *
 *  Cost: an fsync; not for HTTP threads. */
VOR_NODISCARD enum vor_job_outcome
vor_job_service_dismiss(struct vor_job_service *service, const struct vor_uuid *id, const char *why,
                        struct vor_job_view *out, struct vor_error *err);

/** Dismisses a job only if it is not over, because its caller left.
 *
 *  @retval VOR_CONFLICT the job is over; nothing is removed */
VOR_NODISCARD enum vor_job_outcome vor_job_service_cancel(struct vor_job_service *service,
                                                          const struct vor_uuid *id,
                                                          const char *why, struct vor_error *err);

/** A dismissal or cancellation that a thread of the job service carries out, for callers that must
 * not wait for the disk. The caller fills in the first six members and keeps the struct until done
 * is called. */
struct vor_dismissal {
    struct vor_uuid id;
    struct vor_fairness_key caller;                /**< who shares the threads with others */
    const char *why;                               /**< borrowed */
    int is_cancel;                                 /**< cancel; view is not set then */
    int is_stop;                                   /**< a job that another daemon runs; likewise */
    void (*done)(struct vor_dismissal *dismissal); /**< on that thread; may free the struct */
    void *ctx;
    enum vor_job_outcome outcome; /**< from here: the answer */
    struct vor_error error;
    struct vor_job_view view;
    struct vor_job_service *service; /**< from here: the service's own */
    struct vor_task task;
};

/** Hands it over; done will be called, exactly once. Does not block. */
void vor_job_service_dismiss_soon(struct vor_job_service *service, struct vor_dismissal *dismissal);

/** Hands over a task that reads the store, for callers that must not wait for it.
 *
 *  @retval VOR_DONE, VOR_DRAINING
 *  @retval VOR_FAILED there is no thread for it, and none can be started */
VOR_NODISCARD enum vor_job_outcome vor_job_service_read_soon(struct vor_job_service *service,
                                                             struct vor_task *task,
                                                             struct vor_error *err);

/** Waits until everything handed over is done, `seconds` at most. */
void vor_job_service_settle(struct vor_job_service *service, double seconds);

/** Ends a running job with the best cloud so far; it becomes successful. Does not wait.
 *
 *  @retval VOR_DONE, VOR_UNKNOWN, VOR_FAILED
 *  @retval VOR_CONFLICT the job does not run here: elsewhere a vor_dismissal with is_stop asks */
VOR_NODISCARD enum vor_job_outcome vor_job_service_stop(struct vor_job_service *service,
                                                        const struct vor_uuid *id,
                                                        struct vor_error *err);

/** Expires what is due now; the sweeper does it once a minute. */
VOR_NODISCARD vor_status vor_job_service_sweep(struct vor_job_service *service,
                                               struct vor_error *err);

#endif
