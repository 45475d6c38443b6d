/* Anderson acceleration (Xiao 2024 Sec. IV-C, Eq. 7 to 11; row X10). */
#include "core/opt/anderson.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { N = 30, SEEDS = 10 };

/* G(y) = A y + b with the eigenvalues of A between 0 and 0.97, as conditions of a slow Lloyd; one
 * Householder reflection mixes the axes. */
struct contraction {
    double rate[N], mirror[N], fixed[N];
};

static void make(struct contraction *g, uint64_t seed)
{
    for (uint64_t i = 0; i < N; i++) {
        g->rate[i] = 0.97 * vt_unit(seed, i);
        g->mirror[i] = 2 * vt_unit(seed, 100 + i) - 1;
        g->fixed[i] = 2 * vt_unit(seed, 200 + i) - 1;
    }
    g->rate[0] = 0.97;
}

static void apply(const struct contraction *g, const float *y, float *out)
{
    double x[N];

    for (int i = 0; i < N; i++)
        x[i] = (double)y[i] - g->fixed[i];
    vt_reflect(x, g->mirror, N);
    for (int i = 0; i < N; i++)
        x[i] *= g->rate[i];
    vt_reflect(x, g->mirror, N);
    for (int i = 0; i < N; i++)
        out[i] = (float)(x[i] + g->fixed[i]);
}

static double error_of(const struct contraction *g, const float *y)
{
    double sum = 0;

    for (int i = 0; i < N; i++)
        sum += pow((double)y[i] - g->fixed[i], 2);
    return sqrt(sum);
}

static double weight_sum(const struct vor_anderson *a)
{
    double sum = 0;

    for (unsigned j = 0; j < a->depth; j++)
        sum += a->weight[j];
    return sum;
}

static void mix(const struct vor_anderson *a, float *y)
{
    for (size_t i = 0; i < a->length; i++) {
        double sum = 0;

        for (unsigned j = 0; j < a->depth; j++)
            sum += a->weight[j] * (double)a->image[j][i];
        y[i] = (float)sum;
    }
}

/* Iterations until the error is below 1e-3; window 0 is the plain iteration. */
static int iterations_to_converge(const struct contraction *g, unsigned window)
{
    struct vt_engine engine;
    struct vor_anderson a = {0};
    float y[N] = {0}, image[N];
    int done = 0;

    vt_engine_open(&engine, 1);
    if (window > 0)
        vt_assert_ok(vor_anderson_init(&a, N, window, &vt_memory, &vt_err));
    for (; done < 1000 && error_of(g, y) > 1e-3; done++) {
        apply(g, y, image);
        if (window > 0) {
            vt_assert_ok(vor_anderson_push(&a, y, image, &engine.run, &vt_err));
            ck_assert_double_eq_tol(weight_sum(&a), 1, 1e-9);
            mix(&a, y);
        } else {
            memcpy(y, image, sizeof y);
        }
    }
    if (window > 0)
        vor_anderson_free(&a);
    vt_engine_close(&engine);
    vt_assert_no_leak();
    return done;
}

VT_TEST_LOOP(a_linear_contraction_converges_in_less_than_half_the_iterations, SEEDS)
{
    struct contraction g;
    int plain, four, eight;

    make(&g, (uint64_t)_i);
    plain = iterations_to_converge(&g, 0);
    four = iterations_to_converge(&g, 4);
    eight = iterations_to_converge(&g, 8);
    ck_assert_int_gt(plain, 100);
    ck_assert_int_lt(four, plain / 2);
    ck_assert_int_lt(eight, plain / 3);
}

/* |sum alpha_j D_j|, all residuals in double. */
static double mixed_residual(const struct vor_anderson *a, const double *weight)
{
    double square = 0;

    for (size_t i = 0; i < a->length; i++) {
        double sum = 0;

        for (unsigned j = 0; j < a->depth; j++)
            sum += weight[j] * (double)a->residual[j][i];
        square += sum * sum;
    }
    return sqrt(square);
}

static void push_random(struct vor_anderson *a, const struct vor_run *run, uint64_t seed, size_t n)
{
    float *y = vor_malloc(&vt_memory, n, 2 * sizeof *y), *g = y + n;

    for (size_t i = 0; i < n; i++) {
        y[i] = (float)vt_unit(seed, 2 * i);
        g[i] = y[i] + (float)(vt_unit(seed, 2 * i + 1) - 0.4);
    }
    vt_assert_ok(vor_anderson_push(a, y, g, run, &vt_err));
    vor_free(&vt_memory, y);
}

/* Eq. 10: no weights that sum to one leave less; tried along every direction between two of them.
 */
VT_TEST_LOOP(the_weights_minimise_the_mixed_residual, SEEDS)
{
    struct vt_engine engine;
    struct vor_anderson a;

    vt_engine_open(&engine, 1);
    vt_assert_ok(vor_anderson_init(&a, N, 4, &vt_memory, &vt_err));
    for (uint64_t push = 0; push < 9; push++) {
        double least;

        push_random(&a, &engine.run, 100 * (uint64_t)_i + push, N);
        ck_assert_uint_eq(a.depth, push < 4 ? push + 1 : 5);
        ck_assert_double_eq_tol(weight_sum(&a), 1, 1e-9);
        least = mixed_residual(&a, a.weight);
        for (unsigned j = 0; j < a.depth; j++)
            for (unsigned k = 0; k < a.depth; k++) {
                double other[VOR_ANDERSON_MAX + 1];

                memcpy(other, a.weight, sizeof other);
                other[j] += 1e-3;
                other[k] -= 1e-3;
                ck_assert_double_ge(mixed_residual(&a, other), least * (1 - 1e-9));
            }
    }
    vor_anderson_free(&a);
    vt_engine_close(&engine);
}

VT_TEST(equal_and_vanishing_residuals_leave_finite_weights)
{
    struct vt_engine engine;
    struct vor_anderson a;
    const float zero[3] = {0}, one[3] = {1, 2, 3};

    vt_engine_open(&engine, 1);
    for (int k = 0; k < 2; k++) {
        const float *g = k == 0 ? one : zero;

        vt_assert_ok(vor_anderson_init(&a, 3, 4, &vt_memory, &vt_err));
        for (int push = 0; push < 7; push++) {
            vt_assert_ok(vor_anderson_push(&a, zero, g, &engine.run, &vt_err));
            ck_assert_double_eq_tol(weight_sum(&a), 1, 1e-9);
            for (unsigned j = 0; j < a.depth; j++)
                ck_assert(isfinite(a.weight[j]) && fabs(a.weight[j]) <= 1.001);
        }
        ck_assert(k == 0 || a.weight[a.newest] == 1);
        vor_anderson_free(&a);
    }
    vt_engine_close(&engine);
}
