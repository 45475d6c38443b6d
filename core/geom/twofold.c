#include "core/geom/twofold.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"
#include "core/geom/surface.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Searches run side by side, one in each lane of a vector: sides are found from LANES starts, and
 * the one is taken that leaves least. */
enum {
    COMMON = VOR_TWOFOLD_COMMON,
    APART = VOR_TWOFOLD_APART,
    MOST = VOR_TWOFOLD_MOST,
    LANES = 8,
    TIMES = 6 /* that sides and sheets are found in turn */
};

_Static_assert(MOST % LANES == 0, "sums over the points take whole vectors");

typedef float lanes __attribute__((vector_size(4 * LANES)));

/* Weight of a point: that of the place times how near it is, and that of the farthest. */
#define WEIGHT_REACH 0.9
#define WEIGHT_FAR 0.02
/* Least pivot of what determines h: where all points are on one side nothing does. */
#define PIVOT ((float)VOR_NEGLIGIBLE)

/* The terms are made orthonormal over the weighted points, so that q is one projection. Arrays by
 * points are as wide as a vector's multiple; what is past n is 0. */
struct work {
    unsigned n;
    float root[MOST];             /* of the weight of each point */
    float term[COMMON][MOST];     /* orthonormal, times the root of the weight */
    double raise[COMMON][COMMON]; /* term k of u, v over the orthonormal ones: lower triangle */
    float middle[COMMON];         /* q alone */
    double at[MOST][2];           /* u and v */
    float left[MOST];             /* what that leaves of each point's w, times the root */
    lanes side[MOST];
    lanes mixed[COMMON][APART]; /* sums over the points: side times two terms */
    lanes common[COMMON];       /* q, beyond the middle */
    lanes half[APART];          /* h */
    lanes left2;                /* what both leave, squared */
};

static void set_terms(float out[COMMON], double u, double v)
{
    const double term[COMMON] = {1,     u,         v,         u * u,     u * v,
                                 v * v, u * u * u, u * u * v, u * v * v, v * v * v};

    for (int k = 0; k < COMMON; k++)
        out[k] = (float)term[k];
}

/* In one order of sums for any width of vectors. */
VOR_INLINE float dot(const float *restrict a, const float *restrict b)
{
    float part[LANES] = {0}, sum = 0;

    for (unsigned i = 0; i < MOST; i += LANES)
        for (unsigned l = 0; l < LANES; l++)
            part[l] += a[i + l] * b[i + l];
    for (unsigned l = 0; l < LANES; l++)
        sum += part[l];
    return sum;
}

/* Gram-Schmidt. */
VOR_CLONES static int make_orthonormal(struct work *work)
{
    for (int k = 0; k < COMMON; k++) {
        float before = dot(work->term[k], work->term[k]), length;

        for (int j = 0; j < k; j++) {
            float along = dot(work->term[k], work->term[j]);

            for (unsigned i = 0; i < MOST; i++)
                work->term[k][i] -= along * work->term[j][i];
            work->raise[k][j] = (double)along;
        }
        length = dot(work->term[k], work->term[k]);
        if (!(length > (float)VOR_ROUNDED * before))
            return 0;
        length = sqrtf(length);
        for (unsigned i = 0; i < MOST; i++)
            work->term[k][i] /= length;
        work->raise[k][k] = (double)length;
    }
    for (int k = 0; k < COMMON; k++) {
        work->middle[k] = dot(work->left, work->term[k]);
        for (unsigned i = 0; i < MOST; i++)
            work->left[i] -= work->middle[k] * work->term[k][i];
    }
    return 1;
}

/* Sums over the points: the side times a term and each term of h. */
VOR_INLINE void sum_mixed(lanes out[APART], const struct work *work, const float *term)
{
    lanes sum[APART] = {{0}};

    for (unsigned i = 0; i < work->n; i++) {
        lanes one = work->side[i] * term[i];

        for (int m = 0; m < APART; m++)
            sum[m] += one * work->term[m][i];
    }
    memcpy(out, sum, sizeof sum);
}

/* The same for the terms of h among themselves: half of them, as a side is 1 or -1 and changes a
 * product of two terms by no rounding. */
VOR_INLINE void sum_apart(struct work *work)
{
    lanes sum[APART][APART] = {{{0}}};

    for (unsigned i = 0; i < work->n; i++)
        for (int k = 0; k < APART; k++) {
            lanes one = work->side[i] * work->term[k][i];

            for (int m = k; m < APART; m++)
                sum[k][m] += one * work->term[m][i];
        }
    for (int k = 0; k < APART; k++)
        for (int m = k; m < APART; m++)
            work->mixed[k][m] = work->mixed[m][k] = sum[k][m];
}

