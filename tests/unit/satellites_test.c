/* Lists of neighbours by distances from three satellites. */
#include "core/base/linalg.h"
#include "core/input/adjacency.h"
#include "core/input/satellites.h"
#include "core/input/thin.h"
#include "tests/support/vt_lists.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 2, N = 8000, DENSE = 20000 };

/* Sheets are so many spacings apart. */
#define APART 3

static void start(struct vt_lists *lists, unsigned threads, int shape, int seed, size_t n,
                  double gap)
{
    vt_lists_start(lists, threads, shape, seed, n, gap);
    vt_assert_ok(vor_satellites_make(&lists->graph, &lists->domain, &lists->engine.run, &vt_err));
}

/* Lv 2022 Fig. 6 and Sec. 4.1: neighbours across sheets are rejected. Of white noise 3 spacings
 * from the next sheet, one pair in a thousand is not. */
static void expect_hardly_any_across(int shape, int seed)
{
    struct vt_lists bed;
    size_t pairs;

    start(&bed, 2, shape, seed, N, APART * vt_spacing(&vt_metrics[shape], N));
    pairs = vt_lists_across(&bed);
    ck_assert_msg(pairs <= N * VOR_ADJACENT / 1000, "%s: %zu pairs across", bed.metric->name,
                  pairs);
    vt_lists_end(&bed);
}

START_TEST(hardly_a_neighbour_lies_on_the_other_side_of_a_fold)
{
    expect_hardly_any_across(VT_FOLD, _i);
}
END_TEST

START_TEST(hardly_a_neighbour_lies_on_the_other_of_two_sheets)
{
    expect_hardly_any_across(VT_SHEETS, _i);
}
END_TEST

START_TEST(hardly_a_neighbour_lies_on_the_other_of_two_spheres)
{
    expect_hardly_any_across(VT_SPHERES, _i);
}
END_TEST

/* Its limit: three satellites lie on the rim, and a point has the distances of the one behind it.
 */
START_TEST(the_faces_of_a_closed_thin_plate_are_not_told_apart)
{
    struct vt_lists bed;

    start(&bed, 2, VT_PLATE, _i, DENSE, 0.02);
    ck_assert_uint_gt(vt_lists_across(&bed), DENSE * VOR_ADJACENT / 10);
    vt_lists_end(&bed);
}
END_TEST

/* The way along the lists from one point to all others, beyond ten spacings: within 3 % of the one
 * along the surface in the mean. */
START_TEST(the_way_along_the_lists_is_that_along_the_surface)
{
    static const int shapes[] = {VT_SQUARE, VT_BALL, VT_CYLINDER, VT_FOLD};

    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        struct vt_lists bed;
        struct vt_way way;

        start(&bed, 2, shapes[s], _i, N, APART * vt_spacing(&vt_metrics[shapes[s]], N));
        way = vt_lists_way(&bed, _i);
        ck_assert_msg(way.mean <= 0.03, "%s: off by %.2f %%", bed.metric->name, 100 * way.mean);
        vt_lists_end(&bed);
    }
}
END_TEST

START_TEST(lists_are_the_nearest_first_and_own_where_they_are_not_simply_the_nearest)
{
    uint32_t index[VOR_ADJACENT + 1];
    float distance2[VOR_ADJACENT + 1];
    size_t owns = 0;
    struct vt_lists bed;

    start(&bed, 2, VT_FOLD, _i, 5000, 0.02);
    for (size_t i = 0; i < bed.graph.n; i++) {
        const uint32_t *list = &bed.graph.list[i * bed.graph.most];
        const float *normal = &bed.graph.normal[3 * i];
        const float zero[3] = {0};
        int plain;

        vor_knn_search(bed.domain.knn, &bed.domain.xyz[3 * i], 1, VOR_ADJACENT + 1, index,
                       distance2);
        plain = bed.graph.count[i] == VOR_ADJACENT &&
                memcmp(&index[1], list, sizeof *list * VOR_ADJACENT) == 0;
        ck_assert_int_eq(bed.graph.own[i], !plain);
        owns += bed.graph.own[i];
        for (unsigned a = 0; a < bed.graph.count[i]; a++)
            ck_assert_uint_ne(list[a], i);
        for (unsigned a = 1; a < bed.graph.count[i]; a++)
            ck_assert(
                vor_distance2f(&bed.domain.xyz[3 * i], &bed.domain.xyz[3 * (size_t)list[a - 1]]) <=
                vor_distance2f(&bed.domain.xyz[3 * i], &bed.domain.xyz[3 * (size_t)list[a]]));
        ck_assert_double_eq_tol(vor_distance2f(normal, zero), 1, 1e-5);
    }
    ck_assert_uint_gt(owns, 0);
    vt_lists_end(&bed);
}
END_TEST

