#include "server/blob/s3_request.h"

#include "server/base/clock.h"
#include "server/base/metrics.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum {
    STALL_SECONDS = 30,
    PROBE_SECONDS = 5 /* a probe takes at most so long */
};

static CURL *take_handle(struct vor_s3 *s3)
{
    CURL *handle = NULL;

    pthread_mutex_lock(&s3->base.mutex);
    if (s3->idles > 0)
        handle = s3->idle[--s3->idles];
    pthread_mutex_unlock(&s3->base.mutex);
    return handle != NULL ? handle : s3->curl->easy_init();
}

static void give_handle(struct vor_s3 *s3, CURL *handle)
{
    pthread_mutex_lock(&s3->base.mutex);
    if (s3->idles < VOR_S3_IDLE_MAX) {
        s3->idle[s3->idles++] = handle;
        handle = NULL;
    }
    pthread_mutex_unlock(&s3->base.mutex);
    if (handle != NULL)
        s3->curl->easy_cleanup(handle);
}

static size_t on_send(char *bytes, size_t unit, size_t count, void *ctx)
{
    struct vor_s3_call *call = ctx;
    uint64_t left = call->size - call->at;
    size_t size = unit * count < left ? unit * count : (size_t)left;
    ssize_t got;

    do
        got = size > 0 ? pread(call->fd, bytes, size, (off_t)(call->from + call->at)) : 0;
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
    ((struct vor_s3_call *)ctx)->at = (uint64_t)offset;
    return CURL_SEEKFUNC_OK;
}

static size_t on_bytes(char *bytes, size_t unit, size_t count, void *ctx)
{
    struct vor_s3_call *call = ctx;
    size_t size = unit * count;
    long http = 0;

    (void)call->s3->curl->easy_getinfo(call->handle, CURLINFO_RESPONSE_CODE, &http);
    if ((http != 200 && http != 206) || call->reader == NULL) {
        vor_text_add(&call->text, bytes, size);
        return call->text.failed ? CURL_WRITEFUNC_ERROR : size;
    }
    call->is_stopped = !call->reader->take(
        call->reader->ctx, call->at + (http == 206 ? call->reader->from : 0), bytes, size);
    call->at += size;
    return call->is_stopped ? CURL_WRITEFUNC_ERROR : size;
}

/* Called once a second or more often. */
static int on_wait(void *ctx, VOR_UNUSED curl_off_t to_come, VOR_UNUSED curl_off_t have,
                   VOR_UNUSED curl_off_t to_send, VOR_UNUSED curl_off_t sent)
{
    struct vor_s3_call *call = ctx;

    return !vor_objects_are_wanted(&call->s3->base, call->patience, call->began);
}

static int set_headers(struct vor_s3_call *call, struct curl_slist **list)
{
    const char *all[] = {call->header[0], call->header[1], call->header[2],
                         call->s3->token[0] != '\0' ? call->s3->token : NULL};

    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        if (all[i] != NULL && !vor_curl_add(list, all[i]))
            return 0;
    return call->s3->curl->easy_setopt(call->handle, CURLOPT_HTTPHEADER, *list) == CURLE_OK;
}

static CURLcode perform_once(struct vor_s3_call *call)
{
    const struct vor_curl *curl = call->s3->curl;
    struct curl_slist *headers = NULL;
    CURLcode code = CURLE_OUT_OF_MEMORY;
    CURL *handle = call->handle;

    call->at = 0;
    call->http = 0;
    vor_text_clear(&call->text);
    vor_curl_begin(handle, call->url, call->why);
    curl->easy_setopt(handle, CURLOPT_AWS_SIGV4, call->s3->sign);
    curl->easy_setopt(handle, CURLOPT_USERNAME, call->s3->key_id);
    curl->easy_setopt(handle, CURLOPT_PASSWORD, call->s3->secret);
    curl->easy_setopt(handle, CURLOPT_TIMEOUT, call->is_once ? (long)PROBE_SECONDS : 0L);
    curl->easy_setopt(handle, CURLOPT_XFERINFOFUNCTION, on_wait);
    curl->easy_setopt(handle, CURLOPT_XFERINFODATA, call);
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
    } else if (call->body != NULL) {
        curl->easy_setopt(handle, CURLOPT_POSTFIELDS, call->body);
    } else if (strcmp(call->method, "HEAD") == 0) {
        curl->easy_setopt(handle, CURLOPT_NOBODY, 1L);
    } else {
        curl->easy_setopt(handle, CURLOPT_CUSTOMREQUEST, call->method);
    }
    if (set_headers(call, &headers))
        code = curl->easy_perform(handle);
    (void)curl->easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &call->http);
    (void)curl->easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &call->length);
    (void)snprintf(call->etag, sizeof call->etag, "%s", vor_curl_header(handle, "ETag"));
    curl->slist_free_all(headers);
    return code;
}

