#include "core/geom/crease.h"

#include "core/base/linalg.h"
#include "core/geom/surface.h"

#include <math.h>
#include <string.h>

enum {
    SHARED_TERMS = 5, /* terms that crease and quadric share */
    SIDE_TERMS = 3,   /* of a plane */
    /* Rounds in which the sides get their own planes. At 0 / 1 / 3 / 6: recall on fandisk30k .820 /
     * .971 / .974 / .975, precision on fandisk30k_noise2 .871 / .923 / .920 / .919 (input/edges.h
     * says what these are). */
    ROUNDS = 3,
    STEPS = 4 /* of STEP, to either side of the first point */
};

/* Where the edge is looked for, in spacings: twice as far as an edge that is flagged, so that one
 * farther away is not taken for one there. At steps of 0.25 / 0.5 / 1: recall on fandisk30k .973 /
 * .974 / .972, precision on fandisk30k_noise2 .923 / .920 / .915, CPU there 18.8 / 17 / 15 us. */
#define STEP 0.5

/* The points in the frame of the fit, in spacings. */
struct fit {
    unsigned k;
    double u[VOR_NEIGHBORS_MAX], v[VOR_NEIGHBORS_MAX], w[VOR_NEIGHBORS_MAX];
    double q[SHARED_TERMS][VOR_NEIGHBORS_MAX]; /* orthonormal columns of 1, u, v, uv, vv */
    double rest[VOR_NEIGHBORS_MAX];            /* w without its part in them */
};

/* Where the kink is, u = at + slant v, its change of slope, and by how much it lowers the sum of
 * squares of rest. */
struct kink {
    double at, slant, slope, gain;
};

static double dot(const double *a, const double *b, unsigned k)
{
    double sum = 0;

    for (unsigned j = 0; j < k; j++)
        sum += a[j] * b[j];
    return sum;
}

/* The parts of a column in the basis. In one loop: sums in order are slow one after another. */
static void parts_of(double part[SHARED_TERMS], const struct fit *fit, const double *column)
{
    memset(part, 0, SHARED_TERMS * sizeof *part);
    for (unsigned j = 0; j < fit->k; j++)
        for (unsigned b = 0; b < SHARED_TERMS; b++)
            part[b] += fit->q[b][j] * column[j];
}

/* Takes the first `count` columns of the basis out of a column. */
static void take_out(double *column, const struct fit *fit, unsigned count)
{
    for (unsigned b = 0; b < count; b++) {
        double part = dot(fit->q[b], column, fit->k);

        for (unsigned j = 0; j < fit->k; j++)
            column[j] -= part * fit->q[b][j];
    }
}

/* By how much a further column lowers the sum of squares of rest, and its coefficient. */
static double gain_of(const struct fit *fit, const double *column, double *coefficient)
{
    double part[SHARED_TERMS], all = dot(column, column, fit->k), own, shared;

    parts_of(part, fit, column);
    own = all - dot(part, part, SHARED_TERMS);
    *coefficient = 0;
    if (!(own > VOR_ROUNDED * all))
        return 0;
    shared = dot(column, fit->rest, fit->k);
    *coefficient = shared / own;
    return shared * shared / own;
}

/* How far point j is beyond the edge. */
static double beyond(const struct fit *fit, const struct kink *kink, unsigned j)
{
    return fit->u[j] - kink->at - kink->slant * fit->v[j];
}

/* Sets gain and slope of a kink whose place is known. */
static void weigh(struct kink *kink, const struct fit *fit)
{
    double column[VOR_NEIGHBORS_MAX];

    for (unsigned j = 0; j < fit->k; j++)
        column[j] = fmax(0, beyond(fit, kink, j));
    kink->gain = gain_of(fit, column, &kink->slope);
}

/* Fits a plane of its own to what lies beyond the edge. Returns whether the two planes meet in a
 * line near the first point, which is the next kink's place. */
static int meet(struct kink *next, const struct fit *fit, const struct kink *kink)
{
    double column[SIDE_TERMS][VOR_NEIGHBORS_MAX], part[SIDE_TERMS][SHARED_TERMS],
        a[SIDE_TERMS * SIDE_TERMS], b[SIDE_TERMS];

    for (unsigned j = 0; j < fit->k; j++) {
        double on = beyond(fit, kink, j) > 0;

        column[0][j] = on;
        column[1][j] = on * fit->u[j];
        column[2][j] = on * fit->v[j];
    }
    for (int x = 0; x < SIDE_TERMS; x++) {
        parts_of(part[x], fit, column[x]);
        b[x] = dot(column[x], fit->rest, fit->k);
        for (int y = 0; y <= x; y++)
            a[SIDE_TERMS * x + y] =
                dot(column[x], column[y], fit->k) - dot(part[x], part[y], SHARED_TERMS);
    }
    if (vor_solve_spd(a, b, SIDE_TERMS, VOR_ROUNDED) == 0)
        return 0;
    next->at = -b[0] / b[1];
    next->slant = -b[2] / b[1];
    return isfinite(next->at); /* not so where they are parallel */
}

