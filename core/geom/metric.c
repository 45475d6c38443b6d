#include "core/geom/metric.h"

#include <string.h>

void vor_metric_axes(double axis[2][3], const double normal[3])
{
    double x = fabs(normal[0]), y = fabs(normal[1]), z = fabs(normal[2]), length;
    double across[3] = {0, 0, 0};

    across[x <= y && x <= z ? 0 : y <= z ? 1 : 2] = 1; /* the coordinate farthest from the normal */
    vor_cross(axis[0], across, normal);
    length = sqrt(vor_dot(axis[0], axis[0]));
    for (int c = 0; c < 3; c++)
        axis[0][c] /= length;
    vor_cross(axis[1], normal, axis[0]);
}

/* g d. */
static void apply(double out[3], const double g[6], const double d[3])
{
    out[0] = g[0] * d[0] + g[1] * d[1] + g[2] * d[2];
    out[1] = g[1] * d[0] + g[3] * d[1] + g[4] * d[2];
    out[2] = g[2] * d[0] + g[4] * d[1] + g[5] * d[2];
}

void vor_metric_restrict(double plane[3], const double g[6], const double axis[2][3])
{
    double u[3], v[3];

    apply(u, g, axis[0]);
    apply(v, g, axis[1]);
    plane[0] = vor_dot(axis[0], u);
    plane[1] = vor_dot(axis[1], u);
    plane[2] = vor_dot(axis[1], v);
}

void vor_metric_raise(double g[6], const double plane[3], const double axis[2][3],
                      const double normal[3])
{
    unsigned at = 0;

    for (int a = 0; a < 3; a++)
        for (int b = a; b < 3; b++)
            g[at++] = plane[0] * axis[0][a] * axis[0][b] +
                      plane[1] * (axis[0][a] * axis[1][b] + axis[1][a] * axis[0][b]) +
                      plane[2] * axis[1][a] * axis[1][b] + normal[a] * normal[b];
}

/* Half of the difference of the eigenvalues. */
static double half_apart(const double plane[3])
{
    double half = (plane[0] - plane[2]) / 2;

    return sqrt(half * half + plane[1] * plane[1]);
}

static void all_alike(double plane[3])
{
    plane[0] = plane[2] = 1;
    plane[1] = 0;
}

/* The tensor with the eigenvectors of `from` and eigenvalues `high`, for the algebraically larger
 * one of `from`, and 1 / high. A tensor whose eigenvalues coincide has no eigenvectors: then all
 * directions are alike. */
static void with_eigenvalue(double plane[3], const double from[3], double high)
{
    double apart = half_apart(from), mean = (from[0] + from[2]) / 2;
    double scale = (high - 1 / high) / (2 * apart), middle = (high + 1 / high) / 2;
    double shift = middle - scale * mean, whole[3];

    if (!isfinite(scale) || !isfinite(shift)) {
        all_alike(plane);
        return;
    }
    whole[0] = scale * from[0] + shift;
    whole[1] = scale * from[1];
    whole[2] = scale * from[2] + shift;
    memcpy(plane, whole, sizeof whole);
}

int vor_metric_even(double plane[3], double most)
{
    double mean = (plane[0] + plane[2]) / 2, apart = half_apart(plane);
    double ratio = (mean + apart) / (mean - apart), aspect;

    if (!(mean - apart > 0) || !isfinite(ratio)) {
        all_alike(plane);
        return 0;
    }
    aspect = sqrt(ratio);
    with_eigenvalue(plane, plane, aspect < most ? aspect : most);
    return 1;
}

void vor_metric_of_bend(double plane[3], const double bend[3], double floor, double most)
{
    double mean = (bend[0] + bend[2]) / 2, apart = half_apart(bend);
    double high = fmax(fabs(mean + apart), floor), low = fmax(fabs(mean - apart), floor);
    double aspect = sqrt(high > low ? high / low : low / high);

    aspect = aspect < most ? aspect : most;
    with_eigenvalue(plane, bend, high > low ? aspect : 1 / aspect);
}

double vor_metric_aspect(const double plane[3])
{
    return fmax((plane[0] + plane[2]) / 2 + half_apart(plane), 1);
}

void vor_metric_long_side(double direction[2], const double plane[3])
{
    double apart = half_apart(plane), half = (plane[0] - plane[2]) / 2, length;

    /* The eigenvector of the smaller eigenvalue, from the row that does not cancel. */
    if (half > 0) {
        direction[0] = -plane[1];
        direction[1] = half + apart;
    } else {
        direction[0] = apart - half;
        direction[1] = -plane[1];
    }
    length = sqrt(direction[0] * direction[0] + direction[1] * direction[1]);
    if (!(length > 0)) {
        direction[0] = 1;
        direction[1] = 0;
        return;
    }
    direction[0] /= length;
    direction[1] /= length;
}

void vor_metric_root(double root[3], const double plane[3])
{
    double scale = 1 / sqrt(plane[0] + plane[2] + 2); /* Cayley and Hamilton */

    root[0] = (plane[0] + 1) * scale;
    root[1] = plane[1] * scale;
    root[2] = (plane[2] + 1) * scale;
}
