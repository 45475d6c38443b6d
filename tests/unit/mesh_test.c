/* Triangles over the points of a result: known shapes, sheets, orders, few points. */
#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { IN = 6000, POINTS = 750, FEW = 400 };

/* Tangent of the angle at which two sheets cross: four degrees. */
#define SLOPE 0.07

static void open_mesh(struct vt_engine *engine, unsigned threads, size_t points)
{
    vt_engine_open(engine, threads);
    vor_spec_preset(&engine->spec, vor_process_find("mesh"));
    vt_ask_set(engine, "iterations=6 polish=30");
    if (points > 0)
        vt_engine_count(engine, "points", points);
}

/* Meshes `points` points on a cloud. */
static void mesh_of(struct vt_meshed *out, const struct vor_cloud *in, size_t points)
{
    struct vt_engine engine;

    open_mesh(&engine, 2, points);
    vt_assert_ok(vt_engine_mesh(out, in, &engine));
    vt_engine_close(&engine);
}

static const float *corner(const struct vt_meshed *meshed, size_t t, int c)
{
    return &meshed->cloud.xyz[3 * (size_t)meshed->mesh.triangle[3 * t + (size_t)c]];
}

/* Six times the volume between a triangle and the origin. */
static double volume6(const struct vt_meshed *meshed, size_t t)
{
    const float *a = corner(meshed, t, 0), *b = corner(meshed, t, 1), *c = corner(meshed, t, 2);

    return (double)a[0] * ((double)b[1] * (double)c[2] - (double)b[2] * (double)c[1]) +
           (double)a[1] * ((double)b[2] * (double)c[0] - (double)b[0] * (double)c[2]) +
           (double)a[2] * ((double)b[0] * (double)c[1] - (double)b[1] * (double)c[0]);
}

static int by_value(const void *a, const void *b)
{
    uint64_t left = *(const uint64_t *)a, right = *(const uint64_t *)b;

    return (left > right) - (left < right);
}

/* Counts the edges that have a triangle on one side only; an edge that two run along the same way
 * fails. */
static size_t open_edges(const struct vor_mesh *mesh)
{
    size_t n = 3 * mesh->count, open = 0;
    uint64_t *runs = calloc(n + 1, sizeof *runs); /* from, to */

    ck_assert_ptr_nonnull(runs);
    for (size_t c = 0; c < n; c++)
        runs[c] = (uint64_t)mesh->triangle[c] << 32 | mesh->triangle[c - c % 3 + (c + 1) % 3];
    qsort(runs, n, sizeof *runs, by_value);
    for (size_t c = 0; c < n; c++) {
        uint64_t back = runs[c] << 32 | runs[c] >> 32;

        if (c > 0 && runs[c] == runs[c - 1])
            ck_abort_msg("two triangles run from %u to %u", (unsigned)(runs[c] >> 32),
                         (unsigned)runs[c]);
        open += bsearch(&back, runs, n, sizeof *runs, by_value) == NULL;
    }
    free(runs);
    return open;
}

static void assert_sound(const struct vt_meshed *meshed)
{
    for (size_t c = 0; c < 3 * meshed->mesh.count; c++)
        ck_assert_uint_lt(meshed->mesh.triangle[c], meshed->cloud.n);
    ck_assert_uint_eq(meshed->report.mesh_triangles, meshed->mesh.count);
    ck_assert_int_eq(meshed->report.has_mesh, 1);
    ck_assert_int_eq(meshed->report.mesh_manifold, VOR_YES);
}