static struct kink find(const struct fit *fit)
{
    struct kink best = {0};

    for (int i = -STEPS; i <= STEPS; i++) { /* the best of a row of places */
        struct kink kink = {.at = i * STEP};

        weigh(&kink, fit);
        if (kink.gain > best.gain)
            best = kink;
    }

    for (int round = 0; round < ROUNDS && best.gain > 0; round++) {
        struct kink next;

        if (!meet(&next, fit, &best))
            break;
        weigh(&next, fit);
        if (!(next.gain > best.gain))
            break;
        best = next;
    }
    return best;
}

/* The line through the heights over the way across, without what the kink adds. False where all lie
 * at one place. */
static int near_side(const struct fit *fit, const struct kink *kink, double *slope, double *height)
{
    double su = 0, sw = 0, suu = 0, suw = 0, k = (double)fit->k;

    for (unsigned j = 0; j < fit->k; j++) {
        double u = fit->u[j], w = fit->w[j] - kink->slope * fmax(0, beyond(fit, kink, j));

        su += u;
        sw += w;
        suu += u * u;
        suw += u * w;
    }
    *slope = *height = 0;
    if (!(suu * k - su * su > VOR_ROUNDED * suu * k))
        return 0;
    *slope = (suw * k - su * sw) / (suu * k - su * su);
    *height = (sw - *slope * su) / k;
    return 1;
}

/* Sine of half the angle between the normals of the two sides, by the slope of the near one. */
static double turn_of(const struct kink *kink, double p)
{
    double q = p + kink->slope, cosine = (1 + p * q) / sqrt((1 + p * p) * (1 + q * q));

    return sqrt(fmax(0, (1 - cosine) / 2));
}

void vor_crease_fit(struct vor_crease *out, const float *near, unsigned k, double axis[3][3],
                    double spacing)
{
    struct fit fit;
    struct kink kink;
    double rest2, length, slope, height, foot[3], parabola[VOR_NEIGHBORS_MAX], coefficient;

    fit.k = k;
    for (unsigned j = 0; j < k; j++) {
        double d[3];

        for (unsigned c = 0; c < 3; c++)
            d[c] = ((double)near[3 * j + c] - (double)near[c]) / spacing;
        fit.v[j] = vor_dot(axis[0], d);
        fit.u[j] = vor_dot(axis[1], d);
        fit.w[j] = vor_dot(axis[2], d);
    }
    /* Gram-Schmidt; a column that depends on those before it becomes 0. */
    for (unsigned b = 0; b < SHARED_TERMS; b++) {
        double *q = fit.q[b], before, after, scale;

        for (unsigned j = 0; j < fit.k; j++)
            q[j] = ((double[SHARED_TERMS]){1, fit.u[j], fit.v[j], fit.u[j] * fit.v[j],
                                           fit.v[j] * fit.v[j]})[b];
        before = dot(q, q, fit.k);
        take_out(q, &fit, b);
        after = dot(q, q, fit.k);
        scale = after > VOR_ROUNDED * before ? 1 / sqrt(after) : 0;
        for (unsigned j = 0; j < fit.k; j++)
            q[j] *= scale;
    }
    memcpy(fit.rest, fit.w, fit.k * sizeof *fit.rest);
    take_out(fit.rest, &fit, SHARED_TERMS);
    kink = find(&fit);
    rest2 = dot(fit.rest, fit.rest, k);
    length = sqrt(1 + kink.slant * kink.slant);
    for (unsigned j = 0; j < k; j++)
        parabola[j] = fit.u[j] * fit.u[j];
    out->smooth2 = fmax(0, rest2 - gain_of(&fit, parabola, &coefficient)) / k;
    out->crease2 = fmax(0, rest2 - kink.gain) / k;
    out->distance = fabs(kink.at) / length;
    out->turn = near_side(&fit, &kink, &slope, &height) ? turn_of(&kink, slope) : 0;
    foot[0] = -kink.at * kink.slant / (length * length);
    foot[1] = kink.at / (length * length);
    foot[2] = height + slope * foot[1];
    for (int c = 0; c < 3; c++) {
        out->along[c] = (axis[0][c] + kink.slant * axis[1][c]) / length;
        out->foot[c] = foot[0] * axis[0][c] + foot[1] * axis[1][c] + foot[2] * axis[2][c];
    }
}
