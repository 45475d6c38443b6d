/* Frames of a sequence, each from the result of the one before: points stay where they are, and are
 * who they are. */
#include "core/base/linalg.h"
#include "tests/support/vt_ask.h"

#include <math.h>
#include <string.h>

enum { POINTS = 1500, SEEDS = 2, FRAMES = 4 };

/* Makes a sphere whose points have noise of 0.2 spacings, another one in each frame, or that grows
 * longer along x and turns about z, and is cut off at z = `cut`. */
static void make_frame(struct vor_cloud *cloud, uint64_t seed, unsigned frame, double noise,
                       double turn, double cut)
{
    double spacing = sqrt(4 * M_PI / (sqrt(3) / 2 * POINTS));
    double c = cos(turn * frame), s = sin(turn * frame);
    size_t n = 0;

    vt_cloud_sphere(cloud, seed, POINTS);
    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        for (size_t a = 0; a < 3; a++)
            x[a] = (double)cloud->xyz[3 * i + a] +
                   noise * spacing * vt_normal(seed + 100 * (frame + 1), 3 * i + a);
        if (x[2] > cut)
            continue;
        x[0] *= 1.2 + turn * frame;
        cloud->xyz[3 * n] = (float)(c * x[0] - s * x[1]);
        cloud->xyz[3 * n + 1] = (float)(s * x[0] + c * x[1]);
        cloud->xyz[3 * n++ + 2] = (float)x[2];
    }
    cloud->n = n;
}

static vor_status run(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                      const struct vor_cloud *previous, const char *options)
{
    struct vt_engine engine;
    vor_status status;

    vt_engine_open(&engine, 2);
    vt_ask_set(&engine, options);
    engine.previous = previous;
    status = vt_engine_try(&engine, out, report, in);
    vt_engine_close(&engine);
    return status;
}

static uint32_t track_of(const struct vor_cloud *cloud, size_t i)
{
    const struct vor_attribute *track = vor_cloud_find_name(cloud, VOR_TRACK);

    return track != NULL ? ((const uint32_t *)track->data)[i] : (uint32_t)i;
}

/* How many points live on, their mean square move, and that to the nearest point of the frame
 * before. Checks that tracks are of one point each, and those of new points new. */
struct compared {
    size_t kept;
    double moved2, nearest2;
};

static struct compared compare(const struct vor_cloud *before, const struct vor_cloud *now)
{
    struct compared out = {.kept = 0};
    uint32_t most = 0;

    for (size_t j = 0; j < before->n; j++)
        most = track_of(before, j) > most ? track_of(before, j) : most;
    for (size_t i = 0; i < now->n; i++) {
        double x[3], nearest2;
        size_t j = 0;

        for (size_t k = 0; k < i; k++)
            ck_assert_uint_ne(track_of(now, i), track_of(now, k));
        vor_cloud_position(now, i, x);
        nearest2 = vt_nearest2(before, x, NULL);
        out.nearest2 += nearest2 / (double)now->n;
        while (j < before->n && track_of(before, j) != track_of(now, i))
            j++;
        if (j == before->n) {
            ck_assert_uint_gt(track_of(now, i), most);
            continue;
        }
        out.kept++;
        out.moved2 += vor_distance2f(&now->xyz[3 * i], &before->xyz[3 * j]);
    }
    out.moved2 /= (double)out.kept;
    return out;
}

/* Mean square of how far points are off the surface of a frame that does not turn. */
static double off2(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        x[0] /= 1.2;
        sum += pow(sqrt(vor_dot(x, x)) - 1, 2) / (double)cloud->n;
    }
    return sum;
}

/* A row of frames: what their points do at least and at most. Those of frames with noise are nearer
 * to the surface than points of single runs. */
static const struct {
    const char *options;
    double noise, turn, kept, moved, delta;
} rows[] = {
    {"points=1500", 0.2, 0, 0.999, 0.2, 1.6},
    {"points=800", 0, 0.03, 0.98, 1e9, 1.8},
    {"points=800 boundary=sites density=curvature", 0, 0.03, 0.9, 1e9, 2},
    {"points=900 metric=anisotropic", 0, 0.03, 0.8, 1e9, 2},
};

