#include "server/work/admit.h"

#include "proto/codec.h"
#include "proto/dump.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

struct vor_admit {
    struct vor_blobs *blobs;
    struct vor_admit_limits limits;
    struct vor_thread_pool *pool;
};

/* What a child wrote is believed once it was seen to be a dump of so many points. */
static vor_status check_dump(const struct vor_blob_writer *writer,
                             const struct vor_codec_facts *facts, struct vor_error *err)
{
    size_t size = (size_t)vor_blob_size(writer), points = 0;
    void *bytes = MAP_FAILED;
    vor_status status;

    if (size > 0)
        bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, vor_blob_fd(writer), 0);
    if (bytes == MAP_FAILED)
        return vor_fail_errno(err, size > 0 ? errno : EINVAL,
                              "mapping the decoded cloud into memory");
    status = vor_dump_check(&points, bytes, size, err);
    (void)munmap(bytes, size);
    if (status == VOR_OK && points != facts->points)
        status = vor_fail(err, VOR_E_FORMAT, "the decoder announced %llu points and wrote %zu",
                          (unsigned long long)facts->points, points);
    return status;
}

/* Decodes into a blob that has no name yet. */
static vor_status decode_to(struct vor_blob_writer *writer, struct vor_codec_facts *facts,
                            const struct vor_blob_writer *upload,
                            const struct vor_admit_limits *limits, struct vor_error *err)
{
    const struct vor_codec_order order = {.op = VOR_CODEC_DECODE,
                                          .size = vor_blob_size(upload),
                                          .memory = limits->memory,
                                          .most = UINT64_MAX,
                                          .limits = limits->codec};
    const struct vor_sink sink = vor_blob_sink(writer);
    vor_status status = vor_blob_promise(writer, 0, err);

    if (status != VOR_OK)
        return status;
    status = vor_codec_run(facts, &limits->place, &order, vor_blob_fd(upload), &sink, err);
    if (status == VOR_E_IO)
        (void)vor_blob_failure(writer, err);
    if (status == VOR_OK && limits->place.zygote != NULL)
        status = check_dump(writer, facts, err);
    return status == VOR_OK ? vor_blob_seal(writer, err) : status;
}

static vor_status decode(struct vor_admitted_input *input, const struct vor_uuid *id,
                         struct vor_blobs *blobs, struct vor_blob_writer *upload,
                         const struct vor_admit_limits *limits, struct vor_error *err)
{
    double began = vor_clock_seconds();
    struct vor_codec_facts facts = {0};
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_blob_writer *writer;
    const struct vor_format *format = NULL;
    uint8_t magic[16];
    ssize_t size;
    vor_status status;

    if (vor_blob_size(upload) == 0)
        return vor_fail(err, VOR_E_EMPTY, "the body is empty: 0 bytes, want a cloud");
    status = vor_blob_recheck(upload, err);
    VOR_THEN(status, vor_blob_create(blobs, &writer, err));
    if (status != VOR_OK)
        return status;
    status = decode_to(writer, &facts, upload, limits, err);
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        size = pread(vor_blob_fd(upload), magic, sizeof magic, 0);
        if (size > 0)
            format = vor_format_sniff(magic, (size_t)size);
        vor_metric_add(VOR_METRIC_DECODE_ERRORS, 1,
                       VOR_LABELS(format != NULL ? format->name : "none", vor_status_slug(status)));
        return status;
    }
    input->found.format = facts.format;
    input->found.points = facts.points;
    input->found.bytes = vor_blob_size(upload);
    input->found.seconds = vor_clock_seconds() - began;
    input->extent = facts.extent;
    vor_blob_sha256(upload, input->found.sha256);
    input->decoded = vor_blob_size(writer);
    return vor_blob_commit(writer, id, vor_blob_of_input(input->name, blob), err);
}

vor_status vor_admit_file(struct vor_admitted *admitted, const char *name, struct vor_blobs *blobs,
                          struct vor_blob_writer *upload, const struct vor_admit_limits *limits,
                          struct vor_error *err)
{
    struct vor_admitted_input input = {.name = name};
    struct vor_uuid id = admitted->id;
    vor_status status = VOR_OK;

    assert(admitted->count < VOR_INPUTS_MAX);
    if (admitted->count == 0)
        status = vor_uuid_make(&id, err);
    VOR_THEN(status, decode(&input, &id, blobs, upload, limits, err));
    if (status != VOR_OK)
        return status;
    admitted->id = id;
    admitted->item[admitted->count++] = input;
    return VOR_OK;
}

void vor_admit_keep(struct vor_admitted *admitted, struct vor_blob_writer *upload,
                    const struct vor_admit_limits *limits)
{
    struct vor_admitted_input *input = &admitted->item[admitted->count - 1];
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_error err;

    if (upload == NULL || vor_blob_size(upload) > limits->keep) {
        vor_blob_discard(upload);
        return;
    }
    vor_blob_be_lazy(upload); /* the job has its own bytes */
    input->is_kept = vor_blob_commit(upload, &admitted->id, vor_blob_of_upload(input->name, blob),
                                     &err) == VOR_OK;
    if (!input->is_kept)
        vor_log(VOR_LOG_WARN, "upload not kept", VOR_TEXT("job", admitted->id.text),
                VOR_TEXT("input", input->name), VOR_TEXT("error", err.message));
}

