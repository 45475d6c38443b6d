#include "server/cli/remote.h"

#include "server/base/address.h"
#include "server/base/curl_library.h"
#include "server/base/digest.h"
#include "server/cli/interrupt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const struct vor_curl *curl;

struct vor_remote {
    CURL *handle;
    char *authorization;             /* a header, NULL for none; for calls to */
    char origin[VOR_REMOTE_URL_MAX]; /* "https://HOST:PORT" */
    char why[CURL_ERROR_SIZE];
};

/* What the callbacks of one call share. */
struct exchange {
    struct vor_remote *remote;
    struct vor_remote_call *call;
    const char *url;
    char link[VOR_REMOTE_URL_MAX]; /* to where a file comes from, if that is elsewhere */
    int is_there;                  /* the call goes there */
    struct vor_digest digest;      /* of that file */
};

/* A command speaks to one daemon: "" for one that its URL names. */
static char socket_path[VOR_SOCKET_PATH_MAX];

vor_status vor_remote_use_socket(const char *path, struct vor_error *err)
{
    size_t size = strlen(path);

    if (path[0] != '/' || size >= sizeof socket_path)
        return vor_fail(err, VOR_E_PARAM,
                        "the server is \"unix:%.120s\", want unix:/PATH with a path of at most %d "
                        "bytes",
                        path, VOR_SOCKET_PATH_MAX - 1);
    memcpy(socket_path, path, size + 1);
    return VOR_OK;
}

vor_status vor_remote_open(struct vor_remote **out, struct vor_error *err)
{
    struct vor_remote *remote;
    vor_status status = vor_curl_load(&curl, err);

    *out = NULL;
    if (status != VOR_OK)
        return status;
    remote = calloc(1, sizeof *remote);
    if (remote != NULL)
        remote->handle = curl->easy_init();
    if (remote == NULL || remote->handle == NULL) {
        free(remote);
        return vor_fail(err, VOR_E_NOMEM, "the HTTP client");
    }
    *out = remote;
    return VOR_OK;
}

void vor_remote_close(struct vor_remote *remote)
{
    if (remote == NULL)
        return;
    curl->easy_cleanup(remote->handle);
    free(remote->authorization);
    free(remote);
}

/* "https://HOST:PORT" of a URL; "" when it is none. */
static void write_origin(char out[VOR_REMOTE_URL_MAX], const char *text)
{
    CURLU *url = curl->url();
    char *scheme = NULL, *host = NULL, *port = NULL;

    out[0] = '\0';
    if (url != NULL && curl->url_set(url, CURLUPART_URL, text, CURLU_GUESS_SCHEME) == CURLUE_OK &&
        curl->url_get(url, CURLUPART_SCHEME, &scheme, 0) == CURLUE_OK &&
        curl->url_get(url, CURLUPART_HOST, &host, 0) == CURLUE_OK &&
        curl->url_get(url, CURLUPART_PORT, &port, CURLU_DEFAULT_PORT) == CURLUE_OK)
        (void)snprintf(out, VOR_REMOTE_URL_MAX, "%s://%s:%s", scheme, host, port);
    curl->free(scheme);
    curl->free(host);
    curl->free(port);
    curl->url_cleanup(url);
}

vor_status vor_remote_authorize(struct vor_remote *remote, const char *url, const char *key,
                                struct vor_error *err)
{
    static const char name[] = "Authorization: Bearer ";
    size_t size = sizeof name + strlen(key);

