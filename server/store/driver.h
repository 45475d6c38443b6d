/** What a store of rows is made of, and what it is asked with. Callers include store.h. A driver is
 *  a table of functions, one table for each kind of database: its own header declares it, and
 *  store.c lists it. Every function may be called from any thread.
 *
 *  Each change to a running job names its owner and its attempt, the number that claim_next
 *  returned. A change that names another owner or an older attempt does nothing, because another
 *  worker has the job by then, and says so. */
#ifndef VOR_SERVER_STORE_DRIVER_H
#define VOR_SERVER_STORE_DRIVER_H

#include "core/base/status.h"
#include "server/base/reserve.h"
#include "server/base/small_files.h"
#include "server/store/row.h"

#include <stddef.h>
#include <stdint.h>

/** A driver's store begins with this, all zero; the door fills in the first two. */
struct vor_store {
    const struct vor_store_driver *driver;
    struct vor_reserve *reserve;  /**< of the disk; NULL for none */
    struct vor_small_files small; /**< vor_store_small_files */
    int is_shared;                /**< other daemons may use it at the same time */
    char secret[96];              /**< the driver's: of a shared store, with its NUL */
};

/** Whose attempt a change belongs to. */
struct vor_lease {
    const char *owner; /**< borrowed: of this life of a daemon alone */
    uint32_t attempt;  /**< as claim_next returned it */
};

/** The next events of an attempt: a piece that the store keeps as it is. Borrowed. */
struct vor_event_piece {
    uint32_t last; /**< number of the last of them */
    const uint8_t *data;
    size_t size; /**< 0 for none */
};

/** What is written with the final state besides the view. */
struct vor_store_ending {
    const char *report; /**< JSON: the output that is kept in the row; borrowed, or NULL */
    struct vor_event_piece events;
};

/** Which events to read, and who gets each piece; 0 from it ends the reading. */
struct vor_event_query {
    uint32_t attempt;
    uint32_t after; /**< pieces whose last event is this one, or an earlier one, are left out */
    int (*each)(void *ctx, const struct vor_event_piece *piece);
    void *ctx;
};

/** Which jobs to list. Zero is "all". */
struct vor_job_filter {
    unsigned statuses;   /**< bit 1 << VOR_JOB_...; 0 for all */
    const char *process; /**< borrowed; NULL for all */
    int64_t before_seq;  /**< only those with a smaller seq: the cursor; 0 from the newest */
    int64_t created_from, created_to;   /**< wall clock, inclusive; 0 for any */
    const char *name;                   /**< borrowed; NULL for any */
    int64_t duration_min, duration_max; /**< ms since the start, of those that started; 0 for any */
    int64_t now;                        /**< wall clock: the end of what still runs */
    const char *tenant;                 /**< borrowed; only this principal's; NULL for any */
    size_t limit;                       /**< 1 .. 10000 */
};

/** What the files of a job hang on. */
struct vor_job_brief {
    enum vor_job_status status;
    char process[32]; /**< as in the view, as the next two */
    uint64_t kept;
    int expired;
    uint32_t attempt; /**< 0 where none was begun */
};

/** A job that keeps uploads. */
struct vor_keeping {
    int64_t seq;
    struct vor_uuid id;
    char process[32]; /**< as in the view, as the next */
    uint64_t kept;
};

/** What a principal may have, and has: jobs that wait or run, bytes of kept uploads and of results.
 */
struct vor_ledger {
    uint64_t jobs_max, bytes_max; /**< the caller's; 0 for any */
    uint64_t jobs, bytes;         /**< the store's: there are so many */
    int is_over;                  /**< the store's: with one job more there would be too many */
};

/** Would one job more, with so many bytes, be within it? */
static inline int vor_ledger_fits(const struct vor_ledger *ledger, uint64_t bytes)
{
    if (ledger->jobs_max > 0 && ledger->jobs >= ledger->jobs_max)
        return 0;
    return ledger->bytes_max == 0 ||
           (ledger->bytes <= ledger->bytes_max && bytes <= ledger->bytes_max - ledger->bytes);
}