/* Solves for h by LDL^T what is left of q and h when q is eliminated. */
VOR_INLINE void solve(struct work *work)
{
    lanes a[APART][APART], pivot[APART] = {{0}};

    for (int m = 0; m < APART; m++)
        for (int j = 0; j <= m; j++) {
            lanes sum = {0};

            for (int k = 0; k < COMMON; k++)
                sum += work->mixed[k][m] * work->mixed[k][j];
            a[m][j] = (m == j ? 1.0F : 0.0F) - sum;
        }
    for (int m = 0; m < APART; m++) {
        for (int j = 0; j < m; j++) {
            lanes factor = a[m][j] / pivot[j];

            for (int k = m; k < APART; k++)
                a[k][m] -= factor * a[k][j];
            work->half[m] -= factor * work->half[j];
        }
        for (int l = 0; l < LANES; l++)
            pivot[m][l] = a[m][m][l] > PIVOT ? a[m][m][l] : PIVOT;
    }
    for (int m = APART - 1; m >= 0; m--) {
        for (int k = m + 1; k < APART; k++)
            work->half[m] -= a[k][m] * work->half[k];
        work->half[m] /= pivot[m];
    }
}

/* Fits both sheets to the points by their sides. */
VOR_CLONES static void fit(struct work *work)
{
    sum_apart(work);
    for (int k = APART; k < COMMON; k++)
        sum_mixed(work->mixed[k], work, work->term[k]);
    sum_mixed(work->half, work, work->left);
    solve(work);
    for (int k = 0; k < COMMON; k++) {
        lanes sum = {0};

        for (int m = 0; m < APART; m++)
            sum += work->mixed[k][m] * work->half[m];
        work->common[k] = -sum;
    }
}

/* Takes the side that is nearer to each point; sums the squares that are left. Returns whether a
 * point changed sides. */
VOR_CLONES static int take_sides(struct work *work)
{
    lanes left2 = {0}, changed = {0};
    int any = 0;

    for (unsigned i = 0; i < work->n; i++) {
        lanes above = {0}, half = {0}, side = {0}, off, step;

        above += work->left[i];
        for (int k = 0; k < COMMON; k++)
            above -= work->common[k] * work->term[k][i];
        for (int k = 0; k < APART; k++)
            half += work->half[k] * work->term[k][i];
        for (int l = 0; l < LANES; l++)
            side[l] = above[l] * half[l] >= 0 ? 1.0F : -1.0F;
        off = above - side * half;
        left2 += off * off;
        step = side - work->side[i];
        changed += step * step;
        work->side[i] = side;
    }
    work->left2 = left2;
    for (int l = 0; l < LANES; l++)
        any |= changed[l] > 0;
    return any;
}

/* Turns coefficients of n orthonormal terms into those of the terms. */
static void to_terms(double *out, const struct work *work, int n)
{
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            out[k] -= work->raise[j][k] * out[j];
        out[k] /= work->raise[k][k];
    }
}

/* The plane whose square is nearest to the squares of what q alone leaves: h, if that is one. */
static void find_plane(double plane[3], const struct work *work)
{
    double square[APART] = {0}, values[3], vectors[3][3];

    for (int k = 0; k < APART; k++)
        for (unsigned i = 0; i < work->n; i++)
            square[k] += (double)work->left[i] * (double)work->left[i] / (double)work->root[i] *
                         (double)work->term[k][i];
    to_terms(square, work, APART);
    vor_eigen3(values, vectors,
               (const double[6]){square[0], square[1] / 2, square[2] / 2, square[3], square[4] / 2,
                                 square[5]});
    memcpy(plane, vectors[2], 3 * sizeof *plane);
}

/* Sides to start from: signs of what q alone leaves; those times the plane of find_plane, and times
 * six directions, for sheets that cross there. Of 500 times two sheets over a disc, parallel /
 * crossing, not all points are told right: 26 / 9; with what the quadratic part of q alone leaves
 * in the place of one direction 11 / 8, but then 1.03 % of the triangles of arma2_120k to 40,000
 * are on two sheets for 0.83. */
static void start(struct work *work)
{
    static const double turn[LANES - 2][2] = {{1, 0}, {0.8660254, 0.5},  {0.5, 0.8660254},
                                              {0, 1}, {-0.5, 0.8660254}, {-0.8660254, 0.5}};
    double plane[3];

    find_plane(plane, work);
    for (unsigned i = 0; i < work->n; i++) {
        double u = work->at[i][0], v = work->at[i][1];

        for (int l = 0; l < LANES; l++) {
            double up = l == 0   ? 1
                        : l == 1 ? plane[0] + plane[1] * u + plane[2] * v
                                 : turn[l - 2][0] * u + turn[l - 2][1] * v;

            work->side[i][l] = up * (double)work->left[i] >= 0 ? 1 : -1;
        }
    }
}

