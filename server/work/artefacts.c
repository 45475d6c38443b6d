#define _GNU_SOURCE /* memfd_create */
#include "server/work/artefacts.h"

#include "proto/dump.h"
#include "proto/json/json.h"
#include "server/base/disk.h"
#include "server/blob/blob.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* --- reading ---------------------------------------------------------------------------------- */

/* name: of the input's blob, for messages. */
static vor_status load_cloud(struct vor_cloud *cloud, const char *name, int fd,
                             struct vor_error *err)
{
    struct stat info = {.st_size = 0};
    size_t size = fstat(fd, &info) == 0 && info.st_size > 0 ? (size_t)info.st_size : 0;
    void *bytes = size > 0 ? mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
    size_t sealed = size;
    vor_status status;

    if (bytes == MAP_FAILED)
        return vor_fail(err, VOR_E_IO, "the job's %s cannot be read: %s", name,
                        size > 0 ? strerror(errno) : "it is empty");
    status = vor_blob_unseal(bytes, &sealed, name, err);
    VOR_THEN(status, vor_dump_read(cloud, bytes, sealed, err));
    (void)munmap(bytes, size);
    return status;
}

vor_status vor_artefacts_load(struct vor_artefacts *in, const struct vor_process_info *process,
                              const int input[VOR_INPUTS_MAX], struct vor_error *err)
{
    const struct vor_artefact_info *inputs = process->inputs;
    vor_status status = VOR_OK;

    for (unsigned i = 0; inputs[i].name != NULL && status == VOR_OK; i++) {
        char blob[VOR_BLOB_NAME_MAX + 1];
        struct vor_cloud cloud;

        if (input[i] < 0)
            continue;
        vor_cloud_init(&cloud, in->memory);
        status = load_cloud(&cloud, vor_blob_of_input(inputs[i].name, blob), input[i], err);
        vor_artefacts_put_cloud(in, inputs[i].name, &cloud);
    }
    return status;
}

/* --- writing ---------------------------------------------------------------------------------- */

/* A sink of codecs that writes to a descriptor. */
static int put(void *ctx, const void *bytes, size_t size)
{
    const char *at = bytes;

    while (size > 0) {
        ssize_t wrote = write(*(int *)ctx, at, size);

        if (wrote < 0 && errno != EINTR)
            return -1;
        at += wrote > 0 ? wrote : 0;
        size -= wrote > 0 ? (size_t)wrote : 0;
    }
    return 0;
}

static size_t triangle_bytes(const struct vor_mesh *mesh)
{
    return mesh != NULL ? mesh->count * 3 * sizeof *mesh->triangle : 0;
}

/* A file in memory with triangles and cloud, as VOR_CODEC_ENCODE reads it. */
static vor_status make_file(int *out, const struct vor_cloud *cloud, const struct vor_mesh *mesh,
                            struct vor_error *err)
{
    int fd = memfd_create("result", MFD_CLOEXEC);
    const struct vor_sink sink = {.ctx = &fd, .write = put};

    if (fd < 0)
        return vor_fail_errno(err, errno, "memory to share with a child process");
    if ((triangle_bytes(mesh) > 0 && put(&fd, mesh->triangle, triangle_bytes(mesh)) != 0) ||
        vor_dump_write(&sink, cloud, NULL) != VOR_OK) {
        (void)close(fd);
        return vor_fail(err, VOR_E_NOMEM, "a copy of the result's %zu points", cloud->n);
    }
    *out = fd;
    return VOR_OK;
}

