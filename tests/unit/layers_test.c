/* Layers within a neighbourhood: sheets are told apart, noise, creases and staircases are not. */
#include "core/geom/layers.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 40, K = 50, SIDE = 24, DRAWN = SIDE * SIDE };

/* Height over (u, v) of one sheet; the spacing of a sheet is 1. */
typedef double (*shape)(double u, double v, double size);

static double plane(double u, double v, double size)
{
    return 0 * (u + v + size);
}

static double bowl(double u, double v, double size)
{
    return (u * u + v * v) / (2 * size);
}

static double crease(double u, double v, double size)
{
    return u < 0.7 + 0 * v ? 0 : size * (u - 0.7);
}

static double stairs(double u, double v, double size)
{
    return size * floor(0.25 * u + 0.1 * v);
}

struct point {
    float x[3];
    double distance2;
};

static int nearer(const void *a, const void *b)
{
    double x = ((const struct point *)a)->distance2, y = ((const struct point *)b)->distance2;

    return (x > y) - (x < y);
}

/* The K points nearest to a place on the lowest of some sheets in white noise. */
static void sample(float near[3 * K], uint64_t seed, unsigned sheets, double gap, double noise,
                   shape of, double size)
{
    static struct point points[2 * DRAWN];

    for (unsigned i = 0; i < sheets * DRAWN; i++) {
        double u = SIDE * (vt_unit(seed, 3 * i) - 0.5), v = SIDE * (vt_unit(seed, 3 * i + 1) - 0.5);
        double w = of(u, v, size) + gap * (i / DRAWN) + noise * vt_normal(seed + 7777, i);

        points[i] = (struct point){{(float)u, (float)v, (float)w}, u * u + v * v + w * w};
    }
    qsort(points, sheets * (size_t)DRAWN, sizeof *points, nearer);
    for (size_t i = 0; i < K; i++)
        memcpy(&near[3 * i], points[i].x, sizeof points[i].x);
}

/* How many of SEEDS neighbourhoods have layers; and those of two sheets whose points all have the
 * right label. */
static unsigned layered(unsigned sheets, double gap, double noise, shape of, double size,
                        unsigned *right)
{
    static const double origin[3] = {0, 0, 0};
    unsigned found = 0;

    *right = 0;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        struct vor_layers layers;
        float near[3 * K];
        unsigned own, good = 0;

        sample(near, seed, sheets, gap, noise, of, size);
        vor_layers_find(&layers, near, K);
        own = vor_layers_nearest(&layers, origin);
        for (size_t i = 0; layers.count == 2 && i < K; i++) {
            double w =
                (double)near[3 * i + 2] - of((double)near[3 * i], (double)near[3 * i + 1], size);

            good += (layers.of[i] == own) == (w < gap / 2);
        }
        found += layers.count > 1;
        *right += good == K;
    }
    return found;
}

/* Loop index: the gap. */
START_TEST(two_sheets_are_two_layers_and_each_point_is_on_its_own)
{
    static const double gaps[] = {0.3, 0.5, 1, 1.5, 2, 2.5};
    static const struct {
        shape of;
        double size, noise;
    } sheets[] = {{plane, 0, 0}, {plane, 0, 0.1}, {bowl, 15, 0}};

    for (size_t i = 0; i < sizeof sheets / sizeof *sheets; i++) {
        unsigned right;
        unsigned found =
            layered(2, gaps[_i], sheets[i].noise * gaps[_i], sheets[i].of, sheets[i].size, &right);

        ck_assert_msg(found >= SEEDS * 85 / 100 && right >= SEEDS * 85 / 100,
                      "sheets %zu, gap %g: %u found, %u right of %d", i, gaps[_i], found, right,
                      SEEDS);
    }
}
END_TEST

START_TEST(noise_creases_and_staircases_are_one_layer)
{
    static const struct {
        shape of;
        double size, noise;
    } ones[] = {{plane, 0, 0},    {plane, 0, 0.1}, {plane, 0, 1},      {bowl, 5, 0},
                {bowl, 5, 0.2},   {crease, 1, 0},  {crease, 1, 0.1},   {crease, 0.3, 0},
                {stairs, 0.5, 0}, {stairs, 1, 0},  {stairs, 0.5, 0.02}};

    for (size_t i = 0; i < sizeof ones / sizeof *ones; i++) {
        unsigned right, found = layered(1, 0, ones[i].noise, ones[i].of, ones[i].size, &right);

        ck_assert_msg(found <= SEEDS / 20, "shape %zu: %u of %d", i, found, SEEDS);
    }
}
END_TEST

