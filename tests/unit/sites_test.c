/* Points along borders: how evenly they lie there, beside those inside. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { SEEDS = 2, N = 8000, TO = 800 };

/* Of a hexagonal lattice of TO points on the unit square, those on its border with half a cell. */
#define SPACING 0.0393

/* What a run with sites gives; one more parameter, or NULL. */
static struct vor_report resample(struct vor_cloud *out, const struct vor_cloud *in,
                                  const char *name, const char *value)
{
    struct vt_engine engine;
    struct vor_report report;

    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", TO);
    vt_engine_set(&engine, "boundary", "sites");
    if (name != NULL)
        vt_engine_set(&engine, name, value);
    vt_engine_resample(&engine, out, &report, in);
    vt_engine_close(&engine);
    ck_assert_uint_eq(out->n, TO);
    return report;
}

/* Mean distance to the nearest other point over those that `is` takes. */
static double spacing_of(const struct vor_cloud *cloud, int (*is)(const double x[3]))
{
    double sum = 0;
    size_t count = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3], near2 = INFINITY;

        vor_cloud_position(cloud, i, x);
        if (!is(x))
            continue;
        for (size_t j = 0; j < cloud->n; j++) {
            double y[3], d2 = 0;

            vor_cloud_position(cloud, j, y);
            for (int c = 0; c < 3; c++)
                d2 += (x[c] - y[c]) * (x[c] - y[c]);
            near2 = j != i ? fmin(near2, d2) : near2;
        }
        sum += sqrt(near2);
        count++;
    }
    ck_assert_uint_gt(count, 0);
    return sum / (double)count;
}

static double from_edge(const double x[3])
{
    return fmin(fmin(x[0], 1 - x[0]), fmin(x[1], 1 - x[1]));
}

static int is_inside_square(const double x[3])
{
    return from_edge(x) > 0.1;
}

/* Sites lie within the ragged end of the input, the points next to them a spacing from it. */
static int is_at_edge(const double x[3])
{
    return from_edge(x) < 0.4 * SPACING;
}

/* Largest distance from a place on the square's border to a point. */
static double widest_gap(const struct vor_cloud *cloud)
{
    double widest = 0;

    for (int i = 0; i < 4000; i++) {
        double t = i % 1000 / 1000.0, x[3] = {0, 0, 0}, near;

        x[i / 1000 % 2] = t;
        x[1 - i / 1000 % 2] = i / 2000;
        near = sqrt(vt_nearest2(cloud, x, NULL));
        widest = fmax(widest, near);
    }
    return widest;
}

VT_TEST_FIGURES(the_border_of_a_square_has_the_spacing_inside, VT_FEWER(SEEDS))
{
    struct vor_cloud in, out;
    struct vor_report report;
    double inside, edge;

    vt_cloud_square(&in, (uint64_t)_i, N);
    report = resample(&out, &in, NULL, NULL);
    inside = spacing_of(&out, is_inside_square);
    edge = spacing_of(&out, is_at_edge);
    ck_assert_msg(fabs(edge / inside - 1) < 0.05, "%g at the edge, %g inside", edge, inside);
    ck_assert_msg(report.delta < 0.04, "delta %g", report.delta);
    ck_assert_msg(widest_gap(&out) < 0.8 * SPACING, "a gap of %g", widest_gap(&out) / SPACING);
    vt_free_last(&out, &in);
}

/* Distance of a point of the unit cube's surface to the nearest of its edges. */
static double from_cube_edge(const double x[3])
{
    double near[3], most = 0, sum = 0;

    for (int c = 0; c < 3; c++) {
        near[c] = fmin(fabs(x[c]), fabs(1 - x[c]));
        most = fmax(most, near[c]);
        sum += near[c] * near[c];
    }
    return sqrt(sum - most * most);
}

/* Points on the edges of a cube, and the share of places along these with a point within 0.55
 * spacings. */
static size_t on_edges(const struct vor_cloud *cloud, double *covered)
{
    double spacing = sqrt(6 / (0.866 * TO));
    size_t count = 0, near = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        count += from_cube_edge(x) < 0.1 * spacing;
    }
    for (int i = 0; i < 1200; i++) {
        int edge = i / 100, axis = edge / 4;
        double x[3];

        x[axis] = (i % 100 + 0.5) / 100;
        x[(axis + 1) % 3] = edge % 2;
        x[(axis + 2) % 3] = edge / 2 % 2;
        near += sqrt(vt_nearest2(cloud, x, NULL)) < 0.55 * spacing;
    }
    *covered = near / 1200.0;
    return count;
}

VT_TEST_FIGURES(the_edges_of_a_cube_are_kept, 0)
{
    struct vor_cloud in, out;
    double covered, without;
    size_t sites, none;

    vt_cloud_box(&in, (uint64_t)_i, N);
    (void)resample(&out, &in, "edges", "ignore");
    none = on_edges(&out, &without);
    vor_cloud_free(&out);
    (void)resample(&out, &in, "edges", "sites");
    sites = on_edges(&out, &covered);
    vor_cloud_free(&out);
    /* 12 edges of 10 or 11 spacings */
    ck_assert_msg(sites > 100 && sites < 150 && 2 * none < sites, "%zu points, without %zu", sites,
                  none);
    ck_assert_msg(covered > 0.95 && covered > without, "%g covered, without %g", covered, without);
    vor_cloud_free(&in);
}

/* Without a border there are no sites. */
VT_TEST_FIGURES(a_closed_surface_is_spread_as_without, 0)
{
    struct vor_cloud in, out, kept;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    (void)resample(&out, &in, NULL, NULL);
    (void)resample(&kept, &in, "boundary", "keep");
    ck_assert(vt_cloud_hash(&out) == vt_cloud_hash(&kept));
    vor_cloud_free(&kept);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}

/* Sites beside islands, with a density, on a thinned input and by every acceleration: as many
 * points as were asked for, and the border's stay where they are. */
VT_TEST_FIGURES(sites_stay_whatever_else_is_asked_for, VT_FEWER(6))
{
    static const char *const with[][2] = {{"density", "curvature"}, {"anderson", "4"},
                                          {"metric", "lp"},         {"polish", "0"},
                                          {"patch", "plane"},       {"order", "progressive"}};
    struct vor_cloud in, out;
    double edge;

    vt_cloud_square(&in, 5, N);
    (void)resample(&out, &in, with[_i][0], with[_i][1]);
    edge = spacing_of(&out, is_at_edge);
    ck_assert_msg(fabs(edge / (0.97 * SPACING) - 1) < 0.06, "%g spacings", edge / SPACING);
    vt_free_last(&out, &in);
}

/* Few points have no room for a border of their own. */
VT_TEST_FIGURES(any_number_of_points_comes, 0)
{
    struct vor_cloud in;

    vt_cloud_square(&in, 3, 3000);
    for (size_t n = 1; n < 40; n += n < 12 ? 1 : 9) {
        struct vor_cloud out;
        struct vor_report report;

        vt_resample(&out, &report, &in, "points=%zu boundary=sites", n);
        ck_assert_uint_eq(out.n, n);
        vor_cloud_free(&out);
    }
    vor_cloud_free(&in);
}
