/* Our L-BFGS against Okazaki's liblbfgs, which other people wrote from the same paper. */
#include "core/opt/lbfgs.h"
#include "tests/support/vt.h"

#include <lbfgs.h>
#include <math.h>
#include <string.h>

enum { N = 60, SEEDS = 8, STEPS = 3000 };

/* A function of N variables with one lowest point, and its gradient. */
typedef double (*curved)(const double *x, double *gradient);

/* Rosenbrock's valley, between pairs. */
static double valley(const double *x, double *gradient)
{
    double sum = 0;

    for (int i = 0; i < N; i += 2) {
        double a = 1 - x[i], b = x[i + 1] - x[i] * x[i];

        sum += a * a + 100 * b * b;
        gradient[i] = -2 * a - 400 * x[i] * b;
        gradient[i + 1] = 200 * b;
    }
    return sum;
}

/* Fourth powers of differences and squares, as a chain of springs that stiffen. */
static double chain(const double *x, double *gradient)
{
    double sum = 0;

    memset(gradient, 0, N * sizeof *gradient);
    for (int i = 0; i < N; i++) {
        double d = x[i] - (i > 0 ? x[i - 1] : 0) - 0.5, cube = d * d * d;

        sum += cube * d + 0.1 * x[i] * x[i];
        gradient[i] += 4 * cube + 0.2 * x[i];
        if (i > 0)
            gradient[i - 1] -= 4 * cube;
    }
    return sum;
}

/* Squares of very different weights, mixed. */
static double slope(const double *x, double *gradient)
{
    double sum = 0, all = 0;

    for (int i = 0; i < N; i++)
        all += (x[i] - 1) / N;
    for (int i = 0; i < N; i++) {
        double weight = pow(10, 4.0 * i / N), d = x[i] - 1;

        sum += weight * d * d / 2 + all * all / 2;
        gradient[i] = weight * d + all;
    }
    return sum;
}

struct asked {
    curved function;
    unsigned count, reached; /* evaluations; those until the value was below `enough` */
    double enough;
};

static vor_status ours(void *ctx, const double *x, double *value, double *gradient,
                       struct vor_error *err)
{
    struct asked *asked = ctx;

    (void)err;
    asked->count++;
    *value = asked->function(x, gradient);
    if (asked->reached == 0 && *value <= asked->enough)
        asked->reached = asked->count;
    return VOR_OK;
}

static lbfgsfloatval_t theirs(void *ctx, const lbfgsfloatval_t *x, lbfgsfloatval_t *gradient,
                              const int n, const lbfgsfloatval_t step)
{
    struct asked *asked = ctx;

    (void)n;
    (void)step;
    asked->count++;
    return asked->function(x, gradient);
}

static void begin(double *x, uint64_t seed)
{
    for (uint64_t i = 0; i < N; i++)
        x[i] = 4 * vt_unit(seed, i) - 2;
}

VT_TEST_LOOP(it_ends_where_liblbfgs_ends_in_about_as_many_evaluations, 3 * SEEDS)
{
    static const curved functions[3] = {valley, chain, slope};
    struct asked by_us = {.function = functions[_i % 3]}, by_them = by_us;
    struct vor_lbfgs_function function = {&by_us, ours, NULL, NULL};
    struct vor_lbfgs_told told;
    struct vor_lbfgs mine;
    lbfgs_parameter_t parameter;
    lbfgsfloatval_t value, *x = lbfgs_malloc(N);
    double y[N];

    begin(y, (uint64_t)_i);
    memcpy(x, y, sizeof y);
    lbfgs_parameter_init(&parameter);
    parameter.m = VOR_LBFGS_STEPS;
    parameter.epsilon = 1e-7;
    ck_assert_int_ge(lbfgs(N, x, &value, theirs, NULL, &by_them, &parameter), LBFGS_SUCCESS);

    by_us.enough = value + 1e-9 * (1 + fabs(value));
    vt_assert_ok(vor_lbfgs_init(&mine, N, &vt_memory, &vt_err));
    vt_assert_ok(vor_lbfgs_run(&mine, y, &function, STEPS, &told, &vt_err));
    ck_assert_double_eq_tol(told.after, value, 1e-9 * (1 + fabs(value)));
    for (int i = 0; i < N; i++)
        ck_assert_double_eq_tol(y[i], x[i], 1e-4);

    ck_assert_uint_gt(by_us.reached, 0);
    ck_assert_msg(by_us.reached <= by_them.count + by_them.count / 4, "%u, %u", by_us.reached,
                  by_them.count);
    vor_lbfgs_free(&mine);
    lbfgs_free(x);
}
