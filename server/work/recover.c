/* Start-up is recovery: whatever the last run left, however it ended, is put in order. */
#include "server/work/recover.h"

#include "server/base/clock.h"
#include "server/base/log.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { BATCH = 256 };

struct batch {
    struct vor_uuid ids[BATCH];
    size_t count;
    int64_t before_seq;
};

static int take_id(void *ctx, const struct vor_job_view *row)
{
    struct batch *batch = ctx;

    batch->ids[batch->count++] = row->id;
    batch->before_seq = row->seq;
    return 1;
}

static int64_t expiry(const struct vor_worker *worker, int64_t now)
{
    return now + (int64_t)(worker->config.ttl_seconds * 1000);
}

/* Why a job cannot be run again; VOR_OK when it can. */
static vor_status check_row(struct vor_worker *worker, const struct vor_job_view *row,
                            struct vor_error *why)
{
    uint64_t size;
    int fd, found;
    vor_status status =
        vor_blob_get(worker->config.blobs, &row->id, VOR_BLOB_INPUT, &fd, &size, &found, why);

    if (fd >= 0)
        close(fd);
    if (status != VOR_OK)
        return status;
    if (!found)
        return vor_fail(why, VOR_E_INTERNAL, "the job's input was lost with the last run");
    if (vor_spec_check(&row->spec, NULL) != VOR_OK)
        return vor_fail(why, VOR_E_INTERNAL, "the job's request cannot be read by this version");
    return VOR_OK;
}

static vor_status fail_row(struct vor_worker *worker, struct vor_job_view *row,
                           const struct vor_error *why, struct vor_error *err)
{
    int changed;

    row->status = VOR_JOB_FAILED;
    row->problem = *why;
    row->finished = vor_clock_wall_ms();
    row->expires = expiry(worker, row->finished);
    (void)snprintf(row->message, sizeof row->message, "%.*s", (int)sizeof row->message - 1,
                   why->message);
    vor_log(VOR_LOG_WARN, "job lost", VOR_TEXT("job", row->id.text),
            VOR_TEXT("error", why->message));
    return vor_store_finish(worker->config.store, row, 0, NULL, &changed, err);
}

static vor_status requeue(struct vor_worker *worker, const struct vor_job_view *row,
                          struct vor_error *err)
{
    struct vor_job *job = vor_job_create(row);
    vor_status status;

    if (job == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a job");
    status = vor_worker_remember(worker, job, err);
    if (status == VOR_OK)
        status = vor_queue_restore(worker->queue, job, row->seq, err);
    vor_job_release(job);
    return status;
}

static vor_status recover_one(struct vor_worker *worker, const struct vor_uuid *id,
                              struct vor_error *err)
{
    struct vor_job_view row;
    struct vor_error why;
    vor_status status;
    int found;

    status = vor_store_get(worker->config.store, id, &row, &found, err);
    if (status != VOR_OK || !found)
        return status;
    if (check_row(worker, &row, &why) != VOR_OK)
        return fail_row(worker, &row, &why, err);
    return requeue(worker, &row, err);
}

/* Fills the queue with the accepted jobs. */
static vor_status recover_queue(struct vor_worker *worker, struct vor_error *err)
{
    struct batch batch = {.before_seq = 0};
    vor_status status = VOR_OK;

    do {
        struct vor_job_filter filter = {
            .statuses = 1u << VOR_JOB_ACCEPTED, .before_seq = batch.before_seq, .limit = BATCH};

        batch.count = 0;
        status = vor_store_list(worker->config.store, &filter, take_id, &batch, err);
        for (size_t i = 0; i < batch.count && status == VOR_OK; i++)
            status = recover_one(worker, &batch.ids[i], err);
    } while (status == VOR_OK && batch.count == BATCH);
    return status;
}

/* A blob is kept when its row needs it, or when that cannot be found out. */
static int is_needed(void *ctx, const struct vor_uuid *id, const char *name)
{
    struct vor_worker *worker = ctx;
    struct vor_job_view row;
    int found;

    if (vor_store_get(worker->config.store, id, &row, &found, NULL) != VOR_OK)
        return 1;
    if (!found || row.expired)
        return 0;
    return strcmp(name, VOR_BLOB_INPUT) == 0 ? row.status == VOR_JOB_ACCEPTED
                                             : row.status == VOR_JOB_SUCCESSFUL;
}

vor_status vor_worker_sweep(struct vor_worker *worker, struct vor_error *err)
{
    struct vor_uuid ids[BATCH];
    size_t count = BATCH, total = 0;
    vor_status status = VOR_OK;

    while (status == VOR_OK && count == BATCH) {
        status =
            vor_store_expire(worker->config.store, vor_clock_wall_ms(), ids, BATCH, &count, err);
        for (size_t i = 0; i < count; i++)
            vor_worker_drop(worker, &ids[i], VOR_BLOB_CLOUD);
        total += count;
    }
    if (total > 0)
        vor_log(VOR_LOG_INFO, "results expired", VOR_COUNT("jobs", total));
    return status;
}

vor_status vor_worker_recover(struct vor_worker *worker, struct vor_error *err)
{
    int64_t now = vor_clock_wall_ms();
    struct vor_recovered recovered = {0};
    size_t dropped = 0;
    vor_status status = vor_store_recover(worker->config.store, worker->config.crashes_max, now,
                                          expiry(worker, now), &recovered, err);

    if (status == VOR_OK)
        status = vor_worker_sweep(worker, err);
    if (status == VOR_OK)
        status = recover_queue(worker, err);
    if (status == VOR_OK)
        status = vor_blobs_sweep(worker->config.blobs, is_needed, worker, &dropped, err);
    if (status == VOR_OK)
        vor_log(VOR_LOG_INFO, "recovered", VOR_COUNT("waiting", vor_queue_depth(worker->queue)),
                VOR_COUNT("requeued", recovered.requeued), VOR_COUNT("failed", recovered.failed),
                VOR_COUNT("files_removed", dropped));
    return status;
}
