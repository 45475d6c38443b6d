#include "server/http/conn_guard.h"
#include "server/http/state.h"
#include "server/http/waker.h"

#include <string.h>
#include <strings.h>

const char *vor_request_header(const struct vor_request *request, const char *name)
{
    return vor_head_find(&request->head, name);
}

const char *vor_request_header_next(const struct vor_request *request, const char *name,
                                    unsigned *index)
{
    const struct vor_head *head = &request->head;

    while (*index < head->field_count && *index < VOR_FIELDS_MAX) {
        const struct vor_field *field = &head->fields[(*index)++];

        if (strcasecmp(field->name, name) == 0)
            return field->value;
    }
    return NULL;
}

const char *vor_request_query(const struct vor_request *request, const char *name)
{
    for (int i = 0; i < request->pair_count; i++)
        if (strcmp(request->pairs[i].name, name) == 0)
            return request->pairs[i].value;
    return NULL;
}

uint64_t vor_request_bytes_out(const struct vor_request *request)
{
    return request->reply.kind == VOR_REPLY_STREAM ? request->sent : request->reply.size;
}

void vor_request_set_state(struct vor_request *request, void *state, void (*release)(void *state))
{
    if (request->release != NULL)
        request->release(request->state);
    request->state = state;
    request->release = release;
}

void vor_request_take_body(struct vor_request *request, const struct vor_body_sink *sink,
                           uint64_t limit)
{
    request->sink = *sink;
    request->limit = limit;
}

bool vor_request_reply_early(struct vor_request *request, bool (*waits)(void *ctx))
{
    if (strcmp(request->head.version, "HTTP/1.1") != 0)
        return false;
    request->waits = waits;
    vor_conn_watch(request->conn, request->length < 0);
    return true;
}

int vor_request_gone(const struct vor_request *request)
{
    return vor_waker_is_gone(request->waker);
}

int vor_request_closing(const struct vor_request *request)
{
    return atomic_load(&request->http->closing);
}

void vor_request_wake_after(struct vor_request *request, double seconds)
{
    vor_conn_wake_after(request->conn, seconds);
}

unsigned vor_request_excess(const struct vor_request *request)
{
    const struct vor_http_options *options = &request->http->options;

    switch (vor_conn_excess(request->http->guard, request->conn)) {
    case VOR_EXCESS_ALL:
        return options->limits.connections;
    case VOR_EXCESS_ADDRESS:
        return options->limits.each;
    case VOR_EXCESS_NONE:
        break;
    }
    return 0;
}

int vor_request_condition(const struct vor_request *request, const char *etag)
{
    const char *wanted = vor_request_header(request, "If-Match");

    if (request->method != VOR_GET && request->method != VOR_HEAD)
        return 200;
    if (wanted != NULL && !vor_etag_listed(wanted, etag, false))
        return 412;
    return vor_etag_listed(vor_request_header(request, "If-None-Match"), etag, true) ? 304 : 200;
}
