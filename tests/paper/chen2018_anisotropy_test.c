/* Chen 2018, Sec. 5.3: cells are longer along the direction of least curvature, or as tensors of
 * the input ask. Measured against the curvature of the shape itself: each cell is clipped again, in
 * the true metric of the true tangent plane. */
#include "core/base/stat.h"
#include "core/input/anisotropy.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { IN = 10000, OUT = 1000, NEAR = 60, CORNERS = 64 };

#define MOST 6.0

/* The plane and the metric at a point: what an offset is in it, stretched, along the long side and
 * across. */
struct truth {
    double along[3], across[3], normal[3], aspect;
    int counts; /* the point is not near an end of the shape */
};

static void run(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                size_t points, unsigned threads)
{
    struct vt_engine engine;

    vt_engine_open(&engine, threads);
    vt_engine_count(&engine, "points", points);
    vt_engine_set(&engine, "metric", in->attribute_count > 0 ? "attribute:shape" : "anisotropic");
    vt_engine_resample(&engine, out, report, in);
    vt_engine_close(&engine);
}

/* Half axes 4, 1 and 1. */
static void make_ellipsoid(struct vor_cloud *cloud)
{
    vt_cloud_ellipsoid(cloud, 3, IN, 4);
}

/* The principal curvatures are 4 / w^3 along the meridian and 4 / w around. */
static void truth_of_ellipsoid(struct truth *truth, const float *x)
{
    double r = hypot((double)x[1], (double)x[2]), t = atan2(r, (double)x[0] / 4);
    double w = hypot(4 * sin(t), cos(t)), y = (double)x[1] / r, z = (double)x[2] / r;

    *truth = (struct truth){{-4 * sin(t) / w, cos(t) / w * y, cos(t) / w * z},
                            {0, -z, y},
                            {cos(t) / w, 4 * sin(t) / w * y, 4 * sin(t) / w * z},
                            fmin(w, MOST),
                            1};
}

/* The same on a cylinder of radius 1 about the z axis, six high, with caps. */
static void make_cylinder(struct vor_cloud *cloud)
{
    vt_cloud_make(cloud, IN);
    for (uint64_t i = 0; i < IN; i++) {
        int cap = vt_unit(4, 4 * i) < 1 / 7.0;
        double turn = 2 * M_PI * vt_unit(4, 4 * i + 1), h = 6 * vt_unit(4, 4 * i + 2) - 3;
        double r = cap ? sqrt(vt_unit(4, 4 * i + 3)) : 1;

        cloud->xyz[3 * i] = (float)(r * cos(turn));
        cloud->xyz[3 * i + 1] = (float)(r * sin(turn));
        cloud->xyz[3 * i + 2] = (float)(cap ? copysign(3, h) : h);
    }
}

static void truth_of_cylinder(struct truth *truth, const float *x)
{
    double r = hypot((double)x[0], (double)x[1]), u = (double)x[0] / r, v = (double)x[1] / r;

    *truth = (struct truth){
        {0, 0, 1}, {-v, u, 0}, {u, v, 0}, MOST, fabs(r - 1) < 0.02 && fabsf(x[2]) < 2.3F};
}

/* Clips a polygon by the bisector of the origin and d. Returns the number of its corners. */
static unsigned clip(double (*p)[2], unsigned n, const double d[2])
{
    double kept[CORNERS][2], limit = (d[0] * d[0] + d[1] * d[1]) / 2;
    unsigned count = 0;

    for (unsigned i = 0; i < n; i++) {
        const double *a = p[i], *b = p[(i + 1) % n];
        double x = a[0] * d[0] + a[1] * d[1] - limit, y = b[0] * d[0] + b[1] * d[1] - limit;

        if (x <= 0)
            memcpy(kept[count++], a, sizeof kept[0]);
        if ((x <= 0) != (y <= 0)) {
            kept[count][0] = a[0] + x / (x - y) * (b[0] - a[0]);
            kept[count++][1] = a[1] + x / (x - y) * (b[1] - a[1]);
        }
    }
    ck_assert_uint_lt(count, CORNERS - 2);
    memcpy(p, kept, count * sizeof kept[0]);
    return count;
}

/* Root of the ratio of the principal second moments about the centroid. */
static double aspect_of(double (*p)[2], unsigned n)
{
    double area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, half, apart, mean;

    for (unsigned i = 0; i < n; i++) {
        const double *a = p[i], *b = p[(i + 1) % n];
        double cross = a[0] * b[1] - a[1] * b[0], s = a[0] + b[0], t = a[1] + b[1];

        area += cross / 2;
        x += cross * s / 6;
        y += cross * t / 6;
        xx += cross / 24 * (a[0] * a[0] + b[0] * b[0] + s * s);
        xy += cross / 24 * (a[0] * a[1] + b[0] * b[1] + s * t);
        yy += cross / 24 * (a[1] * a[1] + b[1] * b[1] + t * t);
    }
    xx -= x * x / area;
    xy -= x * y / area;
    yy -= y * y / area;
    mean = (xx + yy) / 2;
    half = (xx - yy) / 2;
    apart = sqrt(half * half + xy * xy);
    return sqrt((mean + apart) / (mean - apart));
}

struct offset {
    double s, t, length2;
};

static int nearer(const void *a, const void *b)
{
    const struct offset *x = a, *y = b;

    return (x->length2 > y->length2) - (x->length2 < y->length2);
}

