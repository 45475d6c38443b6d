/* Holes that are filled, and borders that are not, on surfaces that are known. */
#include "core/geom/spline.h"
#include "core/input/holes.h"
#include "core/input/loops.h"
#include "tests/support/vt_ask.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 2, N = 5000, TO = 600 };

/* Takes out the points within `radius` of a place. */
static void punch(struct vor_cloud *cloud, double x, double y, double z, double radius)
{
    size_t left = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        const float *p = &cloud->xyz[3 * i];
        double a = (double)p[0] - x, b = (double)p[1] - y, c = (double)p[2] - z;

        if (a * a + b * b + c * c >= radius * radius)
            memmove(&cloud->xyz[3 * left++], p, 3 * sizeof *p);
    }
    cloud->n = left;
}

/* Spacings of the ball, a lattice as dense. */
static double spacing(void)
{
    return sqrt(4 * M_PI / N);
}

/* A ball with holes of six spacings at the top and of ten at the bottom. */
static void punched_ball(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_sphere(cloud, seed, N);
    punch(cloud, 0, 0, 1, 3 * spacing());
    punch(cloud, 0, 0, -1, 5 * spacing());
}

static void punched_square(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_square(cloud, seed, N);
    punch(cloud, 0.4, 0.6, 0, 0.1);
}

struct filled {
    struct vor_cloud out;
    struct vor_report report;
};

static vor_status try(struct filled *filled, const struct vor_cloud *in, const char *name,
                      const char *value, unsigned threads)
{
    struct vt_engine engine;
    vor_status status;

    vt_engine_open(&engine, threads);
    vt_engine_count(&engine, "points", TO);
    vt_ask_set(&engine, "iterations=4 polish=10 boundary=fill");
    if (name != NULL)
        vt_engine_set(&engine, name, value);
    status = vt_engine_try(&engine, &filled->out, &filled->report, in);
    vt_engine_close(&engine);
    return status;
}

/* Resamples with holes filled; one more parameter, or NULL. */
static struct filled fill(const struct vor_cloud *in, const char *name, const char *value)
{
    struct filled filled;

    vt_assert_ok(try(&filled, in, name, value, 2));
    ck_assert_uint_eq(filled.out.n, TO);
    ck_assert(filled.report.has_holes);
    ck_assert_uint_eq(filled.report.holes_loops, filled.report.holes_count);
    for (unsigned i = 0; i < filled.report.holes_count; i++)
        ck_assert_uint_eq(filled.report.holes[i].id, i + 1);
    return filled;
}

/* How many loops a cloud has. */
static size_t loops_of(const struct vor_cloud *cloud)
{
    struct vt_engine engine;
    struct vor_domain domain;
    struct vor_loops loops;
    size_t count;

    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_domain_init(&domain, cloud, &engine.run, &vt_err));
    vt_assert_ok(vor_loops_find(&loops, &domain, &engine.run, &vt_err));
    count = loops.count;
    vor_loops_free(&loops);
    vor_domain_free(&domain);
    vt_engine_close(&engine);
    return count;
}

static void assert_hole(const struct filled *filled, unsigned i, enum vor_loop_kind kind,
                        enum vor_hole_outcome outcome)
{
    const struct vor_hole_told *told = &filled->report.holes[i];

    ck_assert_uint_lt(i, filled->report.holes_count);
    ck_assert_msg(told->kind == kind && told->outcome == outcome, "loop %u: kind %d, outcome %d",
                  told->id, (int)told->kind, (int)told->outcome);
    ck_assert((told->points > 0) == (outcome == VOR_HOLE_FILLED));
}

/* Root mean square distance to the unit ball of the points within `radius` of a pole. */
static double off_ball(const struct vor_cloud *cloud, double z, double radius, size_t *count)
{
    double sum = 0;

    *count = 0;
    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        if (x[0] * x[0] + x[1] * x[1] + (x[2] - z) * (x[2] - z) >= radius * radius)
            continue;
        sum += pow(sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) - 1, 2);
        ++*count;
    }
    return sqrt(sum / (double)(*count > 0 ? *count : 1));
}

