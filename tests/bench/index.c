/* What the index of a cloud costs, step by step: its points sorted along the Morton curve, the
 * index built over them, 20 neighbours of each looked up. CPU seconds of one thread.
 *
 * usage: index CLOUD.ply */
#include "core/base/morton.h"
#include "core/knn/knn.h"
#include "proto/codec.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define NEIGHBORS 20
#define BLOCK 256       /* queries a call, as the engine asks them */
#define QUERIES 1000000 /* at most */

struct timing {
    double sort, build, search;
    size_t queries;
};

static double cpu_seconds(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static vor_status read_cloud(struct vor_cloud *cloud, const char *path, struct vor_error *err)
{
    struct vor_limits limits = VOR_LIMITS_DEFAULT;
    FILE *in = fopen(path, "rb");
    uint8_t *bytes = NULL;
    long size = -1;
    vor_status status;

    if (in != NULL && fseek(in, 0, SEEK_END) == 0 && (size = ftell(in)) > 0)
        bytes = vor_malloc(cloud->memory, (size_t)size, 1);
    if (bytes == NULL || fseek(in, 0, SEEK_SET) != 0 ||
        fread(bytes, 1, (size_t)size, in) != (size_t)size)
        status = vor_fail(err, VOR_E_IO, "%s cannot be read", path);
    else
        status = vor_codec_read(cloud, NULL, bytes, (size_t)size, &limits, err);
    vor_free(cloud->memory, bytes);
    if (in != NULL)
        (void)fclose(in);
    return status;
}

/* The cloud's positions become sorted ones. */
static vor_status sort_cloud(struct vor_cloud *cloud, struct vor_error *err)
{
    uint32_t *order = vor_malloc(cloud->memory, cloud->n, sizeof *order);
    float *xyz = vor_malloc(cloud->memory, cloud->n, 3 * sizeof *xyz);
    vor_status status;

    if (order == NULL || xyz == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "sorting %zu points", cloud->n);
        goto done;
    }
    status = vor_morton_order(order, cloud->xyz, cloud->n, cloud->memory, err);
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

/* Blocks of points that follow each other, spread over the whole cloud. */
static void search(const struct vor_knn *knn, const struct vor_cloud *cloud, struct timing *timing)
{
    static uint32_t index[BLOCK * NEIGHBORS];
    static float distance2[BLOCK * NEIGHBORS];
    size_t step = cloud->n <= QUERIES ? BLOCK : cloud->n / (QUERIES / BLOCK);
    unsigned k = cloud->n < NEIGHBORS ? (unsigned)cloud->n : NEIGHBORS;

    for (size_t i = 0; i < cloud->n; i += step) {
        size_t count = cloud->n - i < BLOCK ? cloud->n - i : BLOCK;

        vor_knn_search(knn, &cloud->xyz[3 * i], count, k, index, distance2);
        timing->queries += count;
    }
}

static vor_status measure(struct timing *timing, struct vor_cloud *cloud, const char *path,
                          struct vor_error *err)
{
    struct vor_knn *knn;
    double began;
    vor_status status = read_cloud(cloud, path, err);

    if (status != VOR_OK)
        return status;
    began = cpu_seconds();
    status = sort_cloud(cloud, err);
    timing->sort = cpu_seconds() - began;
    if (status != VOR_OK)
        return status;
    began = cpu_seconds();
    status = vor_knn_build(&knn, cloud->xyz, cloud->n, cloud->memory, err);
    timing->build = cpu_seconds() - began;
    if (status != VOR_OK)
        return status;
    began = cpu_seconds();
    search(knn, cloud, timing);
    timing->search = cpu_seconds() - began;
    vor_knn_free(knn);
    return VOR_OK;
}

int main(int argc, char **argv)
{
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_error err;
    struct timing timing = {0};

    if (argc != 2) {
        (void)fprintf(stderr, "usage: index CLOUD.ply\n");
        return 2;
    }
    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    if (measure(&timing, &cloud, argv[1], &err) != VOR_OK) {
        (void)fprintf(stderr, "%s\n", err.message);
        vor_cloud_free(&cloud);
        return 1;
    }
    (void)printf("{\"n\":%zu,\"sort\":%.6f,\"build\":%.6f,\"search_us\":%.4f}\n", cloud.n,
                 timing.sort, timing.build, timing.search / (double)timing.queries * 1e6);
    vor_cloud_free(&cloud);
    return 0;
}
