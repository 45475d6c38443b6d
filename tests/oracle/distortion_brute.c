/* Oracle: D1 and D2 against a look at every pair, on voxels with many equal distances and carried
 * normals, and on spheres with fitted ones. */
#include "core/base/linalg.h"
#include "core/geom/surface.h"
#include "core/metrics/distortion.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_knn.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 24, MOST = 500 };

/* Distinct points with their normals; side: whether the signs of the normals mean anything. */
struct twin {
    size_t n;
    int sided;
    float xyz[3 * MOST];
    double normal[3 * MOST];
};

static double squared(const struct twin *a, size_t i, const struct twin *b, size_t j)
{
    double sum = 0;

    for (int c = 0; c < 3; c++)
        sum += pow((double)a->xyz[3 * i + (size_t)c] - (double)b->xyz[3 * j + (size_t)c], 2);
    return sum;
}

static double nearest(const struct twin *a, size_t i, const struct twin *b, int not_itself)
{
    double least = INFINITY;

    for (size_t j = 0; j < b->n; j++)
        if (!not_itself || i != j)
            least = fmin(least, squared(a, i, b, j));
    return least;
}

/* The mean normal of the reference points whose nearest point is j. */
static void map_normal(struct twin *cloud, size_t j, const struct twin *reference)
{
    double *sum = &cloud->normal[3 * j], count = 0;

    for (size_t i = 0; i < reference->n; i++) {
        const double *normal = &reference->normal[3 * i];
        double sign = !reference->sided && vor_dot(sum, normal) < 0 ? -1 : 1;

        if (squared(reference, i, cloud, j) != nearest(reference, i, cloud, 0))
            continue;
        for (int c = 0; c < 3; c++)
            sum[c] += sign * normal[c];
        count++;
    }
    for (int c = 0; c < 3 && count > 0; c++)
        sum[c] /= count;
}

static void errors(double *d1, double *d2, const struct twin *from, const struct twin *to)
{
    double sums[2] = {0, 0};

    for (size_t i = 0; i < from->n; i++) {
        double least = nearest(from, i, to, 0), along = 0, ties = 0;

        for (size_t j = 0; j < to->n; j++) {
            double error[3];

            if (squared(from, i, to, j) != least)
                continue;
            for (size_t c = 0; c < 3; c++)
                error[c] = (double)from->xyz[3 * i + c] - (double)to->xyz[3 * j + c];
            along += pow(vor_dot(error, &to->normal[3 * j]), 2);
            ties++;
        }
        sums[0] += least;
        sums[1] += along / ties;
    }
    *d1 = fmax(*d1, sums[0] / (double)from->n);
    *d2 = fmax(*d2, sums[1] / (double)from->n);
}

static void twin_of(struct twin *twin, const struct vor_cloud *cloud)
{
    const struct vor_attribute *carried = vor_cloud_find(cloud, VOR_NORMAL);

    memset(twin, 0, sizeof *twin);
    twin->sided = carried != NULL;
    for (size_t i = 0; i < cloud->n; i++) {
        memcpy(&twin->xyz[3 * twin->n], &cloud->xyz[3 * i], 3 * sizeof *twin->xyz);
        if (twin->n > 0 && nearest(twin, twin->n, twin, 0) == 0)
            continue;
        for (size_t c = 0; c < 3 && carried != NULL; c++)
            twin->normal[3 * twin->n + c] = (double)((const float *)carried->data)[3 * i + c];
        twin->n++;
    }
}

static void fit(struct twin *twin)
{
    static const double foot[3] = {0, 0, 0};
    uint32_t index[20];
    float distance2[20], near[60];
    struct vor_surface surface;

    for (size_t i = 0; i < twin->n; i++) {
        vt_knn_brute(twin->xyz, twin->n, &twin->xyz[3 * i], 1, 20, index, distance2);
        for (size_t j = 0; j < 20; j++)
            memcpy(&near[3 * j], &twin->xyz[3 * (size_t)index[j]], 3 * sizeof *near);
        vor_surface_fit(&surface, near, 20);
        ck_assert(surface.kind != VOR_SURFACE_NONE);
        vor_surface_normal(&surface, foot, &twin->normal[3 * i]);
    }
}

