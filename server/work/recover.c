/* Start-up is recovery: whatever the last run left, however it ended, is put in order. */
#include "server/work/recover.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"
#include "server/work/calendar.h"
#include "server/work/room.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A crash between the removal of a job's row and that of its bytes leaves those of as many jobs as
 * the worker removes at a time, which is 2, and each may have results in two formats; what a crash
 * of the machine brings back beyond that is set aside as well. More is a damaged table. */
enum { ORPHANS_OF_CRASH = 8 };

static int64_t expiry(const struct vor_worker *worker, int64_t now)
{
    return now + (int64_t)(worker->config.ttl_seconds * 1000);
}

static vor_status check_input(struct vor_worker *worker, const struct vor_uuid *id,
                              const char *name, uint64_t *bytes, struct vor_error *why)
{
    char blob[VOR_BLOB_NAME_MAX + 1];
    uint64_t size;
    int found;
    vor_status status = vor_blob_get(worker->config.blobs, id, vor_blob_of_input(name, blob), NULL,
                                     &size, &found, why);

    *bytes += size;
    if (status == VOR_OK && !found)
        status =
            vor_fail(why, VOR_E_INTERNAL, "the job's input %s was lost with the last run", name);
    return status;
}

/* Why a job cannot be run again; VOR_OK when it can. */
static vor_status check_row(struct vor_worker *worker, const struct vor_job_view *row,
                            uint64_t *bytes, struct vor_error *why)
{
    const struct vor_artefact_info *inputs = row->spec.process->inputs;
    vor_status status = VOR_OK;

    for (unsigned i = 0; inputs[i].name != NULL && status == VOR_OK; i++)
        if ((row->inputs >> i & 1) != 0)
            status = check_input(worker, &row->id, inputs[i].name, bytes, why);
    if (status != VOR_OK)
        return status;
    if (row->request_lost || vor_spec_check(&row->spec, NULL) != VOR_OK ||
        vor_spec_check_inputs(&row->spec, row->inputs, NULL) != VOR_OK)
        return vor_fail(why, VOR_E_INTERNAL, "the job's request cannot be read by this version");
    return VOR_OK;
}

static vor_status fail_row(struct vor_worker *worker, struct vor_job_view *row,
                           const struct vor_error *why, struct vor_error *err)
{
    int changed;

    row->status = VOR_JOB_FAILED;
    row->problem = *why;
    row->finished = vor_job_now(row, vor_clock_wall_ms());
    row->expires = expiry(worker, row->finished);
    (void)snprintf(row->message, sizeof row->message, "%.*s", (int)sizeof row->message - 1,
                   why->message);
    vor_log(VOR_LOG_WARN, "job lost", VOR_OF_JOB(row), VOR_TEXT("error", why->message));
    return vor_store_finish(worker->config.store, row, 0, NULL, &changed, err);
}

static vor_status requeue(struct vor_worker *worker, const struct vor_job_view *row, uint64_t bytes,
                          struct vor_error *err)
{
    struct vor_job *job = vor_job_create(row);
    vor_status status;

