/* The same bytes for any number of threads, for every run, and for a cloud that was only shifted
 * (RELIABILITY G20, G21). */
#include "tests/support/vt_ask.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { N = 3000, OUT = 800 };

struct result {
    uint64_t positions, normals, report;
};

static void run(struct result *result, const struct vor_cloud *in, unsigned threads,
                const char *boundary, const char *polish, size_t points)
{
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;

    vt_engine_open(&engine, threads);
    vt_engine_count(&engine, "points", points);
    vt_ask_set(&engine, "iterations=12 normals=fit");
    vt_engine_set(&engine, "boundary", boundary);
    vt_engine_set(&engine, "polish", polish);
    vt_engine_resample(&engine, &out, &report, in);
    result->positions = vt_cloud_hash(&out);
    result->normals = vt_hash(vor_cloud_find(&out, VOR_NORMAL)->data, points * 12);
    report.memory_peak_bytes = 0; /* scratch goes by threads */
    result->report = vt_hash(&report.delta, 3 * sizeof report.delta) ^
                     vt_hash(&report.area, 2 * sizeof report.area) ^ report.held_ever;
    vor_cloud_free(&out);
    vt_engine_close(&engine);
}

static void assert_same(const struct result *a, const struct result *b)
{
    ck_assert(a->positions == b->positions);
    ck_assert(a->normals == b->normals);
    ck_assert(a->report == b->report);
}

VT_TEST_LOOP(one_two_three_and_eight_threads_give_the_same_bytes, VT_ONCE(3))
{
    static const unsigned threads[5] = {1, 2, 3, 8, 1};
    struct result first, other;
    struct vor_cloud in;

    if (_i == 0)
        vt_cloud_sphere(&in, 1, N);
    else if (_i == 1)
        vt_cloud_dome(&in, 2, N);
    else
        vt_cloud_box(&in, 3, N);
    for (int k = 0; k < 5; k++) {
        run(&other, &in, threads[k], _i == 2 ? "free" : "keep", "20", OUT);
        if (k == 0)
            first = other;
        assert_same(&first, &other);
    }
    vor_cloud_free(&in);
}

/* A run on a pool that others use too; a thread of its own must not assert. */
struct shared_run {
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;
    vor_status status;
};

static void *run_shared(void *ctx)
{
    struct shared_run *shared = ctx;

    vor_cloud_init(&shared->out, &vt_memory);
    shared->status = vt_run_engine(&shared->out, &shared->report, &shared->in, &shared->engine.spec,
                                   &shared->engine.run, NULL);
    return NULL;
}

VT_TEST(runs_that_share_a_pool_give_the_bytes_they_give_alone)
{
    enum { RUNS = 3 };
    static struct shared_run runs[RUNS];
    struct vt_engine owner;
    pthread_t thread[RUNS];
    uint64_t alone[RUNS];

    vt_engine_open(&owner, 3);
    for (int k = 0; k < RUNS; k++) {
        runs[k].engine = owner;
        vt_cloud_box(&runs[k].in, (uint64_t)k, 1000);
        vt_engine_count(&runs[k].engine, "points", 300 + 400 * (size_t)k);
        vt_engine_set(&runs[k].engine, "iterations", "10");
        (void)run_shared(&runs[k]);
        vt_assert_ok(runs[k].status);
        alone[k] = vt_cloud_hash(&runs[k].out);
        vor_cloud_free(&runs[k].out);
    }
    for (int k = 0; k < RUNS; k++)
        ck_assert_int_eq(pthread_create(&thread[k], NULL, run_shared, &runs[k]), 0);
    for (int k = 0; k < RUNS; k++)
        ck_assert_int_eq(pthread_join(thread[k], NULL), 0);
    for (int k = 0; k < RUNS; k++) {
        vt_assert_ok(runs[k].status);
        ck_assert(vt_cloud_hash(&runs[k].out) == alone[k]);
        vor_cloud_free(&runs[k].out);
        vor_cloud_free(&runs[k].in);
    }
    vt_engine_close(&owner);
}

/* Coordinates that are multiples of 2^-20 survive these shifts exactly. */
static void shifted(struct vor_cloud *cloud, const struct vor_cloud *from, const double shift[3])
{
    double *xyz = malloc(from->n * 3 * sizeof *xyz);

    ck_assert_ptr_nonnull(xyz);
    for (size_t i = 0; i < 3 * from->n; i++)
        xyz[i] = rint((double)from->xyz[i] * 0x1p20) * 0x1p-20 + shift[i % 3];
    vt_cloud_make(cloud, from->n);
    vt_assert_ok(vor_cloud_set_double(cloud, xyz, &vt_err));
    free(xyz);
}

static void resample(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in)
{
    struct vt_engine engine;

    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", OUT);
    vt_engine_set(&engine, "iterations", "12");
    vt_engine_resample(&engine, out, report, in);
    vt_engine_close(&engine);
}

VT_TEST_FIGURES(a_shift_moves_the_result_and_changes_nothing_else, 0)
{
    static const double shifts[3][3] = {
        {637000.25, 5100000.5, 0}, {-4096, 123456.75, 6e6}, {0.5, -0.25, 0.125}};
    struct vor_cloud base, here, there, out_here, out_there;
    struct vor_report report_here, report_there;

    vt_cloud_dome(&base, 4, N);
    shifted(&here, &base, (double[3]){0, 0, 0});
    resample(&out_here, &report_here, &here);
    for (int k = 0; k < 3; k++) {
        shifted(&there, &base, shifts[k]);
        resample(&out_there, &report_there, &there);
        ck_assert(memcmp(out_here.xyz, out_there.xyz, 3 * OUT * sizeof *out_here.xyz) == 0);
        ck_assert_int_eq(out_there.position_type, VOR_FLOAT64);
        for (int c = 0; c < 3; c++)
            ck_assert(out_there.origin[c] - out_here.origin[c] == shifts[k][c]);
        ck_assert(report_here.delta == report_there.delta &&
                  report_here.sigma == report_there.sigma);
        vor_cloud_free(&out_there);
        vor_cloud_free(&there);
    }
    vor_cloud_free(&out_here);
    vor_cloud_free(&here);
    vor_cloud_free(&base);
}

/* Twice as large, half as large: a power of two costs nothing either. */
VT_TEST_FIGURES(a_power_of_two_scales_the_result_and_changes_nothing_else, 0)
{
    struct vor_cloud in, out, scaled;
    struct vor_report report, scaled_report;

    vt_cloud_box(&in, 5, N);
    resample(&out, &report, &in);
    for (int power = -40; power <= 60; power += 50) {
        struct vor_cloud other;

        vt_cloud_make(&other, N);
        for (size_t i = 0; i < 3 * N; i++)
            other.xyz[i] = ldexpf(in.xyz[i], power);
        resample(&scaled, &scaled_report, &other);
        for (size_t i = 0; i < 3 * OUT; i++)
            ck_assert(scaled.xyz[i] == ldexpf(out.xyz[i], power));
        ck_assert(scaled_report.delta == report.delta);
        ck_assert(scaled_report.area == ldexp(report.area, 2 * power));
        vor_cloud_free(&scaled);
        vor_cloud_free(&other);
    }
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}
