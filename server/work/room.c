#include "server/work/live.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <errno.h>
#include <time.h>

vor_status vor_worker_ready(struct vor_worker *worker, struct vor_error *err)
{
    struct vor_error why;
    const char *part = "--store";
    int is_lost;
    vor_status status = vor_store_check(worker->config.store, &is_lost, &why);

    if (status == VOR_OK && atomic_load(&worker->is_late))
        status = vor_fail_errno(&why, ENOSPC, "recovering earlier jobs");
    if (status == VOR_OK)
        status = vor_store_check_reserve(worker->config.store, &why);
    if (status == VOR_OK) {
        part = "--blobs";
        status = vor_blobs_reach(worker->config.blobs, &why);
    }
    if (status == VOR_OK)
        status = vor_blobs_room(worker->config.blobs, 1, &why);
    if (status == VOR_OK)
        return VOR_OK;
    (void)vor_fail(err, status, "%s: %.900s", part, why.message);
    err->got = why.got;
    return status;
}

void vor_worker_look(struct vor_worker *worker)
{
    struct vor_error err;
    int is_away = vor_blobs_reach(worker->config.blobs, &err) != VOR_OK, is_lost = 0;
    vor_status status;

    /* While the blobs are away no job begins. */
    vor_metric_set(VOR_METRIC_STORAGE_UP, !is_away, VOR_LABELS("blobs"));
    if (is_away && !worker->is_away)
        vor_log(VOR_LOG_ERROR, "files cannot be read or written: no job starts",
                VOR_TEXT("error", err.message));
    if (!is_away && worker->is_away) {
        vor_log(VOR_LOG_INFO, "files can be read and written again");
        vor_worker_news(worker);
    }
    worker->is_away = is_away;
    if (!atomic_load(&worker->is_late)) { /* recovery needs the room more than the reserve does */
        int had = vor_store_check_reserve(worker->config.store, NULL) == VOR_OK;
        int has = vor_store_keep_reserve(worker->config.store, &err) == VOR_OK;

        if (has && !had)
            vor_log(VOR_LOG_INFO, "the disk has room again", VOR_TEXT("reserve", "made"));
        else if (!has && !worker->is_full)
            vor_log(VOR_LOG_WARN, "no reserve on the disk", VOR_TEXT("error", err.message));
        worker->is_full = !has;
    }
    if (worker->has_failed)
        return;
    /* Well as long as no disk has failed and the store is ours; one that is away may come back. */
    status = vor_store_check(worker->config.store, &is_lost, &err);
    if (status != VOR_OK)
        worker->unreached = vor_clock_seconds();
    vor_metric_set(VOR_METRIC_STORAGE_UP, status == VOR_OK, VOR_LABELS("store"));
    if (!is_lost)
        status = vor_blobs_check(worker->config.blobs, &err);
    if (status == VOR_OK)
        return;
    worker->has_failed = 1;
    if (worker->config.failed != NULL)
        worker->config.failed(worker->config.failed_ctx, &err);
}

int vor_worker_wait_room(struct vor_worker *worker, struct vor_job *job, double seconds)
{
    static const struct timespec poll = {.tv_nsec = 50000000};
    double until = vor_clock_seconds() + seconds;

    /* A job must not take what the reserve is made of. Where none is asked for, it just tries. */
    while (vor_clock_seconds() < until ||
           vor_store_check_reserve(worker->config.store, NULL) != VOR_OK) {
        if (vor_job_asked(job) == VOR_CANCEL)
            return 0;
        (void)nanosleep(&poll, NULL);
    }
    return vor_job_asked(job) != VOR_CANCEL;
}

void vor_worker_trim_lost(struct vor_worker *worker, int64_t shift_ms)
{
    struct vor_lost_bounds bounds = {.bytes = worker->config.lost_bytes, .shift_ms = shift_ms};
    struct vor_error err;

    bounds.oldest_ms =
        vor_clock_wall_ms() - shift_ms - (int64_t)(worker->config.lost_seconds * 1000);
    if (vor_blobs_trim_lost(worker->config.blobs, &bounds, &err) != VOR_OK)
        vor_log(VOR_LOG_WARN, "the folder of lost files cannot be read",
                VOR_TEXT("error", err.message));
}
