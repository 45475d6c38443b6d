/* Oracle: the indexes against a look at every point. Distances are compared, not indices: points
 * at equal distance come in any order. Those of the tree of boxes are the same to the bit, and the
 * same points come of it whatever the number of threads that built it. */
#include "core/base/morton.h"
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_knn.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 16, SHAPES = 10, QUERIES = 10, POOLS = 4, MANY = 20000 };

static struct vt_engine engine[POOLS];
static const unsigned threads_of[POOLS] = {1, 2, 3, 8};

static void open_pools(void)
{
    for (int p = 0; p < POOLS; p++)
        vt_engine_open(&engine[p], threads_of[p]);
}

static void close_pools(void)
{
    for (int p = 0; p < POOLS; p++)
        vt_engine_close(&engine[p]);
}

static float lay(int shape, uint64_t seed, size_t i, size_t c)
{
    double u = vt_unit(seed, 3 * i + c);

    switch (shape) {
    case 0:
        return (float)u;
    case 1: /* clusters, a ten-thousandth wide */
        return (float)(vt_unit(seed + 1000, 3 * (i % 7) + c) + 1e-4 * u);
    case 2: /* planar */
        return c == 2 ? 0.25f : (float)u;
    case 3: /* every place three times */
        return (float)vt_unit(seed, 3 * (i / 3) + c);
    case 4: /* on a line */
        return (float)(vt_unit(seed, i) * (1.0 + (double)c));
    case 5: /* ever closer to the origin */
        return (float)ldexp(u + 0.1, -(int)(i % 60));
    case 6: /* all in one place */
        return 0.3f;
    case 7: /* a third in one place, as pixels without a depth are */
        return i % 3 > 0 ? (float)(u - 0.5) : i % 2 ? 0.0f : -0.0f;
    case 8: /* as many in each of five places, next to one of which others are */
        return i % 2 ? (float)(i % 5 == c) : (float)(1e-3 * u);
    default: /* on a coarse lattice: many ties */
        return (float)floor(5 * u);
    }
}

static void check_row(const float *xyz, size_t n, const float *query, const uint32_t *index,
                      const float *found, const float *expected, unsigned k)
{
    static unsigned char seen[MANY];

    memset(seen, 0, n);
    for (unsigned j = 0; j < k; j++) {
        double d2 = 0;

        ck_assert_uint_lt(index[j], n);
        ck_assert_msg(!seen[index[j]], "point %u is there twice", index[j]);
        seen[index[j]] = 1;
        for (size_t c = 0; c < 3; c++)
            d2 += pow((double)xyz[3 * (size_t)index[j] + c] - (double)query[c], 2);
        ck_assert_double_le(fabs((double)found[j] - (double)expected[j]),
                            1e-6 * (double)expected[j]);
        ck_assert_double_le(fabs((double)found[j] - d2), 1e-6 * d2);
    }
}

static void sort_points(float *xyz, size_t n)
{
    uint32_t *order = vor_malloc(&vt_memory, n, sizeof *order);
    float *copy = vor_malloc(&vt_memory, n, 3 * sizeof *copy);

    memcpy(copy, xyz, n * 3 * sizeof *copy);
    vt_assert_ok(vor_morton_order(order, xyz, n, &engine[0].run, &vt_err));
    for (size_t i = 0; i < n; i++)
        memcpy(&xyz[3 * i], &copy[3 * (size_t)order[i]], 3 * sizeof *xyz);
    vor_free(&vt_memory, copy);
    vor_free(&vt_memory, order);
}

/* A row of queries of any k has the answers, ties and all, that each query has alone. */
static void compare_row(const struct vor_knn *knn, const float *query, unsigned most)
{
    uint32_t *index = vor_malloc(&vt_memory, most, 2 * sizeof *index);
    float *found = vor_malloc(&vt_memory, most, 2 * sizeof *found);
    struct vor_knn_last last = {.k = 0};

    for (size_t q = 0; q < QUERIES; q++) {
        unsigned k = 1 + (unsigned)(vt_unit(most, q) * most);

        vor_knn_search_next(knn, &last, &query[3 * q], k, index, found);
        vor_knn_search(knn, &query[3 * q], 1, k, index + most, found + most);
        ck_assert_mem_eq(index, index + most, k * sizeof *index);
        ck_assert_mem_eq(found, found + most, k * sizeof *found);
    }
    vor_free(&vt_memory, found);
    vor_free(&vt_memory, index);
}

/* Builds the tree on every pool; checks the first one's answers against the expected distances, the
 * others' against the first one's. */
static void compare_boxes(const float *xyz, size_t n, const float *query, unsigned k,
                          const float *expected)
{
    uint32_t *index = vor_malloc(&vt_memory, QUERIES, 2 * k * sizeof *index);
    float *found = vor_malloc(&vt_memory, QUERIES, 2 * k * sizeof *found);
    size_t values = (size_t)QUERIES * k;

    for (int p = 0; p < POOLS; p++) {
        size_t at = p > 0 ? values : 0;
        struct vor_knn *knn;

        vt_assert_ok(vor_knn_build_sorted(&knn, xyz, n, &engine[p].run, &vt_err));
        vor_knn_search(knn, query, QUERIES, k, index + at, found + at);
        compare_row(knn, query, k);
        vor_knn_free(knn);
        ck_assert_int_eq(memcmp(found + at, expected, values * sizeof *found), 0);
        ck_assert_int_eq(memcmp(index + at, index, values * sizeof *index), 0);
    }
    for (size_t q = 0; q < QUERIES; q++)
        check_row(xyz, n, &query[3 * q], &index[q * k], &found[q * k], &expected[q * k], k);
    vor_free(&vt_memory, found);
    vor_free(&vt_memory, index);
}