/* Known by construction: a lattice on each of two planes; the places asked for need not be among
 * the points. */
START_TEST(the_layer_of_a_place_is_the_nearest)
{
    float near[3 * K];
    struct vor_layers layers;
    unsigned low, high;

    for (unsigned i = 0; i < K; i++) {
        near[3 * i] = (float)(i / 2 % 5);
        near[3 * i + 1] = (float)(i / 10);
        near[3 * i + 2] = (float)(i % 2);
    }
    vor_layers_find(&layers, near, K);
    ck_assert_uint_eq(layers.count, 2);
    low = vor_layers_nearest(&layers, (double[3]){1.3, 2.2, 0.4});
    high = vor_layers_nearest(&layers, (double[3]){1.3, 2.2, 0.6});
    ck_assert_uint_ne(low, high);
    for (unsigned i = 0; i < K; i++)
        ck_assert_uint_eq(layers.of[i], i % 2 ? high : low);
}
END_TEST

/* Of bent sheets, layers of one neighbourhood lead to those of another one, and noise has none that
 * are like them. */
START_TEST(layers_are_found_from_those_nearby)
{
    static const double origin[3] = {0, 0, 0};
    struct vor_layers first, second;
    float near[3 * K];
    unsigned found = 0, tried = 0;

    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        unsigned own, right = 0;

        sample(near, seed, 2, 1, 0, bowl, 20);
        vor_layers_find(&first, near, K);
        if (first.count != 2)
            continue;
        tried++;
        sample(near, seed + 100, 2, 1, 0, bowl, 20);
        if (!vor_layers_find_like(&second, &first, near, K))
            continue;
        own = vor_layers_nearest(&second, origin);
        for (size_t i = 0; i < K; i++) {
            double u = (double)near[3 * i], v = (double)near[3 * i + 1],
                   w = (double)near[3 * i + 2];

            right += (second.of[i] == own) == (w - bowl(u, v, 20) < 0.5);
        }
        ck_assert_uint_eq(right, K);
        found++;
        sample(near, seed, 1, 0, 0.3, plane, 0);
        ck_assert_int_eq(vor_layers_find_like(&second, &first, near, K), 0);
        ck_assert_uint_eq(second.count, 1);
    }
    ck_assert_uint_gt(tried, SEEDS / 2);
    ck_assert_uint_gt(10 * found, 9 * tried);
}
END_TEST

START_TEST(too_few_points_or_points_on_a_line_are_one_layer)
{
    float near[3 * K] = {0};
    struct vor_layers layers;

    for (unsigned k = 1; k <= K; k++) {
        vor_layers_find(&layers, near, k);
        ck_assert_uint_eq(layers.count, 1);
        for (unsigned i = 0; i < K; i++)
            near[3 * i] = (float)i;
        vor_layers_find(&layers, near, k);
        ck_assert_uint_eq(layers.count, 1);
        ck_assert_uint_eq(vor_layers_nearest(&layers, (double[3]){0, 0, 0}), 0);
    }
}
END_TEST

/* The mean square that the fit hands over is that of the heights. */
START_TEST(a_fit_knows_how_far_its_points_are_off)
{
    float near[3 * K];
    struct vor_surface surface;
    double sum = 0;

    sample(near, (uint64_t)_i, 1, 0, 0.3, bowl, 5);
    vor_surface_fit(&surface, near, K);
    for (size_t i = 0; i < K; i++) {
        double x[3] = {(double)near[3 * i], (double)near[3 * i + 1], (double)near[3 * i + 2]};
        double local[3], off;

        vor_surface_to_local(&surface, x, local);
        off = local[2] - vor_surface_height(&surface, local[0], local[1], NULL);
        sum += off * off;
    }
    ck_assert_double_eq_tol(surface.off2, sum / K, 1e-9 * sum);
    ck_assert(vor_layers_possible(&surface));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("layers");

    vt_add_loop(suite, two_sheets_are_two_layers_and_each_point_is_on_its_own, 6);
    vt_add(suite, noise_creases_and_staircases_are_one_layer);
    vt_add(suite, the_layer_of_a_place_is_the_nearest);
    vt_add(suite, layers_are_found_from_those_nearby);
    vt_add(suite, too_few_points_or_points_on_a_line_are_one_layer);
    vt_add_loop(suite, a_fit_knows_how_far_its_points_are_off, 10);
    return vt_run(suite);
}
