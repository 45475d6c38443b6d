/* The sharp edges of an input: known answers, meshes whose edges are known, what has none. */
#include "core/input/edges.h"
#include "core/input/input.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_mesh.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 4, N = 6000, WHOLE = 30000, LARGER = 7000 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_edges edges;
};

/* bed->cloud is there already. */
static void start(struct bed *bed, unsigned threads)
{
    vt_engine_open(&bed->engine, threads);
    vt_assert_ok(
        vor_input_prepare(&bed->domain, &bed->cloud, &bed->engine.spec, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_edges_find(&bed->edges, &bed->domain, &bed->engine.run, &vt_err));
    ck_assert_uint_eq(bed->edges.n, bed->domain.n);
}

static void end(struct bed *bed)
{
    vor_edges_free(&bed->edges);
    vor_domain_free(&bed->domain);
    vt_engine_close(&bed->engine);
    vor_cloud_free(&bed->cloud);
}

static struct vt_judged judge(const struct bed *bed, const struct vt_segments *truth, double area)
{
    size_t n = bed->domain.n;
    double *xyz = malloc(n * 3 * sizeof *xyz);
    struct vt_judged judged;

    ck_assert_ptr_nonnull(xyz);
    for (size_t i = 0; i < n; i++)
        vor_cloud_position(&bed->cloud, bed->domain.source[i], &xyz[3 * i]);
    judged = vt_segments_judge(truth, xyz, bed->edges.flag, n, sqrt(area / (double)n));
    free(xyz);
    return judged;
}

#define assert_at_least(judged, least)                                                             \
    ck_assert_msg((judged).precision >= (least) && (judged).recall >= (least),                     \
                  "precision %g, recall %g", (judged).precision, (judged).recall)

/* The twelve edges of the unit cube: from each corner towards those with one coordinate more. */
static struct vt_segments cube_edges(double end[12 * 6])
{
    struct vt_segments truth = {.end = end};

    for (int corner = 0; corner < 8; corner++)
        for (int axis = 0; axis < 3; axis++) {
            if (corner >> axis & 1)
                continue;
            for (int c = 0; c < 3; c++)
                end[6 * truth.n + (size_t)c] = end[6 * truth.n + 3 + (size_t)c] = corner >> c & 1;
            end[6 * truth.n++ + 3 + (size_t)axis] = 1;
        }
    return truth;
}

VT_TEST_FIGURES(the_edges_of_a_cube_are_found_and_nothing_else, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    double end_of[12 * 6];
    struct vt_segments truth = cube_edges(end_of);
    struct bed bed;

    ck_assert_uint_eq(truth.n, 12);
    vt_cloud_box(&bed.cloud, (uint64_t)_i, LARGER);
    start(&bed, 2);
    assert_at_least(judge(&bed, &truth, 6), 0.98);
    end(&bed);
}

VT_TEST_FIGURES(what_is_smooth_has_none, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static void (*const makes[])(struct vor_cloud *, uint64_t, size_t) = {
        vt_cloud_sphere, vt_cloud_torus, vt_cloud_square, vt_cloud_dome};

    for (size_t i = 0; i < sizeof makes / sizeof *makes; i++) {
        struct bed bed;

        makes[i](&bed.cloud, (uint64_t)_i, N);
        start(&bed, 2);
        ck_assert_uint_eq(bed.edges.flagged, 0);
        ck_assert_double_eq(bed.edges.length, 0);
        end(&bed);
    }
}

VT_TEST_FIGURES(two_sheets_nearer_than_a_crease_is_wide_have_hardly_any,
                VT_FEWER(VT_SOAK_LOOPS(1, 2)))
{
    double spacing = sqrt(2.0 / LARGER);

    for (int gap = 1; gap <= 3; gap++) {
        struct bed bed;

        vt_cloud_sheets(&bed.cloud, (uint64_t)_i, LARGER, gap * spacing);
        start(&bed, 2);
        ck_assert_uint_le(bed.edges.flagged, LARGER / 200);
        end(&bed);
    }
}

/* Two squares of side 2 and 1 that meet in the y axis, with that angle inside. */
static void make_wedge(struct vor_cloud *cloud, uint64_t seed, double degrees)
{
    double half = degrees * M_PI / 360;

    vt_cloud_square(cloud, seed, N);
    for (size_t i = 0; i < N; i++) {
        double x = 2 * (double)cloud->xyz[3 * i] - 1;

        cloud->xyz[3 * i] = (float)(x * sin(half));
        cloud->xyz[3 * i + 1] *= 2;
        cloud->xyz[3 * i + 2] = (float)(-fabs(x) * cos(half));
    }
}

/* Mean strength of the flagged points; every one of them has a direction along y. */
static double mean_strength(const struct vor_edges *edges)
{
    double sum = 0;

    for (size_t i = 0; i < edges->n; i++) {
        if (!edges->flag[i])
            continue;
        sum += (double)edges->strength[i];
        ck_assert_float_ge(fabsf(edges->direction[3 * i + 1]), 0.9F);
    }
    return sum / (double)edges->flagged;
}

VT_TEST_FIGURES(a_wedge_has_its_edge_angle_and_direction, VT_FEWER(VT_SOAK_LOOPS(3, 6)))
{
    static const double inside[] = {120, 150, 90};
    double along_y[6] = {0, 0.1, 0, 0, 1.9, 0}; /* at its ends an edge has too few neighbours */
    struct vt_segments inner = {.n = 1, .end = along_y};
    struct vt_judged judged;
    struct bed bed;

    make_wedge(&bed.cloud, (uint64_t)_i / 3, inside[_i % 3]);
    start(&bed, 2);
    judged = judge(&bed, &inner, 4);
    ck_assert_double_ge(judged.recall, 0.95);
    along_y[1] = 0;
    along_y[4] = 2;
    ck_assert_double_ge(judge(&bed, &inner, 4).precision, 0.98);
    ck_assert_double_eq_tol(mean_strength(&bed.edges), cos(inside[_i % 3] * M_PI / 360), 0.05);
    end(&bed);
}

/* The mesh of ../shared/data, or 0 where it is not there. */
static int read_mesh(struct vt_mesh *mesh, const char *name)
{
    const char *path = vt_data_or_skip(name);

    if (path == NULL)
        return 0;
    ck_assert_int_eq(vt_mesh_read(mesh, path), 0);
    return 1;
}

/* Moves every coordinate by normal noise. */
static void shake(struct vor_cloud *cloud, uint64_t seed, double deviation)
{
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] += (float)(deviation * vt_normal(seed + 77, i));
}

