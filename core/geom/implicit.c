#include "core/geom/implicit.h"

#include "core/base/linalg.h"

enum { TERMS = VOR_IMPLICIT_TERMS };

/* Mean square off the quadric over that off one height, below which there are two faces. Taken of
 * 12,000 points with noise of 0.3 spacings at 0.04 / 0.1 / 0.25: 3 / 190 / 4,000 (split in two,
 * noise has 0.36); at 0.0064 half of an ellipsoid one spacing thick with noise of 0.05 faces
 * inward. */
#define NEARER2 0.04

/* x, y, z, their squares and products, and the gradients of these. */
static void set_terms(double term[TERMS], double gradient[3][TERMS], const double x[3])
{
    memset(gradient, 0, 3 * sizeof *gradient);
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3;

        term[c] = x[c];
        term[3 + c] = x[c] * x[c];
        term[6 + c] = x[c] * x[d];
        gradient[c][c] = 1;
        gradient[c][3 + c] = 2 * x[c];
        gradient[c][6 + c] = x[d];
        gradient[d][6 + c] = x[c];
    }
}

/* Where a place is, over the radius. */
static void locate(double out[3], const struct vor_implicit *implicit, const float x[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = ((double)x[c] - implicit->origin[c]) / implicit->radius;
}

/* Sums over the points, by weight: of the terms' products, and of those of their gradients. */
struct sums {
    double weight, mean[TERMS], product[TERMS][TERMS], gradient[TERMS][TERMS];
};

static void add_point(struct sums *sums, const double x[3])
{
    double term[TERMS], gradient[3][TERMS], weight = fmax(0, 1 - vor_dot(x, x));

    weight *= weight;
    set_terms(term, gradient, x);
    sums->weight += weight;
    for (int j = 0; j < TERMS; j++) {
        sums->mean[j] += weight * term[j];
        for (int k = 0; k <= j; k++) {
            sums->product[j][k] += weight * term[j] * term[k];
            for (int c = 0; c < 3; c++)
                sums->gradient[j][k] += weight * gradient[c][j] * gradient[c][k];
        }
    }
}

/* The product of c with a symmetric matrix of which there is the lower triangle. */
static void multiply(double out[TERMS], double m[TERMS][TERMS], const double c[TERMS])
{
    for (int j = 0; j < TERMS; j++) {
        out[j] = 0;
        for (int k = 0; k < TERMS; k++)
            out[j] += (k <= j ? m[j][k] : m[k][j]) * c[k];
    }
}

/* Finds the coefficients of least value over gradient, squared, by inverse iteration: the least is
 * far below the others where it is taken. Returns it, or less than 0. */
static double find_least(double c[TERMS], struct sums *sums)
{
    double a[TERMS * TERMS], value[TERMS], slope[TERMS], above = 0, below = 0;

    for (int j = 0; j < TERMS; j++) {
        for (int k = 0; k <= j; k++)
            sums->product[j][k] -= sums->mean[j] * sums->mean[k] / sums->weight;
        sums->product[j][j] *= 1 + VOR_ROUNDED2; /* it may be 0 on all points */
        c[j] = 1;
    }
    for (int time = 0; time < TERMS; time++) {
        double length2 = 0;

        memcpy(a, sums->product, sizeof a);
        if (time > 0)
            memcpy(c, slope, sizeof slope);
        if (!(vor_solve_spd(a, c, TERMS, 0) > 0))
            return -1;
        for (int k = 0; k < TERMS; k++)
            length2 += c[k] * c[k];
        for (int k = 0; k < TERMS; k++)
            c[k] /= sqrt(length2);
        multiply(slope, sums->gradient, c);
    }
    multiply(value, sums->product, c);
    for (int k = 0; k < TERMS; k++) {
        above += value[k] * c[k];
        below += slope[k] * c[k];
    }
    return below > 0 ? fmax(0, above / below) : -1;
}

/* Whether as many of the points as determine a surface face either way along a direction, within 45
 * degrees. */
static int faces_both(const struct vor_implicit *fit, const float *near, unsigned n,
                      const double direction[3])
{
    unsigned up = 0, down = 0;

    for (unsigned i = 0; i < n; i++) {
        double normal[3], along;

        vor_implicit_normal(fit, &near[3 * i], normal);
        along = vor_dot(normal, direction);
        up += along > M_SQRT1_2;
        down += along < -M_SQRT1_2;
    }
    return up >= VOR_QUADRIC_TERMS && down >= VOR_QUADRIC_TERMS;
}

int vor_implicit_fit(struct vor_implicit *out, const float *near, unsigned n, const float x[3])
{
    struct vor_implicit fit = {.radius = sqrt(vor_distance2f(x, &near[3 * (n - 1)]))};
    struct sums sums = {0};
    struct vor_surface one;
    double least;

    if (n <= TERMS || !(fit.radius > 0))
        return 0;
    vor_surface_fit(&one, near, n);
    if (one.kind == VOR_SURFACE_NONE)
        return 0;
    vor_to_doubles(fit.origin, x);
    for (unsigned i = 0; i < n; i++) {
        double at[3];

        locate(at, &fit, &near[3 * i]);
        add_point(&sums, at);
    }
    least = find_least(fit.c, &sums);
    least *= fit.radius * fit.radius / (n - VOR_IMPLICIT_TERMS);
    if (!(least >= 0 && least * (n - VOR_QUADRIC_TERMS) < NEARER2 * one.off2) ||
        !faces_both(&fit, near, n, one.axis[2]))
        return 0;
    *out = fit;
    return 1;
}

void vor_implicit_normal(const struct vor_implicit *implicit, const float x[3], double normal[3])
{
    double at[3], term[TERMS], gradient[3][TERMS], length;

    locate(at, implicit, x);
    set_terms(term, gradient, at);
    for (int c = 0; c < 3; c++) {
        normal[c] = 0;
        for (int k = 0; k < TERMS; k++)
            normal[c] += implicit->c[k] * gradient[c][k];
    }
    length = sqrt(vor_dot(normal, normal));
    for (int c = 0; c < 3 && length > 0; c++)
        normal[c] /= length;
}
