#include "server/http/mhd_callbacks.h"

#include "server/base/clock.h"
#include "server/http/conn_guard.h"
#include "server/http/forwarded.h"
#include "server/http/mhd_library.h"
#include "server/http/release_zero_pages.h"
#include "server/http/state.h"
#include "server/http/waker.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

enum {
    STREAM_BLOCK = 1024, /* bytes of a reply in HTTP/1.0 at a time; held for its whole life */
    EARLY_ROOM = 16384,  /* bytes of a reply that began before the body was in, at a time */
    EARLY_HEAD = 8,      /* before them: their number, of six digits, in a line */
    EARLY_PIECES = 512 /* of them that are sent before the thread's other connections have a turn */
};

/* Suspends the request; false when it should go on at once, because it was woken already or the
 * daemon closes. A request that stays is not woken when its peer leaves. Closing sets its flag
 * first and wakes all then, so a request that misses the flag here has the wake kept for it. */
static bool request_sleep(struct vor_request *request, bool stays)
{
    bool sleeps;

    if (vor_request_closing(request))
        return false;
    if (!stays)
        vor_conn_wait(request->conn, true);
    sleeps = vor_waker_sleep(request->waker, stays);
    if (!sleeps)
        vor_conn_wait(request->conn, false);
    return sleeps;
}

static ssize_t read_stream(struct vor_request *request, char *out, size_t size)
{
    ssize_t end = request->reply.size == VOR_LENGTH_UNKNOWN ? MHD_CONTENT_READER_END_OF_STREAM
                                                            : MHD_CONTENT_READER_END_WITH_ERROR;

    vor_conn_wait(request->conn, false);
    for (;;) {
        long got = request->reply.read(request, out, size);

        if (got > 0) {
            request->sent += (uint64_t)got;
            return got;
        }
        if (got < 0)
            return got == VOR_STREAM_CUT ? MHD_CONTENT_READER_END_WITH_ERROR : end;
        if (vor_request_gone(request))
            return MHD_CONTENT_READER_END_WITH_ERROR;
        /* Gives back what the library has cleared of the connection's memory. It reads a head into
         * half of that, and fills the rest of the half with zeros once the reply begins: 24 KiB
         * that a stream would hold to its end. Memory of more than 32 KiB is a mapping of its own
         * there (0.9.75), at the beginning of which the request line stands. */
        if (request->line != NULL)
            vor_release_zero_pages((void *)(uintptr_t)request->line, VOR_CONNECTION_BYTES);
        request->line = NULL;
        if (request_sleep(request, false))
            return 0;
        if (vor_request_closing(request))
            return end;
    }
}

static ssize_t on_read(void *cls, VOR_UNUSED uint64_t position, char *out, size_t size)
{
    struct vor_request *request = cls;
    struct vor_http *http = request->http;
    ssize_t got;

    vor_watchdog_enter(&http->watchdog);
    got = read_stream(request, out, size);
    vor_watchdog_leave(&http->watchdog);
    return got;
}

/* Makes the library's form of the recorded reply, and takes out of the record what the library now
 * owns. */
static struct MHD_Response *make_response(struct vor_request *request)
{
    struct vor_reply *reply = &request->reply;
    struct MHD_Response *response = NULL;

    /* The library would end a chunked reply to HEAD with a chunk that nobody expects. */
    if (reply->kind == VOR_REPLY_STREAM && request->method == VOR_HEAD)
        return vor_mhd->create_response_from_buffer(0, (void *)(uintptr_t) "",
                                                    MHD_RESPMEM_PERSISTENT);
    switch (reply->kind) {
    case VOR_REPLY_BYTES:
        response = vor_mhd->create_response_from_buffer((size_t)reply->size, reply->bytes,
                                                        MHD_RESPMEM_MUST_FREE);
        if (response != NULL)
            reply->bytes = NULL;
        break;
    case VOR_REPLY_FILE:
        response =
            vor_mhd->create_response_from_fd_at_offset64(reply->size, reply->fd, reply->offset);
        if (response != NULL)
            reply->fd = -1;
        break;
    case VOR_REPLY_STREAM:
        response = vor_mhd->create_response_from_callback(reply->size, STREAM_BLOCK, on_read,
                                                          request, NULL);
        break;
    case VOR_REPLY_NONE:
        break;
    }
    return response;
}

