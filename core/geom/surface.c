#include "core/geom/surface.h"

#include "core/base/linalg.h"
#include "core/geom/fours.h"

#include <assert.h>
#include <float.h>
#include <string.h>

/* Figures are rms distances to the true surface over its diagonal, inputs and spread as in
 * boundary.h: igea 1 %, fandisk 3 %, bunny 10 %. */

/* Deviation over reach: a thicker neighbourhood shows no edge. At 0.1 / 0.2 / 0.4: fandisk 6.2e-4
 * / 5.7e-4 / 5.8e-4, igea 5.2e-4 / 5.0e-4 / 5.0e-4. */
#define THICK 0.2

/* Four numbers of one neighbour at once. Each sum is of the same terms in the same order as one by
 * one. */
enum { LANES = 4 };
typedef double lanes __attribute__((vector_size(8 * LANES)));

/* The neighbours relative to the first one, their weighted mean and the sum of their weights; the
 * last lane is 0. */
struct neighborhood {
    unsigned k;
    double total; /* of the weights */
    lanes mean;
    lanes x[VOR_NEIGHBORS_MAX];
};

/* Multiplies by the weight of neighbour i. Inlined, so that it costs nothing where weight is NULL.
 */
VOR_INLINE void weigh(lanes *x, const float *weight, unsigned i)
{
    if (weight != NULL)
        *x *= (double)weight[i];
}

VOR_INLINE void gather(struct neighborhood *out, const float *near, const float *weight, unsigned k)
{
    const lanes first = {(double)near[0], (double)near[1], (double)near[2], 0};

    out->mean = (lanes){0};
    out->k = k;
    out->total = 0;
    for (unsigned i = 0; i < k; i++) {
        const float *at = &near[3 * i];
        lanes x = (lanes){(double)at[0], (double)at[1], (double)at[2], 0} - first;

        out->x[i] = x;
        weigh(&x, weight, i);
        out->mean += x;
        out->total += weight != NULL ? (double)weight[i] : 1;
    }
    out->mean /= out->total;
}

/* Sets the axes from the principal directions, and the spacing. Returns false when the points lie
 * on a line. */
VOR_INLINE int find_axes(struct vor_surface *out, const struct neighborhood *hood,
                         const float *weight)
{
    lanes first = {0}, last = {0}; /* sums of xx, xy, xz, yy; of yz, zz */
    double m[6], values[3], vectors[3][3];

    for (unsigned i = 0; i < hood->k; i++) {
        lanes x = hood->x[i] - hood->mean, weighed = x;

        weigh(&weighed, weight, i);
        first += __builtin_shufflevector(weighed, weighed, 0, 0, 0, 1) *
                 __builtin_shufflevector(x, x, 0, 1, 2, 1);
        last += __builtin_shufflevector(weighed, weighed, 1, 2, 3, 3) *
                __builtin_shufflevector(x, x, 2, 2, 3, 3);
    }
    for (int i = 0; i < LANES; i++)
        m[i] = first[i];
    m[4] = last[0];
    m[5] = last[1];
    vor_eigen3_flat(values, vectors, m);
    if (!(values[1] > VOR_ROUNDED * values[2]))
        return 0;
    memcpy(out->axis[0], vectors[1], sizeof vectors[1]);
    memcpy(out->axis[1], vectors[2], sizeof vectors[2]);
    memcpy(out->axis[2], vectors[0], sizeof vectors[0]);
    /* k points of a uniform disc of radius R have variance R^2 / 4 along each axis; the determinant
     * gives the same area for half a disc within 6 %, so that borders do not look sparse. */
    out->spacing = sqrt(4 * 3.14159265358979 * sqrt(values[1] * values[2]) / hood->k / hood->k);
    return 1;
}

/* Weighted sums: s[a][b] of u^a v^b with a + b <= 4, w[] of w u^a v^b with a + b <= 2, ww of w^2.
 * Lengths are over the reach. */
