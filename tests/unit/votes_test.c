/* What two sheets fitted together say of pairs of points: two that bend, nearer to each other than
 * their spacing. */
#include "core/input/adjacency.h"
#include "core/input/grow.h"
#include "core/input/votes.h"
#include "tests/support/vt_lists.h"

#include <math.h>

enum { N = 2500, HEARD = 40 };

#define WAVES 16.0 /* to a side */
#define SURE 4.6   /* log odds of 99 % */

static void start(struct vt_lists *bed, struct vor_votes *votes, unsigned threads, int seed)
{
    vt_lists_start_waves(bed, threads, seed, N, WAVES);
    vt_assert_ok(vor_grow(&bed->graph, &bed->domain, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_votes_make(votes, &bed->domain, &bed->graph, &bed->engine.run, &vt_err));
}

static void hear(double odds[HEARD], uint32_t index[HEARD], const struct vt_lists *bed,
                 const struct vor_votes *votes, uint32_t i)
{
    float distance2[HEARD];

    vor_knn_search(bed->domain.knn, &bed->domain.xyz[3 * (size_t)i], 1, HEARD, index, distance2);
    vor_votes_hear(odds, votes, i, index, HEARD);
}

START_TEST(pairs_that_votes_are_sure_of_are_told_right)
{
    struct vt_lists bed;
    struct vor_votes votes;
    const uint32_t *source;
    size_t sure = 0, wrong = 0;

    start(&bed, &votes, 2, _i);
    source = bed.domain.source;
    for (uint32_t i = 0; i < N; i++) {
        double odds[HEARD];
        uint32_t index[HEARD];

        hear(odds, index, &bed, &votes, i);
        for (int e = 0; e < HEARD; e++) {
            if (index[e] == i || fabs(odds[e]) < SURE)
                continue;
            sure++;
            wrong += (odds[e] > 0) != (((source[index[e]] ^ source[i]) & 1) == 0);
        }
    }
    ck_assert_uint_gt(sure, 10 * N);
    ck_assert_msg(1000 * wrong < 2 * sure, "%zu of %zu pairs are wrong", wrong, sure);
    vor_votes_free(&votes);
    vt_lists_end(&bed);
}
END_TEST

START_TEST(sure_pairs_are_told_alike_from_both_ends)
{
    struct vt_lists bed;
    struct vor_votes votes;
    size_t both = 0, alike = 0;

    start(&bed, &votes, 2, _i);
    for (uint32_t i = 0; i < N; i += 7) {
        double there[HEARD], back[HEARD];
        uint32_t index[HEARD], other[HEARD];

        hear(there, index, &bed, &votes, i);
        for (int e = 0; e < HEARD; e++) {
            hear(back, other, &bed, &votes, index[e]);
            for (int f = 0; f < HEARD; f++) {
                if (other[f] != i || fabs(there[e]) < SURE || fabs(back[f]) < SURE)
                    continue;
                both++;
                alike += (there[e] > 0) == (back[f] > 0);
            }
        }
    }
    ck_assert_uint_gt(both, N);
    ck_assert_uint_eq(alike, both);
    vor_votes_free(&votes);
    vt_lists_end(&bed);
}
END_TEST

START_TEST(one_and_three_threads_make_the_same_votes)
{
    uint64_t first = 0;

    for (unsigned threads = 1; threads <= 3; threads += 2) {
        struct vt_lists bed;
        struct vor_votes votes;
        uint64_t hash = 0;

        start(&bed, &votes, threads, 1);
        for (size_t i = 0; i < N; i++)
            hash = 31 * hash + vt_hash(votes.of[i].member, sizeof votes.of[i].member) +
                   vt_hash(votes.of[i].says, sizeof votes.of[i].says);
        first = threads == 1 ? hash : first;
        ck_assert_msg(hash == first, "%u threads make other votes", threads);
        vor_votes_free(&votes);
        vt_lists_end(&bed);
    }
}
END_TEST

START_TEST(nothing_is_said_where_lists_are_of_one_sheet)
{
    struct vt_lists bed;
    struct vor_votes votes, none = {NULL, NULL};
    double odds[HEARD];
    uint32_t index[HEARD];

    vt_lists_start(&bed, 1, VT_SQUARE, 1, N, 0);
    vt_assert_ok(vor_adjacency_make(&bed.graph, &bed.domain, &bed.engine.run, &vt_err));
    vt_assert_ok(vor_votes_make(&votes, &bed.domain, &bed.graph, &bed.engine.run, &vt_err));
    for (uint32_t i = 0; i < N; i++) {
        hear(odds, index, &bed, i % 2 ? &votes : &none, i);
        for (int e = 0; e < HEARD; e++)
            ck_assert_double_eq(odds[e], 0);
    }
    vor_votes_free(&votes);
    vor_votes_free(&none);
    vt_lists_end(&bed);
}
END_TEST

static vor_status try_votes(void *ctx)
{
    struct vt_lists *bed = ctx;
    struct vor_votes votes = {NULL, NULL};
    vor_status status =
        vor_votes_make(&votes, &bed->domain, &bed->graph, &bed->engine.run, &vt_err);

    if (status == VOR_OK)
        vor_votes_free(&votes);
    else
        ck_assert_ptr_null(votes.of);
    return status;
}

START_TEST(memory_that_ends_is_an_error_and_leaks_nothing)
{
    struct vt_lists bed;

    vt_lists_start_waves(&bed, 1, 1, N, WAVES);
    vt_fail_each(try_votes, &bed);
    vt_lists_end(&bed);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("votes");

    vt_add_figures(suite, pairs_that_votes_are_sure_of_are_told_right, 2);
    vt_add_figures(suite, sure_pairs_are_told_alike_from_both_ends, 1);
    vt_add(suite, one_and_three_threads_make_the_same_votes);
    vt_add(suite, nothing_is_said_where_lists_are_of_one_sheet);
    vt_add(suite, memory_that_ends_is_an_error_and_leaks_nothing);
    return vt_run(suite);
}