    if (job == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a job");
    status = vor_worker_remember(worker, job, err);
    if (status == VOR_OK)
        (void)vor_worker_charge(worker, job, bytes, UINT64_MAX); /* all were accepted once */
    if (status == VOR_OK)
        status = vor_queue_restore(worker->queue, job, row->seq, err);
    vor_job_release(job);
    return status;
}

/* --- the queue -------------------------------------------------------------------------------- */

/* A job that cannot be run again, and why. */
struct lost {
    struct vor_job_view row;
    struct vor_error why;
    struct lost *next;
};

struct recovery {
    struct vor_worker *worker;
    struct lost *lost; /* to be told to the store once the list is read */
    vor_status status;
    struct vor_error *err;
};

static vor_status note_lost(struct recovery *recovery, const struct vor_job_view *row,
                            const struct vor_error *why)
{
    struct lost *lost = malloc(sizeof *lost);

    if (lost == NULL)
        return vor_fail(recovery->err, VOR_E_NOMEM, "a job");
    *lost = (struct lost){.row = *row, .why = *why, .next = recovery->lost};
    recovery->lost = lost;
    return VOR_OK;
}

/* A recovery that failed midway begins again, and leaves alone what it has put in line already. */
static int recover_one(void *ctx, const struct vor_job_view *row)
{
    struct recovery *recovery = ctx;
    struct vor_job *live = vor_worker_find(recovery->worker, &row->id);
    struct vor_error why;
    uint64_t bytes = 0;

    vor_job_release(live);
    if (live != NULL)
        return 1;
    if (check_row(recovery->worker, row, &bytes, &why) != VOR_OK)
        recovery->status = note_lost(recovery, row, &why);
    else
        recovery->status = requeue(recovery->worker, row, bytes, recovery->err);
    return recovery->status == VOR_OK;
}

static vor_status recover_queue(struct vor_worker *worker, struct vor_error *err)
{
    struct recovery recovery = {.worker = worker, .err = err};
    vor_status status = vor_store_waiting(worker->config.store, recover_one, &recovery, err);

    if (status == VOR_OK)
        status = recovery.status;
    while (recovery.lost != NULL) {
        struct lost *lost = recovery.lost;

        recovery.lost = lost->next;
        if (status == VOR_OK)
            status = fail_row(worker, &lost->row, &lost->why, err);
        if (status == VOR_E_IO && vor_error_storage_full(err))
            status = VOR_OK; /* it stays as it is until the next start */
        free(lost);
    }
    return status;
}

/* --- the blobs -------------------------------------------------------------------------------- */

static void note_blob(void *ctx, const struct vor_uuid *id, const char *name)
{
    struct vor_found *found = &((struct vor_worker *)ctx)->found;

    if (found->count == found->capacity) {
        size_t capacity = found->capacity > 0 ? 2 * found->capacity : 256;
        struct vor_found_blob *blobs = realloc(found->blobs, capacity * sizeof *blobs);

        if (blobs == NULL)
            return; /* it is looked at after the next start */
        found->blobs = blobs;
        found->capacity = capacity;
    }
    found->blobs[found->count].id = *id;
    (void)snprintf(found->blobs[found->count].name, sizeof found->blobs[0].name, "%s", name);
    found->count++;
}

/* The output that a blob is of, be it converted; NULL for none. */
static const struct vor_artefact_info *output_of(const struct vor_process_info *process,
                                                 const char *blob)
{
    char converted[VOR_BLOB_NAME_MAX + 1];

    for (const struct vor_artefact_info *o = process->outputs; o->name != NULL; o++) {
        if (strcmp(o->name, blob) == 0)
            return o;
        for (unsigned i = 0; o->kind == VOR_ARTEFACT_CLOUD && vor_format(i) != NULL; i++)
            if (strcmp(vor_blob_of_converted(o->name, vor_format(i)->name, converted), blob) == 0)
                return o;
    }
    return NULL;
}

/* A job that is not over needs all its blobs; it may be writing its outputs just now. A job that is
 * over needs only its outputs, if it was successful, and its uploads as long as its row counts
 * them. When the store cannot be read, or the process is not known, a blob counts as needed. */
static int is_needed(struct vor_worker *worker, const struct vor_found_blob *blob)
{
    const struct vor_process_info *process;
    const struct vor_artefact_info *output;
    struct vor_job_view row;
    int found;

    if (vor_store_get(worker->config.store, &blob->id, &row, &found, NULL) != VOR_OK)
        return 1;
    if (!found || row.expired)
        return 0;
    process = vor_process_find(row.process);
    if (!vor_job_status_over(row.status) || process == NULL)
        return 1;
    if (vor_blob_is_upload(blob->name))
        return row.kept > 0;
    output = output_of(process, blob->name);
    return row.status == VOR_JOB_SUCCESSFUL && output != NULL && !vor_output_in_row(output);
}

/* Results whose jobs have no row at all. */
static size_t count_orphans(struct vor_worker *worker)
{
    const struct vor_found *found = &worker->found;
    struct vor_job_view row;
    size_t orphans = 0;

    for (size_t i = 0; i < found->count; i++) {
        int is_input = strncmp(found->blobs[i].name, "input", 5) == 0 ||
                       vor_blob_is_upload(found->blobs[i].name);
        int has_row = 1;

        if (!is_input && vor_store_get(worker->config.store, &found->blobs[i].id, &row, &has_row,
                                       NULL) == VOR_OK)
            orphans += !has_row;
    }
    return orphans;
}

/* Dropped, or set aside when the table of jobs has lost rows. */
static int put_away(struct vor_worker *worker, const struct vor_found_blob *blob, int is_lost)
{
    struct vor_error err;

    if (!is_lost) {
        vor_worker_drop(worker, &blob->id, blob->name);
        return 1;
    }
    if (vor_blob_set_aside(worker->config.blobs, &blob->id, blob->name, &err) == VOR_OK)
        return 1;
    vor_log(VOR_LOG_WARN, "files not moved to the folder lost", VOR_TEXT("job", blob->id.text),
            VOR_TEXT("error", err.message));
    return 0;
}

static uint64_t size_of(struct vor_worker *worker, const struct vor_found_blob *blob)
{
    uint64_t size = 0;
    int found;

    if (vor_blob_get(worker->config.blobs, &blob->id, blob->name, NULL, &size, &found, NULL) !=
        VOR_OK)
        return 0;
    return size;
}

static void say_strays(int is_lost, size_t files, uint64_t bytes)
{
    if (files > 0 && is_lost)
        vor_log(VOR_LOG_WARN,
                "THE TABLE OF JOBS HAS LOST ROWS: files that belong to no job are moved to the "
                "folder lost of --blobs, for --lost-ttl and up to --lost-bytes",
                VOR_COUNT("files", files), VOR_COUNT("bytes", bytes));
    else if (files > 0)
        vor_log(VOR_LOG_INFO, "strays removed", VOR_COUNT("files", files));
}

void vor_worker_drop_strays(struct vor_worker *worker)
{
    struct vor_found *found = &worker->found;
    int is_lost =
        vor_store_is_damaged(worker->config.store) || count_orphans(worker) > ORPHANS_OF_CRASH;
    uint64_t bytes = 0;
    size_t files = 0;

    for (size_t i = 0; i < found->count && !vor_worker_pause(worker, 0); i++) {
        uint64_t size;

        if (is_needed(worker, &found->blobs[i]))
            continue;
        size = size_of(worker, &found->blobs[i]);
        if (!put_away(worker, &found->blobs[i], is_lost))
            continue;
        bytes += size;
        files++;
    }
    vor_found_free(found);
    say_strays(is_lost, files, bytes);
}

vor_status vor_worker_sweep(struct vor_worker *worker, struct vor_error *err)
{
    vor_status status = vor_worker_evict(worker, VOR_EVICT_EXPIRED, err);

    vor_worker_keep_quota(worker, VOR_EVICT_UPLOADS);
    vor_worker_keep_quota(worker, VOR_EVICT_RESULTS);
    vor_worker_trim_lost(worker, 0);
    return status;
}

/* Rows of a former life, and the queue. */
static vor_status recover_rows(struct vor_worker *worker, struct vor_error *err)
{
    uint64_t requeued = 0;
    vor_status status = VOR_OK;

    if (!worker->is_reset) /* once: what runs later runs in this life */
        status = vor_store_recover(worker->config.store, vor_clock_wall_ms(), &requeued, err);
    worker->is_reset = worker->is_reset || status == VOR_OK;
    if (status == VOR_OK)
        status = recover_queue(worker, err);
    vor_metric_add(VOR_METRIC_JOBS_AGAIN, (double)requeued, VOR_LABELS("restart"));
    if (status == VOR_OK)
        vor_log(VOR_LOG_INFO, "recovered", VOR_COUNT("waiting", vor_queue_depth(worker->queue)),
                VOR_COUNT("requeued", requeued));
    return status;
}

vor_status vor_worker_recover(struct vor_worker *worker, struct vor_error *err)
{
    vor_status status = vor_calendar_begin(worker, err);

    if (status == VOR_OK)
        status = recover_rows(worker, err);
    if (status == VOR_E_IO && vor_error_storage_full(err)) {
        vor_log(VOR_LOG_ERROR,
                "the disk is full: running and waiting jobs continue once there is room",
                VOR_TEXT("error", err->message));
        atomic_store(&worker->is_late, 1);
        status = VOR_OK;
    }
    return status == VOR_OK ? vor_blobs_list(worker->config.blobs, note_blob, worker, err) : status;
}

void vor_worker_recover_late(struct vor_worker *worker)
{
    struct vor_error err;

    if (!atomic_load(&worker->is_late))
        return;
    if (recover_rows(worker, &err) == VOR_OK) {
        vor_queue_look(worker->queue);
        atomic_store(&worker->is_late, 0);
    } else if (!vor_error_storage_full(&err)) {
        vor_log(VOR_LOG_ERROR, "jobs are not recovered", VOR_TEXT("error", err.message));
    }
}
