#include "tests/support/vt_noise.h"

#include "core/base/linalg.h"
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>

/* Added to seeds: a cloud is made from the same numbers as its seed's noise would be. */
#define APART UINT64_C(0x6e6f697365)

enum { NEAR = 6, FLAT = 20, OUTLIER_FROM = 3, OUTLIER_TO = 6 };

/* The k nearest points of every point, itself first: n x k; free() both. */
static void nearest(uint32_t **index, float **distance2, const struct vor_cloud *cloud, unsigned k)
{
    struct vor_knn *knn;

    ck_assert_uint_ge(cloud->n, k);
    *index = malloc(cloud->n * k * sizeof **index);
    *distance2 = malloc(cloud->n * k * sizeof **distance2);
    ck_assert(*index != NULL && *distance2 != NULL);
    vt_assert_ok(vor_knn_build(&knn, cloud->xyz, cloud->n, &vt_memory, &vt_err));
    vor_knn_search(knn, cloud->xyz, cloud->n, k, *index, *distance2);
    vor_knn_free(knn);
}

/* l from lists of k points. */
static void lengths_of(double *length, size_t n, const float *distance2, unsigned k)
{
    for (size_t i = 0; i < n; i++) {
        length[i] = 0;
        for (size_t j = 1; j <= NEAR; j++)
            length[i] += sqrt((double)distance2[i * k + j]) / NEAR;
    }
}

/* Normal of the plane through the points of one list. */
static void plane(double normal[3], const struct vor_cloud *cloud, const uint32_t *index)
{
    double middle[3] = {0}, m[6] = {0}, values[3], vectors[3][3];

    for (size_t j = 0; j < FLAT; j++)
        for (size_t c = 0; c < 3; c++)
            middle[c] += (double)cloud->xyz[3 * (size_t)index[j] + c] / FLAT;
    for (size_t j = 0; j < FLAT; j++) {
        double d[3];

        for (size_t c = 0; c < 3; c++)
            d[c] = (double)cloud->xyz[3 * (size_t)index[j] + c] - middle[c];
        m[0] += d[0] * d[0];
        m[1] += d[0] * d[1];
        m[2] += d[0] * d[2];
        m[3] += d[1] * d[1];
        m[4] += d[1] * d[2];
        m[5] += d[2] * d[2];
    }
    vor_eigen3(values, vectors, m);
    for (int c = 0; c < 3; c++)
        normal[c] = vectors[0][c];
}

void vt_noise_normals(double *normal, const struct vor_cloud *cloud)
{
    uint32_t *index;
    float *distance2;

    nearest(&index, &distance2, cloud, FLAT);
    for (size_t i = 0; i < cloud->n; i++)
        plane(&normal[3 * i], cloud, &index[i * FLAT]);
    free(distance2);
    free(index);
}

/* l and the normals of a cloud, from the same lists: free() both. */
static void measure(double **length, double **normal, const struct vor_cloud *cloud)
{
    uint32_t *index;
    float *distance2;

    *length = malloc(cloud->n * sizeof **length);
    *normal = malloc(cloud->n * 3 * sizeof **normal);
    ck_assert(*length != NULL && *normal != NULL);
    nearest(&index, &distance2, cloud, FLAT);
    lengths_of(*length, cloud->n, distance2, FLAT);
    for (size_t i = 0; i < cloud->n; i++)
        plane(&(*normal)[3 * i], cloud, &index[i * FLAT]);
    free(distance2);
    free(index);
}

static void move(float *x, const double normal[3], double by)
{
    for (int c = 0; c < 3; c++)
        x[c] = (float)((double)x[c] + normal[c] * by);
}

void vt_noise_add(struct vor_cloud *cloud, uint64_t seed, double deviation)
{
    double *length, *normal;

    seed += APART;
    measure(&length, &normal, cloud);
    for (size_t i = 0; i < cloud->n; i++)
        move(&cloud->xyz[3 * i], &normal[3 * i], deviation * length[i] * vt_normal(seed, i));
    free(normal);
    free(length);
}

void vt_noise_outliers(unsigned char *moved, struct vor_cloud *cloud, uint64_t seed, double share)
{
    size_t left = (size_t)(share * (double)cloud->n);
    double *length, *normal;

    seed += APART;
    measure(&length, &normal, cloud);
    for (size_t i = 0; i < cloud->n; i++) { /* every subset of that size is as likely */
        double by =
            length[i] * (OUTLIER_FROM + (OUTLIER_TO - OUTLIER_FROM) * vt_unit(seed, 3 * i + 1));

        moved[i] = vt_unit(seed, 3 * i) * (double)(cloud->n - i) < (double)left;
        if (!moved[i])
            continue;
        left--;
        move(&cloud->xyz[3 * i], &normal[3 * i], vt_unit(seed, 3 * i + 2) < 0.5 ? -by : by);
    }
    free(normal);
    free(length);
}