struct moments {
    double s[5][5];
    double w[6], ww;
};

VOR_INLINE void sum_moments(struct moments *out, const struct neighborhood *hood,
                            const float *weight, double scale)
{
    /* Sums of u v uu uv; the same by uu, by vv, by w; of uu uv vv w by vv; of vv, w, ww. */
    lanes one = {0}, by_uu = {0}, by_vv = {0}, by_w = {0}, high = {0}, rest = {0};

    for (unsigned i = 0; i < hood->k; i++) {
        lanes u = hood->x[i] * scale, wu = u; /* u, v, w */
        lanes uu = __builtin_shufflevector(u, u, 0, 0, 1, 3) *
                   __builtin_shufflevector(u, u, 0, 1, 1, 3); /* uu, uv, vv */
        lanes wuu = uu, all = __builtin_shufflevector(u, uu, 0, 1, 4, 5);

        weigh(&wu, weight, i);
        weigh(&wuu, weight, i);
        one += __builtin_shufflevector(wu, wuu, 0, 1, 4, 5);
        by_uu += wuu[0] * all;
        by_vv += wuu[2] * all;
        by_w += wu[2] * all;
        high += __builtin_shufflevector(wuu, wu, 0, 1, 2, 6) * uu[2];
        rest += __builtin_shufflevector(wuu, wu, 2, 6, 6, 3) * (lanes){1, 1, u[2], 0};
    }
    memset(out, 0, sizeof *out);
    out->s[0][0] = hood->total;
    out->s[1][0] = one[0];
    out->s[0][1] = one[1];
    out->s[2][0] = one[2];
    out->s[1][1] = one[3];
    out->s[0][2] = rest[0];
    out->s[3][0] = by_uu[0];
    out->s[2][1] = by_uu[1];
    out->s[1][2] = by_vv[0];
    out->s[0][3] = by_vv[1];
    out->s[4][0] = by_uu[2];
    out->s[3][1] = by_uu[3];
    out->s[2][2] = high[0];
    out->s[1][3] = high[1];
    out->s[0][4] = high[2];
    out->w[0] = rest[1];
    out->w[1] = by_w[0];
    out->w[2] = by_w[1];
    out->w[3] = by_w[2];
    out->w[4] = by_w[3];
    out->w[5] = high[3];
    out->ww = rest[2];
}

/* Least squares over the first `terms` of 1, u, v, uu, uv, vv. Returns false when the points do not
 * determine them. */
static int solve(double c[6], const struct moments *moments, int terms, double rank)
{
    static const int up[6] = {0, 1, 0, 2, 1, 0}, vp[6] = {0, 0, 1, 0, 1, 2};
    double a[36];

    for (int i = 0; i < terms; i++)
        for (int j = 0; j <= i; j++)
            a[i * terms + j] = moments->s[up[i] + up[j]][vp[i] + vp[j]];
    memset(c, 0, 6 * sizeof *c);
    memcpy(c, moments->w, (size_t)terms * sizeof *c);
    return vor_solve_spd(a, c, terms, rank) > 0;
}

/* The residual of least squares: what is left of the sum of w^2. */
static double left(const struct moments *moments, const double c[6])
{
    double sum = moments->ww;

    for (int i = 0; i < 6; i++)
        sum -= c[i] * moments->w[i];
    return sum > 0 ? sum : 0;
}

/* Inlined, so that neither the weights nor the highest kind cost anything where they are usual. */
VOR_INLINE void fit(struct vor_surface *out, const float *near, const float *weight, unsigned k,
                    enum vor_surface_kind highest)
{
    struct neighborhood hood;
    struct moments moments;
    lanes axis[3], center;
    double scale, reach2 = 0;