/** Why jobs lose what they keep, and the limit above which they do. */
enum vor_evict {
    VOR_EVICT_EXPIRED, /**< their time is over: the time now, 0 by the store's clock; they expire */
    VOR_EVICT_UPLOADS, /**< bytes of all kept uploads; they give up theirs */
    VOR_EVICT_RESULTS  /**< bytes of all results; they expire */
};

/** The jobs that were evicted, in any order: their blobs, or those of their uploads, are to be
 *  dropped. */
struct vor_evictions {
    struct vor_evicted {
        struct vor_uuid id;
        char process[32]; /**< as in the view */
        uint32_t attempt; /**< as in the brief */
    } * job;              /**< the caller's room for so many */
    size_t max, count;
};

/** Who claims a job, and what may be claimed. */
struct vor_claim {
    const char *owner; /**< borrowed */
    int64_t now_ms;
    uint64_t memory;        /**< bytes: a job that needs more is not claimed; UINT64_MAX for any */
    int may_be_alone;       /**< also one that is to have nothing beside it (vor_job_view.alone) */
    struct vor_build build; /**< the claimer's */
};

/** The lease of an owner on all jobs that it runs, made longer. */
struct vor_renewal {
    const char *owner; /**< borrowed */
    struct vor_build build;
    int64_t lease_ms; /**< it ends so much later than now, by the clock of the store */
    struct vor_leased {
        struct vor_uuid id;
        uint32_t attempt;
        int stops;     /**< a caller asked for that (vor_store_stop) */
        int is_looked; /**< likewise (vor_store_look) */
    } * job;           /**< the caller's room for so many: those that are still the owner's */
    size_t max, count; /**< count may be more than max */
};

/** A run that came to nothing, whose job is to wait again. */
struct vor_hand_back {
    struct vor_lease lease; /**< the caller's, as the next four */
    int64_t now_ms;
    int is_crash;     /**< its process has ended without a word: the job is to run alone */
    int was_alone;    /**< and nothing ran beside it, which counts against the job */
    unsigned most;    /**< so many crashes that count end the job: it is not put back; 0: none do */
    int changed;      /**< the store's: 0 when the attempt is not this owner's any more */
    unsigned crashes; /**< that count against the job, this one included */
    int is_over;      /**< it crashed too often, and stays running: its caller is to finish it */
};

/** What waits. */
struct vor_waiting {
    uint64_t jobs, decoded; /**< how many, and the bytes of their decoded inputs */
    int64_t oldest_ms;      /**< when the one that is next was accepted; 0 when none waits */
};

/** What a move of all jobs has come to. */
struct vor_store_copied {
    uint64_t jobs, were_there; /**< that are there now, and that were before */
};

/** What differs between databases besides their SQL (sql.h). */
struct vor_store_driver {
    const char *scheme; /**< "sqlite": what stands before the colon of --store */
    const char *place;  /**< "PATH": what stands after it, for messages */
    int is_file;        /**< place is a path here: the door keeps a reserve beside it */
    vor_status (*open)(struct vor_store **out, const char *place, int may_share, long *holder,
                       struct vor_error *err);
    void (*close)(struct vor_store *store); /**< the reserve too, before others may open its file */
    vor_status (*check)(struct vor_store *store, int *is_lost, struct vor_error *err);
    /** vor_store_give_back; NULL for a store that has no file here. */
    vor_status (*give_back)(struct vor_store *store, int64_t *left, struct vor_error *err);
    /** NULL for a store that daemons cannot share. */
    vor_status (*listen)(struct vor_store *store, const char *where, void (*heard)(void *ctx),
                         void *ctx, struct vor_error *err);
};

/** In a file of SQLite: WAL mode with synchronous=FULL. PATH.lock says that the file is ours. One
 *  connection writes and others read, so that no reader waits for an fsync.
 *
 *  Cost: a change is one transaction and one fsync, 0.2 to 5 ms; a read some 20 microseconds. */
extern const struct vor_store_driver vor_store_sqlite;

/** In a database of PostgreSQL, from version 13 on: its tables stand in the first schema of the
 *  search path, and one daemon at a time has them, unless they are shared. So jobs outlive the
 *  machine, and a daemon that starts elsewhere goes on with them.
 *
 *  Cost: a change is one transaction, of three to five round trips; a read one round trip. libpq is
 *  loaded when such a store is opened. */
