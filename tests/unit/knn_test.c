/* The index: what it refuses, and small sets by hand. Every test runs on each structure: loop 0 is
 * vor_knn_build, loop 1 vor_knn_build_sorted on two threads, loop 2 vor_knn_build_along. */
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static vor_status build(int kind, struct vor_knn **out, const float *xyz, size_t n,
                        struct vor_memory *memory)
{
    struct vt_engine engine;
    vor_status status;

    if (kind == 0)
        return vor_knn_build(out, xyz, n, memory, &vt_err);
    vt_engine_open(&engine, 2);
    engine.run.memory = memory;
    status =
        (kind == 1 ? vor_knn_build_sorted : vor_knn_build_along)(out, xyz, n, &engine.run, &vt_err);
    engine.run.memory = &vt_memory;
    vt_engine_close(&engine);
    return status;
}

VT_TEST_LOOP(an_index_of_no_points_is_refused, 3)
{
    struct vor_knn *knn = NULL;
    const float x[3] = {0};

    vt_assert_fails(VOR_E_EMPTY, build(_i, &knn, x, 0, &vt_memory));
    ck_assert_ptr_null(knn);
}

VT_TEST_LOOP(a_coordinate_that_would_mislead_the_index_is_refused_by_name, 3)
{
    static const float bad[4] = {NAN, INFINITY, -INFINITY, 1.1e15f};

    for (int b = 0; b < 4; b++)
        for (size_t at = 0; at < 6; at++) {
            float x[6] = {1, 2, 3, 4, 5, 6};
            struct vor_knn *knn = NULL;
            char where[40];

            x[at] = bad[b];
            vt_assert_fails(VOR_E_NONFINITE, build(_i, &knn, x, 2, &vt_memory));
            (void)snprintf(where, sizeof where, "coordinate %c of point %zu", "xyz"[at % 3],
                           at / 3);
            ck_assert_ptr_nonnull(strstr(vt_err.message, where));
            ck_assert_ptr_null(knn);
        }
}

VT_TEST_LOOP(an_index_is_charged_to_its_allocator_and_given_back, 3)
{
    struct vor_memory memory;
    struct vor_knn *knn;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 1000);
    vor_memory_init(&memory, SIZE_MAX);
    vt_assert_ok(build(_i, &knn, cloud.xyz, 1000, &memory));
    ck_assert_uint_ge(atomic_load(&memory.used), 1000 * (_i == 0 ? 37 : 7));
    vor_knn_free(knn);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    vor_knn_free(NULL);
    vor_cloud_free(&cloud);
}

VT_TEST_LOOP(neighbours_come_nearest_first, 3)
{
    const float x[12] = {0, 0, 0, 1, 0, 0, 3, 0, 0, 7, 0, 0}, query[6] = {2.9f, 0, 0, -1, 0, 0};
    struct vor_knn *knn;
    uint32_t index[8];
    float distance2[8];
    static const uint32_t expected[8] = {2, 1, 0, 3, 0, 1, 2, 3};

    vt_assert_ok(build(_i, &knn, x, 4, &vt_memory));
    vor_knn_search(knn, query, 2, 4, index, distance2);
    for (int i = 0; i < 8; i++)
        ck_assert_uint_eq(index[i], expected[i]);
    ck_assert_float_eq_tol(distance2[0], 0.01f, 1e-6f);
    ck_assert(distance2[4] == 1 && distance2[5] == 4 && distance2[6] == 16 && distance2[7] == 64);
    vor_knn_free(knn);
}

VT_TEST_LOOP(no_queries_write_nothing, 3)
{
    const float x[3] = {1, 2, 3};
    struct vor_knn *knn;
    uint32_t index = 77;
    float distance2 = 78;

    vt_assert_ok(build(_i, &knn, x, 1, &vt_memory));
    vor_knn_search(knn, x, 0, 1, &index, &distance2);
    ck_assert(index == 77 && distance2 == 78);
    vor_knn_search(knn, x, 1, 1, &index, &distance2);
    ck_assert(index == 0 && distance2 == 0);
    vor_knn_free(knn);
}

VT_TEST_LOOP(the_first_bad_coordinate_of_many_is_named, 3)
{
    enum { N = 100000 };
    float *x = vor_calloc(&vt_memory, N, 3 * sizeof *x);
    struct vor_knn *knn = NULL;

    for (size_t i = 3 * 70001 + 1; i < 3 * (size_t)N; i += 5000)
        x[i] = NAN;
    vt_assert_fails(VOR_E_NONFINITE, build(_i, &knn, x, N, &vt_memory));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "coordinate y of point 70001"));
    vor_free(&vt_memory, x);
}

/* Neither the queries of the points in that place nor of those around it, which are all as far from
 * it, look at all of the others: they would not end within the harness's ten minutes. */
VT_TEST_LOOP(many_points_in_one_place_do_not_make_queries_beside_them_long, 3)
{
    enum { N = 500000, K = 8 };
    float *x = vor_calloc(&vt_memory, N, 3 * sizeof *x);
    uint32_t index[K];
    float distance2[K];
    struct vor_knn *knn;

    for (size_t i = 0; i < N; i += 2) /* a quarter in the middle, a quarter at each of three ends */
        x[3 * i + i / 2 % 4 % 3] = i / 2 % 4 == 3 ? 0 : 1;
    vt_assert_ok(build(_i, &knn, x, N, &vt_memory));
    for (size_t i = 0; i < N; i++) {
        vor_knn_search(knn, &x[3 * i], 1, K, index, distance2);
        ck_assert(distance2[0] == 0 && distance2[K - 1] == 0);
    }
    for (size_t i = 0; i < N; i++) {
        const float query[3] = {-1 - (float)i, 0, 0};

        vor_knn_search(knn, query, 1, K, index, distance2);
        ck_assert(distance2[0] > 0 && distance2[0] == distance2[K - 1]);
    }
    vor_knn_free(knn);
    vor_free(&vt_memory, x);
}
