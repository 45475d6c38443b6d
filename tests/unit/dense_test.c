/* Moments of a cell with a density: against those without one, and against sums over many small
 * triangles. */
#include "core/geom/integrate.h"
#include "tests/support/vt.h"

#include <math.h>

enum { SEEDS = 8, CUTS = 4, PARTS = 200 };

/* A hexagon over a plane, clipped by some bisectors. */
static void make_cell(struct vor_cell *cell, uint64_t seed)
{
    const struct vor_surface surface = {
        .kind = VOR_SURFACE_PLANE, .axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .reach = 1};
    struct vor_disc disc;

    vor_disc_init(&disc, 6, 0);
    vor_cell_begin(cell, &disc, &surface, (double[3]){0.25, 0.5, 0}, 1);
    for (uint64_t i = 0; i < CUTS; i++) {
        double turn = 2 * M_PI * vt_unit(seed, 2 * i), length = 0.8 + vt_unit(seed, 2 * i + 1);

        vor_cell_clip(cell, (double[3]){length * cos(turn), length * sin(turn), 0});
    }
}

VT_TEST_LOOP(an_even_density_gives_the_moments_without_one, SEEDS)
{
    const struct vor_cell_spacing even = {1, {0, 0, 0}}, half = {0.5, {0, 0, 0}};
    struct vor_moments plain, dense;
    struct vor_cell cell;

    make_cell(&cell, (uint64_t)_i);
    ck_assert(vor_cell_moments(&plain, &cell));
    ck_assert(vor_cell_moments_dense(&dense, &cell, &even));
    ck_assert_double_eq_tol(dense.area, plain.area, 1e-12);
    ck_assert_double_eq_tol(dense.energy, plain.energy, 1e-12);
    for (int c = 0; c < 3; c++)
        ck_assert_double_eq_tol(dense.centroid[c], plain.centroid[c], 1e-12);
    ck_assert(vor_cell_moments_dense(&dense, &cell, &half));
    ck_assert_double_eq_tol(dense.energy, 16 * plain.energy, 1e-11);
    ck_assert_double_eq_tol(dense.area, plain.area, 1e-12);
}

/* Density at a corner. */
static double rho_at(const struct vor_cell_spacing *spacing, const double x[3])
{
    return pow(spacing->value + spacing->slope[0] * x[0] + spacing->slope[1] * x[1], -4);
}

/* Mass, first moments and energy of a triangle by its PARTS^2 parts, the density of each that of
 * its middle. */
static void add_parts(double sum[4], const struct vor_cell_spacing *spacing, const double *a,
                      const double *b, const double *c)
{
    double area = fabs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    double rho[3] = {rho_at(spacing, a), rho_at(spacing, b), rho_at(spacing, c)};

    for (int i = 0; i < PARTS; i++)
        for (int j = 0; j < 2 * (PARTS - i) - 1; j++) {
            double shift = j % 2 ? 2.0 / 3 : 1.0 / 3;
            double s = (i + shift) / PARTS, t = (j / 2 + shift) / PARTS, r = 1 - s - t;
            double x = r * a[0] + s * b[0] + t * c[0], y = r * a[1] + s * b[1] + t * c[1];
            double mass = area / PARTS / PARTS * (r * rho[0] + s * rho[1] + t * rho[2]);

            sum[0] += mass;
            sum[1] += mass * x;
            sum[2] += mass * y;
            sum[3] += mass * (x * x + y * y);
        }
}

VT_TEST_LOOP(a_density_between_corners_is_integrated_exactly, SEEDS)
{
    const struct vor_cell_spacing spacing = {1.2, {0.3, -0.2, 0}};
    double sum[4] = {0};
    struct vor_moments dense, plain;
    struct vor_cell cell;

    make_cell(&cell, 100 + (uint64_t)_i);
    ck_assert_uint_eq(cell.count, 1);
    for (unsigned j = 2; j < cell.piece[0].count; j++)
        add_parts(sum, &spacing, cell.piece[0].vertex[0], cell.piece[0].vertex[j - 1],
                  cell.piece[0].vertex[j]);
    ck_assert(vor_cell_moments_dense(&dense, &cell, &spacing));
    ck_assert(vor_cell_moments(&plain, &cell));
    ck_assert_double_eq_tol(dense.centroid[0] - cell.seed[0], sum[1] / sum[0], 1e-4);
    ck_assert_double_eq_tol(dense.centroid[1] - cell.seed[1], sum[2] / sum[0], 1e-4);
    ck_assert_double_eq_tol(dense.energy / sum[3], 1, 1e-3);
    ck_assert_msg(dense.centroid[0] < plain.centroid[0] && dense.centroid[1] > plain.centroid[1],
                  "the centroid is not on the denser side");
}
