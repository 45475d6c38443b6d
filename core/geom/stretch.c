#include "core/geom/stretch.h"

#include "core/base/linalg.h"
#include "core/geom/metric.h"

#include <string.h>

/* The coefficients of w over the stretched plane, whose points the inverse b takes back. */
static void stretch_coefficients(double out[6], const double c[6], const double b[3])
{
    out[0] = c[0];
    out[1] = c[1] * b[0] + c[2] * b[1];
    out[2] = c[1] * b[1] + c[2] * b[2];
    out[3] = c[3] * b[0] * b[0] + c[4] * b[0] * b[1] + c[5] * b[1] * b[1];
    out[4] = 2 * c[3] * b[0] * b[1] + c[4] * (b[0] * b[2] + b[1] * b[1]) + 2 * c[5] * b[1] * b[2];
    out[5] = c[3] * b[1] * b[1] + c[4] * b[1] * b[2] + c[5] * b[2] * b[2];
}

void vor_stretch_init(struct vor_stretch *out, const struct vor_surface *surface,
                      const float metric[6])
{
    double g[6], plane[3], center[3] = {surface->center[0], surface->center[1], 0};

    for (int c = 0; c < 6; c++)
        g[c] = (double)metric[c];
    vor_metric_restrict(plane, g, surface->axis);
    (void)vor_metric_even(plane, INFINITY);
    vor_metric_root(out->root, plane);
    out->least = 1 / sqrt(vor_metric_aspect(plane));
    out->surface = *surface;
    stretch_coefficients(out->surface.c, surface->c,
                         (double[3]){out->root[2], -out->root[1], out->root[0]});
    vor_stretch_local(out, center);
    memcpy(out->surface.center, center, sizeof out->surface.center);
}

static void undo_local(const double root[3], double local[3])
{
    double u = local[0], v = local[1];

    local[0] = root[2] * u - root[1] * v;
    local[1] = root[0] * v - root[1] * u;
}

void vor_stretch_undo(struct vor_cell *cell, const struct vor_stretch *stretch)
{
    cell->radius2 = 0;
    undo_local(stretch->root, cell->seed);
    for (unsigned i = 0; i < cell->count; i++) {
        struct vor_polygon *piece = &cell->piece[i];

        piece->radius2 = 0;
        for (unsigned j = 0; j < piece->count; j++) {
            double *vertex = piece->vertex[j];

            undo_local(stretch->root, vertex);
            vertex[3] = vor_dot(vertex, vertex);
            piece->radius2 = fmax(piece->radius2, vertex[3]);
        }
        cell->radius2 = fmax(cell->radius2, piece->radius2);
    }
}

const double *vor_stretch_farthest(const struct vor_cell *cell, const struct vor_stretch *stretch,
                                   double *far2)
{
    const double *farthest = NULL;

    *far2 = 0;
    for (unsigned i = 0; i < cell->count; i++)
        for (unsigned j = 0; j < cell->piece[i].count; j++) {
            const double *corner = cell->piece[i].vertex[j];
            double local[3] = {corner[0], corner[1], corner[2]}, d2;

            if (stretch != NULL)
                vor_stretch_local(stretch, local);
            d2 = vor_dot(local, local);
            if (d2 > *far2) {
                *far2 = d2;
                farthest = corner;
            }
        }
    return farthest;
}
