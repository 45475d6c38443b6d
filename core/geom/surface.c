#include "core/geom/surface.h"

#include "core/base/linalg.h"

#include <string.h>

#define LINE_RANK 1e-6    /* second over largest eigenvalue: below it, the points are on a line */
#define QUADRIC_RANK 1e-3 /* smallest relative pivot: below it, a plane is all they determine */

/* Neighbours relative to the first one, and their mean. */
struct neighborhood {
    unsigned k;
    double mean[3];
    double x[VOR_NEIGHBORS_MAX][3];
};

static void gather(struct neighborhood *out, const float *near, unsigned k)
{
    memset(out->mean, 0, sizeof out->mean);
    out->k = k;
    for (unsigned i = 0; i < k; i++)
        for (unsigned c = 0; c < 3; c++) {
            out->x[i][c] = (double)near[3 * i + c] - (double)near[c];
            out->mean[c] += out->x[i][c];
        }
    for (unsigned c = 0; c < 3; c++)
        out->mean[c] /= k;
}

/* Axes from the principal directions; false when there is no plane. */
static int find_axes(struct vor_surface *out, const struct neighborhood *hood)
{
    double m[6] = {0}, values[3], vectors[3][3];

    for (unsigned i = 0; i < hood->k; i++) {
        double x = hood->x[i][0] - hood->mean[0], y = hood->x[i][1] - hood->mean[1],
               z = hood->x[i][2] - hood->mean[2];

        m[0] += x * x;
        m[1] += x * y;
        m[2] += x * z;
        m[3] += y * y;
        m[4] += y * z;
        m[5] += z * z;
    }
    vor_eigen3(values, vectors, m);
    if (!(values[1] > LINE_RANK * values[2]))
        return 0;
    memcpy(out->axis[0], vectors[1], sizeof vectors[1]);
    memcpy(out->axis[1], vectors[2], sizeof vectors[2]);
    memcpy(out->axis[2], vectors[0], sizeof vectors[0]);
    /* k points of a uniform disc of radius R have variance R^2 / 4 along each axis; the determinant
     * gives the same area for half a disc within 6 %, so that borders do not look sparse. */
    out->spacing = sqrt(4 * 3.14159265358979 * sqrt(values[1] * values[2]) / hood->k / hood->k);
    return 1;
}

/* Rotates the neighbours into (u, v, w); sets center and reach. */
static void to_frame(struct vor_surface *out, struct neighborhood *hood)
{
    double reach2 = 0;

    out->center[0] = vor_dot(out->axis[0], hood->mean);
    out->center[1] = vor_dot(out->axis[1], hood->mean);
    for (unsigned i = 0; i < hood->k; i++) {
        double u = vor_dot(out->axis[0], hood->x[i]), v = vor_dot(out->axis[1], hood->x[i]),
               w = vor_dot(out->axis[2], hood->x[i]);
        double du = u - out->center[0], dv = v - out->center[1];

        hood->x[i][0] = u;
        hood->x[i][1] = v;
        hood->x[i][2] = w;
        reach2 = fmax(reach2, du * du + dv * dv);
    }
    out->reach = sqrt(reach2);
}

/* Sums of u^a v^b (a + b <= 4) and of w u^a v^b (a + b <= 2), lengths over the reach. */
struct moments {
    double s[5][5];
    double w[6];
};

static void sum_moments(struct moments *out, const struct neighborhood *hood, double scale)
{
    memset(out, 0, sizeof *out);
    for (unsigned i = 0; i < hood->k; i++) {
        double u = hood->x[i][0] * scale, v = hood->x[i][1] * scale, w = hood->x[i][2] * scale;
        double uu = u * u, uv = u * v, vv = v * v;

        out->s[1][0] += u;
        out->s[0][1] += v;
        out->s[2][0] += uu;
        out->s[1][1] += uv;
        out->s[0][2] += vv;
        out->s[3][0] += uu * u;
        out->s[2][1] += uu * v;
        out->s[1][2] += vv * u;
        out->s[0][3] += vv * v;
        out->s[4][0] += uu * uu;
        out->s[3][1] += uu * uv;
        out->s[2][2] += uu * vv;
        out->s[1][3] += uv * vv;
        out->s[0][4] += vv * vv;
        out->w[0] += w;
        out->w[1] += w * u;
        out->w[2] += w * v;
        out->w[3] += w * uu;
        out->w[4] += w * uv;
        out->w[5] += w * vv;
    }
    out->s[0][0] = hood->k;
}

/* Least squares over the first `terms` of 1, u, v, uu, uv, vv; false when they are not determined.
 */
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

void vor_surface_fit(struct vor_surface *out, const float *near, unsigned k)
{
    struct neighborhood hood;
    struct moments moments;
    double scale;

    memset(out, 0, sizeof *out);
    for (int c = 0; c < 3; c++)
        out->origin[c] = (double)near[c];
    if (k < 3)
        return;
    gather(&hood, near, k);
    if (!find_axes(out, &hood))
        return;
    to_frame(out, &hood);
    scale = 1 / out->reach;
    sum_moments(&moments, &hood, scale);
    if (k >= 6 && solve(out->c, &moments, 6, QUADRIC_RANK))
        out->kind = VOR_SURFACE_QUADRIC;
    else if (solve(out->c, &moments, 3, LINE_RANK))
        out->kind = VOR_SURFACE_PLANE;
    out->c[0] *= out->reach;
    for (int i = 3; i < 6; i++)
        out->c[i] *= scale;
}

static double quadric(const double c[6], double u, double v, double gradient[2])
{
    gradient[0] = c[1] + 2 * c[3] * u + c[4] * v;
    gradient[1] = c[2] + c[4] * u + 2 * c[5] * v;
    return c[0] + u * (c[1] + c[3] * u + c[4] * v) + v * (c[2] + c[5] * v);
}

double vor_surface_height(const struct vor_surface *surface, double u, double v, double gradient[2])
{
    double du = u - surface->center[0], dv = v - surface->center[1], own[2], height;
    double d2 = du * du + dv * dv, reach2 = surface->reach * surface->reach;

    if (gradient == NULL)
        gradient = own;
    if (d2 <= reach2)
        return quadric(surface->c, u, v, gradient);
    du *= 1 - surface->reach / sqrt(d2); /* how far beyond the reach */
    dv *= 1 - surface->reach / sqrt(d2);
    height = quadric(surface->c, u - du, v - dv, gradient);
    return height + gradient[0] * du + gradient[1] * dv;
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

    height = vor_surface_height(surface, u, v, gradient);
    for (int i = 0; i < 3; i++) {
        /* The foot is where (local - foot) is along the normal (-gu, -gv, 1). */
        double residual =
            local[2] - height + gradient[0] * (u - local[0]) + gradient[1] * (v - local[1]);
        double t = residual / (1 + gradient[0] * gradient[0] + gradient[1] * gradient[1]);

        u = local[0] + t * gradient[0];
        v = local[1] + t * gradient[1];
        height = vor_surface_height(surface, u, v, gradient);
    }
    local[0] = u;
    local[1] = v;
    local[2] = height;
}

void vor_surface_normal(const struct vor_surface *surface, const double local[3], double normal[3])
{
    double g[2], length;

    (void)vor_surface_height(surface, local[0], local[1], g);
    length = sqrt(1 + g[0] * g[0] + g[1] * g[1]);
    for (int c = 0; c < 3; c++)
        normal[c] =
            (surface->axis[2][c] - g[0] * surface->axis[0][c] - g[1] * surface->axis[1][c]) /
            length;
}
