/* Two sheets that look alike, over one plane, told apart: made ones, at any place and scale. */
#include "core/geom/twofold.h"

#include "core/base/rng.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

enum { N = 62, PLACES = 5, SEEDS = 500 };

/* Two sheets over a disc of radius 1: they bend alike, and are 2 (at + slope u) apart. */
struct sheets {
    double at, slope, noise;
    double size;         /* everything times that */
    double turn, shift;  /* in the plane of x and z, and along y */
    float near[N][3];    /* points of both, in no order */
    signed char side[N]; /* of which each is */
    double half[N];      /* of their distance there */
};

static double bend(double u, double v)
{
    return 0.15 * u * u - 0.1 * u * v + 0.05 * v * v + 0.04 * u * u * v;
}

static void place(double x[3], const struct sheets *sheets, double u, double v, double w)
{
    x[0] = sheets->size * (u * cos(sheets->turn) - w * sin(sheets->turn));
    x[1] = sheets->size * (v + sheets->shift);
    x[2] = sheets->size * (u * sin(sheets->turn) + w * cos(sheets->turn));
}

static void make(struct sheets *sheets, uint64_t seed)
{
    for (uint64_t i = 0; i < N; i++) {
        double reach = sqrt(vor_rng_unit(seed, 1, i)), angle = 6.2831853 * vor_rng_unit(seed, 2, i);
        double u = reach * cos(angle), v = reach * sin(angle), x[3];

        sheets->half[i] = sheets->at + sheets->slope * u;
        sheets->side[i] = vor_rng_unit(seed, 3, i) < 0.5 ? 1 : -1;
        place(x, sheets, u, v,
              bend(u, v) + sheets->side[i] * sheets->half[i] +
                  sheets->noise * (2 * vor_rng_unit(seed, 4, i) - 1));
        for (int c = 0; c < 3; c++)
            sheets->near[i][c] = (float)x[c];
    }
}

static void fit(struct vor_twofold *two, const struct sheets *sheets)
{
    double x[3];

    place(x, sheets, 0, 0, 0);
    ck_assert(vor_twofold_fit(two, &sheets->near[0][0], N, x));
}

/* Points told wrong of those where the sheets are at least so far apart by half. */
static int wrong(const struct vor_twofold *two, const struct sheets *sheets, double least)
{
    int same = 0, all = 0;

    for (int i = 0; i < N; i++) {
        if (fabs(sheets->half[i]) < least)
            continue;
        same += two->side[i] == sheets->side[i];
        all++;
    }
    return same < all - same ? same : all - same;
}

/* How many of SEEDS made pairs of sheets, by turns with one of three distances at the place, have a
 * point told wrong where they are farther apart by half than `least`. From eight starts the best
 * sides are not always found. */
static int missed(const double at[3], double slope, double least)
{
    int count = 0;

    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        struct sheets sheets = {.at = at[seed % 3], .slope = slope, .size = 1};
        struct vor_twofold two;

        make(&sheets, seed);
        fit(&two, &sheets);
        count += wrong(&two, &sheets, least) > 0;
    }
    return count;
}

START_TEST(points_of_two_sheets_are_told_apart_however_near_these_are)
{
    ck_assert_int_le(missed((const double[]){0.001, 0.01, 0.1}, 0, 0), SEEDS / 10);
}
END_TEST

/* Sides are those of the sheets beyond the line as well: nothing but slopes tells that. */
START_TEST(sheets_that_cross_keep_their_sides_beyond_the_line)
{
    ck_assert_int_le(missed((const double[]){0, 0.01, 0.02}, 0.035, 0.002), SEEDS / 20);
}
END_TEST

START_TEST(height_and_distance_are_those_of_the_sheets_at_any_scale_and_place)
{
    static const double sizes[] = {1e-6, 1, 1e6};
    struct vor_twofold two;

    for (int s = 0; s < 3; s++) {
        struct sheets sheets = {
            .at = 0.03, .slope = 0.01, .size = sizes[s], .turn = 0.5 * _i, .shift = 3};
        double sign = 0;

        make(&sheets, (uint64_t)_i);
        fit(&two, &sheets);
        ck_assert_int_eq(wrong(&two, &sheets, 0), 0);
        for (int k = 0; k < PLACES; k++) {
            double u = 0.4 * cos(k), v = 0.4 * sin(k), want = 0.03 + 0.01 * u, x[3], above, half;

            place(x, &sheets, u, v, bend(u, v) + want);
            above = vor_twofold_above(&two, x, &half) / sheets.size;
            sign = k == 0 ? (above > 0 ? 1 : -1) : sign;
            ck_assert_double_eq_tol(sign * above, want, 3e-3);
            ck_assert_double_eq_tol(fabs(half) / sheets.size, want, 3e-3);
        }
        ck_assert_double_lt(two.off, 3e-3 * sheets.size);
    }
}
END_TEST