/* Components of too few points for coordinates have plain lists. */
START_TEST(five_points_have_each_other)
{
    struct vt_lists bed;

    start(&bed, 2, VT_BALL, _i, 5, 0);
    for (size_t i = 0; i < 5; i++) {
        ck_assert_uint_eq(bed.graph.count[i], 4);
        ck_assert_uint_eq(bed.graph.own[i], 0);
    }
    vt_lists_end(&bed);
}
END_TEST

START_TEST(one_two_three_and_eight_threads_make_the_same_lists)
{
    static const unsigned threads_of[4] = {1, 2, 3, 8};
    uint64_t first = 0;

    for (int t = 0; t < 4; t++) {
        struct vt_lists bed;
        uint64_t hash;

        start(&bed, threads_of[t], VT_SPHERES, 1, 4000, 0.1);
        hash = vt_lists_hash(&bed.graph) + vt_hash(bed.graph.own, bed.graph.n);
        first = t == 0 ? hash : first;
        ck_assert(hash == first);
        vt_lists_end(&bed);
    }
}
END_TEST

/* Between sheets 3 spacings apart: with satellites 18 points, without 118. */
START_TEST(a_run_with_satellites_leaves_fewer_points_between_sheets)
{
    static const char *const words[] = {"satellites", "none"};
    const double gap = 3 * sqrt(2. / 3000);
    size_t between[2] = {0};

    for (int w = 0; w < 2; w++) {
        struct vt_engine engine;
        struct vor_cloud in, out;
        struct vor_report report;

        vt_engine_open(&engine, 2);
        vt_cloud_sheets(&in, (uint64_t)_i, 3000, gap);
        vt_engine_count(&engine, "points", 1500);
        vt_engine_set(&engine, "iterations", "3");
        vt_engine_set(&engine, "polish", "4");
        vt_engine_set(&engine, "intrinsic", words[w]);
        vt_engine_resample(&engine, &out, &report, &in);
        for (size_t i = 0; i < out.n; i++) {
            double x[3];

            vor_cloud_position(&out, i, x);
            between[w] += fabs(x[2] - gap / 2) < 0.45 * gap;
        }
        vor_cloud_free(&out);
        vor_cloud_free(&in);
        vt_engine_close(&engine);
    }
    ck_assert_uint_gt(between[1], 50);
    ck_assert_uint_lt(between[0], between[1] / 3);
    vt_assert_no_leak();
}
END_TEST

/* The thinned domain of an input has lists of its own points. */
START_TEST(a_thinned_domain_has_lists_of_its_own)
{
    struct vor_domain thin;
    struct vt_lists bed;

    start(&bed, 2, VT_SHEETS, _i, N, 0.1);
    bed.domain.known.lists = VOR_LISTS_SATELLITES;
    vt_assert_ok(vor_domain_thin(&thin, &bed.domain, 0.02, &bed.engine.run, &vt_err));
    ck_assert_uint_gt(thin.n, 0);
    ck_assert_uint_eq(thin.graph.n, thin.n);
    for (size_t i = 0; i < thin.n; i++)
        for (unsigned a = 0; a < thin.graph.count[i]; a++)
            ck_assert_uint_lt(thin.graph.list[i * thin.graph.most + a], thin.n);
    vor_domain_free(&thin);
    vt_lists_end(&bed);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("satellites");

    vt_add_loop(suite, hardly_a_neighbour_lies_on_the_other_side_of_a_fold,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, hardly_a_neighbour_lies_on_the_other_of_two_sheets,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, hardly_a_neighbour_lies_on_the_other_of_two_spheres,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add(suite, the_faces_of_a_closed_thin_plate_are_not_told_apart);
    vt_add(suite, the_way_along_the_lists_is_that_along_the_surface);
    vt_add_loop(suite, lists_are_the_nearest_first_and_own_where_they_are_not_simply_the_nearest,
                SEEDS);
    vt_add(suite, five_points_have_each_other);
    vt_add(suite, one_two_three_and_eight_threads_make_the_same_lists);
    vt_add(suite, a_run_with_satellites_leaves_fewer_points_between_sheets);
    vt_add(suite, a_thinned_domain_has_lists_of_its_own);
    return vt_run(suite);
}