/* Takes the frame: the place, and the directions along which the points spread around their mean.
 */
static int take_frame(struct vor_twofold *out, const float *near, unsigned n, const double x[3])
{
    double m[6] = {0}, mean[3] = {0}, values[3], axis[3][3], radius2 = 0;

    for (unsigned i = 0; i < n; i++) {
        double d[3], d2;

        for (int c = 0; c < 3; c++) {
            d[c] = (double)near[3 * i + c] - x[c];
            mean[c] += d[c] / n;
        }
        d2 = vor_dot(d, d);
        radius2 = d2 > radius2 ? d2 : radius2;
    }
    for (unsigned i = 0; i < n; i++) {
        double d[3];

        for (int c = 0; c < 3; c++)
            d[c] = (double)near[3 * i + c] - x[c] - mean[c];
        vor_add_square(m, d);
    }
    if (!(radius2 > 0))
        return 0;
    vor_eigen3(values, axis, m);
    for (int a = 0; a < 3; a++)
        memcpy(out->axis[a], axis[2 - a], sizeof out->axis[a]);
    memcpy(out->origin, x, sizeof out->origin);
    out->radius = sqrt(radius2);
    return 1;
}

static void to_local(double local[3], const struct vor_twofold *twofold, const double x[3])
{
    double d[3];

    for (int c = 0; c < 3; c++)
        d[c] = (x[c] - twofold->origin[c]) / twofold->radius;
    for (int a = 0; a < 3; a++)
        local[a] = vor_dot(d, twofold->axis[a]);
}

/* Sets the points in the frame, with their weights. */
static void set(struct work *work, const struct vor_twofold *frame, const float *near, unsigned n)
{
    memset(work, 0, sizeof *work);
    work->n = n;
    for (unsigned i = 0; i < n; i++) {
        double x[3] = {(double)near[3 * i], (double)near[3 * i + 1], (double)near[3 * i + 2]};
        double local[3], weight;
        float term[COMMON];

        to_local(local, frame, x);
        weight = fmax(1 - WEIGHT_REACH * vor_dot(local, local), 0);
        work->root[i] = (float)sqrt(weight * weight + WEIGHT_FAR);
        set_terms(term, local[0], local[1]);
        for (int k = 0; k < COMMON; k++)
            work->term[k][i] = term[k] * work->root[i];
        work->left[i] = (float)local[2] * work->root[i];
        work->at[i][0] = local[0];
        work->at[i][1] = local[1];
    }
}

/* Writes down what one lane found. */
static void take(struct vor_twofold *out, const struct work *work, int lane)
{
    double weights = 0;

    for (int k = 0; k < COMMON; k++)
        out->common[k] = (double)work->middle[k] + (double)work->common[k][lane];
    for (int k = 0; k < APART; k++)
        out->apart[k] = (double)work->half[k][lane];
    to_terms(out->common, work, COMMON);
    to_terms(out->apart, work, APART);
    for (unsigned i = 0; i < work->n; i++) {
        weights += (double)work->root[i] * (double)work->root[i];
        out->side[i] = work->side[i][lane] > 0 ? 1 : -1;
    }
    out->off = sqrt((double)work->left2[lane] / weights) * out->radius;
}

int vor_twofold_fit(struct vor_twofold *out, const float *near, unsigned n, const double x[3])
{
    struct vor_twofold found = {.radius = 0};
    struct work work;
    int best = 0;

    assert(n >= VOR_TWOFOLD_LEAST && n <= VOR_TWOFOLD_MOST);
    if (!take_frame(&found, near, n, x))
        return 0;
    set(&work, &found, near, n);
    if (!make_orthonormal(&work))
        return 0;
    start(&work);
    for (int time = 0; time < TIMES; time++) {
        fit(&work);
        if (!take_sides(&work))
            break;
    }
    for (int l = 1; l < LANES; l++)
        if (work.left2[l] < work.left2[best])
            best = l;
    take(&found, &work, best);
    *out = found;
    return 1;
}

double vor_twofold_above(const struct vor_twofold *twofold, const double x[3], double *half)
{
    double local[3], middle = 0, h = 0;
    float term[COMMON];

    to_local(local, twofold, x);
    set_terms(term, local[0], local[1]);
    for (int k = 0; k < COMMON; k++)
        middle += twofold->common[k] * (double)term[k];
    for (int k = 0; k < APART; k++)
        h += twofold->apart[k] * (double)term[k];
    *half = h * twofold->radius;
    return (local[2] - middle) * twofold->radius;
}
