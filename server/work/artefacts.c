#include "server/work/artefacts.h"

#include "proto/dump.h"
#include "proto/json/json.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* --- reading ---------------------------------------------------------------------------------- */

static vor_status map_cloud(struct vor_cloud *cloud, const char *name, int fd, size_t size,
                            struct vor_error *err)
{
    void *bytes = size > 0 ? mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
    size_t sealed = size;
    vor_status status;

    if (bytes == MAP_FAILED)
        return vor_fail(err, VOR_E_IO, "the job's %s cannot be mapped: %s", name,
                        size > 0 ? strerror(errno) : "it is empty");
    status = vor_blob_unseal(bytes, &sealed, name, err);
    if (status == VOR_OK)
        status = vor_dump_read(cloud, bytes, sealed, err);
    (void)munmap(bytes, size);
    return status;
}

static vor_status load_cloud(struct vor_cloud *cloud, struct vor_blobs *blobs,
                             const struct vor_uuid *id, const char *name, struct vor_error *err)
{
    char blob[VOR_BLOB_NAME_MAX + 1];
    uint64_t size;
    vor_status status;
    int fd, found;

    status = vor_blob_get(blobs, id, vor_blob_of_input(name, blob), &fd, &size, &found, err);
    if (status != VOR_OK)
        return status;
    if (!found)
        return vor_fail(err, VOR_E_INTERNAL, "the job's input %s is gone", name);
    status = map_cloud(cloud, blob, fd, (size_t)size, err);
    close(fd);
    return status;
}

vor_status vor_artefacts_load(struct vor_artefacts *in, struct vor_blobs *blobs,
                              const struct vor_job_view *row, struct vor_error *err)
{
    const struct vor_artefact_info *inputs = row->spec.process->inputs;
    vor_status status = VOR_OK;

    for (unsigned i = 0; inputs[i].name != NULL && status == VOR_OK; i++) {
        struct vor_cloud cloud;

        if ((row->inputs >> i & 1) == 0)
            continue;
        vor_cloud_init(&cloud, in->memory);
        status = load_cloud(&cloud, blobs, &row->id, inputs[i].name, err);
        vor_artefacts_put_cloud(in, inputs[i].name, &cloud);
    }
    return status;
}

/* --- writing ---------------------------------------------------------------------------------- */

static vor_status write_cloud(struct vor_job_output *out, struct vor_blob_writer *writer,
                              const struct vor_job_view *row, const struct vor_artefact *artefact,
                              const struct vor_result_facts *facts, struct vor_error *err)
{
    int is_asked = vor_spec_given(&row->spec, VOR_PARAM_FORMAT);
    struct vor_sink sink = vor_blob_sink(writer);
    struct vor_write_options options;
    const struct vor_format *format;
    vor_status status;

    out->format = is_asked ? (unsigned)row->spec.value[VOR_PARAM_FORMAT] : row->input[0].format;
    out->points = artefact->cloud.n;
    format = vor_format(out->format);
    if (format == NULL)
        return vor_fail(err, VOR_E_INTERNAL, "this version has no format %u", out->format);
    status = vor_write_options_from(&options, format, &row->spec, facts, err);
    if (status != VOR_OK)
        return status;
    out->has_origin = options.has_origin;
    memcpy(out->origin, options.origin, sizeof out->origin);
    options.mesh = &artefact->mesh;
    status = format->write(&sink, &artefact->cloud, &options, err);
    if (status == VOR_E_IO && vor_blob_failure(writer, err) == VOR_OK)
        return vor_fail(err, VOR_E_INTERNAL, "the %s writer gave up", format->label);
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
    if (status == VOR_OK)
        status = vor_blob_append(writer, text.data, text.size, err);
    vor_text_free(&text);
    return status;
}

vor_status vor_artefact_save(struct vor_job_output *out, struct vor_blobs *blobs,
                             const struct vor_job_view *row, const struct vor_artefact *artefact,
                             const struct vor_result_facts *facts, struct vor_error *err)
{
    struct vor_job_output written = {.format = 0};
    struct vor_blob_writer *writer;
    vor_status status = vor_blob_create(blobs, &writer, err);

    if (status != VOR_OK)
        return status;
    status = artefact->kind == VOR_ARTEFACT_CLOUD
                 ? write_cloud(&written, writer, row, artefact, facts, err)
                 : write_document(writer, &artefact->document, err);
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        return status;
    }
    written.bytes = vor_blob_size(writer);
    vor_blob_sha256(writer, written.sha256);
    status = vor_blob_commit(writer, &row->id, artefact->name, err);
    if (status == VOR_OK)
        *out = written;
    return status;
}