vor_status vor_encode(const struct vor_sink *sink, const struct vor_codec_place *place,
                      const struct vor_cloud *cloud, unsigned format,
                      const struct vor_write_options *options, struct vor_error *err)
{
    static const size_t MEMORY_MOST = (size_t)1 << 46; /* of an address space */
    const struct vor_mesh *mesh = options->mesh;
    size_t size = triangle_bytes(mesh), left;
    struct vor_codec_facts facts;
    struct vor_codec_order order = {.op = VOR_CODEC_ENCODE, .format = format, .options = *options};
    vor_status status;
    int fd = -1;

    if (place->zygote == NULL || !vor_format(format)->is_fragile)
        return vor_format(format)->write(sink, cloud, options, err);
    order.triangles = mesh != NULL ? mesh->count : 0;
    order.polygons = mesh != NULL && mesh->polygons;
    order.options.mesh = NULL;
    size += (size_t)vor_dump_size(cloud);
    order.size = size;
    if (!vor_memory_charge(cloud->memory, size))
        return vor_fail(err, VOR_E_NOMEM, "a copy of the result's %zu points", cloud->n);
    status = make_file(&fd, cloud, mesh, err);
    if (status == VOR_OK) {
        left = cloud->memory->cap - atomic_load(&cloud->memory->used);
        order.most = order.memory = left < MEMORY_MOST ? left : MEMORY_MOST;
        status = vor_codec_run(&facts, place, &order, fd, sink, err);
        (void)close(fd);
        /* The peak of the memory tells what the child took besides. */
        if (status == VOR_OK && vor_memory_charge(cloud->memory, facts.memory))
            vor_memory_release(cloud->memory, facts.memory);
    }
    vor_memory_release(cloud->memory, size);
    return status;
}

static vor_status write_cloud(struct vor_job_output *out, struct vor_blob_writer *writer,
                              const struct vor_writing *writing,
                              const struct vor_artefact *artefact, struct vor_error *err)
{
    struct vor_sink sink = vor_blob_sink(writer);
    const struct vor_format *format = vor_format(out->format);
    struct vor_write_options options;
    struct vor_error why;
    vor_status status;

    if (format == NULL)
        return vor_fail(err, VOR_E_INTERNAL, "this version cannot write format %u", out->format);
    status = vor_write_options_from(&options, format, &writing->order->spec, writing->facts, err);
    if (status != VOR_OK)
        return status;
    out->points = artefact->cloud.n;
    out->has_origin = options.has_origin;
    memcpy(out->origin, options.origin, sizeof out->origin);
    options.mesh = &artefact->mesh;
    status = vor_encode(&sink, writing->place, &artefact->cloud, out->format, &options, &why);
    if (status == VOR_E_IO && vor_blob_failure(writer, err) == VOR_OK)
        return vor_fail(err, VOR_E_INTERNAL, "the %s writer failed: %.900s", format->label,
                        why.message);
    if (status != VOR_OK && status != VOR_E_IO)
        *err = why;
    return status;
}

static vor_status write_document(struct vor_blob_writer *writer,
                                 const struct vor_document *document, struct vor_error *err)
{
    struct vor_text text;
    vor_status status;

    vor_text_init(&text, 0);
    vor_json_document(&text, document);
    status = vor_text_status(&text, err);
    VOR_THEN(status, vor_blob_append(writer, text.data, text.size, err));
    vor_text_free(&text);
    return status;
}

vor_status vor_artefact_write(struct vor_job_output *out, const struct vor_writing *writing,
                              unsigned index, const struct vor_artefact *artefact,
                              struct vor_error *err)
{
    const struct vor_order *order = writing->order;
    int is_cloud = artefact->kind == VOR_ARTEFACT_CLOUD;
    struct vor_job_output written = {.format = !is_cloud ? 0
                                               : vor_spec_given(&order->spec, VOR_PARAM_FORMAT)
                                                   ? (unsigned)order->spec.value[VOR_PARAM_FORMAT]
                                                   : order->format};
    struct vor_blob_writer *writer = vor_blob_borrow(order->output[index]);
    vor_status status;

    if (writer == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the output %s", artefact->name);
    status = is_cloud ? write_cloud(&written, writer, writing, artefact, err)
                      : write_document(writer, &artefact->document, err);
    if (status == VOR_OK) {
        written.bytes = vor_blob_size(writer);
        vor_blob_sha256(writer, written.sha256);
        *out = written;
    }
    vor_blob_discard(writer);
    return status;
}
