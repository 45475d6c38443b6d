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

void vt_cloud_ellipsoid(struct vor_cloud *cloud, uint64_t seed, size_t n, double half)
{
    vt_cloud_make(cloud, n);
    for (uint64_t i = 0, drawn = 0; i < n; drawn++) {
        double x = 2 * vt_unit(seed, 3 * drawn) - 1, turn = 2 * M_PI * vt_unit(seed, 3 * drawn + 1);
        double r = sqrt(1 - x * x);

        if (half * vt_unit(seed, 3 * drawn + 2) > sqrt(x * x + half * half * r * r))
            continue;
        cloud->xyz[3 * i] = (float)(half * x);
        cloud->xyz[3 * i + 1] = (float)(r * cos(turn));
        cloud->xyz[3 * i++ + 2] = (float)(r * sin(turn));
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

static void make_square(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    (void)gap;
    vt_cloud_square(cloud, seed, n);
}

static void make_ball(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    (void)gap;
    vt_cloud_sphere(cloud, seed, n);
}

static void make_cylinder(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    (void)gap;
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double turn = 2 * M_PI * vt_unit(seed, 2 * i);

        cloud->xyz[3 * i] = (float)(0.5 * cos(turn));
        cloud->xyz[3 * i + 1] = (float)(0.5 * sin(turn));
        cloud->xyz[3 * i + 2] = (float)(2 * vt_unit(seed, 2 * i + 1));
    }
}

static void make_fold(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    double r = gap / 2, bend = M_PI * r;

    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double s = (2 + bend) * vt_unit(seed, 2 * i), x = s, z = 0;

        if (s > 1 + bend) {
            x = 2 + bend - s;
            z = gap;
        } else if (s > 1) {
            x = 1 + r * sin((s - 1) / r);
            z = r - r * cos((s - 1) / r);
        }
        cloud->xyz[3 * i] = (float)x;
        cloud->xyz[3 * i + 1] = (float)vt_unit(seed, 2 * i + 1);
        cloud->xyz[3 * i + 2] = (float)z;
    }
}

static void make_plate(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double face = (2 + 4 * gap) * vt_unit(seed, 3 * i), side = (face - 2) / gap;
        double u = vt_unit(seed, 3 * i + 1), v = vt_unit(seed, 3 * i + 2);
        float *x = &cloud->xyz[3 * i];

        x[0] = (float)u;
        x[1] = (float)v;
        x[2] = (float)(face < 1 ? 0 : gap);
        if (face < 2)
            continue;
        x[2] = (float)(v * gap);
        x[side < 2] = (float)((int)side % 2);
        x[side >= 2] = (float)u;
    }
}

static void make_spheres(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i] += (float)((i % 2 ? 1 : -1) * (1 + gap / 2));
}

static double straight(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static double along_square(const double a[3], const double b[3], double gap)
{
    (void)gap;
    return straight(a, b);
}

static double along_ball(const double a[3], const double b[3], double gap)
{
    (void)gap;
    return 2 * asin(fmin(1, straight(a, b) / 2));
}

static double along_cylinder(const double a[3], const double b[3], double gap)
{
    double turn = fabs(atan2(a[1], a[0]) - atan2(b[1], b[0]));

    (void)gap;
    return hypot(0.5 * fmin(turn, 2 * M_PI - turn), a[2] - b[2]);
}

/* How far a point is along the profile of the fold. */
static double unfolded(const double x[3], double gap)
{
    double r = gap / 2;

    if (x[0] <= 1)
        return x[2] < r ? x[0] : 2 + M_PI * r - x[0];
    return 1 + r * atan2(x[0] - 1, r - x[2]);
}

static double along_fold(const double a[3], const double b[3], double gap)
{
    return hypot(unfolded(a, gap) - unfolded(b, gap), a[1] - b[1]);
}

static double along_plate(const double a[3], const double b[3], double gap)
{
    double least = INFINITY;
    int from_face = fabs(fabs(a[2] - gap / 2) - gap / 2) < 1e-7;
    int to_face = fabs(fabs(b[2] - gap / 2) - gap / 2) < 1e-7;

    if (!from_face || !to_face || fabs(a[2] - b[2]) < gap / 2)
        return straight(a, b);
    for (int c = 0; c < 2; c++)
        for (int end = 0; end < 2; end++)
            least = fmin(least, hypot(fabs(end - a[c]) + fabs(end - b[c]) + gap, a[!c] - b[!c]));
    return least;
}

static double along_sheets(const double a[3], const double b[3], double gap)
{
    return fabs(a[2] - b[2]) > gap / 2 ? INFINITY : straight(a, b);
}

static double along_spheres(const double a[3], const double b[3], double gap)
{
    return a[0] * b[0] < 0 ? INFINITY : along_ball(a, b, gap);
}

const struct vt_metric vt_metrics[VT_METRICS] = {
    [VT_SQUARE] = {"square", make_square, along_square, 1},
    [VT_BALL] = {"sphere", make_ball, along_ball, 4 * M_PI},
    [VT_CYLINDER] = {"cylinder", make_cylinder, along_cylinder, 2 * M_PI},
    [VT_FOLD] = {"fold", make_fold, along_fold, 2},
    [VT_PLATE] = {"plate", make_plate, along_plate, 2},
    [VT_SHEETS] = {"two sheets", vt_cloud_sheets, along_sheets, 2},
    [VT_SPHERES] = {"two spheres", make_spheres, along_spheres, 8 * M_PI},
};

double vt_spacing(const struct vt_metric *metric, size_t n)
{
    return sqrt(metric->area / (double)n);
}