/* Points in holes are as many as their area has of the ball's, and lie on it. */
VT_TEST_FIGURES(holes_of_a_ball_are_closed, VT_FEWER(SEEDS))
{
    static const double radius[] = {5, 3}, z[] = {-1, 1}, most[] = {0.1, 0.05};
    struct vor_cloud cloud;
    struct filled filled;

    punched_ball(&cloud, (uint64_t)_i);
    ck_assert_uint_eq(loops_of(&cloud), 2);
    filled = fill(&cloud, NULL, NULL);
    ck_assert_uint_eq(filled.report.holes_filled, 2);
    ck_assert_uint_eq(filled.report.holes_not_closed, 0);
    ck_assert_uint_eq(filled.report.holes_points,
                      filled.report.holes[0].points + filled.report.holes[1].points);
    ck_assert_uint_eq(filled.report.points_in, cloud.n);
    ck_assert_uint_eq(filled.report.boundary_points, 0);
    ck_assert_uint_eq(loops_of(&filled.out), 0);
    for (unsigned k = 0; k < 2; k++) {
        double wide = radius[k] * spacing(), wanted = TO * wide * wide / 4, off;
        size_t count;

        assert_hole(&filled, k, VOR_LOOP_HOLE, VOR_HOLE_FILLED);
        off = off_ball(&filled.out, z[k], wide, &count);
        ck_assert_msg(off < most[k] * spacing(), "rms %g spacings", off / spacing());
        ck_assert_msg(fabs((double)count - wanted) < 0.15 * wanted + 3, "%zu points, want %g",
                      count, wanted);
        ck_assert_double_eq_tol(filled.report.holes[k].centre[2] / z[k], 1, 0.1);
    }
    vt_free_last(&filled.out, &cloud);
}

/* The outer border of a sheet is none that auto fills, whatever holeMax is. */
VT_TEST_FIGURES(the_rim_of_a_sheet_stays_open, 0)
{
    struct vor_cloud cloud;
    struct filled filled;

    punched_square(&cloud, (uint64_t)_i);
    filled = fill(&cloud, "holeMax", "100");
    ck_assert_uint_eq(filled.report.holes_filled, 1);
    assert_hole(&filled, 0, VOR_LOOP_RIM, VOR_HOLE_RIM);
    assert_hole(&filled, 1, VOR_LOOP_HOLE, VOR_HOLE_FILLED);
    ck_assert_double_eq_tol(filled.report.holes[1].centre[0], 0.4, 0.01);
    ck_assert_uint_gt(filled.report.boundary_points, 60);
    ck_assert_uint_eq(loops_of(&filled.out), 1);
    for (size_t i = 0; i < filled.out.n; i++)
        ck_assert_double_lt(fabs((double)filled.out.xyz[3 * i + 2]), 1e-5);
    vor_cloud_free(&filled.out);
    filled = fill(&cloud, "holeMax", "0.5");
    ck_assert_uint_eq(filled.report.holes_filled, 0);
    assert_hole(&filled, 1, VOR_LOOP_HOLE, VOR_HOLE_TOO_LONG);
    vt_free_last(&filled.out, &cloud);
}

