/* Symmetric eigenproblems and positive definite systems. */
#include "core/base/linalg.h"
#include "tests/support/vt.h"

#include <string.h>

enum { SEEDS = 60 };

static void assert_orthonormal(double vectors[3][3])
{
    double cross[3];

    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            ck_assert_double_eq_tol(vor_dot(vectors[i], vectors[j]), i == j, 1e-14);
    vor_cross(cross, vectors[0], vectors[1]);
    ck_assert_double_eq_tol(vor_dot(cross, vectors[2]), 1, 1e-14);
}

/* V^T D V against m, relative to its largest entry. */
static void assert_reconstructs(const double m[6], const double values[3], double vectors[3][3])
{
    static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
    double scale = 0;

    for (int e = 0; e < 6; e++)
        scale = fmax(scale, fabs(m[e]));
    for (int e = 0; e < 6; e++) {
        double sum = 0;

        for (int i = 0; i < 3; i++)
            sum += values[i] * vectors[i][row[e]] * vectors[i][column[e]];
        ck_assert_double_le(fabs(sum - m[e]), 1e-14 * scale);
    }
}

VT_TEST(a_diagonal_matrix_keeps_its_entries_and_axes)
{
    const double m[6] = {3, 0, 0, 1, 0, 2};
    double values[3], vectors[3][3];

    vor_eigen3(values, vectors, m);
    ck_assert(values[0] == 1 && values[1] == 2 && values[2] == 3);
    ck_assert(fabs(vectors[0][1]) == 1 && fabs(vectors[1][2]) == 1 && fabs(vectors[2][0]) == 1);
    assert_orthonormal(vectors);
}

VT_TEST(repeated_eigenvalues_have_orthonormal_vectors)
{
    static const double matrices[4][6] = {
        {0}, {7, 0, 0, 7, 0, 7}, {2, 1, 1, 2, 1, 2}, {2, -1, 0, 2, 0, 3}};
    static const double expected[4][3] = {{0, 0, 0}, {7, 7, 7}, {1, 1, 4}, {1, 3, 3}};
    double values[3], vectors[3][3];

    for (int k = 0; k < 4; k++) {
        vor_eigen3(values, vectors, matrices[k]);
        for (int i = 0; i < 3; i++)
            ck_assert_double_eq_tol(values[i], expected[k][i], 1e-14);
        assert_orthonormal(vectors);
        assert_reconstructs(matrices[k], values, vectors);
    }
}

VT_TEST_LOOP(eigenvectors_rebuild_the_matrix_at_every_scale, SEEDS)
{
    double m[6], values[3], vectors[3][3], scale = pow(10, 6 * (_i % 41) - 120);

    for (uint64_t e = 0; e < 6; e++)
        m[e] = scale * (2 * vt_unit((uint64_t)_i, e) - 1);
    vor_eigen3(values, vectors, m);
    ck_assert(values[0] <= values[1] && values[1] <= values[2]);
    assert_orthonormal(vectors);
    assert_reconstructs(m, values, vectors);
}

/* Moments of points off a plane, or a line, or of many sizes: the same as by Jacobi's method. */
VT_TEST_LOOP(moments_have_the_same_axes_both_ways, SEEDS)
{
    double m[6] = {0}, values[3], vectors[3][3], expected[3], axes[3][3];
    double off = pow(10, -(_i % 16)), wide = _i % 5 == 0 ? off : 1;

    for (uint64_t p = 0; p < 20 && _i > 0; p++) {
        double a = vt_unit(p, 1) - 0.5, b = wide * (vt_unit(p, 2) - 0.5), c = off * vt_unit(p, 3);

        vor_add_square(m, (double[3]){a + b, a - b + c, c + b});
    }
    vor_eigen3_flat(values, vectors, m);
    vor_eigen3(expected, axes, m);
    assert_orthonormal(vectors);
    for (int i = 0; i < 3; i++)
        ck_assert_double_le(fabs(values[i] - expected[i]), 1e-12 * expected[2]);
    if (expected[1] > 2 * expected[0] + 1e-2 * expected[2])
        ck_assert_double_le(1 - fabs(vor_dot(vectors[0], axes[0])), 1e-12);
}

/* A = B B^T / n + I / 10 and b = A x for a known x; what is above the diagonal must not be read. */
static void known_system(uint64_t seed, int n, double *a, double *b, double *x)
{
    double full[20][20], factor[20][20];

    for (int i = 0; i < n; i++) {
        x[i] = 2 * vt_unit(seed, 1000 + (uint64_t)i) - 1;
        for (int j = 0; j < n; j++)
            factor[i][j] = 2 * vt_unit(seed, (uint64_t)(20 * i + j)) - 1;
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            full[i][j] = i == j ? 0.1 : 0;
            for (int k = 0; k < n; k++)
                full[i][j] += factor[i][k] * factor[j][k] / n;
            a[i * n + j] = j <= i ? full[i][j] : NAN;
        }
    for (int i = 0; i < n; i++) {
        b[i] = 0;
        for (int j = 0; j < n; j++)
            b[i] += full[i][j] * x[j];
    }
}

VT_TEST_LOOP(a_system_of_1_to_20_has_its_known_solution, SEEDS)
{
    double a[400], b[20], x[20];

    for (int n = 1; n <= 20; n++) {
        known_system((uint64_t)_i, n, a, b, x);
        ck_assert_double_gt(vor_solve_spd(a, b, n, 1e-6), 0);
        for (int i = 0; i < n; i++)
            ck_assert_double_eq_tol(b[i], x[i], 1e-11);
    }
}

/* 1 1 / 1 1+e has pivots 1 and e: the measure is e / (1 + e). */
VT_TEST(the_measure_of_rank_is_the_smallest_relative_pivot)
{
    const double e = 0.25;
    double a[4] = {1, NAN, 1, 1 + e}, b[2] = {2, 2 + e};

    ck_assert_double_eq_tol(vor_solve_spd(a, b, 2, 0.1), e / (1 + e), 1e-15);
    ck_assert_double_eq_tol(b[0], 1, 1e-14);
    ck_assert_double_eq_tol(b[1], 1, 1e-14);
}

VT_TEST(a_system_below_the_rank_asked_for_is_refused_untouched)
{
    static const double systems[4][4] = {
        {1, NAN, 1, 1.25}, {1, NAN, 1, 1}, {0, NAN, 0, 1}, {1, NAN, 2, 1}};

    for (int k = 0; k < 4; k++) {
        double a[4], b[2] = {3, 5};

        memcpy(a, systems[k], sizeof a);
        ck_assert(vor_solve_spd(a, b, 2, 0.21) == 0);
        ck_assert(b[0] == 3 && b[1] == 5);
    }
}

VT_TEST(a_system_that_is_not_a_number_is_refused)
{
    double a[1] = {NAN}, b[1] = {1};

    ck_assert(vor_solve_spd(a, b, 1, 0) == 0);
    ck_assert(b[0] == 1);
}
