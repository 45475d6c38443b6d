#include "server/http/request.h"

#include "server/base/clock.h"
#include "server/http/conn_guard.h"
#include "server/http/state.h"
#include "server/http/waker.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

enum vor_method vor_method_find(const char *word)
{
    static const char *const words[VOR_METHOD_COUNT] = {"GET", "HEAD", "POST", "DELETE", "OPTIONS"};
    int i = 0;

    while (i < VOR_METHOD_COUNT && strcmp(words[i], word) != 0)
        i++;
    return (enum vor_method)i;
}

bool vor_request_split(struct vor_request *request)
{
    request->path = request->target;
    request->query = strchr(request->target, '?');
    if (request->query != NULL)
        *request->query++ = '\0';
    request->pair_count = vor_query_split(request->query, request->pairs, VOR_QUERY_MAX);
    if (request->pair_count >= 0)
        return true;
    request->pair_count = 0;
    return false;
}

void vor_request_trace(struct vor_request *request)
{
    unsigned index = 0;
    const char *text = vor_request_header_next(request, "traceparent", &index);
    struct vor_span caller;

    if (text != NULL && vor_request_header_next(request, "traceparent", &index) == NULL &&
        vor_span_parse(&caller, text))
        vor_span_begin(&request->span, &caller);
}

const struct vor_span *vor_request_span(const struct vor_request *request)
{
    return &request->span;
}

enum vor_method vor_request_method(const struct vor_request *request)
{
    return request->method;
}

const char *vor_request_path(const struct vor_request *request)
{
    return request->path;
}

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

const char *vor_request_query_name(const struct vor_request *request, unsigned index)
{
    return index < (unsigned)request->pair_count ? request->pairs[index].name : NULL;
}

const char *vor_request_query_value(const struct vor_request *request, unsigned index)
{
    return index < (unsigned)request->pair_count ? request->pairs[index].value : NULL;
}

const char *vor_request_query(const struct vor_request *request, const char *name)
{
    for (int i = 0; i < request->pair_count; i++)
        if (strcmp(request->pairs[i].name, name) == 0)
            return request->pairs[i].value;
    return NULL;
}

const char *vor_request_id(const struct vor_request *request)
{
    return request->id;
}

const struct vor_via *vor_request_via(const struct vor_request *request)
{
    return &request->via;
}

int64_t vor_request_length(const struct vor_request *request)
{
    return request->length;
}

void vor_request_set_route(struct vor_request *request, const struct vor_route *route)
{
    request->route = route;
}

const struct vor_route *vor_request_route(const struct vor_request *request)
{
    return request->route;
}

void vor_request_set_principal(struct vor_request *request, const struct vor_principal *principal)
{
    request->principal = *principal;
}

const struct vor_principal *vor_request_principal(const struct vor_request *request)
{
    return &request->principal;
}

void vor_request_set_job(struct vor_request *request, const char *job)
{
    (void)snprintf(request->job, sizeof request->job, "%s", job);
}

const char *vor_request_job(const struct vor_request *request)
{
    return request->job;
}

void vor_request_set_problem(struct vor_request *request, const char *slug)
{
    request->problem = slug;
}

const char *vor_request_problem(const struct vor_request *request)
{
    return request->problem;
}

int vor_request_status(const struct vor_request *request)
{
    return request->reply.http;
}

uint64_t vor_request_bytes_in(const struct vor_request *request)
{
    return request->received;
}

uint64_t vor_request_bytes_out(const struct vor_request *request)
{
    return request->reply.kind == VOR_REPLY_STREAM ? request->sent : request->reply.size;
}

double vor_request_seconds(const struct vor_request *request)
{
    return vor_clock_seconds() - request->began;
}

void vor_request_set_state(struct vor_request *request, void *state, void (*release)(void *state))
{
    if (request->release != NULL)
        request->release(request->state);
    request->state = state;
    request->release = release;
}

void *vor_request_state(const struct vor_request *request)
{
    return request->state;
}

void vor_request_take_body(struct vor_request *request, const struct vor_body_sink *sink,
                           uint64_t limit)
{
    request->sink = *sink;
    request->limit = limit;
}

struct vor_waker *vor_request_waker(struct vor_request *request)
{
    return vor_waker_hold(request->waker);
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
        return options->connections;
    case VOR_EXCESS_ADDRESS:
        return options->each;
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
