/* Energy of flat cells, its gradient and second derivatives (Chen 2018, Eq. 4; rows C8, C9). */
#include "core/geom/energy.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 20, OTHERS = 14, POWERS = 4 };

/* A seed in its plane and others around it, about a spacing apart, off the plane by a third. */
struct made {
    struct vor_energy_plane plane;
    double at[2], other[OTHERS][3];
};

/* What cuts the cell besides the others: which of these is loop / POWERS % 3. */
enum { WIDE, PATCH, WALL };

static void make(struct made *made, int loop)
{
    uint64_t seed = (uint64_t)loop, k = 0;
    int ends = loop / POWERS % 3;

    memset(made, 0, sizeof *made);
    made->plane.power = 2 + 2 * ((unsigned)loop % POWERS);
    made->plane.factor[0] = loop % 2 ? 1 : 0.5 + vt_unit(seed, k++);
    made->plane.factor[1] = loop % 2 ? 1 : 0.5 + 2 * vt_unit(seed, k++);
    made->plane.radius = ends == PATCH ? 0.6 : 1.6;
    made->plane.room = ends == WALL ? 0.3 : (double)INFINITY;
    made->plane.wall[0] = 0.8;
    made->plane.wall[1] = 0.5;
    for (int d = 0; d < 2; d++)
        made->at[d] = 0.2 * vt_unit(seed, 10 + k++) - 0.1;
    for (int j = 0; j < OTHERS; j++) {
        double turn = 2 * M_PI * (j + 0.8 * vt_unit(seed, 100 + k++)) / 7;
        double far = (j < 7 ? 0.9 : 1.7) + 0.3 * vt_unit(seed, 100 + k++);

        made->other[j][0] = far * cos(turn);
        made->other[j][1] = far * sin(turn);
        made->other[j][2] = 0.6 * vt_unit(seed, 100 + k++) - 0.3;
    }
}

static double energy_of(const struct made *made, struct vor_energy *energy)
{
    const double(*other)[3] = (const double(*)[3])made->other;
    struct vor_energy here;
    struct vor_flat cell;

    energy = energy != NULL ? energy : &here;
    vor_energy_cut(&cell, &made->plane, made->at, other, OTHERS);
    vor_energy_of(energy, &cell, &made->plane, made->at, other);
    return energy->value;
}

/* The difference quotient of the fourth order. */
static double slope_along(struct made *made, double *x)
{
    const double h = 2e-6, from = *x;
    double value[4];

    for (int k = 0; k < 4; k++) {
        static const double step[4] = {-2, -1, 1, 2};

        *x = from + step[k] * h;
        value[k] = energy_of(made, NULL);
    }
    *x = from;
    return (value[0] - 8 * value[1] + 8 * value[2] - value[3]) / (12 * h);
}

/* The step is so short that hardly a corner appears or goes within it: there the second derivative
 * jumps. */
VT_TEST_FIGURES(the_gradient_is_that_of_finite_differences, 3 * POWERS * SEEDS)
{
    struct made made;
    struct vor_energy energy;
    double by[OTHERS][3] = {{0}}, off = 0, all = 0;

    make(&made, _i);
    (void)energy_of(&made, &energy);
    ck_assert_uint_ge(energy.count, 3);
    for (unsigned k = 0; k < energy.count; k++)
        memcpy(by[energy.id[k]], energy.by[k], sizeof by[0]);
    for (int d = 0; d < 2; d++) {
        off = fmax(off, fabs(slope_along(&made, &made.at[d]) - energy.own[d]));
        all = fmax(all, fabs(energy.own[d]));
    }
    for (int j = 0; j < OTHERS; j++)
        for (int d = 0; d < 3; d++) {
            off = fmax(off, fabs(slope_along(&made, &made.other[j][d]) - by[j][d]));
            all = fmax(all, fabs(by[j][d]));
        }
    ck_assert_double_gt(all, 0);
    ck_assert_double_le(off, 1e-6 * all);
}

