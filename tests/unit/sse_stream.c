/* The event stream, both ends: what one writes the other reads, however the bytes are cut. */
#include "proto/sse.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What has arrived, as text: one line "id|name|data" an event. */
struct seen {
    struct vor_text log;
    int stop_after; /* events; 0 never */
    int count;
};

static int note(void *ctx, const struct vor_sse_arrival *event)
{
    struct seen *seen = ctx;

    vor_text_printf(&seen->log, "%s|%s|", event->id, event->name);
    vor_text_add(&seen->log, event->data, event->size);
    vor_text_puts(&seen->log, "\x1e");
    return ++seen->count == seen->stop_after;
}

/* Feeds a stream in one piece, or byte by byte, or cut at random. */
static char *heard(const char *stream, size_t size, int cut, uint64_t seed)
{
    struct seen seen = {.stop_after = 0};
    struct vor_sse_parser parser;

    vor_text_init(&seen.log, 0);
    vor_text_puts(&seen.log, "");
    vor_sse_parser_init(&parser, note, &seen);
    for (size_t at = 0, piece; at < size; at += piece) {
        piece = cut == 0   ? size
                : cut == 1 ? 1
                           : 1 + (size_t)vor_rng_below(seed, 4, at, 1 + seed % 40);
        if (piece > size - at)
            piece = size - at;
        vt_assert_ok(vor_sse_feed(&parser, stream + at, piece, &vt_err));
    }
    vor_sse_parser_free(&parser);
    return seen.log.data;
}

struct example {
    const char *stream, *events;
};

/* The first five are the examples of the standard. */
static const struct example examples[] = {
    {"data: YHOO\ndata: +2\ndata: 10\n\n", "|message|YHOO\n+2\n10\x1e"},
    {": test stream\n\ndata: first event\nid: 1\n\ndata:second event\nid\n\ndata:  third event\n\n",
     "1|message|first event\x1e|message|second event\x1e|message| third event\x1e"},
    {"data\n\ndata\ndata\n\ndata:", "|message|\x1e|message|\n\x1e"},
    {"data:test\n\ndata: test\n\n", "|message|test\x1e|message|test\x1e"},
    {"event: add\ndata: 73857293\n\nevent: remove\ndata: 2153\n\n",
     "|add|73857293\x1e|remove|2153\x1e"},
    {"\xef\xbb\xbf"
     "data: a\n\n",
     "|message|a\x1e"},
    {"\xef\xbb\xbf\xef\xbb\xbf"
     "data: a\n\ndata: b\n\n",
     "|message|b\x1e"},
    {"data: a\r\rdata: b\r\n\r\ndata: c\n\r\n", "|message|a\x1e|message|b\x1e|message|c\x1e"},
    {"id: 1.7\nevent: progress\n\ndata: x\n\n", "1.7|message|x\x1e"},
    {"data: x\n\nid: 2\ndata: cut off\n", "|message|x\x1e"},
    {"retry: 2000\n\n: hb\n\nfoo: bar\nDATA: no\n data: no\ndata: yes\n\n", "|message|yes\x1e"},
    {"data: a:b: c\nevent:\n\n", "|message|a:b: c\x1e"},
    {"id: keep\ndata: 1\n\ndata: 2\n\nid:\ndata: 3\n\n",
     "keep|message|1\x1ekeep|message|2\x1e|message|3\x1e"},
    {"\n\n\n:\n::\n\n", ""},
    {"event: a\nevent: b\ndata: x\n\n", "|b|x\x1e"},
};

VT_TEST_LOOP(the_grammar_is_the_standards, (int)(sizeof examples / sizeof examples[0]))
{
    const struct example *e = &examples[_i];

    for (int cut = 0; cut < 6; cut++) {
        char *log = heard(e->stream, strlen(e->stream), cut, (uint64_t)cut);

        ck_assert_str_eq(log, e->events);
        free(log);
    }
}

/* Regression: a name of a lone NUL was neither a name nor "message". */
VT_TEST_LOOP(an_id_with_a_nul_is_ignored_and_a_name_is_cut_at_it, 2)
{
    static const char id[] = "id: a\ndata: 1\n\nid: b\0c\ndata: 2\n\n";
    static const char name[] = "event: \0x\ndata: 1\n\nevent: a\0b\ndata: 2\n\n";
    char *log = _i == 0 ? heard(id, sizeof id - 1, 0, 0) : heard(name, sizeof name - 1, 0, 0);

    ck_assert_str_eq(log, _i == 0 ? "a|message|1\x1e"
                                    "a|message|2\x1e"
                                  : "|message|1\x1e"
                                    "|a|2\x1e");
    free(log);
}

VT_TEST(a_formatted_stream_has_its_shape)
{
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_sse_retry(&text, 2000);
    vor_sse_event(&text, "1.4", "progress", "{}", 2);
    vor_sse_heartbeat(&text);
    vor_sse_event(&text, NULL, NULL, "a\r\nb\rc\n", 7);
    vor_sse_event(&text, NULL, "end", "", 0);
    ck_assert_str_eq(text.data, "retry: 2000\n\nid: 1.4\nevent: progress\ndata: {}\n\n: hb\n\n"
                                "data: a\ndata: b\ndata: c\ndata: \n\nevent: end\ndata: \n\n");
    vor_text_free(&text);
}

