/* The local surface: what it recovers, where it falls back, how it goes on and projects. */
#include "core/base/linalg.h"
#include "core/geom/glide.h"
#include "core/geom/layers.h"
#include "core/geom/surface.h"
#include "tests/support/vt.h"

#include <string.h>

enum { SEEDS = 20, PAIRS = 12, K = 2 * PAIRS };

/* Orthogonal rows of length 3 with whole entries: a rotation that costs no rounding. */
static const double turn[3][3] = {{1, 2, 2}, {2, 1, -2}, {2, -2, 1}};

/* A multiple of 1 / steps in [-1, 1). */
static double step(uint64_t seed, uint64_t index, unsigned steps)
{
    return (double)vor_rng_below(seed, 21, index, 2 * steps) / steps - 1;
}

static void put(float *near, unsigned i, double u, double v, double w, const double shift[3])
{
    for (int c = 0; c < 3; c++) {
        double x = shift[c] + u * turn[0][c] + v * turn[1][c] + w * turn[2][c];

        near[3 * i + (unsigned)c] = (float)x;
        ck_assert((double)near[3 * i + (unsigned)c] == x);
    }
}

/* Samples of w = a uu + b uv + c vv, in pairs that mirror each other so that the best plane is
 * w = const, in a turned and shifted frame; every coordinate is exact in float32. */
static void sample_quadric(float *near, uint64_t seed, double curved)
{
    double shift[3], a[3];

    for (unsigned c = 0; c < 3; c++) {
        shift[c] = step(seed, 900 + c, 8);
        a[c] = curved * step(seed, 910 + c, 16);
    }
    for (unsigned i = 0; i < PAIRS; i++) {
        double u = step(seed, 2 * i, 32), v = step(seed, 2 * i + 1, 32);
        double w = a[0] * u * u + a[1] * u * v + a[2] * v * v;

        put(near, 2 * i, u, v, w, shift);
        put(near, 2 * i + 1, -u, -v, w, shift);
    }
}

static void local_of(const struct vor_surface *surface, const float *near, unsigned i,
                     double local[3])
{
    double x[3] = {(double)near[3 * i], (double)near[3 * i + 1], (double)near[3 * i + 2]};

    vor_surface_to_local(surface, x, local);
}

/* Xiao 2024 Sec. III-B, row X1. */
VT_TEST_LOOP(a_quadric_is_recovered_exactly_from_its_samples, SEEDS)
{
    float near[3 * K];
    struct vor_surface s;

    sample_quadric(near, (uint64_t)_i, 0.25);
    vor_surface_fit(&s, near, K);
    ck_assert_int_eq(s.kind, VOR_SURFACE_QUADRIC);
    for (int c = 0; c < 3; c++)
        ck_assert(s.origin[c] == (double)near[c]);
    for (unsigned i = 0; i < K; i++) {
        double local[3];

        local_of(&s, near, i, local);
        ck_assert_double_le(fabs(vor_surface_height(&s, local[0], local[1], NULL) - local[2]),
                            1e-12 * s.reach);
    }
}

/* Least squares: the residuals of noisy samples are orthogonal to each of the six terms, so no
 * other quadric over this plane fits better. */
VT_TEST_LOOP(no_other_quadric_over_the_plane_fits_better, SEEDS)
{
    float near[3 * 40];
    struct vor_surface s;
    double dot[6] = {0};

    for (unsigned i = 0; i < 40; i++) {
        double u = step((uint64_t)_i, 3 * i, 1 << 20), v = step((uint64_t)_i, 3 * i + 1, 1 << 20);

        near[3 * i] = (float)u;
        near[3 * i + 1] = (float)v;
        near[3 * i + 2] = (float)(0.2 * u * v + 0.05 * step((uint64_t)_i, 3 * i + 2, 1 << 20));
    }
    vor_surface_fit(&s, near, 40);
    ck_assert_int_eq(s.kind, VOR_SURFACE_QUADRIC);
    for (unsigned i = 0; i < 40; i++) {
        double l[3], r;

        local_of(&s, near, i, l);
        r = l[2] - vor_surface_height(&s, l[0], l[1], NULL);
        const double term[6] = {1, l[0], l[1], l[0] * l[0], l[0] * l[1], l[1] * l[1]};
        for (int t = 0; t < 6; t++)
            dot[t] += r * term[t];
    }
    for (int t = 0; t < 6; t++)
        ck_assert_double_le(fabs(dot[t]), 1e-11);
}

