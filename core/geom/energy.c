#include "core/geom/energy.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"

#include <string.h>

void vor_energy_cut(struct vor_flat *cell, const struct vor_energy_plane *plane, const double at[2],
                    const double (*other)[3], unsigned count)
{
    double off = sqrt(at[0] * at[0] + at[1] * at[1]), at2 = off * off;

    vor_flat_begin(cell, vor_patch_octagon, VOR_PATCH_OCTAGON, plane->radius);
    if (plane->room < plane->radius)
        vor_flat_clip(cell, plane->wall, plane->room, VOR_ENERGY_WALL);
    for (unsigned j = 0; j < count; j++) {
        const double *x = other[j];
        double d[2] = {x[0] - at[0], x[1] - at[1]}, far = sqrt(cell->far2) + off;

        if (d[0] * d[0] + d[1] * d[1] + x[2] * x[2] < 4 * far * far)
            vor_flat_clip(cell, d, (vor_dot(x, x) - at2) / 2, j);
    }
}

/* Energy of the triangle of the seed and two corners, relative to it, and its gradient in them. */
struct triangle {
    double value, by[2][2], area;
};

/* The sum of a^i b^j over i + j = p in *value, and its derivatives. */
static void sum_powers(unsigned p, double a, double b, double *value, double *by_a, double *by_b)
{
    double sum = 1, da = 0, db = 0, power = 1; /* power: b^k */

    /* S(k) = a S(k - 1) + b^k */
    for (unsigned k = 1; k <= p; k++) {
        da = a * da + sum;
        db = a * db + k * power;
        power *= b;
        sum = a * sum + power;
    }
    *value = sum;
    *by_a = da;
    *by_b = db;
}

static void find_triangle(struct triangle *out, const struct vor_energy_plane *plane,
                          const double c1[2], const double c2[2])
{
    double area = (c1[0] * c2[1] - c1[1] * c2[0]) / 2, sum = 0;
    double share = 2.0 / ((plane->power + 1) * (plane->power + 2));

    for (int d = 0; d < 2; d++) {
        double m = plane->factor[d], value, by1, by2;

        sum_powers(plane->power, m * c1[d], m * c2[d], &value, &by1, &by2);
        sum += value;
        out->by[0][d] = share * area * m * by1;
        out->by[1][d] = share * area * m * by2;
    }
    out->area = area;
    out->value = share * area * sum;
    out->by[0][0] += share * sum * c2[1] / 2;
    out->by[0][1] -= share * sum * c2[0] / 2;
    out->by[1][0] -= share * sum * c1[1] / 2;
    out->by[1][1] += share * sum * c1[0] / 2;
}

/* Direction across the line of an edge, as far from the seed at `at` as the line is given. */
static void across(double n[2], const struct vor_energy_plane *plane, uint32_t id,
                   const double at[2], const double (*other)[3])
{
    if (id < VOR_FLAT_SIDE) {
        n[0] = other[id][0] - at[0];
        n[1] = other[id][1] - at[1];
    } else if (id == VOR_ENERGY_WALL) {
        n[0] = plane->wall[0];
        n[1] = plane->wall[1];
    } else {
        const double *a = vor_patch_octagon[id - VOR_FLAT_SIDE];
        const double *b = vor_patch_octagon[(id - VOR_FLAT_SIDE + 1) % VOR_PATCH_OCTAGON];

        n[0] = a[0] + b[0];
        n[1] = a[1] + b[1];
    }
}

/* The share of other seed `id` in the gradient; made on its first mention. */
static double *share_of(struct vor_energy *out, uint32_t id)
{
    for (unsigned k = 0; k < out->count; k++)
        if (out->id[k] == id)
            return out->by[k];
    out->id[out->count] = id;
    memset(out->by[out->count], 0, sizeof out->by[0]);
    return out->by[out->count++];
}

/* Adds what moving a line by `times` along its gradient changes. The bisector of s and x is where
 * (x - s) z = (x^2 - s^2) / 2; so it moves by (x - z) dx + (z - s) ds. */
static void add_line(struct vor_energy *out, uint32_t id, double times, const double at[2],
                     const double x[3], const double z[2])
{
    double *by;

    by = share_of(out, id);
    by[0] += times * (x[0] - z[0]);
    by[1] += times * (x[1] - z[1]);
    by[2] += times * x[2];
    out->own[0] += times * (z[0] - at[0]);
    out->own[1] += times * (z[1] - at[1]);
}

