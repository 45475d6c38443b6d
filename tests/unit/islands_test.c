/* Small parts of the input, clear of all others. */
#include "core/base/linalg.h"
#include "core/input/islands.h"
#include "tests/support/vt_ask.h"
#include "tests/support/vt_data.h"

#include <math.h>

enum { CLUSTERS = 4, STRAYS = 43, SCAN = 4000, SEEDS = 3 };

static const size_t cluster_of[CLUSTERS] = {1, 4, 8, 30};

/* Where a cluster lies: 4 to 8 from the origin. */
static void middle_of(uint64_t seed, size_t cluster, double x[3])
{
    double length = 0, far = 4 + 4 * vt_unit(seed + 50, cluster);

    for (size_t c = 0; c < 3; c++) {
        x[c] = vt_unit(seed + 60, 3 * cluster + c) - 0.5 + (c == cluster % 3 ? 1.0 : 0.0);
        length += x[c] * x[c];
    }
    for (size_t c = 0; c < 3; c++)
        x[c] *= (cluster & 1 ? 1 : -1) * far / sqrt(length);
}

/* Puts `count` points around x, 0.02 apart at most. */
static void put_cluster(float *xyz, uint64_t seed, size_t count, const double x[3])
{
    for (size_t i = 0; i < 3 * count; i++)
        xyz[i] = (float)(x[i % 3] + 0.02 * (vt_unit(seed, i) - 0.5));
}

/* The unit sphere, n points, and after them the clusters. */
static void make_scan(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    size_t at = n;

    vt_cloud_sphere(cloud, seed, n + STRAYS);
    for (size_t cluster = 0; cluster < CLUSTERS; cluster++) {
        double x[3];

        middle_of(seed, cluster, x);
        put_cluster(&cloud->xyz[3 * at], seed + cluster, cluster_of[cluster], x);
        at += cluster_of[cluster];
    }
}

/* `count` clusters of `each` points, 1 apart, on a lattice in the plane z = 0. */
static void make_clusters(struct vor_cloud *cloud, uint64_t seed, size_t count, size_t each)
{
    vt_cloud_make(cloud, count * each);
    for (size_t i = 0; i < count; i++)
        put_cluster(&cloud->xyz[3 * i * each], seed + i, each,
                    (double[3]){(double)(i % 10), (double)(i / 10), 0});
}

/* Whether a point has the place of one of the points first .. first + count - 1 of the input. */
static int is_one_of(const float *x, const struct vor_cloud *in, size_t first, size_t count)
{
    for (size_t i = first; i < first + count; i++)
        if (vor_distance2f(x, &in->xyz[3 * i]) == 0)
            return 1;
    return 0;
}

static size_t count_at(const struct vor_cloud *out, const struct vor_cloud *in, size_t first,
                       size_t count)
{
    size_t found = 0;

    for (size_t i = 0; i < out->n; i++)
        found += (size_t)is_one_of(&out->xyz[3 * i], in, first, count);
    return found;
}

/* Results that are not near the unit sphere. */
static size_t off_sphere(const struct vor_cloud *out)
{
    size_t off = 0;

    for (size_t i = 0; i < out->n; i++)
        off += vor_distance2f(&out->xyz[3 * i], (float[3]){0, 0, 0}) > 1.5 * 1.5;
    return off;
}

static void resample(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                     size_t points, const char *outliers)
{
    vt_resample(out, report, in, "points=%zu polish=8 outliers=%s", points, outliers);
    ck_assert_uint_eq(out->n, points);
    ck_assert_uint_eq(report->points_out, points);
}

