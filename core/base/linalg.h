/** Small dense linear algebra in double precision: vectors of three, symmetric 3 x 3 eigenproblems,
 *  systems of equations. No allocation, no failure but what is returned. */
#ifndef VOR_BASE_LINALG_H
#define VOR_BASE_LINALG_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/** Share of a length below which it may be the rounding of positions to float32, 6e-8 of their
 *  extent; the least pivot of fits; and the least ratio of the variances of points across and along
 *  a line, whose width is then a thousandth of its length. As the last two, 1e-8 and 1e-4 change
 *  nothing on kitti, autzen, bunny and shell; at 1e-3 one crease in a thousand differs. */
#define VOR_ROUNDED 1e-6
/** The same of a square, or of a sum in double. */
#define VOR_ROUNDED2 (VOR_ROUNDED * VOR_ROUNDED)

/** Scalar product. */
static inline double vor_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** The same of floats. */
static inline double vor_dotf(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

/** x^n by squaring: its bits do not differ between machines, as those of pow do. O(log n). */
static inline double vor_power(double x, unsigned n)
{
    double y = 1;

    for (; n > 0; n >>= 1) {
        if (n & 1)
            y *= x;
        x *= x;
    }
    return y;
}

/** Takes from v its part along a unit vector; with one_way only if v points that way. */
static inline void vor_remove_along(double v[3], const double direction[3], int one_way)
{
    double along = vor_dot(v, direction);

    if (one_way && !(along > 0))
        return;
    for (int c = 0; c < 3; c++)
        v[c] -= along * direction[c];
}

/** Cross product; out is neither a nor b. */
static inline void vor_cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/** The way from one point to another. */
static inline void vor_way(double out[3], const float from[3], const float to[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = (double)to[c] - (double)from[c];
}

/** Adds d d^T to the upper triangle m of a symmetric matrix: xx xy xz yy yz zz. */
static inline void vor_add_square(double m[6], const double d[3])
{
    m[0] += d[0] * d[0];
    m[1] += d[0] * d[1];
    m[2] += d[0] * d[2];
    m[3] += d[1] * d[1];
    m[4] += d[1] * d[2];
    m[5] += d[2] * d[2];
}

/** A vector of doubles in single precision, and one the other way. */
static inline void vor_to_floats(float out[3], const double x[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = (float)x[c];
}

static inline void vor_to_doubles(double out[3], const float x[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = (double)x[c];
}

/** Copies the points index[0 .. k - 1] of xyz to out, k x 3 floats. */
static inline void vor_gather(float *out, const float *xyz, const uint32_t *index, size_t k)
{
    for (size_t j = 0; j < k; j++)
        memcpy(&out[3 * j], &xyz[3 * (size_t)index[j]], 3 * sizeof *out);
}

/** Squared distance of two points, in double precision. */
static inline double vor_distance2f(const float a[3], const float b[3])
{
    double x = (double)a[0] - (double)b[0], y = (double)a[1] - (double)b[1],
           z = (double)a[2] - (double)b[2];

    return x * x + y * y + z * z;
}

static inline double vor_distance2(const double a[3], const double b[3])
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return vor_dot(d, d);
}

/** Computes the eigenvalues, ascending, and unit eigenvectors (rows of `vectors`, right-handed) of
 *  a symmetric matrix with upper triangle m = {xx, xy, xz, yy, yz, zz}. Cyclic Jacobi method; exact
 *  zeros stay zero. It uses no function whose bits differ between machines. Cannot fail; O(1). */
void vor_eigen3(double values[3], double vectors[3][3], const double m[6]);

/** vor_eigen3 for second moments of points near a plane, in less than half the time: the smallest
 * value is found by itself, as the least root of the characteristic polynomial. Values are off by
 * up to 1e-12 of the largest. Where the smallest is not clearly apart from the others, this is
 * vor_eigen3.
 */
void vor_eigen3_flat(double values[3], double vectors[3][3], const double m[6]);

/** Solves A x = b for symmetric positive definite A by LDL^T in place.
 *
 *  @param[in,out] a     n x n, row-major; only the lower triangle is read; destroyed
 *  @param[in,out] b     n; becomes x on success, else unchanged
 *  @param[in]     rank  smallest pivot over its diagonal entry that is allowed
 *
 *  @return the smallest pivot over its diagonal entry, a measure of rank in (0, 1]; 0 if one is
 *          below `rank` or not positive
 *
 *  O(n^3). */
double vor_solve_spd(double *a, double *b, int n, double rank);

/** Solves A x = b for each of `sides` right sides, by elimination with pivots from columns.
 *
 *  @param[in,out] a      n x n, row-major; destroyed
 *  @param[in,out] b      n x sides; becomes the solutions on success
 *  @param[in]     least  a pivot must exceed it,
 *  @param[in]     rank   and this share of the largest pivot before it: else A is as good as
 * singular
 *
 *  @return whether there is a solution
 *
 *  O(n^3). */
int vor_solve_pivots(double *a, double *b, size_t n, size_t sides, double least, double rank);

#endif