/* An answer that ended too soon: curl takes one that is cut in its head for whole. An object has a
 * length, and a document ends; one that was begun with 200 may turn out to be an error. */
static int is_cut(const struct vor_s3_call *call)
{
    if (call->http != 200 && call->http != 206)
        return 0;
    if (call->ends != NULL)
        return call->text.data == NULL || strstr(call->text.data, call->ends) == NULL;
    if (call->is_put)
        return 0;
    if (call->reader != NULL)
        return call->length < 0 || call->at != (uint64_t)call->length;
    return strcmp(call->method, "HEAD") == 0 && call->length < 0;
}

/* May the same request succeed a little later? */
static int is_passing(const struct vor_s3_call *call, CURLcode code)
{
    switch (code) {
    case CURLE_OK:
        return call->http >= 500 || call->http == 429 || call->http == 408 || is_cut(call) ||
               (call->http == 400 && call->text.data != NULL && /* the connection was too slow */
                strstr(call->text.data, "<Code>RequestTimeout</Code>") != NULL);
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

void vor_s3_element(const char *xml, const char *name, char *out, size_t size)
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

/* Fails with what can be told apart later: S3 is away (EAGAIN), or refuses us (EKEYREJECTED). */
static vor_status fail(const struct vor_s3_call *call, CURLcode code, struct vor_error *err)
{
    const struct vor_s3 *s3 = call->s3;
    char reason[80] = "";
    int number = is_passing(call, code) || code == CURLE_ABORTED_BY_CALLBACK ? EAGAIN : 0;

    if (code == CURLE_OUT_OF_MEMORY)
        return vor_fail(err, VOR_E_NOMEM, "a request to S3");
    if (code != CURLE_OK) {
        (void)vor_fail(err, VOR_E_IO, "S3 at %.200s: %.200s", s3->bucket,
                       call->why[0] != '\0' ? call->why : s3->curl->easy_strerror(code));
    } else {
        if (call->text.data != NULL)
            vor_s3_element(call->text.data, "Code", reason, sizeof reason);
        if (call->http / 100 == 4 && number == 0)
            number = EKEYREJECTED;
        (void)vor_fail(err, VOR_E_IO, "S3 at %.200s answered %s with status %ld%s%s%s", s3->bucket,
                       call->method, call->http, reason[0] != '\0' ? " " : "", reason,
                       is_cut(call) ? " and not all that belongs to it" : "");
    }
    if (err != NULL)
        err->got = (uint64_t)number;
    return VOR_E_IO;
}

vor_status vor_s3_fail(const struct vor_s3_call *call, struct vor_error *err)
{
    return fail(call, CURLE_OK, err);
}

vor_status vor_s3_perform(struct vor_s3_call *call, struct vor_error *err)
{
    struct vor_s3 *s3 = call->s3;
    struct vor_error failure = {.status = VOR_OK};
    char reason[80] = "";
    CURLcode code = CURLE_OUT_OF_MEMORY;
    double began = vor_clock_seconds();

    call->handle = take_handle(s3);
    if (call->handle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a request to S3");
    for (int i = 0;; i++) {
        call->began = vor_clock_seconds();
        code = perform_once(call);
        vor_metric_observe(VOR_METRIC_BLOB_SECONDS, vor_clock_seconds() - call->began,
                           VOR_LABELS("s3", call->verb));
        if (!is_passing(call, code) || call->is_once ||
            !vor_objects_again(&call->s3->base, i, began))
            break;
    }
    give_handle(s3, call->handle);
    if (call->text.data != NULL && call->http == 404)
        vor_s3_element(call->text.data, "Code", reason, sizeof reason);
    if (code != CURLE_OK || is_cut(call) || (call->http / 100 != 2 && call->http != 404) ||
        strcmp(reason, "NoSuchBucket") == 0)
        (void)fail(call, code, &failure);
    if (failure.status != VOR_E_NOMEM && !call->is_stopped && code != CURLE_ABORTED_BY_CALLBACK)
        vor_objects_note(&s3->base, &failure, call->is_probe);
    if (failure.status != VOR_OK && err != NULL)
        *err = failure;
    return failure.status;
}