static void compare(const struct vor_cloud *cloud, const struct vor_cloud *reference)
{
    static struct twin a, b;
    struct vor_distortion_pair pair = {cloud->xyz, reference->xyz, cloud->n, reference->n,
                                       vor_cloud_find(reference, VOR_NORMAL)};
    double d1 = 0, d2 = 0, peak = 0;
    struct vt_engine engine;
    struct vor_distortion found;

    twin_of(&a, cloud);
    twin_of(&b, reference);
    if (!b.sided)
        fit(&b);
    for (size_t j = 0; j < a.n; j++)
        map_normal(&a, j, &b);
    for (size_t i = 0; i < b.n; i++)
        peak = fmax(peak, nearest(&b, i, &b, 1));
    errors(&d1, &d2, &a, &b);
    errors(&d1, &d2, &b, &a);
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_distortion_measure(&found, &pair, &engine.run, &vt_err));
    vt_engine_close(&engine);
    ck_assert_double_eq_tol(found.d1_mse, d1, 1e-12 * d1 + 1e-15);
    ck_assert_double_eq_tol(found.d2_mse, d2, 1e-5 * d2 + 1e-15);
    ck_assert_double_eq_tol(found.peak, sqrt(peak), 1e-12);
}

static void unit_normals(struct vor_cloud *cloud, uint64_t seed)
{
    struct vor_attribute *normal;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &normal, &vt_err));
    for (size_t i = 0; i < cloud->n; i++) {
        double x[3], length;

        for (size_t c = 0; c < 3; c++)
            x[c] = vt_normal(seed, 3 * i + c);
        length = sqrt(vor_dot(x, x));
        for (size_t c = 0; c < 3; c++)
            ((float *)normal->data)[3 * i + c] = (float)(x[c] / length);
    }
}

/* Up to twelve voxels a side: most points have several nearest ones, and some coincide. The sparser
 * cloud is now one, now the other: the error is that of the way to it. */
VT_TEST_LOOP(voxels_have_the_errors_of_a_look_at_every_pair, VT_FEWER(SEEDS))
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 4 + (size_t)vor_rng_below(seed, 33, 0, MOST - 4);
    size_t m = 4 + (size_t)vor_rng_below(seed, 33, 2, MOST - 4);
    float side = 4 + (float)vor_rng_below(seed, 33, 1, 9);
    struct vor_cloud cloud, reference;

    vt_cloud_cube(&cloud, 2 * seed, n);
    vt_cloud_cube(&reference, 2 * seed + 1, m);
    for (size_t i = 0; i < 3 * n; i++)
        cloud.xyz[i] = floorf(cloud.xyz[i] * side);
    for (size_t i = 0; i < 3 * m; i++)
        reference.xyz[i] = floorf(reference.xyz[i] * side);
    unit_normals(&reference, seed);
    compare(&cloud, &reference);
    vt_free_last(&reference, &cloud);
}

VT_TEST_LOOP(spheres_have_the_errors_of_a_look_at_every_pair, VT_FEWER(SEEDS))
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 100 + (size_t)vor_rng_below(seed, 34, 0, MOST - 100);
    size_t m = 150 + (size_t)vor_rng_below(seed, 34, 1, MOST - 150);
    struct vor_cloud cloud, reference;

    vt_cloud_sphere(&cloud, 2 * seed, n);
    vt_cloud_sphere(&reference, 2 * seed + 1, m);
    for (size_t i = 0; i < 3 * n; i++)
        cloud.xyz[i] *= 1.03f;
    compare(&cloud, &reference);
    vt_free_last(&reference, &cloud);
}
