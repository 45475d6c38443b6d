/* Start-up is recovery: whatever the last run left, however it ended, is put in order. */
#include "server/work/live.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A crash between the removal of a job's row and that of its bytes leaves those of as many jobs as
 * the worker removes at a time, which is 2, and each may have results in two formats; what a crash
 * of the machine brings back beyond that is set aside as well. More is a damaged table. */
enum { ORPHANS_OF_CRASH = 8 };

/* A look at strays may take so long: a part of the time between two looks of the sweeper. */
static const double portion_seconds = 0.25;

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

vor_status vor_worker_find_blobs(struct vor_worker *worker, struct vor_error *err)
{
    return vor_blobs_list(worker->config.blobs, note_blob, worker, err);
}

/* The output of an attempt that a blob is of, be it converted; NULL for none. */
static const struct vor_artefact_info *output_of(const struct vor_process_info *process,
                                                 uint32_t attempt, const char *blob)
{
    char converted[VOR_BLOB_NAME_MAX + 1];

    for (const struct vor_artefact_info *o = process->outputs; o->name != NULL; o++) {
        if (strcmp(o->name, blob) == 0 ||
            strcmp(vor_blob_of_output(o->name, attempt, converted), blob) == 0)
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
    struct vor_job_brief row;
    int found;

    if (vor_store_brief(worker->config.store, &blob->id, &row, &found, NULL) != VOR_OK)
        return 1;
    if (!found || row.expired)
        return 0;
    process = vor_process_find(row.process);
    if (!vor_job_status_over(row.status) || process == NULL)
        return 1;
    if (vor_blob_is_upload(blob->name))
        return row.kept > 0;
    output = output_of(process, row.attempt, blob->name);
    return row.status == VOR_JOB_SUCCESSFUL && output != NULL && !vor_output_in_row(output) &&
           (strcmp(blob->name, output->name) != 0 ||
            !vor_blob_is_superseded(worker->config.blobs, &blob->id, output->name, row.attempt));
}

/* A file may come before its row, at the most as long before it as an upload takes. The first
 * twelve digits of an identifier are its milliseconds since 1970. */
static int is_young(const struct vor_worker *worker, const struct vor_uuid *id)
{
    static const int64_t upload_ms = 3600 * 1000;
    char digits[13];

    if (worker->found.is_first)
        return 0;
    (void)snprintf(digits, sizeof digits, "%.8s%.4s", id->text, id->text + 9);
    return (int64_t)strtoll(digits, NULL, 16) > vor_clock_wall_ms() - upload_ms;
}

/* A result whose job has no row at all; who removes a job removes its row first. */
static int is_orphan(struct vor_worker *worker, const struct vor_found_blob *blob)
{
    struct vor_job_brief row;
    uint64_t size;
    int found;

    if (strncmp(blob->name, "input", 5) == 0 || vor_blob_is_upload(blob->name) ||
        vor_store_brief(worker->config.store, &blob->id, &row, &found, NULL) != VOR_OK || found)
        return 0;
    return vor_blob_get(worker->config.blobs, &blob->id, blob->name, NULL, &size, &found, NULL) ==
               VOR_OK &&
           found;
}

/* Dropped, or set aside when the table of jobs has lost rows. */
static int put_away(struct vor_worker *worker, const struct vor_found_blob *blob, int is_lost)
{
    struct vor_error err;

    if (!is_lost) {
        vor_drop_file(worker->config.blobs, &blob->id, blob->name);
        return 1;
    }
    if (vor_blob_set_aside(worker->config.blobs, &blob->id, blob->name, &err) == VOR_OK)
        return 1;
    vor_log(VOR_LOG_WARN, "files not moved to the folder lost", VOR_TEXT("job", blob->id.text),
            VOR_TEXT("error", err.message));
    return 0;
}

/* --- uploads that a crash of the machine took --------------------------------------------------
 */

/* Jobs whose uploads are not there, or not whole. */
struct missing {
    struct vor_worker *worker;
    struct vor_evicted job[16];
    size_t count, seen;
    int64_t seq; /* of the row seen last */
};

static int note_missing(void *ctx, const struct vor_job_view *row)
{
    struct missing *missing = ctx;
    const struct vor_artefact_info *input = row->spec.process->inputs;
    vor_status status = row->request_lost ? VOR_E_PARAM : VOR_OK; /* its inputs are not known */
    uint64_t bytes = 0, size;
    int found;

    missing->seen++;
    missing->seq = row->seq;
    for (; input->name != NULL && status == VOR_OK; input++) {
        char blob[VOR_BLOB_NAME_MAX + 1];

        status = vor_blob_get(missing->worker->config.blobs, &row->id,
                              vor_blob_of_upload(input->name, blob), NULL, &size, &found, NULL);
        bytes += size;
    }
    if (status == VOR_OK && bytes != row->kept) {
        struct vor_evicted *one = &missing->job[missing->count++];

        one->id = row->id;
        memcpy(one->process, row->process, sizeof one->process);
    }
    return missing->count < sizeof missing->job / sizeof missing->job[0];
}

/* A kept upload waits for no disk, so that of the last ones before a crash of the machine there may
 * be the row alone, or a part of the bytes: then there is nothing to promise. */
void vor_worker_forget_missing(struct vor_worker *worker)
{
    struct vor_job_filter filter = {.is_kept = 1, .limit = 1000};
    struct missing missing = {.worker = worker};
    struct vor_error err;

    do {
        missing.count = missing.seen = 0;
        if (vor_store_list(worker->config.store, &filter, note_missing, &missing, &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "the kept uploads cannot be listed",
                    VOR_TEXT("error", err.message));
        for (size_t i = 0; i < missing.count; i++) {
            const struct vor_evicted *job = &missing.job[i];

            if (vor_store_forget_uploads(worker->config.store, &job->id, &err) != VOR_OK)
                continue; /* the next start finds it */
            vor_worker_drop_all(worker, &job->id, job->process, 0, VOR_HAS_UPLOADS);
            vor_log(VOR_LOG_WARN, "kept upload missing", VOR_TEXT("job", job->id.text));
        }
        filter.before_seq = missing.seq;
    } while (missing.seen > 0 && !vor_worker_pause(worker, 0));
}

static void drop_if_stray(struct vor_worker *worker, const struct vor_found_blob *blob, int is_lost)
{
    struct vor_found *found = &worker->found;
    uint64_t size = 0;
    int is_there;

    if (is_young(worker, &blob->id) || is_needed(worker, blob))
        return;
    if (vor_blob_get(worker->config.blobs, &blob->id, blob->name, NULL, &size, &is_there, NULL) !=
        VOR_OK)
        size = 0;
    if (!put_away(worker, blob, is_lost))
        return;
    found->bytes += size;
    found->files++;
}

static int may_go_on(struct vor_worker *worker, double until)
{
    return vor_clock_seconds() < until && !vor_worker_pause(worker, 0);
}

void vor_worker_drop_strays(struct vor_worker *worker)
{
    struct vor_found *found = &worker->found;
    double until = vor_clock_seconds() + portion_seconds;
    int is_lost;

    for (; found->counted < found->count && may_go_on(worker, until); found->counted++)
        found->orphans += (size_t)is_orphan(worker, &found->blobs[found->counted]);
    if (found->counted < found->count)
        return;
    is_lost = vor_store_is_damaged(worker->config.store) || found->orphans > ORPHANS_OF_CRASH;
    for (; found->looked < found->count && may_go_on(worker, until); found->looked++)
        drop_if_stray(worker, &found->blobs[found->looked], is_lost);
    if (found->looked < found->count)
        return;
    if (found->files > 0 && is_lost)
        vor_log(VOR_LOG_WARN,
                "JOBS ARE MISSING FROM THE DATABASE: their files are moved to the folder lost in "
                "--blobs, for --lost-ttl and up to --lost-bytes",
                VOR_COUNT("files", found->files), VOR_COUNT("bytes", found->bytes));
    else if (found->files > 0)
        vor_log(VOR_LOG_INFO, "strays removed", VOR_COUNT("files", found->files));
    vor_found_free(found);
}

vor_status vor_worker_sweep(struct vor_worker *worker, struct vor_error *err)
{
    vor_status status = vor_worker_evict(worker, VOR_EVICT_EXPIRED, err);

    vor_worker_keep_quota(worker, VOR_EVICT_UPLOADS);
    vor_worker_keep_quota(worker, VOR_EVICT_RESULTS);
    vor_worker_trim_lost(worker, 0);
    return status;
}

/* Rows of a former life, and what waits. */
static vor_status recover_rows(struct vor_worker *worker, struct vor_error *err)
{
    struct vor_waiting waiting;
    uint64_t requeued = 0;
    vor_status status = VOR_OK;

    /* What another daemon runs is its own until its lease ends: later (mirror.c). */
    if (!vor_store_is_shared(worker->config.store))
        status = vor_store_reap(worker->config.store, worker->owner.text, 1, vor_clock_wall_ms(),
                                &requeued, err);
    pthread_mutex_lock(&worker->claim); /* nothing that waits is dismissed meanwhile */
    if (status == VOR_OK)
        status = vor_store_waiting(worker->config.store, &waiting, err);
    if (status == VOR_OK)
        vor_capacity_begin(worker, &waiting);
    pthread_mutex_unlock(&worker->claim);
    if (status != VOR_OK)
        return status;
    vor_metric_add(VOR_METRIC_JOBS_AGAIN, (double)requeued, VOR_LABELS("restart"));
    vor_log(VOR_LOG_INFO, "recovered", VOR_COUNT("waiting", waiting.jobs),
            VOR_COUNT("requeued", requeued));
    return VOR_OK;
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
    worker->found.is_first = !vor_store_is_shared(worker->config.store);
    return status == VOR_OK ? vor_worker_find_blobs(worker, err) : status;
}

void vor_worker_recover_late(struct vor_worker *worker)
{
    struct vor_error err;

    if (!atomic_load(&worker->is_late))
        return;
    if (recover_rows(worker, &err) == VOR_OK) {
        atomic_store(&worker->is_late, 0);
        vor_worker_news(worker);
    } else if (!vor_error_storage_full(&err)) {
        vor_log(VOR_LOG_ERROR, "jobs are not recovered", VOR_TEXT("error", err.message));
    }
}
