#include "core/geom/integrate.h"

#include "core/base/linalg.h"

#include <string.h>

static double triangle_area(const double a[3], const double b[3], const double c[3])
{
    double ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    double ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]}, n[3];

    vor_cross(n, ab, ac);
    return sqrt(vor_dot(n, n)) / 2;
}

int vor_cell_moments(struct vor_moments *out, const struct vor_cell *cell)
{
    double area = 0, energy = 0, sum[3] = {0};

    for (unsigned i = 0; i < cell->count; i++) {
        const struct vor_polygon *polygon = &cell->piece[i];
        const double *a = polygon->vertex[0];

        for (unsigned j = 2; j < polygon->count; j++) {
            const double *b = polygon->vertex[j - 1], *c = polygon->vertex[j];
            double here = triangle_area(a, b, c);
            double s[3] = {a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]};

            area += here;
            for (int d = 0; d < 3; d++)
                sum[d] += here / 3 * s[d];
            energy += here / 12 * (vor_dot(a, a) + vor_dot(b, b) + vor_dot(c, c) + vor_dot(s, s));
        }
    }
    if (!(area > 0))
        return 0;
    out->area = area;
    out->energy = energy;
    for (int d = 0; d < 3; d++)
        out->centroid[d] = cell->seed[d] + sum[d] / area;
    return isfinite(out->centroid[0]) && isfinite(out->centroid[1]) && isfinite(out->centroid[2]);
}

/* Density at a corner of the cell. */
static double density_at(const struct vor_cell_spacing *spacing, const double corner[3])
{
    double value = spacing->value + vor_dot(spacing->slope, corner), square;

    value = fmin(fmax(value, spacing->value / 2), 2 * spacing->value);
    square = value * value;
    return 1 / (square * square);
}

/* Sums over triangles with a density. */
struct dense {
    double area, mass, energy, sum[3];
};

/* Adds a triangle whose density is linear between rho at its corners. With barycentric coordinates
 * l, the integral of l_i l_j is (1 + [i = j]) area / 12, that of l_i l_j l_k is area / 60 times 6,
 * 2 or 1 where three, two or none of i, j, k are the same. */
static void add_dense(struct dense *to, const double *const corner[3], const double rho[3])
{
    double here = triangle_area(corner[0], corner[1], corner[2]);
    double s[3], squares = 0, all = rho[0] + rho[1] + rho[2];

    for (int d = 0; d < 3; d++)
        s[d] = corner[0][d] + corner[1][d] + corner[2][d];
    for (int i = 0; i < 3; i++)
        squares += vor_dot(corner[i], corner[i]);
    to->area += here;
    to->mass += here / 3 * all;
    for (int i = 0; i < 3; i++) {
        const double *x = corner[i];

        for (int d = 0; d < 3; d++)
            to->sum[d] += here / 12 * (all + rho[i]) * x[d];
        to->energy +=
            here / 60 * rho[i] * (vor_dot(s, s) + 2 * vor_dot(x, s) + squares + 2 * vor_dot(x, x));
    }
}

int vor_cell_moments_dense(struct vor_moments *out, const struct vor_cell *cell,
                           const struct vor_cell_spacing *spacing)
{
    struct dense total = {0};

    for (unsigned i = 0; i < cell->count; i++) {
        const struct vor_polygon *polygon = &cell->piece[i];
        const double *corner[3] = {polygon->vertex[0], NULL, polygon->vertex[1]};
        double rho[3] = {density_at(spacing, corner[0]), 0, density_at(spacing, corner[2])};

        for (unsigned j = 2; j < polygon->count; j++) {
            corner[1] = corner[2];
            rho[1] = rho[2];
            corner[2] = polygon->vertex[j];
            rho[2] = density_at(spacing, corner[2]);
            add_dense(&total, corner, rho);
        }
    }
    if (!(total.area > 0) || !(total.mass > 0))
        return 0;
    out->area = total.area;
    out->energy = total.energy;
    for (int d = 0; d < 3; d++)
        out->centroid[d] = cell->seed[d] + total.sum[d] / total.mass;
    return isfinite(out->centroid[0]) && isfinite(out->centroid[1]) && isfinite(out->centroid[2]);
}

/* Adds a uniform point of a triangle: the unit square is folded along its diagonal. */
static void add_sample(double to[3], const double *const corner[3], double s, double t)
{
    const double *a = corner[0], *b = corner[1], *c = corner[2];

    if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
    }
    for (int d = 0; d < 3; d++)
        to[d] += a[d] + s * (b[d] - a[d]) + t * (c[d] - a[d]);
}

void vor_cell_sample(const struct vor_cell *cell, double area, size_t n, const double (*unit)[3],
                     double (*local)[3])
{
    double part[VOR_PATCH_TRIANGLES_MAX * (VOR_POLYGON_MAX - 2)]; /* areas of its triangles */
    const double *corner[VOR_PATCH_TRIANGLES_MAX * (VOR_POLYGON_MAX - 2)][3];
    size_t parts = 0;

    part[0] = 0;
    for (unsigned i = 0; i < cell->count && area > 0; i++) {
        const struct vor_polygon *polygon = &cell->piece[i];

        for (unsigned j = 2; j < polygon->count; j++, parts++) {
            const double **at = corner[parts];

            at[0] = polygon->vertex[0];
            at[1] = polygon->vertex[j - 1];
            at[2] = polygon->vertex[j];
            part[parts] = triangle_area(at[0], at[1], at[2]);
        }
    }
    for (size_t k = 0; k < n; k++) {
        double left = unit[k][0] * area - part[0];
        size_t at = 0;

        memcpy(local[k], cell->seed, sizeof cell->seed);
        while (!(left < 0) && at + 1 < parts) /* rounding may leave an area after the last one */
            left -= part[++at];
        if (parts > 0)
            add_sample(local[k], corner[at], unit[k][1], unit[k][2]);
    }
}