/* A corner of a cell. */
struct corner {
    uint32_t a, b; /* its edges */
    double z[2];
    const double *by; /* the gradient in z */
};

/* Adds what a corner changes when its lines move. */
static void add_corner(struct vor_energy *out, const struct vor_energy_plane *plane,
                       const struct corner *corner, const double at[2], const double (*other)[3])
{
    const double *z = corner->z, *by = corner->by;
    uint32_t a = corner->a, b = corner->b;
    double na[2], nb[2], det;

    if (a >= VOR_FLAT_SIDE && b >= VOR_FLAT_SIDE)
        return;
    across(na, plane, a, at, other);
    across(nb, plane, b, at, other);
    det = na[0] * nb[1] - na[1] * nb[0];
    if (det * det <=
        VOR_ROUNDED2 * (na[0] * na[0] + na[1] * na[1]) * (nb[0] * nb[0] + nb[1] * nb[1]))
        return;
    /* times_a na + times_b nb = by */
    if (a < VOR_FLAT_SIDE)
        add_line(out, a, (by[0] * nb[1] - by[1] * nb[0]) / det, at, other[a], z);
    if (b < VOR_FLAT_SIDE)
        add_line(out, b, (by[1] * na[0] - by[0] * na[1]) / det, at, other[b], z);
}

void vor_energy_of(struct vor_energy *out, const struct vor_flat *cell,
                   const struct vor_energy_plane *plane, const double at[2],
                   const double (*other)[3])
{
    double by[VOR_POLYGON_MAX][2] = {{0}};

    out->value = out->own[0] = out->own[1] = out->bend[0] = out->bend[1] = 0;
    out->count = 0;
    for (unsigned e = 0; e < cell->count; e++) {
        unsigned f = e + 1 < cell->count ? e + 1 : 0;
        double c1[2] = {cell->x[e] - at[0], cell->y[e] - at[1]};
        double c2[2] = {cell->x[f] - at[0], cell->y[f] - at[1]};
        struct triangle triangle;
        unsigned p = plane->power;

        find_triangle(&triangle, plane, c1, c2);
        /* Adds the second derivative, were the cell to stand still: p (p - 1) times the integral of
         * the power p - 2. */
        for (int d = 0; d < 2; d++) {
            double m = plane->factor[d], value, by1, by2;

            sum_powers(p - 2, m * c1[d], m * c2[d], &value, &by1, &by2);
            out->bend[d] += 2 * triangle.area * m * m * value; /* (p - 1) p / C(p, 2) = 2 */
        }
        out->value += triangle.value;
        for (int d = 0; d < 2; d++) {
            by[e][d] += triangle.by[0][d];
            by[f][d] += triangle.by[1][d];
            out->own[d] -= triangle.by[0][d] + triangle.by[1][d];
        }
    }
    for (unsigned e = 0; e < cell->count; e++)
        add_corner(out, plane,
                   &(struct corner){cell->id[e > 0 ? e - 1 : cell->count - 1],
                                    cell->id[e],
                                    {cell->x[e], cell->y[e]},
                                    by[e]},
                   at, other);
}

int vor_energy_shape_of(struct vor_energy_shape *out, const struct vor_flat *cell,
                        const double at[2])
{
    double area = 0, first[2] = {0}, second[3] = {0};

    for (unsigned e = 0; e < cell->count; e++) {
        unsigned f = e + 1 < cell->count ? e + 1 : 0;
        double a = cell->x[e] - at[0], b = cell->y[e] - at[1];
        double c = cell->x[f] - at[0], d = cell->y[f] - at[1], here = (a * d - b * c) / 2;

        area += here;
        first[0] += here / 3 * (a + c);
        first[1] += here / 3 * (b + d);
        second[0] += here / 6 * (a * a + a * c + c * c);
        second[1] += here / 12 * (2 * a * b + a * d + b * c + 2 * c * d);
        second[2] += here / 6 * (b * b + b * d + d * d);
    }
    if (!(area > 0))
        return 0;
    out->area = area;
    out->energy = second[0] + second[2];
    out->moment[0] = second[0] - first[0] * first[0] / area;
    out->moment[1] = second[1] - first[0] * first[1] / area;
    out->moment[2] = second[2] - first[1] * first[1] / area;
    return 1;
}
