#include "tests/support/vt_shape.h"

#include "core/base/linalg.h"
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

static void trefoil(double t, double x[3])
{
    x[0] = (2 + cos(3 * t)) * cos(2 * t);
    x[1] = (2 + cos(3 * t)) * sin(2 * t);
    x[2] = -sin(3 * t);
}

/* Unit vectors across the knot at t: away from the axis of its torus, made orthogonal, and the
 * other. */
static void across(double t, double first[3], double second[3])
{
    const double step = 1e-4;
    double before[3], after[3], along[3], length, dot;

    trefoil(t - step, before);
    trefoil(t + step, after);
    for (int c = 0; c < 3; c++)
        along[c] = after[c] - before[c];
    length = sqrt(vor_dot(along, along));
    for (int c = 0; c < 3; c++)
        along[c] /= length;
    first[0] = cos(3 * t) * cos(2 * t);
    first[1] = cos(3 * t) * sin(2 * t);
    first[2] = -sin(3 * t);
    dot = vor_dot(first, along);
    for (int c = 0; c < 3; c++)
        first[c] -= dot * along[c];
    length = sqrt(vor_dot(first, first));
    for (int c = 0; c < 3; c++)
        first[c] /= length;
    vor_cross(second, along, first);
}

void vt_cloud_knot(struct vor_cloud *cloud, float *normal, uint64_t seed, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double t = 2 * M_PI * vt_unit(seed, 2 * i), tube = 2 * M_PI * vt_unit(seed, 2 * i + 1);
        double x[3], first[3], second[3];

        trefoil(t, x);
        across(t, first, second);
        for (size_t c = 0; c < 3; c++) {
            double out = cos(tube) * first[c] + sin(tube) * second[c];

            cloud->xyz[3 * i + c] = (float)(x[c] + VT_KNOT_TUBE * out);
            if (normal != NULL)
                normal[3 * i + c] = (float)out;
        }
    }
}

void vt_cloud_moebius(struct vor_cloud *cloud, uint64_t seed, size_t n, double width)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double around = 2 * M_PI * vt_unit(seed, 2 * i);
        double off = width * (vt_unit(seed, 2 * i + 1) - 0.5), r = 1 + off * cos(around / 2);

        cloud->xyz[3 * i] = (float)(r * cos(around));
        cloud->xyz[3 * i + 1] = (float)(r * sin(around));
        cloud->xyz[3 * i + 2] = (float)(off * sin(around / 2));
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
