#include "server/blob/objects.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/blob/s3_multipart.h"
#include "server/blob/s3_request.h"
#include "server/blob/s3_sign.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    TEXT_MAX = 8 << 20, /* of an answer that is no object: 1,000 keys take .5 MB */
    PATH_SIZE = 3 * VOR_S3_URL_SIZE + VOR_OBJECT_KEY_MAX + 2
};

/* The characters of buckets and keys. */
#define PLAIN "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._/-"

#define TOKEN "x-amz-security-token: "

/* --- opening ---------------------------------------------------------------------------------- */

static vor_status read_secret_file(char out[VOR_S3_SECRET_SIZE], const char *path,
                                   struct vor_error *err)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t size = fd >= 0 ? read(fd, out, VOR_S3_SECRET_SIZE - 1) : -1;
    int number = errno;

    if (fd >= 0)
        close(fd);
    if (size < 0)
        return vor_fail_errno(err, number, path);
    while (size > 0 && strchr(" \t\r\n", out[size - 1]) != NULL)
        size--;
    out[size] = '\0';
    return VOR_OK;
}

/* The value of a variable, or of the file that VARIABLE_FILE names; "" where neither is set. */
static vor_status read_secret(char out[VOR_S3_SECRET_SIZE], const char *variable,
                              struct vor_error *err)
{
    const char *value = getenv(variable), *path;
    char file[64];

    out[0] = '\0';
    (void)snprintf(file, sizeof file, "%s_FILE", variable);
    path = getenv(file);
    if (value == NULL)
        return path != NULL ? read_secret_file(out, path, err) : VOR_OK;
    if (strlen(value) >= VOR_S3_SECRET_SIZE)
        return vor_fail_param(err, VOR_E_IO, "blobs", "%s has %zu bytes, want at most %d", variable,
                              strlen(value), VOR_S3_SECRET_SIZE - 1);
    memcpy(out, value, strlen(value) + 1);
    return VOR_OK;
}

static vor_status read_keys(struct vor_s3 *s3, struct vor_error *err)
{
    const char *region = getenv("AWS_REGION");
    char token[VOR_S3_SECRET_SIZE];
    vor_status status = read_secret(s3->key_id, "AWS_ACCESS_KEY_ID", err);

    VOR_THEN(status, read_secret(s3->secret, "AWS_SECRET_ACCESS_KEY", err));
    VOR_THEN(status, read_secret(token, "AWS_SESSION_TOKEN", err));
    if (status != VOR_OK)
        return status;
    if (s3->key_id[0] == '\0' || s3->secret[0] == '\0')
        return vor_fail_param(err, VOR_E_IO, "blobs",
                              "blobs in S3 need keys: set AWS_ACCESS_KEY_ID and "
                              "AWS_SECRET_ACCESS_KEY, or name files with them in "
                              "AWS_ACCESS_KEY_ID_FILE and AWS_SECRET_ACCESS_KEY_FILE");
    if (token[0] != '\0')
        (void)snprintf(s3->token, sizeof s3->token, TOKEN "%s", token);
    (void)snprintf(s3->region, sizeof s3->region, "%s",
                   region != NULL && region[0] != '\0' ? region : "us-east-1");
    (void)snprintf(s3->sign, sizeof s3->sign, "aws:amz:%s:s3", s3->region);
    return VOR_OK;
}

/* Splits a URL into the bucket's and the prefix. */
static int read_url(struct vor_s3 *s3, const char *url)
{
    static const char styles[2][12] = {"?style=path", "?style=host"};
    const char *host = strstr(url, "://"), *bucket, *prefix, *style = strchr(url, '?');
    size_t length = style != NULL ? (size_t)(style - url) : strlen(url);

    if (style != NULL && strcmp(style, styles[0]) != 0 && strcmp(style, styles[1]) != 0)
        return 0;
    if (length + 2 > VOR_S3_URL_SIZE || host == NULL ||
        (strncmp(url, "http://", 7) != 0 && strncmp(url, "https://", 8) != 0))
        return 0;
    host += 3;
    bucket = host + strcspn(host, "/");
    if (bucket == host || memchr(host, '@', (size_t)(bucket - host)) != NULL || *bucket != '/')
        return 0;
    bucket++;
    prefix = bucket + strcspn(bucket, "/?");
    if (prefix == bucket || bucket + strspn(bucket, PLAIN) != url + length)
        return 0;
    (void)snprintf(s3->name, sizeof s3->name, "%.*s", (int)(prefix - bucket), bucket);
    if (style == NULL || strcmp(style, styles[1]) != 0)
        (void)snprintf(s3->bucket, sizeof s3->bucket, "%.*s", (int)(prefix - url), url);
    else
        (void)snprintf(s3->bucket, sizeof s3->bucket, "%.*s%s.%.*s", (int)(host - url), url,
                       s3->name, (int)(bucket - 1 - host), host);
    prefix += strspn(prefix, "/");
    length -= (size_t)(prefix - url);
    (void)snprintf(s3->prefix, sizeof s3->prefix, "%.*s%s", (int)length, prefix,
                   length == 0 || prefix[length - 1] == '/' ? "" : "/");
    return 1;
}

