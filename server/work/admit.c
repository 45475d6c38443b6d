#include "server/work/admit.h"
#include "proto/dump.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/work/counted.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/mman.h>

struct vor_admit {
    struct vor_blobs *blobs;
    struct vor_admit_limits limits;
    struct vor_crew *crew;
};

static vor_status keep_cloud(const struct vor_cloud *cloud, struct vor_blobs *blobs,
                             const struct vor_uuid *id, const char *name, struct vor_error *err)
{
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_blob_writer *writer;
    struct vor_sink sink;
    vor_status status = vor_blob_create(blobs, &writer, err);

    if (status != VOR_OK)
        return status;
    sink = vor_blob_sink(writer);
    status = vor_dump_write(&sink, cloud, err);
    if (status != VOR_OK) {
        (void)vor_blob_failure(writer, err);
        vor_blob_discard(writer);
        return status;
    }
    return vor_blob_commit(writer, id, vor_blob_of_input(name, blob), err);
}

static vor_status decode(struct vor_cloud *cloud, struct vor_job_input *input,
                         struct vor_blob_writer *upload, const struct vor_limits *limits,
                         struct vor_error *err)
{
    size_t size = (size_t)vor_blob_size(upload);
    const struct vor_format *format = NULL;
    vor_status status;
    void *bytes;

    if (size == 0)
        return vor_fail(err, VOR_E_EMPTY, "the body is empty: 0 bytes, want a cloud");
    bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, vor_blob_fd(upload), 0);
    if (bytes == MAP_FAILED)
        return vor_fail_errno(err, errno, "mapping the upload");
    status = vor_codec_read(cloud, &format, bytes, size, limits, err);
    (void)munmap(bytes, size);
    if (status != VOR_OK) {
        vor_count_undecodable(format, status);
        return status;
    }
    for (input->format = 0; vor_format(input->format) != format; input->format++)
        assert(vor_format(input->format) != NULL);
    input->points = cloud->n;
    input->bytes = size;
    vor_blob_sha256(upload, input->sha256);
    return VOR_OK;
}

vor_status vor_admit_file(struct vor_admitted *admitted, const char *name, struct vor_blobs *blobs,
                          struct vor_blob_writer *upload, const struct vor_admit_limits *limits,
                          struct vor_error *err)
{
    struct vor_admitted_input input = {.name = name};
    double began = vor_clock_seconds();
    struct vor_uuid id = admitted->id;
    struct vor_memory memory;
    struct vor_cloud cloud;
    vor_status status;

    assert(admitted->count < VOR_INPUTS_MAX);
    vor_memory_init(&memory, limits->memory);
    vor_cloud_init(&cloud, &memory);
    status = decode(&cloud, &input.found, upload, &limits->codec, err);
    if (status == VOR_OK)
        vor_extent_measure(&input.extent, &cloud);
    input.found.seconds = vor_clock_seconds() - began;
    if (status == VOR_OK && admitted->count == 0)
        status = vor_uuid_make(&id, err);
    if (status == VOR_OK)
        status = keep_cloud(&cloud, blobs, &id, name, err);
    vor_cloud_free(&cloud);
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
    input->is_kept = vor_blob_commit(upload, &admitted->id, vor_blob_of_upload(input->name, blob),
                                     &err) == VOR_OK;
    if (!input->is_kept)
        vor_log(VOR_LOG_WARN, "upload not kept", VOR_TEXT("job", admitted->id.text),
                VOR_TEXT("input", input->name), VOR_TEXT("error", err.message));
}

static void drop_blob(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name)
{
    struct vor_error err;

    if (vor_blob_drop(blobs, id, name, &err) != VOR_OK)
        vor_log(VOR_LOG_WARN, "input not dropped", VOR_TEXT("job", id->text),
                VOR_TEXT("blob", name), VOR_TEXT("error", err.message));
}

void vor_admit_drop(struct vor_blobs *blobs, const struct vor_admitted *admitted)
{
    for (unsigned i = 0; i < admitted->count; i++) {
        const struct vor_admitted_input *input = &admitted->item[i];
        char blob[VOR_BLOB_NAME_MAX + 1];

        drop_blob(blobs, &admitted->id, vor_blob_of_input(input->name, blob));
        if (input->is_kept)
            drop_blob(blobs, &admitted->id, vor_blob_of_upload(input->name, blob));
    }
}

/* Says which of several inputs is at fault. */
static void name_input(struct vor_error *err, const char *name)
{
    struct vor_error was = *err;

    (void)vor_fail_param(err, was.status, name, "%s: %s", name, was.message);
    err->byte_offset = was.byte_offset;
    err->limit = was.limit;
    err->got = was.got;
}

static vor_status admit_all(struct vor_admission *admission)
{
    const struct vor_admit *admit = admission->admit;
    struct vor_uploads *uploads = &admission->uploads;
    struct vor_admit_limits limits = admit->limits;
    uint64_t most = limits.inflated;
    vor_status status = VOR_OK;

    limits.codec.drop_invalid = admission->drop_invalid;
    limits.codec.keep_faces = admission->keep_faces;
    for (unsigned i = 0; i < uploads->count && status == VOR_OK; i++) {
        struct vor_upload *upload = &uploads->item[i];

        status = vor_upload_inflate(upload, admit->blobs, &most, &admission->error);
        if (status == VOR_OK)
            status = vor_admit_file(&admission->admitted, upload->name, admit->blobs, upload->bytes,
                                    &limits, &admission->error);
        if (status == VOR_OK) {
            vor_admit_keep(&admission->admitted, upload->bytes, &limits);
            upload->bytes = NULL;
        }
        if (status != VOR_OK && uploads->count > 1)
            name_input(&admission->error, upload->name);
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

    if (vor_crew_closing(admission->admit->crew))
        admission->status =
            vor_fail(&admission->error, VOR_E_CANCELLED, "the daemon is going down");
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
        return vor_fail(err, VOR_E_NOMEM, "the admission");
    admit->blobs = blobs;
    admit->limits = *limits;
    if (vor_crew_create(&admit->crew, threads, waiting_max, err) != VOR_OK) {
        free(admit);
        return VOR_E_NOMEM;
    }
    *out = admit;
    return VOR_OK;
}

void vor_admit_destroy(struct vor_admit *admit)
{
    if (admit == NULL)
        return;
    vor_crew_destroy(admit->crew);
    free(admit);
}

struct vor_crew *vor_admit_crew(struct vor_admit *admit)
{
    return admit->crew;
}

enum vor_job_outcome vor_admit_submit(struct vor_admit *admit, struct vor_admission *admission)
{
    admission->admit = admit;
    admission->task = (struct vor_task){.run = run_admission, .ctx = admission};
    return vor_crew_take(admit->crew, &admission->task);
}
