#include "core/cloud/extent.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

enum {
    EDGE_MIN = 2,  /* cubes along an edge of the box */
    EDGE_MAX = 64, /* 32 KiB of bits */
    POINTS_A_CUBE = 8
};

/* Cubes that a surface of area 1 meets, of edge 1: the mean of |nx| + |ny| + |nz| over all
 * directions of its normal. */
static const double CUBES_OF_AREA = 1.5;

/* Area of a point's cell over the square of the spacing, in the hexagonal lattice. */
static const double HEXAGON = 0.86602540378443864676;

/* The box of the relative positions. */
static void bound(const struct vor_cloud *cloud, float low[3], float high[3])
{
    const float *x = cloud->xyz;

    memcpy(low, x, 3 * sizeof *x);
    memcpy(high, x, 3 * sizeof *x);
    for (size_t i = 1; i < cloud->n; i++) {
        x += 3;
        for (int c = 0; c < 3; c++) {
            low[c] = x[c] < low[c] ? x[c] : low[c];
            high[c] = x[c] > high[c] ? x[c] : high[c];
        }
    }
}

/* Counts the cubes with points in them: `edge` of them along the longest side of the box. */
static unsigned count_cubes(const struct vor_cloud *cloud, const float low[3], double side,
                            unsigned edge)
{
    uint64_t seen[EDGE_MAX * EDGE_MAX * EDGE_MAX / 64] = {0};
    double scale = edge / side;
    unsigned count = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        unsigned at = 0;

        for (size_t c = 0; c < 3; c++) {
            double cube = ((double)cloud->xyz[3 * i + c] - (double)low[c]) * scale;

            at = at * EDGE_MAX + (cube < edge - 1 ? (unsigned)cube : edge - 1);
        }
        seen[at / 64] |= (uint64_t)1 << at % 64;
    }
    for (size_t i = 0; i < sizeof seen / sizeof *seen; i++)
        count += (unsigned)__builtin_popcountll(seen[i]);
    return count;
}

/* A closed surface that fills its box meets some 5 edge^2 cubes: fewer than n / POINTS_A_CUBE. */
static double estimate_area(const struct vor_cloud *cloud, const float low[3], double side)
{
    double most = sqrt((double)cloud->n / (5 * POINTS_A_CUBE));
    unsigned edge = (unsigned)fmin(fmax(most, EDGE_MIN), EDGE_MAX);
    double cube = side / edge;

    return side > 0 ? count_cubes(cloud, low, side, edge) * cube * cube / CUBES_OF_AREA : 0;
}

void vor_extent_measure(struct vor_extent *out, const struct vor_cloud *cloud)
{
    float low[3], high[3];
    double side = 0;

    bound(cloud, low, high);
    out->n = cloud->n;
    for (int c = 0; c < 3; c++) {
        out->low[c] = cloud->origin[c] + (double)low[c];
        out->high[c] = cloud->origin[c] + (double)high[c];
        side = fmax(side, (double)high[c] - (double)low[c]);
    }
    out->area = estimate_area(cloud, low, side);
}

double vor_extent_spacing(const struct vor_extent *extent, double n)
{
    return sqrt(extent->area / (HEXAGON * n));
}

void vor_extent_middle(double out[3], const struct vor_extent *extent, double step)
{
    double half = 0;

    for (int c = 0; c < 3; c++)
        half = fmax(half, extent->high[c] / 2 - extent->low[c] / 2);
    for (int exponent = 0;; exponent--) {
        double unit = ldexp(1, exponent);

        for (int c = 0; c < 3; c++)
            out[c] = rint((extent->low[c] / 2 + extent->high[c] / 2) / unit) * unit + 0.0;
        if (unit <= half || half == 0 || step <= 0 || vor_extent_step(extent, out) <= step)
            return;
    }
}

double vor_extent_step(const struct vor_extent *extent, const double origin[3])
{
    double farthest = 0;
    int exponent = FLT_MIN_EXP;

    for (int c = 0; c < 3; c++)
        farthest = fmax(farthest,
                        fmax(fabs(extent->low[c] - origin[c]), fabs(extent->high[c] - origin[c])));
    if (!(farthest <= (double)FLT_MAX))
        return INFINITY;
    if (farthest > (double)FLT_MIN)
        (void)frexp(farthest, &exponent); /* farthest < 2^exponent */
    return ldexp(1, exponent - FLT_MANT_DIG);
}