VT_TEST_LOOP(points_of_a_plane_give_that_plane, SEEDS)
{
    float near[3 * K];
    struct vor_surface s;

    sample_quadric(near, (uint64_t)_i, 0);
    for (unsigned k = 3; k <= K; k += 7) {
        vor_surface_fit(&s, near, k);
        if (s.kind == VOR_SURFACE_NONE)
            continue; /* two mirrored pairs may lie on a line */
        ck_assert(k == K ? s.kind == VOR_SURFACE_QUADRIC : k > 6 || s.kind == VOR_SURFACE_PLANE);
        for (unsigned i = 0; i < K; i++) {
            double local[3];

            local_of(&s, near, i, local);
            ck_assert_double_le(fabs(local[2]), 1e-12 * s.reach);
            ck_assert_double_le(fabs(vor_surface_height(&s, local[0], local[1], NULL)),
                                1e-11 * s.reach);
        }
    }
}

VT_TEST_LOOP(points_of_a_line_have_no_surface, SEEDS)
{
    float near[3 * K];
    struct vor_surface s;

    for (unsigned i = 0; i < K; i++)
        put(near, i, step((uint64_t)_i, i, 64), 0, 0, (double[3]){1, -2, 0.5});
    for (unsigned k = 1; k <= K; k++) {
        vor_surface_fit(&s, near, k);
        ck_assert_int_eq(s.kind, VOR_SURFACE_NONE);
    }
}

VT_TEST(two_points_have_no_surface_and_three_have_a_plane)
{
    const float near[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0.5f};
    struct vor_surface s;

    vor_surface_fit(&s, near, 1);
    ck_assert_int_eq(s.kind, VOR_SURFACE_NONE);
    vor_surface_fit(&s, near, 2);
    ck_assert_int_eq(s.kind, VOR_SURFACE_NONE);
    vor_surface_fit(&s, near, 3);
    ck_assert_int_eq(s.kind, VOR_SURFACE_PLANE);
}

/* `distinct` places, each several times. */
static enum vor_surface_kind fit_repeated(unsigned distinct)
{
    float near[3 * K];
    struct vor_surface s;

    for (unsigned i = 0; i < K; i++)
        put(near, i, step(5, 2 * (i % distinct), 64), step(5, 2 * (i % distinct) + 1, 64), 0,
            (double[3]){0});
    vor_surface_fit(&s, near, K);
    return s.kind;
}

VT_TEST(repeated_points_count_once)
{
    ck_assert_int_eq(fit_repeated(1), VOR_SURFACE_NONE);
    ck_assert_int_eq(fit_repeated(2), VOR_SURFACE_NONE);
    for (unsigned distinct = 3; distinct <= 5; distinct++)
        ck_assert_int_eq(fit_repeated(distinct), VOR_SURFACE_PLANE);
    ck_assert_int_eq(fit_repeated(12), VOR_SURFACE_QUADRIC);
}

/* uu + vv is constant on a circle, so it cannot be told from the constant. */
VT_TEST(points_of_a_circle_determine_a_plane_only)
{
    float near[3 * K];
    struct vor_surface s;

    for (unsigned i = 0; i < K; i++) {
        near[3 * i] = (float)cos(2 * M_PI * i / K);
        near[3 * i + 1] = (float)sin(2 * M_PI * i / K);
        near[3 * i + 2] = 0.125f;
    }
    vor_surface_fit(&s, near, K);
    ck_assert_int_eq(s.kind, VOR_SURFACE_PLANE);
}

VT_TEST(the_spacing_of_a_lattice_is_found_inside_and_at_its_border)
{
    for (int half = 0; half < 2; half++) {
        float near[3 * 81];
        struct vor_surface s;
        unsigned k = 0;

        for (int radius2 = 0; radius2 < 50 && k < 60; radius2++)
            for (int x = -7; x <= 7; x++)
                for (int y = -7; y <= 7; y++)
                    if (x * x + y * y == radius2 && (!half || x >= 0)) {
                        near[3 * k] = 0.5f * (float)x;
                        near[3 * k + 1] = 0.5f * (float)y;
                        near[3 * k++ + 2] = 0;
                    }
        vor_surface_fit(&s, near, k);
        ck_assert_double_eq_tol(s.spacing, 0.5, 0.04);
    }
}

/* Departure of the header: no jump in height or slope where the quadric ends, and a straight line
 * from there on. */
