/* Lists of neighbours that stay on one sheet, on surfaces where the way along them is known. */
#include "core/input/adjacency.h"
#include "tests/support/vt_lists.h"

#include <math.h>

enum { SEEDS = 2, N = 8000, DENSE = 20000, MANY = 80000 };

/* Sheets are so many spacings apart. */
#define APART 3

static void start(struct vt_lists *lists, int shape, int seed, size_t n, double gap)
{
    vt_lists_start(lists, 2, shape, seed, n, gap);
    vt_assert_ok(vor_adjacency_make(&lists->graph, &lists->domain, &lists->engine.run, &vt_err));
}

/* At most one entry in `in` lies across; 0: none. */
static void expect_across(struct vt_lists *bed, size_t in)
{
    size_t pairs = vt_lists_across(bed), few = 0,
           most = in > 0 ? bed->graph.n * bed->graph.most / in : 0;

    for (size_t i = 0; i < bed->graph.n; i++)
        few += bed->graph.count[i] < 8;
    ck_assert_msg(pairs <= most, "%s: %zu pairs across", bed->metric->name, pairs);
    ck_assert_msg(few <= (in > 0 ? 20 : 0), "%s: %zu points with fewer than 8 neighbours",
                  bed->metric->name, few);
    vt_lists_end(bed);
}

static void expect_none_across(struct vt_lists *bed)
{
    expect_across(bed, 0);
}

START_TEST(no_neighbour_lies_on_the_other_side_of_a_fold)
{
    struct vt_lists bed;

    start(&bed, VT_FOLD, _i, N, APART * vt_spacing(&vt_metrics[VT_FOLD], N));
    expect_none_across(&bed);
}
END_TEST

/* At the rim, where the normals of both faces and of the side mix, one of four plates has a pair;
 * at some corners fewer than eight neighbours can be reached. */
START_TEST(no_neighbour_lies_on_the_other_face_of_a_plate)
{
    struct vt_lists bed;

    start(&bed, VT_PLATE, _i, DENSE, 0.02);
    expect_across(&bed, bed.graph.n * bed.graph.most);
}
END_TEST

/* As the cloud `sheets` that voronoid is measured on, and nearer to each other. */
START_TEST(no_neighbour_lies_on_the_other_of_two_sheets)
{
    struct vt_lists bed;

    if (vt_soaks()) {
        start(&bed, VT_SHEETS, _i, MANY, 0.02);
        expect_none_across(&bed);
    }
    start(&bed, VT_SHEETS, _i, N, APART * vt_spacing(&vt_metrics[VT_SHEETS], N));
    expect_none_across(&bed);
}
END_TEST

START_TEST(no_neighbour_lies_on_the_other_of_two_spheres)
{
    struct vt_lists bed;

    start(&bed, VT_SPHERES, _i, N, APART * vt_spacing(&vt_metrics[VT_SPHERES], N));
    expect_none_across(&bed);
}
END_TEST

/* The way along the lists from one point to all others is within 3 % of the one along the surface,
 * beyond ten spacings, and within 1 % in the mean. */
static void expect_distances(int shape, int seed, size_t n)
{
    struct vt_lists bed;
    struct vt_way way;

    start(&bed, shape, seed, n, APART * vt_spacing(&vt_metrics[shape], n));
    way = vt_lists_way(&bed, seed);
    /* At the rims of a fold single points hang on its other side, up to half too near. */
    ck_assert_msg((way.worst <= 0.03 || shape == VT_FOLD) && way.mean <= 0.01,
                  "%s: off by %.2f %%, mean %.2f %%", bed.metric->name, 100 * way.worst,
                  100 * way.mean);
    vt_lists_end(&bed);
}

START_TEST(the_way_along_the_lists_is_that_along_a_square)
{
    expect_distances(VT_SQUARE, _i, N);
}
END_TEST

START_TEST(the_way_along_the_lists_is_that_along_a_sphere)
{
    expect_distances(VT_BALL, _i, N);
}
END_TEST

