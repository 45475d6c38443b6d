#include "core/mesh/quality.h"

#include "core/base/linalg.h"

#include <string.h>

void vor_frame_of(struct vor_frame *out, const float normal[3])
{
    double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]}, any[3] = {0, 0, 0};
    double length;
    int least = 0;

    for (int c = 1; c < 3; c++)
        least = fabs(n[c]) < fabs(n[least]) ? c : least;
    any[least] = 1;
    vor_cross(out->axis[0], n, any);
    length = sqrt(vor_dot(out->axis[0], out->axis[0]));
    for (int c = 0; c < 3; c++)
        out->axis[0][c] /= length;
    memcpy(out->axis[2], n, sizeof n);
    vor_cross(out->axis[1], out->axis[2], out->axis[0]);
}

void vor_triangle_normal(double out[3], const float *xyz, const uint32_t corner[3])
{
    double u[3], v[3];

    vor_way(u, &xyz[3 * (size_t)corner[0]], &xyz[3 * (size_t)corner[1]]);
    vor_way(v, &xyz[3 * (size_t)corner[0]], &xyz[3 * (size_t)corner[2]]);
    vor_cross(out, u, v);
}

int vor_triangle_unit_normal(double out[3], const float *xyz, const uint32_t corner[3])
{
    double length;

    vor_triangle_normal(out, xyz, corner);
    length = sqrt(vor_dot(out, out));
    for (int c = 0; c < 3; c++)
        out[c] /= length > 0 ? length : 1;
    return length > 0;
}

double vor_triangle_quality(const float *xyz, const uint32_t corner[3])
{
    double normal[3], perimeter = 0, longest = 0;

    vor_triangle_normal(normal, xyz, corner);
    for (int c = 0; c < 3; c++) {
        double u[3], length;

        vor_way(u, &xyz[3 * (size_t)corner[c]], &xyz[3 * (size_t)corner[(c + 1) % 3]]);
        length = sqrt(vor_dot(u, u));
        perimeter += length;
        longest = fmax(longest, length);
    }
    if (!(longest > 0))
        return 0;
    return 6 / sqrt(3) * sqrt(vor_dot(normal, normal)) / (perimeter * longest);
}

double vor_triangle_strain(const float *xyz, const uint32_t corner[3])
{
    double normal[3], sum = 0, area2;

    vor_triangle_normal(normal, xyz, corner);
    area2 = sqrt(vor_dot(normal, normal));
    for (int c = 0; c < 3; c++)
        sum += vor_distance2f(&xyz[3 * (size_t)corner[c]], &xyz[3 * (size_t)corner[(c + 1) % 3]]);
    return area2 > 0 ? sum / (2 * sqrt(3) * area2) : INFINITY;
}

double vor_triangle_sharpest(const float *xyz, const uint32_t corner[3])
{
    double most = -1;

    for (int c = 0; c < 3; c++) {
        double u[3], v[3], length;

        vor_way(u, &xyz[3 * (size_t)corner[c]], &xyz[3 * (size_t)corner[(c + 1) % 3]]);
        vor_way(v, &xyz[3 * (size_t)corner[c]], &xyz[3 * (size_t)corner[(c + 2) % 3]]);
        length = sqrt(vor_dot(u, u) * vor_dot(v, v));
        most = fmax(most, length > 0 ? vor_dot(u, v) / length : 1);
    }
    return fmin(most, 1);
}