/* Property: what is formatted arrives, however it is cut; line ends arrive as LF. */
VT_TEST_LOOP(what_is_sent_arrives, 40)
{
    uint64_t seed = (uint64_t)_i;
    struct vor_text stream, wanted;
    char *log;

    vor_text_init(&stream, 0);
    vor_text_init(&wanted, 0);
    vor_sse_retry(&stream, 100);
    for (uint64_t e = 0; e < 40; e++) {
        char data[64], id[16];
        size_t size = (size_t)vor_rng_below(seed, 5, e, sizeof data);

        for (size_t i = 0; i < size; i++) {
            uint64_t random = vor_rng_below(seed, 6 + e, i, 300);

            data[i] = random < 256 && random != '\r' ? (char)random : random % 2 ? ':' : '\n';
        }
        snprintf(id, sizeof id, "%u", (unsigned)e);
        if (vt_unit(seed, e) < 0.3)
            vor_sse_heartbeat(&stream);
        vor_sse_event(&stream, id, e % 2 ? "progress" : NULL, data, size);
        vor_text_printf(&wanted, "%s|%s|", id, e % 2 ? "progress" : "message");
        vor_text_add(&wanted, data, size);
        vor_text_puts(&wanted, "\x1e");
    }
    log = heard(stream.data, stream.size, 2, seed);
    ck_assert_mem_eq(log, wanted.data, wanted.size + 1);
    free(log);
    vor_text_free(&stream);
    vor_text_free(&wanted);
}

static vor_status feed_run(struct vor_sse_parser *parser, const char *start, size_t count,
                           const char *end)
{
    vor_status status = vor_sse_feed(parser, start, strlen(start), &vt_err);

    for (size_t i = 0; i < count && status == VOR_OK; i++)
        status = vor_sse_feed(parser, "x", 1, &vt_err);
    return status == VOR_OK ? vor_sse_feed(parser, end, strlen(end), &vt_err) : status;
}

VT_TEST(a_line_ends_at_its_limit)
{
    struct seen seen = {.stop_after = 0};
    struct vor_sse_parser parser;

    vor_text_init(&seen.log, 0);
    vor_sse_parser_init(&parser, note, &seen);
    vt_assert_ok(feed_run(&parser, "data: ", VOR_SSE_LINE_MAX - 6, "\n\n"));
    ck_assert_int_eq(seen.count, 1);
    vt_assert_fails(VOR_E_LIMIT, feed_run(&parser, "data: ", VOR_SSE_LINE_MAX - 5, "\n\n"));
    ck_assert_uint_eq(vt_err.limit, VOR_SSE_LINE_MAX);
    ck_assert_uint_eq(vt_err.got, VOR_SSE_LINE_MAX + 1);
    vor_sse_parser_restart(&parser);
    vt_assert_ok(feed_run(&parser, "data: y", 0, "\n\n"));
    ck_assert_int_eq(seen.count, 2);
    vor_sse_parser_free(&parser);
    vor_text_free(&seen.log);
}

VT_TEST(an_event_ends_at_its_limit)
{
    struct seen seen = {.stop_after = 0};
    struct vor_sse_parser parser;
    vor_status status = VOR_OK;
    char line[1025];
    size_t lines = 0;

    memset(line, 'x', sizeof line);
    memcpy(line, "data:", 5);
    line[1024] = '\n';
    vor_text_init(&seen.log, 0);
    vor_sse_parser_init(&parser, note, &seen);
    for (; status == VOR_OK && lines < 3000; lines++)
        status = vor_sse_feed(&parser, line, sizeof line, &vt_err);
    vt_assert_fails(VOR_E_LIMIT, status);
    ck_assert_uint_eq(vt_err.limit, VOR_SSE_DATA_MAX);
    ck_assert_uint_eq(lines, VOR_SSE_DATA_MAX / 1020 + 1);
    vor_sse_parser_free(&parser);
    vor_text_free(&seen.log);
}

VT_TEST(the_handler_can_end_the_feed)
{
    static const char stream[] = "data: 1\n\ndata: 2\n\ndata: 3\n\n";
    struct seen seen = {.stop_after = 2};
    struct vor_sse_parser parser;

    vor_text_init(&seen.log, 0);
    vor_sse_parser_init(&parser, note, &seen);
    vt_assert_fails(VOR_E_CANCELLED, vor_sse_feed(&parser, stream, sizeof stream - 1, &vt_err));
    ck_assert_int_eq(seen.count, 2);
    vor_sse_parser_free(&parser);
    vor_text_free(&seen.log);
}

VT_TEST(a_restart_keeps_the_last_complete_id_and_the_retry)
{
    struct seen seen = {.stop_after = 0};
    struct vor_sse_parser parser;

    vor_text_init(&seen.log, 0);
    vor_sse_parser_init(&parser, note, &seen);
    ck_assert_int_eq(parser.retry_ms, -1);
    ck_assert_str_eq(vor_sse_parser_last_id(&parser), "");
    vt_assert_ok(feed_run(&parser, "retry: 1500\nretry: 9x\nid: 1.7\ndata: a\n\nid: 1.8\ndata: b",
                          0, "\ndata: c"));
    ck_assert_str_eq(vor_sse_parser_last_id(&parser), "1.7");
    ck_assert_int_eq(parser.retry_ms, 1500);
    vor_sse_parser_restart(&parser);
    vt_assert_ok(feed_run(&parser, "data: d", 0, "\n\n"));
    ck_assert_str_eq(seen.log.data, "1.7|message|a\x1e"
                                    "1.7|message|d\x1e");
    vor_sse_parser_free(&parser);
    vor_text_free(&seen.log);
}
