/* Signs of a graph's points: the vote of all edges between two patches. */
#include "core/geom/span.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { SIDE = 12, N = 2 * SIDE + 1, MOST = SIDE + 1 };

/* Two patches in which every point knows every other, and a point that knows none. */
struct patches {
    struct vt_engine engine;
    struct vor_graph graph;
    unsigned char edge[N * MOST];
};

static void add(struct patches *patches, size_t i, size_t j, unsigned edge)
{
    size_t at = i * MOST + patches->graph.count[i]++;

    patches->graph.list[at] = (uint32_t)j;
    patches->edge[at] = (unsigned char)edge;
}

static void open(struct patches *patches)
{
    vt_engine_open(&patches->engine, 2);
    vt_assert_ok(vor_graph_init(&patches->graph, N, MOST, &vt_memory, &vt_err));
    for (size_t i = 0; i + 1 < N; i++)
        for (size_t j = 0; j + 1 < N; j++)
            if (i != j && i / SIDE == j / SIDE)
                add(patches, i, j, 0);
}

static void shut(struct patches *patches)
{
    vor_graph_free(&patches->graph);
    vt_engine_close(&patches->engine);
    vt_assert_no_leak();
}

START_TEST(one_bad_edge_is_outvoted_by_good_ones_that_are_heavier)
{
    struct patches patches;
    struct vor_span span;

    open(&patches);
    add(&patches, 0, SIDE, 2);
    for (size_t i = 1; i < 4; i++)
        add(&patches, i, SIDE + i, 8 + VOR_SPAN_TURNS);
    for (size_t i = 4; i < 6; i++)
        add(&patches, SIDE + i, i, 8 + VOR_SPAN_TURNS);
    vt_assert_ok(
        vor_span_make(&span, &patches.graph, patches.edge, 1, &patches.engine.run, &vt_err));
    for (size_t i = 0; i + 1 < N; i++) {
        ck_assert_uint_eq(span.first[i], 0);
        ck_assert_int_eq(span.odd[i] ^ span.odd[0], i / SIDE == 1);
    }
    ck_assert_uint_eq(span.first[N - 1], N - 1);
    vor_span_free(&span);
    shut(&patches);
}
END_TEST

START_TEST(a_patch_is_remembered_with_its_points_and_the_share_of_the_votes)
{
    struct patches patches;
    struct vor_span span;
    unsigned char of[N] = {0};
    uint32_t i;

    open(&patches);
    for (size_t k = 0; k < 4; k++) {
        add(&patches, k, SIDE + k, 8 + (k == 0) * VOR_SPAN_TURNS);
        add(&patches, SIDE + k, k, 8 + (k == 0) * VOR_SPAN_TURNS);
    }
    vt_assert_ok(
        vor_span_make(&span, &patches.graph, patches.edge, 1, &patches.engine.run, &vt_err));
    ck_assert_uint_eq(span.joins, 1);
    ck_assert_uint_eq(span.join[0].count, SIDE);
    i = span.join[0].first;
    for (unsigned k = 0; k < SIDE; k++, i = span.next[i])
        of[i] = 1;
    for (size_t k = 0; k + 1 < N; k++)
        ck_assert_uint_eq(of[k], of[k / SIDE * SIDE]);
    ck_assert_double_gt(span.join[0].support, 0.1);
    ck_assert_double_lt(span.join[0].support, 0.7);
    vor_span_free(&span);
    shut(&patches);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("span");

    vt_add(suite, one_bad_edge_is_outvoted_by_good_ones_that_are_heavier);
    vt_add(suite, a_patch_is_remembered_with_its_points_and_the_share_of_the_votes);
    return vt_run(suite);
}
