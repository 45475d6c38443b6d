#include "proto/sse.h"

#include <assert.h>
#include <string.h>

static int is_one_line(const char *value)
{
    return strpbrk(value, "\r\n") == NULL;
}

void vor_sse_retry(struct vor_text *text, unsigned retry_ms)
{
    vor_text_printf(text, "retry: %u\n\n", retry_ms);
}

void vor_sse_heartbeat(struct vor_text *text)
{
    vor_text_puts(text, ": hb\n\n");
}

void vor_sse_event(struct vor_text *text, const char *id, const char *name, const char *data,
                   size_t size)
{
    size_t at = 0, length;

    assert((id == NULL || is_one_line(id)) && (name == NULL || is_one_line(name)));
    if (id != NULL)
        vor_text_printf(text, "id: %s\n", id);
    if (name != NULL)
        vor_text_printf(text, "event: %s\n", name);
    for (;;) {
        length = vor_line_length(data + at, size - at);
        vor_text_puts(text, "data: ");
        vor_text_add(text, data + at, length);
        vor_text_puts(text, "\n");
        at += length;
        if (at == size)
            break;
        at += data[at] == '\r' && at + 1 < size && data[at + 1] == '\n' ? 2 : 1;
    }
    vor_text_puts(text, "\n");
}

void vor_sse_parser_init(struct vor_sse_parser *parser, vor_sse_handler handler, void *ctx)
{
    memset(parser, 0, sizeof *parser);
    parser->handler = handler;
    parser->ctx = ctx;
    vor_text_init(&parser->line, VOR_SSE_LINE_MAX);
    vor_text_init(&parser->name, VOR_SSE_LINE_MAX);
    vor_text_init(&parser->data, VOR_SSE_DATA_MAX);
    vor_text_init(&parser->pending_id, VOR_SSE_LINE_MAX);
    vor_text_init(&parser->id, VOR_SSE_LINE_MAX);
    parser->first_line = 1;
    parser->retry_ms = -1;
}

void vor_sse_parser_free(struct vor_sse_parser *parser)
{
    vor_text_free(&parser->line);
    vor_text_free(&parser->name);
    vor_text_free(&parser->data);
    vor_text_free(&parser->pending_id);
    vor_text_free(&parser->id);
}

static void replace(struct vor_text *text, const char *bytes, size_t size)
{
    vor_text_clear(text);
    vor_text_add(text, bytes, size);
}

void vor_sse_parser_restart(struct vor_sse_parser *parser)
{
    vor_text_clear(&parser->line);
    vor_text_clear(&parser->name);
    vor_text_clear(&parser->data);
    replace(&parser->pending_id, parser->id.data != NULL ? parser->id.data : "", parser->id.size);
    parser->seen_cr = 0;
    parser->seen_data = 0;
    parser->first_line = 1;
}

const char *vor_sse_parser_last_id(const struct vor_sse_parser *parser)
{
    return parser->id.data != NULL ? parser->id.data : "";
}

static int is(const char *field, size_t size, const char *name)
{
    return size == strlen(name) && memcmp(field, name, size) == 0;
}

static vor_status too_long(struct vor_error *err, const char *what, size_t limit, size_t got)
{
    (void)vor_fail(err, VOR_E_LIMIT, "event stream: %s of %zu bytes, want at most %zu", what, got,
                   limit);
    return vor_fail_over(err, VOR_E_LIMIT, limit, got);
}

/* Digits only, or the field is ignored. */
static void set_retry(struct vor_sse_parser *parser, const char *value, size_t size)
{
    int retry_ms = 0;

    for (size_t i = 0; i < size; i++) {
        if (value[i] < '0' || value[i] > '9')
            return;
        if (retry_ms < 100000000)
            retry_ms = retry_ms * 10 + (value[i] - '0');
    }
    if (size > 0)
        parser->retry_ms = retry_ms;
}