VT_TEST_LOOP(beyond_its_reach_a_quadric_goes_on_straight_without_a_kink, SEEDS)
{
    const double h = 1e-5;
    float near[3 * K];
    struct vor_surface s;

    sample_quadric(near, (uint64_t)_i, 0.25);
    vor_surface_fit(&s, near, K);
    for (int a = 0; a < 12; a++) {
        double d[2] = {cos(0.5 * a), sin(0.5 * a)}, height[7], slope[2], g[2];
        double scale = s.reach * s.reach;

        for (int i = 0; i < 7; i++) {
            static const double at[7] = {-2, -1, 0, 1, 2, 1e5, 2e5};
            double r = s.reach + at[i] * h * s.reach;

            height[i] =
                vor_surface_height(&s, s.center[0] + r * d[0], s.center[1] + r * d[1], NULL);
        }
        (void)vor_surface_height(&s, s.center[0] + s.reach * d[0], s.center[1] + s.reach * d[1], g);
        slope[0] = (height[2] - height[1]) / h;
        slope[1] = (height[3] - height[2]) / h;
        ck_assert_double_le(fabs(slope[1] - slope[0]), 10 * h * scale);
        ck_assert_double_le(fabs(slope[1] / s.reach - (g[0] * d[0] + g[1] * d[1])), 10 * h * scale);
        ck_assert_double_le(fabs((height[5] - height[2]) - slope[1]), 1e-6 * scale);
        ck_assert_double_le(fabs(height[6] - 2 * height[5] + height[2]), 1e-11 * scale);
    }
}

/* The slow twin: one foot at a time, by the height and its gradient. Some are beyond the reach, one
 * is the center. */
VT_TEST_LOOP(feet_of_many_points_are_those_of_each, SEEDS)
{
    float near[3 * K], wide[3 * K];
    double way[4 * K];
    struct vor_surface s;

    sample_quadric(near, (uint64_t)_i, 0.25);
    vor_surface_fit(&s, near, K);
    for (size_t k = 0; k < sizeof near / sizeof *near; k++)
        wide[k] = (float)(k % 2 ? 3 : 1) * near[k];
    vor_to_floats(wide, s.origin);
    vor_surface_feet(&s, wide, K, way);
    for (size_t j = 0; j < K; j++) {
        double x[3], l[3], g[2], step, off;

        vor_to_doubles(x, &wide[3 * j]);
        vor_surface_to_local(&s, x, l);
        off = l[2] - vor_surface_height(&s, l[0], l[1], g);
        step = off / (1 + g[0] * g[0] + g[1] * g[1]);
        for (size_t c = 0; c < 3; c++)
            ck_assert_double_eq_tol(
                way[c * K + j], step * (g[0] * s.axis[0][c] + g[1] * s.axis[1][c] - s.axis[2][c]),
                1e-13);
        ck_assert_double_eq_tol(way[3 * K + j], off * step, 1e-13);
    }
}

static double gap2(const double a[3], const double b[3])
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return vor_dot(d, d);
}

/* Xiao 2024 Sec. IV-D: the foot is on the surface, the way to it is along the normal, and no other
 * place of the surface around it is nearer. */
VT_TEST_LOOP(a_projected_point_is_the_foot_of_its_perpendicular, SEEDS)
{
    float near[3 * K];
    struct vor_surface s;

    sample_quadric(near, (uint64_t)_i, 0.25);
    vor_surface_fit(&s, near, K);
    for (unsigned a = 0; a < 10; a++) {
        double from[3], foot[3], along[3], g[2], off, best;

        from[0] = s.center[0] + 0.5 * s.reach * step((uint64_t)_i, 800 + 3 * a, 100);
        from[1] = s.center[1] + 0.5 * s.reach * step((uint64_t)_i, 801 + 3 * a, 100);
        from[2] = vor_surface_height(&s, from[0], from[1], NULL) +
                  0.1 * s.reach * step((uint64_t)_i, 802 + 3 * a, 100);
        memcpy(foot, from, sizeof foot);
        vor_surface_project(&s, foot);
        ck_assert_double_eq_tol(foot[2], vor_surface_height(&s, foot[0], foot[1], g), 1e-14);
        for (int c = 0; c < 3; c++)
            along[c] = from[c] - foot[c];
        off = sqrt(vor_dot(along, along));
        ck_assert_double_le(fabs(along[0] + along[2] * g[0]), 2e-4 * off + 1e-14);
        ck_assert_double_le(fabs(along[1] + along[2] * g[1]), 2e-4 * off + 1e-14);
        best = gap2(from, foot);
        for (int i = -10; i <= 10; i++)
            for (int j = -10; j <= 10; j++) {
                double other[3] = {foot[0] + 0.02 * i * s.reach, foot[1] + 0.02 * j * s.reach, 0};

                other[2] = vor_surface_height(&s, other[0], other[1], NULL);
                ck_assert_double_ge(gap2(from, other), best * (1 - 1e-6));
            }
    }
}

