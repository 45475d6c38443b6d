#include "server/work/upload.h"

#include "proto/gzip.h"
#include "server/base/disk.h"

#include <errno.h>
#include <sys/mman.h>

void vor_uploads_discard(struct vor_uploads *uploads)
{
    while (uploads->count > 0)
        vor_blob_discard(uploads->item[--uploads->count].bytes);
}

static vor_status inflate_to(struct vor_blob_writer *out, const struct vor_blob_writer *in,
                             uint64_t most, struct vor_error *err)
{
    size_t size = (size_t)vor_blob_size(in);
    struct vor_sink sink = vor_blob_sink(out);
    void *bytes = NULL;
    vor_status status;

    if (size > 0)
        bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, vor_blob_fd(in), 0);
    if (bytes == MAP_FAILED)
        return vor_fail_errno(err, errno, "mapping the upload");
    status = vor_gzip_inflate(&sink, bytes, size, most, err);
    if (bytes != NULL)
        (void)munmap(bytes, size);
    if (status != VOR_OK)
        (void)vor_blob_failure(out, err);
    return status;
}

vor_status vor_upload_inflate(struct vor_upload *upload, struct vor_blobs *blobs, uint64_t *most,
                              struct vor_error *err)
{
    struct vor_blob_writer *inflated = NULL;
    vor_status status;

    if (!upload->is_gzip)
        return VOR_OK;
    status = vor_blob_create(blobs, &inflated, err);
    if (status != VOR_OK)
        return status;
    status = vor_blob_promise(inflated, 0, err);
    if (status == VOR_OK)
        status = inflate_to(inflated, upload->bytes, *most, err);
    if (status != VOR_OK) {
        vor_blob_discard(inflated);
        return status;
    }
    *most -= vor_blob_size(inflated);
    vor_blob_discard(upload->bytes);
    upload->bytes = inflated;
    upload->is_gzip = 0;
    return VOR_OK;
}
