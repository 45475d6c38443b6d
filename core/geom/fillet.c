#include "core/geom/fillet.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

enum {
    SIDE_TERMS = VOR_FILLET_SIDE_TERMS,
    PARAMETERS = VOR_FILLET_TERMS,
    STEPS = 6, /* of Gauss and Newton, at most */
    /* Radii that are tried. At 10 / 24: figures of lop/fillets.c .224, .280 / .222, .257. */
    RADII = 10
};

/* Largest radius, in reaches: beyond it a fit sees no edge. */
#define WIDEST 3.0

/* Points in the frame of a fillet. */
struct points {
    unsigned k;
    double u[VOR_NEIGHBORS_MAX], v[VOR_NEIGHBORS_MAX], w[VOR_NEIGHBORS_MAX];
};

/* The height over a rounded wedge, by those over its sides, and how it grows with these and with
 * the radius. */
struct rounded {
    double height, by[2], by_radius;
    int round;
};

static void round_off(struct rounded *out, const double side[2], double cosine, double radius)
{
    double a = side[0] + radius, b = side[1] + radius, sine2 = 1 - cosine * cosine;
    double p = (a - b * cosine) / sine2, q = (b - a * cosine) / sine2, length;
    int first = side[0] > side[1];

    if (radius > 0 && p > 0 && q > 0) {
        length = sqrt(p * p + q * q + 2 * p * q * cosine);
        *out = (struct rounded){length - radius, {p / length, q / length}, (p + q) / length - 1, 1};
    } else {
        *out = (struct rounded){side[!first], {first, !first}, 0, 0};
    }
}

/* Heights of a place in the frame over both sides. */
static void over_sides(double out[2], const struct vor_fillet *fillet, double u, double v, double w)
{
    for (int l = 0; l < 2; l++) {
        const double *h = fillet->height[l];

        out[l] = fillet->side[l][0] * u + fillet->side[l][1] * w + h[0] + (h[1] + h[2] * v) * v;
    }
}

/* The sum of squares; fills the lower triangle of a and b unless a is NULL. */
static double sum_up(double *a, double *b, const struct vor_fillet *fillet,
                     const struct points *points)
{
    double sum = 0;

    for (unsigned j = 0; j < points->k; j++) {
        double u = points->u[j], v = points->v[j], w = points->w[j], side[2], d[PARAMETERS];
        struct rounded r;

        over_sides(side, fillet, u, v, w);
        round_off(&r, side, fillet->cosine, fillet->radius);
        sum += r.height * r.height;
        if (a == NULL)
            continue;
        for (int l = 0; l < 2; l++) {
            const double *n = fillet->side[l];
            const double by[SIDE_TERMS] = {1, n[1] * u - n[0] * w, v, v * v};

            for (int x = 0; x < SIDE_TERMS; x++)
                d[SIDE_TERMS * l + x] = r.by[l] * by[x];
        }
        d[2 * SIDE_TERMS] = r.by_radius;
        for (int x = 0; x < PARAMETERS; x++) {
            b[x] -= d[x] * r.height;
            for (int y = 0; y <= x; y++)
                a[PARAMETERS * x + y] += d[x] * d[y];
        }
    }
    return sum;
}

static void add(struct vor_fillet *fillet, const double *step, double widest)
{
    for (int l = 0; l < 2; l++) {
        const double *s = &step[SIDE_TERMS * l];
        double *n = fillet->side[l], *h = fillet->height[l];
        double across = n[0] + s[1] * n[1], up = n[1] - s[1] * n[0];
        double length = sqrt(across * across + up * up);

        n[0] = across / length;
        n[1] = up / length;
        h[0] += s[0];
        h[1] += s[2];
        h[2] += s[3];
    }
    fillet->radius = fmin(fmax(fillet->radius + step[2 * SIDE_TERMS], 0), widest);
    fillet->cosine =
        fillet->side[0][0] * fillet->side[1][0] + fillet->side[0][1] * fillet->side[1][1];
}

/* Improves a fillet; returns the sum of squares. Once its radius is 0 it stays so: nothing depends
 * on it then. */
