/* How a result follows a density: the field of the request is made again, and each point of the
 * result has the density that was followed there and the distance to its nearest other one. Prints
 * a JSON object: slope of log distance over log density by the means of 20 bins with as many points
 * each, and delta of the distance times density^(1/4).
 *
 * usage: density CLOUD.ply RESULT.ply DENSITY */
#include "core/input/density.h"
#include "core/base/stat.h"
#include "core/input/input.h"
#include "core/metrics/uniformity.h"
#include "tests/support/read_cloud.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BINS = 20 };

/* A point of the result. */
struct followed {
    double rho, apart;
};

static int by_density(const void *a, const void *b)
{
    double x = ((const struct followed *)a)->rho, y = ((const struct followed *)b)->rho;

    return (x > y) - (x < y);
}

static double slope_of(struct followed *point, size_t n)
{
    double x = 0, y = 0, xx = 0, xy = 0;

    qsort(point, n, sizeof *point, by_density);
    for (size_t bin = 0; bin < BINS; bin++) {
        size_t begin = bin * n / BINS, end = (bin + 1) * n / BINS;
        double rho = 0, apart = 0, count = (double)(end - begin);

        for (size_t i = begin; i < end; i++) {
            rho += log(point[i].rho) / count;
            apart += log(point[i].apart) / count;
        }
        x += rho / BINS;
        y += apart / BINS;
        xx += rho * rho / BINS;
        xy += rho * apart / BINS;
    }
    return (xy - x * y) / (xx - x * x);
}

static double delta_of(const struct followed *point, size_t n)
{
    double sum = 0, sum2 = 0;

    for (size_t i = 0; i < n; i++) {
        double d = point[i].apart * sqrt(sqrt(point[i].rho));

        sum += d;
        sum2 += d * d;
    }
    return sqrt(fmax(sum2 * (double)n / (sum * sum) - 1, 0));
}

/* Density and distance at each point of the result. */
static vor_status follow(struct followed *point, const struct vor_cloud *result,
                         const struct vor_cloud *cloud, const struct vor_domain *domain,
                         const struct vor_run *run, struct vor_error *err)
{
    float *xyz = vor_malloc(run->memory, result->n, 3 * sizeof *xyz);
    float *apart = vor_malloc(run->memory, result->n, sizeof *apart);
    struct vor_knn *knn = NULL;
    vor_status status = VOR_OK;

    if (xyz == NULL || apart == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", result->n);
    for (size_t i = 0; status == VOR_OK && i < result->n; i++) {
        float relative[3];

        for (size_t c = 0; c < 3; c++)
            relative[c] =
                (float)(result->origin[c] - cloud->origin[c] + (double)result->xyz[3 * i + c]);
        vor_domain_normalise(domain, relative, &xyz[3 * i]);
    }
    if (status == VOR_OK)
        status = vor_knn_build(&knn, xyz, result->n, run->memory, err);
    if (status == VOR_OK)
        status = vor_nearest_distances(apart, xyz, result->n, knn, run, err);
    for (size_t i = 0; status == VOR_OK && i < result->n; i++) {
        struct vor_field_near near;
        double value;

        vor_field_find(&near, &domain->field, &xyz[3 * i]);
        value = (double)near.value;
        point[i] = (struct followed){1 / (value * value * value * value), (double)apart[i]};
    }
    vor_knn_free(knn);
    vor_free(run->memory, apart);
    vor_free(run->memory, xyz);
    return status;
}

static vor_status measure(struct vor_cloud *cloud, struct vor_cloud *result,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    struct followed *point = malloc(result->n * sizeof *point);
    struct vor_domain domain;
    vor_status status;

    if (point == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", result->n);
    status = vor_input_prepare(&domain, cloud, spec, run, err);
    if (status != VOR_OK) {
        free(point);
        return status;
    }
    status = vor_density_make(&domain, cloud, result->n, spec, run, err);
    if (status == VOR_OK)
        status = follow(point, result, cloud, &domain, run, err);
    if (status == VOR_OK) {
        double slope = slope_of(point, result->n);

        (void)printf("{\"n\":%zu,\"slope\":%.5f,\"delta\":%.5f,\"span\":%.4f}\n", result->n, slope,
                     delta_of(point, result->n), domain.field.span);
    }
    vor_domain_free(&domain);
    free(point);
    return status;
}

int main(int argc, char **argv)
{
    struct vor_memory memory;
    struct vor_run run = {.memory = &memory};
    struct vor_cloud cloud, result;
    struct vor_spec spec;
    struct vor_error err;
    vor_status status;

    if (argc != 4) {
        (void)fprintf(stderr, "usage: density CLOUD.ply RESULT.ply DENSITY\n");
        return 2;
    }
    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    vor_cloud_init(&result, &memory);
    vor_spec_init(&spec);
    status = vor_pool_create(&run.pool, 1, &err);
    if (status == VOR_OK)
        status = vor_spec_set(&spec, "density", argv[3], &err);
    if (status == VOR_OK)
        status = read_cloud(&cloud, argv[1], &err);
    if (status == VOR_OK)
        status = read_cloud(&result, argv[2], &err);
    if (status == VOR_OK)
        status = measure(&cloud, &result, &spec, &run, &err);
    if (status != VOR_OK)
        (void)fprintf(stderr, "%s\n", err.message);
    vor_cloud_free(&result);
    vor_cloud_free(&cloud);
    vor_pool_destroy(run.pool);
    return status == VOR_OK ? 0 : 1;
}
