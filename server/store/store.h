/** The rows of the jobs: what survives a crash. SQLite in WAL mode with synchronous=FULL.
 *
 *  Every change is durable when its function returns, and returns what it changed: the store
 * decides who wins when a job ends twice at the same time. Thread-safe; reads do not wait for
 * writes.
 *
 *  Every function fails with VOR_E_IO when the database refuses (vor_error_storage_full tells a
 * full disk apart). After a failed fsync nothing is known about the disk any more: every later
 * change is refused and vor_store_check says so; only a restart helps.
 *
 *  Cost: a change is one transaction and one fsync, 0.2 to 5 ms; a read some 20 microseconds. */
#ifndef VOR_SERVER_STORE_H
#define VOR_SERVER_STORE_H

#include "server/store/row.h"

#include <stddef.h>
#include <stdint.h>

struct vor_store;

/** Opens "sqlite:PATH" (made if missing, with its directory), takes its lock, brings its schema up
 *  to date.
 *
 *  @param[out] holder  0, or the process that has the store already (-1 when it has not said
 *                      which); the caller ends with exit code 75
 *
 *  @retval VOR_E_PARAM no "sqlite:" in front
 *  @retval VOR_E_IO    locked (holder is not 0), not a database, or of a newer version */
VOR_NODISCARD vor_status vor_store_open(struct vor_store **out, const char *where, long *holder,
                                        struct vor_error *err);

/** store may be NULL; no call may be under way. */
void vor_store_close(struct vor_store *store);

/** Is it in working order? For /readyz. */
VOR_NODISCARD vor_status vor_store_check(struct vor_store *store, struct vor_error *err);

/** Adds an accepted job; sets row->seq. Its input blob must be durable before. */
VOR_NODISCARD vor_status vor_store_insert(struct vor_store *store, struct vor_job_view *row,
                                          struct vor_error *err);

/** accepted -> running.
 *
 *  @param[out] attempt  the number of this start, from 1
 *  @param[out] changed  0 when the job is not accepted (any more) */
VOR_NODISCARD vor_status vor_store_claim(struct vor_store *store, const struct vor_uuid *id,
                                         int64_t now_ms, uint32_t *attempt, int *changed,
                                         struct vor_error *err);

/** Notes how far a running job is; nothing happens when the attempt is not the current one. */
VOR_NODISCARD vor_status vor_store_beat(struct vor_store *store, const struct vor_job_view *row,
                                        struct vor_error *err);

/** running -> accepted: the daemon goes down in good order. Counts as no crash. */
VOR_NODISCARD vor_status vor_store_release(struct vor_store *store, const struct vor_uuid *id,
                                           uint32_t attempt, int64_t now_ms, int *changed,
                                           struct vor_error *err);

/** What goes into the row with the final state besides the view; either may be NULL. Borrowed. */
struct vor_store_ending {
    const char *report;   /**< JSON */
    const uint8_t *trace; /**< vor_trace_pack */
    size_t trace_size;
};

/** accepted or running -> row->status (a final one), with progress, record, output, problem,
 *  message, finished and expires of the row.
 *
 *  @param[in]  attempt  only if this is the running attempt; 0 for whichever, also a waiting job
 *  @param[in]  ending   may be NULL
 *  @param[out] changed  0 when the job is unknown, over, or in another attempt */
VOR_NODISCARD vor_status vor_store_finish(struct vor_store *store, const struct vor_job_view *row,
                                          uint32_t attempt, const struct vor_store_ending *ending,
                                          int *changed, struct vor_error *err);

/** @param[out] found  0 when there is no such job; *out is then untouched */
VOR_NODISCARD vor_status vor_store_get(struct vor_store *store, const struct vor_uuid *id,
                                       struct vor_job_view *out, int *found, struct vor_error *err);

/** The report of a job as JSON, the trace as bytes: malloc, the caller frees; NULL when there is
 *  none. The report is NUL-terminated.
 *
 *  @retval VOR_E_NOMEM, VOR_E_IO */
VOR_NODISCARD vor_status vor_store_report(struct vor_store *store, const struct vor_uuid *id,
                                          char **report, struct vor_error *err);
VOR_NODISCARD vor_status vor_store_trace(struct vor_store *store, const struct vor_uuid *id,
                                         uint8_t **trace, size_t *size, struct vor_error *err);

/** Which jobs to list. Zero is "all". */
struct vor_job_filter {
    unsigned statuses;   /**< bit 1 << VOR_JOB_...; 0 for all */
    const char *process; /**< borrowed; NULL for all */
    int64_t before_seq;  /**< only those with a smaller seq: the cursor; 0 from the newest */
    int64_t created_from, created_to;   /**< wall clock, inclusive; 0 for any */
    int64_t duration_min, duration_max; /**< ms since the start, of those that started; 0 for any */
    int64_t now;                        /**< wall clock: the end of what still runs */
    size_t limit;                       /**< 1 .. 10000 */
};

/** Calls each for the jobs that match and have not expired, newest first. each must not call the
 *  store and ends the list by returning 0. */
VOR_NODISCARD vor_status vor_store_list(struct vor_store *store,
                                        const struct vor_job_filter *filter,
                                        int (*each)(void *ctx, const struct vor_job_view *row),
                                        void *ctx, struct vor_error *err);

/** Removes a job that is over.
 *
 *  @param[out] changed  0 when it is unknown or not over */
VOR_NODISCARD vor_status vor_store_remove(struct vor_store *store, const struct vor_uuid *id,
                                          int *changed, struct vor_error *err);

/** Marks up to max jobs whose time is over as expired, drops their report and trace and lists them:
 *  the caller then drops their blobs. Forgets jobs that expired longer ago than they lived. Call
 *  again while count is max. */
VOR_NODISCARD vor_status vor_store_expire(struct vor_store *store, int64_t now_ms,
                                          struct vor_uuid *ids, size_t max, size_t *count,
                                          struct vor_error *err);

/** At start, before anything else: what was running when the daemon died becomes accepted again, or
 *  failed (VOR_E_INTERNAL) when that happened crashes_max times. recovered gets how many of each.
 */
struct vor_recovered {
    uint64_t requeued, failed;
};

VOR_NODISCARD vor_status vor_store_recover(struct vor_store *store, unsigned crashes_max,
                                           int64_t now_ms, int64_t expires_ms,
                                           struct vor_recovered *recovered, struct vor_error *err);

#endif
