/* The sharp edges of an input: known answers, meshes whose edges are known, what has none. */
#include "core/input/edges.h"
#include "core/input/input.h"
#include "core/metrics/vcm.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_mesh.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdlib.h>

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

/* The mesh of ../shared/data, or 0 where it is not there. */
static int read_mesh(struct vt_mesh *mesh, const char *name)
{
    const char *path = vt_data_or_skip(name);

    if (path == NULL)
        return 0;
    ck_assert_int_eq(vt_mesh_read(mesh, path), 0);
    return 1;
}

/* The sheets are 1 to 3 spacings apart, nearer than a crease is wide. */
VT_TEST_FIGURES(what_is_smooth_has_none_and_near_sheets_hardly_any,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static void (*const makes[])(struct vor_cloud *, uint64_t, size_t) = {
        vt_cloud_sphere, vt_cloud_torus, vt_cloud_square, vt_cloud_dome};

    for (size_t i = 0; i < 8; i++) {
        struct vt_mesh mesh;
        struct bed bed;

        if (i < 4) {
            makes[i](&bed.cloud, (uint64_t)_i, N);
        } else if (i < 7) {
            vt_cloud_sheets(&bed.cloud, (uint64_t)_i, LARGER, (double)(i - 3) * sqrt(2.0 / LARGER));
        } else if (read_mesh(&mesh, "igea_mesh.ply")) {
            vt_cloud_make(&bed.cloud, WHOLE);
            vt_mesh_sample(bed.cloud.xyz, NULL, &mesh, (uint64_t)_i, WHOLE);
            vt_mesh_free(&mesh);
        } else {
            break;
        }
        start(&bed, 2);
        ck_assert_uint_le(bed.edges.flagged, i < 4 ? 0 : bed.domain.n / 200);
        ck_assert(bed.edges.flagged > 0 || bed.edges.length == 0);
        end(&bed);
    }
}

/* The edges of a unit cube, and of the side of a cylinder. From an edge of the cube a place on it
 * is as far as the middle one of its distances from the faces. VCM marks every point near an edge
 * or a border, and no other. */
VT_TEST_FIGURES(the_edges_of_a_cube_are_found_and_nothing_else, VT_FEWER(VT_SOAK_LOOPS(2, SEEDS)))
{
    int cube = _i % 2 == 0;
    double spacing = sqrt((cube ? 6 : 4 * M_PI) / LARGER);
    size_t right = 0, missed = 0, near = 0;
    unsigned char flag[LARGER];
    struct bed bed;

    (cube ? vt_cloud_box : vt_cloud_square)(&bed.cloud, (uint64_t)_i, LARGER);
    for (float *x = bed.cloud.xyz; !cube && x < &bed.cloud.xyz[3 * LARGER]; x += 3) {
        x[2] = (float)sin(2 * M_PI * (double)x[0]);
        x[0] = (float)cos(2 * M_PI * (double)x[0]);
        x[1] *= 2;
    }
    start(&bed, 2);
    vt_assert_ok(vor_vcm_mark(flag, &bed.domain, &bed.engine.run, &vt_err));
    for (size_t i = 0; i < bed.domain.n; i++) {
        const float *x = &bed.cloud.xyz[3 * (size_t)bed.domain.source[i]];
        double d[3], off;

        for (int c = 0; c < 3; c++)
            d[c] = fmin((double)x[c], (cube ? 1 : 2) - (double)x[c]);
        off = (cube ? fmax(fmin(d[0], d[1]), fmin(fmax(d[0], d[1]), d[2])) : d[1]) / spacing;
        ck_assert_msg(flag[i] ? off < 3.5 : off > 0.5, "%g spacings: %d", off, flag[i]);
        right += bed.edges.flag[i] && off <= 1.5;
        near += off <= 0.5;
        missed += off <= 0.5 && !bed.edges.flag[i];
    }
    ck_assert_msg(cube ? right >= 0.98 * bed.edges.flagged && missed <= 0.08 * near
                       : bed.edges.flagged == 0,
                  "%zu of %zu right, %zu of %zu missed", right, bed.edges.flagged, missed, near);
    end(&bed);
}

/* Oracle: moments of a cell, summed over a grid of places: of a lone point, of one on a sheet, in a
 * volume. */
VT_TEST_FIGURES(moments_of_a_cell_are_those_of_the_places_nearest_to_it, VT_SOAK_LOOPS(6, 24))
{
    enum { POINTS = 40, GRID = 60 };
    float around[3 * POINTS];
    double m[6], sum[6] = {0};
    size_t k = _i % 3 == 0 ? 1 : POINTS;

    for (size_t i = 0; i < 3 * POINTS; i++)
        around[i] =
            (float)((vt_unit((uint64_t)_i, i) - 0.5) * (_i % 3 == 1 && i % 3 == 2 ? 0.1 : 1));
    vor_vcm_cell(m, around, k, 0.5);
    for (int at = 0; at < GRID * GRID * GRID; at++) {
        double x[3] = {at % GRID, at / GRID % GRID, at / GRID / GRID}, least = 1, d2 = 0;

        for (int c = 0; c < 3; c++)
            x[c] = (2 * x[c] + 1) / GRID - 1;
        for (size_t j = 0; j < k; j++, least = fmin(least, d2), d2 = 0)
            for (size_t c = 0; c < 3; c++)
                d2 += pow(x[c] - 2 * ((double)around[3 * j + c] - (double)around[c]), 2);
        if (vor_dot(x, x) <= least)
            vor_add_square(sum, x);
    }
    for (int c = 0; c < 6; c++)
        ck_assert_double_eq_tol(m[c], sum[c] * pow(2. / GRID, 3), 0.06 * (m[0] + m[3] + m[5]));
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
    vt_assert_ok(vor_vcm_mark(bed.edges.flag, &bed.domain, &bed.engine.run, &vt_err));
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
