/* Triangles where two sheets meet: two lattices that cross along a line. */
#include "core/base/rng.h"
#include "core/input/adjacency.h"
#include "core/mesh/meeting.h"
#include "tests/support/vt_complex.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SIDE = 30, EACH = SIDE * SIDE, N = 2 * EACH, TRIANGLES = 4 * (SIDE - 1) * (SIDE - 1) };

/* Points looked at for the lists: on two sheets 20 of one are among them. */
enum { LOOKED = 60 };

/* Tangent of the angle between the sheets. */
#define SLOPE 0.07

/* Two uneven lattices of points that are input and result, the second slanted, or apart by gap. */
struct bed {
    struct vt_engine engine;
    struct vor_domain domain;
    struct vor_knn *knn;
    struct vor_graph graph;
    struct vor_seeds seeds;
    struct vor_last_fit fit[N];
    uint32_t root[N];
    struct vor_sheet sheet;
    struct vor_complex complex;
    float xyz[3 * N];
};

/* Lists of the nearest points of the same lattice. */
static void make_lists(struct bed *bed)
{
    uint32_t index[LOOKED];
    float distance2[LOOKED];

    vt_assert_ok(vor_graph_init(&bed->graph, N, VOR_ADJACENT, &vt_memory, &vt_err));
    for (uint32_t i = 0; i < N; i++) {
        unsigned count = 0;

        vor_knn_search(bed->knn, &bed->xyz[3 * i], 1, LOOKED, index, distance2);
        for (int e = 0; e < LOOKED && count < VOR_ADJACENT; e++)
            if (index[e] != i && (index[e] < EACH) == (i < EACH))
                bed->graph.list[i * VOR_ADJACENT + count++] = index[e];
        bed->graph.count[i] = (unsigned char)count;
        bed->graph.own[i] = 1;
        bed->root[i] = i;
        bed->fit[i].layered = 1;
    }
}

static void start(struct bed *bed, unsigned threads, uint64_t seed, double slope, double gap)
{
    memset(bed, 0, sizeof *bed);
    vt_engine_open(&bed->engine, threads);
    for (size_t i = 0; i < N; i++) {
        float *x = &bed->xyz[3 * i];
        size_t k = i % EACH;

        x[0] = (float)(((double)(k % SIDE) + 0.8 * vor_rng_unit(seed, 1, 2 * i)) / SIDE);
        x[1] = (float)(((double)(k / SIDE) + 0.8 * vor_rng_unit(seed, 1, 2 * i + 1)) / SIDE);
        x[2] = i < EACH ? 0 : (float)(gap + slope * ((double)x[0] - 0.5));
    }
    vt_assert_ok(vor_knn_build(&bed->knn, bed->xyz, N, &vt_memory, &vt_err));
    make_lists(bed);
    bed->domain.n = bed->seeds.n = N;
    bed->domain.xyz = bed->seeds.xyz = bed->xyz;
    bed->domain.knn = bed->knn;
    bed->domain.known.grown = bed->domain.known.sheets = 1;
    bed->seeds.domain = &bed->domain;
    bed->seeds.last_fit = bed->fit;
    bed->sheet.seeds = &bed->seeds;
    bed->sheet.graph = &bed->graph;
    bed->sheet.root = bed->root;
    vt_assert_ok(vor_complex_init(&bed->complex, N, &vt_memory, &vt_err));
    vt_complex_lattice(&bed->complex, 0, SIDE);
    vt_complex_lattice(&bed->complex, EACH, SIDE);
}

static void end(struct bed *bed)
{
    vor_complex_free(&bed->complex);
    vor_graph_free(&bed->graph);
    vor_knn_free(bed->knn);
    vt_engine_close(&bed->engine);
    vt_assert_no_leak();
}

static vor_status drop(struct bed *bed)
{
    return vor_meeting_drop(&bed->complex, &bed->sheet, &bed->engine.run, &vt_err);
}

static size_t gone(const struct bed *bed)
{
    size_t count = 0;

    for (size_t t = 0; t < TRIANGLES; t++)
        count += bed->complex.triangle[3 * t] == VOR_COMPLEX_GONE;
    return count;
}

/* Least distance of the sheets at a corner, in spacings. */
static double nearest(const struct bed *bed, const uint32_t corner[3])
{
    double least = INFINITY;

    for (int c = 0; c < 3; c++)
        least = fmin(least, SIDE * SLOPE * fabs((double)bed->xyz[3 * corner[c]] - 0.5));
    return least;
}

