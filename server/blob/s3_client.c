#include "server/blob/s3_client.h"

#include "proto/text.h"
#include "server/base/curl_library.h"
#include "server/base/disk.h"
#include "server/base/uuid.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    TRIES = 6,
    FIRST_PAUSE_MS = 100,
    CONNECT_SECONDS = 10,
    STALL_SECONDS = 30,
    IDLE_MAX = 8,       /* connections that are kept open */
    URL_SIZE = 512,     /* of the bucket, with the prefix */
    SECRET_SIZE = 4096, /* of a session token: some 1,000 bytes */
    TEXT_MAX = 8 << 20, /* of an answer that is no object: 1,000 keys take .5 MB */
    PATH_SIZE = 2 * URL_SIZE + VOR_S3_KEY_MAX + 2,
    HEADER_SIZE = SECRET_SIZE + 32
};

#define PLAIN "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._/-"

struct vor_s3 {
    const struct vor_curl *curl;
    char bucket[URL_SIZE]; /* "https://HOST/BUCKET" */
    char prefix[URL_SIZE]; /* "" or "PART/PART/" */
    char key_id[SECRET_SIZE], secret[SECRET_SIZE];
    char token[HEADER_SIZE]; /* a header; "" for none */
    char sign[96];           /* what CURLOPT_AWS_SIGV4 takes */
    pthread_mutex_t mutex;
    CURL *idle[IDLE_MAX];
    int idles;
};

/* A request and its answer. */
struct call {
    struct vor_s3 *s3;
    CURL *handle;
    const char *method; /* not PUT: GET, HEAD, DELETE */
    const char *url;
    const char *header[3]; /* NULL: none */
    int fd;                /* of the bytes that are sent or received; -1 for none */
    uint64_t size, at;     /* of those that are sent; where the next one stands */
    int is_put;            /* else bytes are received */
    struct vor_text text;  /* an answer that is no object */
    vor_status status;     /* of a write that failed; its errno */
    int number;
    long http;
    curl_off_t length; /* of the answer, as it was declared */
    char why[CURL_ERROR_SIZE];
};

/* --- opening ---------------------------------------------------------------------------------- */

static vor_status read_secret_file(char out[SECRET_SIZE], const char *path, struct vor_error *err)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t size = fd >= 0 ? read(fd, out, SECRET_SIZE - 1) : -1;
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
static vor_status read_secret(char out[SECRET_SIZE], const char *variable, struct vor_error *err)
{
    const char *value = getenv(variable), *path;
    char file[64];

    out[0] = '\0';
    (void)snprintf(file, sizeof file, "%s_FILE", variable);
    path = getenv(file);
    if (value == NULL)
        return path != NULL ? read_secret_file(out, path, err) : VOR_OK;
    if (strlen(value) >= SECRET_SIZE)
        return vor_fail_param(err, VOR_E_PARAM, "blobs", "%s has %zu bytes, want at most %d",
                              variable, strlen(value), SECRET_SIZE - 1);
    memcpy(out, value, strlen(value) + 1);
    return VOR_OK;
}

static vor_status read_keys(struct vor_s3 *s3, struct vor_error *err)
{
    const char *region = getenv("AWS_REGION");
    char token[SECRET_SIZE];
    vor_status status = read_secret(s3->key_id, "AWS_ACCESS_KEY_ID", err);

    if (status == VOR_OK)
        status = read_secret(s3->secret, "AWS_SECRET_ACCESS_KEY", err);
    if (status == VOR_OK)
        status = read_secret(token, "AWS_SESSION_TOKEN", err);
    if (status != VOR_OK)
        return status;
    if (s3->key_id[0] == '\0' || s3->secret[0] == '\0')
        return vor_fail_param(err, VOR_E_PARAM, "blobs",
                              "blobs in S3 need keys: set AWS_ACCESS_KEY_ID and "
                              "AWS_SECRET_ACCESS_KEY, or name files with them in "
                              "AWS_ACCESS_KEY_ID_FILE and AWS_SECRET_ACCESS_KEY_FILE");
    if (token[0] != '\0')
        (void)snprintf(s3->token, sizeof s3->token, "x-amz-security-token: %s", token);
    (void)snprintf(s3->sign, sizeof s3->sign, "aws:amz:%.64s:s3",
                   region != NULL && region[0] != '\0' ? region : "us-east-1");
    return VOR_OK;
}

