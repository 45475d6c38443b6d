#include "core/cloud/extent.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { EDGE_MIN = 2, EDGE_MAX = VOR_EXTENT_EDGE_MAX, POINTS_A_CUBE = 8 };

/* Area of a point's cell over the square of the spacing, in the hexagonal lattice. */
static const double HEXAGON = 0.86602540378443864676;

/* Widens the box by the positions of points first .. end - 1. */
static void bound(struct vor_extent_walk *walk, size_t first, size_t end)
{
    const float *x = walk->cloud->xyz + 3 * first;
    float low[3], high[3];

    memcpy(low, walk->low, sizeof low);
    memcpy(high, walk->high, sizeof high);
    for (size_t i = first; i < end; i++, x += 3)
        for (int c = 0; c < 3; c++) {
            low[c] = x[c] < low[c] ? x[c] : low[c];
            high[c] = x[c] > high[c] ? x[c] : high[c];
        }
    memcpy(walk->low, low, sizeof low);
    memcpy(walk->high, high, sizeof high);
}

/* Marks the cubes that points first .. end - 1 lie in. */
static void mark_cubes(struct vor_extent_walk *walk, size_t first, size_t end)
{
    const float *x = walk->cloud->xyz + 3 * first;
    unsigned edge = walk->edge;
    double scale = edge / walk->side;

    if (!(walk->side > 0))
        return;
    for (size_t i = first; i < end; i++, x += 3) {
        unsigned at = 0;

        for (int c = 0; c < 3; c++) {
            double cube = ((double)x[c] - (double)walk->low[c]) * scale;

            at = at * EDGE_MAX + (cube < edge - 1 ? (unsigned)cube : edge - 1);
        }
        walk->seen[at / 64] |= (uint64_t)1 << at % 64;
    }
}

static double area(const struct vor_extent_walk *walk)
{
    double cube = walk->side / walk->edge;
    unsigned count = 0;

    for (size_t i = 0; i < sizeof walk->seen / sizeof *walk->seen; i++)
        count += (unsigned)__builtin_popcountll(walk->seen[i]);
    return count * cube * cube / VOR_EXTENT_CUBES;
}

void vor_extent_begin(struct vor_extent_walk *walk, const struct vor_cloud *cloud)
{
    *walk = (struct vor_extent_walk){.cloud = cloud};
    memcpy(walk->low, cloud->xyz, sizeof walk->low);
    memcpy(walk->high, cloud->xyz, sizeof walk->high);
}

void vor_extent_walk(struct vor_extent_walk *walk, size_t points)
{
    size_t n = walk->cloud->n, end = points < 2 * n - walk->next ? walk->next + points : 2 * n;

    if (walk->next < n) {
        size_t until = end < n ? end : n;

        bound(walk, walk->next, until);
        walk->next = until;
        if (until == n) {
            double most = sqrt((double)walk->cloud->n / (5 * POINTS_A_CUBE));

            for (int c = 0; c < 3; c++)
                walk->side = fmax(walk->side, (double)walk->high[c] - (double)walk->low[c]);
            walk->edge = (unsigned)fmin(fmax(most, EDGE_MIN), EDGE_MAX);
        }
    }
    if (walk->next < end) {
        mark_cubes(walk, walk->next - n, end - n);
        walk->next = end;
    }
}

void vor_extent_end(struct vor_extent *out, struct vor_extent_walk *walk)
{
    const struct vor_cloud *cloud = walk->cloud;

    vor_extent_walk(walk, SIZE_MAX);
    out->n = cloud->n;
    for (int c = 0; c < 3; c++) {
        out->low[c] = cloud->origin[c] + (double)walk->low[c];
        out->high[c] = cloud->origin[c] + (double)walk->high[c];
    }
    out->area = area(walk);
}

void vor_extent_measure(struct vor_extent *out, const struct vor_cloud *cloud)
{
    struct vor_extent_walk walk;

    vor_extent_begin(&walk, cloud);
    vor_extent_end(out, &walk);
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
