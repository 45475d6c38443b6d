#include "tests/support/vt_wedge.h"

#include "core/base/linalg.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PLACES = 200 /* on the edge, where the distance to the nearest point is asked */ };

/* Direction within a square, away from the edge. */
static void across(const struct vt_wedge *wedge, int square, double d[3])
{
    double turn = square == 0 ? 0 : wedge->degrees * M_PI / 180;

    d[0] = cos(turn);
    d[1] = 0;
    d[2] = sin(turn);
}

static void normal_of(const struct vt_wedge *wedge, int square, double normal[3])
{
    double d[3];

    across(wedge, square, d);
    normal[0] = square == 0 ? 0 : d[2];
    normal[1] = 0;
    normal[2] = square == 0 ? 1 : -d[0];
}

void vt_wedge_make(struct vor_cloud *cloud, const struct vt_wedge *wedge, uint64_t seed)
{
    vt_cloud_make(cloud, wedge->n);
    for (size_t i = 0; i < wedge->n; i++) {
        double d[3], far = vt_unit(seed, 3 * i), along = vt_unit(seed, 3 * i + 1);

        across(wedge, vt_unit(seed, 3 * i + 2) < 0.5, d);
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] = (float)(far * d[c] + (c == 1 ? along : 0) +
                                            wedge->noise * vt_normal(seed + 1, 3 * i + c));
    }
}

/* How far a number is outside of 0 .. 1. */
static double outside(double t)
{
    return t < 0 ? -t : t > 1 ? t - 1 : 0;
}

double vt_wedge_off(const struct vt_wedge *wedge, int square, const double x[3])
{
    double d[3], normal[3], height, far, along;

    across(wedge, square, d);
    normal_of(wedge, square, normal);
    height = vor_dot(x, normal);
    far = outside(vor_dot(x, d));
    along = outside(x[1]);
    return sqrt(height * height + far * far + along * along);
}

double vt_wedge_spacing(size_t n)
{
    return sqrt(2 / sqrt(3) * 2 / (double)n);
}

static int by_value(const void *left, const void *right)
{
    const double *a = left, *b = right;

    return *a < *b ? -1 : *a > *b;
}

double vt_quantile(double *value, size_t n, double share)
{
    qsort(value, n, sizeof *value, by_value);
    return value[(size_t)(share * (double)n)];
}

static double degrees_between(const double a[3], const double b[3])
{
    double cosine = fabs(vor_dot(a, b)) / sqrt(vor_dot(a, a) * vor_dot(b, b));

    return acos(fmin(1, cosine)) * 180 / M_PI;
}

/* A place to write one more point's figures to. */
static void make_room(struct vt_wedge_seen *seen)
{
    if (seen->n < seen->room)
        return;
    seen->room = 2 * seen->room + 1000;
    seen->angle = realloc(seen->angle, seen->room * sizeof *seen->angle);
    seen->off = realloc(seen->off, seen->room * sizeof *seen->off);
    ck_assert(seen->angle != NULL && seen->off != NULL);
}

static void see_point(struct vt_wedge_seen *seen, const struct vt_wedge *wedge, const double x[3],
                      const double normal[3])
{
    double off[2], angle[2], least;

    for (int square = 0; square < 2; square++) {
        double true_normal[3];

        normal_of(wedge, square, true_normal);
        angle[square] = degrees_between(normal, true_normal);
        off[square] = vt_wedge_off(wedge, square, x);
    }
    least = fmin(off[0], off[1]);
    make_room(seen);
    seen->off[seen->n] = least;
    if (fabs(off[0] - off[1]) <= wedge->noise)
        seen->angle[seen->n] = fmin(angle[0], angle[1]);
    else
        seen->angle[seen->n] = angle[off[0] < off[1] ? 0 : 1];
    seen->smeared += fmin(angle[0], angle[1]) > VT_SMEARED_DEGREES || least > 2 * wedge->noise;
    seen->n++;
}

void vt_wedge_see(struct vt_wedge_seen *seen, const struct vt_wedge *wedge,
                  const struct vor_cloud *cloud)
{
    const struct vor_attribute *normals = vor_cloud_find(cloud, VOR_NORMAL);
    double near = VT_WEDGE_NEAR * vt_wedge_spacing(cloud->n);

    ck_assert_ptr_nonnull(normals);
    for (size_t i = 0; i < cloud->n; i++) {
        double x[3], normal[3];

        vor_cloud_position(cloud, i, x);
        for (size_t c = 0; c < 3; c++)
            normal[c] = vor_attribute_scalar(normals, 3 * i + c);
        if (x[0] * x[0] + x[2] * x[2] < near * near && x[1] > near && x[1] < 1 - near)
            see_point(seen, wedge, x, normal);
    }
    for (int k = 0; k < PLACES; k++) {
        double place[3] = {0, near + (1 - 2 * near) * (k + 0.5) / PLACES, 0};

        seen->reach_sum += sqrt(vt_nearest2(cloud, place, NULL));
        seen->reach_count++;
    }
}

void vt_wedge_seen_free(struct vt_wedge_seen *seen)
{
    free(seen->angle);
    free(seen->off);
    memset(seen, 0, sizeof *seen);
}
