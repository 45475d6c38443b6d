/* Points that nothing points back to. */
#include "core/input/outliers.h"

#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 4, N = 12000, STRAYS = 120, K = 20 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    size_t dropped;
};

/* bed->cloud is there already. */
static void start(struct bed *bed, unsigned threads)
{
    vt_engine_open(&bed->engine, threads);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_outliers_drop(&bed->domain, &bed->dropped, &bed->engine.run, &vt_err));
    ck_assert_uint_eq(bed->domain.n + bed->dropped, bed->cloud.n);
}

static void end(struct bed *bed)
{
    vor_domain_free(&bed->domain);
    vt_engine_close(&bed->engine);
    vor_cloud_free(&bed->cloud);
}

/* Moves the first points off the sphere, by a tenth of its radius to a whole one. */
static void stray(struct vor_cloud *cloud, uint64_t seed)
{
    for (size_t i = 0; i < STRAYS; i++)
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] *= (float)(1.1 + 0.9 * vt_unit(seed, i));
}

VT_TEST_FIGURES(hardly_a_point_of_a_surface_is_one, VT_FEWER(VT_SOAK_LOOPS(2, SEEDS)))
{
    static void (*const makes[])(struct vor_cloud *, uint64_t, size_t) = {
        vt_cloud_sphere, vt_cloud_torus, vt_cloud_box, vt_cloud_dome, vt_cloud_square};

    for (size_t i = 0; i < sizeof makes / sizeof *makes; i++) {
        struct bed bed;

        makes[i](&bed.cloud, (uint64_t)_i, N);
        start(&bed, 2);
        ck_assert_uint_le(bed.dropped, N / 2000);
        end(&bed);
    }
}

/* Puts every `every`-th point anywhere in the box around a sphere of half its width. */
static void scatter(struct vor_cloud *cloud, uint64_t seed, size_t every)
{
    for (size_t i = 0; i < cloud->n; i += every)
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] = (float)(4 * vt_unit(seed, 3 * i + c) - 2);
}

static double off_sphere(const float x[3])
{
    return fabs(sqrt((double)(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])) - 1);
}

/* Regression: they are among the nearest of each other: half of a result lay between them. */
VT_TEST_FIGURES(points_that_fill_space_are_outliers_however_many, VT_FEWER(VT_SOAK_LOOPS(2, SEEDS)))
{
    static const size_t every[3] = {100, 50, 10};

    for (size_t e = 0; e < 3; e++) {
        size_t far = 0, kept = 0, cloud_n = N / every[e];
        struct bed bed;

        vt_cloud_sphere(&bed.cloud, (uint64_t)_i, N);
        scatter(&bed.cloud, (uint64_t)_i, every[e]);
        for (size_t i = 0; i < N; i++)
            far += off_sphere(&bed.cloud.xyz[3 * i]) > 0.2;
        start(&bed, 2);
        for (size_t i = 0; i < bed.domain.n; i++)
            kept += off_sphere(&bed.cloud.xyz[3 * (size_t)bed.domain.source[i]]) > 0.2;
        ck_assert_uint_gt(far, cloud_n / 2);
        ck_assert_msg(kept <= far / 50, "%zu of %zu kept, one in %zu", kept, far, every[e]);
        ck_assert_uint_le(bed.dropped, cloud_n + N / 1000);
        ck_assert_double_lt(bed.domain.sparse, 4 * bed.domain.usual6); /* not theirs */
        end(&bed);
    }
}

/* The same nearest points, thick around a corner, flat where a surface is thin. */
VT_TEST_FIGURES(thin_and_sharp_parts_of_a_surface_are_none, VT_FEWER(VT_SOAK_LOOPS(2, SEEDS)))
{
    struct bed bed;
    size_t kept = 0;

    vt_cloud_box(&bed.cloud, (uint64_t)_i, N);
    for (size_t i = 0; i < N; i++) /* one in 36 of those with x > 0.5: spacings six times as wide */
        if (bed.cloud.xyz[3 * i] < 0.5F || i % 36 == 0)
            memmove(&bed.cloud.xyz[3 * kept++], &bed.cloud.xyz[3 * i], 3 * sizeof(float));
    bed.cloud.n = kept;
    ck_assert_uint_ge(kept, N / 3);
    start(&bed, 2);
    ck_assert_uint_le(bed.dropped, N / 1000);
    end(&bed);
}

