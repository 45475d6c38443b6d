/* A request that leaves everything to the engine (momentum, polish, neighbours, stops) gives the
 * same bytes, records and counts for any number of threads. */
#include "tests/support/vt_trace.h"

#include <math.h>
#include <string.h>

enum { N = 4000, OUT = 1100, SHAPES = 5 };

struct result {
    uint64_t positions, normals, labels, records, counts;
    double delta;
};

/* Closed, with a border, with edges, with a wide hole and uneven density; more points than went in;
 * two crowds far apart, one of them with many points in one place. */
static size_t shape(struct vor_cloud *cloud, int kind, uint64_t seed)
{
    struct vor_attribute *label;

    if (kind == 0)
        vt_cloud_sphere(cloud, seed, N);
    else if (kind == 1)
        vt_cloud_dome(cloud, seed, N);
    else if (kind == 2 || kind == 3)
        vt_cloud_box(cloud, seed, kind == 2 ? N : 400);
    else
        vt_cloud_square(cloud, seed, N);
    for (size_t i = 0; kind == 4 && i < N; i++) {
        cloud->xyz[3 * i] *= cloud->xyz[3 * i]; /* dense towards x = 0 */
        if (i % 10 == 0)
            cloud->xyz[3 * i + 2] = 3;
        if (i % 50 == 0)
            memcpy(&cloud->xyz[3 * i], cloud->xyz, 3 * sizeof *cloud->xyz);
    }
    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "label", VOR_GENERIC, VOR_INT32, 1, &label, &vt_err));
    for (size_t i = 0; i < cloud->n; i++)
        ((int32_t *)label->data)[i] = (int32_t)i;
    return kind == 3 ? 3 * cloud->n : OUT;
}

static uint64_t hash_records(const struct vt_trace *trace)
{
    uint64_t hash = trace->count;

    for (size_t i = 0; i < trace->count; i++) {
        const struct vor_record *r = &trace->record[i];
        const double values[5] = {r->delta, r->sigma, r->epsilon, r->energy, r->max_move};
        const uint64_t counts[3] = {r->iteration, r->polish, r->held};

        hash = 31 * hash + (vt_hash(values, sizeof values) ^ vt_hash(counts, sizeof counts));
    }
    return hash;
}

/* All that a report counts or measures but times and memory. */
static uint64_t hash_report(const struct vor_report *r)
{
    const double values[9] = {r->delta,         r->sigma,     r->epsilon,
                              r->spacing_mean,  r->area,      r->min_over_mean,
                              r->max_over_mean, r->six_share, r->bisectors_per_cell};
    const uint64_t counts[9] = {r->iterations, r->polish_steps,  (uint64_t)r->stopped,
                                r->held,       r->held_ever,     r->fallback_plane,
                                r->queries,    r->list_rebuilds, r->fallback_left};

    return vt_hash(values, sizeof values) ^ vt_hash(counts, sizeof counts) ^
           vt_hash(&r->in_to_out, sizeof r->in_to_out) ^
           vt_hash(&r->out_to_in, sizeof r->out_to_in) ^ vt_hash(r->fitted, sizeof r->fitted) ^
           r->boundary_points ^ vt_hash(&r->triangles_per_cell, sizeof r->triangles_per_cell);
}

static struct result run(const struct vor_cloud *in, size_t points, unsigned threads,
                         const char *anderson, uint64_t seed)
{
    static struct vt_trace trace;
    struct result result;
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;

    vt_engine_open(&engine, threads);
    vt_trace_attach(&trace, &engine);
    vt_engine_count(&engine, "points", points);
    vt_engine_count(&engine, "seed", (size_t)seed);
    if (anderson != NULL)
        vt_engine_set(&engine, "anderson", anderson);
    vt_engine_set(&engine, "normals", "fit");
    vt_engine_resample(&engine, &out, &report, in);
    ck_assert_uint_gt(report.polish_steps, 0);
    ck_assert_uint_gt(trace.count, 10);
    result.positions = vt_cloud_hash(&out);
    result.normals = vt_hash(vor_cloud_find(&out, VOR_NORMAL)->data, points * 3 * sizeof(float));
    result.labels = vt_hash(vor_cloud_find(&out, VOR_GENERIC)->data, points * sizeof(int32_t));
    result.records = hash_records(&trace);
    result.counts = hash_report(&report);
    result.delta = report.delta;
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return result;
}

static void assert_same(const struct result *a, const struct result *b)
{
    ck_assert(a->positions == b->positions);
    ck_assert(a->normals == b->normals);
    ck_assert(a->labels == b->labels);
    ck_assert(a->records == b->records);
    ck_assert(a->counts == b->counts);
}

START_TEST(the_defaults_give_the_same_bytes_on_one_two_three_and_eight_threads)
{
    static const unsigned threads[4] = {2, 3, 8, 1};
    const char *anderson = _i >= SHAPES ? "4" : NULL;
    struct vor_cloud in;
    size_t points = shape(&in, _i % SHAPES, (uint64_t)_i);
    struct result first = run(&in, points, 1, anderson, 1);

    for (int k = 0; k < 4; k++) {
        struct result other = run(&in, points, threads[k], anderson, 1);

        assert_same(&first, &other);
    }
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* The comparison can tell: another seed changes all of it. */
START_TEST(another_seed_gives_other_bytes_records_and_counts)
{
    struct vor_cloud in;
    size_t points = shape(&in, _i, (uint64_t)_i);
    struct result a = run(&in, points, 2, NULL, 1), b = run(&in, points, 2, NULL, 2);

    ck_assert(a.positions != b.positions && a.normals != b.normals && a.labels != b.labels);
    ck_assert(a.records != b.records && a.counts != b.counts && a.delta != b.delta);
    vor_cloud_free(&in);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("engine_threads");

    vt_add_loop(suite, the_defaults_give_the_same_bytes_on_one_two_three_and_eight_threads,
                VT_FEWER(SHAPES + 2));
    vt_add_loop(suite, another_seed_gives_other_bytes_records_and_counts, VT_FEWER(2));
    return vt_run(suite);
}
