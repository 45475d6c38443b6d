/* The engine's test of itself, and what it tells apart. */
#include "server/work/self_test.h"

#include "core/engine.h"
#include "tests/support/vt.h"

#include <math.h>

VT_TEST_LOOP(the_engine_works, 3)
{
    struct vor_pool *pool;

    vt_assert_ok(vor_pool_create(&pool, (unsigned)_i + 1, &vt_err));
    vt_assert_ok(vor_self_test(pool, &vt_memory, &vt_err));
    vor_pool_destroy(pool);
}

VT_TEST(a_run_that_fails_says_why)
{
    struct vor_memory memory;
    struct vor_pool *pool;
    vor_status status;
    size_t at = 0;

    vt_assert_ok(vor_pool_create(&pool, 2, &vt_err));
    do {
        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = at += 7;
        status = vor_self_test(pool, &memory, &vt_err);
        ck_assert(status == VOR_OK || status == VOR_E_NOMEM);
        ck_assert_uint_eq(memory.used, 0);
    } while (status != VOR_OK);
    ck_assert_uint_gt(at, 7);
    vor_pool_destroy(pool);
}

/* Points of a sphere, as the judge wants them. */
static void make_right(struct vor_cloud *cloud)
{
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(cloud, VOR_SELF_TEST_POINTS, &vt_err));
    for (size_t i = 0; i < cloud->n; i++) {
        float *at = cloud->xyz + 3 * i;
        double z = (2 * (double)i + 1) / VOR_SELF_TEST_POINTS - 1, turn = 2.4 * (double)i;

        at[0] = (float)(cos(turn) * sqrt(1 - z * z));
        at[1] = (float)(sin(turn) * sqrt(1 - z * z));
        at[2] = (float)z;
    }
}

VT_TEST(what_is_wrong_is_told)
{
    struct vor_cloud cloud;

    make_right(&cloud);
    vt_assert_ok(vor_self_test_judge(&cloud, .03, &vt_err));
    vt_assert_fails(VOR_E_INTERNAL, vor_self_test_judge(&cloud, .3, &vt_err));
    ck_assert_str_eq(vt_err.message, "delta of the result is 0.3, want at most 0.1");
    vt_assert_fails(VOR_E_INTERNAL, vor_self_test_judge(&cloud, NAN, &vt_err));
    cloud.xyz[5] = NAN;
    vt_assert_fails(VOR_E_INTERNAL, vor_self_test_judge(&cloud, .03, &vt_err));
    cloud.xyz[3] = 0;
    cloud.xyz[4] = 0;
    cloud.xyz[5] = 1.5F;
    vt_assert_fails(VOR_E_INTERNAL, vor_self_test_judge(&cloud, .03, &vt_err));
    ck_assert_str_eq(vt_err.message, "point 1 is 1.5 from the centre of the unit sphere, want 1");
    cloud.n--;
    vt_assert_fails(VOR_E_INTERNAL, vor_self_test_judge(&cloud, .03, &vt_err));
    ck_assert_str_eq(vt_err.message, "the result has 149 points, want 150");
    vor_cloud_free(&cloud);
}