/* The integral by the midpoints of the sides of many small triangles. */
static double by_quadrature(const struct made *made, const struct vor_flat *cell)
{
    enum { CUTS = 60 };
    double sum = 0;

    for (unsigned e = 0; e < cell->count; e++) {
        unsigned f = e + 1 < cell->count ? e + 1 : 0;
        double a[2] = {cell->x[e] - cell->x[0], cell->y[e] - cell->y[0]};
        double b[2] = {cell->x[f] - cell->x[0], cell->y[f] - cell->y[0]};
        double area = (a[0] * b[1] - a[1] * b[0]) / 2 / (CUTS * CUTS);

        for (int s = 0; s < CUTS; s++)
            for (int t = 0; s + t < CUTS; t++)
                for (int side = 0; side < (s + t + 1 < CUTS ? 6 : 3); side++) {
                    /* three midpoints of the triangle at (s, t), three of the one beyond it */
                    static const double mid[6][2] = {{0.5, 0}, {0, 0.5}, {0.5, 0.5},
                                                     {1, 0.5}, {0.5, 1}, {0.5, 0.5}};
                    double u = (s + mid[side][0]) / CUTS, v = (t + mid[side][1]) / CUTS, here = 0;

                    for (int d = 0; d < 2; d++) {
                        double x = (d == 0 ? cell->x[0] : cell->y[0]) + u * a[d] + v * b[d];

                        here += pow(made->plane.factor[d] * (x - made->at[d]), made->plane.power);
                    }
                    sum += area / 3 * here;
                }
    }
    return sum;
}

VT_TEST_FIGURES(the_energy_is_that_of_a_numeric_quadrature, 3 * POWERS * 2)
{
    struct made made;
    struct vor_flat cell;
    double energy;

    make(&made, _i);
    energy = energy_of(&made, NULL);
    vor_energy_cut(&cell, &made.plane, made.at, (const double(*)[3])made.other, OTHERS);
    ck_assert_double_gt(energy, 0);
    ck_assert_double_eq_tol(by_quadrature(&made, &cell) / energy, 1, 1e-5);
}

/* The square from -h to h: the integral of x^p is 2 h times 2 h^(p + 1) / (p + 1). */
VT_TEST_LOOP(a_square_has_the_energy_of_the_textbook, POWERS)
{
    const double h = 0.4, other[4][3] = {{2 * h, 0}, {0, 2 * h}, {-2 * h, 0}, {0, -2 * h}};
    struct vor_energy_plane plane = {{1.5, 0.5}, 2 + 2 * (unsigned)_i, 1, {0, 0}, INFINITY};
    struct vor_energy_shape shape;
    struct vor_energy energy;
    struct vor_flat cell;
    unsigned p = plane.power;
    double one = 4 * pow(h, p + 2) / (p + 1);

    vor_energy_cut(&cell, &plane, (double[2]){0, 0}, other, 4);
    vor_energy_of(&energy, &cell, &plane, (double[2]){0, 0}, other);
    ck_assert_uint_eq(cell.count, 4);
    ck_assert_double_eq_tol(energy.value, (pow(1.5, p) + pow(0.5, p)) * one, 1e-14);
    ck_assert_double_eq_tol(energy.own[0], 0, 1e-14);
    ck_assert_double_eq_tol(energy.own[1], 0, 1e-14);
    /* p (p - 1) M^p times the integral of x^(p - 2) */
    ck_assert_double_eq_tol(energy.bend[0], p * pow(1.5, p) * 4 * pow(h, p), 1e-13);
    ck_assert_double_eq_tol(energy.bend[1], p * pow(0.5, p) * 4 * pow(h, p), 1e-13);
    ck_assert(vor_energy_shape_of(&shape, &cell, (double[2]){0, 0}));
    ck_assert_double_eq_tol(shape.area, 4 * h * h, 1e-14);
    ck_assert_double_eq_tol(shape.moment[0], 4 * h * h * h * h / 3, 1e-14);
    ck_assert_double_eq_tol(shape.moment[1], 0, 1e-14);
    ck_assert_double_eq_tol(shape.energy, 8 * h * h * h * h / 3, 1e-14);
}
