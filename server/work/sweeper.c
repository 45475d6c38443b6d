/* What the sweeper's thread does, and the start before it: whatever the last life of the daemon
 * left, however it ended, is put in order. Jobs come first, before anybody is answered; files are
 * tidied up later. Then, over and over: what is due expires, what no job needs goes, and disks and
 * the clock are looked at. */
#include "server/work/active_jobs.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* --- the clock --------------------------------------------------------------------------------
 *
 * When results expire, whatever is done to the wall clock. Rows say it in wall time, which jumps.
 *
 * While the daemon lives it knows how much time has passed: when the wall clock moves by more than
 * that, the expiry of every row is moved along, so that each keeps the time that it had left.
 *
 * A start knows only the newest time in the store. If the clock is an hour ahead of that, the
 * daemon was down that long, or the clock is wrong; if it is behind, it is wrong. Then nothing
 * expires, and nothing is moved, until the clock fits, or an hour has passed and it is believed. */

/* Milliseconds. A clock that is corrected in small steps, or a thread that waits for its core, is
 * no jump; a daemon that was down for less than an hour is common, and an hour more of a result
 * that has expired harms nobody. */
static const int64_t jump_ms = 30000, unsure_ms = 3600000;

/* At the start, before the first row is changed. */
static vor_status begin_expiry_clock(struct vor_job_service *service, struct vor_error *err)
{
    struct vor_expiry_clock *expiry_clock = &service->expiry_clock;
    int64_t ahead;
    vor_status status;

    if (vor_store_is_shared(service->config.store)) /* whose clock it goes by */
        return VOR_OK;
    status = vor_store_newest(service->config.store, &expiry_clock->newest, err);
    if (status != VOR_OK)
        return status;
    expiry_clock->wall = vor_clock_wall_ms();
    expiry_clock->steady = expiry_clock->began = vor_clock_boot_ms();
    ahead = expiry_clock->wall - expiry_clock->newest;
    expiry_clock->unsure = expiry_clock->newest > 0 && (ahead > unsure_ms || ahead < -jump_ms);
    if (expiry_clock->unsure)
        vor_log(VOR_LOG_WARN,
                "the clock does not agree with the times of the stored jobs: no job expires "
                "for an hour, or until the clock agrees",
                VOR_REAL("ahead_s", (double)ahead / 1000));
    return VOR_OK;
}

/* Looks for a jump and moves what it would expire. True when rows may expire now. */
static int look_at_clock(struct vor_job_service *service)
{
    struct vor_expiry_clock *expiry_clock = &service->expiry_clock;
    int64_t wall = vor_clock_wall_ms(), steady = vor_clock_boot_ms();
    int64_t jump = wall - expiry_clock->wall - (steady - expiry_clock->steady);
    int64_t passed = steady - expiry_clock->began, ahead = wall - expiry_clock->newest - passed;
    struct vor_error err;

    if (vor_store_is_shared(service->config.store))
        return 1;
    if (expiry_clock->unsure) { /* until it fits, or an hour has passed */
        expiry_clock->unsure = passed <= unsure_ms && (ahead > unsure_ms || ahead < -jump_ms);
    } else if (jump > jump_ms || jump < -jump_ms) {
        if (vor_store_shift(service->config.store, jump, &err) != VOR_OK) {
            vor_log(VOR_LOG_ERROR, "the clock jumped, and expiry times could not be adjusted",
                    VOR_TEXT("error", err.message));
            return 0;
        }
        vor_log(VOR_LOG_WARN, "the clock jumped: expiry times are adjusted",
                VOR_REAL("by_s", (double)jump / 1000));
    }
    expiry_clock->wall = wall;
    expiry_clock->steady = steady;
    return !expiry_clock->unsure;
}
/* --- disks ------------------------------------------------------------------------------------ */

/* What may take long takes so long of the time between two looks of the sweeper. */
static const double portion_seconds = 0.25;

