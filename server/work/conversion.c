/* The digest of a conversion's bytes and its origin stand behind them in the blob, so that the ETag
 * needs no pass over the file, and the origin no decoding. */
#include "server/work/conversion.h"

#include "proto/codec.h"
#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What stands behind the bytes in the blob; both with their NUL. */
struct trailer {
    char sha256[VOR_DIGEST_SIZE];
    char origin[VOR_ORIGIN_TEXT_SIZE]; /* "" in a format that takes none */
};

static const double failed_seconds = 5;

/* One that is on its way, or that failed in the last seconds. */
struct conversion {
    struct vor_conversions *service;
    struct vor_job_view row;
    unsigned output, format;
    struct vor_task task;
    struct vor_askers *waiting;
    double failed; /* when; 0 while it is on its way */
    struct vor_error error;
    struct conversion *next;
};

struct vor_conversions {
    struct vor_conversions_config config;
    pthread_mutex_t mutex; /* the list, and how conversions end */
    struct conversion *list;
};

vor_status vor_conversions_create(struct vor_conversions **out,
                                  const struct vor_conversions_config *config,
                                  struct vor_error *err)
{
    struct vor_conversions *conversions = calloc(1, sizeof *conversions);

    if (conversions == NULL)
        return vor_fail(err, VOR_E_NOMEM, "converting results");
    conversions->config = *config;
    pthread_mutex_init(&conversions->mutex, NULL);
    *out = conversions;
    return VOR_OK;
}

void vor_conversions_destroy(struct vor_conversions *conversions)
{
    if (conversions == NULL)
        return;
    while (conversions->list != NULL) {
        struct conversion *next = conversions->list->next;

        free(conversions->list);
        conversions->list = next;
    }
    pthread_mutex_destroy(&conversions->mutex);
    free(conversions);
}

/* --- the work --------------------------------------------------------------------------------- */

static const char *output_name(const struct conversion *conversion)
{
    return conversion->row.spec.process->outputs[conversion->output].name;
}

/* The spacing that the report tells; 0 where none does. */
static double spacing_of(const struct conversion *conversion)
{
    struct vor_json *json = NULL;
    char *report = NULL;
    double spacing = 0;

    if (vor_store_report(conversion->service->config.store, &conversion->row.id, &report, NULL) ==
            VOR_OK &&
        report != NULL && vor_json_parse(&json, report, strlen(report), NULL) == VOR_OK)
        (void)vor_json_get_number(vor_json_get(json, "spacing"), &spacing);
    vor_json_free(json);
    free(report);
    return spacing;
}

static vor_status convert_file(const struct conversion *conversion, int fd, uint64_t size,
                               struct vor_error *err)
{
    const struct vor_conversions_config *config = &conversion->service->config;
    const struct vor_codec_order order = {.op = VOR_CODEC_CONVERT,
                                          .size = size,
                                          .memory = config->memory,
                                          .most = UINT64_MAX,
                                          .limits = {.points = VOR_POINTS_MAX},
                                          .format = conversion->format,
                                          .spacing = spacing_of(conversion),
                                          .spec = conversion->row.spec};
    char name[VOR_BLOB_NAME_MAX + 1];
    struct trailer trailer = {.origin = ""};
    struct vor_blob_writer *writer;
    struct vor_codec_facts facts;
    struct vor_sink sink;
    vor_status status = vor_blob_create(config->blobs, &writer, err);

    if (status != VOR_OK)
        return status;
    sink = vor_blob_sink(writer);
    status = vor_blob_compare(fd, size, conversion->row.output[conversion->output].sha256,
                              output_name(conversion), err);
    VOR_THEN(status, vor_blob_promise(writer, 0, err));
    VOR_THEN(status, vor_codec_run(&facts, &config->place, &order, fd, &sink, err));
    if (status == VOR_E_IO)
        (void)vor_blob_failure(writer, err);
    if (status == VOR_OK) {
        vor_blob_sha256(writer, trailer.sha256);
        if (facts.has_origin)
            (void)vor_origin_text(facts.origin, trailer.origin);
        status = vor_blob_append(writer, &trailer, sizeof trailer, err);
    }
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        return status;
    }
    vor_blob_of_converted(output_name(conversion), vor_format(conversion->format)->name, name);
    return vor_blob_commit(writer, &conversion->row.id, name, err);
}

/* Removes the blob of a job that went while it was made; the next removal of the job finds it. */
static void drop_if_gone(const struct conversion *conversion)
{
    const struct vor_conversions_config *config = &conversion->service->config;
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_job_view now;
    enum vor_job_outcome outcome =
        vor_job_service_get(config->service, &conversion->row.id, NULL, &now, NULL);

    if (outcome == VOR_UNKNOWN || (outcome == VOR_DONE && now.expired))
        vor_drop_file(config->blobs, &conversion->row.id,
                      vor_blob_of_converted(output_name(conversion),
                                            vor_format(conversion->format)->name, name));
}

