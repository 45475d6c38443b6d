/* A conversion is shared by those who wait for it: it is freed once it is over and the last of them
 * has left. The digest of its bytes and its origin stand behind them in the blob, so that the ETag
 * needs no pass over the file, and the origin no decoding. */
#include "server/work/conversion.h"

#include "proto/codec.h"
#include "proto/json/json.h"
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

struct vor_conversion {
    struct vor_conversions *service;
    struct vor_job_view row;
    unsigned output, format;
    struct vor_task task;
    struct vor_conversion_waiter *waiters;
    int is_over;
    vor_status status;
    struct vor_error error;
    struct vor_conversion *next;
};

struct vor_conversions {
    struct vor_conversions_config config;
    pthread_mutex_t mutex;       /* everything below, and the waiters and ends of conversions */
    struct vor_conversion *list; /* those that are not over */
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
    pthread_mutex_destroy(&conversions->mutex);
    free(conversions);
}

/* --- the work --------------------------------------------------------------------------------- */

static const char *output_name(const struct vor_conversion *conversion)
{
    return conversion->row.spec.process->outputs[conversion->output].name;
}

/* The spacing that the report tells; 0 where none does. */
static double spacing_of(const struct vor_conversion *conversion)
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

/* Converts the file of a result into a blob that has no name yet. */
static vor_status fill_blob(struct vor_blob_writer *writer, const struct vor_conversion *conversion,
                            int fd, uint64_t size, struct vor_error *err)
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
    const struct vor_sink sink = vor_blob_sink(writer);
    struct trailer trailer = {.origin = ""};
    struct vor_codec_facts facts;
    vor_status status = vor_blob_compare(
        fd, size, conversion->row.output[conversion->output].sha256, output_name(conversion), err);

    if (status == VOR_OK)
        status = vor_blob_promise(writer, 0, err);
    if (status == VOR_OK)
        status = vor_codec_run(&facts, &config->place, &order, fd, &sink, err);
    if (status == VOR_E_IO)
        (void)vor_blob_failure(writer, err);
    if (status != VOR_OK)
        return status;
    vor_blob_sha256(writer, trailer.sha256);
    if (facts.has_origin)
        (void)vor_origin_text(facts.origin, trailer.origin);
    return vor_blob_append(writer, &trailer, sizeof trailer, err);
}

static vor_status convert_file(const struct vor_conversion *conversion, int fd, uint64_t size,
                               struct vor_error *err)
{
    struct vor_blobs *blobs = conversion->service->config.blobs;
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_blob_writer *writer;
    vor_status status = vor_blob_create(blobs, &writer, err);

    if (status != VOR_OK)
        return status;
    status = fill_blob(writer, conversion, fd, size, err);
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        return status;
    }
    vor_blob_of_converted(output_name(conversion), vor_format(conversion->format)->name, name);
    return vor_blob_commit(writer, &conversion->row.id, name, err);
}

/* Removes the blob of a job that went while it was made; the next removal of the job finds it. */
static void drop_if_gone(const struct vor_conversion *conversion)
{
    const struct vor_conversions_config *config = &conversion->service->config;
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_job_view now;

    switch (vor_worker_get(config->worker, &conversion->row.id, NULL, &now, NULL)) {
    case VOR_UNKNOWN:
        break;
    case VOR_DONE:
        if (now.expired)
            break;
        return;
    default:
        return;
    }
    vor_blob_of_converted(output_name(conversion), vor_format(conversion->format)->name, name);
    if (vor_blob_drop(config->blobs, &conversion->row.id, name, NULL) != VOR_OK)
        vor_log(VOR_LOG_WARN, "file not deleted", VOR_TEXT("job", conversion->row.id.text));
}

