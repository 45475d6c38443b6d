#include "core/geom/curvature.h"

#include "core/base/linalg.h"

#include <string.h>

/* Highest power of u or v in the sums, and coefficients of degree four. */
enum { DEGREE = 4, POWERS = 2 * DEGREE, TERMS = 15 };

/* Times less variance about it that a polynomial of degree four must have. Where it is always
 * taken, facets and noise pass for curvature: armadillo, sampled from its mesh, to 20,000, 64
 * points a fit, span of the density followed 6.0, with quadrics 7.3. */
#define FINER 4.0

/* First and second derivatives of w(u, v) at the origin. */
struct derivatives {
    double u, v, uu, uv, vv;
};

/* Sums of u^a v^b and of w u^a v^b over the points; lengths are over the reach. */
struct sums {
    double s[POWERS + 1][POWERS + 1];
    double w[DEGREE + 1][DEGREE + 1], ww;
};

static void add_point(struct sums *sums, double u, double v, double w)
{
    double ua = 1;

    sums->ww += w * w;
    for (unsigned a = 0; a <= POWERS; a++) {
        double uv = ua;

        for (unsigned b = 0; a + b <= POWERS; b++) {
            sums->s[a][b] += uv;
            if (a + b <= DEGREE)
                sums->w[a][b] += w * uv;
            uv *= v;
        }
        ua *= u;
    }
}

/* Least squares of degree four. Returns false when the points do not determine it, or it fits them
 * little better than the quadric: then that is the more certain, as on noise and facets. */
static int fit_quartic(struct derivatives *out, const struct vor_surface *surface,
                       const float *near, unsigned k)
{
    unsigned power[TERMS][2], terms = 0;
    double a[TERMS * TERMS], c[TERMS] = {0}, left, quadric;
    struct sums sums;

    memset(&sums, 0, sizeof sums);
    for (unsigned i = 0; i < k; i++) {
        double x[3] = {(double)near[3 * i], (double)near[3 * i + 1], (double)near[3 * i + 2]};
        double local[3];

        vor_surface_to_local(surface, x, local);
        add_point(&sums, local[0] / surface->reach, local[1] / surface->reach,
                  local[2] / surface->reach);
    }
    for (unsigned degree = 0; degree <= DEGREE; degree++)
        for (unsigned b = 0; b <= degree; b++, terms++) {
            power[terms][0] = degree - b;
            power[terms][1] = b;
            c[terms] = sums.w[degree - b][b];
        }
    for (unsigned i = 0; i < TERMS; i++)
        for (unsigned j = 0; j <= i; j++)
            a[i * TERMS + j] = sums.s[power[i][0] + power[j][0]][power[i][1] + power[j][1]];
    if (!(vor_solve_spd(a, c, TERMS, VOR_ROUNDED) > 0))
        return 0;
    left = sums.ww;
    for (unsigned i = 0; i < TERMS; i++)
        left -= c[i] * sums.w[power[i][0]][power[i][1]];
    quadric = surface->off2 / (surface->reach * surface->reach) * k;
    if (!(FINER * left / (k - TERMS) <= quadric / (k - VOR_QUADRIC_TERMS)))
        return 0;
    *out = (struct derivatives){c[1], c[2], 2 * c[3] / surface->reach, c[4] / surface->reach,
                                2 * c[5] / surface->reach};
    return 1;
}

/* Derivatives of the surface at the first of the points, from a polynomial of degree four where
 * that is certain. Returns false when only a plane, or none, was found. */
static int differentiate(struct derivatives *out, const struct vor_surface *surface,
                         const float *near, unsigned k)
{
    const double *c = surface->c;

    if (surface->kind != VOR_SURFACE_QUADRIC)
        return 0;
    *out = (struct derivatives){c[1], c[2], 2 * c[3], c[4], 2 * c[5]};
    if (k >= 2 * TERMS)
        (void)fit_quartic(out, surface, near, k);
    return 1;
}

void vor_curvature_at(double kappa[2], const struct vor_surface *surface, const float *near,
                      unsigned k)
{
    struct derivatives d;
    double w2, mean, gauss, apart;

    kappa[0] = kappa[1] = 0;
    if (!differentiate(&d, surface, near, k))
        return;
    /* Mean and Gaussian curvature of the graph of w. */
    w2 = 1 + d.u * d.u + d.v * d.v;
    gauss = (d.uu * d.vv - d.uv * d.uv) / (w2 * w2);
    mean = ((1 + d.u * d.u) * d.vv - 2 * d.u * d.v * d.uv + (1 + d.v * d.v) * d.uu) /
           (2 * w2 * sqrt(w2));
    apart = sqrt(fmax(mean * mean - gauss, 0));
    kappa[0] = mean - apart;
    kappa[1] = mean + apart;
}

/* Tangents in the surface's axes that are dual to those of the graph, (1, 0, w_u) and (0, 1, w_v):
 * the inverse of the first fundamental form, times them. */
static void dual_tangents(double dual[2][3], const struct derivatives *d)
{
    double w2 = 1 + d->u * d->u + d->v * d->v;
    double uu = (1 + d->v * d->v) / w2, uv = -d->u * d->v / w2, vv = (1 + d->u * d->u) / w2;

    dual[0][0] = uu;
    dual[0][1] = uv;
    dual[0][2] = uu * d->u + uv * d->v;
    dual[1][0] = uv;
    dual[1][1] = vv;
    dual[1][2] = uv * d->u + vv * d->v;
}

int vor_curvature_tensor(double bend[6], double normal[3], const struct vor_surface *surface,
                         const float *near, unsigned k)
{
    struct derivatives d;
    double dual[2][3], world[2][3], length;
    unsigned at = 0;

    if (!differentiate(&d, surface, near, k))
        return 0;
    dual_tangents(dual, &d);
    length = sqrt(1 + d.u * d.u + d.v * d.v);
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t < 2; t++)
            world[t][c] = dual[t][0] * surface->axis[0][c] + dual[t][1] * surface->axis[1][c] +
                          dual[t][2] * surface->axis[2][c];
        normal[c] =
            (surface->axis[2][c] - d.u * surface->axis[0][c] - d.v * surface->axis[1][c]) / length;
    }
    for (int a = 0; a < 3; a++)
        for (int b = a; b < 3; b++)
            bend[at++] = (d.uu * world[0][a] * world[0][b] +
                          d.uv * (world[0][a] * world[1][b] + world[1][a] * world[0][b]) +
                          d.vv * world[1][a] * world[1][b]) /
                         length;
    return 1;
}
