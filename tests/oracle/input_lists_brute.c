/* Lists that are reused against looking at every point, while the queries wander. */
#include "core/base/stat.h"
#include "core/knn/input_lists.h"
#include "tests/support/vt.h"
#include "tests/support/vt_knn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { QUERIES = 40, STEPS = 30, K_MAX = 60 };

struct walk {
    struct vor_cloud cloud;
    struct vor_knn *knn;
    struct vor_input_lists near;
    float at[QUERIES][3];
    uint32_t last[QUERIES][K_MAX]; /* what each query found last, sorted */
    size_t found[3], kept;         /* by what was said; sets that were those of the last search */
    unsigned k;
};

static void start(struct walk *walk, uint64_t seed, size_t n, unsigned k, int still)
{
    struct vor_input_lists_of of = {.m = n, .most = k, .still = still};

    vt_cloud_cube(&walk->cloud, seed, n);
    vt_assert_ok(vor_knn_build(&walk->knn, walk->cloud.xyz, n, &vt_memory, &vt_err));
    of.knn = walk->knn;
    of.reference = walk->cloud.xyz;
    vt_assert_ok(vor_input_lists_init(&walk->near, QUERIES, &of, &vt_memory, &vt_err));
    walk->k = k;
    walk->kept = 0;
    memset(walk->found, 0, sizeof walk->found);
    memset(walk->last, 0xff, sizeof walk->last); /* no point's number */
    for (size_t i = 0; i < QUERIES; i++)
        for (size_t c = 0; c < 3; c++)
            walk->at[i][c] = (float)vt_unit(seed + 1, 3 * i + c);
}

static void end(struct walk *walk)
{
    vor_input_lists_free(&walk->near);
    vor_knn_free(walk->knn);
    vor_cloud_free(&walk->cloud);
}

static float distance2(const struct walk *walk, uint32_t point, const float x[3])
{
    const float *p = &walk->cloud.xyz[3 * (size_t)point];
    float a = p[0] - x[0], b = p[1] - x[1], c = p[2] - x[2];

    return a * a + b * b + c * c;
}

static int by_number(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;

    return (x > y) - (x < y);
}

/* Whether the points are those of the query's last search; they take its place. */
static int same_set(struct walk *walk, size_t i, const uint32_t *index)
{
    uint32_t sorted[K_MAX];
    size_t bytes = walk->k * sizeof *sorted;
    int same;

    memcpy(sorted, index, bytes);
    qsort(sorted, walk->k, sizeof *sorted, by_number);
    same = memcmp(walk->last[i], sorted, bytes) == 0;
    memcpy(walk->last[i], sorted, bytes);
    return same;
}

/* One query: distances, sorted, equal the brute ones; the nearest comes first; no point twice; what
 * is said to be the set of the last search is. */
static enum vor_input_lists_found check_query(struct walk *walk, size_t i)
{
    const uint32_t *index;
    uint32_t brute[K_MAX];
    float found[K_MAX], expected[K_MAX];
    enum vor_input_lists_found how =
        vor_input_lists_search(&walk->near, i, walk->at[i], walk->k, &index);
    unsigned twice = 0;
    int same = same_set(walk, i, index);

    walk->found[how]++;
    walk->kept += same;
    ck_assert(how != VOR_INPUT_LISTS_SAME || same);
    ck_assert_uint_eq(vor_input_lists_first(&walk->near, i), index[0]);
    vt_knn_brute(walk->cloud.xyz, walk->cloud.n, walk->at[i], 1, walk->k, brute, expected);
    for (unsigned j = 0; j < walk->k; j++) {
        found[j] = distance2(walk, index[j], walk->at[i]);
        twice += j > 0 && walk->last[i][j] == walk->last[i][j - 1];
    }
    ck_assert_uint_eq(twice, 0);
    ck_assert(found[0] == expected[0]);
    vor_sort_floats(found, walk->k);
    ck_assert(memcmp(found, expected, walk->k * sizeof *found) == 0);
    return how;
}

VT_TEST_LOOP(a_wandering_query_finds_what_brute_force_finds, 30)
{
    static const unsigned ks[] = {1, 6, 20, 40, K_MAX};
    struct walk walk;
    double step = _i % 3 == 0 ? 0.2 : _i % 3 == 1 ? 0.01 : 0.001;

    start(&walk, (uint64_t)_i, 60 + 300 * (size_t)(_i % 4), ks[_i % 5], _i / 3 % 2);
    if (_i % 2 > 0)
        vor_input_lists_make(&walk.near, 0, QUERIES, walk.at[0], walk.k);
    walk.at[1][0] += 0.1f; /* its list does not count then */
    for (size_t s = 0; s < STEPS; s++)
        for (size_t i = 0; i < QUERIES; i++) {
            enum vor_input_lists_found how = check_query(&walk, i);

            ck_assert(s > 0 || how == VOR_INPUT_LISTS_ANEW);
            for (size_t c = 0; c < 3; c++)
                walk.at[i][c] +=
                    (float)(step * (vt_unit((uint64_t)_i + 2, (s * QUERIES + i) * 3 + c) - 0.5));
        }
    ck_assert_uint_ge(walk.found[VOR_INPUT_LISTS_ANEW], QUERIES);
    if (step <= 0.001 && !walk.near.still) { /* or the lists are of no use */
        ck_assert_uint_le(walk.found[VOR_INPUT_LISTS_ANEW], QUERIES * STEPS / 2);
        ck_assert_uint_ge(walk.found[VOR_INPUT_LISTS_SAME], walk.kept * 2 / 3);
    }
    end(&walk);
}