extern const struct vor_store_driver vor_store_postgres;

/* --- the verbs, but for those that a full disk makes room for (store.h) ------------------------
 */

/** Adds an accepted job; sets row->seq. The blobs of its inputs must be durable before,
 *  or become so with it.
 *
 *  @param[in,out] ledger  what its principal may have with this job and the uploads that it keeps:
 *                         if that is too much, is_over is set and nothing is added. NULL: anything
 *
 *  @retval VOR_E_IO also when the row's key is that of another job */
VOR_NODISCARD vor_status vor_store_insert(struct vor_store *store, struct vor_job_view *row,
                                          struct vor_ledger *ledger, struct vor_error *err);

/** accepted -> running of the job that is next, if it may be claimed; no other goes before it.
 *  Events of its former attempts go. A job of a later release than the claimer's, and one of
 * another engine while a daemon that has a lease is of that engine, is left to others.
 *
 *  The queue goes in rounds. In each round every principal gets one job, and the jobs of one
 *  principal start in the order of acceptance. A principal without waiting jobs joins the current
 *  round, so that its job does not wait behind the many that others have queued. Each row gets its
 *  round (turn) when it is inserted; jobs start by round, and within a round by acceptance.
 *
 *  @param[out] out    the row as it is now; its attempt is the number of this start, from 1
 *  @param[out] found  0 when none waits, or the next one may not be claimed; *out is then untouched
 *
 *  Cost: one look at an index, however many wait. A crash of the machine may undo it. */
VOR_NODISCARD vor_status vor_store_claim_next(struct vor_store *store,
                                              const struct vor_claim *claim,
                                              struct vor_job_view *out, int *found,
                                              struct vor_error *err);

/** Makes the lease of an owner longer, or begins it, and says which jobs are still its: any other
 *  that it runs was dismissed, or is another owner's by now, and no change of its does anything to
 *  it. Waits for no other daemon's change.
 *
 *  Cost: as many rows as it runs jobs. A crash of the machine may undo it. */
VOR_NODISCARD vor_status vor_store_renew(struct vor_store *store, struct vor_renewal *renewal,
                                         struct vor_error *err);

/** How many daemons have a lease. */
VOR_NODISCARD vor_status vor_store_daemons(struct vor_store *store, int64_t *count,
                                           struct vor_error *err);

/** Adds events to those of a running attempt, behind all that it has, and notes progress and record
 *  of the row.
 *
 *  @param[out] changed  0 when the attempt is not this owner's any more
 *
 *  Cost: a crash of the machine may undo it. */
VOR_NODISCARD vor_status vor_store_append_events(struct vor_store *store,
                                                 const struct vor_job_view *row,
                                                 const struct vor_lease *lease,
                                                 const struct vor_event_piece *piece, int *changed,
                                                 struct vor_error *err);

/** Asks the owner of a running attempt to end it now, with what it has: vor_store_renew tells him.
 *
 *  @param[out] changed  0 when the job does not run */
VOR_NODISCARD vor_status vor_store_stop(struct vor_store *store, const struct vor_uuid *id,
                                        int *changed, struct vor_error *err);

/** Tells the owner of a running attempt, by vor_store_renew, that somebody looks at its points, for
 *  the next 10 s. */
VOR_NODISCARD vor_status vor_store_look(struct vor_store *store, const struct vor_uuid *id,
                                        struct vor_error *err);

/** Puts a preview of a running attempt in place of the one before; size 0: there is none any more.
 *  It is read as the only event of attempt VOR_STORE_PREVIEW, and piece->last is its version. */
enum { VOR_STORE_PREVIEW = 0 };
VOR_NODISCARD vor_status vor_store_show(struct vor_store *store, const struct vor_uuid *id,
                                        const struct vor_lease *lease,
                                        const struct vor_event_piece *piece, struct vor_error *err);

/** True once the answer to a change was lost (vor_error_may_be_done): what waits and runs in the
 *  store need not be what its callers have counted. */
int vor_store_is_unsure(struct vor_store *store);