VT_TEST_FIGURES(few_points_have_none, VT_FEWER(VT_SOAK_LOOPS(2, SEEDS)))
{
    struct bed bed;

    vt_cloud_sphere(&bed.cloud, (uint64_t)_i, 199);
    stray(&bed.cloud, (uint64_t)_i);
    start(&bed, 2);
    ck_assert_uint_eq(bed.dropped, 0);
    end(&bed);
}

/* Tight balls of 21 points, far apart, each in the middle of the twelve corners of an icosahedron.
 * A corner has the ball nearer than any other corner, and the points of a ball have each other:
 * nothing points back to the corners, which are more than a third of all points. */
static void make_hubs(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    enum { BALL = K + 1, CORNERS = 12, HUB = BALL + CORNERS, ROW = 8 };
    const double golden = (1 + sqrt(5)) / 2, radius = sqrt(1 + golden * golden);

    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < n; i++) {
        size_t hub = i / HUB, part = i % HUB, corner = part - BALL;
        double at[3] = {10.0 * (double)(hub % ROW), 10.0 * (double)(hub / ROW), 0};
        double sign[2] = {corner & 1 ? 1 : -1, corner & 2 ? golden : -golden};

        for (size_t c = 0; c < 3; c++) {
            size_t turned = (c + corner / 4) % 3; /* 0: none, 1: the side of 1, 2: that of golden */
            double off = part < BALL  ? 0.01 * (double)cloud->xyz[3 * i + c]
                         : turned > 0 ? sign[turned - 1] / radius
                                      : 0;

            cloud->xyz[3 * i + c] = (float)(at[c] + off);
        }
    }
}

VT_TEST_FIGURES(where_more_than_a_quarter_would_go_all_stay, VT_FEWER(VT_SOAK_LOOPS(2, SEEDS)))
{
    enum { FEW = 33 * 45 };
    struct bed bed;

    make_hubs(&bed.cloud, (uint64_t)_i, FEW);
    start(&bed, 2);
    ck_assert_uint_eq(bed.dropped, 0);
    end(&bed);
}

/* Mean distance to the unit sphere of a result, and what the report counts. */
static double off(const struct vor_cloud *in, const char *method, const char *outliers,
                  uint64_t *counted)
{
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;
    double mean;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "points", "1500");
    vt_engine_set(&engine, "method", method);
    if (outliers != NULL)
        vt_engine_set(&engine, "outliers", outliers);
    vt_engine_set(&engine, "polish", "20");
    vt_engine_resample(&engine, &out, &report, in);
    ck_assert_uint_eq(out.n, 1500);
    ck_assert_uint_eq(report.points_in, in->n);
    mean = vt_off_mean(&vt_shapes[VT_SPHERE], &out);
    *counted = report.outliers;
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return mean;
}

VT_TEST_FIGURES(a_result_without_them_lies_on_the_surface, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud cloud;
    uint64_t none, some;
    double with, without;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    stray(&cloud, (uint64_t)_i);
    with = off(&cloud, "cvt", "keep", &none);
    without = off(&cloud, "cvt", "drop", &some);
    ck_assert_uint_eq(none, 0);
    ck_assert_uint_ge(some, STRAYS * 49 / 50);
    ck_assert_msg(without < with / 10, "%g off, %g with them", without, with);
    cloud.xyz[0] = 1e9F; /* beside which float32 tells no others apart */
    ck_assert_double_lt(off(&cloud, "cvt", "drop", &some), with / 10);
    ck_assert_uint_ge(some, STRAYS * 49 / 50);
    vor_cloud_free(&cloud);
}

/* Outliers hide the edges that ear is asked for. */
VT_TEST(ear_drops_them_and_others_keep_them_unless_told)
{
    struct vor_cloud cloud;
    uint64_t dropped, kept;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    stray(&cloud, (uint64_t)_i);
    ck_assert_double_lt(off(&cloud, "ear", NULL, &dropped), 0.01);
    ck_assert_uint_ge(dropped, STRAYS * 49 / 50);
    ck_assert_double_lt(off(&cloud, "ear", "keep", &kept), /* a draw of its share of them */
                        1.3 * vt_off_mean(&vt_shapes[VT_SPHERE], &cloud));
    ck_assert_uint_eq(kept, 0);
    (void)off(&cloud, "cvt", NULL, &kept);
    ck_assert_uint_eq(kept, 0);
    vor_cloud_free(&cloud);
}