static vor_status convert(const struct conversion *conversion, struct vor_error *err)
{
    char blob[VOR_BLOB_NAME_MAX + 1];
    uint64_t size;
    int fd, found;
    vor_status status;

    if (vor_thread_pool_is_closing(conversion->service->config.pool))
        return vor_fail(err, VOR_E_CANCELLED, "the daemon is shutting down");
    (void)vor_blob_of_output(output_name(conversion), conversion->row.attempt, blob);
    status = vor_blob_get(conversion->service->config.blobs, &conversion->row.id, blob, &fd, &size,
                          &found, err);
    if (status != VOR_OK)
        return status;
    if (!found)
        return vor_fail(err, VOR_E_INTERNAL, "the result no longer exists");
    status = convert_file(conversion, fd, size, err);
    (void)close(fd);
    if (status == VOR_OK)
        drop_if_gone(conversion);
    return status;
}

/* --- on its way ------------------------------------------------------------------------------- */

static void run_conversion(void *ctx)
{
    struct conversion *conversion = ctx;
    struct vor_conversions *service = conversion->service;
    struct conversion **at = &service->list;
    struct vor_error err = {.status = VOR_OK};
    vor_status status = convert(conversion, &err);
    struct vor_askers *waiting;

    vor_log(status == VOR_OK ? VOR_LOG_INFO : VOR_LOG_WARN, "result converted",
            VOR_TEXT("job", conversion->row.id.text),
            VOR_TEXT("format", vor_format(conversion->format)->name),
            VOR_TEXT("error", status != VOR_OK ? err.message : NULL));
    pthread_mutex_lock(&service->mutex);
    waiting = vor_waiting_take(&conversion->waiting);
    if (status != VOR_OK) {
        conversion->error = err;
        conversion->failed = vor_clock_seconds();
    } else {
        while (*at != conversion)
            at = &(*at)->next;
        *at = conversion->next;
        free(conversion);
    }
    pthread_mutex_unlock(&service->mutex);
    vor_waiting_wake(waiting);
}

/* The one of the same job, output and format; removes those that failed long ago. The mutex is
 * held. */
static struct conversion *find(struct vor_conversions *service, const struct vor_job_view *row,
                               unsigned output, unsigned format)
{
    double now = vor_clock_seconds();
    struct conversion *found = NULL;

    for (struct conversion **at = &service->list; *at != NULL;) {
        struct conversion *one = *at;

        if (one->failed > 0 && now - one->failed > failed_seconds) {
            *at = one->next;
            free(one);
            continue;
        }
        if (one->output == output && one->format == format &&
            strcmp(one->row.id.text, row->id.text) == 0)
            found = one;
        at = &one->next;
    }
    return found;
}

enum vor_job_outcome vor_convert(struct vor_conversions *conversions,
                                 const struct vor_job_view *row, unsigned output, unsigned format,
                                 const struct vor_asker *asker, struct vor_error *err)
{
    struct conversion *fresh = calloc(1, sizeof *fresh), *found;
    enum vor_job_outcome outcome = VOR_DONE;

    (void)vor_fail(err, VOR_E_NOMEM, "converting a result");
    if (fresh == NULL)
        return VOR_FAILED;
    *fresh = (struct conversion){.service = conversions,
                                 .row = *row,
                                 .output = output,
                                 .format = format,
                                 .task = {.run = run_conversion,
                                          .ctx = fresh,
                                          .caller = asker->caller,
                                          .weight = row->output[output].bytes}};
    pthread_mutex_lock(&conversions->mutex);
    found = find(conversions, row, output, format);
    if (found == NULL)
        outcome = vor_thread_pool_submit(conversions->config.pool, &fresh->task, err);
    if (found == NULL && outcome == VOR_DONE) {
        found = fresh;
        fresh = NULL;
        found->next = conversions->list;
        conversions->list = found;
    }
    if (found != NULL && found->failed > 0) {
        outcome = VOR_FAILED;
        *err = found->error;
    } else if (found != NULL && !vor_waiting_add(&found->waiting, asker)) {
        outcome = VOR_FAILED;
    }
    pthread_mutex_unlock(&conversions->mutex);
    free(fresh);
    return outcome;
}

/* --- what is kept ----------------------------------------------------------------------------- */

vor_status vor_converted_open(struct vor_converted *out, struct vor_blobs *blobs,
                              const struct vor_uuid *id, const char *output, unsigned format,
                              struct vor_error *err)
{
    char name[VOR_BLOB_NAME_MAX + 1];
    struct trailer trailer;
    int found = 0;
    vor_status status =
        vor_blob_get(blobs, id, vor_blob_of_converted(output, vor_format(format)->name, name),
                     &out->fd, &out->size, &found, err);

    if (status != VOR_OK || !found) {
        out->fd = -1;
        return status;
    }
    if (out->size < sizeof trailer ||
        pread(out->fd, &trailer, sizeof trailer, (off_t)(out->size - sizeof trailer)) !=
            (ssize_t)sizeof trailer) {
        (void)close(out->fd);
        out->fd = -1;
        return vor_fail_errno(err, EIO, "reading a converted result");
    }
    (void)snprintf(out->sha256, sizeof out->sha256, "%.*s", VOR_DIGEST_SIZE - 1, trailer.sha256);
    (void)snprintf(out->origin, sizeof out->origin, "%.*s", VOR_ORIGIN_TEXT_SIZE - 1,
                   trailer.origin);
    out->size -= sizeof trailer;
    return VOR_OK;
}