/* Diagonal of fandisk's box, and what its edges are asked to come to with noise of so much of it.
 */
static const double fandisk_diagonal = 7.60;
static const struct {
    double noise, least, length; /* length: largest relative error */
} levels[] = {{0, 0.96, 0.12}, {0.002, 0.9, 0.12}, {0.001, 0.92, 0.12}};

VT_TEST_FIGURES(the_edges_of_fandisk_are_those_of_its_mesh, VT_FEWER(VT_SOAK_LOOPS(3, 12)))
{
    struct vt_segments truth;
    struct vt_mesh mesh;
    struct bed bed;
    double length;

    if (!read_mesh(&mesh, "fandisk_mesh.ply"))
        return;
    ck_assert_int_eq(vt_mesh_sharp(&truth, &mesh, 30), 0);
    vt_cloud_make(&bed.cloud, WHOLE);
    vt_mesh_sample(bed.cloud.xyz, NULL, &mesh, (uint64_t)_i, WHOLE);
    shake(&bed.cloud, (uint64_t)_i, levels[_i % 3].noise * fandisk_diagonal);
    start(&bed, 2);
    assert_at_least(judge(&bed, &truth, vt_mesh_area(&mesh)), levels[_i % 3].least);
    length = bed.edges.length * bed.domain.unit / vt_segments_length(&truth);
    ck_assert_double_eq_tol(length, 1, levels[_i % 3].length);
    end(&bed);
    vt_segments_free(&truth);
    vt_mesh_free(&mesh);
}

VT_TEST_FIGURES(hardly_a_point_of_igea_is_on_one, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vt_mesh mesh;
    struct bed bed;

    if (!read_mesh(&mesh, "igea_mesh.ply"))
        return;
    vt_cloud_make(&bed.cloud, WHOLE);
    vt_mesh_sample(bed.cloud.xyz, NULL, &mesh, (uint64_t)_i, WHOLE);
    start(&bed, 2);
    ck_assert_uint_le(bed.edges.flagged, WHOLE * 5 / 1000);
    end(&bed);
    vt_mesh_free(&mesh);
}

/* A grid, a volume, and a volume of which half is nearer to one point than float32 can square. */
static void make_odd(struct vor_cloud *cloud, uint64_t seed, int kind)
{
    if (kind == 0)
        vt_cloud_lattice(cloud, 40);
    else
        vt_cloud_cube(cloud, seed, 1600);
    for (size_t i = 0; kind == 2 && i < 3 * 800; i++)
        cloud->xyz[i] *= 1e-25F;
}

VT_TEST_FIGURES(no_cloud_is_too_odd_for_finite_figures, VT_SOAK_LOOPS(3, 6))
{
    struct bed bed;

    make_odd(&bed.cloud, (uint64_t)_i, _i % 3);
    start(&bed, 2);
    ck_assert(isfinite(bed.edges.length) && bed.edges.length >= 0);
    for (size_t i = 0; i < bed.edges.n; i++) {
        ck_assert(bed.edges.strength[i] >= 0 && bed.edges.strength[i] <= 1);
        for (size_t c = 0; c < 3; c++)
            ck_assert_float_le(fabsf(bed.edges.direction[3 * i + c]), 1.00001F);
    }
    ck_assert(_i % 3 != 0 || bed.edges.flagged == 0);
    end(&bed);
}

VT_TEST(a_point_takes_44_bytes)
{
    struct vor_memory memory;
    struct bed bed;

    vt_cloud_box(&bed.cloud, 1, N);
    vt_engine_open(&bed.engine, 2);
    vt_assert_ok(vor_domain_init(&bed.domain, &bed.cloud, &bed.engine.run, &vt_err));
    vor_memory_init(&memory, SIZE_MAX);
    bed.engine.run.memory = &memory;
    vt_assert_ok(vor_edges_find(&bed.edges, &bed.domain, &bed.engine.run, &vt_err));
    ck_assert_uint_le(atomic_load(&memory.peak) / N, 44);
    end(&bed);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
}
