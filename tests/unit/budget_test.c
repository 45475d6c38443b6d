/* What becomes of a run whose time is over, wherever that happens. */
#include "tests/support/vt_ask.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { IN = 600, OUT = 1500, MOMENTS = 6 };

/* A clock that goes on by `step` seconds at every reading, by whichever thread. */
struct hours {
    atomic_uint readings;
    double step;
};

static double read_hours(void *ctx)
{
    struct hours *hours = ctx;

    return hours->step * (double)(atomic_fetch_add(&hours->readings, 1) + 1);
}

static enum vor_answer go_on(void *ctx)
{
    (void)ctx;
    return VOR_CONTINUE;
}

/* A request for many steps with wide fits, that may take a second by that clock. */
struct hurry {
    struct vt_engine engine;
    struct hours hours;
    struct vor_watch watch;
    struct vor_cloud in, out;
    struct vor_report report;
};

static void open_hurry(struct hurry *hurry, double step)
{
    memset(hurry, 0, sizeof *hurry);
    hurry->hours.step = step;
    hurry->watch = (struct vor_watch){.ctx = &hurry->hours, .poll = go_on, .clock = read_hours};
    vt_engine_open(&hurry->engine, 2);
    hurry->engine.run.watch = &hurry->watch;
    vt_cloud_sphere(&hurry->in, 3, IN);
    vt_engine_count(&hurry->engine, "points", OUT);
    vt_ask_set(&hurry->engine, "neighbors=60 iterations=200 polish=200 seconds=1");
}

static void close_hurry(struct hurry *hurry)
{
    vor_cloud_free(&hurry->out);
    vor_cloud_free(&hurry->in);
    vt_engine_close(&hurry->engine);
}

/* Farthest from the unit sphere. */
static double off_sphere(const struct vor_cloud *cloud)
{
    double most = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        most = fmax(most, fabs(sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) - 1));
    }
    return most;
}

static size_t fits(const struct vor_report *report)
{
    size_t count = 0;

    for (unsigned i = 0; i < report->fitted_count; i++)
        count += report->fitted[i].points;
    return count;
}

/* Each first point, the question whether it lies in a hole, and each figure of the report took a
 * fit or several, whatever the time was: 8.4 s of CPU for 16,000 points on 1,000 with 500
 * neighbors. */
VT_TEST(when_time_is_over_at_once_points_are_placed_without_a_fit)
{
    struct hurry hurry;

    open_hurry(&hurry, 1000);
    vt_engine_resample(&hurry.engine, &hurry.out, &hurry.report, &hurry.in);
    ck_assert_uint_eq(hurry.out.n, OUT);
    ck_assert_int_eq(hurry.report.stopped, VOR_STOPPED_SECONDS);
    ck_assert_uint_eq(fits(&hurry.report), 0);
    ck_assert_uint_le(hurry.report.queries, OUT); /* who is nearest to whom */
    ck_assert_double_lt(off_sphere(&hurry.out), 0.05);
    ck_assert_double_lt(hurry.report.ref_to_out.max, 0.35); /* 2.5 spacings of the input */
    ck_assert_double_lt(hurry.report.delta, 0.8);
    close_hurry(&hurry);
}

/* The last row: no method but kmeans takes as many points as there are. */
static const char *const variants[][2] = {
    {"boundary", "keep"},     {"metric", "lp"},         {"metric", "anisotropic"},
    {"density", "curvature"}, {"boundary", "sites"},    {"boundary", "fill"},
    {"normals", "fit"},       {"order", "progressive"}, {"intrinsic", "satellites"},
    {"method", "wlop"},       {"method", "ear"},        {"method", "kmeans"}};
enum { VARIANTS = sizeof variants / sizeof variants[0] };

/* A run reads its clock some thousand times: the steps are such that the time is over somewhere
 * among the first of these. */
VT_TEST_LOOP(whenever_time_is_over_a_run_hands_back_its_points, VARIANTS *MOMENTS)
{
    const char *const *variant = variants[_i % VARIANTS];
    int moment = _i / VARIANTS;
    struct hurry hurry;

    open_hurry(&hurry, pow(0.25, moment));
    vt_engine_set(&hurry.engine, variant[0], variant[1]);
    vt_engine_count(&hurry.engine, "points", _i % VARIANTS + 1 < VARIANTS ? OUT : IN / 2);
    vt_engine_resample(&hurry.engine, &hurry.out, &hurry.report, &hurry.in);
    ck_assert_uint_eq(hurry.out.n, _i % VARIANTS + 1 < VARIANTS ? OUT : IN / 2);
    ck_assert_int_eq(hurry.report.stopped, VOR_STOPPED_SECONDS);
    ck_assert_double_lt(off_sphere(&hurry.out), 0.2);
    close_hurry(&hurry);
}

VT_TEST(a_time_that_is_not_over_changes_no_byte)
{
    struct hurry hurry;
    uint64_t hash;

    open_hurry(&hurry, 1e-9);
    vt_ask_set(&hurry.engine, "iterations=3 polish=3");
    vt_engine_resample(&hurry.engine, &hurry.out, &hurry.report, &hurry.in);
    hash = vt_cloud_hash(&hurry.out);
    vor_cloud_free(&hurry.out);
    hurry.engine.spec.value[VOR_PARAM_SECONDS] = VOR_UNSET;
    vt_engine_resample(&hurry.engine, &hurry.out, &hurry.report, &hurry.in);
    ck_assert_uint_eq(vt_cloud_hash(&hurry.out), hash);
    ck_assert_int_eq(hurry.report.stopped, VOR_STOPPED_ITERATIONS);
    close_hurry(&hurry);
}
