/* The index: what it refuses, and small sets by hand. */
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

START_TEST(an_index_of_no_points_is_refused)
{
    struct vor_knn *knn = NULL;
    const float x[3] = {0};

    vt_assert_fails(VOR_E_EMPTY, vor_knn_build(&knn, x, 0, &vt_memory, &vt_err));
    ck_assert_ptr_null(knn);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_coordinate_that_would_mislead_the_index_is_refused_by_name)
{
    static const float bad[4] = {NAN, INFINITY, -INFINITY, 1.1e6f};

    for (int b = 0; b < 4; b++)
        for (size_t at = 0; at < 6; at++) {
            float x[6] = {1, 2, 3, 4, 5, 6};
            struct vor_knn *knn = NULL;
            char where[40];

            x[at] = bad[b];
            vt_assert_fails(VOR_E_NONFINITE, vor_knn_build(&knn, x, 2, &vt_memory, &vt_err));
            (void)snprintf(where, sizeof where, "coordinate %c of point %zu", "xyz"[at % 3],
                           at / 3);
            ck_assert_ptr_nonnull(strstr(vt_err.message, where));
            ck_assert_ptr_null(knn);
        }
    vt_assert_no_leak();
}
END_TEST

START_TEST(an_index_that_does_not_fit_is_refused_whole)
{
    struct vor_memory memory;
    struct vor_knn *knn = NULL;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 1000);
    vor_memory_init(&memory, 20000);
    vt_assert_fails(VOR_E_NOMEM, vor_knn_build(&knn, cloud.xyz, 1000, &memory, &vt_err));
    ck_assert_ptr_null(knn);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(an_index_is_charged_to_its_allocator_and_given_back)
{
    struct vor_memory memory;
    struct vor_knn *knn;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 1000);
    vor_memory_init(&memory, SIZE_MAX);
    vt_assert_ok(vor_knn_build(&knn, cloud.xyz, 1000, &memory, &vt_err));
    ck_assert_uint_ge(atomic_load(&memory.used), 1000 * 37);
    vor_knn_free(knn);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    vor_knn_free(NULL);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(neighbours_come_nearest_first)
{
    const float x[12] = {0, 0, 0, 1, 0, 0, 3, 0, 0, 7, 0, 0}, query[6] = {2.9f, 0, 0, -1, 0, 0};
    struct vor_knn *knn;
    uint32_t index[8];
    float distance2[8];
    static const uint32_t expected[8] = {2, 1, 0, 3, 0, 1, 2, 3};

    vt_assert_ok(vor_knn_build(&knn, x, 4, &vt_memory, &vt_err));
    vor_knn_search(knn, query, 2, 4, index, distance2);
    for (int i = 0; i < 8; i++)
        ck_assert_uint_eq(index[i], expected[i]);
    ck_assert_float_eq_tol(distance2[0], 0.01f, 1e-6f);
    ck_assert(distance2[4] == 1 && distance2[5] == 4 && distance2[6] == 16 && distance2[7] == 64);
    vor_knn_free(knn);
}
END_TEST

START_TEST(no_queries_write_nothing)
{
    const float x[3] = {1, 2, 3};
    struct vor_knn *knn;
    uint32_t index = 77;
    float distance2 = 78;

    vt_assert_ok(vor_knn_build(&knn, x, 1, &vt_memory, &vt_err));
    vor_knn_search(knn, x, 0, 1, &index, &distance2);
    ck_assert(index == 77 && distance2 == 78);
    vor_knn_search(knn, x, 1, 1, &index, &distance2);
    ck_assert(index == 0 && distance2 == 0);
    vor_knn_free(knn);
}
END_TEST

START_TEST(points_all_in_one_place_are_all_found)
{
    float x[300];
    uint32_t index[100];
    float distance2[100];
    unsigned char seen[100] = {0};
    struct vor_knn *knn;

    for (int i = 0; i < 300; i++)
        x[i] = 0.5f;
    vt_assert_ok(vor_knn_build(&knn, x, 100, &vt_memory, &vt_err));
    vor_knn_search(knn, x, 1, 100, index, distance2);
    for (int i = 0; i < 100; i++) {
        ck_assert(distance2[i] == 0 && index[i] < 100 && !seen[index[i]]);
        seen[index[i]] = 1;
    }
    vor_knn_free(knn);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("knn");

    vt_add(suite, an_index_of_no_points_is_refused);
    vt_add(suite, a_coordinate_that_would_mislead_the_index_is_refused_by_name);
    vt_add(suite, an_index_that_does_not_fit_is_refused_whole);
    vt_add(suite, an_index_is_charged_to_its_allocator_and_given_back);
    vt_add(suite, neighbours_come_nearest_first);
    vt_add(suite, no_queries_write_nothing);
    vt_add(suite, points_all_in_one_place_are_all_found);
    return vt_run(suite);
}
