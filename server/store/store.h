/** The rows of the jobs: what survives a crash. The door to whichever driver --store names.
 *
 *  Every change is durable when its function returns, and returns what it changed: the store
 *  decides who wins when a job ends twice at the same time. Thread-safe; a read does not wait for a
 *  change.
 *
 *  Every function fails with VOR_E_IO when the database refuses (vor_error_storage_full tells a
 *  full disk apart). After a failed fsync nothing is known about the disk any more: every later
 *  change is refused and vor_store_check says so; only a restart helps.
 *
 *  Cost: a change waits for the disk (not for HTTP threads), a read does not. */
#ifndef VOR_SERVER_STORE_H
#define VOR_SERVER_STORE_H

#include "server/store/driver.h"

/** Driver number `index`, NULL past the last. */
const struct vor_store_driver *vor_store_driver_at(unsigned index);

/** Opens "SCHEME:PLACE" ("sqlite:PATH": made if missing, with its directory), takes its lock.
 *
 *  @param[in]  may_share  other daemons may have it as well, where the driver can do that: it is
 * then locked only against those that want it for themselves
 *  @param[out] holder  0, or the process that has the store already (-1 when it has not said
 *                      which); the caller ends with exit code 75
 *
 *  @retval VOR_E_PARAM no driver has this scheme, or nothing follows it
 *  @retval VOR_E_IO    locked (holder is not 0), not a database, or of another version */
VOR_NODISCARD vor_status vor_store_open(struct vor_store **out, const char *where, int may_share,
                                        long *holder, struct vor_error *err);

/** True where other daemons may use the store at the same time. */
static inline int vor_store_is_shared(const struct vor_store *store)
{
    return store->is_shared;
}

/** A random text that all daemons of the store know, and nobody else; "" where it has but one. */
static inline const char *vor_store_secret(const struct vor_store *store)
{
    return store->secret;
}

/** Keeps so many bytes of the store's disk (server/base/reserve.h), and some that are left to the
 *  next opening however full it gets, if it has a disk here, from now
 *  on: on a full one they are given up for vor_store_finish, _hand_back, _remove, _evict and
 *  _reap, and when it is opened. */
void vor_store_set_reserve(struct vor_store *store, uint64_t bytes);

/** Makes the reserve again once there is room, or only says whether it is there (for HTTP threads).
 *
 *  @retval VOR_E_IO it is not */
VOR_NODISCARD vor_status vor_store_keep_reserve(struct vor_store *store, struct vor_error *err);
VOR_NODISCARD vor_status vor_store_check_reserve(struct vor_store *store, struct vor_error *err);

/** store may be NULL; no call may be under way. */
void vor_store_close(struct vor_store *store);

/** True when changes were lost since the store was last open: rows may be missing, or be as they
 * were before. A driver that cannot know says no. */
int vor_store_is_damaged(const struct vor_store *store);

/** Is it in working order? For /readyz.
 *
 *  @param[out] is_lost  where it is not: only a start of the daemon helps, because its disk failed
 * or another daemon has it; else it may come back */
VOR_NODISCARD static inline vor_status vor_store_check(struct vor_store *store, int *is_lost,
                                                       struct vor_error *err)
{
    return store->driver->check(store, is_lost, err);
}

/** Adds an accepted job; sets row->seq. The blobs of its inputs must be durable before.
 *
 *  @param[in,out] ledger  what its principal may have with this job and the uploads that it keeps:
 *                         if that is too much, is_over is set and nothing is added. NULL: anything
 *
 *  @retval VOR_E_IO also when the row's key is that of another job */
VOR_NODISCARD static inline vor_status vor_store_insert(struct vor_store *store,
                                                        struct vor_job_view *row,
                                                        struct vor_ledger *ledger,
                                                        struct vor_error *err)
{
    return store->driver->insert(store, row, ledger, err);
}

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
VOR_NODISCARD static inline vor_status vor_store_claim_next(struct vor_store *store,
                                                            const struct vor_claim *claim,
                                                            struct vor_job_view *out, int *found,
                                                            struct vor_error *err)
{
    return store->driver->claim_next(store, claim, out, found, err);
}

/** Makes the lease of an owner longer, or begins it, and says which jobs are still its: any other
 *  that it runs was dismissed, or is another owner's by now, and no change of its does anything to
 *  it. Waits for no other daemon's change.
 *
 *  Cost: as many rows as it runs jobs. A crash of the machine may undo it. */