/* How far the cell of point i is off the aspect wanted there, and the distance to the nearest. */
static void measure(double *off, double *nearest, const struct vor_cloud *cloud, size_t i,
                    const struct truth *truth)
{
    static struct offset offset[OUT];
    double corner[CORNERS][2] = {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}}, root = sqrt(truth->aspect);
    unsigned corners = 4;

    for (size_t j = 0; j < OUT; j++) {
        double d[3] = {0}, along = 0, across = 0, up = 0;

        for (size_t c = 0; c < 3; c++) {
            d[c] = (double)cloud->xyz[3 * j + c] - (double)cloud->xyz[3 * i + c];
            along += d[c] * truth->along[c];
            across += d[c] * truth->across[c];
            up += d[c] * truth->normal[c];
        }
        offset[j] = (struct offset){along / root, across * root, 0};
        offset[j].length2 = offset[j].s * offset[j].s + offset[j].t * offset[j].t + up * up;
    }
    qsort(offset, OUT, sizeof *offset, nearer);
    *nearest = sqrt(offset[1].length2);
    for (size_t j = 1; j < NEAR; j++)
        corners = clip(corner, corners, (double[2]){offset[j].s, offset[j].t});
    for (unsigned j = 0; j < corners; j++) {
        corner[j][0] *= root;
        corner[j][1] /= root;
    }
    *off = fabs(aspect_of(corner, corners) / truth->aspect - 1);
}

static const struct {
    const char *name;
    void (*make)(struct vor_cloud *cloud);
    void (*truth)(struct truth *truth, const float *x);
    double area;
} shapes[] = {{"ellipsoid", make_ellipsoid, truth_of_ellipsoid, 40.50},
              {"cylinder", make_cylinder, truth_of_cylinder, 14 * M_PI}};

VT_TEST_LOOP(cells_are_as_long_as_the_curvatures_of_the_shape_ask_for, 2)
{
    static double off[OUT];
    struct vor_cloud in, out;
    struct vor_report report;
    double sum = 0, sum2 = 0, delta;
    size_t n = 0;

    shapes[_i].make(&in);
    run(&out, &report, &in, OUT, 2);
    ck_assert_uint_eq(out.n, OUT);
    for (size_t i = 0; i < OUT; i++) {
        struct truth truth;
        double nearest;

        shapes[_i].truth(&truth, &out.xyz[3 * i]);
        if (!truth.counts)
            continue;
        measure(&off[n++], &nearest, &out, i, &truth);
        sum += nearest;
        sum2 += nearest * nearest;
    }
    ck_assert_uint_gt(n, OUT / 2);
    vor_sort_doubles(off, n);
    delta = sqrt(sum2 / (double)n / (sum / (double)n * sum / (double)n) - 1);
    ck_assert_msg(off[n / 2] <= 0.15 && off[n * 9 / 10] <= 0.3 && delta <= 0.08,
                  "%s: off by %g, one in ten by %g, delta %g", shapes[_i].name, off[n / 2],
                  off[n * 9 / 10], delta);
    ck_assert(report.has_metric);
    ck_assert_msg(fabs(report.area / shapes[_i].area - 1) < 0.02, "%s: area %g, %g of cells",
                  shapes[_i].name, shapes[_i].area, report.area);
    ck_assert_msg(report.delta <= 0.08 && report.metric_off <= 0.15 &&
                      report.metric_off_high <= 0.3,
                  "%s: report: delta %g, off by %g, one in ten by %g", shapes[_i].name,
                  report.delta, report.metric_off, report.metric_off_high);
    vt_free_last(&out, &in);
}

/* Gives points of a square tensors whose long side, of aspect 4, turns with x. */
static void plant(struct vor_cloud *cloud)
{
    static const char *const parts[6] = {"shape_xx", "shape_xy", "shape_xz",
                                         "shape_yy", "shape_yz", "shape_zz"};

    for (int c = 0; c < 6; c++) {
        struct vor_attribute *attribute;

        vt_assert_ok(vor_cloud_add_attribute(cloud, parts[c], VOR_GENERIC, VOR_FLOAT64, 1,
                                             &attribute, &vt_err));
        for (size_t i = 0; i < cloud->n; i++) {
            double turn = 1.5 * (double)cloud->xyz[3 * i], u = cos(turn), v = sin(turn);
            double value[6] = {u * u + 16 * v * v, -15 * u * v, 0, 16 * u * u + v * v, 0, 1};

            ((double *)attribute->data)[i] = value[c];
        }
    }
}

VT_TEST(cells_follow_a_planted_field_of_tensors)
{
    static double off[OUT];
    struct vor_cloud in, out;
    struct vor_report report;
    size_t n = 0;

    vt_cloud_square(&in, 1, IN);
    plant(&in);
    run(&out, &report, &in, OUT, 2);
    for (size_t i = 0; i < OUT; i++) {
        const float *x = &out.xyz[3 * i];
        double turn = 1.5 * (double)x[0], u = cos(turn), v = sin(turn), nearest;
        struct truth truth = {{u, v, 0}, {-v, u, 0}, {0, 0, 1}, 4, 1};

        if (x[0] < 0.15F || x[0] > 0.85F || x[1] < 0.15F || x[1] > 0.85F)
            continue;
        measure(&off[n++], &nearest, &out, i, &truth);
    }
    vor_sort_doubles(off, n);
    ck_assert_msg(off[n / 2] <= 0.15 && off[n * 9 / 10] <= 0.3, "off by %g, one in ten by %g",
                  off[n / 2], off[n * 9 / 10]);
    ck_assert_double_eq_tol(report.metric_median, 4, 0.1);
    ck_assert_double_le(report.delta, 0.08);
    vt_free_last(&out, &in);
}
