/** A job: what is known about it (a plain value) and, while it waits or runs, the live thing. */
#ifndef VOR_SERVER_JOBS_JOB_H
#define VOR_SERVER_JOBS_JOB_H

#include "core/base/watch.h"
#include "core/report.h"
#include "server/base/digest.h"
#include "server/base/uuid.h"
#include "server/jobs/bus.h"

#include <stddef.h>
#include <stdint.h>

/** How the operations on jobs end. */
enum vor_outcome {
    VOR_DONE,
    VOR_UNKNOWN,  /**< no such job */
    VOR_CONFLICT, /**< the job is not in a state that allows it */
    VOR_FULL,     /**< the queue is full: 429 */
    VOR_DRAINING, /**< the daemon is going down: 503 */
    VOR_FAILED    /**< err says why */
};

/** What a client sent, known before the job exists. */
struct vor_job_input {
    unsigned format;              /**< index of vor_format */
    uint64_t points;              /**< decoded */
    uint64_t bytes;               /**< of the upload */
    char sha256[VOR_DIGEST_SIZE]; /**< of the upload */
    double seconds;               /**< decoding took */
};

/** What a client gets. */
struct vor_job_output {
    unsigned format;
    uint64_t points, bytes;
    char sha256[VOR_DIGEST_SIZE];
    uint64_t report_bytes; /**< of the report as JSON; 0 for none */
};

/** Everything statusInfo says; a row of the store and a snapshot of a live job alike. Plain value,
 *  owns nothing. Times are wall-clock milliseconds, 0 for not yet. */
struct vor_job_view {
    struct vor_uuid id;
    int64_t seq;      /**< order of acceptance, from 1 */
    char process[32]; /**< "resample" */
    enum vor_job_status status;
    enum vor_stage stage;
    int progress;         /**< 0 .. 100, never decreases; 100 only when successful */
    uint32_t attempt;     /**< from 1; the next one while the job waits */
    long queue_position;  /**< 0 is next; -1 when not waiting */
    double eta_seconds;   /**< until the last stage of the run ends; -1 when not known */
    struct vor_spec spec; /**< FORMAT is always given */
    struct vor_job_input input;
    struct vor_job_output output; /**< successful */
    int has_record;
    struct vor_record record; /**< the latest */
    struct vor_error problem; /**< failed; status VOR_OK otherwise */
    char message[128];        /**< a sentence for people: what it does, or why it ended */
    int expired;              /**< result and report are gone: 410 */
    int64_t created, started, updated, finished, expires;
};

/** A job that waits or runs. Counted references; thread-safe. */
struct vor_job;

/** A live job for a row of status accepted, with one reference and a bus for attempt
 *  row->attempt; its first event (REPLACED after the first attempt, then STATUS) is published. NULL
 *  when memory is out. */
struct vor_job *vor_job_create(const struct vor_job_view *row);

/** job may be NULL. */
struct vor_job *vor_job_retain(struct vor_job *job);
void vor_job_release(struct vor_job *job);

/** Neither changes during a job's life; borrowed. */
const struct vor_uuid *vor_job_id(const struct vor_job *job);
struct vor_bus *vor_job_bus(const struct vor_job *job);

/** A snapshot; queue_position is -1 (vor_worker_get knows it). Never waits for an fsync. */
void vor_job_view(struct vor_job *job, struct vor_job_view *out);

/** Gives a job the place in the order of acceptance that the store found for it. */
void vor_job_set_seq(struct vor_job *job, int64_t seq);

/* What follows publishes events; the locks that a subscriber's wake takes must not be held. All but
 * vor_job_end do nothing once the job is over. */

/** accepted -> running: a runner begins. Publishes STATUS. */
void vor_job_begin(struct vor_job *job, int64_t now_ms);

/** Enters a stage of a running job. Publishes STATUS. */
void vor_job_stage(struct vor_job *job, enum vor_stage stage, int64_t now_ms);

/** Takes in a record of the run. Publishes PROGRESS (and STATUS at the first
 *  one: prepare is over). */
void vor_job_progress(struct vor_job *job, const struct vor_record *record, int64_t now_ms);

/** Holds every change back until thawed by the same thread, so that the row written meanwhile is
 *  the job's last word. False, and not frozen, when the job is over. */
VOR_NODISCARD int vor_job_freeze(struct vor_job *job);
void vor_job_thaw(struct vor_job *job);

/** Final state of a frozen job, as `row` has it. Publishes END. */
void vor_job_end(struct vor_job *job, const struct vor_job_view *row);

/** Flags for the watch of a run: the answer the next poll gets; it only grows. */
void vor_job_ask(struct vor_job *job, enum vor_answer answer);
enum vor_answer vor_job_asked(struct vor_job *job);

#endif