/* Splits a URL into the bucket's and the prefix. */
static int read_url(struct vor_s3 *s3, const char *url)
{
    const char *host = strstr(url, "://"), *bucket, *prefix;
    size_t length = strlen(url);

    if (length + 2 > URL_SIZE || host == NULL ||
        (strncmp(url, "http://", 7) != 0 && strncmp(url, "https://", 8) != 0))
        return 0;
    host += 3;
    bucket = host + strcspn(host, "/");
    if (bucket == host || memchr(host, '@', (size_t)(bucket - host)) != NULL || *bucket != '/')
        return 0;
    bucket++;
    prefix = bucket + strcspn(bucket, "/");
    if (prefix == bucket || strspn(bucket, PLAIN) != strlen(bucket))
        return 0;
    (void)snprintf(s3->bucket, sizeof s3->bucket, "%.*s", (int)(prefix - url), url);
    prefix += strspn(prefix, "/");
    length = strlen(prefix);
    (void)snprintf(s3->prefix, sizeof s3->prefix, "%s%s", prefix,
                   length == 0 || prefix[length - 1] == '/' ? "" : "/");
    return 1;
}

vor_status vor_s3_open(struct vor_s3 **out, const char *url, struct vor_error *err)
{
    struct vor_s3 *s3 = calloc(1, sizeof *s3);
    vor_status status;

    if (s3 == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a client of S3");
    pthread_mutex_init(&s3->mutex, NULL);
    status = read_url(s3, url)
                 ? read_keys(s3, err)
                 : vor_fail_param(err, VOR_E_PARAM, "blobs",
                                  "blobs is \"s3:%.80s\", want s3:https://HOST/BUCKET or "
                                  "s3:https://HOST/BUCKET/PREFIX, with letters, digits, '.', '_' "
                                  "and '-' in both, and no user or password",
                                  strchr(url, '@') == NULL ? url : "...");
    if (status == VOR_OK)
        status = vor_curl_load(&s3->curl, err);
    if (status != VOR_OK) {
        vor_s3_close(s3);
        return status;
    }
    *out = s3;
    return VOR_OK;
}

void vor_s3_close(struct vor_s3 *s3)
{
    if (s3 == NULL)
        return;
    for (int i = 0; i < s3->idles; i++)
        s3->curl->easy_cleanup(s3->idle[i]);
    pthread_mutex_destroy(&s3->mutex);
    explicit_bzero(s3->secret, sizeof s3->secret);
    free(s3);
}

/* --- one request ------------------------------------------------------------------------------ */

static CURL *take_handle(struct vor_s3 *s3)
{
    CURL *handle = NULL;

    pthread_mutex_lock(&s3->mutex);
    if (s3->idles > 0)
        handle = s3->idle[--s3->idles];
    pthread_mutex_unlock(&s3->mutex);
    return handle != NULL ? handle : s3->curl->easy_init();
}

static void give_handle(struct vor_s3 *s3, CURL *handle)
{
    pthread_mutex_lock(&s3->mutex);
    if (s3->idles < IDLE_MAX) {
        s3->idle[s3->idles++] = handle;
        handle = NULL;
    }
    pthread_mutex_unlock(&s3->mutex);
    if (handle != NULL)
        s3->curl->easy_cleanup(handle);
}

static size_t on_send(char *bytes, size_t unit, size_t count, void *ctx)
{
    struct call *call = ctx;
    uint64_t left = call->size - call->at;
    size_t size = unit * count < left ? unit * count : (size_t)left;
    ssize_t got;

    do
        got = size > 0 ? pread(call->fd, bytes, size, (off_t)call->at) : 0;
    while (got < 0 && errno == EINTR);
    if (got < 0)
        return CURL_READFUNC_ABORT;
    call->at += (uint64_t)got;
    return (size_t)got;
}

/* curl calls this when a kept connection is dead and it must send the bytes again. */
static int on_rewind(void *ctx, curl_off_t offset, int origin)
{
    if (origin != SEEK_SET)
        return CURL_SEEKFUNC_CANTSEEK;
    ((struct call *)ctx)->at = (uint64_t)offset;
    return CURL_SEEKFUNC_OK;
}

static size_t on_bytes(char *bytes, size_t unit, size_t count, void *ctx)
{
    struct call *call = ctx;
    size_t size = unit * count;
    long http = 0;

    (void)call->s3->curl->easy_getinfo(call->handle, CURLINFO_RESPONSE_CODE, &http);
    if (http != 200 || call->fd < 0 || call->is_put) {
        vor_text_add(&call->text, bytes, size);
        return call->text.failed ? CURL_WRITEFUNC_ERROR : size;
    }
    for (size_t done = 0; done < size;) {
        ssize_t wrote = write(call->fd, bytes + done, size - done);

        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote < 0) {
            call->number = errno;
            return CURL_WRITEFUNC_ERROR;
        }
        done += (size_t)wrote;
    }
    call->at += size;
    return size;
}

