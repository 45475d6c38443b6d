/* The parallel sort against qsort by code, coordinates and index, for several numbers of threads;
 * and the box against looking at every point. */
#include "core/base/bounds.h"
#include "core/base/morton.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>

enum { SHAPES = 6, THREADS = 4, MANY = 120000 };

static const unsigned threads_of[THREADS] = {1, 2, 3, 8};

struct key {
    uint64_t code;
    float x[3];
    uint32_t index;
};

/* Bit by bit. */
static uint64_t slow_code(const uint64_t cell[3])
{
    uint64_t code = 0;

    for (int bit = 20; bit >= 0; bit--)
        for (int c = 2; c >= 0; c--)
            code = code << 1 | (cell[c] >> bit & 1);
    return code;
}

static int compare(const void *a, const void *b)
{
    const struct key *x = a, *y = b;

    if (x->code != y->code)
        return x->code < y->code ? -1 : 1;
    for (int c = 0; c < 3; c++)
        if (x->x[c] != y->x[c])
            return x->x[c] < y->x[c] ? -1 : 1;
    return x->index < y->index ? -1 : 1;
}

static struct key *slow_order(const struct vor_cloud *cloud)
{
    struct key *keys = malloc(cloud->n * sizeof *keys);
    double low[3], high[3], extent = 0;

    ck_assert_ptr_nonnull(keys);
    for (int c = 0; c < 3; c++) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
        for (size_t i = 0; i < cloud->n; i++) {
            low[c] = fmin(low[c], (double)cloud->xyz[3 * i + (size_t)c]);
            high[c] = fmax(high[c], (double)cloud->xyz[3 * i + (size_t)c]);
        }
        extent = fmax(extent, high[c] - low[c]);
    }
    for (size_t i = 0; i < cloud->n; i++) {
        double scale = extent > 0 ? 2097151 / extent : 0;
        uint64_t cell[3];

        for (size_t c = 0; c < 3; c++) {
            keys[i].x[c] = cloud->xyz[3 * i + c];
            cell[c] = (uint64_t)(((double)keys[i].x[c] - low[c]) * scale);
        }
        keys[i].code = slow_code(cell);
        keys[i].index = (uint32_t)i;
    }
    qsort(keys, cloud->n, sizeof *keys, compare);
    return keys;
}

/* A box; a lattice's even steps; a crowd with one point far away, so that nearly all share the
 * first digits; nearly all in one cell; few places, each many times; all in one place. */
static void make(struct vor_cloud *cloud, int shape, size_t n)
{
    vt_cloud_box(cloud, 3, n);
    for (size_t i = 0; i < 3 * n; i++) {
        float *x = &cloud->xyz[i];

        if (shape == 1)
            *x = rintf(*x * 40);
        if (shape == 2 && i >= 3)
            *x = *x * 1e-3f + 5;
        if (shape == 3 && i >= 3)
            *x = *x * 1e-8f + 1e-7f;
        if (shape == 4)
            *x = cloud->xyz[i % 300];
        if (shape == 5)
            *x = -7;
    }
    if (shape == 2 || shape == 3)
        cloud->xyz[0] = 100;
}

static void check_order(const struct vor_cloud *cloud, const struct key *keys, unsigned threads)
{
    struct vt_engine engine;
    uint32_t *order = malloc(cloud->n * sizeof *order);

    ck_assert_ptr_nonnull(order);
    vt_engine_open(&engine, threads);
    vt_assert_ok(vor_morton_order(order, cloud->xyz, cloud->n, &engine.run, &vt_err));
    for (size_t i = 0; i < cloud->n; i++)
        ck_assert_uint_eq(order[i], keys[i].index);
    vt_engine_close(&engine);
    free(order);
}

/* Sizes around those at which the work is cut otherwise: 16,384 points, and many. */
VT_TEST_LOOP(the_order_is_that_of_qsort_for_any_number_of_threads, VT_FEWER(SHAPES))
{
    static const size_t sizes[6] = {1, 25, 1000, 16384, 16385, MANY};

    for (int s = 0; s < 6; s++) {
        struct vor_cloud cloud;
        struct key *keys;

        make(&cloud, _i, sizes[s]);
        keys = slow_order(&cloud);
        for (int t = 0; t < THREADS; t++)
            check_order(&cloud, keys, threads_of[t]);
        free(keys);
        vor_cloud_free(&cloud);
    }
}

VT_TEST(the_box_is_that_of_looking_at_every_point)
{
    for (int t = 0; t < THREADS; t++)
        for (size_t n = 1; n <= MANY; n = 7 * n + 1) {
            struct vt_engine engine;
            struct vor_cloud cloud;
            struct vor_box box;

            vt_engine_open(&engine, threads_of[t]);
            vt_cloud_sphere(&cloud, n, n);
            vt_assert_ok(vor_bounds(&box, cloud.xyz, n, &engine.run, &vt_err));
            for (size_t c = 0; c < 3; c++) {
                float low = INFINITY, high = -INFINITY;

                for (size_t i = 0; i < n; i++) {
                    low = fminf(low, cloud.xyz[3 * i + c]);
                    high = fmaxf(high, cloud.xyz[3 * i + c]);
                }
                ck_assert(box.low[c] == low && box.high[c] == high);
            }
            vor_cloud_free(&cloud);
            vt_engine_close(&engine);
        }
}