VOR_NODISCARD static inline vor_status
vor_store_renew(struct vor_store *store, struct vor_renewal *renewal, struct vor_error *err)
{
    return store->driver->renew(store, renewal, err);
}

/** Adds events to those of a running attempt, behind all that it has, and notes progress and record
 *  of the row.
 *
 *  @param[out] changed  0 when the attempt is not this owner's any more
 *
 *  Cost: a crash of the machine may undo it. */
VOR_NODISCARD static inline vor_status vor_store_append_events(struct vor_store *store,
                                                               const struct vor_job_view *row,
                                                               const struct vor_lease *lease,
                                                               const struct vor_event_piece *piece,
                                                               int *changed, struct vor_error *err)
{
    return store->driver->append_events(store, row, lease, piece, changed, err);
}

/** Asks the owner of a running attempt to end it now, with what it has: vor_store_renew tells him.
 *
 *  @param[out] changed  0 when the job does not run */
VOR_NODISCARD static inline vor_status vor_store_stop(struct vor_store *store,
                                                      const struct vor_uuid *id, int *changed,
                                                      struct vor_error *err)
{
    return store->driver->stop(store, id, changed, err);
}

/** running -> accepted, in its place: the daemon goes down in good order, or the run's process has
 *  ended. A job that has crashed too often (run->most) stays running, so that nobody claims it
 *  before its caller finishes it. */
VOR_NODISCARD vor_status vor_store_hand_back(struct vor_store *store, const struct vor_uuid *id,
                                             struct vor_hand_back *run, struct vor_error *err);

/** accepted or running -> row->status (a final one), with progress, record, outputs, problem,
 *  message, finished and expires of the row; what it keeps only becomes less.
 *
 *  @param[in]  lease    its owner's attempt must still run; NULL ends the job in any state that
 *                       is not final
 *  @param[in]  ending   may be NULL
 *  @param[out] changed  0 when the job is unknown or has ended, or the lease does not hold */
VOR_NODISCARD vor_status vor_store_finish(struct vor_store *store, const struct vor_job_view *row,
                                          const struct vor_lease *lease,
                                          const struct vor_store_ending *ending, int *changed,
                                          struct vor_error *err);

/** A job of this principal (NULL: of any).
 *
 *  @param[out] found  0 when there is no such job; *out is then untouched
 *
 *  Cost: of a job that waits also some hundred steps over an index, and one for each principal
 *  that has jobs waiting, for its place in the queue. */
VOR_NODISCARD static inline vor_status vor_store_get(struct vor_store *store,
                                                     const struct vor_uuid *id, const char *tenant,
                                                     struct vor_job_view *out, int *found,
                                                     struct vor_error *err)
{
    return store->driver->get(store, id, tenant, out, found, err);
}

/** A few columns of a job, for who asks about very many.
 *
 *  @param[out] found  0 when there is no such job; *out is then untouched
 *
 *  Cost: one look at an index. */
VOR_NODISCARD static inline vor_status vor_store_brief(struct vor_store *store,
                                                       const struct vor_uuid *id,
                                                       struct vor_job_brief *out, int *found,
                                                       struct vor_error *err)
{
    return store->driver->brief(store, id, out, found, err);
}

/** What a principal has: sets jobs and bytes.
 *
 *  Cost: a read of one row, however many jobs there are. */
VOR_NODISCARD static inline vor_status vor_store_ledger(struct vor_store *store, const char *tenant,
                                                        struct vor_ledger *ledger,
                                                        struct vor_error *err)
{
    return store->driver->ledger(store, tenant, ledger, err);
}

/** The job that has this key of this principal; key->fingerprint does not matter. A job has its key
 *  until it expires or is removed.
 *
 *  @param[out] found  0 when there is none; *out is then untouched */
VOR_NODISCARD static inline vor_status vor_store_find_key(struct vor_store *store,
                                                          const struct vor_job_key *key,
                                                          struct vor_job_view *out, int *found,
                                                          struct vor_error *err)
{
    return store->driver->find_key(store, key, out, found, err);
}

/** The output of a job that is kept in its row (vor_output_in_row), as JSON: malloc, the caller
 *  frees; NULL when there is none. All others are blobs.
 *
 *  @retval VOR_E_NOMEM, VOR_E_IO */
