/* The library's functions as a program calls them: floats in and out. */
#include "core/voronoid.h"
#include "tests/support/vt.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { N = 3000, MORE = 6000 };

static struct vor_cloud cloud;
static float values[N], spread[2][3 * MORE], taken[2][MORE];

static struct vor_points given(void)
{
    return (struct vor_points){N, cloud.xyz, values, 1};
}

static struct vor_points wanted(int which, size_t n)
{
    return (struct vor_points){n, spread[which], taken[which], 1};
}

static void make(void)
{
    vt_cloud_torus(&cloud, 5, N);
    for (size_t i = 0; i < N; i++)
        values[i] = cloud.xyz[3 * i];
}

static void unmake(void)
{
    vor_cloud_free(&cloud);
}

/* A value that is the first coordinate stays about that. */
START_TEST(results_are_even_with_the_values_around_them)
{
    struct vor_failure failure;
    struct vor_points in = given(), out = wanted(0, 1000), again = wanted(1, 1000);
    struct vor_call call = {.threads = vor_threads_start(3, &failure)};
    double off = 0;

    ck_assert_ptr_nonnull(call.threads);
    ck_assert_int_eq(vor_resample(&out, &in, NULL, &failure), 0);
    ck_assert_str_eq(failure.name, "");
    ck_assert_int_eq(vor_resample(&again, &in, &call, NULL), 0);
    ck_assert_mem_eq(spread[0], spread[1], 3 * 1000 * sizeof(float));
    for (size_t i = 0; i < 1000; i++)
        off += fabs((double)(taken[0][i] - spread[0][3 * i])) / 1000;
    ck_assert_double_lt(off, 0.05);
    out = (struct vor_points){MORE, spread[0], NULL, 0};
    ck_assert_int_eq(vor_upsample(&out, &in, &call, &failure), 0);
    ck_assert(isfinite(spread[0][3 * MORE - 1]));
    vor_threads_end(call.threads);
}
END_TEST

static enum vor_told answer(void *ctx, const struct vor_state *state)
{
    return state->iteration < 2 ? VOR_GO_ON : *(const enum vor_told *)ctx;
}

START_TEST(a_call_says_how_far_it_is_and_ends_when_told)
{
    enum vor_told says = VOR_TAKE_BEST;
    struct vor_failure failure;
    struct vor_points in = given(), out = wanted(0, 500), all = wanted(1, 500);
    const struct vor_call call = {.progress = answer, .ctx = &says};

    ck_assert_int_eq(vor_resample(&out, &in, &call, &failure), 0);
    ck_assert_int_eq(vor_resample(&all, &in, NULL, &failure), 0);
    ck_assert_mem_ne(spread[0], spread[1], 3 * 500 * sizeof(float));
    says = VOR_GIVE_UP;
    memcpy(spread[1], spread[0], sizeof spread[0]);
    ck_assert_int_eq(vor_resample(&out, &in, &call, &failure), -1);
    ck_assert_str_eq(failure.name, "cancelled");
    ck_assert_mem_eq(spread[0], spread[1], sizeof spread[0]);
}
END_TEST

static const char *const no_word[] = {"method", "cvtt", NULL}, *const no_value[] = {"seed", NULL},
                         *const reference[] = {"density", "curvature", NULL};

static const struct refused {
    size_t in, out;
    unsigned components;
    struct vor_call call;
    float x;
    const char *name, *parameter;
} refused[] = {
    {0, 10, 0, {0}, 0, "target-out-of-range", "points"},
    {1, 1, 0, {0}, 0, "degenerate-cloud", ""},
    {N, 0, 0, {0}, 0, "target-out-of-range", "points"},
    {10, 1000, 0, {0}, 0, "target-out-of-range", "points"},
    {N, 10, 2, {0}, 0, "invalid-parameter", ""},
    {N, 10, 1, {0}, NAN, "non-finite-points", ""},
    {N, 10, 1, {.memory = 10000}, 0, "too-much-memory", ""},
    {N, 10, 1, {.parameters = no_word}, 0, "invalid-parameter", "method"},
    {N, 10, 1, {.parameters = no_value}, 0, "invalid-parameter", "seed"},
};

START_TEST(what_cannot_be_done_is_refused_by_name)
{
    const struct refused *row = &refused[_i];
    struct vor_points in = given(), out = wanted(0, row->out);
    struct vor_failure failure;

    in.n = row->in;
    out.components = row->components;
    cloud.xyz[4] += row->x;
    memset(spread, 0, sizeof spread);
    ck_assert_int_eq(vor_resample(&out, &in, &row->call, &failure), -1);
    ck_assert_str_eq(failure.name, row->name);
    ck_assert_str_eq(failure.parameter, row->parameter);
    ck_assert_str_ne(failure.message, "");
    ck_assert_mem_eq(spread[0], spread[1], sizeof spread[0]);
    ck_assert_ptr_null(vor_threads_start(0, &failure));
    ck_assert_str_eq(failure.name, "invalid-parameter");
    ck_assert_int_eq(vor_restore(&in, &(struct vor_call){.parameters = reference}, NULL), -1);
}
END_TEST

void vt_suite(Suite *suite)
{
    TCase *tcase = tcase_create("calls");

    tcase_set_timeout(tcase, 600);
    tcase_add_checked_fixture(tcase, make, unmake);
    tcase_add_test(tcase, results_are_even_with_the_values_around_them);
    tcase_add_test(tcase, a_call_says_how_far_it_is_and_ends_when_told);
    tcase_add_loop_test(tcase, what_cannot_be_done_is_refused_by_name, 0,
                        (int)(sizeof refused / sizeof refused[0]));
    suite_add_tcase(suite, tcase);
}