static ssize_t send_raw(const struct vor_request *request, const char *bytes, size_t size)
{
    const union MHD_ConnectionInfo *info =
        vor_mhd->get_connection_info(request->connection, MHD_CONNECTION_INFO_CONNECTION_FD);

    return send(info->connect_fd, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
}

/* Sends what there is of a reply that begins while the body arrives. False once it is over. */
static bool send_early(struct vor_request *request)
{
    if (request->early == NULL) {
        char *head = vor_reply_raw(request);

        if (head == NULL)
            return false;
        request->early_size = strlen(head);
        request->early = realloc(head, request->early_size + EARLY_HEAD + EARLY_ROOM);
        if (request->early == NULL) {
            free(head);
            return false;
        }
        vor_conn_late(request->conn, NULL);
        vor_conn_linger(request->conn);
    }
    for (int pieces = 0; pieces < EARLY_PIECES; pieces++) {
        char *piece = request->early + EARLY_HEAD;
        char head[EARLY_HEAD + 1];
        ssize_t sent = send_raw(request, request->early + request->early_at,
                                request->early_size - request->early_at);
        unsigned size;
        long got;

        if (sent < 0)
            return errno == EAGAIN;
        request->early_at += (size_t)sent;
        if (request->early_at < request->early_size)
            continue;
        if (request->is_ended)
            return false;
        got = request->reply.read(request, piece, EARLY_ROOM - 2);
        if (got == 0 || got == VOR_STREAM_CUT)
            return got == 0;
        request->is_ended = got < 0;
        size = got < 0 ? 0 : (unsigned)got & 0xffffffu;
        request->sent += size;
        (void)snprintf(head, sizeof head, "%06x\r\n", size);
        memcpy(request->early, head, EARLY_HEAD);
        piece[size] = '\r';
        piece[size + 1] = '\n';
        request->early_size = EARLY_HEAD + size + 2;
        request->early_at = 0;
    }
    vor_request_wake_after(request, 0);
    return true;
}

/* Sends the rest of such a reply. The library has none, so the connection is dropped then. */
static enum MHD_Result finish_early(struct vor_request *request)
{
    request->stage = VOR_AT_REPLIED;
    vor_conn_wait(request->conn, false);
    vor_conn_phase(request->conn, VOR_PHASE_STREAM);
    while (send_early(request)) {
        if (request_sleep(request, false))
            return MHD_YES;
        if (vor_request_closing(request) || vor_request_gone(request))
            break;
    }
    return MHD_NO;
}

static enum MHD_Result queue_reply(struct vor_request *request)
{
    bool early = request->length != 0 && !request->whole;
    const struct vor_reply *reply = &request->reply;
    struct MHD_Response *response;
    enum MHD_Result result;
    const struct vor_refusal failed = {412, "precondition-failed",
                                       "no ETag in If-Match is the current one", 0, 0};
    int http = 200;

    if (request->early != NULL)
        return finish_early(request);
    /* Makes of a reply of 200 that has an ETag what the conditions of the request leave of it. */
    for (unsigned i = 0; reply->http == 200 && i < reply->field_count; i++)
        if (strcmp(reply->fields[i].name, "ETag") == 0)
            http = vor_request_condition(request, reply->fields[i].value);
    if (http == 304) {
        request->reply.http = http; /* the library sends no body, but its length */
    } else if (http == 412) {
        vor_reply_clear(request, 0);
        request->http->options.refuse(request, &failed);
    }
    response = make_response(request);
    request->stage = VOR_AT_REPLIED;
    if (response == NULL)
        return MHD_NO;
    if (early) {
        request->reply.close = true;
        vor_conn_linger(request->conn);
    }
    for (unsigned i = 0; i < reply->field_count; i++)
        (void)vor_mhd->add_response_header(response, reply->fields[i].name, reply->fields[i].value);
    if (reply->media_type != NULL)
        (void)vor_mhd->add_response_header(response, "Content-Type", reply->media_type);
    (void)vor_mhd->add_response_header(response, "X-Request-Id", request->id);
    (void)vor_mhd->add_response_header(response, "X-Content-Type-Options", "nosniff");
    if (reply->close || atomic_load(&request->http->quiesced))
        (void)vor_mhd->add_response_header(response, "Connection", "close");
    vor_conn_phase(request->conn, request->reply.kind == VOR_REPLY_STREAM &&
                                          request->reply.size == VOR_LENGTH_UNKNOWN
                                      ? VOR_PHASE_STREAM
                                      : VOR_PHASE_SEND);
    result = vor_mhd->queue_response(request->connection, (unsigned)request->reply.http, response);
    vor_mhd->destroy_response(response);
    return result;
}

static void refuse(struct vor_request *request, const struct vor_refusal *refusal)
{
    request->http->options.refuse(request, refusal);
    request->reply.close = true;
}

/* Ends a request whose reply is recorded, or has begun, which cuts it. The library takes no reply
 * while a body arrives: we write it ourselves, then drop the connection. */
static enum MHD_Result abort_body(struct vor_request *request)
{
    char *raw = request->reply.kind == VOR_REPLY_BYTES ? vor_reply_raw(request) : NULL;

    if (raw != NULL)
        (void)send_raw(request, raw, strlen(raw));
    free(raw);
    vor_conn_linger(request->conn);
    request->stage = VOR_AT_REPLIED;
    return MHD_NO;
}

/* 0 when the body may come, else a 413 is recorded. */
static int begin_body(struct vor_request *request)
{
    static const struct vor_refusal late = {
        408, "upload-timeout", "the upload paused too long, took too long or came too slowly", 0,
        0};
    unsigned fields = request->reply.field_count;
    struct vor_refusal refusal;
    char detail[128];

    if (request->length > 0 && (uint64_t)request->length > request->limit) {
        vor_refusal_excess(detail, sizeof detail, &refusal, request->limit,
                           (uint64_t)request->length);
        refuse(request, &refusal);
        return -1;
    }
    request->stage = VOR_AT_BODY;
    /* The reply that the guard sends when the body is late. The guard must not touch the request,
     * so it is made before. */
    refuse(request, &late);
    vor_conn_late(request->conn, vor_reply_raw(request));
    vor_reply_clear(request, fields);
    vor_conn_phase(request->conn, VOR_PHASE_BODY);
    return 0;
}

static enum MHD_Result run(struct vor_request *request, enum vor_step step)
{
    const struct vor_http_options *options = &request->http->options;

    for (;;) {
        enum vor_next next = options->handler(request, step);

        switch (next) {
        case VOR_NEXT_REPLY:
            return queue_reply(request);
        case VOR_NEXT_BODY:
            if (begin_body(request) != 0)
                return queue_reply(request);
            if (request->length != 0)
                return MHD_YES;
            step = VOR_STEP_BODY;
            break;
        case VOR_NEXT_WAIT:
        case VOR_NEXT_STAY:
            request->stage = VOR_AT_WAIT;
            vor_conn_phase(request->conn, VOR_PHASE_SERVE);
            if (request_sleep(request, next == VOR_NEXT_STAY))
                return MHD_YES;
            step = VOR_STEP_WAKE;
            break;
        }
    }
}

static enum MHD_Result on_field(void *cls, VOR_UNUSED enum MHD_ValueKind kind, const char *name,
                                const char *value)
{
    struct vor_head *head = cls;

    if (head->field_count > VOR_FIELDS_MAX)
        return MHD_NO;
    if (head->field_count < VOR_FIELDS_MAX)
        head->fields[head->field_count] = (struct vor_field){name, value != NULL ? value : ""};
    head->field_count++;
    return MHD_YES;
}

/* NULL when the head is sound; the query is split then. */
static const char *check_head(struct vor_request *request, const char **detail)
{
    unsigned index = 0;
    const char *slug, *trace;
    struct vor_span caller;

    (void)vor_mhd->get_connection_values(request->connection, MHD_HEADER_KIND, on_field,
                                         &request->head);
    vor_request_id_make(request->id, vor_head_find(&request->head, "X-Request-Id"));
    trace = vor_request_header_next(request, "traceparent", &index);
    if (trace != NULL && vor_request_header_next(request, "traceparent", &index) == NULL &&
        vor_span_parse(&caller, trace))
        vor_span_begin(&request->span, &caller);
    slug = vor_head_check(&request->head, detail);
    if (slug != NULL)
        return slug;
    if (request->via.client[0] != '\0')
        vor_forwarded_read(&request->via, &request->head, &request->from,
                           request->http->options.limits.trusted,
                           request->http->options.proxy_headers);
    request->length = vor_head_length(&request->head);
    request->path = request->target;
    request->query = strchr(request->target, '?');
    if (request->query != NULL)
        *request->query++ = '\0';
    request->pair_count = vor_query_split(request->query, request->pairs, VOR_QUERY_MAX);
    if (request->pair_count >= 0)
        return NULL;
    request->pair_count = 0;
    *detail = "the query holds a malformed escape, a control byte or more than 64 pairs";
    return "malformed-request";
}

/* Ends a request while its body arrives; refusal may be NULL: a reply is recorded, or none is due.
 */
static enum MHD_Result end_body(struct vor_request *request, const struct vor_refusal *refusal)
{
    if (refusal != NULL && request->reply.kind == VOR_REPLY_NONE)
        refuse(request, refusal);
    return abort_body(request);
}

/* Takes a piece of the body. Where the reply may begin before the body is in, and has something to
 * wait for, the request sleeps once no more bytes are there. The library calls for one that was
 * awake only when it has bytes, so the last is left with it, although it is taken. It does not pass
 * the end of a chunk before: bytes that came meanwhile are behind that, so the byte is let go. */
static enum MHD_Result take_piece(struct vor_request *request, const char *bytes, size_t *size)
{
    struct vor_refusal refusal;
    char detail[128];
    size_t fresh = *size;
    bool news = false;

    if (request->stage != VOR_AT_BODY) {
        *size = 0;
        return MHD_YES;
    }
    if (request->is_held) {
        bytes++;
        fresh--;
        vor_conn_wait(request->conn, false);
        news = vor_conn_news(request->conn) && request->length < 0;
    }
    request->is_held = false;
    request->received += fresh;
    vor_conn_received(request->conn, fresh);
    if (request->received > request->limit) {
        vor_refusal_excess(detail, sizeof detail, &refusal, request->limit, request->limit);
        return end_body(request, &refusal);
    }
    do {
        int http = request->sink.write(request->sink.ctx, bytes, fresh);
        bool waits = false;

        fresh = 0;
        if (http > 0)
            vor_refusal_sink(&refusal, http);
        if (http != 0 || (request->reply.kind == VOR_REPLY_STREAM && !send_early(request)))
            return end_body(request, http > 0 ? &refusal : NULL);
        if (request->waits != NULL) {
            waits = request->waits(request->sink.ctx) || request->early_at < request->early_size;
            vor_conn_phase(request->conn, waits ? VOR_PHASE_STREAM : VOR_PHASE_BODY);
        }
        *size = 0;
        if (waits)
            (void)vor_conn_news(request->conn);
        if (!waits || news || vor_conn_has_unread(request->conn))
            return MHD_YES;
        *size = 1;
        request->is_held = request_sleep(request, false);
    } while (!request->is_held && !vor_request_closing(request) && !vor_request_gone(request));
    return request->is_held ? MHD_YES : end_body(request, NULL);
}

/* One call of the library: the head, a piece of the body, or whatever comes next. */
static enum MHD_Result take_turn(struct vor_request *request, const char *method,
                                 const char *version, const char *data, size_t *size)
{
    if (request->stage == VOR_AT_NEW) {
        static const char *const words[VOR_METHOD_COUNT] = {"GET", "HEAD", "POST", "DELETE",
                                                            "OPTIONS"};
        const char *detail, *slug;

        /* The library closes the connection of a request that is answered in this first call. So a
         * request without a body is answered in the second one. */
        while (request->method < VOR_METHOD_COUNT && strcmp(words[request->method], method) != 0)
            request->method++;
        request->head.version = version;
        /* 0.9.75 does not copy the header block: names and values point into it (framing.t holds
         * that). Of later versions it is not known. */
        request->head.block = MHD_VERSION < 0x00097600 ? request->block : NULL;
        if (request->head.block != NULL)
            request->line = request->block - strlen(method) - 1;
        request->stage = VOR_AT_HEAD;
        (void)atomic_fetch_add(&request->http->busy, 1);
        slug = check_head(request, &detail);
        if (slug != NULL) {
            struct vor_refusal refusal = {400, slug, detail, 0, 0};

            request->path = "";
            request->length = -1;
            refuse(request, &refusal);
            return queue_reply(request);
        }
        vor_conn_phase(request->conn, VOR_PHASE_SERVE);
        return request->length != 0 ? run(request, VOR_STEP_HEAD) : MHD_YES;
    }
    if (*size > 0)
        return take_piece(request, data, size);
    switch (request->stage) {
    case VOR_AT_HEAD:
        return run(request, VOR_STEP_HEAD);
    case VOR_AT_BODY:
        vor_conn_phase(request->conn, VOR_PHASE_SERVE);
        request->whole = true;
        request->stage = VOR_AT_WAIT;
        return run(request, VOR_STEP_BODY);
    case VOR_AT_WAIT:
        vor_conn_wait(request->conn, false);
        return run(request, VOR_STEP_WAKE);
    case VOR_AT_REPLIED:
        return request->early != NULL ? finish_early(request) : MHD_YES;
    case VOR_AT_NEW:
        break;
    }
    return MHD_YES;
}

static void request_free(struct vor_request *request)
{
    if (request->release != NULL)
        request->release(request->state);
    vor_reply_clear(request, 0);
    vor_waker_drop(request->waker);
    free(request->early);
    free(request->target);
    free(request);
}

enum MHD_Result vor_mhd_step(void *cls, VOR_UNUSED struct MHD_Connection *connection,
                             VOR_UNUSED const char *url, const char *method, const char *version,
                             const char *data, size_t *size, void **con_cls)
{
    struct vor_http *http = cls;
    enum MHD_Result result;

    if (*con_cls == NULL)
        return MHD_NO;
    vor_watchdog_enter(&http->watchdog);
    result = take_turn(*con_cls, method, version, data, size);
    vor_watchdog_leave(&http->watchdog);
    return result;
}

/* This is the only place that shows the target as it was sent. */
void *vor_mhd_begin(void *cls, const char *target, struct MHD_Connection *connection)
{
    struct vor_http *http = cls;
    const union MHD_ConnectionInfo *info =
        vor_mhd->get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    struct vor_request *request;

    if (info == NULL || info->socket_context == NULL) /* no memory to guard it: it is cut */
        return NULL;
    request = calloc(1, sizeof *request);
    if (request == NULL)
        return NULL;
    request->http = http;
    request->app = http->options.app;
    request->connection = connection;
    request->conn = info->socket_context;
    request->began = vor_clock_seconds();
    request->reply.fd = -1;
    request->path = "";
    request->block = target;
    request->target = strdup(target);
    request->head.target = request->target;
    request->waker = vor_waker_create(connection);
    if (request->target == NULL || request->waker == NULL) {
        free(request->target);
        vor_waker_drop(request->waker);
        free(request);
        return NULL;
    }
    info = vor_mhd->get_connection_info(request->connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    if (info != NULL && info->client_addr != NULL &&
        vor_address_of_socket(&request->from, info->client_addr))
        (void)vor_address_text(&request->from, request->via.client);
    vor_conn_request(request->conn, request->waker);
    vor_conn_phase(request->conn, VOR_PHASE_HEAD);
    return request;
}

void vor_mhd_end(void *cls, VOR_UNUSED struct MHD_Connection *connection, void **con_cls,
                 VOR_UNUSED enum MHD_RequestTerminationCode code)
{
    struct vor_http *http = cls;
    struct vor_request *request = *con_cls;

    if (request == NULL)
        return;
    *con_cls = NULL;
    vor_watchdog_enter(&http->watchdog);
    vor_waker_end(request->waker);
    if (vor_conn_end(request->conn)) {
        request->reply.http = 408;
        request->problem = "upload-timeout";
    }
    if (request->stage != VOR_AT_NEW) {
        http->options.done(request);
        request_free(request);
        (void)atomic_fetch_sub(&http->busy, 1);
    } else {
        request_free(request);
    }
    vor_watchdog_leave(&http->watchdog);
}