/* By a part of a vector, or as far as allowed. */
VT_TEST_LOOP(what_glides_moves_along_the_surface_and_is_put_onto_it, SEEDS)
{
    float near[3 * K];
    double x[3], v[3], local[3], normal[3], length, most;
    struct vor_glide glide = {.count = 0}, before;
    struct vor_surface s;

    sample_quadric(near, (uint64_t)_i, 0.25);
    vor_surface_fit(&s, near, K);
    most = 0.1 * s.reach;
    for (unsigned j = 0; j < (unsigned)_i % VOR_GLIDE_LANES + 1; j++) {
        float at[3];

        for (unsigned c = 0; c < 3; c++) {
            at[c] = (float)(s.origin[c] + 0.6 * j * s.reach * step((uint64_t)_i, 900 + c, 100));
            v[c] = 0.3 * s.reach * step((uint64_t)_i, 910 + c + 3 * j, 100);
        }
        ck_assert_int_eq(vor_glide_add(&glide, &s, j, most, at, v), j + 1 == VOR_GLIDE_LANES);
    }
    before = glide;
    vor_glide_go(&glide);
    for (unsigned j = 0; j < glide.count; j++) {
        memcpy(x, before.x[j], sizeof x);
        vor_surface_to_local(&s, x, local);
        vor_surface_normal(&s, local, normal);
        vor_remove_along(before.v[j], normal, 0);
        length = sqrt(vor_dot(before.v[j], before.v[j]));
        for (int c = 0; c < 3; c++)
            x[c] += before.v[j][c] * (length > most ? most / length : 1);
        vor_surface_put(&s, x);
        ck_assert_double_le(gap2(x, glide.x[j]), 1e-24 * s.reach * s.reach);
    }
}

VT_TEST_LOOP(a_weight_counts_like_so_many_points, SEEDS)
{
    float near[3 * K], repeated[9 * K], weight[K], ones[K];
    struct vor_surface weighted, listed, plain, one;
    unsigned k = 0;

    for (unsigned i = 0; i < K; i++) {
        near[3 * i] = (float)vt_unit((uint64_t)_i, 3 * i);
        near[3 * i + 1] = (float)vt_unit((uint64_t)_i, 3 * i + 1);
        near[3 * i + 2] = (float)(0.2 * vt_unit((uint64_t)_i, 3 * i + 2));
        ones[i] = 1;
        weight[i] = (float)(1 + i % 3);
        for (unsigned j = 0; j <= i % 3; j++)
            memcpy(&repeated[3 * k++], &near[3 * i], 3 * sizeof *near);
    }
    vor_surface_fit_weighted(&weighted, near, weight, K);
    vor_surface_fit(&listed, repeated, k);
    vor_surface_fit(&plain, near, K);
    vor_surface_fit_weighted(&one, near, ones, K);
    ck_assert_int_eq(weighted.kind, VOR_SURFACE_QUADRIC);
    ck_assert_int_eq(listed.kind, VOR_SURFACE_QUADRIC);
    for (int i = 0; i < 6; i++) {
        ck_assert_double_eq_tol(weighted.c[i], listed.c[i], 1e-9);
        ck_assert(one.c[i] == plain.c[i]);
    }
    ck_assert_double_eq_tol(weighted.center[0], listed.center[0], 1e-12);
    ck_assert(fabs(weighted.c[0] - plain.c[0]) > 1e-6);
    ck_assert(weighted.spacing == 0);
}

/* Heights that are equal, as on a lattice, are sorted like others. */
VT_TEST_LOOP(two_sheets_of_as_many_points_as_a_fit_takes_are_told_apart, SEEDS)
{
    float near[3 * VOR_NEIGHBORS_MAX], apart = (float)(2 + vt_unit((uint64_t)_i, 0));
    struct vor_layers layers;

    for (unsigned i = 0; i < VOR_NEIGHBORS_MAX; i++) {
        near[3 * i] = (float)(i / 2 % 16) - 7.5F;
        near[3 * i + 1] = (float)(i / 32) - 7.5F;
        near[3 * i + 2] = i % 2 ? apart : -apart;
    }
    vor_layers_find(&layers, near, VOR_NEIGHBORS_MAX);
    ck_assert_uint_eq(layers.count, 2);
    for (unsigned i = 0; i < VOR_NEIGHBORS_MAX; i++)
        ck_assert_uint_eq(layers.of[i], i % 2);
}
