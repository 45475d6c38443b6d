/** A job that waits or runs: its row kept current, its latest events, and what was asked of its
 * run. */
#ifndef VOR_SERVER_JOBS_JOB_H
#define VOR_SERVER_JOBS_JOB_H

#include "core/base/watch.h"
#include "core/report.h"
#include "server/jobs/events.h"
#include "server/jobs/preview.h"
#include "server/store/row.h"

#include <stdint.h>

/** How the operations on jobs end. */
enum vor_job_outcome {
    VOR_DONE,
    VOR_UNKNOWN,    /**< no such job */
    VOR_CONFLICT,   /**< the job is not in a state that allows it */
    VOR_FULL,       /**< the queue is full: 429 */
    VOR_CROWDED,    /**< the caller has as many jobs as he may: 429 */
    VOR_OVER_BYTES, /**< the caller has as many bytes stored as he may: 429 */
    VOR_DRAINING,   /**< the daemon is going down: 503 */
    VOR_FAILED      /**< err says why */
};

/** A job that waits or runs; begins with its identifier. Counted references; thread-safe. */
struct vor_job;

/** A live job for a row of status accepted, with one reference; the first event of attempt
 *  row->attempt (REPLACED after the first attempt, then STATUS) is published. NULL when memory is
 *  out. */
struct vor_job *vor_job_create(const struct vor_job_view *row);

/** job may be NULL. */
struct vor_job *vor_job_retain(struct vor_job *job);
void vor_job_release(struct vor_job *job);

/** None of them changes during a job's life; borrowed. */
const struct vor_uuid *vor_job_id(const struct vor_job *job);
struct vor_preview *vor_job_preview(const struct vor_job *job);

/** Asks for wake to be called after every event, from the publisher's thread. wake must be quick,
 *  may read the job, must not subscribe or unsubscribe. Keep the struct until unsubscribed; the
 *  caller fills in wake and ctx. job may be NULL in both: it is over, and has no event more. */
struct vor_subscriber {
    void (*wake)(void *ctx, enum vor_event_kind kind);
    void *ctx;
    struct vor_subscriber *next; /**< the job's own */
};

void vor_job_subscribe(struct vor_job *job, struct vor_subscriber *subscriber);

/** When this returns, wake is not running and will not be called again: do not call it while
 *  holding a lock that wake takes. One that never subscribed is fine. */
void vor_job_unsubscribe(struct vor_job *job, struct vor_subscriber *subscriber);

/** Reads events that the store does not have yet, and END. Never waits for an fsync. A position
 *  behind the last event that is known stays while the job runs at another daemon, which may have
 *  told it.
 *
 *  @return false, and nothing is read, where the store has the next one */
int vor_job_read(struct vor_job *job, struct vor_event_batch *batch);

/** Reads the END of a row that is over, whose other events end with number `last`, unless it was
 *  read. */
void vor_job_read_end(const struct vor_job_view *row, uint32_t last, struct vor_event_batch *batch);

/** True from its END on. */
int vor_job_is_over(struct vor_job *job);

/** Says what a job does, in its message: of a row that is not over, as of a live job. */
void vor_job_describe(struct vor_job_view *view, enum vor_answer asked);

/** A snapshot; queue_position is -1 (the store knows it). Never waits for an fsync. */
void vor_job_view(struct vor_job *job, struct vor_job_view *out);

/* What follows publishes events; the locks that a subscriber's wake takes must not be held. All but
 * vor_job_end do nothing once the job is over. */

/** accepted -> running: a runner begins. Publishes STATUS. */
void vor_job_begin(struct vor_job *job, int64_t now_ms);

/** running -> accepted: nothing came of the attempt, and the next one begins anew, with nothing
 *  beside it if is_suspect. Publishes REPLACED and STATUS as the first events of that attempt.
 *
 *  @return false when the job is over */
VOR_NODISCARD int vor_job_restart(struct vor_job *job, int is_suspect, int64_t now_ms);

/** Enters a stage of a running job. Publishes STATUS. */
void vor_job_stage(struct vor_job *job, enum vor_stage stage, int64_t now_ms);

/** Tells that a job was asked to stop while its input is prepared, which ends first. Publishes
 *  STATUS; nothing in other stages, where a stop takes effect at once. */
void vor_job_tell_stop(struct vor_job *job, int64_t now_ms);

/** Takes in a record of the run. Publishes PROGRESS (and STATUS at the first
 *  one: prepare is over). */
void vor_job_progress(struct vor_job *job, const struct vor_record *record, int64_t now_ms);

/** Shows where the points of a run are, to who looks at vor_job_preview; wakes the subscribers as a
 *  progress does, without an event. */
void vor_job_show(struct vor_job *job, const struct vor_shown *shown);

/** The same for what another daemon has packed (vor_preview_pack). */
void vor_job_show_packed(struct vor_job *job, uint32_t attempt,
                         const struct vor_event_piece *piece);

/** Holds every change back until thawed by the same thread, so that the row written meanwhile is
 *  the job's last word. False, and not frozen, when the job is over. */
VOR_NODISCARD int vor_job_freeze(struct vor_job *job);
void vor_job_thaw(struct vor_job *job);

/** Of a frozen job: the events that the store does not have yet, borrowed until it is thawed; and
 *  that it has them now. */
struct vor_event_piece vor_job_piece(const struct vor_job *job);
int vor_job_is_stored(
    struct vor_job *job); /**< the store has all; also of one that is not frozen */
void vor_job_stored(struct vor_job *job);

/** A job that runs elsewhere, or may: takes over what its row says, whose attempt's events up to
 *  number `last` the store has. Publishes what is new; nothing once the job is over. */
void vor_job_mirror(struct vor_job *job, const struct vor_job_view *row, uint32_t last);

/** Number of the newest event of an attempt, 0 when the job is at another one. */
uint32_t vor_job_newest(struct vor_job *job, uint32_t attempt);

/** Final state of a frozen job, as `row` has it. Publishes END. */
void vor_job_end(struct vor_job *job, const struct vor_job_view *row);

/** Flags for the watch of a run: the answer the next poll gets; it only grows. */
void vor_job_ask(struct vor_job *job, enum vor_answer answer);
enum vor_answer vor_job_asked(struct vor_job *job);
void vor_job_unask(struct vor_job *job); /**< another run begins, of which nobody has asked */

#endif