/* Points searched for together, along their order, and a few that are far from each other, with and
 * without a bound. */
static void compare_near(const float *xyz, size_t n, unsigned k)
{
    size_t count = n < VOR_KNN_NEAR_MAX ? n : VOR_KNN_NEAR_MAX;
    float query[3 * VOR_KNN_NEAR_MAX], within[VOR_KNN_NEAR_MAX];
    struct vor_knn_near near = {query, count, k, NULL, 0};
    float *d2 = vor_malloc(&vt_memory, 2 * count, k * sizeof *d2);
    uint32_t *index = vor_malloc(&vt_memory, count, k * sizeof *index);
    struct vor_knn *knn;

    vt_assert_ok(vor_knn_build_along(&knn, xyz, n, &engine[1].run, &vt_err));
    for (int round = 0; round < 4; round++) {
        for (size_t i = 0; i < count; i++) {
            size_t at = round < 2 ? n / 2 - count / 2 + i : i * 37 % n;

            memcpy(&query[3 * i], &xyz[3 * (size_t)vor_knn_order(knn)[at]], 3 * sizeof *query);
        }
        vt_knn_brute(xyz, n, query, count, k, index, d2 + count * k);
        for (size_t i = 0; i < count; i++)
            within[i] = sqrtf(d2[(count + i + 1) * k - 1]);
        near.within = round % 2 ? within : NULL;
        vor_knn_search_near(knn, &near, index, d2);
        for (size_t i = 0; i < count; i++)
            check_row(xyz, n, &query[3 * i], &index[i * k], &d2[i * k], &d2[(count + i) * k], k);
    }
    vor_knn_free(knn);
    vor_free(&vt_memory, index);
    vor_free(&vt_memory, d2);
}

static void compare(int shape, uint64_t seed, size_t n, unsigned k)
{
    float *xyz = vor_malloc(&vt_memory, n, 3 * sizeof *xyz), query[3 * QUERIES];
    uint32_t *index = vor_malloc(&vt_memory, QUERIES, 2 * k * sizeof *index);
    float *distance2 = vor_malloc(&vt_memory, QUERIES, 2 * k * sizeof *distance2);
    struct vor_knn *knn;

    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] = lay(shape, seed, i / 3, i % 3);
    for (size_t q = 0; q < QUERIES; q++)
        for (size_t c = 0; c < 3; c++) /* half of them points, half anywhere */
            query[3 * q + c] =
                q % 2 ? xyz[3 * (q * 37 % n) + c] : (float)(3 * vt_unit(seed + 5, 3 * q + c) - 1);
    vt_assert_ok(vor_knn_build(&knn, xyz, n, &vt_memory, &vt_err));
    vor_knn_search(knn, query, QUERIES, k, index, distance2);
    vt_knn_brute(xyz, n, query, QUERIES, k, index + QUERIES * k, distance2 + QUERIES * k);
    for (size_t q = 0; q < QUERIES; q++)
        check_row(xyz, n, &query[3 * q], &index[q * k], &distance2[q * k],
                  &distance2[(QUERIES + q) * k], k);
    vor_knn_free(knn);
    compare_near(xyz, n, k);
    compare_boxes(xyz, n, query, k, &distance2[QUERIES * k]);
    sort_points(xyz, n);
    compare_boxes(xyz, n, query, k, &distance2[QUERIES * k]);
    vor_free(&vt_memory, distance2);
    vor_free(&vt_memory, index);
    vor_free(&vt_memory, xyz);
}

VT_TEST_LOOP(the_index_finds_what_a_look_at_every_point_finds, VT_FEWER(SEEDS))
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 1 + (size_t)vor_rng_below(seed, 11, 0, 3000);

    open_pools();
    if (_i < 5)
        n = (size_t)_i + 1;
    for (int shape = 0; shape < SHAPES; shape++) {
        compare(shape, seed, n, 1);
        compare(shape, seed, n, n < 2 ? 1 : 2);
        compare(shape, seed, n, (unsigned)(n < 21 ? n : 21));
        compare(shape, seed, n, (unsigned)(1 + vor_rng_below(seed, 12, 0, n)));
    }
    close_pools();
}

VT_TEST(every_point_is_found_when_all_are_asked_for)
{
    open_pools();
    for (int shape = 0; shape < SHAPES; shape++)
        compare(shape, 99, 700, 700);
    close_pools();
}

/* Enough points for several subtrees, and for nodes above them. */
VT_TEST(many_points_are_found)
{
    open_pools();
    for (int shape = 0; shape < SHAPES; shape++) {
        compare(shape, 7, MANY, 1);
        compare(shape, 7, MANY, 33);
    }
    close_pools();
}
