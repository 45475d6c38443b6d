#include "server/http/state.h"

#include "proto/text.h"
#include "server/base/clock.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void vor_reply_header(struct vor_request *request, const char *name, const char *value)
{
    struct vor_reply *reply = &request->reply;
    char *copy;

    if (value == NULL || strpbrk(value, VOR_CONTROLS "\t") != NULL ||
        reply->field_count == VOR_REPLY_FIELDS_MAX)
        return;
    copy = strdup(value);
    if (copy != NULL) {
        reply->fields[reply->field_count].name = name;
        reply->fields[reply->field_count].value = copy;
        reply->field_count++;
    }
}

void vor_reply_clear(struct vor_request *request, unsigned fields)
{
    struct vor_reply *reply = &request->reply;

    while (reply->field_count > fields) {
        reply->field_count--;
        free((void *)(uintptr_t)reply->fields[reply->field_count].value);
    }
    free(reply->bytes);
    reply->bytes = NULL;
    if (reply->kind == VOR_REPLY_FILE && reply->fd >= 0)
        (void)close(reply->fd);
    reply->fd = -1;
    reply->kind = VOR_REPLY_NONE;
    reply->http = 0;
    reply->size = 0;
    reply->close = false;
    request->problem = NULL;
}

static struct vor_reply *begin(struct vor_request *request, enum vor_reply_kind kind, int http,
                               const char *media_type)
{
    struct vor_reply *reply = &request->reply;

    assert(reply->kind == VOR_REPLY_NONE);
    reply->kind = kind;
    reply->http = http;
    reply->media_type = media_type;
    return reply;
}

void vor_reply_bytes(struct vor_request *request, int http, const char *media_type,
                     const void *bytes, size_t size)
{
    char *copy = malloc(size + 1);
    struct vor_reply *reply = begin(request, VOR_REPLY_BYTES, copy != NULL ? http : 500,
                                    copy != NULL ? media_type : NULL);

    reply->size = copy != NULL ? size : 0;
    reply->bytes = copy;
    if (copy == NULL)
        return;
    if (size > 0)
        memcpy(copy, bytes, size);
    copy[size] = '\0';
}

void vor_reply_file(struct vor_request *request, int http, const char *media_type, int fd,
                    uint64_t offset, uint64_t length)
{
    struct vor_reply *reply = begin(request, VOR_REPLY_FILE, http, media_type);

    reply->fd = fd;
    reply->offset = offset;
    reply->size = length;
}

void vor_reply_stream(struct vor_request *request, int http, const char *media_type,
                      uint64_t length,
                      long (*read)(struct vor_request *request, char *out, size_t size))
{
    struct vor_reply *reply = begin(request, VOR_REPLY_STREAM, http, media_type);

    reply->size = length;
    reply->read = read;
}

char *vor_reply_raw(const struct vor_request *request)
{
    const struct vor_reply *reply = &request->reply;
    char *text = NULL, date[VOR_HTTP_DATE_SIZE];
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);

    assert(reply->kind == VOR_REPLY_BYTES || reply->kind == VOR_REPLY_STREAM);
    if (out == NULL)
        return NULL;
    vor_clock_http_date(date);
    (void)fprintf(out, "HTTP/1.1 %d %s\r\nDate: %s\r\n", reply->http,
                  reply->kind == VOR_REPLY_STREAM ? "OK" : "Refused", date);
    (void)fputs("Connection: close\r\nX-Content-Type-Options: nosniff\r\n", out);
    if (reply->kind == VOR_REPLY_STREAM)
        (void)fputs("Transfer-Encoding: chunked\r\n", out);
    else
        (void)fprintf(out, "Content-Length: %" PRIu64 "\r\n", reply->size);
    (void)fprintf(out, "X-Request-Id: %s\r\n", request->id);
    if (reply->media_type != NULL)
        (void)fprintf(out, "Content-Type: %s\r\n", reply->media_type);
    for (unsigned i = 0; i < reply->field_count; i++)
        (void)fprintf(out, "%s: %s\r\n", reply->fields[i].name, reply->fields[i].value);
    (void)fprintf(out, "\r\n%s", reply->bytes != NULL ? reply->bytes : "");
    if (fclose(out) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

void vor_refusal_excess(char *detail, size_t size, struct vor_refusal *refusal, uint64_t limit,
                        uint64_t got)
{
    (void)snprintf(detail, size, "the body has %s%llu bytes, want at most %llu",
                   got > limit ? "" : "more than ", (unsigned long long)got,
                   (unsigned long long)limit);
    *refusal = (struct vor_refusal){413, "too-many-bytes", detail, limit, got};
}

void vor_refusal_sink(struct vor_refusal *refusal, int http)
{
    *refusal =
        http == 507
            ? (struct vor_refusal){507, "storage-full", "no room is left to keep the upload", 0, 0}
            : (struct vor_refusal){503, "store-unavailable", "the upload cannot be kept", 0, 0};
}
