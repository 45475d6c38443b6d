#include "server/blob/s3_multipart.h"

#include <stdio.h>

enum {
    ID_SIZE = 1024, /* of an upload, with its escapes */
    ANSWER_MAX = 64 << 10,
    PARTS_URL_SIZE = 4 * VOR_S3_URL_SIZE + ID_SIZE
};

#define UNSIGNED "x-amz-content-sha256: UNSIGNED-PAYLOAD"

struct upload {
    struct vor_s3 *s3;
    const char *url; /* of the object */
    const struct vor_object_bytes *bytes;
    char id[ID_SIZE];
    struct vor_text parts; /* the document that lists them */
};

/* A request about an upload; 404 is a failure. */
static vor_status ask(struct vor_s3_call *call, const char *url, struct vor_error *err)
{
    vor_status status;

    call->url = url;
    status = vor_s3_perform(call, err);
    return status == VOR_OK && call->http == 404 ? vor_s3_fail(call, err) : status;
}

static vor_status begin(struct upload *upload, struct vor_error *err)
{
    struct vor_s3_call call = {.s3 = upload->s3,
                               .verb = "parts",
                               .method = "POST",
                               .body = "",
                               .fd = -1,
                               .ends = "</InitiateMultipartUploadResult>",
                               .patience = upload->bytes->patience,
                               .header = {UNSIGNED, "Content-Type: application/octet-stream"}};
    char url[PARTS_URL_SIZE], id[ID_SIZE / 3], *escaped;
    vor_status status;

    (void)snprintf(url, sizeof url, "%s?uploads=", upload->url);
    vor_text_init(&call.text, ANSWER_MAX);
    status = ask(&call, url, err);
    if (status == VOR_OK) {
        vor_s3_element(call.text.data, "UploadId", id, sizeof id);
        escaped = upload->s3->curl->easy_escape(NULL, id, 0);
        status = escaped != NULL ? VOR_OK : vor_fail(err, VOR_E_NOMEM, "a request to S3");
        if (escaped != NULL)
            (void)snprintf(upload->id, sizeof upload->id, "%s", escaped);
        upload->s3->curl->free(escaped);
    }
    vor_text_free(&call.text);
    return status;
}

static vor_status put_part(struct upload *upload, unsigned number, struct vor_s3_call *part,
                           struct vor_error *err)
{
    char url[PARTS_URL_SIZE], header[128], sha256[VOR_DIGEST_SIZE];
    vor_status status;

    if (!vor_digest_file(part->fd, part->from, part->size, sha256))
        return vor_fail(err, VOR_E_IO, "a temporary file cannot be read, or memory is out");
    /* In the order of names, as they are signed. */
    (void)snprintf(url, sizeof url, "%s?partNumber=%u&uploadId=%s", upload->url, number,
                   upload->id);
    (void)snprintf(header, sizeof header, "x-amz-content-sha256: %s", sha256);
    part->header[0] = header;
    vor_text_init(&part->text, ANSWER_MAX);
    status = ask(part, url, err);
    vor_text_free(&part->text);
    vor_text_printf(&upload->parts, "<Part><PartNumber>%u</PartNumber><ETag>%s</ETag></Part>",
                    number, part->etag);
    return status;
}

static vor_status put_all(struct upload *upload, struct vor_error *err)
{
    const uint64_t size = upload->bytes->size;
    vor_status status = VOR_OK;
    unsigned number = 1;

    vor_text_puts(&upload->parts, "<CompleteMultipartUpload>");
    for (uint64_t at = 0; at < size && status == VOR_OK; at += VOR_S3_PART) {
        struct vor_s3_call part = {.s3 = upload->s3,
                                   .verb = "part",
                                   .method = "PUT",
                                   .is_put = 1,
                                   .fd = upload->bytes->fd,
                                   .patience = upload->bytes->patience,
                                   .from = at,
                                   .size = size - at < VOR_S3_PART ? size - at : VOR_S3_PART};

        status = put_part(upload, number++, &part, err);
    }
    vor_text_puts(&upload->parts, "</CompleteMultipartUpload>");
    return status == VOR_OK ? vor_text_status(&upload->parts, err) : status;
}

/* The object is there with that size: whose answer was lost is asked for twice. */
static int is_made(struct upload *upload)
{
    struct vor_s3_call call = {
        .s3 = upload->s3, .verb = "head", .method = "HEAD", .fd = -1, .header = {UNSIGNED}};

    return ask(&call, upload->url, NULL) == VOR_OK && (uint64_t)call.length == upload->bytes->size;
}

static vor_status complete(struct upload *upload, struct vor_error *err)
{
    struct vor_s3_call call = {.s3 = upload->s3,
                               .verb = "parts",
                               .method = "POST",
                               .body = upload->parts.data,
                               .fd = -1,
                               .ends = "</CompleteMultipartUploadResult>",
                               .patience = upload->bytes->patience,
                               .header = {UNSIGNED, "Content-Type: application/xml"}};
    char url[PARTS_URL_SIZE];
    vor_status status;

    (void)snprintf(url, sizeof url, "%s?uploadId=%s", upload->url, upload->id);
    vor_text_init(&call.text, ANSWER_MAX);
    status = ask(&call, url, err);
    vor_text_free(&call.text);
    return status != VOR_OK && call.http == 404 && is_made(upload) ? VOR_OK : status;
}

static void abort_parts(struct upload *upload)
{
    struct vor_s3_call call = {.s3 = upload->s3,
                               .verb = "parts",
                               .method = "DELETE",
                               .fd = -1,
                               .is_once = 1,
                               .header = {UNSIGNED}};
    char url[PARTS_URL_SIZE];

    (void)snprintf(url, sizeof url, "%s?uploadId=%s", upload->url, upload->id);
    vor_text_init(&call.text, ANSWER_MAX);
    (void)(ask(&call, url, NULL) == VOR_OK); /* nothing more can be done */
    vor_text_free(&call.text);
}

vor_status vor_s3_put_parts(struct vor_s3 *s3, const char *url,
                            const struct vor_object_bytes *bytes, struct vor_error *err)
{
    struct upload upload = {.s3 = s3, .url = url, .bytes = bytes};
    vor_status status;

    vor_text_init(&upload.parts, 0);
    status = begin(&upload, err);
    if (status == VOR_OK) {
        status = put_all(&upload, err);
        VOR_THEN(status, complete(&upload, err));
        if (status != VOR_OK)
            abort_parts(&upload);
    }
    vor_text_free(&upload.parts);
    return status;
}
