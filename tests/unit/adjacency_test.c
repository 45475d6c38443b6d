/* Lists of neighbours that stay on one sheet, on surfaces where the way along them is known. */
#include "core/geom/march.h"
#include "core/input/adjacency.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { SEEDS = 2, N = 20000 };

/* Sheets are so many spacings apart. */
#define APART 3

struct bed {
    struct vt_engine engine;
    const struct vt_metric *metric;
    double gap;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_graph graph;
};

static void start(struct bed *bed, int shape, int seed, size_t n, double gap)
{
    bed->metric = &vt_metrics[shape];
    bed->gap = gap;
    vt_engine_open(&bed->engine, 2);
    bed->metric->make(&bed->cloud, (uint64_t)seed, n, gap);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_adjacency_make(&bed->graph, &bed->domain, &bed->engine.run, &vt_err));
}

static void end(struct bed *bed)
{
    vor_graph_free(&bed->graph);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
    vt_assert_no_leak();
}

static void position(const struct bed *bed, size_t i, double x[3])
{
    vor_cloud_position(&bed->cloud, bed->domain.source[i], x);
}

static double straight(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* Pairs of neighbours between which the way along the surface is more than twice the straight one.
 * Round an edge of a plate or along a fold's bend it is at most 1.6 times that. */
static size_t across(const struct bed *bed)
{
    size_t pairs = 0;

    for (size_t i = 0; i < bed->graph.n; i++)
        for (unsigned a = 0; a < bed->graph.count[i]; a++) {
            double x[3], y[3];

            position(bed, i, x);
            position(bed, bed->graph.list[i * bed->graph.most + a], y);
            pairs += bed->metric->along(x, y, bed->gap) > 2 * straight(x, y);
        }
    return pairs;
}

/* At most one entry in `in` lies across; 0: none. */
static void expect_across(struct bed *bed, size_t in)
{
    size_t pairs = across(bed), few = 0, most = in > 0 ? bed->graph.n * bed->graph.most / in : 0;

    for (size_t i = 0; i < bed->graph.n; i++)
        few += bed->graph.count[i] < 8;
    ck_assert_msg(pairs <= most, "%s: %zu pairs across", bed->metric->name, pairs);
    ck_assert_msg(few <= (in > 0 ? 20 : 0), "%s: %zu points with fewer than 8 neighbours",
                  bed->metric->name, few);
    end(bed);
}

static void expect_none_across(struct bed *bed)
{
    expect_across(bed, 0);
}

START_TEST(no_neighbour_lies_on_the_other_side_of_a_fold)
{
    struct bed bed;

    start(&bed, VT_FOLD, _i, N, APART * vt_spacing(&vt_metrics[VT_FOLD], N));
    expect_none_across(&bed);
}
END_TEST

/* At the rim, where the normals of both faces and of the side mix: 28 to 36 entries of 400,000. */
START_TEST(hardly_a_neighbour_lies_on_the_other_face_of_a_plate)
{
    struct bed bed;

    start(&bed, VT_PLATE, _i, N, 0.02);
    expect_across(&bed, 8000);
}
END_TEST

/* As the cloud `sheets` that voronoid is measured on, and nearer to each other. */
START_TEST(no_neighbour_lies_on_the_other_of_two_sheets)
{
    struct bed bed;

    start(&bed, VT_SHEETS, _i, 4 * N, 0.02);
    expect_none_across(&bed);
    start(&bed, VT_SHEETS, _i, N, APART * vt_spacing(&vt_metrics[VT_SHEETS], N));
    expect_none_across(&bed);
}
END_TEST

START_TEST(no_neighbour_lies_on_the_other_of_two_spheres)
{
    struct bed bed;

    start(&bed, VT_SPHERES, _i, N, APART * vt_spacing(&vt_metrics[VT_SPHERES], N));
    expect_none_across(&bed);
}
END_TEST

/* The way along the lists from one point to all others is within 3 % of the one along the surface,
 * beyond ten spacings, and within 1 % in the mean. */
static void expect_distances(int shape, int seed)
{
    struct bed bed;
    struct vor_march march;
    double spacing = vt_spacing(&vt_metrics[shape], N), worst = 0, sum = 0, from[3], to[3], exact;
    float *far = vor_malloc(&vt_memory, N, sizeof *far);
    uint32_t source = (uint32_t)(vt_unit(77, (uint64_t)seed) * N);

    start(&bed, shape, seed, N, APART * spacing);
    vt_assert_ok(vor_march_init(&march, &bed.graph, bed.domain.xyz, &vt_err));
    vt_assert_ok(vor_march_from(&march, far, &source, 1, &bed.engine.run, &vt_err));
    position(&bed, source, from);
    for (size_t i = 0; i < bed.domain.n; i++) {
        double off;

        position(&bed, i, to);
        exact = bed.metric->along(from, to, bed.gap);
        if (exact < 10 * spacing)
            continue;
        off = fabs((double)far[i] * bed.domain.unit / exact - 1);
        worst = fmax(worst, off);
        sum += off;
    }
    /* At the rims of a fold single points hang on its other side, up to half too near. */
    ck_assert_msg((worst <= 0.03 || shape == VT_FOLD) && sum <= 0.01 * N,
                  "%s: off by %.2f %%, mean %.2f %%", bed.metric->name, 100 * worst, 100 * sum / N);
    vor_march_free(&march);
    vor_free(&vt_memory, far);
    end(&bed);
}

START_TEST(the_way_along_the_lists_is_that_along_a_square)
{
    expect_distances(VT_SQUARE, _i);
}
END_TEST

START_TEST(the_way_along_the_lists_is_that_along_a_sphere)
{
    expect_distances(VT_BALL, _i);
}
END_TEST

START_TEST(the_way_along_the_lists_is_that_along_a_cylinder)
{
    expect_distances(VT_CYLINDER, _i);
}
END_TEST

START_TEST(the_way_along_the_lists_is_that_along_a_fold)
{
    expect_distances(VT_FOLD, _i);
}
END_TEST

/* Points of a shape that the probe is asked about. */
enum { PROBED = 12000 };

/* Two unit squares that cross along a line, at 30 degrees. */
static void make_crossing(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_make(cloud, PROBED);
    for (size_t i = 0; i < PROBED; i++) {
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

    make_crossing(&cloud, (uint64_t)_i);
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
    static const char *const words[] = {"local", "none"};
    double off[2];

    for (int w = 0; w < 2; w++) {
        struct vt_engine engine;
        struct vor_cloud in, out;
        struct vor_report report;

        vt_engine_open(&engine, 2);
        make_crossing(&in, (uint64_t)_i);
        vt_engine_count(&engine, "points", PROBED);
        vt_engine_set(&engine, "iterations", "2");
        vt_engine_set(&engine, "polish", "8");
        vt_engine_set(&engine, "intrinsic", words[w]);
        vt_engine_resample(&engine, &out, &report, &in);
        ck_assert_uint_eq(out.n, PROBED);
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
        uint64_t hash = 0;

        vt_engine_open(&engine, threads_of[t]);
        make_crossing(&cloud, 1);
        vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
        vt_assert_ok(vor_adjacency_make(&graph, &domain, &engine.run, &vt_err));
        for (size_t i = 0; i < graph.n; i++)
            hash = hash * 31 +
                   vt_hash(&graph.list[i * graph.most], graph.count[i] * sizeof *graph.list);
        hash = hash * 31 + vt_hash(graph.normal, 3 * graph.n * sizeof *graph.normal);
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
    ck_assert_uint_ge(before, 4);
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

    vt_add_loop(suite, no_neighbour_lies_on_the_other_side_of_a_fold, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, hardly_a_neighbour_lies_on_the_other_face_of_a_plate,
                VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, no_neighbour_lies_on_the_other_of_two_sheets, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, no_neighbour_lies_on_the_other_of_two_spheres, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, the_way_along_the_lists_is_that_along_a_square, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, the_way_along_the_lists_is_that_along_a_sphere, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, the_way_along_the_lists_is_that_along_a_cylinder, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, the_way_along_the_lists_is_that_along_a_fold, VT_SOAK_LOOPS(1, SEEDS));
    vt_add_loop(suite, the_probe_finds_surfaces_that_cross, SEEDS);
    vt_add_loop(suite, creases_edges_and_steps_of_depth_are_no_second_sheet, SEEDS);
    vt_add_loop(suite, points_lie_twice_as_near_to_crossing_surfaces_as_without_lists, 1);
    vt_add_loop(suite, one_two_three_and_eight_threads_make_the_same_lists, 1);
    vt_add_loop(suite, memory_that_ends_anywhere_is_an_error_and_leaks_nothing, 1);
    return vt_run(suite);
}
