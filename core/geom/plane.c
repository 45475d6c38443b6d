#include "core/geom/plane.h"

#include "core/base/linalg.h"

#include <stddef.h>

void vor_plane_fit(struct vor_plane *out, const float *xyz, const uint32_t *index, unsigned k)
{
    double mean[3] = {0}, m[6] = {0}, values[3], vectors[3][3], total;

    for (unsigned j = 0; j < k; j++)
        for (unsigned c = 0; c < 3; c++)
            mean[c] += (double)xyz[3 * (size_t)index[j] + c] / k;
    for (unsigned j = 0; j < k; j++) {
        const float *p = &xyz[3 * (size_t)index[j]];
        double d[3] = {(double)p[0] - mean[0], (double)p[1] - mean[1], (double)p[2] - mean[2]};

        vor_add_square(m, d);
    }
    vor_eigen3_flat(values, vectors, m);
    total = values[0] + values[1] + values[2];
    for (unsigned c = 0; c < 3; c++) {
        out->middle[c] = (float)mean[c];
        out->normal[c] = (float)vectors[0][c];
    }
    out->flatness = (float)(total > 0 ? values[0] / total : 1);
}

double vor_plane_cost(const struct vor_plane *plane, const float x[3], double r2)
{
    double height = 0;

    for (unsigned c = 0; c < 3; c++)
        height += ((double)x[c] - (double)plane->middle[c]) * (double)plane->normal[c];
    return (double)plane->flatness + height * height / r2;
}