static double improve(struct vor_fillet *fillet, const struct points *points, double reach)
{
    double now = INFINITY;

    for (int s = 0; s < STEPS; s++) {
        double a[PARAMETERS * PARAMETERS] = {0}, b[PARAMETERS] = {0}, next;
        struct vor_fillet tried = *fillet;

        now = sum_up(a, b, fillet, points);
        for (int x = 0; x < PARAMETERS; x++)
            /* parameters that the points say nothing of stay */
            a[PARAMETERS * x + x] += VOR_NEGLIGIBLE * a[PARAMETERS * x + x] + VOR_ROUNDED2;
        if (vor_solve_spd(a, b, PARAMETERS, VOR_ROUNDED2) == 0)
            break;
        add(&tried, b, WIDEST * reach);
        next = sum_up(NULL, NULL, &tried, points);
        if (!(next < now) || 1 - tried.cosine * tried.cosine < VOR_NEGLIGIBLE)
            break;
        *fillet = tried;
        if (next > now * (1 - VOR_NEGLIGIBLE))
            return next;
        now = next;
    }
    return now;
}

/* The frame of two planes, with its origin where they meet. */
static void begin(struct vor_fillet *out, double place[2][3], double normal[2][3])
{
    double up[3], length, off[2] = {0}, rest;

    vor_cross(out->axis[0], normal[0], normal[1]);
    length = sqrt(vor_dot(out->axis[0], out->axis[0]));
    for (int c = 0; c < 3; c++) {
        out->axis[0][c] /= length;
        up[c] = normal[0][c] + normal[1][c];
        out->origin[c] = (place[0][c] + place[1][c]) / 2;
    }
    length = sqrt(vor_dot(up, up));
    for (int c = 0; c < 3; c++)
        out->axis[2][c] = up[c] / length;
    vor_cross(out->axis[1], out->axis[2], out->axis[0]);
    out->cosine = vor_dot(normal[0], normal[1]);
    rest = 1 - out->cosine * out->cosine;
    for (int l = 0; l < 2; l++) {
        for (int c = 0; c < 3; c++)
            off[l] += normal[l][c] * (place[l][c] - out->origin[c]);
        out->side[l][0] = vor_dot(normal[l], out->axis[1]);
        out->side[l][1] = vor_dot(normal[l], out->axis[2]);
    }
    for (int c = 0; c < 3; c++)
        out->origin[c] += ((off[0] - out->cosine * off[1]) * normal[0][c] +
                           (off[1] - out->cosine * off[0]) * normal[1][c]) /
                          rest;
}

static void to_frame(double local[3], const struct vor_fillet *fillet, const double x[3])
{
    double d[3];

    for (int c = 0; c < 3; c++)
        d[c] = x[c] - fillet->origin[c];
    for (int r = 0; r < 3; r++)
        local[r] = vor_dot(fillet->axis[r], d);
}

/* Takes the best of a row of radii. Returns the sum of squares without any. */
static double look(struct vor_fillet *fillet, const struct points *points, double reach)
{
    struct vor_fillet tried = *fillet;
    double without = sum_up(NULL, NULL, &tried, points), best = without;

    for (int i = 1; i <= RADII; i++) {
        double sum;

        tried.radius = i * WIDEST / RADII * reach;
        sum = sum_up(NULL, NULL, &tried, points);
        if (sum < best) {
            best = sum;
            fillet->radius = tried.radius;
        }
    }
    return without - best;
}

void vor_fillet_fit(struct vor_fillet *out, const float *near, unsigned k, double place[2][3],
                    double normal[2][3], double reach)
{
    struct points points = {.k = k};
    double gain;

    memset(out, 0, sizeof *out);
    begin(out, place, normal);
    for (unsigned j = 0; j < k; j++) {
        const double x[3] = {(double)near[3 * j], (double)near[3 * j + 1], (double)near[3 * j + 2]};
        double local[3];

        to_frame(local, out, x);
        points.v[j] = local[0];
        points.u[j] = local[1];
        points.w[j] = local[2];
    }
    gain = look(out, &points, reach);
    if (!(gain > 0))
        return;
    out->off2 = improve(out, &points, reach) / k;
    out->gain = out->off2 > 0 ? gain / out->off2 : 0;
}

int vor_fillet_at(const struct vor_fillet *fillet, const double x[3], double *height,
                  double normal[3])
{
    double local[3], side[2], across, up;
    struct rounded r;

    to_frame(local, fillet, x);
    over_sides(side, fillet, local[1], local[0], local[2]);
    round_off(&r, side, fillet->cosine, fillet->radius);
    across = r.by[0] * fillet->side[0][0] + r.by[1] * fillet->side[1][0];
    up = r.by[0] * fillet->side[0][1] + r.by[1] * fillet->side[1][1];
    *height = r.height;
    for (int c = 0; c < 3; c++)
        normal[c] = across * fillet->axis[1][c] + up * fillet->axis[2][c];
    return r.round;
}