VT_TEST_FIGURES(a_sphere_and_a_torus_are_closed_and_face_outward, VT_FEWER(VT_SOAK_LOOPS(1, 20)))
{
    static const double euler[] = {2, 0};

    for (int shape = 0; shape < VT_SMOOTH; shape++) {
        struct vor_cloud in;
        struct vt_meshed meshed;
        double volume = 0;

        vt_shapes[shape].make(&in, (uint64_t)_i, IN);
        mesh_of(&meshed, &in, POINTS);
        assert_sound(&meshed);
        ck_assert_uint_eq(open_edges(&meshed.mesh), 0);
        ck_assert_int_eq(meshed.report.mesh_closed, VOR_YES);
        ck_assert_double_eq(meshed.report.mesh_euler, euler[shape]);
        ck_assert_uint_eq(meshed.report.mesh_points, POINTS);
        ck_assert_uint_eq(meshed.report.mesh_components, 1);
        ck_assert_uint_eq(meshed.report.mesh_loops, 0);
        ck_assert_uint_eq(meshed.report.mesh_unsure, 0);
        ck_assert_uint_eq(meshed.report.mesh_left_out, 0);
        for (size_t t = 0; t < meshed.mesh.count; t++) {
            double here = volume6(&meshed, t);

            volume += here;
            if (shape == VT_SPHERE && !(here > 0))
                ck_abort_msg("triangle %zu faces inward", t);
        }
        ck_assert_double_gt(volume, 0);
        /* 0.94; of the points of resample, which are not moved for triangles, 0.87 */
        ck_assert_double_gt(meshed.report.mesh_quality_mean, 0.93);
        ck_assert_double_gt(meshed.report.mesh_angle_min, 20);
        vt_meshed_free(&meshed);
        vor_cloud_free(&in);
    }
}

/* Regressions: at edges of 70 degrees cells in tangent planes disagreed, it fell apart in its
 * faces; with as many input points a loop stayed open, the points of which lay badly until they
 * moved; flat, at edges of 32 degrees, triangles lay in the way of what would close loops. */
VT_TEST_FIGURES(a_tetrahedron_is_closed_and_faces_outward, VT_SOAK_LOOPS(4, 20))
{
    size_t n = _i == 0 ? 2000 : 800;
    float high = _i % 4 < 2 ? 1 : .3f;
    static const float tip[4][3] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    struct vor_cloud in;
    struct vt_meshed meshed;
    double volume = 0;

    vt_cloud_square(&in, 21 * (uint64_t)_i, n);
    for (size_t i = 0; i < in.n; i++) {
        float u = sqrtf(in.xyz[3 * i]), v = in.xyz[3 * i + 1];

        for (size_t c = 0; c < 3; c++)
            in.xyz[3 * i + c] = (1 - u) * tip[i % 4][c] + u * (1 - v) * tip[(i + 1) % 4][c] +
                                u * v * tip[(i + 2) % 4][c];
        in.xyz[3 * i + 2] *= high;
    }
    mesh_of(&meshed, &in, 800);
    assert_sound(&meshed);
    ck_assert_int_eq(meshed.report.mesh_closed, VOR_YES);
    ck_assert_double_eq(meshed.report.mesh_euler, 2);
    ck_assert_uint_eq(meshed.report.mesh_components, 1);
    for (size_t t = 0; t < meshed.mesh.count; t++)
        volume += volume6(&meshed, t) / 6;
    ck_assert_double_eq_tol(volume, 8. / 3 * (double)high, .05);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

static size_t open_edges_of_a_bowl(uint64_t draw, size_t points)
{
    const double w = 0.126, in2 = (1 - w) * (1 - w), rim = M_PI * w / 2 * (1 - w / 2);
    struct vor_cloud in;
    struct vt_meshed meshed;
    size_t open;

    vt_cloud_make(&in, points);
    for (size_t i = 0; i < in.n; i++) {
        double u = vt_unit(draw, 3 * i) * (1 + in2 + rim), r = u < 1 ? 1 : 1 - w;
        double t = vt_unit(draw, 3 * i + 1), way = 2 * M_PI * vt_unit(draw, 3 * i + 2);
        double up = u > 1 + in2 ? w / 2 * sin(M_PI * t) : -r * t;
        double out = u > 1 + in2 ? 1 - w / 2 + w / 2 * cos(M_PI * t) : sqrt(r * r - up * up);

        vor_to_floats(&in.xyz[3 * i], (double[]){out * cos(way), out * sin(way), up});
    }
    mesh_of(&meshed, &in, 2000);
    open = open_edges(&meshed.mesh);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
    return open;
}

/* A bowl of radius 1 whose wall is 1.55 spacings of its points thick. From four times as many
 * points one of eight draws has 4 open edges, the others none. From as many, the draws whose faces
 * clustering parts have 0, 0 and 10; 115 to 125 where lists do not go around the rim. */
VT_TEST_FIGURES(a_bowl_of_a_thin_wall_is_all_but_closed, VT_SOAK_LOOPS(2, 8))
{
    ck_assert_uint_le(open_edges_of_a_bowl((uint64_t)_i, 8000), 8);
    if (_i == 0 || _i == 3 || _i == 4)
        ck_assert_uint_le(open_edges_of_a_bowl((uint64_t)_i, 2000), 20);
}

VT_TEST_FIGURES(a_square_has_one_loop_and_a_cylinder_two, VT_FEWER(VT_SOAK_LOOPS(1, 20)))
{
    static const struct {
        int metric;
        size_t loops;
        double euler;
    } cases[] = {{VT_SQUARE, 1, 1}, {VT_CYLINDER, 2, 0}};

    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct vor_cloud in;
        struct vt_meshed meshed;

        vt_metrics[cases[k].metric].make(&in, (uint64_t)_i, IN, 0);
        mesh_of(&meshed, &in, POINTS);
        assert_sound(&meshed);
        ck_assert_uint_gt(open_edges(&meshed.mesh), 0);
        ck_assert_int_eq(meshed.report.mesh_closed, VOR_NO);
        ck_assert_uint_eq(meshed.report.mesh_loops, cases[k].loops);
        ck_assert_uint_eq(meshed.report.mesh_longest_count, cases[k].loops);
        ck_assert_double_eq(meshed.report.mesh_euler, cases[k].euler);
        vt_meshed_free(&meshed);
        vor_cloud_free(&in);
    }
}

