#include "server/work/upload.h"

#include "server/base/metrics.h"

#include <assert.h>

void vor_uploads_add(struct vor_uploads *uploads, const struct vor_upload *upload)
{
    assert(uploads->count < VOR_INPUTS_MAX);
    vor_metric_add(VOR_METRIC_UPLOADS, 1, NULL);
    uploads->item[uploads->count++] = *upload;
}

/* A file for bytes that come. Room is kept for them as they do, and not for a length that was
 * declared: else a few callers who declare much and send nothing would have the disk. */
static vor_status create_file(struct vor_blob_writer **out, struct vor_blobs *blobs,
                              struct vor_error *err)
{
    vor_status status = vor_blob_create(blobs, out, err);

    if (status != VOR_OK)
        return status;
    status = vor_blob_promise(*out, 0, err);
    if (status != VOR_OK) {
        vor_blob_discard(*out);
        *out = NULL;
    }
    return status;
}

vor_status vor_uploads_begin(struct vor_uploads *uploads, const char *name, int is_gzip,
                             struct vor_blobs *blobs, struct vor_error *err)
{
    struct vor_upload upload = {.name = name, .is_gzip = is_gzip};
    vor_status status = create_file(&upload.bytes, blobs, err);

    if (status == VOR_OK)
        vor_uploads_add(uploads, &upload);
    return status;
}

void vor_uploads_drop_last(struct vor_uploads *uploads)
{
    vor_metric_add(VOR_METRIC_UPLOADS, -1, NULL);
    vor_blob_discard(uploads->item[--uploads->count].bytes);
}

void vor_uploads_discard(struct vor_uploads *uploads)
{
    while (uploads->count > 0)
        vor_uploads_drop_last(uploads);
}

vor_status vor_upload_cut(struct vor_upload *upload, struct vor_blobs *blobs, struct vor_error *err)
{
    vor_status status;

    if (upload->whole == NULL)
        return VOR_OK;
    status = create_file(&upload->bytes, blobs, err);
    VOR_THEN(status, vor_blob_append_file(upload->bytes, vor_blob_fd(upload->whole), upload->offset,
                                          upload->size, err));
    upload->whole = NULL;
    return status;
}

vor_status vor_upload_inflate(struct vor_upload *upload, struct vor_blobs *blobs,
                              const struct vor_codec_place *place, uint64_t *most,
                              struct vor_error *err)
{
    struct vor_codec_order order = {.op = VOR_CODEC_INFLATE};
    struct vor_blob_writer *inflated = NULL;
    struct vor_codec_facts facts;
    struct vor_sink sink;
    vor_status status;

    if (!upload->is_gzip)
        return VOR_OK;
    order.size = vor_blob_size(upload->bytes);
    status = create_file(&inflated, blobs, err);
    if (status != VOR_OK)
        return status;
    order.most = *most;
    sink = vor_blob_sink(inflated);
    status = vor_codec_run(&facts, place, &order, vor_blob_fd(upload->bytes), &sink, err);
    if (status != VOR_OK) {
        (void)vor_blob_failure(inflated, err);
        vor_blob_discard(inflated);
        return status;
    }
    *most -= vor_blob_size(inflated);
    vor_blob_discard(upload->bytes);
    upload->bytes = inflated;
    upload->is_gzip = 0;
    return VOR_OK;
}