/** A job of this principal (NULL: of any).
 *
 *  @param[out] found  0 when there is no such job; *out is then untouched
 *
 *  Cost: of a job that waits also some hundred steps over an index, and one for each principal
 *  that has jobs waiting, for its place in the queue. */
VOR_NODISCARD vor_status vor_store_get(struct vor_store *store, const struct vor_uuid *id,
                                       const char *tenant, struct vor_job_view *out, int *found,
                                       struct vor_error *err);

/** A few columns of a job, for who asks about very many.
 *
 *  @param[out] found  0 when there is no such job; *out is then untouched
 *
 *  Cost: one look at an index. */
VOR_NODISCARD vor_status vor_store_brief(struct vor_store *store, const struct vor_uuid *id,
                                         struct vor_job_brief *out, int *found,
                                         struct vor_error *err);

/** What a principal has: sets jobs and bytes.
 *
 *  Cost: a read of one row, however many jobs there are. */
VOR_NODISCARD vor_status vor_store_ledger(struct vor_store *store, const char *tenant,
                                          struct vor_ledger *ledger, struct vor_error *err);

/** The job that has this key of this principal; key->fingerprint does not matter. A job has its key
 *  until it expires or is removed.
 *
 *  @param[out] found  0 when there is none; *out is then untouched */
VOR_NODISCARD vor_status vor_store_find_key(struct vor_store *store, const struct vor_job_key *key,
                                            struct vor_job_view *out, int *found,
                                            struct vor_error *err);

/** The output of a job that is kept in its row (vor_output_in_row), as JSON: malloc, the caller
 *  frees; NULL when there is none. All others are blobs.
 *
 *  @retval VOR_E_NOMEM, VOR_E_IO */
VOR_NODISCARD vor_status vor_store_report(struct vor_store *store, const struct vor_uuid *id,
                                          char **report, struct vor_error *err);

/** Calls query->each for the events of an attempt, in the pieces that were appended, in order. It
 *  must not call the store. A job has its events until it expires or is removed. */
VOR_NODISCARD vor_status vor_store_events(struct vor_store *store, const struct vor_uuid *id,
                                          const struct vor_event_query *query,
                                          struct vor_error *err);

/** Calls each for the jobs that match and have not expired, newest first. each must not call the
 *  store and ends the list by returning 0. */
VOR_NODISCARD vor_status vor_store_list(struct vor_store *store,
                                        const struct vor_job_filter *filter,
                                        int (*each)(void *ctx, const struct vor_job_view *row),
                                        void *ctx, struct vor_error *err);

/** Calls each for some of the jobs that keep uploads, from those before `seq` on, newest first;
 * none where there are no more. It must not call the store and ends the list by returning 0. Cost:
 * what files hang on is read, and no request: 100,000 rows take .1 s. */
VOR_NODISCARD vor_status vor_store_keeping(struct vor_store *store, int64_t seq,
                                           int (*each)(void *ctx, const struct vor_keeping *job),
                                           void *ctx, struct vor_error *err);

/** How much waits. Cost: one step for each 256 jobs of the one who has most. */
VOR_NODISCARD vor_status vor_store_waiting(struct vor_store *store, struct vor_waiting *out,
                                           struct vor_error *err);

/** Notes that a job keeps no uploads any more. */
VOR_NODISCARD vor_status vor_store_forget_uploads(struct vor_store *store,
                                                  const struct vor_uuid *id, struct vor_error *err);

/** The latest time that a row was changed, or nearly; 0 when there is none. */
VOR_NODISCARD vor_status vor_store_newest(struct vor_store *store, int64_t *newest_ms,
                                          struct vor_error *err);

/** Copies all jobs of one store into another, whatever their drivers: rows, reports, events, and
 *  whose turn is next. A job that was running is copied as such. No daemon may use either.
 *
 *  @param[in] into  empty, or with the first jobs of `from`, as a copy that was broken off leaves
 *                   it: then it goes on from there
 *
 *  @retval VOR_E_IO also when `into` has other jobs, or not as many in the end
 *
 *  Cost: a durable change for each job. */
VOR_NODISCARD vor_status vor_store_copy(struct vor_store *into, struct vor_store *from,
                                        struct vor_store_copied *out, struct vor_error *err);

#endif
