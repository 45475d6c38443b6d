/** The rows of the jobs: what survives a crash. The door to whichever driver --store names.
 *
 *  Most verbs are declared in driver.h. A change is durable when its function returns, and returns
 * what it changed: the store decides who wins when a job ends twice at the same time. Thread-safe;
 * a read does not wait for a change.
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
 *  @retval VOR_E_IO no driver has this scheme, locked (holder is not 0), not a database, or of
 *                   another version */
VOR_NODISCARD vor_status vor_store_open(struct vor_store **out, const char *where, int may_share,
                                        long *holder, struct vor_error *err);

/** True where other daemons may use the store at the same time. */
static inline int vor_store_is_shared(const struct vor_store *store)
{
    return store->is_shared;
}

/** The small files of a store that is a file of this machine, as long as it is open; NULL of any
 *  other. Before other threads know the store. */
const struct vor_small_files *vor_store_small_files(struct vor_store *store);

/** A random text that all daemons of the store know, and nobody else; "" where it has but one. */
static inline const char *vor_store_secret(const struct vor_store *store)
{
    return store->secret;
}

/** Keeps so many bytes of the store's disk (server/base/reserve.h), if it has one here, from now
 * on: on a full one they are given up for vor_store_finish, _hand_back, _remove, _evict and _reap,
 * and when it is opened, to which a part is left however full it gets. */
void vor_store_set_reserve(struct vor_store *store, uint64_t bytes);

/** Makes the reserve again once there is room, or only says whether it is there (for HTTP threads).
 *
 *  @retval VOR_E_IO it is not */
VOR_NODISCARD vor_status vor_store_keep_reserve(struct vor_store *store, struct vor_error *err);
VOR_NODISCARD vor_status vor_store_check_reserve(struct vor_store *store, struct vor_error *err);

/** True when a change failed because the disk is full, and there is room for another try now: the
 *  reserve was given up. */
int vor_store_made_room(struct vor_store *store, vor_status status, const struct vor_error *err);

/** Gives some of the room that rows have left back to the disk.
 *
 *  @param[out] left  how much there is still to give; 0: nothing, or the store is no file here
 *
 *  Cost: some syncs, for which changes wait; none when there is nothing to give. */
VOR_NODISCARD vor_status vor_store_give_back(struct vor_store *store, int64_t *left,
                                             struct vor_error *err);

/** store may be NULL; no call may be under way. */
void vor_store_close(struct vor_store *store);

/** Is it in working order? For /readyz.
 *
 *  @param[out] is_lost  where it is not: only a start of the daemon helps, because its disk failed
 * or another daemon has it; else it may come back */
VOR_NODISCARD static inline vor_status vor_store_check(struct vor_store *store, int *is_lost,
                                                       struct vor_error *err)
{
    return store->driver->check(store, is_lost, err);
}

/** Where the store is shared: from now on sends the other daemons a hint at once when this one has
 *  changed jobs, and calls `heard`, on another thread, when they send one. Hints can be lost or
 *  late.
 *
 *  @param[in] where  the database, reached directly or through a pooler in session mode
 *
 *  @retval VOR_E_IO it cannot connect; a connection that breaks later is made again */
VOR_NODISCARD static inline vor_status vor_store_listen(struct vor_store *store, const char *where,
                                                        void (*heard)(void *ctx), void *ctx,
                                                        struct vor_error *err)
{
    return store->driver->listen != NULL ? store->driver->listen(store, where, heard, ctx, err)
                                         : VOR_OK;
}

static inline void vor_store_unlisten(struct vor_store *store)
{
    if (store->driver->listen != NULL)
        (void)store->driver->listen(store, NULL, NULL, NULL, NULL);
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

/** Moves the time at which each job expires: the wall clock has moved by that. */
VOR_NODISCARD vor_status vor_store_shift(struct vor_store *store, int64_t by_ms,
                                         struct vor_error *err);

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

#endif