static int set_headers(struct call *call, struct curl_slist **list)
{
    const struct vor_curl *curl = call->s3->curl;

    const char *all[] = {call->header[0], call->header[1], call->header[2],
                         call->s3->token[0] != '\0' ? call->s3->token : NULL};

    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        struct curl_slist *longer = all[i] != NULL ? curl->slist_append(*list, all[i]) : *list;

        if (longer == NULL && all[i] != NULL)
            return 0;
        *list = longer;
    }
    return curl->easy_setopt(call->handle, CURLOPT_HTTPHEADER, *list) == CURLE_OK;
}

static CURLcode perform_once(struct call *call)
{
    const struct vor_curl *curl = call->s3->curl;
    struct curl_slist *headers = NULL;
    CURLcode code = CURLE_OUT_OF_MEMORY;
    CURL *handle = call->handle;

    call->at = 0;
    call->http = 0;
    vor_text_clear(&call->text);
    call->why[0] = '\0';
    curl->easy_reset(handle);
    curl->easy_setopt(handle, CURLOPT_URL, call->url);
    curl->easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
    curl->easy_setopt(handle, CURLOPT_USERAGENT, "voronoid/" VOR_VERSION);
    curl->easy_setopt(handle, CURLOPT_AWS_SIGV4, call->s3->sign);
    curl->easy_setopt(handle, CURLOPT_USERNAME, call->s3->key_id);
    curl->easy_setopt(handle, CURLOPT_PASSWORD, call->s3->secret);
    curl->easy_setopt(handle, CURLOPT_ERRORBUFFER, call->why);
    curl->easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
    curl->easy_setopt(handle, CURLOPT_CONNECTTIMEOUT, (long)CONNECT_SECONDS);
    curl->easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl->easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, (long)STALL_SECONDS);
    curl->easy_setopt(handle, CURLOPT_WRITEFUNCTION, on_bytes);
    curl->easy_setopt(handle, CURLOPT_WRITEDATA, call);
    if (call->is_put) {
        curl->easy_setopt(handle, CURLOPT_UPLOAD, 1L);
        curl->easy_setopt(handle, CURLOPT_INFILESIZE_LARGE, (curl_off_t)call->size);
        curl->easy_setopt(handle, CURLOPT_READFUNCTION, on_send);
        curl->easy_setopt(handle, CURLOPT_READDATA, call);
        curl->easy_setopt(handle, CURLOPT_SEEKFUNCTION, on_rewind);
        curl->easy_setopt(handle, CURLOPT_SEEKDATA, call);
    } else if (strcmp(call->method, "HEAD") == 0) {
        curl->easy_setopt(handle, CURLOPT_NOBODY, 1L);
    } else {
        curl->easy_setopt(handle, CURLOPT_CUSTOMREQUEST, call->method);
    }
    if (set_headers(call, &headers))
        code = curl->easy_perform(handle);
    (void)curl->easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &call->http);
    (void)curl->easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &call->length);
    curl->slist_free_all(headers);
    return code;
}

/* An answer that ended too soon: curl takes one that is cut in its head for whole. An object has a
 * length, and a list ends. */
static int is_cut(const struct call *call)
{
    if (call->http != 200 || call->is_put)
        return 0;
    if (call->fd >= 0)
        return call->length < 0 || call->at != (uint64_t)call->length;
    if (strcmp(call->method, "HEAD") == 0)
        return call->length < 0;
    return call->text.data == NULL || strstr(call->text.data, "</ListBucketResult>") == NULL;
}

/* May the same request succeed a little later? */
static int is_passing(const struct call *call, CURLcode code)
{
    switch (code) {
    case CURLE_OK:
        return call->http >= 500 || call->http == 429 || call->http == 408 || is_cut(call);
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_CONNECT:
    case CURLE_PARTIAL_FILE:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_SSL_CONNECT_ERROR:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_WEIRD_SERVER_REPLY:
        return 1;
    default:
        return 0;
    }
}

