#include "core/geom/through.h"

#include "core/base/linalg.h"

#include <string.h>

/* Terms of the plane, which are 1, u, v; and equations. */
enum { TERMS = 3, ORDER = VOR_THROUGH_MOST + TERMS };

/* Lengths are over the scale. */
struct through {
    unsigned n;
    double scale;                   /* largest |u| or |v| of a point */
    double at[VOR_THROUGH_MOST][2]; /* places of the points */
    double weight[ORDER];           /* of the points, then of the plane */
};

static double kernel(const double a[2], double u, double v)
{
    double x = a[0] - u, y = a[1] - v, r2 = x * x + y * y;

    return r2 * sqrt(r2);
}

/* The equations of the height: through->weight gets the right side. */
static void set_up(double a[ORDER * ORDER], struct through *through, const double (*local)[3])
{
    size_t n = through->n, order = n + TERMS;

    memset(a, 0, order * order * sizeof *a);
    memset(through->weight, 0, sizeof through->weight);
    for (size_t i = 0; i < n; i++) {
        const double *at = through->at[i];
        double *row = &a[i * order];

        for (size_t j = 0; j < n; j++)
            row[j] = kernel(through->at[j], at[0], at[1]);
        row[n] = a[n * order + i] = 1;
        row[n + 1] = a[(n + 1) * order + i] = at[0];
        row[n + 2] = a[(n + 2) * order + i] = at[1];
        through->weight[i] = local[i][2] / through->scale;
    }
}

static int fit(struct through *through, const double (*local)[3])
{
    unsigned n = through->n;
    double a[ORDER * ORDER];

    for (unsigned i = 0; i < n; i++)
        through->scale = fmax(through->scale, fmax(fabs(local[i][0]), fabs(local[i][1])));
    if (n < 4 || !(through->scale > 0))
        return 0;
    for (unsigned i = 0; i < n; i++)
        for (int c = 0; c < 2; c++)
            through->at[i][c] = local[i][c] / through->scale;
    set_up(a, through, local);
    return vor_solve_pivots(a, through->weight, n + TERMS, 1, VOR_ROUNDED2, 0);
}

static double height_at(const struct through *through, double u, double v)
{
    unsigned n = through->n;
    double x = u / through->scale, y = v / through->scale;
    double sum = through->weight[n] + through->weight[n + 1] * x + through->weight[n + 2] * y;

    for (unsigned i = 0; i < n; i++)
        sum += through->weight[i] * kernel(through->at[i], x, y);
    return sum * through->scale;
}

int vor_through_fit(struct vor_surface *frame, double at[3], double *height, const float *near,
                    unsigned n, const double x[3])
{
    struct through through = {.n = n};
    double local[VOR_THROUGH_MOST][3];

    vor_surface_fit(frame, near, n);
    if (frame->kind == VOR_SURFACE_NONE)
        return 0;
    for (unsigned i = 0; i < n; i++) {
        double p[3];

        vor_to_doubles(p, &near[3 * i]);
        vor_surface_to_local(frame, p, local[i]);
    }
    vor_surface_to_local(frame, x, at);
    if (!fit(&through, (const double(*)[3])local))
        return 0;
    *height = height_at(&through, at[0], at[1]);
    return 1;
}
