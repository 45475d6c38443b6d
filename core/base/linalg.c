#include "core/base/linalg.h"

#include "core/base/vector.h"

#include <float.h>
#include <string.h>

/* Most sweeps of the Jacobi method, which converges quadratically: on 4,000 random 3 x 3
 * matrices it took 2 to 4. */
enum { SWEEPS_MAX = 12 };

/* Off-diagonal entries over the trace that count as 0: below the rounding of the diagonal. */
#define OFF_DIAGONAL 1e-16

/* Of the angle that makes {{p, q}, {q, r}} diagonal, q not 0; the numerically stable root. */
VOR_INLINE double tangent(double p, double q, double r)
{
    double theta = (r - p) / (2 * q);

    return (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
}

/* a^T M b. */
VOR_INLINE double square_form(const double m[6], const double a[3], const double b[3])
{
    return a[0] * (m[0] * b[0] + m[1] * b[1] + m[2] * b[2]) +
           a[1] * (m[1] * b[0] + m[3] * b[1] + m[4] * b[2]) +
           a[2] * (m[2] * b[0] + m[4] * b[1] + m[5] * b[2]);
}

/* Rotates so that a[p][q] becomes 0. */
VOR_INLINE void rotate(double a[3][3], double v[3][3], int p, int q)
{
    double t, c, s;

    if (a[p][q] == 0)
        return;
    t = tangent(a[p][p], a[p][q], a[q][q]);
    c = 1 / sqrt(t * t + 1);
    s = t * c;
    for (int k = 0; k < 3; k++) {
        double kp = a[k][p], kq = a[k][q];

        a[k][p] = c * kp - s * kq;
        a[k][q] = s * kp + c * kq;
    }
    for (int k = 0; k < 3; k++) {
        double pk = a[p][k], qk = a[q][k], vp = v[p][k], vq = v[q][k];

        a[p][k] = c * pk - s * qk;
        a[q][k] = s * pk + c * qk;
        v[p][k] = c * vp - s * vq;
        v[q][k] = s * vp + c * vq;
    }
    a[p][q] = a[q][p] = 0;
}

static void swap_rows(double values[3], double vectors[3][3], int i, int j)
{
    double value = values[i], row[3];

    values[i] = values[j];
    values[j] = value;
    memcpy(row, vectors[i], sizeof row);
    memcpy(vectors[i], vectors[j], sizeof row);
    memcpy(vectors[j], row, sizeof row);
}

void vor_eigen3(double values[3], double vectors[3][3], const double m[6])
{
    double a[3][3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}};
    double scale = fabs(m[0]) + fabs(m[3]) + fabs(m[5]);

    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            vectors[i][j] = i == j;
    for (int sweep = 0; sweep < SWEEPS_MAX; sweep++) {
        if (fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]) <= OFF_DIAGONAL * scale)
            break;
        rotate(a, vectors, 0, 1);
        rotate(a, vectors, 0, 2);
        rotate(a, vectors, 1, 2);
    }
    for (int i = 0; i < 3; i++)
        values[i] = a[i][i];
    if (values[1] < values[0])
        swap_rows(values, vectors, 0, 1);
    if (values[2] < values[1])
        swap_rows(values, vectors, 1, 2);
    if (values[1] < values[0])
        swap_rows(values, vectors, 0, 1);
    vor_cross(vectors[2], vectors[0], vectors[1]);
}

/* The least root of the characteristic polynomial of a matrix of trace 1 without negative roots, or
 * a negative number. Newton's steps come from below it and so never pass it: where it is a tenth of
 * the next root, five leave 1e-16. */
static double least_root(const double a[6])
{
    double xy = a[0] * a[3] - a[1] * a[1], xz = a[0] * a[5] - a[2] * a[2];
    double yz = a[3] * a[5] - a[4] * a[4], root = 0;
    double determinant =
        a[0] * yz - a[1] * (a[1] * a[5] - a[4] * a[2]) + a[2] * (a[1] * a[4] - a[3] * a[2]);

    for (int i = 0; i < SWEEPS_MAX; i++) {
        double value = ((root - 1) * root + xy + xz + yz) * root - determinant;
        double slope = (3 * root - 2) * root + xy + xz + yz;

        if (!(slope > 0))
            return -1;
        root -= value / slope;
        if (fabs(value) <= OFF_DIAGONAL * slope)
            break;
    }
    return root > 0 ? root : 0; /* below it by rounding */
}

/* Sets the unit vector of a root. Returns false where the product of its distances from the other
 * two is below 3e-4. */
static int vector_of(double vector[3], const double a[6], double root)
{
    double row[3][3] = {
        {a[0] - root, a[1], a[2]}, {a[1], a[3] - root, a[4]}, {a[2], a[4], a[5] - root}};
    double best2 = 0;

    for (int i = 0; i < 3; i++) {
        double cross[3], length2;

        vor_cross(cross, row[i], row[(i + 1) % 3]);
        length2 = vor_dot(cross, cross);
        if (length2 <= best2)
            continue;
        best2 = length2;
        memcpy(vector, cross, sizeof cross);
    }
    if (!(best2 > FLT_EPSILON))
        return 0;
    for (int c = 0; c < 3; c++)
        vector[c] /= sqrt(best2);
    return 1;
}