/* A half to the whole of a pause that doubles. */
static void wait_before(int attempt)
{
    uint8_t part = 0;
    int64_t ms = (int64_t)FIRST_PAUSE_MS << attempt;
    struct timespec pause;

    (void)(vor_random_fill(&part, sizeof part, NULL) == VOR_OK);
    ms -= ms / 2 * part / 255;
    pause = (struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    while (nanosleep(&pause, &pause) != 0 && errno == EINTR)
        continue;
}

/* The text of an element of an answer, "" when it has none. */
static void read_element(const char *xml, const char *name, char *out, size_t size)
{
    char open_tag[40];
    const char *at;

    (void)snprintf(open_tag, sizeof open_tag, "<%s>", name);
    at = strstr(xml, open_tag);
    out[0] = '\0';
    if (at != NULL)
        (void)snprintf(out, size, "%.*s", (int)strcspn(at + strlen(open_tag), "<\r\n"),
                       at + strlen(open_tag));
}

static vor_status fail(const struct call *call, CURLcode code, struct vor_error *err)
{
    const struct vor_s3 *s3 = call->s3;
    char reason[80] = "";

    if (code == CURLE_OUT_OF_MEMORY)
        return vor_fail(err, VOR_E_NOMEM, "a request to S3");
    if (call->number != 0)
        return vor_fail_errno(err, call->number, "a temporary file");
    if (code != CURLE_OK)
        return vor_fail(err, VOR_E_IO, "S3 at %.200s: %.200s", s3->bucket,
                        call->why[0] != '\0' ? call->why : s3->curl->easy_strerror(code));
    if (call->text.data != NULL)
        read_element(call->text.data, "Code", reason, sizeof reason);
    return vor_fail(err, VOR_E_IO, "S3 at %.200s answered %s with status %ld%s%s%s", s3->bucket,
                    call->method, call->http, reason[0] != '\0' ? " " : "", reason,
                    is_cut(call) ? " and not all that belongs to it" : "");
}

/* Sends a request until it is answered with less than 500. VOR_OK: with 2xx or 404. */
static vor_status perform(struct call *call, struct vor_error *err)
{
    struct vor_s3 *s3 = call->s3;
    CURLcode code = CURLE_OUT_OF_MEMORY;

    call->handle = take_handle(s3);
    if (call->handle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a request to S3");
    for (int i = 0; i < TRIES; i++) {
        if (i > 0)
            wait_before(i - 1);
        /* What an attempt has written is not part of the next one. */
        if (i > 0 && call->fd >= 0 && !call->is_put &&
            (ftruncate(call->fd, 0) != 0 || lseek(call->fd, 0, SEEK_SET) != 0))
            call->number = errno;
        if (call->number != 0)
            break;
        code = perform_once(call);
        if (!is_passing(call, code))
            break;
    }
    give_handle(s3, call->handle);
    if (code == CURLE_OK && !is_cut(call) && (call->http / 100 == 2 || call->http == 404))
        return VOR_OK;
    return fail(call, code, err);
}

/* --- the requests ----------------------------------------------------------------------------- */

static void write_url(const struct vor_s3 *s3, const char *key, char out[PATH_SIZE])
{
    (void)snprintf(out, PATH_SIZE, "%s/%s%.*s", s3->bucket, s3->prefix, VOR_S3_KEY_MAX, key);
}

/* A request for one object; 404 is no failure for those who can be told by `found`. */
static vor_status ask(struct call *call, const char *key, int *found, struct vor_error *err)
{
    char url[PATH_SIZE], reason[80] = "";
    vor_status status;

    write_url(call->s3, key, url);
    call->url = url;
    vor_text_init(&call->text, TEXT_MAX);
    status = perform(call, err);
    if (call->text.data != NULL)
        read_element(call->text.data, "Code", reason, sizeof reason);
    if (found != NULL)
        *found = call->http != 404;
    if (status == VOR_OK && call->http == 404 &&
        (found == NULL || strcmp(reason, "NoSuchBucket") == 0))
        status = fail(call, CURLE_OK, err);
    vor_text_free(&call->text);
    call->url = NULL;
    return status;
}

#define UNSIGNED "x-amz-content-sha256: UNSIGNED-PAYLOAD"

vor_status vor_s3_put(struct vor_s3 *s3, const char *key, int fd, uint64_t size, const char *sha256,
                      struct vor_error *err)
{
    char digest[128];
    struct call call = {.s3 = s3,
                        .method = "PUT",
                        .is_put = 1,
                        .fd = fd,
                        .size = size,
                        .header = {digest, "Content-Type: application/octet-stream"}};

    (void)snprintf(digest, sizeof digest, "x-amz-content-sha256: %s", sha256);
    return ask(&call, key, NULL, err);
}

vor_status vor_s3_copy(struct vor_s3 *s3, const char *from, const char *to, struct vor_error *err)
{
    char source[PATH_SIZE + 32];
    struct call call = {
        .s3 = s3, .method = "PUT", .is_put = 1, .fd = -1, .header = {UNSIGNED, source}};

    (void)snprintf(source, sizeof source, "x-amz-copy-source: %s/%s%.*s", strrchr(s3->bucket, '/'),
                   s3->prefix, VOR_S3_KEY_MAX, from);
    return ask(&call, to, NULL, err);
}

vor_status vor_s3_get(struct vor_s3 *s3, const char *key, int fd, uint64_t *size, int *found,
                      struct vor_error *err)
{
    struct call call = {
        .s3 = s3, .method = fd >= 0 ? "GET" : "HEAD", .fd = fd, .header = {UNSIGNED}};
    vor_status status = ask(&call, key, found, err);

    *size = status == VOR_OK && *found ? (uint64_t)call.length : 0;
    return status;
}

vor_status vor_s3_delete(struct vor_s3 *s3, const char *key, struct vor_error *err)
{
    struct call call = {.s3 = s3, .method = "DELETE", .fd = -1, .header = {UNSIGNED}};
    int found;

    return ask(&call, key, &found, err);
}

/* The time of "2026-11-27T04:58:22.000Z"; 0 when it is none. */
static int64_t read_time(const char *text)
{
    struct tm tm = {0};

    if (sscanf(text, "%4d-%2d-%2dT%2d:%2d:%2d", &tm.tm_year, &tm.tm_mon, &tm.tm_mday, &tm.tm_hour,
               &tm.tm_min, &tm.tm_sec) != 6)
        return 0;
    tm.tm_year -= 1900;
    tm.tm_mon -= 1;
    return (int64_t)timegm(&tm) * 1000;
}

/* Calls each for the objects of one answer. */
static void read_page(const char *xml, size_t hidden,
                      void (*each)(void *ctx, const struct vor_s3_object *object), void *ctx)
{
    static const char begin[] = "<Contents>";
    char key[PATH_SIZE], text[64];

    for (const char *at = xml; (at = strstr(at, begin)) != NULL; at += sizeof begin - 1) {
        struct vor_s3_object object = {.key = key + hidden};

        read_element(at, "Key", key, sizeof key);
        if (strlen(key) < hidden || strlen(object.key) > VOR_S3_KEY_MAX ||
            strspn(object.key, PLAIN) != strlen(object.key))
            continue;
        read_element(at, "Size", text, sizeof text);
        object.size = strtoull(text, NULL, 10);
        read_element(at, "LastModified", text, sizeof text);
        object.modified_ms = read_time(text);
        each(ctx, &object);
    }
}

/* One answer of a listing, from where the last one ended; *more: there is another one. */
static vor_status list_page(struct call *call, const char *prefix, char token[URL_SIZE], int *more,
                            struct vor_error *err)
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
    (void)snprintf(url, sizeof url, "%s?%s%s%slist-type=2&prefix=%s", call->s3->bucket,
                   token[0] != '\0' ? "continuation-token=" : "", from, token[0] != '\0' ? "&" : "",
                   below);
    curl->free(from);
    curl->free(below);
    call->url = url;
    status = perform(call, err);
    call->url = NULL;
    if (status == VOR_OK && call->http == 404)
        status = fail(call, CURLE_OK, err);
    if (status != VOR_OK)
        return status;
    read_element(call->text.data, "IsTruncated", truncated, sizeof truncated);
    read_element(call->text.data, "NextContinuationToken", token, URL_SIZE);
    *more = strcmp(truncated, "true") == 0 && token[0] != '\0';
    return VOR_OK;
}

vor_status vor_s3_list(struct vor_s3 *s3, const char *begin,
                       void (*each)(void *ctx, const struct vor_s3_object *object), void *ctx,
                       struct vor_error *err)
{
    struct call call = {.s3 = s3, .method = "GET", .fd = -1, .header = {UNSIGNED}};
    char prefix[PATH_SIZE], token[URL_SIZE] = "";
    vor_status status = VOR_OK;

    (void)snprintf(prefix, sizeof prefix, "%s%.*s", s3->prefix, VOR_S3_KEY_MAX, begin);
    vor_text_init(&call.text, TEXT_MAX);
    for (int more = 1; status == VOR_OK && more;) {
        status = list_page(&call, prefix, token, &more, err);
        if (status == VOR_OK)
            read_page(call.text.data, strlen(prefix), each, ctx);
    }
    vor_text_free(&call.text);
    return status;
}
