/* Limited-memory BFGS (Chen 2018, Sec. 4.3.3; row C8). */
#include "core/opt/lbfgs.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

enum { N = 40, SEEDS = 10 };

/* sum of rate[i] (x[i] - least[i])^2 / 2, with the axes mixed by one reflection. */
struct bowl {
    double rate[N], least[N], mirror[N];
    double lowest, highest; /* places asked about, along the first variable */
    unsigned asked, fail_at;
    double hole; /* the value is NaN where the first variable is above it */
};

static void make(struct bowl *bowl, uint64_t seed, double condition)
{
    *bowl = (struct bowl){.lowest = INFINITY, .highest = -INFINITY, .hole = INFINITY};
    for (uint64_t i = 0; i < N; i++) {
        bowl->rate[i] = pow(condition, vt_unit(seed, i));
        bowl->least[i] = 4 * vt_unit(seed, 100 + i) - 2;
        bowl->mirror[i] = 2 * vt_unit(seed, 200 + i) - 1;
    }
}

static vor_status at_bowl(void *ctx, const double *x, double *value, double *gradient,
                          struct vor_error *err)
{
    struct bowl *bowl = ctx;
    double d[N];

    if (++bowl->asked == bowl->fail_at)
        return vor_fail(err, VOR_E_CANCELLED, "no more");
    bowl->lowest = fmin(bowl->lowest, x[0]);
    bowl->highest = fmax(bowl->highest, x[0]);
    for (int i = 0; i < N; i++)
        d[i] = x[i] - bowl->least[i];
    vt_reflect(d, bowl->mirror, N);
    *value = 0;
    for (int i = 0; i < N; i++) {
        *value += bowl->rate[i] * d[i] * d[i] / 2;
        d[i] *= bowl->rate[i];
    }
    vt_reflect(d, bowl->mirror, N);
    memcpy(gradient, d, sizeof d);
    if (x[0] > bowl->hole)
        *value = NAN;
    return VOR_OK;
}

static double error_of(const struct bowl *bowl, const double *x)
{
    double sum = 0;

    for (int i = 0; i < N; i++)
        sum += (x[i] - bowl->least[i]) * (x[i] - bowl->least[i]);
    return sqrt(sum);
}

static struct vor_lbfgs_told run(struct bowl *bowl, double *x, unsigned steps)
{
    struct vor_lbfgs_function function = {bowl, at_bowl, NULL, NULL};
    struct vor_lbfgs_told told;
    struct vor_lbfgs lbfgs;

    vt_assert_ok(vor_lbfgs_init(&lbfgs, N, &vt_memory, &vt_err));
    vt_assert_ok(vor_lbfgs_run(&lbfgs, x, &function, steps, &told, &vt_err));
    vor_lbfgs_free(&lbfgs);
    vt_assert_no_leak();
    return told;
}

VT_TEST_LOOP(a_stretched_bowl_is_descended_to_its_lowest_point, SEEDS)
{
    struct bowl bowl;
    double x[N] = {0};
    struct vor_lbfgs_told told;

    make(&bowl, (uint64_t)_i, 1000);
    told = run(&bowl, x, 500);
    ck_assert_double_le(error_of(&bowl, x), 1e-6);
    ck_assert_uint_eq(told.evaluations, bowl.asked);
    ck_assert_uint_le(told.evaluations, 2 * told.steps + 30); /* mostly one for each step */
}

VT_TEST_LOOP(a_known_bend_makes_the_first_step_the_last, SEEDS)
{
    struct bowl bowl;
    double x[N] = {0};
    struct vor_lbfgs_function function = {&bowl, at_bowl, NULL, bowl.rate};
    struct vor_lbfgs_told told;
    struct vor_lbfgs lbfgs;

    make(&bowl, (uint64_t)_i, 1000);
    memset(bowl.mirror, 0, sizeof bowl.mirror);
    vt_assert_ok(vor_lbfgs_init(&lbfgs, N, &vt_memory, &vt_err));
    vt_assert_ok(vor_lbfgs_run(&lbfgs, x, &function, 1, &told, &vt_err));
    ck_assert_uint_eq(told.evaluations, 2);
    ck_assert_double_le(error_of(&bowl, x), 1e-12);
    vor_lbfgs_free(&lbfgs);
}

/* No variable may leave -1 .. 1. */
static void stay_within_one(void *ctx, const double *x, double *step)
{
    (void)ctx;
    for (int i = 0; i < N; i++) {
        double most = step[i] > 0 ? 1 - x[i] : step[i] < 0 ? -1 - x[i] : 0;

        if (fabs(step[i]) > fabs(most))
            step[i] = most;
    }
}

VT_TEST_LOOP(a_function_that_shortens_steps_is_asked_nowhere_else, SEEDS)
{
    struct bowl bowl;
    double x[N] = {0};
    struct vor_lbfgs_function function = {&bowl, at_bowl, stay_within_one, NULL};
    struct vor_lbfgs_told told;
    struct vor_lbfgs lbfgs;

    make(&bowl, (uint64_t)_i, 100);
    bowl.least[0] = 3;
    vt_assert_ok(vor_lbfgs_init(&lbfgs, N, &vt_memory, &vt_err));
    vt_assert_ok(vor_lbfgs_run(&lbfgs, x, &function, 100, &told, &vt_err));
    ck_assert_double_le(bowl.highest, 1 + 1e-12);
    ck_assert_double_ge(bowl.lowest, -1 - 1e-12);
    ck_assert_double_gt(x[0], 0.5);
    ck_assert_double_lt(told.after, told.before);
    vor_lbfgs_free(&lbfgs);
}

VT_TEST_LOOP(a_value_that_is_no_number_is_stepped_back_from, SEEDS)
{
    struct bowl bowl;
    double x[N] = {0};

    make(&bowl, (uint64_t)_i, 100);
    bowl.least[0] = 3;
    bowl.hole = 1;
    (void)run(&bowl, x, 20);
    ck_assert_double_gt(bowl.highest, 1);
    ck_assert_double_le(x[0], 1);
    for (int i = 0; i < N; i++)
        ck_assert(isfinite(x[i]));
}

VT_TEST_LOOP(a_failure_is_handed_on_at_the_last_place_taken, SEEDS)
{
    struct bowl bowl;
    struct vor_lbfgs_function function = {&bowl, at_bowl, NULL, NULL};
    struct vor_lbfgs_told told;
    struct vor_lbfgs lbfgs;
    double x[N] = {0}, gradient[N], value;

    make(&bowl, 2, 100);
    bowl.fail_at = 1 + (unsigned)_i;
    vt_assert_ok(vor_lbfgs_init(&lbfgs, N, &vt_memory, &vt_err));
    vt_assert_fails(VOR_E_CANCELLED, vor_lbfgs_run(&lbfgs, x, &function, 50, &told, &vt_err));
    vor_lbfgs_free(&lbfgs);
    if (_i > 0) { /* else it was never measured */
        vt_assert_ok(at_bowl(&bowl, x, &value, gradient, &vt_err));
        ck_assert(value == told.after);
    }
}