void vor_eigen3_flat(double values[3], double vectors[3][3], const double m[6])
{
    double trace = m[0] + m[3] + m[5], root = -1, *n = vectors[0];
    double a[6] = {0}; /* clang-analyzer cannot see that the loop sets all */
    double u[3], v[3], p, q, r, t = 0, c, s, k, sign;

    for (int i = 0; i < 6 && trace > 0; i++)
        a[i] = m[i] / trace;
    if (trace > 0)
        root = least_root(a);
    if (!(root >= 0) || !vector_of(n, a, root)) {
        vor_eigen3(values, vectors, m);
        return;
    }
    /* Two vectors across it (Duff et al. 2017, "Building an orthonormal basis, revisited"), turned
     * to the directions of the other two values as in a step of Jacobi's method. */
    sign = n[2] < 0 ? -1 : 1;
    k = -1 / (sign + n[2]);
    u[0] = 1 + sign * n[0] * n[0] * k;
    u[1] = v[0] = n[0] * n[1] * k;
    u[1] *= sign;
    u[2] = -sign * n[0];
    v[1] = sign + n[1] * n[1] * k;
    v[2] = -n[1];
    p = square_form(m, u, u);
    q = square_form(m, u, v);
    r = square_form(m, v, v);
    if (q < 0 || q > 0)
        t = tangent(p, q, r);
    c = 1 / sqrt(t * t + 1);
    s = t * c;
    values[0] = trace * root;
    values[1] = p - t * q;
    values[2] = r + t * q;
    for (int i = 0; i < 3; i++) {
        vectors[1][i] = c * u[i] - s * v[i];
        vectors[2][i] = s * u[i] + c * v[i];
    }
    if (values[2] < values[1])
        swap_rows(values, vectors, 1, 2);
    vor_cross(vectors[2], vectors[0], vectors[1]);
}

/* Inlined, so that the compiler knows n where that is usual. */
VOR_INLINE double solve_spd(double *a, double *b, int n, double rank)
{
    double smallest = 1;

#pragma GCC unroll 6
    for (int j = 0; j < n; j++) {
        double diagonal = a[j * n + j], pivot = diagonal;

        for (int k = 0; k < j; k++)
            pivot -= a[j * n + k] * a[j * n + k] * a[k * n + k];
        if (!(diagonal > 0) || !(pivot >= rank * diagonal) || !(pivot > 0))
            return 0;
        if (pivot < smallest * diagonal)
            smallest = pivot / diagonal;
        a[j * n + j] = pivot;
        for (int i = j + 1; i < n; i++) {
            double sum = a[i * n + j];

            for (int k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k] * a[k * n + k];
            a[i * n + j] = sum / pivot;
        }
    }
#pragma GCC unroll 6
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            b[i] -= a[i * n + k] * b[k];
#pragma GCC unroll 6
    for (int i = n - 1; i >= 0; i--) {
        b[i] /= a[i * n + i];
        for (int k = i + 1; k < n; k++)
            b[i] -= a[k * n + i] * b[k];
    }
    return smallest;
}

double vor_solve_spd(double *a, double *b, int n, double rank)
{
    return n == 6 ? solve_spd(a, b, 6, rank) : solve_spd(a, b, n, rank);
}

static void swap(double *a, double *b, size_t n)
{
    for (size_t j = 0; j < n; j++) {
        double held = a[j];

        a[j] = b[j];
        b[j] = held;
    }
}

int vor_solve_pivots(double *a, double *b, size_t n, size_t sides, double least, double rank)
{
    double largest = 0;

    for (size_t k = 0; k < n; k++) {
        size_t best = k;

        for (size_t i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k]))
                best = i;
        if (best != k) {
            swap(&a[k * n], &a[best * n], n);
            swap(&b[k * sides], &b[best * sides], sides);
        }
        largest = fmax(largest, fabs(a[k * n + k]));
        if (!(fabs(a[k * n + k]) > fmax(least, rank * largest)))
            return 0;
        /* Subtracts the pivot's row from those below it. */
        for (size_t i = k + 1; i < n; i++) {
            double factor = a[i * n + k] / a[k * n + k];

            if (factor == 0)
                continue;
            for (size_t j = k; j < n; j++)
                a[i * n + j] -= factor * a[k * n + j];
            for (size_t c = 0; c < sides; c++)
                b[i * sides + c] -= factor * b[k * sides + c];
        }
    }
    for (size_t k = n; k-- > 0;)
        for (size_t c = 0; c < sides; c++) {
            double sum = b[k * sides + c];

            for (size_t j = k + 1; j < n; j++)
                sum -= a[k * n + j] * b[j * sides + c];
            b[k * sides + c] = sum / a[k * n + k];
        }
    return 1;
}
