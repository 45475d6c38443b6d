/* The input made ready: normalised, sorted, without coincident points. */
#include "core/input/domain.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 10, N = 600 };

/* Two threads, and memory of the test's choice. */
static vor_status init_domain(struct vor_domain *domain, const struct vor_cloud *cloud,
                              struct vor_memory *memory)
{
    struct vt_engine engine;
    vor_status status;

    vt_engine_open(&engine, 2);
    engine.run.memory = memory;
    status = vor_domain_init(domain, cloud, &engine.run, &vt_err);
    vt_engine_close(&engine);
    return status;
}

static void open_domain(struct vor_domain *domain, const struct vor_cloud *cloud)
{
    vt_assert_ok(init_domain(domain, cloud, &vt_memory));
}

VT_TEST_LOOP(every_distinct_point_is_there_once, SEEDS)
{
    struct vor_cloud cloud;
    struct vor_domain domain;
    unsigned char seen[N] = {0};

    vt_cloud_cube(&cloud, (uint64_t)_i, N);
    open_domain(&domain, &cloud);
    ck_assert_uint_eq(domain.n, N);
    for (size_t i = 0; i < N; i++)
        ck_assert_uint_eq(seen[domain.source[i]]++, 0);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
}

VT_TEST_LOOP(the_unit_is_a_power_of_two_and_positions_lose_nothing, SEEDS)
{
    struct vor_cloud cloud;
    struct vor_domain domain;
    float scale = ldexpf(1.37f, 5 * _i - 50);
    int exponent;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    for (size_t i = 0; i < 3 * N; i++)
        cloud.xyz[i] *= scale;
    open_domain(&domain, &cloud);
    ck_assert(frexp(domain.unit, &exponent) == 0.5);
    for (size_t i = 0; i < 3 * domain.n; i++) {
        size_t at = 3 * (size_t)domain.source[i / 3] + i % 3;

        ck_assert(fabsf(domain.xyz[i]) <= 1);
        ck_assert((double)domain.xyz[i] * domain.unit + domain.shift[i % 3] ==
                  (double)cloud.xyz[at]);
    }
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
}

/* A cloud far from its origin is moved there first, since normalising it in place would leave few
 * bits to the positions; and that costs at most half a step of its own float32. */
VT_TEST_LOOP(a_cloud_far_from_its_origin_fills_the_unit_cube, SEEDS)
{
    struct vor_cloud cloud;
    struct vor_domain domain;
    float low = 1, high = -1;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    for (size_t i = 0; i < 3 * N; i++)
        cloud.xyz[i] += i % 3 == 0 ? 637000.25f : 0;
    open_domain(&domain, &cloud);
    for (size_t i = 0; i < 3 * domain.n; i++) {
        double back = (double)domain.xyz[i] * domain.unit + domain.shift[i % 3];
        double from = (double)cloud.xyz[3 * (size_t)domain.source[i / 3] + i % 3];

        ck_assert_double_le(fabs(back - from), 0x1p-24 * (1 + fabs(from)));
        ck_assert(fabsf(domain.xyz[i]) <= 1);
        low = i % 3 == 0 ? fminf(low, domain.xyz[i]) : low;
        high = i % 3 == 0 ? fmaxf(high, domain.xyz[i]) : high;
    }
    ck_assert_float_ge(high - low, 0.5f);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
}

VT_TEST_LOOP(coincident_points_are_dropped_for_the_first_of_them, SEEDS)
{
    struct vor_cloud cloud;
    struct vor_domain domain;
    size_t places = N / 4;

    vt_cloud_cube(&cloud, (uint64_t)_i, N);
    for (size_t i = places; i < N; i++)
        memcpy(&cloud.xyz[3 * i], &cloud.xyz[3 * (i * i % places)], 3 * sizeof *cloud.xyz);
    open_domain(&domain, &cloud);
    ck_assert_uint_eq(domain.n, places);
    for (size_t i = 0; i < domain.n; i++)
        ck_assert_uint_lt(domain.source[i], places);
    ck_assert_uint_eq(vt_coincident(&cloud), N - places);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
}

VT_TEST(zero_and_minus_zero_are_one_place)
{
    static const float xyz[18] = {0, 0, 0, -0.0f, 0, -0.0f, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    struct vor_cloud cloud;
    struct vor_domain domain;

    vt_cloud_make(&cloud, 6);
    memcpy(cloud.xyz, xyz, sizeof xyz);
    open_domain(&domain, &cloud);
    ck_assert_uint_eq(domain.n, 5);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
}

/* A point far from all others: float32 tells these apart no more, and the message names it. */
VT_TEST(an_outlier_that_hides_all_others_is_named)
{
    struct vor_domain domain;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 3, N);
    for (size_t c = 0; c < 3; c++)
        cloud.xyz[3 * 17 + c] = c == 1 ? 1e9f : 0;
    vt_assert_fails(VOR_E_DEGENERATE, init_domain(&domain, &cloud, &vt_memory));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "point 17 at 0 1e+09 0 is 1e+09 away"));
    for (size_t i = 0; i < N / 2; i++) /* half of the points are no outliers */
        memcpy(&cloud.xyz[3 * i], &cloud.xyz[3 * 17], 3 * sizeof *cloud.xyz);
    vt_assert_fails(VOR_E_DEGENERATE, init_domain(&domain, &cloud, &vt_memory));
    ck_assert_ptr_null(strstr(vt_err.message, "away"));
    vor_cloud_free(&cloud);
}