vor_status vor_job_service_ready(struct vor_job_service *service, struct vor_error *err)
{
    struct vor_error why;
    const char *part = "--store";
    int is_lost;
    vor_status status = vor_store_check(service->config.store, &is_lost, &why);

    if (status == VOR_OK && atomic_load(&service->is_late))
        status = vor_fail_errno(&why, ENOSPC, "recovering earlier jobs");
    VOR_THEN(status, vor_store_check_reserve(service->config.store, &why));
    if (status == VOR_OK) {
        part = "--blobs";
        status = vor_blobs_reach(service->config.blobs, &why);
    }
    VOR_THEN(status, vor_blobs_room(service->config.blobs, 1, &why));
    if (status == VOR_OK)
        return VOR_OK;
    (void)vor_fail(err, status, "%s: %.900s", part, why.message);
    err->got = why.got;
    return status;
}

/* Rows that went have left room in the file of the store. True when there is more of it. */
static int give_room_back(struct vor_job_service *service)
{
    double until = vor_clock_seconds() + portion_seconds;
    int64_t left = 0;

    while (vor_store_give_back(service->config.store, &left, NULL) == VOR_OK && left > 0 &&
           vor_clock_seconds() < until)
        continue;
    return left > 0;
}

/* Makes the reserve again once there is room, and tells config.failed, once, that a disk has
 * failed. */
static void look_at_disk(struct vor_job_service *service)
{
    struct vor_error err;
    int is_away = vor_blobs_reach(service->config.blobs, &err) != VOR_OK, is_lost = 0;
    vor_status status;

    /* While the blobs are away no job begins. */
    vor_metric_set(VOR_METRIC_STORAGE_UP, !is_away, VOR_LABELS("blobs"));
    if (is_away && !service->is_away)
        vor_log(VOR_LOG_ERROR, "files cannot be read or written: no job starts",
                VOR_TEXT("error", err.message));
    if (!is_away && service->is_away) {
        vor_log(VOR_LOG_INFO, "files can be read and written again");
        vor_job_service_news(service);
    }
    service->is_away = is_away;
    if (!atomic_load(&service->is_late)) { /* recovery needs the room more than the reserve does */
        int had = vor_store_check_reserve(service->config.store, NULL) == VOR_OK;
        int has = vor_store_keep_reserve(service->config.store, &err) == VOR_OK;

        if (has && !had)
            vor_log(VOR_LOG_INFO, "the disk has room again", VOR_TEXT("reserve", "made"));
        else if (!has && !service->is_full)
            vor_log(VOR_LOG_WARN, "no reserve on the disk", VOR_TEXT("error", err.message));
        service->is_full = !has;
    }
    if (vor_blobs_lack_room(service->config.blobs) || service->gives_back || service->is_full ||
        atomic_load(&service->is_late))
        service->gives_back = give_room_back(service);
    if (service->has_failed)
        return;
    /* Well as long as no disk has failed and the store is ours; one that is away may come back. */
    status = vor_store_check(service->config.store, &is_lost, &err);
    if (status != VOR_OK)
        service->unreached = vor_clock_seconds();
    vor_metric_set(VOR_METRIC_STORAGE_UP, status == VOR_OK, VOR_LABELS("store"));
    if (!is_lost)
        status = vor_blobs_check(service->config.blobs, &err);
    if (status == VOR_OK)
        return;
    service->has_failed = 1;
    if (service->config.failed != NULL)
        service->config.failed(service->config.failed_ctx, &err);
}

/* A crash between the removal of a job's row and that of its bytes leaves those of as many jobs as
 * the job service removes at a time, which is 2, and each may have results in two formats. More is
 * a damaged table, or another one: then files stay as long as results do. */
enum { ORPHANS_OF_CRASH = 8 };

/* --- the blobs -------------------------------------------------------------------------------- */

