/* The numbers for /metrics: what is written of what was counted. */
#include "tests/support/vt.h"

#include "server/base/metrics.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *written(void)
{
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_metrics_write(&text);
    vt_assert_ok(vor_text_status(&text, &vt_err));
    return text.data != NULL ? text.data : strdup("");
}

static void check_line(const char *text, const char *line)
{
    const char *at = strstr(text, line);

    ck_assert_msg(at != NULL && (at == text || at[-1] == '\n'), "no line \"%s\" in\n%s", line,
                  text);
}

VT_TEST(what_was_never_counted_is_not_written)
{
    char *text;

    text = written();
    ck_assert_str_eq(text, "");
    free(text);
}

VT_TEST(counters_of_different_labels_are_apart)
{
    char *text;

    vor_metric_add(VOR_METRIC_HTTP_REQUESTS, 1, VOR_LABELS("/v1/jobs", "GET", "200"));
    vor_metric_add(VOR_METRIC_HTTP_REQUESTS, 2, VOR_LABELS("/v1/jobs", "GET", "200"));
    vor_metric_add(VOR_METRIC_HTTP_REQUESTS, 1, VOR_LABELS("/v1/jobs", "GET", "404"));
    vor_metric_set(VOR_METRIC_CONNECTIONS, 7, NULL);
    text = written();
    check_line(text, "# TYPE voronoid_http_requests_total counter\n");
    check_line(text,
               "voronoid_http_requests_total{route=\"/v1/jobs\",method=\"GET\",code=\"200\"} 3\n");
    check_line(text,
               "voronoid_http_requests_total{route=\"/v1/jobs\",method=\"GET\",code=\"404\"} 1\n");
    check_line(text,
               "# HELP voronoid_connections Open connections\n# TYPE voronoid_connections gauge\n"
               "voronoid_connections 7\n");
    free(text);
}

VT_TEST(a_label_s_value_is_escaped_and_cut)
{
    char value[100], line[160];
    char *text;

    memset(value, 'x', sizeof value - 1);
    value[sizeof value - 1] = '\0';
    vor_metric_add(VOR_METRIC_REJECTED, 1, VOR_LABELS("a\"b\\c\nd"));
    vor_metric_add(VOR_METRIC_REJECTED, 1, VOR_LABELS(value));
    text = written();
    check_line(text, "voronoid_rejected_total{reason=\"a\\\"b\\\\c\\nd\"} 1\n");
    (void)snprintf(line, sizeof line, "voronoid_rejected_total{reason=\"%.*s\"} 1\n",
                   VOR_LABEL_MAX - 1, value);
    check_line(text, line);
    free(text);
}

/* A bound belongs to its bucket; buckets add up; +Inf is the count. */
VT_TEST(a_histogram_counts_up_to_each_bound)
{
    static const double values[] = {0, 0.001, 0.0011, 0.5, 1e9};
    char *text;

    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        vor_metric_observe(VOR_METRIC_HTTP_SECONDS, values[i], VOR_LABELS("/livez"));
    vor_metric_observe(VOR_METRIC_HTTP_SECONDS, NAN, VOR_LABELS("/livez"));
    text = written();
    check_line(text,
               "voronoid_http_request_duration_seconds_bucket{route=\"/livez\",le=\"0.0005\"} 1\n");
    check_line(text,
               "voronoid_http_request_duration_seconds_bucket{route=\"/livez\",le=\"0.001\"} 2\n");
    check_line(text,
               "voronoid_http_request_duration_seconds_bucket{route=\"/livez\",le=\"0.0025\"} 3\n");
    check_line(text,
               "voronoid_http_request_duration_seconds_bucket{route=\"/livez\",le=\"0.5\"} 4\n");
    check_line(text,
               "voronoid_http_request_duration_seconds_bucket{route=\"/livez\",le=\"1800\"} 4\n");
    check_line(text,
               "voronoid_http_request_duration_seconds_bucket{route=\"/livez\",le=\"+Inf\"} 5\n");
    check_line(text, "voronoid_http_request_duration_seconds_count{route=\"/livez\"} 5\n");
    check_line(text,
               "voronoid_http_request_duration_seconds_sum{route=\"/livez\"} 1000000000.5021");
    free(text);
}

enum { THREADS = 4, ROUNDS = 2000, LABELS = 50 };

static void *count_all(void *unused)
{
    (void)unused;
    for (int i = 0; i < ROUNDS; i++) {
        char label[16];

        (void)snprintf(label, sizeof label, "r%d", i % LABELS);
        vor_metric_add(VOR_METRIC_REJECTED, 1, VOR_LABELS(label));
        vor_metric_observe(VOR_METRIC_JOB_ITERATIONS, i, NULL);
    }
    return NULL;
}

VT_TEST(threads_that_count_at_once_lose_nothing)
{
    pthread_t threads[THREADS];
    char *text, line[80];

    for (int i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, count_all, NULL), 0);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    text = written();
    for (int i = 0; i < LABELS; i++) {
        (void)snprintf(line, sizeof line, "voronoid_rejected_total{reason=\"r%d\"} %d\n", i,
                       THREADS * ROUNDS / LABELS);
        check_line(text, line);
    }
    (void)snprintf(line, sizeof line, "voronoid_job_iterations_count %d\n", THREADS * ROUNDS);
    check_line(text, line);
    free(text);
}

/* What promtool's lint asks of names and units. */
VT_TEST(names_end_in_their_unit_and_counters_in_total)
{
    static const struct {
        const char *name, *kind, *unit, *labels, *sentence;
    } rows[] = {
#define ROW(id, name, kind, unit, labels, sentence) {name, #kind, unit, labels, sentence},
        VOR_METRIC_TABLE(ROW)
#undef ROW
    };

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const char *name = rows[i].name;
        size_t size = strlen(name), unit = strlen(rows[i].unit);
        int total = size > 6 && strcmp(name + size - 6, "_total") == 0;

        ck_assert_msg(strspn(name, "abcdefghijklmnopqrstuvwxyz_") == size, "%s", name);
        ck_assert_msg(total == (strcmp(rows[i].kind, "COUNTER") == 0), "%s", name);
        size -= total ? 6 : 0;
        ck_assert_msg(size > unit && strncmp(name + size - unit, rows[i].unit, unit) == 0,
                      "%s has no unit", name);
        ck_assert_msg(strstr(name, "seconds") == NULL || strcmp(rows[i].unit, "seconds") == 0, "%s",
                      name);
        ck_assert_msg(strpbrk(rows[i].sentence, "\n\\") == NULL && rows[i].sentence[0] != '\0',
                      "%s", name);
        ck_assert_msg(strstr(rows[i].labels, "tenant") == NULL &&
                          strstr(rows[i].labels, "job") == NULL,
                      "%s has a label without end", name);
    }
}
