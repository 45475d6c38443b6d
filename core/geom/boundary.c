#include "core/geom/boundary.h"

#include "core/base/linalg.h"

int vor_boundary_one_sided(const struct vor_surface *surface, const float *near, unsigned k,
                           const double local[3])
{
    double at[3], along[2], direction[3];

    vor_surface_to_world(surface, local, at);
    along[0] = surface->center[0] - local[0];
    along[1] = surface->center[1] - local[1];
    for (int c = 0; c < 3; c++)
        direction[c] = along[0] * surface->axis[0][c] + along[1] * surface->axis[1][c];
    for (unsigned i = 0; i < k; i++) {
        double d[3] = {(double)near[3 * i] - at[0], (double)near[3 * i + 1] - at[1],
                       (double)near[3 * i + 2] - at[2]};

        if (!(vor_dot(direction, d) > 0))
            return 0;
    }
    return 1;
}

int vor_boundary_restrict(const struct vor_surface *surface, const float *near, unsigned k,
                          double x[3])
{
    double d[3], local[3], length;

    if (surface->kind == VOR_SURFACE_NONE)
        return 0;
    for (int c = 0; c < 3; c++)
        d[c] = x[c] - (double)near[c];
    length = sqrt(vor_dot(d, d));
    if (!(length > surface->spacing))
        return 0;
    vor_surface_to_local(surface, x, local);
    if (!vor_boundary_one_sided(surface, near, k, local))
        return 0;
    for (int c = 0; c < 3; c++)
        x[c] = (double)near[c] + d[c] * (surface->spacing / length);
    return 1;
}
