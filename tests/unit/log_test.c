/* The log before readers that read late, slowly, or not at all. */
#include "tests/support/vt.h"

#include "proto/json/json.h"
#include "server/base/log.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TEXT_MAX = 8 << 20 };

/* A pipe whose write end is the log; the read end does not wait. */
static void open_log(int ends[2])
{
    ck_assert_int_eq(pipe(ends), 0);
    ck_assert_int_eq(fcntl(ends[0], F_SETFL, O_NONBLOCK), 0);
    vor_log_open(ends[1], VOR_LOG_INFO);
}

/* What is in the pipe, and what comes within 100 ms after it. */
static char *read_all(int fd)
{
    char *text = malloc(TEXT_MAX);
    struct pollfd more = {fd, POLLIN, 0};
    size_t size = 0;
    ssize_t got = 1;

    ck_assert_ptr_nonnull(text);
    while (got > 0 && poll(&more, 1, 100) > 0) {
        got = read(fd, text + size, TEXT_MAX - 1 - size);
        size += got > 0 ? (size_t)got : 0;
    }
    text[size] = '\0';
    return text;
}

/* The whole number of a member, or -1. */
static long member(const char *line, const char *name)
{
    const char *at = strstr(line, name);

    return at != NULL ? strtol(at + strlen(name), NULL, 10) : -1;
}

/* Adds up the lines "n" and those that are told as dropped; each must be JSON, and none missing
 * between the two. Returns how many were told. */
static long count_in_order(char *text, long total)
{
    char *rest;
    long next = 0, dropped = 0;

    for (char *line = strtok_r(text, "\n", &rest); line != NULL;
         line = strtok_r(NULL, "\n", &rest)) {
        vt_assert_ok(vor_json_scan(line, strlen(line), &vt_err));
        if (strstr(line, "log lines dropped") != NULL) {
            long lines = member(line, "\"lines\":");

            dropped += lines;
            next += lines;
        } else {
            ck_assert_int_eq(member(line, "\"n\":"), next);
            next++;
        }
    }
    ck_assert_int_eq(next, total);
    return dropped;
}

/* 20,000 lines of 100 bytes are twice what the pipe takes. */
VT_TEST(nobody_waits_for_a_log_that_nobody_reads)
{
    enum { LINES = 20000 };
    uint64_t before = vor_log_dropped();
    int ends[2];
    char *text, *rest;

    open_log(ends);
    for (int i = 0; i < LINES; i++)
        vor_log(VOR_LOG_INFO, "a line that waits for a reader", VOR_COUNT("n", i));
    ck_assert_uint_gt(vor_log_dropped(), before);
    text = read_all(ends[0]);
    vor_log(VOR_LOG_INFO, "a line that finds room", VOR_COUNT("n", LINES));
    rest = read_all(ends[0]);
    ck_assert_uint_lt(strlen(text) + strlen(rest), TEXT_MAX);
    strcpy(text + strlen(text), rest);
    ck_assert_int_eq(count_in_order(text, LINES + 1), (long)(vor_log_dropped() - before));
    free(text);
    free(rest);
}

VT_TEST(lines_for_a_reader_that_has_gone_are_counted)
{
    uint64_t before = vor_log_dropped();
    int ends[2];

    (void)signal(SIGPIPE, SIG_IGN);
    open_log(ends);
    (void)close(ends[0]);
    for (int i = 0; i < 10; i++)
        vor_log(VOR_LOG_INFO, "for nobody", VOR_COUNT("n", i));
    ck_assert_uint_eq(vor_log_dropped() - before, 10);
    vor_log_open(STDERR_FILENO, VOR_LOG_INFO);
}

/* Two bytes a character: a cut inside of one would show as U+FFFD. */
VT_TEST_LOOP(a_long_text_loses_its_middle_and_says_how_much, 2)
{
    char path[8193] = "/v1/", *text, *mark;
    size_t begin = 4 - (size_t)_i;
    int ends[2];

    for (size_t i = begin; i + 1 < sizeof path - 1; i += 2)
        memcpy(path + i, "\xc3\xa9", 3);
    open_log(ends);
    vor_log(VOR_LOG_INFO, "request", VOR_TEXT("path", path));
    text = read_all(ends[0]);
    ck_assert_uint_lt(strlen(text), 400);
    ck_assert_ptr_nonnull(strstr(text, "\"path\":\"/v1"));
    mark = strstr(text, " bytes] ");
    ck_assert_ptr_nonnull(mark);
    ck_assert_ptr_null(strstr(text, "\xef\xbf\xbd"));
    while (mark[-1] != '[')
        mark--;
    ck_assert_int_ge(atoi(mark), 7900);
    vt_assert_ok(vor_json_scan(text, strlen(text), &vt_err));
    free(text);
}