VT_TEST_FIGURES(points_of_a_sequence_live_on, VT_FEWER(SEEDS))
{
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        struct vor_cloud before, alone;
        struct vor_report report, single;

        for (unsigned frame = 0; frame < FRAMES; frame++) {
            struct vor_cloud in, now;
            struct compared with, without = {.kept = 0};

            make_frame(&in, (uint64_t)_i + 1, frame, rows[k].noise, rows[k].turn, 2);
            vt_assert_ok(run(&now, &single, &in, NULL, rows[k].options));
            if (frame > 0) {
                without = compare(&alone, &now);
                vor_cloud_free(&alone);
            }
            alone = now;
            vt_assert_ok(run(&now, &report, &in, frame > 0 ? &before : NULL, rows[k].options));
            ck_assert_uint_eq(now.n, report.parameters.value[VOR_PARAM_POINTS]);
            if (frame > 0) {
                with = compare(&before, &now);
                ck_assert_double_ge((double)with.kept, rows[k].kept * (double)now.n);
                ck_assert_double_le(sqrt(with.moved2), rows[k].moved * sqrt(without.nearest2));
                ck_assert_double_le(report.delta, rows[k].delta * single.delta);
                ck_assert(rows[k].noise <= 0 || off2(&now) <= 0.95 * 0.95 * off2(&alone));
                vor_cloud_free(&before);
            }
            before = now;
            vor_cloud_free(&in);
        }
        vor_cloud_free(&alone);
        vor_cloud_free(&before);
    }
    vt_assert_no_leak();
}

/* The surface loses a part, and gets it back; the number of points changes; all lie in one place,
 * or there is one. */
VT_TEST_FIGURES(the_number_of_points_is_exact, VT_FEWER(SEEDS))
{
    static const struct {
        double cut;
        const char *options;
    } frames[] = {{2, "points=600"},   {0.2, "points=600 polish=4"},
                  {2, "points=600"},   {2, "points=90 polish=4"},
                  {2, "points=700"},   {2, "points=1 polish=4"},
                  {2, "points=40"},    {2, "points=300 coherence=0.4"},
                  {-0.9, "points=40"}, {2, "points=200 boundary=free patch=plane"}};
    struct vor_cloud before, now, in;
    struct vor_report report;

    for (size_t k = 0; k < sizeof frames / sizeof frames[0]; k++) {
        make_frame(&in, (uint64_t)_i + 1, 0, 0, 0, frames[k].cut);
        vt_assert_ok(run(&now, &report, &in, k > 0 ? &before : NULL, frames[k].options));
        ck_assert_uint_eq(now.n, report.parameters.value[VOR_PARAM_POINTS]);
        for (size_t i = 0; i < now.n; i++)
            ck_assert_double_le((double)now.xyz[3 * i + 2], frames[k].cut + 0.2);
        if (k > 0) {
            (void)compare(&before, &now);
            vor_cloud_free(&before);
        }
        before = now;
        if (k == 4) /* all in one place */
            for (size_t i = 0; i < before.n; i++)
                memcpy(&before.xyz[3 * i], before.xyz, 3 * sizeof *before.xyz);
        vor_cloud_free(&in);
    }
    vor_cloud_free(&before);
    vt_assert_no_leak();
}

/* Coherence of 0, and an earlier result somewhere else. */
VT_TEST(where_no_point_lives_on_the_result_is_that_of_a_single_run)
{
    struct vor_cloud in, single, first, now;
    struct vor_report report;

    make_frame(&in, 1, 0, 0, 0, 2);
    vt_assert_ok(run(&single, &report, &in, NULL, "points=300 polish=4"));
    vt_assert_ok(run(&first, &report, &in, &single, "points=300 polish=4 coherence=0"));
    ck_assert_mem_eq(first.xyz, single.xyz, 3 * single.n * sizeof *single.xyz);
    for (size_t i = 0; i < 3 * first.n; i++)
        first.xyz[i] = 1e30F;
    vt_assert_ok(run(&now, &report, &in, &first, "points=300 polish=4"));
    ck_assert_mem_eq(now.xyz, single.xyz, 3 * single.n * sizeof *single.xyz);
    ck_assert_uint_eq(compare(&first, &now).kept, 0);
    ((uint32_t *)first.attributes[0].data)[7] = UINT32_MAX;
    vor_cloud_free(&now);
    ck_assert_int_eq(run(&now, &report, &in, &first, "points=300"), VOR_E_PARAM);
    ck_assert_str_eq(vt_err.parameter, "previous");
    ((uint32_t *)first.attributes[0].data)[7] = track_of(&first, 8);
    vor_cloud_free(&now);
    ck_assert_int_eq(run(&now, &report, &in, &first, "points=300"), VOR_E_PARAM);
    vor_cloud_free(&now);
    vor_cloud_free(&first);
    vor_cloud_free(&single);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