    free(remote->authorization);
    remote->authorization = NULL;
    if (key[0] == '\0')
        return VOR_OK;
    remote->authorization = malloc(size);
    if (remote->authorization == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the key");
    (void)snprintf(remote->authorization, size, "%s%s", name, key);
    write_origin(remote->origin, url);
    return VOR_OK;
}

static size_t on_bytes(char *bytes, size_t unit, size_t count, void *ctx)
{
    struct exchange *exchange = ctx;
    struct vor_remote_call *call = exchange->call;
    size_t size = unit * count;
    long http = 0;

    (void)curl->easy_getinfo(exchange->remote->handle, CURLINFO_RESPONSE_CODE, &http);
    if (exchange->is_there)
        vor_digest_update(&exchange->digest, bytes, size);
    if (call->take != NULL && http >= 200 && http < 300) {
        call->was_stopped = call->take(call->ctx, bytes, size) != 0;
        return call->was_stopped ? CURL_WRITEFUNC_ERROR : size;
    }
    vor_text_add(&call->text, bytes, size);
    return call->text.failed ? CURL_WRITEFUNC_ERROR : size;
}

/* Location may be relative to the URL of the call. */
static void keep_location(struct vor_remote_call *call, const char *value)
{
    CURLU *url = curl->url();
    char *whole = NULL;

    call->location[0] = '\0';
    if (value[0] != '\0' && url != NULL &&
        curl->url_set(url, CURLUPART_URL, call->url, CURLU_GUESS_SCHEME) == CURLUE_OK &&
        curl->url_set(url, CURLUPART_URL, value, 0) == CURLUE_OK &&
        curl->url_get(url, CURLUPART_URL, &whole, 0) == CURLUE_OK &&
        strlen(whole) < sizeof call->location)
        (void)snprintf(call->location, sizeof call->location, "%s", whole);
    curl->free(whole);
    curl->url_cleanup(url);
}

static size_t on_file(char *bytes, size_t unit, size_t count, void *ctx)
{
    struct vor_remote_file *file = ctx;
    size_t size = fread(bytes, 1, unit * count, file->bytes);

    return ferror(file->bytes) ? CURL_READFUNC_ABORT : size;
}

/* curl calls this when a kept connection is dead and it must send a file again. */
static int on_rewind(void *ctx, curl_off_t offset, int origin)
{
    struct vor_remote_file *file = ctx;

    return fseeko(file->bytes, (off_t)offset, origin) == 0 ? CURL_SEEKFUNC_OK
                                                           : CURL_SEEKFUNC_CANTSEEK;
}

static int on_tick(void *ctx, VOR_UNUSED curl_off_t down, VOR_UNUSED curl_off_t downloaded,
                   VOR_UNUSED curl_off_t up, VOR_UNUSED curl_off_t uploaded)
{
    struct exchange *exchange = ctx;

    return (!exchange->call->is_last_word && vor_interrupt_seen()) ||
           (exchange->call->ends_to_stop && vor_interrupt_stops());
}

/* What the call sends. *form is freed after the call. */
static int send_files(CURL *handle, struct vor_remote_call *call, curl_mime **form)
{
    *form = NULL;
    if (call->files == 1) {
        curl->easy_setopt(handle, CURLOPT_POST, 1L);
        curl->easy_setopt(handle, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)call->file[0].size);
        curl->easy_setopt(handle, CURLOPT_READFUNCTION, on_file);
        curl->easy_setopt(handle, CURLOPT_READDATA, &call->file[0]);
        curl->easy_setopt(handle, CURLOPT_SEEKFUNCTION, on_rewind);
        curl->easy_setopt(handle, CURLOPT_SEEKDATA, &call->file[0]);
    }
    if (call->files < 2)
        return 1;
    *form = curl->mime_init(handle);
    for (unsigned i = 0; i < call->files; i++) {
        struct vor_remote_file *file = &call->file[i];
        curl_mimepart *part = *form != NULL ? curl->mime_addpart(*form) : NULL;

        /* A part that curl takes for a file, by its name. */
        if (part == NULL || curl->mime_name(part, file->name) != CURLE_OK ||
            curl->mime_filename(part, file->name) != CURLE_OK ||
            curl->mime_data_cb(part, (curl_off_t)file->size, on_file, on_rewind, NULL, file) !=
                CURLE_OK)
            return 0;
    }
    return curl->easy_setopt(handle, CURLOPT_MIMEPOST, *form) == CURLE_OK;
}

static int send_headers(const struct exchange *exchange, struct curl_slist **out)
{
    const struct vor_remote *remote = exchange->remote;
    const struct vor_remote_call *call = exchange->call;
    char origin[VOR_REMOTE_URL_MAX] = "";

    *out = NULL;
    /* The key goes nowhere else; a link is signed itself, even at the origin of the daemon. */
    if (!exchange->is_there && remote->authorization != NULL)
        write_origin(origin, exchange->url);
    for (size_t i = 0; call->headers != NULL && call->headers[i] != NULL; i++)
        if (!vor_curl_add(out, call->headers[i]))
            return 0;
    if (origin[0] != '\0' && strcasecmp(origin, remote->origin) == 0 &&
        !vor_curl_add(out, remote->authorization))
        return 0;
    return curl->easy_setopt(remote->handle, CURLOPT_HTTPHEADER, *out) == CURLE_OK;
}

