#include "server/work/admit.h"
#include "proto/dump.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"

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
    if (status != VOR_OK)
        return status;
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

void vor_admit_drop(struct vor_blobs *blobs, const struct vor_admitted *admitted)
{
    for (unsigned i = 0; i < admitted->count; i++) {
        char blob[VOR_BLOB_NAME_MAX + 1];
        struct vor_error err;

        if (vor_blob_drop(blobs, &admitted->id, vor_blob_of_input(admitted->item[i].name, blob),
                          &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "input not dropped", VOR_TEXT("job", admitted->id.text),
                    VOR_TEXT("input", admitted->item[i].name), VOR_TEXT("error", err.message));
    }
}

static void run_admission(void *ctx)
{
    struct vor_admission *admission = ctx;
    struct vor_admit *admit = admission->admit;
    struct vor_admit_limits limits = admit->limits;

    limits.codec.drop_invalid = admission->drop_invalid;
    if (vor_crew_closing(admit->crew))
        admission->status =
            vor_fail(&admission->error, VOR_E_CANCELLED, "the daemon is going down");
    else
        admission->status = vor_admit_file(&admission->admitted, admission->name, admit->blobs,
                                           admission->upload, &limits, &admission->error);
    if (admission->status == VOR_OK)
        admission->error.status = VOR_OK;
    vor_blob_discard(admission->upload);
    admission->upload = NULL;
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