    memset(out, 0, sizeof *out);
    vor_to_doubles(out->origin, near);
    if (k < 3)
        return;
    gather(&hood, near, weight, k);
    if (!find_axes(out, &hood, weight))
        return;
    /* Rotates the neighbours into (u, v, w); sets center and reach. */
    for (int c = 0; c < 3; c++)
        axis[c] = (lanes){out->axis[0][c], out->axis[1][c], out->axis[2][c], 0};
    center = axis[0] * hood.mean[0] + axis[1] * hood.mean[1] + axis[2] * hood.mean[2];
    for (unsigned i = 0; i < hood.k; i++) {
        lanes x = hood.x[i], d;
        double d2;

        hood.x[i] = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
        d = hood.x[i] - center;
        d *= d;
        d2 = d[0] + d[1];
        reach2 = d2 > reach2 ? d2 : reach2; /* fmax is a call */
    }
    out->center[0] = center[0];
    out->center[1] = center[1];
    out->reach = sqrt(reach2);
    scale = 1 / out->reach;
    sum_moments(&moments, &hood, weight, scale);
    if (highest == VOR_SURFACE_QUADRIC && k >= 6 && solve(out->c, &moments, 6, VOR_NEGLIGIBLE))
        out->kind = VOR_SURFACE_QUADRIC;
    else if (solve(out->c, &moments, 3, VOR_ROUNDED))
        out->kind = VOR_SURFACE_PLANE;
    out->off2 = out->reach * out->reach * left(&moments, out->c) / hood.total;
    out->c[0] *= out->reach;
    for (int i = 3; i < 6; i++)
        out->c[i] *= scale;
}

VOR_CLONES void vor_surface_fit(struct vor_surface *out, const float *near, unsigned k)
{
    fit(out, near, NULL, k, VOR_SURFACE_QUADRIC);
}

enum vor_surface_kind vor_surface_fit_to(struct vor_surface *out, const float *xyz,
                                         const uint32_t *index, unsigned k)
{
    float near[3 * VOR_NEIGHBORS_MAX];

    vor_gather(near, xyz, index, k);
    vor_surface_fit(out, near, k);
    return out->kind;
}

void vor_surface_fit_as(struct vor_surface *out, const float *near, unsigned k,
                        enum vor_surface_kind highest)
{
    assert(highest != VOR_SURFACE_NONE);
    if (highest == VOR_SURFACE_PLANE)
        fit(out, near, NULL, k, VOR_SURFACE_PLANE);
    else
        vor_surface_fit(out, near, k);
}

VOR_CLONES void vor_surface_fit_weighted(struct vor_surface *out, const float *near,
                                         const float *weight, unsigned k)
{
    fit(out, near, weight, k, VOR_SURFACE_QUADRIC);
    out->spacing = 0;
}

VOR_INLINE double quadric(const double c[6], double u, double v, double gradient[2])
{
    gradient[0] = c[1] + 2 * c[3] * u + c[4] * v;
    gradient[1] = c[2] + c[4] * u + 2 * c[5] * v;
    return c[0] + u * (c[1] + c[3] * u + c[4] * v) + v * (c[2] + c[5] * v);
}

/* As vor_surface_height. */
VOR_INLINE double height_at(const struct vor_surface *surface, double u, double v,
                            double gradient[2])
{
    double du = u - surface->center[0], dv = v - surface->center[1], height;
    double d2 = du * du + dv * dv, reach2 = surface->reach * surface->reach;

    if (d2 <= reach2)
        return quadric(surface->c, u, v, gradient);
    du *= 1 - surface->reach / sqrt(d2); /* how far beyond the reach */
    dv *= 1 - surface->reach / sqrt(d2);
    height = quadric(surface->c, u - du, v - dv, gradient);
    return height + gradient[0] * du + gradient[1] * dv;
}

double vor_surface_height(const struct vor_surface *surface, double u, double v, double gradient[2])
{
    double own[2];

    return height_at(surface, u, v, gradient != NULL ? gradient : own);
}

