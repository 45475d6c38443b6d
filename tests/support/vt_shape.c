#include "tests/support/vt_shape.h"

#include "tests/support/vt_engine.h"

#include <math.h>

static double off_sphere(const double x[3])
{
    return fabs(sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) - 1);
}

static double off_torus(const double x[3])
{
    return fabs(hypot(hypot(x[0], x[1]) - 1, x[2]) - VT_TORUS_TUBE);
}

const struct vt_shape vt_shapes[VT_SMOOTH] = {
    [VT_SPHERE] = {"sphere", vt_cloud_sphere, off_sphere, 4 * M_PI},
    [VT_TORUS] = {"torus", vt_cloud_torus, off_torus, 4 * M_PI *M_PI *VT_TORUS_TUBE},
};

void vt_cloud_torus(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0, drawn = 0; i < n; drawn++) {
        double around = 2 * M_PI * vt_unit(seed, 3 * drawn);
        double tube = 2 * M_PI * vt_unit(seed, 3 * drawn + 1);
        double r = 1 + VT_TORUS_TUBE * cos(tube);

        if (vt_unit(seed, 3 * drawn + 2) * (1 + VT_TORUS_TUBE) > r)
            continue;
        cloud->xyz[3 * i] = (float)(r * cos(around));
        cloud->xyz[3 * i + 1] = (float)(r * sin(around));
        cloud->xyz[3 * i++ + 2] = (float)(VT_TORUS_TUBE * sin(tube));
    }
}

void vt_cloud_sheets(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    vt_cloud_square(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i + 2] = (float)(i % 2 ? gap : 0);
}

double vt_off_mean(const struct vt_shape *shape, const struct vor_cloud *cloud)
{
    double sum = 0, x[3];

    for (size_t i = 0; i < cloud->n; i++) {
        vor_cloud_position(cloud, i, x);
        sum += shape->off(x);
    }
    return sum / (double)cloud->n;
}
