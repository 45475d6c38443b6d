/* What the index of a cloud costs, step by step: its points sorted along the Morton curve, FLANN's
 * kd-tree and the tree of boxes built over them, the boxes on two threads too; then neighbours near
 * points spread over the cloud looked up in both, one query a call and many. CPU seconds of one
 * thread, but the build on two: seconds by the clock.
 *
 * usage: index CLOUD.ply */
#include "core/base/morton.h"
#include "core/knn/knn.h"
#include "tests/support/read_cloud.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    BLOCK = 250,      /* queries a call, where it is many */
    QUERIES = 100000, /* at most */
    K_MAX = 150,
    KS = 4,
    BATCH_K = 20,
    KINDS = 2
};

static const unsigned ks[KS] = {1, 20, 32, K_MAX};
static const char *const kind_name[KINDS] = {"flann", "boxes"};

struct timing {
    double sort, build[KINDS], build_two;
    double one_us[KINDS][KS], batch_us[KINDS]; /* a query */
};

static double seconds(clockid_t clock)
{
    struct timespec t;

    (void)clock_gettime(clock, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static double cpu_seconds(void)
{
    return seconds(CLOCK_PROCESS_CPUTIME_ID);
}

/* The cloud's positions become sorted ones. */
static vor_status sort_cloud(struct vor_cloud *cloud, const struct vor_run *run,
                             struct vor_error *err)
{
    uint32_t *order = vor_malloc(cloud->memory, cloud->n, sizeof *order);
    float *xyz = vor_malloc(cloud->memory, cloud->n, 3 * sizeof *xyz);
    vor_status status;

    if (order == NULL || xyz == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "sorting %zu points", cloud->n);
        goto done;
    }
    status = vor_morton_order(order, cloud->xyz, cloud->n, run, err);
    if (status != VOR_OK)
        goto done;
    for (size_t i = 0; i < cloud->n; i++)
        memcpy(&xyz[3 * i], &cloud->xyz[3 * (size_t)order[i]], 3 * sizeof *xyz);
    memcpy(cloud->xyz, xyz, cloud->n * 3 * sizeof *xyz);
done:
    vor_free(cloud->memory, xyz);
    vor_free(cloud->memory, order);
    return status;
}

/* Blocks of points that follow each other, spread over the whole cloud, each asked for in calls of
 * `call` queries. Microseconds a query. */
static double search(const struct vor_knn *knn, const struct vor_cloud *cloud, unsigned k,
                     size_t call)
{
    static uint32_t index[BLOCK * K_MAX];
    static float distance2[BLOCK * K_MAX];
    size_t step = cloud->n <= QUERIES ? BLOCK : cloud->n / (QUERIES / BLOCK), queries = 0;
    double began = cpu_seconds();

    for (size_t i = 0; i + BLOCK <= cloud->n; i += step)
        for (size_t j = i; j < i + BLOCK; j += call, queries += call)
            vor_knn_search(knn, &cloud->xyz[3 * j], call, k, index, distance2);
    return (cpu_seconds() - began) / (double)queries * 1e6;
}

static vor_status measure_kind(struct timing *timing, int kind, const struct vor_cloud *cloud,
                               const struct vor_run *run, struct vor_error *err)
{
    struct vor_knn *knn;
    double began = cpu_seconds();
    vor_status status = kind == 0 ? vor_knn_build(&knn, cloud->xyz, cloud->n, run->memory, err)
                                  : vor_knn_build_sorted(&knn, cloud->xyz, cloud->n, run, err);

    if (status != VOR_OK)
        return status;
    timing->build[kind] = cpu_seconds() - began;
    for (int i = 0; i < KS; i++)
        timing->one_us[kind][i] = search(knn, cloud, ks[i], 1);
    timing->batch_us[kind] = search(knn, cloud, BATCH_K, BLOCK);
    vor_knn_free(knn);
    return VOR_OK;
}

static vor_status measure_two(struct timing *timing, const struct vor_cloud *cloud,
                              struct vor_memory *memory, struct vor_error *err)
{
    struct vor_run run = {.memory = memory};
    struct vor_knn *knn = NULL;
    double began;
    vor_status status = vor_pool_create(&run.pool, 2, err);

    if (status != VOR_OK)
        return status;
    began = seconds(CLOCK_MONOTONIC);
    status = vor_knn_build_sorted(&knn, cloud->xyz, cloud->n, &run, err);
    timing->build_two = seconds(CLOCK_MONOTONIC) - began;
    vor_knn_free(knn);
    vor_pool_destroy(run.pool);
    return status;
}

static vor_status measure(struct timing *timing, struct vor_cloud *cloud, const char *path,
                          const struct vor_run *run, struct vor_error *err)
{
    double began;
    vor_status status = read_cloud(cloud, path, err);

    if (status != VOR_OK)
        return status;
    if (cloud->n < K_MAX + BLOCK)
        return vor_fail(err, VOR_E_PARAM, "%zu points, want %d", cloud->n, K_MAX + BLOCK);
    began = cpu_seconds();
    status = sort_cloud(cloud, run, err);
    timing->sort = cpu_seconds() - began;
    for (int kind = 0; status == VOR_OK && kind < KINDS; kind++)
        status = measure_kind(timing, kind, cloud, run, err);
    return status == VOR_OK ? measure_two(timing, cloud, run->memory, err) : status;
}

static void print(const struct timing *timing, size_t n)
{
    (void)printf("{\"n\":%zu,\"sort\":%.6f,\"build_two\":%.6f", n, timing->sort, timing->build_two);
    for (int kind = 0; kind < KINDS; kind++) {
        (void)printf(",\"%s_build\":%.6f", kind_name[kind], timing->build[kind]);
        for (int i = 0; i < KS; i++)
            (void)printf(",\"%s_%u\":%.4f", kind_name[kind], ks[i], timing->one_us[kind][i]);
        (void)printf(",\"%s_batch\":%.4f", kind_name[kind], timing->batch_us[kind]);
    }
    (void)printf("}\n");
}

int main(int argc, char **argv)
{
    struct vor_memory memory;
    struct vor_run run = {.memory = &memory};
    struct vor_cloud cloud;
    struct vor_error err;
    struct timing timing = {0};
    vor_status status;

    if (argc != 2) {
        (void)fprintf(stderr, "usage: index CLOUD.ply\n");
        return 2;
    }
    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    status = vor_pool_create(&run.pool, 1, &err);
    if (status == VOR_OK)
        status = measure(&timing, &cloud, argv[1], &run, &err);
    if (status == VOR_OK)
        print(&timing, cloud.n);
    else
        (void)fprintf(stderr, "%s\n", err.message);
    vor_cloud_free(&cloud);
    vor_pool_destroy(run.pool);
    return status == VOR_OK ? 0 : 1;
}