/* The output of an attempt that a blob is of, be it converted; NULL for none. */
static const struct vor_artefact_info *output_of(const struct vor_process_info *process,
                                                 uint32_t attempt, const char *blob)
{
    char converted[VOR_BLOB_NAME_MAX + 1];

    for (const struct vor_artefact_info *o = process->outputs; o->name != NULL; o++) {
        if (strcmp(vor_blob_of_output(o->name, attempt, converted), blob) == 0)
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
static int is_needed(struct vor_job_service *service, const struct vor_blob_entry *blob)
{
    const struct vor_process_info *process;
    const struct vor_artefact_info *output;
    struct vor_job_brief row;
    int found;

    if (vor_store_brief(service->config.store, &blob->id, &row, &found, NULL) != VOR_OK)
        return 1;
    if (!found || row.expired)
        return 0;
    process = vor_process_find(row.process);
    if (!vor_job_status_over(row.status) || process == NULL)
        return 1;
    if (vor_blob_is_upload(blob->name))
        return row.kept > 0;
    output = output_of(process, row.attempt, blob->name);
    return row.status == VOR_JOB_SUCCESSFUL && output != NULL && !vor_output_in_row(output);
}

/* The first twelve digits of an identifier are its milliseconds since 1970. */
static int is_younger(const struct vor_uuid *id, double seconds)
{
    char digits[13];

    (void)snprintf(digits, sizeof digits, "%.8s%.4s", id->text, id->text + 9);
    return (double)strtoll(digits, NULL, 16) > (double)vor_clock_wall_ms() - seconds * 1000;
}

/* A result whose job has no row at all; who removes a job removes its row first. */
static int is_orphan(struct vor_job_service *service, const struct vor_blob_entry *blob)
{
    struct vor_job_brief row;
    uint64_t size;
    int found;

    if (strncmp(blob->name, "input", 5) == 0 || vor_blob_is_upload(blob->name) ||
        vor_store_brief(service->config.store, &blob->id, &row, &found, NULL) != VOR_OK || found)
        return 0;
    return vor_blob_get(service->config.blobs, &blob->id, blob->name, NULL, &size, &found, NULL) ==
               VOR_OK &&
           found;
}

/* --- uploads that a crash of the machine took --------------------------------------------------
 */

/* Jobs with kept uploads, some at a time. */
struct keeping {
    struct vor_keeping job[16];
    size_t count;
};

static int note_keeping(void *ctx, const struct vor_keeping *job)
{
    struct keeping *keeping = ctx;

    keeping->job[keeping->count++] = *job;
    return keeping->count < sizeof keeping->job / sizeof keeping->job[0];
}

/* Whether uploads of a job are not there, or not whole. */
static int is_missing(struct vor_job_service *service, const struct vor_keeping *job)
{
    const struct vor_process_info *process = vor_process_find(job->process);
    vor_status status = process != NULL ? VOR_OK : VOR_E_PARAM; /* its inputs are not known */
    uint64_t bytes = 0, size;
    int found;

    for (unsigned i = 0; status == VOR_OK && process->inputs[i].name != NULL; i++) {
        char blob[VOR_BLOB_NAME_MAX + 1];

        status = vor_blob_get(service->config.blobs, &job->id,
                              vor_blob_of_upload(process->inputs[i].name, blob), NULL, &size,
                              &found, NULL);
        bytes += size;
    }
    return status == VOR_OK && bytes != job->kept;
}

/* A kept upload waits for no disk, so that of the last ones before a crash of the machine there may
 * be the row alone, or a part of the bytes: then there is nothing to promise. Blobs are asked
 * between two lists, as small ones are in the store as well. */
static void forget_missing(struct vor_job_service *service)
{
    struct keeping keeping;
    int64_t seq = INT64_MAX;
    struct vor_error err;

    do {
        keeping.count = 0;
        if (vor_store_keeping(service->config.store, seq, note_keeping, &keeping, &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "the kept uploads cannot be listed",
                    VOR_TEXT("error", err.message));
        for (size_t i = 0; i < keeping.count; i++) {
            const struct vor_keeping *job = &keeping.job[i];

            seq = job->seq;
            if (!is_missing(service, job) ||
                vor_store_forget_uploads(service->config.store, &job->id, &err) != VOR_OK)
                continue; /* the next start finds it */
            vor_job_service_drop_all(service, &job->id, job->process, 0, VOR_HAS_UPLOADS);
            vor_log(VOR_LOG_WARN, "kept upload missing", VOR_TEXT("job", job->id.text));
        }
    } while (keeping.count > 0 && !vor_job_service_pause(service, 0));
}

static void drop_if_stray(struct vor_job_service *service, const struct vor_blob_entry *blob,
                          int is_lost)
{
    static const double upload_seconds = 3600; /* as long before its row a file may come */
    struct vor_found *found = &service->found;
    uint64_t size = 0;
    int is_there;

    if ((!found->is_first && is_younger(&blob->id, upload_seconds)) || is_needed(service, blob))
        return;
    found->files++;
    if (!is_lost || !is_younger(&blob->id, service->config.ttl_seconds)) {
        vor_drop_file(service->config.blobs, &blob->id, blob->name);
        return;
    }
    found->kept++;
    if (vor_blob_get(service->config.blobs, &blob->id, blob->name, NULL, &size, &is_there, NULL) ==
        VOR_OK)
        found->bytes += size;
}

static int may_go_on(struct vor_job_service *service, double until)
{
    return vor_clock_seconds() < until && !vor_job_service_pause(service, 0);
}

/* Drops the blobs that were found and that no row needs, as far as it comes in a quarter of a
 * second: the next call goes on, while found.list.count is not 0. Where more results have no row
 * than a crash leaves, the younger ones stay, with a warning. Ends early when the daemon goes down;
 * the next start does the rest. */
static void drop_strays(struct vor_job_service *service)
{
    struct vor_found *found = &service->found;
    double until = vor_clock_seconds() + portion_seconds;
    int is_lost;

    for (; found->counted < found->list.count && may_go_on(service, until); found->counted++) {
        const struct vor_blob_entry *blob = &found->list.entry[found->counted];

        if (is_needed(service, blob))
            continue;
        found->orphans += (size_t)is_orphan(service, blob);
        found->list.entry[found->strays++] = *blob;
    }
    if (found->counted < found->list.count)
        return;
    is_lost = found->orphans > ORPHANS_OF_CRASH;
    for (; found->looked < found->strays && may_go_on(service, until); found->looked++)
        drop_if_stray(service, &found->list.entry[found->looked], is_lost);
    if (found->looked < found->strays)
        return;
    if (found->kept > 0)
        vor_log(VOR_LOG_WARN,
                "JOBS ARE MISSING FROM THE DATABASE: their files stay in --blobs until they are as "
                "old as --result-ttl",
                VOR_COUNT("files", found->kept), VOR_COUNT("bytes", found->bytes));
    if (found->files > found->kept)
        vor_log(VOR_LOG_INFO, "strays removed", VOR_COUNT("files", found->files - found->kept));
    vor_found_free(found);
}

/* What fails is tried again, with the next sweep at the latest. */
static void keep_quotas(struct vor_job_service *service)
{
    static const enum vor_evict quotas[] = {VOR_EVICT_UPLOADS, VOR_EVICT_RESULTS};
    struct vor_error err;

    for (size_t k = 0; k < sizeof quotas / sizeof *quotas; k++)
        if (vor_job_service_evict(service, quotas[k], &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "uploads or results not deleted", VOR_TEXT("error", err.message));
}

vor_status vor_job_service_sweep(struct vor_job_service *service, struct vor_error *err)
{
    vor_status status = vor_job_service_evict(service, VOR_EVICT_EXPIRED, err);

    keep_quotas(service);
    return status;
}

/* Rows of a former life, and what waits. */
static vor_status recover_rows(struct vor_job_service *service, struct vor_error *err)
{
    struct vor_waiting waiting;
    uint64_t requeued = 0;
    vor_status status = VOR_OK;

    /* What another daemon runs is its own until its lease ends: later (mirror.c). */
    if (!vor_store_is_shared(service->config.store))
        status = vor_store_reap(service->config.store, service->owner.text, 1, vor_clock_wall_ms(),
                                &requeued, err);
    pthread_mutex_lock(&service->claim); /* nothing that waits is dismissed meanwhile */
    VOR_THEN(status, vor_store_waiting(service->config.store, &waiting, err));
    if (status == VOR_OK)
        vor_capacity_begin(service, &waiting);
    pthread_mutex_unlock(&service->claim);
    if (status != VOR_OK)
        return status;
    vor_metric_add(VOR_METRIC_JOBS_AGAIN, (double)requeued, VOR_LABELS("restart"));
    vor_log(VOR_LOG_INFO, "recovered", VOR_COUNT("waiting", waiting.jobs),
            VOR_COUNT("requeued", requeued));
    return VOR_OK;
}

vor_status vor_job_service_recover(struct vor_job_service *service, struct vor_error *err)
{
    vor_status status = begin_expiry_clock(service, err);

    VOR_THEN(status, recover_rows(service, err));
    if (status == VOR_E_IO && vor_error_storage_full(err)) {
        vor_log(VOR_LOG_ERROR,
                "the disk is full: running and waiting jobs continue once there is room",
                VOR_TEXT("error", err->message));
        atomic_store(&service->is_late, 1);
        status = VOR_OK;
    }
    service->found.is_first = !vor_store_is_shared(service->config.store);
    VOR_THEN(status, vor_blobs_list(service->config.blobs, &service->found.list, err));
    return status;
}

/* Recovers if there is room by now. */
static void recover_late(struct vor_job_service *service)
{
    struct vor_error err;

    if (!atomic_load(&service->is_late))
        return;
    if (recover_rows(service, &err) == VOR_OK) {
        atomic_store(&service->is_late, 0);
        vor_job_service_news(service);
    } else if (!vor_error_storage_full(&err)) {
        vor_log(VOR_LOG_ERROR, "jobs are not recovered", VOR_TEXT("error", err.message));
    }
}

/* --- the thread ------------------------------------------------------------------------------- */

/* Seconds: between two sweeps; between two looks for files that no job needs; between two looks at
 * disk and clock, as a restart takes as long; and between two looks at what other daemons do,
 * however often they tell. */
static const double sweep_seconds = 60, tidy_seconds = 6 * 3600, look_seconds = 0.5,
                    heard_seconds = 0.1;

/* Ends the daemon, as the signal does, once it has had no job for so long as it may. */
static void look_idle(struct vor_job_service *service)
{
    double now = vor_clock_seconds(), most = service->config.idle_seconds;
    int is_busy;

    pthread_mutex_lock(&service->mutex);
    is_busy = service->capacity.running > 0 || service->capacity.waiting > 0;
    pthread_mutex_unlock(&service->mutex);
    if (is_busy)
        service->busy = now;
    if (most == 0 || now - service->busy < most)
        return;
    vor_log(VOR_LOG_INFO, "no job for as long as --exit-when-idle", VOR_REAL("seconds", most));
    service->busy = now;
    (void)kill(getpid(), SIGTERM);
}

/* Until the next look, follows others whenever they say that there is something. True when the
 * daemon goes down. */
static int pause_and_hear(struct vor_job_service *service)
{
    double until = vor_clock_seconds() + look_seconds;
    int has_news, is_down = 0;

    while (!is_down && vor_clock_seconds() < until) {
        (void)vor_job_service_pause(service, heard_seconds);
        pthread_mutex_lock(&service->mutex);
        while (!service->draining && !service->has_news &&
               !vor_clock_wait(&service->changed, &service->mutex, until))
            continue;
        has_news = service->has_news;
        service->has_news = 0;
        is_down = service->draining;
        pthread_mutex_unlock(&service->mutex);
        if (!has_news || is_down)
            continue;
        vor_metric_add(VOR_METRIC_STORE_HINTS, 1, VOR_LABELS("received"));
        vor_job_service_follow_others(service);
    }
    return is_down;
}

void *vor_job_service_sweep_on(void *arg)
{
    struct vor_job_service *service = arg;
    double swept = vor_clock_seconds() - sweep_seconds, tidied = vor_clock_seconds();
    double tidy = service->config.tidy_seconds > 0 ? service->config.tidy_seconds : tidy_seconds;
    struct vor_error err;

    service->busy = service->unreached = vor_clock_seconds();
    drop_strays(service);
    forget_missing(service);
    do {
        double now = vor_clock_seconds();

        if (!service->keeper_started)
            vor_job_service_renew(service);
        vor_job_service_follow_others(service);
        recover_late(service);
        look_at_disk(service);
        look_idle(service);
        drop_strays(service);
        /* Here, and not where uploads and results are added: a submit, or the end of a job, would
         * wait for one more sync. */
        if (atomic_exchange(&service->has_grown, 0))
            keep_quotas(service);
        if (!look_at_clock(service))
            continue;
        if (now - tidied >= tidy && service->found.list.count == 0) {
            tidied = now;
            if (vor_blobs_list(service->config.blobs, &service->found.list, &err) != VOR_OK)
                vor_log(VOR_LOG_WARN, "files are not listed", VOR_TEXT("error", err.message));
        }
        if (now - swept < sweep_seconds)
            continue;
        swept = now;
        if (vor_job_service_sweep(service, &err) != VOR_OK)
            vor_log(VOR_LOG_ERROR, "sweeping failed", VOR_TEXT("error", err.message));
    } while (!pause_and_hear(service));
    return NULL;
}