void vor_drop_file(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name)
{
    struct vor_error err;

    if (vor_blob_drop(blobs, id, name, &err) != VOR_OK)
        vor_log(VOR_LOG_WARN, "file not deleted", VOR_TEXT("job", id->text), VOR_TEXT("blob", name),
                VOR_TEXT("error", err.message));
}

void vor_admit_drop(struct vor_blobs *blobs, const struct vor_admitted *admitted)
{
    for (unsigned i = 0; i < admitted->count; i++) {
        const struct vor_admitted_input *input = &admitted->item[i];
        char blob[VOR_BLOB_NAME_MAX + 1];

        vor_drop_file(blobs, &admitted->id, vor_blob_of_input(input->name, blob));
        if (input->is_kept)
            vor_drop_file(blobs, &admitted->id, vor_blob_of_upload(input->name, blob));
    }
}

static vor_status admit_all(struct vor_admission *admission)
{
    const struct vor_admit *admit = admission->admit;
    struct vor_uploads *uploads = &admission->uploads;
    struct vor_admit_limits limits = admit->limits;
    uint64_t most = limits.inflated;
    vor_status status = VOR_OK;

    vor_limits_want(&limits.codec, admission->spec);
    limits.place.has_left = admission->has_left;
    limits.place.ctx = admission->ctx;
    for (unsigned i = 0; i < uploads->count && status == VOR_OK; i++) {
        struct vor_upload *upload = &uploads->item[i];

        status = vor_upload_cut(upload, admit->blobs, &admission->error);
        VOR_THEN(status,
                 vor_upload_inflate(upload, admit->blobs, &limits.place, &most, &admission->error));
        VOR_THEN(status, vor_admit_file(&admission->admitted, upload->name, admit->blobs,
                                        upload->bytes, &limits, &admission->error));
        if (status == VOR_OK) {
            vor_admit_keep(&admission->admitted, upload->bytes, &limits);
            upload->bytes = NULL;
        }
        if (status != VOR_OK && uploads->count > 1) { /* says which one is at fault */
            struct vor_error was = admission->error;

            (void)vor_fail_param(&admission->error, was.status, upload->name, "%s: %s",
                                 upload->name, was.message);
            admission->error.byte_offset = was.byte_offset;
            admission->error.limit = was.limit;
            admission->error.got = was.got;
        }
    }
    if (status != VOR_OK) {
        vor_admit_drop(admit->blobs, &admission->admitted);
        admission->admitted.count = 0;
    }
    return status;
}

static void run_admission(void *ctx)
{
    struct vor_admission *admission = ctx;

    if (vor_thread_pool_is_closing(admission->admit->pool))
        admission->status =
            vor_fail(&admission->error, VOR_E_CANCELLED, "the daemon is shutting down");
    else if (admission->has_left != NULL && admission->has_left(admission->ctx))
        admission->status = vor_fail(&admission->error, VOR_E_CANCELLED, "the client disconnected");
    else
        admission->status = admit_all(admission);
    if (admission->status == VOR_OK)
        admission->error.status = VOR_OK;
    vor_uploads_discard(&admission->uploads);
    admission->done(admission);
}

vor_status vor_admit_create(struct vor_admit **out, struct vor_blobs *blobs,
                            const struct vor_admit_limits *limits, unsigned threads,
                            size_t waiting_max, struct vor_error *err)
{
    struct vor_admit *admit = calloc(1, sizeof *admit);

    if (admit == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a request");
    admit->blobs = blobs;
    admit->limits = *limits;
    if (vor_thread_pool_create(&admit->pool, threads, waiting_max, err) != VOR_OK) {
        free(admit);
        return VOR_E_NOMEM;
    }
    if (threads > 1)
        vor_thread_pool_share(admit->pool, threads - 1, (waiting_max + 3) / 4);
    *out = admit;
    return VOR_OK;
}

void vor_admit_destroy(struct vor_admit *admit)
{
    if (admit == NULL)
        return;
    vor_thread_pool_destroy(admit->pool);
    free(admit);
}

struct vor_thread_pool *vor_admit_thread_pool(struct vor_admit *admit)
{
    return admit->pool;
}

enum vor_job_outcome vor_admit_submit(struct vor_admit *admit, struct vor_admission *admission)
{
    enum { GZIP_TYPICAL = 3 }; /* times its bytes come of it */
    const struct vor_uploads *uploads = &admission->uploads;

    admission->admit = admit;
    admission->task =
        (struct vor_task){.run = run_admission, .ctx = admission, .caller = admission->caller};
    for (unsigned i = 0; i < uploads->count; i++) {
        const struct vor_upload *upload = &uploads->item[i];

        admission->task.weight +=
            (upload->whole != NULL ? upload->size : vor_blob_size(upload->bytes)) *
            (upload->is_gzip ? GZIP_TYPICAL : 1);
    }
    return vor_thread_pool_submit(admit->pool, &admission->task, &admission->error);
}