static vor_status perform_once(struct exchange *exchange, struct vor_error *err)
{
    struct vor_remote *remote = exchange->remote;
    struct vor_remote_call *call = exchange->call;
    CURL *handle = remote->handle;
    struct curl_slist *headers = NULL;
    curl_mime *form = NULL;
    CURLcode code = CURLE_OUT_OF_MEMORY;
    long http = 0;

    call->http = 0;
    call->was_stopped = 0;
    vor_text_init(&call->text, VOR_JSON_SIZE_MAX);
    vor_curl_begin(handle, exchange->url, remote->why);
    if (socket_path[0] != '\0' && !exchange->is_there)
        curl->easy_setopt(handle, CURLOPT_UNIX_SOCKET_PATH, socket_path);
    curl->easy_setopt(handle, CURLOPT_TCP_KEEPALIVE, 1L);
    curl->easy_setopt(handle, CURLOPT_TIMEOUT, (long)call->timeout_seconds);
    if (call->stall_seconds > 0) {
        curl->easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, 1L);
        curl->easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, (long)call->stall_seconds);
    }
    curl->easy_setopt(handle, CURLOPT_WRITEFUNCTION, on_bytes);
    curl->easy_setopt(handle, CURLOPT_WRITEDATA, exchange);
    curl->easy_setopt(handle, CURLOPT_XFERINFOFUNCTION, on_tick);
    curl->easy_setopt(handle, CURLOPT_XFERINFODATA, exchange);
    curl->easy_setopt(handle, CURLOPT_CUSTOMREQUEST, call->method);
    if (send_headers(exchange, &headers) && send_files(handle, call, &form))
        code = curl->easy_perform(handle);
    (void)curl->easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &http);
    call->http = (int)http;
    curl->slist_free_all(headers);
    curl->mime_free(form);
    if (code == CURLE_OK || call->was_stopped)
        return VOR_OK;
    if (code == CURLE_ABORTED_BY_CALLBACK)
        return vor_interrupt_fail(err);
    if (code == CURLE_OUT_OF_MEMORY)
        return vor_fail(err, VOR_E_NOMEM, "a request");
    if (code == CURLE_WRITE_ERROR && call->text.failed)
        return vor_fail(err, VOR_E_LIMIT, "the response has more than %zu bytes", call->text.cap);
    return vor_fail(err, VOR_E_IO, "%s",
                    remote->why[0] != '\0' ? remote->why : curl->easy_strerror(code));
}

/* Gets the bytes from where the daemon says that they lie. */
static vor_status go_there(struct exchange *exchange, struct vor_error *err)
{
    struct vor_remote_call *call = exchange->call;
    char sha256[VOR_DIGEST_SIZE];
    vor_status status;

    memcpy(exchange->link, call->location, sizeof exchange->link);
    exchange->url = exchange->link;
    exchange->is_there = 1;
    vor_digest_begin(&exchange->digest);
    vor_text_free(&call->text);
    status = perform_once(exchange, err);
    vor_digest_hex(&exchange->digest, sha256);
    if (status == VOR_OK && call->http == 200 && !call->was_stopped &&
        strcmp(sha256, call->etag) != 0)
        status = vor_fail(err, VOR_E_DAMAGED,
                          "the file is damaged: its SHA-256 is %s, and not %s as the server said",
                          sha256, call->etag);
    return status;
}

vor_status vor_remote_perform(struct vor_remote *remote, struct vor_remote_call *call,
                              struct vor_error *err)
{
    struct exchange exchange = {.remote = remote, .call = call, .url = call->url};
    vor_status status = perform_once(&exchange, err);
    const char *etag = vor_curl_header(remote->handle, "ETag");

    call->etag[0] = '\0';
    if (etag[0] == '"')
        (void)snprintf(call->etag, sizeof call->etag, "%.*s", (int)strcspn(etag + 1, "\""),
                       etag + 1);
    keep_location(call, vor_curl_header(remote->handle, "Location"));
    return status == VOR_OK && call->goes_there && call->http == 307 && call->location[0] != '\0'
               ? go_there(&exchange, err)
               : status;
}

struct vor_json *vor_remote_json(const struct vor_remote_call *call)
{
    const char *text = call->text.data != NULL ? call->text.data : "";
    struct vor_json *json = NULL;

    return vor_json_parse(&json, text, call->text.size, NULL) == VOR_OK ? json : NULL;
}
