/** A daemon without HTTP: blobs, store, pool and job service on a directory. */
#ifndef VT_DAEMON_H
#define VT_DAEMON_H

#include "core/base/parallel.h"
#include "server/work/job_service.h"

/** Runs jobs in this process, so that what they do is seen by its sanitizers. */
struct vt_run_here {
    struct vor_run_executor base;
    struct vor_pool *pool; /**< borrowed */
};

void vt_run_here_init(struct vt_run_here *here, struct vor_pool *pool);

struct vt_daemon {
    const char *dir;
    struct vor_blobs *blobs;
    struct vor_store *store;
    struct vor_pool *pool;
    struct vt_run_here here;
    struct vor_job_service *service;
};

/** What a daemon may be given; zero is the default (2 jobs, queue 16, 1 GiB, an hour, 3 crashes
 * alone).
 */
struct vt_daemon_options {
    unsigned jobs;
    size_t queue, memory;
    uint64_t budget;                 /**< 0 for any */
    double ttl_seconds, job_seconds; /**< a job may run for any time with 0 */
    uint64_t queue_bytes;            /**< 0 for 1 GiB */
    uint64_t results;                /**< 0 for 1 GiB */
    uint64_t keep;                   /**< 0 for no uploads */
    uint64_t checkpoint_work;        /**< 0 for that of a daemon; else they are kept at once */
    void (*failed)(void *ctx,
                   const struct vor_error *why); /**< as of the job service; NULL for none */
    void *failed_ctx;
    int tidies; /**< strays are looked for at each look of the sweeper */
    void (*prepare)(
        struct vt_daemon *daemon); /**< once store and blobs are open; NULL for nothing */
};

void vt_daemon_start(struct vt_daemon *daemon, const char *dir,
                     const struct vt_daemon_options *options);
void vt_daemon_stop(struct vt_daemon *daemon);

/** A request for that many points, with iterations (or the default with -1), to PLY; without the
 *  polish, so that there is a record an iteration and no more work than the test asks for. */
struct vor_spec vt_request(unsigned points, int iterations);

/** Admits a cloud for the input of that name. */
void vt_admit(struct vor_admitted *admitted, struct vor_blobs *blobs, const char *name,
              const struct vor_cloud *cloud);

/** A cloud for an input; a name of NULL ends a list. */
struct vt_input {
    const char *name;
    const struct vor_cloud *cloud;
};

/** Admits clouds and submits them; *id is the job's when VOR_DONE is returned. */
enum vor_job_outcome vt_daemon_submit_inputs(struct vt_daemon *daemon,
                                             const struct vt_input *inputs,
                                             const struct vor_spec *spec, struct vor_uuid *id);

/** The same with one, for the input "cloud". */
enum vor_job_outcome vt_daemon_submit(struct vt_daemon *daemon, const struct vor_cloud *cloud,
                                      const struct vor_spec *spec, struct vor_uuid *id);

/** Submits a sphere of n points. */
enum vor_job_outcome vt_daemon_try_sphere(struct vt_daemon *daemon, size_t n,
                                          const struct vor_spec *spec, struct vor_uuid *id);

/** The same, which must be accepted; the job's id. */
struct vor_uuid vt_daemon_submit_sphere(struct vt_daemon *daemon, size_t n,
                                        const struct vor_spec *spec);

/** A job that runs, and does so until it is told to end. */
struct vor_uuid vt_daemon_submit_endless(struct vt_daemon *daemon);

struct vor_job_view vt_daemon_get(struct vt_daemon *daemon, const struct vor_uuid *id);

/** Reads all events of a job, live or not: how many, of which out has the first `max`. */
size_t vt_daemon_events(struct vt_daemon *daemon, const struct vor_uuid *id, struct vor_event *out,
                        size_t max);

/** Waits until the job is over, or runs, or had so many iterations. */
struct vor_job_view vt_daemon_wait_over(struct vt_daemon *daemon, const struct vor_uuid *id);
struct vor_job_view vt_daemon_wait_iteration(struct vt_daemon *daemon, const struct vor_uuid *id,
                                             unsigned iteration);

/** Waits until no job waits or runs, and the runners have unwound. */
void vt_daemon_wait_idle(struct vt_daemon *daemon);

/** Files that are kept: inputs and results. */
int vt_daemon_kept(const struct vt_daemon *daemon);

/** The bytes of an output that is a blob (malloc), with a NUL behind them. */
uint8_t *vt_daemon_output(struct vt_daemon *daemon, const struct vor_uuid *id, const char *name,
                          size_t *size);

/** The same of the output "cloud". */
uint8_t *vt_daemon_result(struct vt_daemon *daemon, const struct vor_uuid *id, size_t *size);

#endif