/* Squares that a point is off its sheet, summed with the weights that fits use. */
static double left2(const struct vor_twofold *two, const struct sheets *sheets)
{
    double sum = 0, weights = 0;

    for (int i = 0; i < N; i++) {
        double x[3], half, above, r2 = 0, weight;

        for (int c = 0; c < 3; c++) {
            x[c] = (double)sheets->near[i][c];
            r2 += (x[c] - two->origin[c]) * (x[c] - two->origin[c]);
        }
        weight = fmax(1 - 0.9 * r2 / (two->radius * two->radius), 0);
        weight = weight * weight + 0.02;
        above = vor_twofold_above(two, x, &half);
        sum += weight * (above - two->side[i] * half) * (above - two->side[i] * half);
        weights += weight;
    }
    return sum / weights;
}

START_TEST(each_point_is_on_its_nearer_sheet_and_no_other_sheets_leave_less)
{
    struct sheets sheets = {.at = 0.02, .slope = 0.03, .noise = 0.01, .size = 1};
    struct vor_twofold two, other;
    double least;
    int moved = 0;

    make(&sheets, (uint64_t)_i);
    fit(&two, &sheets);
    least = left2(&two, &sheets);
    ck_assert_double_eq_tol(sqrt(least), two.off, 1e-6);
    for (int i = 0; i < N; i++) {
        double x[3] = {(double)sheets.near[i][0], (double)sheets.near[i][1],
                       (double)sheets.near[i][2]};
        double half, above = vor_twofold_above(&two, x, &half);

        moved += fabs(above * half) > 1e-7 && two.side[i] != (above * half > 0 ? 1 : -1);
    }
    ck_assert_int_eq(moved, 0);
    for (int k = 0; k < VOR_TWOFOLD_COMMON + VOR_TWOFOLD_APART; k++)
        for (int sign = -1; sign <= 1; sign += 2) {
            double *c =
                k < VOR_TWOFOLD_COMMON ? &other.common[k] : &other.apart[k - VOR_TWOFOLD_COMMON];

            other = two;
            *c += sign * 0.02;
            ck_assert_double_gt(left2(&other, &sheets), least);
        }
}
END_TEST

/* One sheet with noise: what parts the two that are fitted is that noise. */
START_TEST(over_one_sheet_two_are_no_farther_apart_than_it_is_noisy)
{
    struct sheets sheets = {.noise = 0.01, .size = 1};
    struct vor_twofold two;

    make(&sheets, (uint64_t)_i);
    fit(&two, &sheets);
    for (int i = 0; i < N; i++) {
        double x[3] = {(double)sheets.near[i][0], (double)sheets.near[i][1],
                       (double)sheets.near[i][2]};
        double half;

        (void)vor_twofold_above(&two, x, &half);
        ck_assert_double_lt(fabs(half), 0.03);
    }
}
END_TEST

START_TEST(points_on_a_curve_or_at_one_place_determine_none)
{
    struct vor_twofold two, before;
    float near[N][3] = {{0}};
    const double x[3] = {0, 0, 0};

    memset(&two, 77, sizeof two);
    before = two;
    ck_assert(!vor_twofold_fit(&two, &near[0][0], N, x));
    for (int i = 0; i < N; i++)
        near[i][0] = (float)(i - N / 2);
    ck_assert(!vor_twofold_fit(&two, &near[0][0], N, x));
    for (int i = 0; i < N; i++)
        near[i][1] = near[i][0] * near[i][0] / N;
    ck_assert(!vor_twofold_fit(&two, &near[0][0], N, x));
    ck_assert_mem_eq(&two, &before, sizeof two);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("twofold");

    vt_add(suite, points_of_two_sheets_are_told_apart_however_near_these_are);
    vt_add(suite, sheets_that_cross_keep_their_sides_beyond_the_line);
    vt_add_loop(suite, height_and_distance_are_those_of_the_sheets_at_any_scale_and_place, 10);
    vt_add_loop(suite, each_point_is_on_its_nearer_sheet_and_no_other_sheets_leave_less, 10);
    vt_add_loop(suite, over_one_sheet_two_are_no_farther_apart_than_it_is_noisy, 20);
    vt_add(suite, points_on_a_curve_or_at_one_place_determine_none);
    return vt_run(suite);
}