VOR_NODISCARD static inline vor_status vor_store_report(struct vor_store *store,
                                                        const struct vor_uuid *id, char **report,
                                                        struct vor_error *err)
{
    return store->driver->report(store, id, report, err);
}

/** Calls query->each for the events of an attempt, in the pieces that were appended, in order. It
 *  must not call the store. A job has its events until it expires or is removed. */
VOR_NODISCARD static inline vor_status vor_store_events(struct vor_store *store,
                                                        const struct vor_uuid *id,
                                                        const struct vor_event_query *query,
                                                        struct vor_error *err)
{
    return store->driver->events(store, id, query, err);
}

/** Calls each for the jobs that match and have not expired, newest first. each must not call the
 *  store and ends the list by returning 0. */
VOR_NODISCARD static inline vor_status
vor_store_list(struct vor_store *store, const struct vor_job_filter *filter,
               int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
               struct vor_error *err)
{
    return store->driver->list(store, filter, each, ctx, err);
}

/** How much waits. Cost: one step for each 256 jobs of the one who has most. */
VOR_NODISCARD static inline vor_status
vor_store_waiting(struct vor_store *store, struct vor_waiting *out, struct vor_error *err)
{
    return store->driver->waiting(store, out, err);
}

/** Removes a job that is over.
 *
 *  @param[out] changed  0 when it is unknown or not over */
VOR_NODISCARD vor_status vor_store_remove(struct vor_store *store, const struct vor_uuid *id,
                                          int *changed, struct vor_error *err);

/** Takes from up to max jobs what they keep, as far as a limit wants it; call again while count is
 *  max. A job that expires loses its report, events, key and kept uploads.
 *  VOR_EVICT_EXPIRED: those first whose time was over first; also forgets jobs that expired longer
 *  ago than they lived. VOR_EVICT_UPLOADS: those first that ended first, and never one that is not
 *  over. VOR_EVICT_RESULTS: likewise, but never the last one to end.
 *
 *  Cost: a read as long as the limit holds, else a change or two, however many jobs there are. */
VOR_NODISCARD vor_status vor_store_evict(struct vor_store *store, enum vor_evict why, int64_t limit,
                                         struct vor_evictions *evictions, struct vor_error *err);

/** Notes that a job keeps no uploads any more. */
VOR_NODISCARD static inline vor_status
vor_store_forget_uploads(struct vor_store *store, const struct vor_uuid *id, struct vor_error *err)
{
    return store->driver->forget_uploads(store, id, err);
}

/** Moves the time at which each job expires: the wall clock has moved by that. */
VOR_NODISCARD vor_status vor_store_shift(struct vor_store *store, int64_t by_ms,
                                         struct vor_error *err);

/** The latest time that a row was changed, or nearly; 0 when there is none. */
VOR_NODISCARD static inline vor_status vor_store_newest(struct vor_store *store, int64_t *newest_ms,
                                                        struct vor_error *err)
{
    return store->driver->newest(store, newest_ms, err);
}

/** Daemons have ended while these jobs ran: every running job of another owner becomes accepted
 *  again, to be run with nothing beside it (vor_job_view.alone). What ran in another process cannot
 *  be why a daemon ended, so nothing counts against a job.
 *
 *  @param[in]  is_alone  it is known that there is no other daemon, as after an opening that locks
 *                        the store; else only jobs of owners whose leases have ended, or who never
 *                        had one
 *  @param[out] reaped    how many */
VOR_NODISCARD vor_status vor_store_reap(struct vor_store *store, const char *owner, int is_alone,
                                        int64_t now_ms, uint64_t *reaped, struct vor_error *err);

/** Copies all jobs of one store into another, whatever their drivers: rows, reports, events, and
 *  whose turn is next. A job that was running is copied as such. No daemon may use either.
 *
 *  @param[in] into  empty, or with the first jobs of `from`, as a copy that was broken off leaves
 *                   it: then it goes on from there
 *
 *  @retval VOR_E_IO also when `into` has other jobs, or not as many in the end
 *
 *  Cost: a durable change for each job. */
VOR_NODISCARD static inline vor_status vor_store_copy(struct vor_store *into,
                                                      struct vor_store *from,
                                                      struct vor_store_copied *out,
                                                      struct vor_error *err)
{
    return into->driver->copy(into, from, out, err);
}

#endif