/* A tube ends in rims, which auto leaves; by its number one is capped. */
VT_TEST_FIGURES(an_end_of_a_tube_is_capped_if_it_is_named, 0)
{
    struct vor_cloud cloud;
    struct filled filled;
    double z;
    size_t beyond = 0, inside = 0;

    vt_metrics[VT_CYLINDER].make(&cloud, (uint64_t)_i, N, 0);
    filled = fill(&cloud, NULL, NULL);
    ck_assert_uint_eq(filled.report.holes_filled, 0);
    assert_hole(&filled, 0, VOR_LOOP_RIM, VOR_HOLE_RIM);
    assert_hole(&filled, 1, VOR_LOOP_RIM, VOR_HOLE_RIM);
    vor_cloud_free(&filled.out);
    filled = fill(&cloud, "holes", "2");
    assert_hole(&filled, 0, VOR_LOOP_RIM, VOR_HOLE_NOT_CHOSEN);
    assert_hole(&filled, 1, VOR_LOOP_RIM, VOR_HOLE_FILLED);
    z = filled.report.holes[1].centre[2];
    for (size_t i = 0; i < filled.out.n; i++) {
        const float *p = &filled.out.xyz[3 * i];
        double r = sqrt((double)p[0] * (double)p[0] + (double)p[1] * (double)p[1]);

        beyond += (z > 1 ? (double)p[2] - 2 : -(double)p[2]) > 0.05;
        inside += r < 0.4;
        ck_assert_double_lt(r, 0.55);
        ck_assert_double_gt((double)p[2], -0.6);
        ck_assert_double_lt((double)p[2], 2.6);
    }
    ck_assert_uint_gt(inside, TO / 20); /* a disc in its place has a ninth of the area */
    ck_assert_uint_gt(beyond, TO / 50); /* the tube goes on, so that the cap is a dome */
    ck_assert_uint_eq(loops_of(&filled.out), 1);
    vt_free_last(&filled.out, &cloud);
}

/* A disc that floats in a hole lies where the surface would go: neither loop can be closed. */
VT_TEST_FIGURES(what_lies_in_the_way_keeps_a_hole_open, 0)
{
    struct vor_cloud cloud;
    struct filled filled;
    size_t left = 0;

    vt_cloud_square(&cloud, 1, N);
    for (size_t i = 0; i < cloud.n; i++) {
        const float *p = &cloud.xyz[3 * i];
        double x = (double)p[0] - 0.5, y = (double)p[1] - 0.5, r2 = x * x + y * y;

        if (r2 < 0.2 * 0.2 || r2 > 0.3 * 0.3)
            memmove(&cloud.xyz[3 * left++], p, 3 * sizeof *p);
    }
    cloud.n = left;
    filled = fill(&cloud, "holes", "2");
    ck_assert_uint_eq(filled.report.holes_loops, 3);
    assert_hole(&filled, 1, VOR_LOOP_HOLE, VOR_HOLE_NOT_CLOSED);
    ck_assert_uint_eq(filled.report.holes_not_closed, 1);
    ck_assert_uint_eq(filled.report.holes_points, 0);
    vor_cloud_free(&filled.out);
    vor_cloud_free(&cloud);
}

VT_TEST_FIGURES(a_number_that_no_loop_has_is_refused, 0)
{
    struct vor_cloud cloud;
    struct filled filled;

    punched_ball(&cloud, 1);
    vt_assert_fails(VOR_E_HOLES, try(&filled, &cloud, "holes", "1,3", 2));
    ck_assert_str_eq(vt_err.parameter, "holes");
    ck_assert_ptr_nonnull(
        strstr(vt_err.message, "holes contains 3, but the border loops are numbered from 1 to 2"));
    vor_cloud_free(&cloud);
    vt_cloud_sphere(&cloud, 1, N);
    vt_assert_fails(VOR_E_HOLES, try(&filled, &cloud, "holes", "1", 2));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "has no border loops"));
    vor_cloud_free(&cloud);
}

/* What a closed input has of boundary=fill is what it has of keep. */
VT_TEST_FIGURES(a_closed_input_stays_as_it_is, 0)
{
    struct vor_cloud cloud;
    struct filled filled, kept;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    filled = fill(&cloud, NULL, NULL);
    ck_assert_uint_eq(filled.report.holes_loops, 0);
    vt_assert_ok(try(&kept, &cloud, "boundary", "keep", 2));
    ck_assert(!kept.report.has_holes);
    ck_assert(vt_cloud_hash(&kept.out) == vt_cloud_hash(&filled.out));
    vor_cloud_free(&kept.out);
    vor_cloud_free(&filled.out);
    vor_cloud_free(&cloud);
}