static vor_status convert(const struct vor_conversion *conversion, struct vor_error *err)
{
    uint64_t size;
    int fd, found;
    vor_status status;

    if (vor_crew_closing(conversion->service->config.crew))
        return vor_fail(err, VOR_E_CANCELLED, "the daemon is shutting down");
    status = vor_blob_get(conversion->service->config.blobs, &conversion->row.id,
                          output_name(conversion), &fd, &size, &found, err);
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

/* --- those who wait --------------------------------------------------------------------------- */

/* Takes a conversion that is over off the list; the mutex is held. */
static void unlist(struct vor_conversions *service, const struct vor_conversion *conversion)
{
    struct vor_conversion **at = &service->list;

    while (*at != conversion)
        at = &(*at)->next;
    *at = conversion->next;
}

static void run_conversion(void *ctx)
{
    struct vor_conversion *conversion = ctx;
    struct vor_conversions *service = conversion->service;
    struct vor_error err = {.status = VOR_OK};
    vor_status status = convert(conversion, &err);
    int is_alone;

    vor_log(status == VOR_OK ? VOR_LOG_INFO : VOR_LOG_WARN, "result converted",
            VOR_TEXT("job", conversion->row.id.text),
            VOR_TEXT("format", vor_format(conversion->format)->name),
            VOR_TEXT("error", status != VOR_OK ? err.message : NULL));
    pthread_mutex_lock(&service->mutex);
    conversion->is_over = 1;
    conversion->status = status;
    conversion->error = err;
    unlist(service, conversion);
    for (struct vor_conversion_waiter *w = conversion->waiters; w != NULL; w = w->next)
        w->wake(w->ctx);
    is_alone = conversion->waiters == NULL;
    pthread_mutex_unlock(&service->mutex);
    if (is_alone)
        free(conversion);
}

/* The one of the same job, output and format; the mutex is held. */
static struct vor_conversion *find(const struct vor_conversions *service,
                                   const struct vor_job_view *row, unsigned output, unsigned format)
{
    struct vor_conversion *at = service->list;

    while (at != NULL && (at->output != output || at->format != format ||
                          strcmp(at->row.id.text, row->id.text) != 0))
        at = at->next;
    return at;
}

enum vor_job_outcome vor_conversion_begin(struct vor_conversion **out,
                                          struct vor_conversions *conversions,
                                          const struct vor_job_view *row, unsigned output,
                                          unsigned format, struct vor_conversion_waiter *waiter,
                                          struct vor_error *err)
{
    struct vor_conversion *fresh = calloc(1, sizeof *fresh), *found;
    enum vor_job_outcome outcome = VOR_DONE;

    if (fresh == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "converting a result");
        return VOR_FAILED;
    }
    fresh->service = conversions;
    fresh->row = *row;
    fresh->output = output;
    fresh->format = format;
    fresh->task = (struct vor_task){.run = run_conversion,
                                    .ctx = fresh,
                                    .caller = waiter->caller,
                                    .weight = row->output[output].bytes};
    pthread_mutex_lock(&conversions->mutex);
    found = find(conversions, row, output, format);
    if (found == NULL)
        outcome = vor_crew_take(conversions->config.crew, &fresh->task, err);
    if (found == NULL && outcome == VOR_DONE) {
        found = fresh;
        fresh = NULL;
        found->next = conversions->list;
        conversions->list = found;
    }
    if (found != NULL) {
        waiter->next = found->waiters;
        found->waiters = waiter;
        *out = found;
    }
    pthread_mutex_unlock(&conversions->mutex);
    free(fresh);
    return outcome;
}

int vor_conversion_over(struct vor_conversion *conversion, vor_status *status,
                        struct vor_error *err)
{
    int is_over;

    pthread_mutex_lock(&conversion->service->mutex);
    is_over = conversion->is_over;
    *status = conversion->status;
    *err = conversion->error;
    pthread_mutex_unlock(&conversion->service->mutex);
    return is_over;
}

void vor_conversion_leave(struct vor_conversion *conversion, struct vor_conversion_waiter *waiter)
{
    struct vor_conversions *service = conversion->service;
    struct vor_conversion_waiter **at = &conversion->waiters;
    int is_last;

    pthread_mutex_lock(&service->mutex);
    while (*at != waiter)
        at = &(*at)->next;
    *at = waiter->next;
    is_last = conversion->is_over && conversion->waiters == NULL;
    pthread_mutex_unlock(&service->mutex);
    if (is_last)
        free(conversion);
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
