/* traceparent: the grammar of W3C Trace Context, level 1, with its own examples. */
#include "tests/support/vt.h"

#include "server/base/span.h"

#include <string.h>

#define TRACE "4bf92f3577b34da6a3ce929d0e0e4736"
#define SPAN "00f067aa0ba902b7"

VT_TEST(a_traceparent_is_read_and_written_again)
{
    struct vor_span span;
    char text[VOR_TRACEPARENT_SIZE];

    ck_assert(vor_span_parse(&span, "00-" TRACE "-" SPAN "-01"));
    ck_assert_str_eq(span.trace, TRACE);
    ck_assert_str_eq(span.id, SPAN);
    ck_assert_str_eq(vor_span_text(&span, text), "00-" TRACE "-" SPAN "-01");
}

/* What a later version appends is not ours to know; its first fields are. */
VT_TEST(later_versions_are_read_as_far_as_they_are_known)
{
    struct vor_span span;
    char text[VOR_TRACEPARENT_SIZE];

    ck_assert(vor_span_parse(&span, "cc-" TRACE "-" SPAN "-01-what-the-future-brings"));
    ck_assert_str_eq(vor_span_text(&span, text), "00-" TRACE "-" SPAN "-01");
    ck_assert(vor_span_parse(&span, "01-" TRACE "-" SPAN "-ff"));
}

VT_TEST(what_is_no_traceparent_is_none)
{
    static const char *const none[] = {
        "",
        "00",
        "00-" TRACE "-" SPAN "-0",
        "00-" TRACE "-" SPAN "-01-x",
        "00-" TRACE "-" SPAN "-01 ",
        "00-" TRACE "-" SPAN "-0g",
        "01-" TRACE "-" SPAN "-01x",
        "ff-" TRACE "-" SPAN "-01",
        "0-" TRACE "-" SPAN "-01-",
        "00_" TRACE "-" SPAN "-01",
        "00-00000000000000000000000000000000-" SPAN "-01",
        "00-" TRACE "-0000000000000000-01",
        "00-4BF92F3577B34DA6A3CE929D0E0E4736-" SPAN "-01",
        "00-4bf92f3577b34da6a3ce929d0e0e473-" SPAN "-010",
        "00-" TRACE "\n" SPAN "-01",
    };
    struct vor_span span;
    char text[VOR_TRACEPARENT_SIZE];

    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++) {
        memset(&span, 'x', sizeof span);
        ck_assert_msg(!vor_span_parse(&span, none[i]), "%s", none[i]);
        ck_assert_str_eq(span.trace, "");
        ck_assert_str_eq(span.id, "");
        ck_assert_str_eq(vor_span_text(&span, text), "");
    }
}

VT_TEST(a_step_of_ours_has_the_trace_and_an_id_of_its_own)
{
    struct vor_span of, first, second, none = {"", "", ""};

    ck_assert(vor_span_parse(&of, "00-" TRACE "-" SPAN "-00"));
    vor_span_begin(&first, &of);
    vor_span_begin(&second, &of);
    ck_assert_str_eq(first.trace, TRACE);
    ck_assert_str_eq(first.flags, "00");
    ck_assert_uint_eq(strspn(first.id, "0123456789abcdef"), 16);
    ck_assert_str_ne(first.id, SPAN);
    ck_assert_str_ne(first.id, second.id);
    vor_span_begin(&first, &none);
    ck_assert_str_eq(first.trace, "");
}