/* The length and the middle of the one loop of a square of side 1. */
VT_TEST_FIGURES(a_loop_is_told_in_the_unit_of_the_cloud, 0)
{
    struct vor_cloud in;
    struct vt_meshed meshed;
    const struct vor_mesh_loop *loop = &meshed.report.mesh_longest[0];

    vt_cloud_square(&in, 3, IN);
    for (size_t i = 0; i < 3 * in.n; i++)
        in.xyz[i] *= 40;
    in.origin[0] = 500000;
    mesh_of(&meshed, &in, POINTS);
    ck_assert_uint_eq(meshed.report.mesh_loops, 1);
    ck_assert_double_eq_tol(loop->length, 4 * 40, 8);
    ck_assert_double_eq_tol(loop->middle[0], 500020, 2);
    ck_assert_double_eq_tol(loop->middle[1], 20, 2);
    ck_assert_double_gt((double)loop->edges, 4 * sqrt(POINTS) * 0.8);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

/* Gaps in spacings of the result, whose sheets are also nearer than the input's spacing. */
VT_TEST_FIGURES(no_triangle_joins_two_sheets, VT_FEWER(VT_SOAK_LOOPS(1, 10)))
{
    static const double gaps[] = {0.3, 0.6, 1, 2};

    for (size_t k = 0; k < sizeof gaps / sizeof *gaps; k++) {
        double gap = gaps[k] * sqrt(2 / (0.866 * POINTS));
        struct vor_cloud in;
        struct vt_meshed meshed;
        size_t across = 0;

        vt_cloud_sheets(&in, (uint64_t)_i, IN, gap);
        mesh_of(&meshed, &in, POINTS);
        assert_sound(&meshed);
        for (size_t t = 0; t < meshed.mesh.count; t++) {
            int upper = 0;

            for (int c = 0; c < 3; c++)
                upper += (double)corner(&meshed, t, c)[2] > gap / 2;
            across += upper % 3 != 0;
        }
        ck_assert_msg(across == 0, "gap %g: %zu triangles join the sheets", gaps[k], across);
        ck_assert_uint_gt(meshed.mesh.count, POINTS);
        vt_meshed_free(&meshed);
        vor_cloud_free(&in);
    }
}

static void assert_two_balls(const struct vor_cloud *in, size_t n)
{
    struct vt_meshed meshed;

    mesh_of(&meshed, in, n);
    assert_sound(&meshed);
    ck_assert_uint_eq(meshed.report.mesh_components, 2);
    ck_assert_double_eq(meshed.report.mesh_euler, 4);
    vt_meshed_free(&meshed);
}

/* Two balls of radius 1, as far apart as their 1,000 points each, drawn at random, are from each
 * other; normals of length 0 are none. Regression: without them they were joined, as so small a
 * spot was taken for none. Where the signs of normals say nothing, they change nothing. */
VT_TEST_FIGURES(balls_a_spacing_apart_stay_two, VT_SOAK_LOOPS(2, 8))
{
    enum { EACH = 1000 };
    double gap = sqrt(4 * 3.14159265 / (0.866 * EACH));
    struct vor_cloud in;
    struct vor_attribute *normal;
    struct vt_meshed plain, signs;

    vt_shapes[VT_SPHERE].make(&in, (uint64_t)_i + 6, (size_t)2 * EACH);
    mesh_of(&plain, &in, EACH / 2);
    vt_assert_ok(
        vor_cloud_add_attribute(&in, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &normal, &vt_err));
    for (size_t c = 0; c < 3 * in.n; c++)
        ((float *)normal->data)[c] = vor_rng_below(1, 1, c / 3, 2) ? in.xyz[c] : -in.xyz[c];
    mesh_of(&signs, &in, EACH / 2);
    ck_assert_mem_eq(signs.cloud.xyz, plain.cloud.xyz, 3 * sizeof(float) * plain.cloud.n);
    memcpy(normal->data, in.xyz, 3 * sizeof(float) * in.n);
    for (size_t i = EACH; i < in.n; i++)
        in.xyz[3 * i] += (float)(2 + gap);
    assert_two_balls(&in, EACH / 2);
    memset(normal->data, 0, 3 * sizeof(float) * in.n);
    assert_two_balls(&in, EACH / 2);
    vt_meshed_free(&signs);
    vt_meshed_free(&plain);
    vor_cloud_free(&in);
}

/* Height, and waves a unit over 2 pi, of two sheets that bend; their distance in input spacings. */
#define HIGH 0.03
#define WAVES 18.0
#define APART 0.4

/* Largest share of the triangles that may join them: of six seeds 0.002 to 0.018. */
#define JOINING 0.02

/* How far a point is over the lower of two wavy sheets, over their distance: 0 there, 1 on the
 * upper one. */
static double between_sheets(const float *x, double apart)
{
    return ((double)x[2] - HIGH * sin(WAVES * (double)x[0]) * sin(WAVES * (double)x[1])) / apart;
}

/* Triangles with corners nearest to two such sheets. */
static size_t joining(const struct vt_meshed *meshed, double apart)
{
    size_t across = 0;

    for (size_t t = 0; t < meshed->mesh.count; t++) {
        int upper = 0;

        for (int c = 0; c < 3; c++)
            upper += between_sheets(corner(meshed, t, c), apart) > 0.5;
        across += upper % 3 != 0;
    }
    return across;
}

/* Fits alone leave points 0.014 off on average, the surface through the points 0.007. */
VT_TEST_FIGURES(a_mesh_of_two_sheets_that_bend_lies_on_them_and_joins_them_at_few_places,
                VT_SOAK_LOOPS(1, 6))
{
    double apart = APART / sqrt(IN), off = 0;
    struct vor_cloud in;
    struct vt_meshed meshed;

    vt_cloud_sheets(&in, (uint64_t)_i, (size_t)2 * IN, apart);
    for (size_t i = 0; i < in.n; i++) {
        float *x = &in.xyz[3 * i];

        x[2] += (float)(HIGH * sin(WAVES * (double)x[0]) * sin(WAVES * (double)x[1]));
    }
    mesh_of(&meshed, &in, (size_t)2 * POINTS);
    assert_sound(&meshed);
    for (size_t i = 0; i < meshed.cloud.n; i++)
        off += fmin(fabs(between_sheets(&meshed.cloud.xyz[3 * i], apart)),
                    fabs(between_sheets(&meshed.cloud.xyz[3 * i], apart) - 1)) /
               (double)meshed.cloud.n;
    ck_assert_double_lt(off, 0.01);
    ck_assert_uint_gt(meshed.report.mesh_left_out, 0);
    ck_assert_msg((double)joining(&meshed, apart) <= JOINING * (double)meshed.mesh.count,
                  "%zu of %zu triangles join the sheets", joining(&meshed, apart),
                  (size_t)meshed.mesh.count);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

/* Two squares that cross along a line, at four degrees as a surface and its copy turned a little:
 * near the line points lie on both, and triangles join what they please. */
VT_TEST_FIGURES(where_sheets_cross_the_report_tells_how_many_triangles_are_unsure, 1)
{
    struct vor_cloud in;
    struct vt_meshed meshed;
    size_t across = 0;

    vt_cloud_sheets(&in, (uint64_t)_i, IN, 0);
    for (size_t i = 1; i < IN; i += 2)
        in.xyz[3 * i + 2] = (float)(SLOPE * ((double)in.xyz[3 * i] - 0.5));
    mesh_of(&meshed, &in, POINTS);
    assert_sound(&meshed);
    for (size_t t = 0; t < meshed.mesh.count; t++) {
        int slanted = 0;

        for (int c = 0; c < 3; c++) {
            const float *x = corner(&meshed, t, c);

            slanted += fabs((double)x[2]) > fabs((double)x[2] - SLOPE * ((double)x[0] - 0.5));
        }
        across += slanted % 3 != 0;
    }
    ck_assert_uint_gt(across, 0);
    ck_assert_uint_gt(meshed.report.mesh_unsure, 0);
    ck_assert_uint_lt(meshed.report.mesh_unsure, meshed.mesh.count / 4);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

/* Regression: nothing was unsure where the input has no lists of neighbours. */
VT_TEST_FIGURES(two_spheres_an_input_spacing_apart_are_unsure, 0)
{
    struct vor_cloud in;
    struct vt_meshed meshed;

    vt_cloud_sphere(&in, (uint64_t)_i + 1, 1000);
    for (size_t i = 0; i < in.n; i += 2)
        in.xyz[3 * i] += 2.13f; /* of 500 points on a unit sphere the spacing is .17 */
    mesh_of(&meshed, &in, 500);
    assert_sound(&meshed);
    ck_assert_uint_gt(meshed.report.mesh_unsure, 0);
    ck_assert_uint_lt(meshed.report.mesh_unsure, meshed.mesh.count / 4);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

/* In some draws of white noise two sheets two spacings apart are too near to be told apart. */
VT_TEST(of_balls_two_spacings_within_another_half_are_apart_from_it)
{
    int right = 0;

    for (uint64_t seed = 3; seed < 19; seed++) {
        struct vor_cloud in;
        struct vt_meshed meshed;

        vt_cloud_sphere(&in, seed, 3000);
        for (size_t i = 0; i < in.n; i++)
            for (size_t c = 0; c < 3 && i % 5 == 0; c++)
                in.xyz[3 * i + c] = in.xyz[3 * i + c] / 2 + (c == 2 ? .35f : 0);
        mesh_of(&meshed, &in, in.n);
        assert_sound(&meshed);
        right += meshed.report.mesh_closed == VOR_YES && meshed.report.mesh_euler == 4 &&
                 meshed.report.mesh_components == 2;
        vt_meshed_free(&meshed);
        vor_cloud_free(&in);
    }
    ck_assert_int_ge(right, 8);
}

/* Six times the volume of a tetrahedron. */
static double volume6_of(const float *a, const float *b, const float *c, const float *d)
{
    double u[3][3];

    for (int e = 0; e < 3; e++) {
        u[0][e] = (double)b[e] - (double)a[e];
        u[1][e] = (double)c[e] - (double)a[e];
        u[2][e] = (double)d[e] - (double)a[e];
    }
    return u[0][0] * (u[1][1] * u[2][2] - u[1][2] * u[2][1]) +
           u[0][1] * (u[1][2] * u[2][0] - u[1][0] * u[2][2]) +
           u[0][2] * (u[1][0] * u[2][1] - u[1][1] * u[2][0]);
}

/* Whether edge c of triangle s passes through triangle t, of which it has no corner. */
static int passes(const struct vt_meshed *meshed, size_t s, int c, size_t t)
{
    const float *p = corner(meshed, s, c), *q = corner(meshed, s, (c + 1) % 3), *a[3];
    double turn[3];

    for (int d = 0; d < 3; d++) {
        a[d] = corner(meshed, t, d);
        if (a[d] == p || a[d] == q)
            return 0;
    }
    if (!(volume6_of(a[0], a[1], a[2], p) * volume6_of(a[0], a[1], a[2], q) < 0))
        return 0;
    for (int d = 0; d < 3; d++)
        turn[d] = volume6_of(p, q, a[d], a[(d + 1) % 3]);
    return turn[0] * turn[1] > 0 && turn[1] * turn[2] > 0;
}

/* Regression: triangles were compared with those around one corner, and with none that shared one;
 * loops were closed without a look. */
VT_TEST_FIGURES(a_mesh_of_noisy_points_does_not_pass_through_itself, VT_FEWER(VT_SOAK_LOOPS(1, 5)))
{
    struct vor_cloud in;
    struct vt_meshed meshed;
    struct vt_engine engine;

    vt_cloud_sphere(&in, (uint64_t)_i, 1500);
    for (size_t i = 0; i < 3 * in.n; i++)
        in.xyz[i] += (float)(0.12 * vt_normal((uint64_t)_i + 1000, i)); /* 1.2 spacings */
    vt_engine_open(&engine, 2);
    vor_spec_preset(&engine.spec, vor_process_find("mesh"));
    vt_engine_set(&engine, "filters", "outliers"); /* and no point moves */
    vt_assert_ok(vt_engine_mesh(&meshed, &in, &engine));
    vt_engine_close(&engine);
    assert_sound(&meshed);
    ck_assert_uint_gt(meshed.mesh.count, in.n);
    for (size_t s = 0; s < meshed.mesh.count; s++)
        for (size_t t = 0; t < meshed.mesh.count; t++)
            for (int c = 0; c < 3; c++)
                if (passes(&meshed, s, c, t))
                    ck_abort_msg("triangle %zu passes through %zu", s, t);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

VT_TEST_FIGURES(triangles_follow_the_points_into_another_order, 0)
{
    struct vor_cloud in;
    struct vt_meshed spatial, progressive;
    struct vt_engine engine;

    vt_cloud_sphere(&in, 7, IN);
    open_mesh(&engine, 2, FEW);
    vt_assert_ok(vt_engine_mesh(&spatial, &in, &engine));
    vt_engine_set(&engine, "order", "progressive");
    vt_assert_ok(vt_engine_mesh(&progressive, &in, &engine));
    ck_assert_uint_eq(spatial.mesh.count, progressive.mesh.count);
    ck_assert(memcmp(spatial.mesh.triangle, progressive.mesh.triangle,
                     3 * spatial.mesh.count * sizeof *spatial.mesh.triangle) != 0);
    ck_assert_uint_eq(open_edges(&progressive.mesh), 0);
    for (size_t t = 0; t < spatial.mesh.count; t++)
        for (int c = 0; c < 3; c++)
            ck_assert(
                memcmp(corner(&spatial, t, c), corner(&progressive, t, c), 3 * sizeof(float)) == 0);
    vt_meshed_free(&spatial);
    vt_meshed_free(&progressive);
    vt_engine_close(&engine);
    vor_cloud_free(&in);
}

VT_TEST_FIGURES(a_moebius_band_has_one_side_and_one_loop, 0)
{
    struct vor_cloud in;
    struct vt_meshed meshed;

    vt_cloud_moebius(&in, 2, IN, 0.6);
    mesh_of(&meshed, &in, FEW);
    assert_sound(&meshed);
    ck_assert_uint_eq(meshed.report.mesh_components, 1);
    ck_assert_uint_eq(meshed.report.mesh_one_sided, 1);
    ck_assert_uint_eq(meshed.report.mesh_loops, 1);
    ck_assert_double_eq(meshed.report.mesh_euler, 0);
    vt_meshed_free(&meshed);
    vor_cloud_free(&in);
}

VT_TEST(fewer_than_three_points_have_no_triangles)
{
    struct vor_cloud in;
    struct vt_meshed meshed;

    vt_cloud_sphere(&in, 4, FEW);
    for (size_t n = 1; n < 4; n++) {
        mesh_of(&meshed, &in, n);
        assert_sound(&meshed);
        ck_assert_uint_le(meshed.mesh.count, n < 3 ? 0 : 1);
        ck_assert_uint_eq(meshed.cloud.n, n);
        vt_meshed_free(&meshed);
    }
    vor_cloud_free(&in);
}