/* vor_surface_above of points i to i + 3 of k; also sets the gradients there. */
VOR_INLINE void above(vor_fours *off, vor_fours gradient[2], const struct vor_surface *s,
                      const float *near, unsigned k, unsigned i)
{
    vor_fours way[3], u, v, du, dv, d2, share = {0};
    vor_fours_marks beyond;

    vor_fours_ways(way, near, k, i, s->origin);
    vor_fours_along(&u, s->axis[0], way);
    vor_fours_along(&v, s->axis[1], way);
    vor_fours_along(off, s->axis[2], way);
    du = u - s->center[0];
    dv = v - s->center[1];
    d2 = du * du + dv * dv;
    beyond = d2 > s->reach * s->reach;
    if (vor_fours_any(&beyond)) {
        for (int j = 0; j < VOR_FOURS_LANES; j++)
            d2[j] = sqrt(d2[j]);
        share = VOR_FOURS_CHOOSE(beyond, 1 - s->reach / d2, share);
    }
    du *= share; /* how far beyond the reach */
    dv *= share;
    u -= du;
    v -= dv;
    gradient[0] = s->c[1] + 2 * s->c[3] * u + s->c[4] * v;
    gradient[1] = s->c[2] + s->c[4] * u + 2 * s->c[5] * v;
    *off -= s->c[0] + u * (s->c[1] + s->c[3] * u + s->c[4] * v) + v * (s->c[2] + s->c[5] * v) +
            gradient[0] * du + gradient[1] * dv;
}

VOR_CLONES void vor_surface_feet(const struct vor_surface *surface, const float *near, unsigned k,
                                 double *restrict way)
{
    const struct vor_surface s = *surface;

    for (unsigned i = 0; i < k; i += VOR_FOURS_LANES) {
        vor_fours off, gradient[2], step, by[4];

        above(&off, gradient, &s, near, k, i);
        step = off / (1 + gradient[0] * gradient[0] + gradient[1] * gradient[1]);
        for (int c = 0; c < 3; c++)
            by[c] = step * (gradient[0] * s.axis[0][c] + gradient[1] * s.axis[1][c] - s.axis[2][c]);
        by[3] = off * step;
        for (unsigned c = 0; c < 4; c++)
            for (unsigned j = 0; j < VOR_FOURS_LANES && i + j < k; j++)
                way[(size_t)c * k + i + j] = by[c][j];
    }
}

void vor_surface_to_local(const struct vor_surface *surface, const double x[3], double local[3])
{
    double d[3] = {x[0] - surface->origin[0], x[1] - surface->origin[1], x[2] - surface->origin[2]};

    for (int i = 0; i < 3; i++)
        local[i] = vor_dot(surface->axis[i], d);
}

void vor_surface_to_world(const struct vor_surface *surface, const double local[3], double x[3])
{
    for (int c = 0; c < 3; c++)
        x[c] = surface->origin[c] + local[0] * surface->axis[0][c] +
               local[1] * surface->axis[1][c] + local[2] * surface->axis[2][c];
}

void vor_surface_project(const struct vor_surface *surface, double local[3])
{
    double u = local[0], v = local[1], gradient[2], height;

    height = height_at(surface, u, v, gradient);
    for (int i = 0; i < VOR_SURFACE_PROJECTIONS; i++) {
        /* At the foot, local - foot is parallel to the normal (-gu, -gv, 1). */
        double residual =
            local[2] - height + gradient[0] * (u - local[0]) + gradient[1] * (v - local[1]);
        double t = residual / (1 + gradient[0] * gradient[0] + gradient[1] * gradient[1]);

        if (fabs(residual) <= FLT_EPSILON * surface->reach) /* float32 rounds off more */
            break;
        u = local[0] + t * gradient[0];
        v = local[1] + t * gradient[1];
        height = height_at(surface, u, v, gradient);
    }
    local[0] = u;
    local[1] = v;
    local[2] = height;
}