/* The spacing and the distance are estimated: a third of VOR_MEETING_NEAR is left to that. */
START_TEST(triangles_where_sheets_meet_go_and_others_stay)
{
    static struct bed bed;
    uint32_t before[3 * TRIANGLES];
    size_t met = 0, stayed = 0, meeting = 0, away = 0;

    start(&bed, 2, (uint64_t)_i, SLOPE, 0);
    memcpy(before, bed.complex.triangle, sizeof before);
    vt_assert_ok(drop(&bed));
    for (size_t t = 0; t < TRIANGLES; t++) {
        int is_gone = bed.complex.triangle[3 * t] == VOR_COMPLEX_GONE;
        double apart = nearest(&bed, &before[3 * t]);

        if (apart < VOR_MEETING_NEAR * 2 / 3) {
            meeting++;
            met += (size_t)is_gone;
        } else if (apart > VOR_MEETING_NEAR * 4 / 3) {
            away++;
            stayed += (size_t)!is_gone;
        }
    }
    ck_assert_uint_gt(meeting, 2 * SIDE);
    ck_assert_uint_gt(away, TRIANGLES / 2);
    ck_assert_msg(100 * met >= 98 * meeting, "%zu of %zu are gone", met, meeting);
    ck_assert_msg(1000 * stayed >= 995 * away, "%zu of %zu stayed", stayed, away);
    end(&bed);
}
END_TEST

START_TEST(sheets_that_keep_half_a_spacing_apart_keep_their_triangles)
{
    static struct bed bed;

    start(&bed, 2, (uint64_t)_i, 0, 0.5 / SIDE);
    vt_assert_ok(drop(&bed));
    ck_assert_uint_eq(gone(&bed), 0);
    end(&bed);
}
END_TEST

/* Two sheets far from each other, with bumps; and with lists that have nothing, as if all around
 * each point lay on another sheet: then their bumps are mostly told from two sheets. */
START_TEST(bumps_of_one_sheet_keep_their_triangles)
{
    static struct bed bed;

    for (int listed = 1; listed >= 0; listed--) {
        start(&bed, 2, (uint64_t)_i, 0, 5);
        for (size_t i = 0; i < N; i++) {
            float *x = &bed.xyz[3 * i];

            x[2] += (float)(0.02 * sin(12 * (double)x[0]) * sin(12 * (double)x[1]));
            if (!listed)
                bed.graph.count[i] = 0;
        }
        vor_knn_free(bed.knn);
        vt_assert_ok(vor_knn_build(&bed.knn, bed.xyz, N, &vt_memory, &vt_err));
        bed.domain.knn = bed.knn;
        vt_assert_ok(drop(&bed));
        ck_assert_msg(gone(&bed) <= (listed ? 0 : TRIANGLES / 3), "%zu are gone", gone(&bed));
        end(&bed);
    }
}
END_TEST

START_TEST(without_sheets_all_triangles_stay)
{
    static struct bed bed;

    for (int what = 0; what < 3; what++) {
        start(&bed, 1, 1, SLOPE, 0);
        bed.domain.known.grown = what != 0;
        bed.domain.known.sheets = what != 1;
        for (size_t i = 0; i < N && what == 2; i++)
            bed.fit[i].layered = 0;
        vt_assert_ok(drop(&bed));
        ck_assert_uint_eq(gone(&bed), 0);
        end(&bed);
    }
}
END_TEST

START_TEST(one_and_three_threads_leave_the_same_triangles)
{
    static struct bed one, three;

    start(&one, 1, (uint64_t)_i, SLOPE, 0);
    start(&three, 3, (uint64_t)_i, SLOPE, 0);
    vt_assert_ok(drop(&one));
    vt_assert_ok(drop(&three));
    ck_assert_uint_gt(gone(&one), 0);
    ck_assert_mem_eq(one.complex.triangle, three.complex.triangle,
                     3 * TRIANGLES * sizeof *one.complex.triangle);
    vor_complex_free(&one.complex);
    vor_graph_free(&one.graph);
    vor_knn_free(one.knn);
    vt_engine_close(&one.engine);
    end(&three);
}
END_TEST

/* What is refused takes no triangle. */
static vor_status try_drop(void *ctx)
{
    vor_status status = drop(ctx);

    if (status != VOR_OK)
        ck_assert_uint_eq(gone(ctx), 0);
    return status;
}

START_TEST(memory_that_ends_is_an_error_and_leaks_nothing)
{
    static struct bed bed;

    start(&bed, 1, 1, SLOPE, 0);
    vt_fail_each(try_drop, &bed);
    end(&bed);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("meeting");

    vt_add_figures(suite, triangles_where_sheets_meet_go_and_others_stay, 5);
    vt_add_figures(suite, sheets_that_keep_half_a_spacing_apart_keep_their_triangles, 3);
    vt_add_figures(suite, bumps_of_one_sheet_keep_their_triangles, 3);
    vt_add(suite, without_sheets_all_triangles_stay);
    vt_add_loop(suite, one_and_three_threads_leave_the_same_triangles, 1);
    vt_add(suite, memory_that_ends_is_an_error_and_leaks_nothing);
    return vt_run(suite);
}
