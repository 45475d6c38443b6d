#include "core/geom/spline.h"

#include "core/base/linalg.h"

#include <string.h>

enum { VALUES = 3 };

static void terms(double out[VOR_SPLINE_TERMS], const double u[2])
{
    out[0] = 1;
    out[1] = u[0];
    out[2] = u[1];
    out[3] = u[0] * u[0];
    out[4] = u[0] * u[1];
    out[5] = u[1] * u[1];
}

static double kernel(const double a[2], const double b[2])
{
    double x = a[0] - b[0], y = a[1] - b[1], r2 = x * x + y * y;

    return r2 * sqrt(r2);
}

/* A system of `order` linear equations with three right sides. */
struct system {
    size_t order;
    double *row;  /* order x order */
    double *side; /* order x VALUES */
};

/* The spline takes the values at its points, and its weights are orthogonal to every quadric. */
static void set_up(struct system *system, const struct vor_spline *spline, const double *value,
                   double smooth)
{
    size_t n = spline->n, order = system->order;

    for (size_t i = 0; i < n; i++) {
        double *row = &system->row[i * order], term[VOR_SPLINE_TERMS];

        for (size_t j = 0; j < n; j++)
            row[j] = kernel(&spline->at[2 * i], &spline->at[2 * j]);
        row[i] += smooth;
        terms(term, &spline->at[2 * i]);
        for (size_t t = 0; t < VOR_SPLINE_TERMS; t++) {
            row[n + t] = term[t];
            system->row[(n + t) * order + i] = term[t];
        }
    }
    for (size_t t = n; t < order; t++)
        memset(&system->row[t * order + n], 0, VOR_SPLINE_TERMS * sizeof *system->row);
    memcpy(system->side, value, n * VALUES * sizeof *value);
    memset(&system->side[n * VALUES], 0, VALUES * VOR_SPLINE_TERMS * sizeof *value);
}

vor_status vor_spline_fit(struct vor_spline *out, const double *at, const double *value, size_t n,
                          double smooth, struct vor_memory *memory, struct vor_error *err)
{
    struct vor_spline spline = {.memory = memory, .n = n};
    struct system system = {.order = n + VOR_SPLINE_TERMS};
    vor_status status = VOR_OK;

    if (n < VOR_SPLINE_TERMS)
        return vor_fail(err, VOR_E_DEGENERATE,
                        "%zu points are too few for a surface, want at least %d", n,
                        VOR_SPLINE_TERMS);
    spline.at = vor_malloc(memory, n, 2 * sizeof *spline.at);
    spline.weight = vor_malloc(memory, system.order, VALUES * sizeof *spline.weight);
    system.row = vor_malloc(memory, system.order, system.order * sizeof *system.row);
    system.side = spline.weight;
    if (spline.at == NULL || spline.weight == NULL || system.row == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    } else {
        memcpy(spline.at, at, 2 * n * sizeof *spline.at);
        set_up(&system, &spline, value, smooth);
        if (!vor_solve_pivots(system.row, system.side, system.order, VALUES, 0, VOR_ROUNDED2))
            status = vor_fail(err, VOR_E_DEGENERATE, "no surface can be fitted to %zu points", n);
    }
    vor_free(memory, system.row);
    if (status == VOR_OK)
        *out = spline;
    else
        vor_spline_free(&spline);
    return status;
}

void vor_spline_at(const struct vor_spline *spline, const double u[2], double out[3])
{
    double term[VOR_SPLINE_TERMS];

    terms(term, u);
    memset(out, 0, VALUES * sizeof *out);
    for (size_t t = 0; t < VOR_SPLINE_TERMS; t++)
        for (size_t c = 0; c < VALUES; c++)
            out[c] += term[t] * spline->weight[(spline->n + t) * VALUES + c];
    for (size_t i = 0; i < spline->n; i++) {
        double r3 = kernel(u, &spline->at[2 * i]);

        for (size_t c = 0; c < VALUES; c++)
            out[c] += r3 * spline->weight[i * VALUES + c];
    }
}

void vor_spline_free(struct vor_spline *spline)
{
    VOR_FREE_ALL(spline->memory, spline->at, spline->weight);
    memset(spline, 0, sizeof *spline);
}