static vor_status take_field(struct vor_sse_parser *parser, const char *line, size_t size,
                             struct vor_error *err)
{
    const char *colon = memchr(line, ':', size);
    size_t name = colon != NULL ? (size_t)(colon - line) : size;
    const char *value = colon != NULL ? colon + 1 : line + size;
    size_t length = size - (size_t)(value - line);

    if (length > 0 && value[0] == ' ') {
        value++;
        length--;
    }
    if (is(line, name, "data")) {
        if (length + 1 > VOR_SSE_DATA_MAX - parser->data.size)
            return too_long(err, "an event", VOR_SSE_DATA_MAX, parser->data.size + length + 1);
        vor_text_add(&parser->data, value, length);
        vor_text_add(&parser->data, "\n", 1);
        parser->seen_data = 1;
        return vor_text_status(&parser->data, err);
    }
    if (is(line, name, "event")) {
        replace(&parser->name, value, length);
        return vor_text_status(&parser->name, err);
    }
    if (is(line, name, "id") && (length == 0 || memchr(value, '\0', length) == NULL)) {
        replace(&parser->pending_id, value, length);
        return vor_text_status(&parser->pending_id, err);
    }
    if (is(line, name, "retry"))
        set_retry(parser, value, length);
    return VOR_OK;
}

/* A blank line: the event is complete, its id is the stream's from here on. */
static vor_status dispatch(struct vor_sse_parser *parser, struct vor_error *err)
{
    struct vor_sse_arrival event = {NULL, "message", NULL, 0};
    vor_status status = VOR_OK;

    replace(&parser->id, parser->pending_id.data != NULL ? parser->pending_id.data : "",
            parser->pending_id.size);
    status = vor_text_status(&parser->id, err);
    if (status == VOR_OK && parser->seen_data) {
        parser->data.data[--parser->data.size] = '\0'; /* the last line's LF */
        event.id = vor_sse_parser_last_id(parser);
        if (parser->name.size > 0 && parser->name.data[0] != '\0')
            event.name = parser->name.data;
        event.data = parser->data.data;
        event.size = parser->data.size;
        if (parser->handler(parser->ctx, &event) != 0)
            status = vor_fail(err, VOR_E_CANCELLED, "the caller ended the event stream");
    }
    vor_text_clear(&parser->name);
    vor_text_clear(&parser->data);
    parser->seen_data = 0;
    return status;
}

static vor_status take_line(struct vor_sse_parser *parser, struct vor_error *err)
{
    const char *line = parser->line.data != NULL ? parser->line.data : "";
    size_t size = parser->line.size;
    vor_status status = VOR_OK;

    if (parser->first_line && size >= 3 && memcmp(line, "\xef\xbb\xbf", 3) == 0) {
        line += 3;
        size -= 3;
    }
    parser->first_line = 0;
    if (size == 0)
        status = dispatch(parser, err);
    else if (line[0] != ':')
        status = take_field(parser, line, size, err);
    vor_text_clear(&parser->line);
    return status;
}

vor_status vor_sse_feed(struct vor_sse_parser *parser, const void *bytes, size_t size,
                        struct vor_error *err)
{
    const char *p = bytes;
    vor_status status = VOR_OK;

    for (size_t at = 0; at < size && status == VOR_OK;) {
        size_t length = vor_line_length(p + at, size - at);

        if (parser->seen_cr && p[at] == '\n') {
            parser->seen_cr = 0;
            at++;
            continue;
        }
        parser->seen_cr = 0;
        if (length > VOR_SSE_LINE_MAX - parser->line.size)
            return too_long(err, "a line", VOR_SSE_LINE_MAX, parser->line.size + length);
        vor_text_add(&parser->line, p + at, length);
        status = vor_text_status(&parser->line, err);
        at += length;
        if (at == size || status != VOR_OK)
            break;
        parser->seen_cr = p[at++] == '\r';
        status = take_line(parser, err);
    }
    return status;
}