VT_TEST_LOOP(put_onto_other_points_it_forgets_the_first_ones, 3)
{
    struct walk walk, other;

    start(&walk, (uint64_t)_i, 400, 20, 0);
    start(&other, (uint64_t)_i + 9, 300, 20, 0);
    for (size_t i = 0; i < QUERIES; i++)
        (void)check_query(&walk, i);
    vor_input_lists_onto(&walk.near, other.knn, other.cloud.xyz, other.cloud.n);
    vor_knn_free(walk.knn);
    vor_cloud_free(&walk.cloud);
    walk.knn = other.knn;
    walk.cloud = other.cloud;
    for (size_t i = 0; i < QUERIES; i++)
        ck_assert_int_eq(check_query(&walk, i), VOR_INPUT_LISTS_ANEW);
    vor_input_lists_free(&other.near);
    end(&walk);
}

/* What the list of a query tells of places near it is what is there, the nearest first: at the
 * query itself all that was asked for, farther away less, and far away nothing. */
VT_TEST_LOOP(what_a_list_tells_of_places_around_is_true, 4)
{
    static const double away[] = {0, 0.02, 0.1, 3};
    struct walk walk;

    start(&walk, (uint64_t)_i, 1000, 20, 0);
    for (size_t i = 0; i < QUERIES; i++) {
        uint32_t index[K_MAX], brute[K_MAX];
        float expected[K_MAX];

        ck_assert_uint_eq(vor_input_lists_around(&walk.near, i, walk.at[i], walk.k, index),
                          0); /* no list */
        (void)check_query(&walk, i);
        for (size_t a = 0; a < sizeof away / sizeof *away; a++) {
            float x[3];
            unsigned told;

            for (size_t c = 0; c < 3; c++)
                x[c] =
                    walk.at[i][c] + (float)(away[a] * (vt_unit((uint64_t)_i + 7, 3 * i + c) - 0.5));
            told = vor_input_lists_around(&walk.near, i, x, walk.k, index);
            ck_assert_uint_le(told, walk.k);
            ck_assert(a > 0 || told == walk.k);
            ck_assert(a < 3 || told == 0);
            vt_knn_brute(walk.cloud.xyz, walk.cloud.n, x, 1, walk.k, brute, expected);
            for (unsigned j = 0; j < told; j++)
                ck_assert(distance2(&walk, index[j], x) == expected[j]);
        }
    }
    end(&walk);
}

/* A list that was left every other of the points around finds the nearest of these, though fewer
 * than it was asked for, until it is made anew. */
VT_TEST_LOOP(a_narrowed_list_finds_the_nearest_of_its_own, 2)
{
    unsigned k = 20, count = _i == 0 ? 45 : 15;
    struct walk walk;

    start(&walk, 3, 1000, k, 0);
    for (size_t i = 0; i < QUERIES; i++) {
        uint32_t around[90], own[45];
        float d2[90], x[3];
        const uint32_t *index;

        (void)check_query(&walk, i);
        vt_knn_brute(walk.cloud.xyz, 1000, walk.at[i], 1, 90, around, d2);
        for (unsigned j = 0; j < count; j++)
            own[j] = around[2 * j];
        vor_input_lists_narrow(&walk.near, i, walk.at[i], own, count, sqrtf(d2[89]));
        for (size_t c = 0; c < 3; c++)
            x[c] = walk.at[i][c] + 0.003F;
        if (vor_input_lists_search(&walk.near, i, x, k, &index) == VOR_INPUT_LISTS_ANEW)
            continue;
        ck_assert_uint_eq(vor_input_lists_count(&walk.near, i), count < k ? count : k);
        for (unsigned j = 0; j < count; j++) {
            unsigned in = 0, nearer = 0;

            for (unsigned other = 0; other < count; other++)
                nearer += distance2(&walk, own[other], x) < distance2(&walk, own[j], x);
            for (unsigned m = 0; m < vor_input_lists_count(&walk.near, i); m++)
                in += index[m] == own[j];
            ck_assert_uint_eq(in, nearer < k);
        }
        walk.kept++;
    }
    ck_assert_uint_ge(walk.kept, QUERIES / 2);
    end(&walk);
}
