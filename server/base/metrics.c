/* Series are found in a table of pointers that only ever grows: open addressing, a free place taken
 * by compare-and-swap. A series is made before its pointer is seen, and never goes away. */
#include "server/base/metrics.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SERIES_MAX = 4096, /* a power of two; the tables that labels come from give some 1,000 */
    BOUNDS_MAX = 18
};

enum kind {
#define KIND_ENUM(id, word) KIND_##id,
    VOR_METRIC_KIND_TABLE(KIND_ENUM)
#undef KIND_ENUM
        KINDS
};

static const char *const kind_words[KINDS] = {
#define KIND_WORD(id, word) word,
    VOR_METRIC_KIND_TABLE(KIND_WORD)
#undef KIND_WORD
};

/* Upper bounds of the buckets, up to the first 0. Times reach from an answer of /livez to the
 * longest job. */
static const double bounds[KINDS][BOUNDS_MAX + 1] = {
    [KIND_TIMES] = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10,
                    30, 60, 300, 1800},
    [KIND_SIZES] = {100, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8},
    [KIND_STEPS] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10000},
    [KIND_RATIOS] = {0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5, 1},
    [KIND_BYTES] = {1048576, 16777216, 67108864, 268435456, 1073741824, 4294967296, 17179869184},
};

static const struct {
    const char *name;
    enum kind kind;
    const char *labels, *sentence;
} infos[VOR_METRICS] = {
#define INFO_ROW(id, name, kind, unit, labels, sentence) {name, KIND_##kind, labels, sentence},
    VOR_METRIC_TABLE(INFO_ROW)
#undef INFO_ROW
};

struct series {
    enum vor_metric metric;
    char label[VOR_LABELS_MAX][VOR_LABEL_MAX];
    _Atomic double value;                        /* of a histogram: the sum */
    atomic_uint_least64_t count[BOUNDS_MAX + 1]; /* up to each bound alone; the last: above all */
};

static _Atomic(struct series *) table[SERIES_MAX];

/* --- finding ---------------------------------------------------------------------------------- */

/* FNV-1a. */
static uint32_t hash(const struct series *key)
{
    uint32_t value = 2166136261u ^ (uint32_t)key->metric;

    for (unsigned i = 0; i < VOR_LABELS_MAX; i++) {
        for (const char *c = key->label[i]; *c != '\0'; c++)
            value = (value ^ (unsigned char)*c) * 16777619u;
        value = (value ^ 0xffu) * 16777619u;
    }
    return value;
}

/* NULL when memory is out or the table full: the value is not counted. */
static struct series *find(enum vor_metric metric, const char *const *labels)
{
    struct series key, *made = NULL;
    uint32_t at;

    memset(&key, 0, sizeof key);
    key.metric = metric;
    for (unsigned i = 0; labels != NULL && labels[i] != NULL; i++) {
        size_t size = strlen(labels[i]);

        assert(i < VOR_LABELS_MAX);
        memcpy(key.label[i], labels[i], size < VOR_LABEL_MAX ? size : VOR_LABEL_MAX - 1);
    }
    at = hash(&key);
    for (unsigned tries = 0; tries < SERIES_MAX; tries++, at++) {
        struct series *found = atomic_load(&table[at % SERIES_MAX]);

        if (found == NULL && made == NULL) {
            made = malloc(sizeof *made);
            if (made == NULL)
                return NULL;
            memcpy(made, &key, sizeof key);
        }
        if (found == NULL && atomic_compare_exchange_strong(&table[at % SERIES_MAX], &found, made))
            return made;
        if (found->metric == metric && memcmp(found->label, key.label, sizeof key.label) == 0) {
            free(made);
            return found;
        }
    }
    free(made);
    return NULL;
}

/* --- counting --------------------------------------------------------------------------------- */

static void add(_Atomic double *value, double by)
{
    double was = atomic_load(value);

    while (!atomic_compare_exchange_weak(value, &was, was + by))
        ;
}

