/* Sheets grown to where a look at one place does not find them: two that bend, nearer to each other
 * than their spacing. */
#include "core/input/adjacency.h"
#include "core/input/grow.h"
#include "core/input/sheets.h"
#include "tests/support/vt_lists.h"

#include <string.h>

enum { N = 6000, FEWEST = 8 };

#define WAVES 18.0 /* to a side */

static void start(struct vt_lists *bed, unsigned threads, int seed)
{
    vt_lists_start_waves(bed, threads, seed, N, WAVES);
}

START_TEST(lists_grown_from_sure_ones_hold_a_tenth_of_the_pairs_across)
{
    struct vt_lists bed;
    size_t before, after, few = 0;

    start(&bed, 2, _i);
    before = vt_lists_astray(&bed);
    vt_assert_ok(vor_grow(&bed.graph, &bed.domain, &bed.engine.run, &vt_err));
    after = vt_lists_astray(&bed);
    for (size_t i = 0; i < bed.graph.n; i++)
        few += bed.graph.count[i] < FEWEST;
    ck_assert_uint_eq(few, 0);
    ck_assert_uint_gt(before, N / 30);
    ck_assert_msg(10 * after <= before, "%zu pairs across, %zu before", after, before);
    vt_lists_end(&bed);
}
END_TEST

START_TEST(one_two_three_and_eight_threads_grow_the_same_lists)
{
    static const unsigned threads[] = {1, 2, 3, 8};
    uint64_t first = 0;

    for (size_t k = 0; k < sizeof threads / sizeof *threads; k++) {
        struct vt_lists bed;
        uint64_t hash;

        start(&bed, threads[k], _i);
        vt_assert_ok(vor_grow(&bed.graph, &bed.domain, &bed.engine.run, &vt_err));
        hash = vt_lists_hash(&bed.graph);
        first = k == 0 ? hash : first;
        ck_assert_msg(hash == first, "%u threads grow other lists", threads[k]);
        vt_lists_end(&bed);
    }
}
END_TEST

START_TEST(lists_of_one_sheet_stay_as_they_are)
{
    struct vt_lists bed;
    uint64_t before;

    vt_lists_start(&bed, 2, VT_SQUARE, _i, N, 0);
    vt_assert_ok(vor_adjacency_make(&bed.graph, &bed.domain, &bed.engine.run, &vt_err));
    before = vt_lists_hash(&bed.graph);
    vt_assert_ok(vor_grow(&bed.graph, &bed.domain, &bed.engine.run, &vt_err));
    ck_assert(vt_lists_hash(&bed.graph) == before);
    vt_lists_end(&bed);
}
END_TEST

static vor_status try_grow(void *ctx)
{
    struct vt_lists *bed = ctx;

    return vor_grow(&bed->graph, &bed->domain, &bed->engine.run, &vt_err);
}

START_TEST(memory_that_ends_is_an_error_and_leaks_nothing)
{
    struct vt_lists bed;

    start(&bed, 1, _i);
    vt_fail_each(try_grow, &bed);
    vt_lists_end(&bed);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("grow");

    vt_add_figures(suite, lists_grown_from_sure_ones_hold_a_tenth_of_the_pairs_across, 1);
    vt_add_loop(suite, one_two_three_and_eight_threads_grow_the_same_lists, 1);
    vt_add_loop(suite, lists_of_one_sheet_stay_as_they_are, 1);
    vt_add_loop(suite, memory_that_ends_is_an_error_and_leaks_nothing, 1);
    return vt_run(suite);
}