static void close_s3(struct vor_objects *objects)
{
    struct vor_s3 *s3 = (struct vor_s3 *)objects;

    for (int i = 0; i < s3->idles; i++)
        s3->curl->easy_cleanup(s3->idle[i]);
    vor_objects_destroy(&s3->base);
    explicit_bzero(s3->secret, sizeof s3->secret);
    free(s3);
}

static vor_status open_s3(struct vor_objects **out, const char *url, struct vor_error *err)
{
    struct vor_s3 *s3 = calloc(1, sizeof *s3);
    vor_status status;

    if (s3 == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a client of S3");
    vor_objects_init(&s3->base, &vor_s3_objects);
    status = read_url(s3, url)
                 ? read_keys(s3, err)
                 : vor_fail_param(err, VOR_E_IO, "blobs",
                                  "blobs is \"s3:%.80s\", want s3:https://HOST/BUCKET or "
                                  "s3:https://HOST/BUCKET/PREFIX, optionally followed by "
                                  "?style=host or ?style=path, without user or password; BUCKET "
                                  "and PREFIX may contain letters, digits, '.', '_' and '-'",
                                  strchr(url, '@') == NULL ? url : "...");
    VOR_THEN(status, vor_curl_load(&s3->curl, err));
    if (status != VOR_OK) {
        close_s3(&s3->base);
        return status;
    }
    *out = &s3->base;
    return VOR_OK;
}

/* --- the requests ----------------------------------------------------------------------------- */

static struct vor_s3 *of(struct vor_objects *objects)
{
    return (struct vor_s3 *)objects;
}

static void write_url(const struct vor_s3 *s3, const char *key, char out[PATH_SIZE])
{
    (void)snprintf(out, PATH_SIZE, "%s/%s%.*s", s3->bucket, s3->prefix, VOR_OBJECT_KEY_MAX, key);
}

/* A request for one object; 404 is no failure for those who can be told by `found`. */
static vor_status ask(struct vor_s3_call *call, const char *key, int *found, struct vor_error *err)
{
    char url[PATH_SIZE];
    vor_status status;

    write_url(call->s3, key, url);
    call->url = url;
    vor_text_init(&call->text, TEXT_MAX);
    status = vor_s3_perform(call, err);
    if (found != NULL)
        *found = call->http != 404;
    else if (status == VOR_OK && call->http == 404)
        status = vor_s3_fail(call, err);
    vor_text_free(&call->text);
    call->url = NULL;
    return status;
}

#define UNSIGNED "x-amz-content-sha256: UNSIGNED-PAYLOAD"

static vor_status put(struct vor_objects *objects, const char *key,
                      const struct vor_object_bytes *bytes, struct vor_error *err)
{
    char digest[128];
    struct vor_s3_call call = {.s3 = of(objects),
                               .verb = "put",
                               .method = "PUT",
                               .is_put = 1,
                               .fd = bytes->fd,
                               .size = bytes->size,
                               .patience = bytes->patience,
                               .header = {digest, "Content-Type: application/octet-stream"}};

    if (bytes->size > VOR_S3_PART) {
        char url[PATH_SIZE];

        write_url(call.s3, key, url);
        return vor_s3_put_parts(call.s3, url, bytes, err);
    }
    (void)snprintf(digest, sizeof digest, "x-amz-content-sha256: %s", bytes->sha256);
    return ask(&call, key, NULL, err);
}

static vor_status remove_one(struct vor_objects *objects, const char *key, struct vor_error *err)
{
    struct vor_s3_call call = {
        .s3 = of(objects), .verb = "delete", .method = "DELETE", .fd = -1, .header = {UNSIGNED}};
    int found;

    return ask(&call, key, &found, err);
}

static vor_status get(struct vor_objects *objects, const char *key,
                      const struct vor_object_reader *reader, uint64_t *size, int *found,
                      struct vor_error *err)
{
    struct vor_s3_call call = {.s3 = of(objects),
                               .verb = reader != NULL ? "get" : "head",
                               .method = reader != NULL ? "GET" : "HEAD",
                               .fd = -1,
                               .reader = reader,
                               .header = {UNSIGNED}};
    char range[64];
    int is_there = 0;
    vor_status status;

    if (reader != NULL && reader->to != UINT64_MAX) {
        (void)snprintf(range, sizeof range, "Range: bytes=%" PRIu64 "-%" PRIu64, reader->from,
                       reader->to - 1);
        call.header[1] = range;
    }
    status = ask(&call, key, &is_there, err);
    *found = is_there;
    *size = status == VOR_OK && is_there ? (uint64_t)call.length : 0;
    return status;
}

static vor_status link_to(struct vor_objects *objects, const char *base, const char *key,
                          const struct vor_blob_reading *reading, struct vor_text *out,
                          struct vor_error *err)
{
    const struct vor_s3 *s3 = of(objects);
    struct vor_s3_signing signing = {.method = reading->method,
                                     .key_id = s3->key_id,
                                     .secret = s3->secret,
                                     .token = s3->token[0] != '\0' ? s3->token + strlen(TOKEN) : "",
                                     .region = s3->region,
                                     .at = vor_clock_wall_ms() / 1000,
                                     .seconds = VOR_BLOB_LINK_SECONDS};
    struct vor_text url, query;

    vor_text_init(&url, 0);
    vor_text_init(&query, 0);
    vor_text_printf(&url, "%s%s%s%s", base, base[strlen(base) - 1] == '/' ? "" : "/", s3->prefix,
                    key);
    vor_text_puts(&query, "&response-content-disposition=");
    vor_text_escape(&query, reading->disposition);
    vor_text_puts(&query, "&response-content-type=");
    vor_text_escape(&query, reading->media_type);
    signing.url = url.data;
    signing.query = query.data;
    if (url.failed || query.failed)
        out->failed = 1;
    else
        vor_s3_sign(&signing, out);
    vor_text_free(&url);
    vor_text_free(&query);
    return vor_text_status(out, err);
}

/* Calls each for the objects of one answer. */
static void read_page(const char *xml, size_t hidden, void (*each)(void *ctx, const char *key),
                      void *ctx)
{
    static const char begin[] = "<Contents>";
    char key[PATH_SIZE];

    for (const char *at = xml; (at = strstr(at, begin)) != NULL; at += sizeof begin - 1) {
        vor_s3_element(at, "Key", key, sizeof key);
        if (strlen(key) >= hidden && strlen(key + hidden) <= VOR_OBJECT_KEY_MAX &&
            strspn(key + hidden, PLAIN) == strlen(key + hidden))
            each(ctx, key + hidden);
    }
}

/* One answer of a listing, from where the last one ended; *more: there is another one. */
static vor_status list_page(struct vor_s3_call *call, const char *prefix,
                            char token[VOR_S3_URL_SIZE], int *more, struct vor_error *err)
{
    const struct vor_curl *curl = call->s3->curl;
    char *from = curl->easy_escape(NULL, token, 0), *below = curl->easy_escape(NULL, prefix, 0);
    char url[8 * PATH_SIZE], truncated[8];
    vor_status status;

    if (from == NULL || below == NULL) {
        curl->free(from);
        curl->free(below);
        return vor_fail(err, VOR_E_NOMEM, "a request to S3");
    }
    /* In the order of names, as they are signed. */
    (void)snprintf(url, sizeof url, "%s/?%s%s%slist-type=2&prefix=%s", call->s3->bucket,
                   token[0] != '\0' ? "continuation-token=" : "", from, token[0] != '\0' ? "&" : "",
                   below);
    curl->free(from);
    curl->free(below);
    call->url = url;
    status = vor_s3_perform(call, err);
    call->url = NULL;
    if (status == VOR_OK && call->http == 404)
        status = vor_s3_fail(call, err);
    if (status != VOR_OK)
        return status;
    vor_s3_element(call->text.data, "IsTruncated", truncated, sizeof truncated);
    vor_s3_element(call->text.data, "NextContinuationToken", token, VOR_S3_URL_SIZE);
    *more = strcmp(truncated, "true") == 0 && token[0] != '\0';
    return VOR_OK;
}

static vor_status list(struct vor_s3_call *call, const char *begin,
                       void (*each)(void *ctx, const char *key), void *ctx, struct vor_error *err)
{
    char prefix[PATH_SIZE], token[VOR_S3_URL_SIZE] = "";
    vor_status status = VOR_OK;

    (void)snprintf(prefix, sizeof prefix, "%s%.*s", call->s3->prefix, VOR_OBJECT_KEY_MAX, begin);
    vor_text_init(&call->text, TEXT_MAX);
    for (int more = 1; status == VOR_OK && more;) {
        status = list_page(call, prefix, token, &more, err);
        if (status == VOR_OK)
            read_page(call->text.data, strlen(prefix), each, ctx);
    }
    vor_text_free(&call->text);
    return status;
}

#define LIST_CALL                                                                                  \
    .verb = "list", .method = "GET", .fd = -1, .ends = "</ListBucketResult>", .header = {UNSIGNED}

static vor_status list_all(struct vor_objects *objects, const char *begin,
                           void (*each)(void *ctx, const char *key), void *ctx,
                           struct vor_error *err)
{
    struct vor_s3_call call = {.s3 = of(objects), LIST_CALL};

    return list(&call, begin, each, ctx, err);
}

static void ignore(VOR_UNUSED void *ctx, VOR_UNUSED const char *key)
{
}

static vor_status probe(struct vor_objects *objects, struct vor_error *err)
{
    struct vor_s3_call call = {.s3 = of(objects), .is_once = 1, .is_probe = 1, LIST_CALL};

    return list(&call, "none/", ignore, NULL, err);
}

const struct vor_objects_kind vor_s3_objects = {
    .scheme = "s3",
    .open = open_s3,
    .close = close_s3,
    .put = put,
    .get = get,
    .remove = remove_one,
    .list = list_all,
    .probe = probe,
    .link = link_to,
};