START_TEST(the_way_along_the_lists_is_that_along_a_cylinder)
{
    expect_distances(VT_CYLINDER, _i, N);
}
END_TEST

START_TEST(the_way_along_the_lists_is_that_along_a_fold)
{
    expect_distances(VT_FOLD, _i, DENSE);
}
END_TEST

/* Points of a shape that the probe is asked about. */
enum { PROBED = 12000 };

/* Two unit squares that cross along a line, at 30 degrees. */
static void make_crossing(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double u = vt_unit(seed, 2 * i) - 0.5, v = vt_unit(seed, 2 * i + 1);

        cloud->xyz[3 * i] = (float)(u * (i % 2 ? sqrt(0.75) : 1));
        cloud->xyz[3 * i + 1] = (float)v;
        cloud->xyz[3 * i + 2] = (float)(i % 2 ? u / 2 : 0);
    }
}

/* A rod about seven spacings thick, bent to a ring. */
static void make_rod(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_make(cloud, PROBED);
    for (size_t i = 0; i < PROBED; i++) {
        double u = 2 * M_PI * vt_unit(seed, 2 * i), v = 2 * M_PI * vt_unit(seed, 2 * i + 1);
        double radius = 1 + 0.04 * cos(v);

        cloud->xyz[3 * i] = (float)(radius * cos(u));
        cloud->xyz[3 * i + 1] = (float)(radius * sin(u));
        cloud->xyz[3 * i + 2] = (float)(0.04 * sin(v));
    }
}

/* A slope whose heights are rounded to steps wider than the spacing, as depth cameras do. */
static void make_steps(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_make(cloud, PROBED);
    for (size_t i = 0; i < PROBED; i++) {
        double u = vt_unit(seed, 2 * i), v = vt_unit(seed, 2 * i + 1);

        cloud->xyz[3 * i] = (float)u;
        cloud->xyz[3 * i + 1] = (float)v;
        cloud->xyz[3 * i + 2] = (float)(floor(20 * u) / 20);
    }
}

static int probe(struct vor_cloud *cloud)
{
    struct vt_engine engine;
    struct vor_domain domain;
    int pays;

    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_domain_init(&domain, cloud, &engine.run, &vt_err));
    vt_assert_ok(vor_adjacency_probe(&pays, &domain, &engine.run, &vt_err));
    vor_domain_free(&domain);
    vor_cloud_free(cloud);
    vt_engine_close(&engine);
    vt_assert_no_leak();
    return pays;
}

START_TEST(the_probe_finds_surfaces_that_cross)
{
    struct vor_cloud cloud;

    make_crossing(&cloud, (uint64_t)_i, PROBED);
    ck_assert_int_eq(probe(&cloud), 1);
}
END_TEST

START_TEST(creases_edges_and_steps_of_depth_are_no_second_sheet)
{
    struct vor_cloud cloud;

    vt_cloud_box(&cloud, (uint64_t)_i, PROBED);
    ck_assert_int_eq(probe(&cloud), 0);
    make_steps(&cloud, (uint64_t)_i);
    ck_assert_int_eq(probe(&cloud), 0);
    vt_cloud_dome(&cloud, (uint64_t)_i, PROBED);
    ck_assert_int_eq(probe(&cloud), 0);
    make_rod(&cloud, (uint64_t)_i);
    ck_assert_int_eq(probe(&cloud), 0);
}
END_TEST

/* Rms distance to the nearer one of the crossing squares, where it is not at their borders. */
static double off_crossing(const struct vor_cloud *out)
{
    double sum = 0;
    size_t n = 0;

    for (size_t i = 0; i < out->n; i++) {
        double x[3], flat, steep, off;

        vor_cloud_position(out, i, x);
        if (fabs(x[0]) > 0.35 || x[1] < 0.05 || x[1] > 0.95)
            continue;
        flat = fabs(x[2]);
        steep = fabs(x[2] * sqrt(0.75) - x[0] / 2);
        off = fmin(flat, steep);
        sum += off * off;
        n++;
    }
    return sqrt(sum / (double)n);
}