/* A spline through a quadric is that quadric; too few points are none. */
VT_TEST_FIGURES(a_spline_has_the_quadrics, 0)
{
    double at[2 * 30], value[3 * 30], u[2] = {0.1, -0.2}, x[3];
    struct vor_spline spline;

    for (size_t i = 0; i < 30; i++) {
        double a = 2 * vt_unit(1, 2 * i) - 1, b = 2 * vt_unit(1, 2 * i + 1) - 1;

        at[2 * i] = a;
        at[2 * i + 1] = b;
        value[3 * i] = a;
        value[3 * i + 1] = b - 3;
        value[3 * i + 2] = 1 + a * a - 2 * a * b;
    }
    vt_assert_ok(vor_spline_fit(&spline, at, value, 30, 0, &vt_memory, &vt_err));
    vor_spline_at(&spline, u, x);
    ck_assert_double_eq_tol(x[0], 0.1, 1e-10);
    ck_assert_double_eq_tol(x[1], -3.2, 1e-10);
    ck_assert_double_eq_tol(x[2], 1.05, 1e-10);
    value[3 * 7 + 2] += 1;
    vor_spline_free(&spline);
    vt_assert_ok(vor_spline_fit(&spline, at, value, 30, 0, &vt_memory, &vt_err));
    vor_spline_at(&spline, &at[2 * 7], x);
    ck_assert_double_eq_tol(x[2], value[3 * 7 + 2], 1e-9);
    vor_spline_free(&spline);
    vt_assert_fails(VOR_E_DEGENERATE,
                    vor_spline_fit(&spline, at, value, 5, 0, &vt_memory, &vt_err));
}

/* Two or three squares that meet at an edge or a corner, and the hole around the middle of it: the
 * sides go on to where they meet. */
VT_TEST_LOOP(a_hole_across_creases_carries_them_on, 2)
{
    enum { SIDE = 40 };
    int squares = _i + 2;
    double along = squares == 2 ? 0.5 : 0, sum = 0;
    size_t missing = (size_t)squares * SIDE * SIDE, inside = 0;
    struct vor_report report;
    struct vor_cloud in, out;

    vt_cloud_make(&in, missing);
    for (size_t i = 0; i < in.n; i++) {
        size_t square = i / (SIDE * SIDE), at = i % (SIDE * SIDE);
        double u = ((double)(at % SIDE) + vt_unit(5, 2 * i)) / SIDE;
        double v = ((double)(at / SIDE) + vt_unit(5, 2 * i + 1)) / SIDE;

        in.xyz[3 * i + square] = 0;
        in.xyz[3 * i + (square + 1) % 3] = (float)(square == 0 ? u : v);
        in.xyz[3 * i + (square + 2) % 3] = (float)(square == 0 ? v : u);
    }
    punch(&in, squares == 2 ? 0 : along, squares == 2 ? 0 : along, along, 6.0 / SIDE);
    missing -= in.n;
    vt_resample(&out, &report, &in, "points=%zu boundary=fill iterations=4 polish=10",
                in.n + missing);
    ck_assert_uint_eq(report.holes_filled, 1);
    for (size_t i = 0; i < out.n; i++) {
        double x[3], off;

        vor_cloud_position(&out, i, x);
        off = squares == 2 ? fmin(fabs(x[0]), fabs(x[1]))
                           : fmin(fmin(fabs(x[0]), fabs(x[1])), fabs(x[2]));
        if (x[0] * x[0] + x[1] * x[1] + (x[2] - along) * (x[2] - along) < 36.0 / (SIDE * SIDE)) {
            inside++;
            sum += off * off;
        }
    }
    ck_assert_msg(sqrt(sum / (double)inside) * SIDE < 0.2, "%f spacings off",
                  sqrt(sum / (double)inside) * SIDE);
    ck_assert_msg(inside > 0.85 * (double)missing && inside < 1.15 * (double)missing,
                  "%zu points for %zu", inside, missing);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}