void vor_metric_add(enum vor_metric metric, double by, const char *const *labels)
{
    struct series *series = find(metric, labels);

    if (series != NULL)
        add(&series->value, by);
}

void vor_metric_set(enum vor_metric metric, double value, const char *const *labels)
{
    struct series *series = find(metric, labels);

    if (series != NULL)
        atomic_store(&series->value, value);
}

void vor_metric_observe(enum vor_metric metric, double value, const char *const *labels)
{
    struct series *series = find(metric, labels);
    const double *bound = bounds[infos[metric].kind];
    unsigned i = 0;

    assert(bound[0] > 0);
    if (series == NULL || isnan(value))
        return;
    while (i < BOUNDS_MAX && bound[i] > 0 && value > bound[i])
        i++;
    (void)atomic_fetch_add(&series->count[bound[i] > 0 ? i : BOUNDS_MAX], 1);
    add(&series->value, value);
}

/* --- writing ---------------------------------------------------------------------------------- */

/* A label's value: quotes, backslashes and newlines are escaped. */
static void put_value(struct vor_text *text, const char *value)
{
    for (; *value != '\0'; value++) {
        if (*value == '\n')
            vor_text_puts(text, "\\n");
        else if (*value == '"' || *value == '\\')
            vor_text_printf(text, "\\%c", *value);
        else
            vor_text_add(text, value, 1);
    }
}

/* NAME{label="value",le="0.5"}; le is NULL for none. */
static void put_series(struct vor_text *text, const struct series *series, const char *suffix,
                       const char *le)
{
    const char *label = infos[series->metric].labels;
    const char *before = "{";

    vor_text_printf(text, "voronoid_%s%s", infos[series->metric].name, suffix);
    for (unsigned i = 0; *label != '\0'; i++) {
        int size = (int)strcspn(label, " ");

        vor_text_printf(text, "%s%.*s=\"", before, size, label);
        put_value(text, series->label[i]);
        vor_text_puts(text, "\"");
        before = ",";
        label += size + (label[size] == ' ');
    }
    if (le != NULL)
        vor_text_printf(text, "%sle=\"%s\"", before, le);
    vor_text_puts(text, le != NULL || before[0] == ',' ? "} " : " ");
}

static void put_one(struct vor_text *text, struct series *series)
{
    if (bounds[infos[series->metric].kind][0] > 0) {
        const double *bound = bounds[infos[series->metric].kind];
        double sum = atomic_load(&series->value);
        uint64_t count = 0;
        char le[32];

        for (unsigned i = 0; i < BOUNDS_MAX && bound[i] > 0; i++) {
            count += atomic_load(&series->count[i]);
            (void)snprintf(le, sizeof le, "%.10g", bound[i]);
            put_series(text, series, "_bucket", le);
            vor_text_printf(text, "%llu\n", (unsigned long long)count);
        }
        count += atomic_load(&series->count[BOUNDS_MAX]);
        put_series(text, series, "_bucket", "+Inf");
        vor_text_printf(text, "%llu\n", (unsigned long long)count);
        put_series(text, series, "_sum", NULL);
        vor_text_printf(text, "%.17g\n", sum);
        put_series(text, series, "_count", NULL);
        vor_text_printf(text, "%llu\n", (unsigned long long)count);
    } else {
        put_series(text, series, "", NULL);
        vor_text_printf(text, "%.17g\n", atomic_load(&series->value));
    }
}

void vor_metrics_write(struct vor_text *text)
{
    for (int metric = 0; metric < VOR_METRICS; metric++) {
        int said = 0;

        for (unsigned at = 0; at < SERIES_MAX; at++) {
            struct series *series = atomic_load(&table[at]);

            if (series == NULL || (int)series->metric != metric)
                continue;
            if (!said++)
                vor_text_printf(text, "# HELP voronoid_%s %s\n# TYPE voronoid_%s %s\n",
                                infos[metric].name, infos[metric].sentence, infos[metric].name,
                                kind_words[infos[metric].kind]);
            put_one(text, series);
        }
    }
}