/* Where surfaces cross, fits to the nearest points run between them. */
START_TEST(points_lie_twice_as_near_to_crossing_surfaces_as_without_lists)
{
    enum { CROSSING = 6000 };
    static const char *const words[] = {"local", "none"};
    double off[2];

    for (int w = 0; w < 2; w++) {
        struct vt_engine engine;
        struct vor_cloud in, out;
        struct vor_report report;

        vt_engine_open(&engine, 2);
        make_crossing(&in, (uint64_t)_i, CROSSING);
        vt_engine_count(&engine, "points", CROSSING);
        vt_engine_set(&engine, "iterations", "2");
        vt_engine_set(&engine, "polish", "8");
        vt_engine_set(&engine, "intrinsic", words[w]);
        vt_engine_resample(&engine, &out, &report, &in);
        ck_assert_uint_eq(out.n, CROSSING);
        off[w] = off_crossing(&out);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
        vt_engine_close(&engine);
    }
    ck_assert_double_lt(off[0], 0.5 * off[1]);
}
END_TEST

START_TEST(one_two_three_and_eight_threads_make_the_same_lists)
{
    static const unsigned threads_of[4] = {1, 2, 3, 8};
    uint64_t first = 0;

    for (int t = 0; t < 4; t++) {
        struct vt_engine engine;
        struct vor_cloud cloud;
        struct vor_domain domain;
        struct vor_graph graph;
        uint64_t hash;

        vt_engine_open(&engine, threads_of[t]);
        make_crossing(&cloud, 1, 4000);
        vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
        vt_assert_ok(vor_adjacency_make(&graph, &domain, &engine.run, &vt_err));
        hash = vt_lists_hash(&graph);
        if (t == 0)
            first = hash;
        ck_assert_uint_eq(hash, first);
        vor_graph_free(&graph);
        vor_domain_free(&domain);
        vor_cloud_free(&cloud);
        vt_engine_close(&engine);
    }
}
END_TEST

START_TEST(memory_that_ends_anywhere_is_an_error_and_leaks_nothing)
{
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_graph graph;
    size_t before;

    vt_engine_open(&engine, 1);
    vt_cloud_dome(&cloud, 1, 500);
    vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
    before = atomic_load(&vt_memory.calls);
    vt_assert_ok(vor_adjacency_make(&graph, &domain, &engine.run, &vt_err));
    before = atomic_load(&vt_memory.calls) - before;
    ck_assert_uint_gt(before, 0);
    vor_graph_free(&graph);
    for (size_t call = 1; call <= before; call++) {
        vt_memory.fail_at = atomic_load(&vt_memory.calls) + call;
        ck_assert_int_eq(vor_adjacency_make(&graph, &domain, &engine.run, &vt_err), VOR_E_NOMEM);
    }
    vt_memory.fail_at = 0;
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("adjacency");

    vt_add_figures(suite, no_neighbour_lies_on_the_other_side_of_a_fold, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, no_neighbour_lies_on_the_other_face_of_a_plate, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, no_neighbour_lies_on_the_other_of_two_sheets, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, no_neighbour_lies_on_the_other_of_two_spheres, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, the_way_along_the_lists_is_that_along_a_square, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, the_way_along_the_lists_is_that_along_a_sphere, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, the_way_along_the_lists_is_that_along_a_cylinder,
                   VT_SOAK_LOOPS(1, SEEDS));
    vt_add_figures(suite, the_way_along_the_lists_is_that_along_a_fold, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, the_probe_finds_surfaces_that_cross, SEEDS);
    vt_add_figures(suite, creases_edges_and_steps_of_depth_are_no_second_sheet, SEEDS);
    vt_add_figures(suite, points_lie_twice_as_near_to_crossing_surfaces_as_without_lists, 1);
    vt_add_loop(suite, one_two_three_and_eight_threads_make_the_same_lists, 1);
    vt_add_loop(suite, memory_that_ends_anywhere_is_an_error_and_leaks_nothing, 1);
    return vt_run(suite);
}