VT_TEST_FIGURES(each_gets_at_most_its_own_points_in_their_places, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static const size_t wanted[] = {1, 3, 300, 2000, SCAN + SCAN / 2};

    for (size_t w = 0; w < sizeof wanted / sizeof *wanted; w++) {
        struct vor_cloud in, out;
        struct vor_report report;
        size_t at = SCAN, all = 0;

        make_scan(&in, (uint64_t)_i, SCAN);
        resample(&out, &report, &in, wanted[w], "keep");
        for (size_t cluster = 0; cluster < CLUSTERS; cluster++) {
            size_t found = count_at(&out, &in, at, cluster_of[cluster]);

            ck_assert_uint_le(found, cluster_of[cluster]);
            at += cluster_of[cluster];
            all += found;
        }
        ck_assert_uint_eq(all, off_sphere(&out));
        ck_assert_uint_eq(report.parts, CLUSTERS + 1);
        ck_assert_uint_eq(report.islands, CLUSTERS);
        ck_assert_uint_eq(report.in_islands, STRAYS);
        ck_assert_uint_eq(report.on_islands, all);
        ck_assert_uint_eq(all, wanted[w] > SCAN ? STRAYS : wanted[w] * STRAYS / (SCAN + STRAYS));
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
}

VT_TEST_FIGURES(points_beside_islands_are_as_even_as_without_any, VT_FEWER(VT_SOAK_LOOPS(1, 2)))
{
    enum { LARGE = 100000, POINTS = 1500 };
    struct vor_cloud in, out;
    struct vor_report with, without;

    make_scan(&in, (uint64_t)_i, LARGE);
    resample(&out, &with, &in, POINTS, "keep");
    vor_cloud_free(&out);
    ck_assert_uint_eq(with.islands, CLUSTERS);
    in.n = LARGE;
    resample(&out, &without, &in, POINTS, "keep");
    in.n = LARGE + STRAYS;
    ck_assert_uint_eq(without.islands, 0);
    ck_assert_double_eq(without.delta_beside, without.delta);
    ck_assert_double_eq_tol(with.delta_beside / without.delta, 1, 0.08);
    vt_free_last(&out, &in);
}

/* The number is exact whatever it is, and none lies between the parts. */
VT_TEST_FIGURES(more_points_than_small_parts_have_are_spread_over_them, 0)
{
    static const size_t wanted[] = {201, 400, 2000};

    for (size_t w = 0; w < sizeof wanted / sizeof *wanted; w++) {
        struct vor_cloud in, out;
        struct vor_report report;
        size_t on[25] = {0};

        make_clusters(&in, (uint64_t)_i, 25, 8);
        resample(&out, &report, &in, wanted[w], "keep");
        ck_assert_uint_eq(report.islands, 25);
        ck_assert_uint_eq(report.on_islands, 0);
        for (size_t i = 0; i < out.n; i++) {
            float x = rintf(out.xyz[3 * i]), y = rintf(out.xyz[3 * i + 1]);

            ck_assert_double_lt(vor_distance2f(&out.xyz[3 * i], (float[3]){x, y, 0}), 0.05 * 0.05);
            on[(size_t)(10 * y + x)]++;
        }
        for (size_t i = 0; i < 25; i++)
            ck_assert_uint_gt(on[i], 0);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
}

/* A floor beside the sphere, 20 times as coarse and one point in fifty. */
VT_TEST_FIGURES(a_coarse_part_of_the_surface_is_no_islands, VT_SOAK_LOOPS(1, SEEDS))
{
    enum { N = 20000, FLOOR = 400 };
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N + FLOOR);
    for (size_t i = 0; i < FLOOR; i++) {
        float *x = &in.xyz[3 * (N + i)];

        x[0] = (float)(10 * (vt_unit((uint64_t)_i + 80, 2 * i) - 0.5));
        x[1] = (float)(10 * (vt_unit((uint64_t)_i + 80, 2 * i + 1) - 0.5));
        x[2] = -1.5F;
    }
    resample(&out, &report, &in, 300, "keep");
    ck_assert_uint_eq(report.islands, 0);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(drop_leaves_out_those_that_a_fit_does_not_fill, 0)
{
    struct vor_cloud in, out;
    struct vor_report report;

    make_scan(&in, (uint64_t)_i, SCAN);
    resample(&out, &report, &in, SCAN + 100, "drop");
    ck_assert_uint_ge(report.outliers, 1 + 4 + 8);
    ck_assert_uint_eq(count_at(&out, &in, SCAN, 1 + 4 + 8), 0);
    ck_assert_uint_eq(count_at(&out, &in, SCAN + 13, 30), 30);
    ck_assert_uint_eq(report.islands, 1);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(drop_keeps_an_input_of_small_parts, SEEDS)
{
    struct vor_cloud in, out;
    struct vor_report report;

    make_clusters(&in, (uint64_t)_i, 50, 15);
    resample(&out, &report, &in, 500, "drop");
    ck_assert_uint_eq(report.outliers, 0);
    for (size_t i = 0; i < 50; i++)
        ck_assert_uint_eq(count_at(&out, &in, 15 * i, 15), 10);
    vt_free_last(&out, &in);
}

/* Each point carries its own number. */
static void number(struct vor_cloud *cloud)
{
    struct vor_attribute *attribute;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "number", VOR_GENERIC, VOR_UINT32, 1, &attribute, &vt_err));
    for (size_t i = 0; i < cloud->n; i++)
        ((uint32_t *)attribute->data)[i] = (uint32_t)i;
}

VT_TEST_FIGURES(their_points_bring_attributes_and_normals_in_any_order, 0)
{
    struct vor_cloud in, out;
    struct vor_report report;
    const uint32_t *carried;
    size_t off = 0;

    make_scan(&in, 3, SCAN);
    number(&in);
    vt_resample(&out, &report, &in, "points=%d polish=5 order=progressive normals=fit", SCAN);
    ck_assert_uint_eq(out.n, SCAN);
    ck_assert_ptr_nonnull(vor_cloud_find(&out, VOR_NORMAL));
    carried = (const uint32_t *)out.attributes[0].data;
    for (size_t i = 0; i < out.n; i++)
        if (is_one_of(&out.xyz[3 * i], &in, SCAN, STRAYS)) {
            ck_assert(vor_distance2f(&out.xyz[3 * i], &in.xyz[3 * (size_t)carried[i]]) == 0);
            off++;
        }
    ck_assert_uint_eq(off, report.on_islands);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(spacing_asks_for_points_of_the_rest_and_islands_have_theirs_beside, 0)
{
    struct vor_cloud in, out;
    struct vor_report report;

    make_scan(&in, 2, SCAN);
    vt_resample(&out, &report, &in, "spacing=0.05 polish=5");
    ck_assert_double_eq_tol(report.area, 4 * 3.14159, 0.3);
    ck_assert_double_eq_tol((double)(out.n - report.on_islands), 12.566 / (0.8660 * 0.0025), 150);
    ck_assert_uint_eq(report.on_islands, off_sphere(&out));
    vt_free_last(&out, &in);
}

/* Also not of their ragged ends. office1 has two parts, one behind a window. */
VT_TEST_FIGURES(a_real_scan_has_hardly_any_islands, 4)
{
    static const size_t most[] = {0, 0, 0, 4}; /* far returns of kitti */
    static const char *const names[] = {"scannet.ply", "office1.ply", "autzen.ply",
                                        "kitti_000008.ply"};
    struct vt_engine engine;
    struct vor_cloud in;
    struct vor_domain domain;

    if (!vt_cloud_open(&in, names[_i]))
        return;
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_domain_init(&domain, &in, &engine.run, &vt_err));
    vt_assert_ok(vor_islands_take(&domain, 1000, &engine.run, &vt_err));
    ck_assert_uint_le(domain.known.islands, most[_i]);
    ck_assert_uint_eq(domain.known.parts, (_i == 1 ? 2 : 1) + domain.known.islands);
    vor_domain_free(&domain);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}

/* A lattice that is ten times as coarse on one side, and over the fine side a point, or five of
 * which each is nearest to others of them, not so far from it as points of the coarse side are from
 * each other: they hold themselves, and no disc of others. */
VT_TEST_LOOP(lone_points_beside_a_coarse_side_hold_no_disc, 2)
{
    static const float over[][3] = {
        {30, 30, 15}, {42, 30, 14}, {43, 30, 14}, {30, 44, 16}, {18, 30, 16}};
    enum { FINE = 60, COARSE = 8, AT = FINE * FINE + COARSE * COARSE };
    struct vor_report report;
    struct vor_cloud in, out;
    size_t near = 0, strays = _i == 0 ? 1 : sizeof over / sizeof *over;

    vt_cloud_make(&in, AT + strays);
    for (size_t i = 0; i < AT; i++) {
        size_t side = i < FINE * FINE ? FINE : COARSE, at = i < FINE * FINE ? i : i - FINE * FINE;
        double step = side == FINE ? 1 : 8, x = (double)(at % side), y = (double)(at / side);

        in.xyz[3 * i] = (float)(step * (x + 0.1 * vt_unit(3, 2 * i)) + (side == FINE ? 0 : FINE));
        in.xyz[3 * i + 1] = (float)(step * (y + 0.1 * vt_unit(3, 2 * i + 1)));
        in.xyz[3 * i + 2] = 0;
    }
    memcpy(&in.xyz[3 * (size_t)AT], over, strays * sizeof *over);
    vt_resample(&out, &report, &in, "points=3600");
    for (size_t i = 0; i < out.n; i++) {
        double x[3];

        vor_cloud_position(&out, i, x);
        near += x[2] > 4;
    }
    ck_assert_uint_le(near, strays);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}