void vor_surface_put(const struct vor_surface *surface, double x[3])
{
    double local[3];

    vor_surface_to_local(surface, x, local);
    vor_surface_project(surface, local);
    vor_surface_to_world(surface, local, x);
}

void vor_surface_normal(const struct vor_surface *surface, const double local[3], double normal[3])
{
    double g[2], length;

    (void)height_at(surface, local[0], local[1], g);
    length = sqrt(1 + g[0] * g[0] + g[1] * g[1]);
    for (int c = 0; c < 3; c++)
        normal[c] =
            (surface->axis[2][c] - g[0] * surface->axis[0][c] - g[1] * surface->axis[1][c]) /
            length;
}

double vor_surface_above(const struct vor_surface *surface, const double x[3])
{
    double local[3];

    vor_surface_to_local(surface, x, local);
    return local[2] - vor_surface_height(surface, local[0], local[1], NULL);
}

double vor_surface_abovef(const struct vor_surface *surface, const float x[3])
{
    return vor_surface_above(surface, (double[3]){(double)x[0], (double)x[1], (double)x[2]});
}

VOR_CLONES double vor_surface_variance(const struct vor_surface *surface, const float *near,
                                       unsigned k)
{
    const struct vor_surface s = *surface;
    double sum = 0;

    for (unsigned i = 0; s.kind != VOR_SURFACE_NONE && i < k; i += VOR_FOURS_LANES) {
        vor_fours off, gradient[2];

        above(&off, gradient, &s, near, k, i);
        off *= off;
        for (unsigned j = 0; j < VOR_FOURS_LANES && i + j < k; j++)
            sum += off[j];
    }
    return sum / (k - VOR_QUADRIC_TERMS);
}

/* Copies the VOR_REFINED_TO neighbours nearest to x to out, nearest first. */
static void take_nearest(float *out, const float *near, unsigned k, const float x[3])
{
    double distance2[VOR_REFINED_TO] = {0};
    uint32_t index[VOR_REFINED_TO] = {0};

    for (uint32_t j = 0; j < k; j++) {
        double d2 = vor_distance2f(&near[3 * j], x);
        unsigned at = j < VOR_REFINED_TO ? j : VOR_REFINED_TO - 1;

        if (at < j && !(d2 < distance2[at]))
            continue;
        for (; at > 0 && d2 < distance2[at - 1]; at--) {
            distance2[at] = distance2[at - 1];
            index[at] = index[at - 1];
        }
        distance2[at] = d2;
        index[at] = j;
    }
    vor_gather(out, near, index, VOR_REFINED_TO);
}

int vor_surface_refine(struct vor_surface *surface, const float *near, unsigned k, const float x[3])
{
    double coarse2 = vor_surface_variance(surface, near, k), thick = THICK * surface->reach;
    double a[3] = {(double)x[0], (double)x[1], (double)x[2]}, b[3] = {a[0], a[1], a[2]};
    float few[3 * VOR_REFINED_TO];
    struct vor_surface fine = {0}; /* gcc's analyzer does not follow VOR_CLONES */

    assert(k >= VOR_REFINED_MIN && k <= VOR_REFINED_MAX);
    if (surface->kind != VOR_SURFACE_QUADRIC || coarse2 > thick * thick)
        return 0;
    take_nearest(few, near, k, x);
    vor_surface_fit(&fine, few, VOR_REFINED_TO);
    if (fine.kind != VOR_SURFACE_QUADRIC ||
        VOR_FINER * vor_surface_variance(&fine, few, VOR_REFINED_TO) > coarse2)
        return 0;
    vor_surface_put(surface, a);
    vor_surface_put(&fine, b);
    for (int c = 0; c < 3; c++)
        a[c] -= b[c];
    if (vor_dot(a, a) > VOR_FINER * coarse2)
        return 0;
    *surface = fine;
    return 1;
}
