/* Inputs that were rounded to a lattice: it is found, and the points moved within their cells. */
#include "core/input/lattice.h"
#include "core/input/restore.h"
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 3, N = 12000, MANY = 20000 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_lattice lattice;
};

/* bed->cloud is there already. */
static void start(struct bed *bed, unsigned threads)
{
    vt_engine_open(&bed->engine, threads);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_lattice_find(&bed->lattice, &bed->domain, &bed->engine.run, &vt_err));
}

static void end(struct bed *bed)
{
    vor_domain_free(&bed->domain);
    vt_engine_close(&bed->engine);
    vor_cloud_free(&bed->cloud);
}

static double spacing(const struct vt_shape *shape)
{
    return sqrt(shape->area / N);
}

/* To the middle of cells that one has a corner at that offset. */
static void snap(struct vor_cloud *cloud, const double cell[3], double offset)
{
    for (size_t i = 0; i < 3 * cloud->n; i++) {
        double x = floor(((double)cloud->xyz[i] - offset) / cell[i % 3]) + 0.5;

        cloud->xyz[i] = (float)(x * cell[i % 3] + offset);
    }
}

static void snap_even(struct vor_cloud *cloud, double cell)
{
    const double cells[3] = {cell, cell, cell};

    snap(cloud, cells, 0);
}

static void scale(struct vor_cloud *cloud, double factor, double shift)
{
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] = (float)((double)cloud->xyz[i] * factor + shift);
}

static void assert_cell(const struct bed *bed, int c, double cell)
{
    double found = bed->lattice.cell[c] * bed->domain.unit;

    ck_assert_msg(fabs(found - cell) <= 1e-4 * cell, "axis %d: %.9g, want %.9g", c, found, cell);
}

static void assert_none(const struct bed *bed)
{
    ck_assert(!bed->lattice.matters);
    for (int c = 0; c < 3; c++)
        ck_assert_msg(bed->lattice.cell[c] == 0, "axis %d: %g", c, bed->lattice.cell[c]);
}

VT_TEST_FIGURES(known_lattices_are_found, VT_FEWER(SEEDS))
{
    static const double ratios[3][3] = {{1, 1, 1}, {1, 1.37, 0.71}, {0.5, 2, 1}};
    static const double factors[3][2] = {{1, 0}, {1e-3, 5e-3}, {1e4, -7e4}};

    for (int i = 0; i < 9; i++) {
        const struct vt_shape *shape = &vt_shapes[(_i + i) % VT_SMOOTH];
        const double *factor = factors[i % 3];
        struct bed bed;
        double cell[3], size = (0.6 + 0.5 * vt_unit((uint64_t)_i, (uint64_t)i)) * spacing(shape);

        for (int c = 0; c < 3; c++)
            cell[c] = size * ratios[i / 3][c];
        shape->make(&bed.cloud, (uint64_t)_i, N);
        snap(&bed.cloud, cell, 0.3 * size);
        scale(&bed.cloud, factor[0], factor[1]);
        start(&bed, 2);
        ck_assert(bed.lattice.matters);
        for (int c = 0; c < 3; c++)
            assert_cell(&bed, c, cell[c] * factor[0]);
        end(&bed);
    }
}

VT_TEST_FIGURES(clouds_without_one_are_not_taken_for_one, VT_FEWER(SEEDS))
{
    static void (*const makes[])(struct vor_cloud *, uint64_t,
                                 size_t) = {vt_cloud_sphere, vt_cloud_torus,  vt_cloud_box,
                                            vt_cloud_dome,   vt_cloud_square, vt_cloud_cube};

    for (size_t i = 0; i < sizeof makes / sizeof *makes; i++)
        for (size_t n = 100; n <= N; n *= 3) {
            struct bed bed;

            makes[i](&bed.cloud, (uint64_t)_i, n);
            start(&bed, 2);
            assert_none(&bed);
            end(&bed);
        }
}

/* A scan rounded to a millimetre. */
VT_TEST_FIGURES(one_of_small_cells_is_found_and_does_not_matter, VT_FEWER(SEEDS))
{
    static const double shares[] = {0.35, 0.05, 0.01};

    for (int i = 0; i < 3; i++) {
        struct bed bed;
        double cell = shares[i] * 0.5 * spacing(&vt_shapes[VT_TORUS]); /* nearest: half of it */

        vt_cloud_torus(&bed.cloud, (uint64_t)_i, N);
        snap_even(&bed.cloud, cell);
        start(&bed, 2);
        ck_assert(!bed.lattice.matters);
        for (int c = 0; c < 3; c++)
            assert_cell(&bed, c, cell);
        end(&bed);
    }
}

VT_TEST_FIGURES(six_digits_do_not_hide_it, VT_FEWER(SEEDS))
{
    struct bed bed;
    double cell = spacing(&vt_shapes[VT_SPHERE]);

    vt_cloud_sphere(&bed.cloud, (uint64_t)_i, N);
    snap_even(&bed.cloud, cell);
    scale(&bed.cloud, 77, 123);
    for (size_t i = 0; i < 3 * bed.cloud.n; i++) {
        char text[32];

        (void)snprintf(text, sizeof text, "%g", (double)bed.cloud.xyz[i]);
        bed.cloud.xyz[i] = strtof(text, NULL);
    }
    start(&bed, 2);
    ck_assert(bed.lattice.matters);
    for (int c = 0; c < 3; c++)
        assert_cell(&bed, c, 77 * cell);
    end(&bed);
}

VT_TEST_FIGURES(a_few_strays_and_gaps_do_not_hide_it_and_many_do, VT_FEWER(SEEDS))
{
    static const size_t every[] = {4000, 50};

    for (int i = 0; i < 2; i++) {
        struct bed bed;
        double cell = spacing(&vt_shapes[VT_TORUS]);
        size_t kept = 0;

        vt_cloud_torus(&bed.cloud, (uint64_t)_i, N);
        snap_even(&bed.cloud, cell);
        for (size_t j = 0; j < N; j++)
            if (vt_unit((uint64_t)_i + 9, j) > 0.1)
                memmove(&bed.cloud.xyz[3 * kept++], &bed.cloud.xyz[3 * j], 3 * sizeof(float));
        bed.cloud.n = kept;
        for (size_t j = 0; j < kept; j += every[i])
            for (size_t c = 0; c < 3; c++)
                bed.cloud.xyz[3 * j + c] += (float)(0.37 * cell);
        start(&bed, 2);
        for (int c = 0; c < 3 && i == 0; c++)
            assert_cell(&bed, c, cell);
        if (i == 1)
            assert_none(&bed);
        end(&bed);
    }
}

VT_TEST_FIGURES(all_points_in_a_plane_leave_one_axis_without, VT_FEWER(SEEDS))
{
    struct bed bed;
    size_t moved;

    vt_cloud_square(&bed.cloud, (uint64_t)_i, N);
    snap_even(&bed.cloud, 0.01);
    for (size_t i = 0; i < N; i++)
        bed.cloud.xyz[3 * i + 2] = 7;
    start(&bed, 2);
    assert_cell(&bed, 0, 0.01);
    assert_cell(&bed, 1, 0.01);
    ck_assert(bed.lattice.cell[2] == 0 && bed.lattice.matters);
    vt_assert_ok(vor_lattice_smooth(&bed.domain, &moved, &bed.lattice, &bed.engine.run, &vt_err));
    for (size_t i = 0; i < bed.domain.n; i++)
        ck_assert((double)bed.domain.xyz[3 * i + 2] * bed.domain.unit + bed.domain.shift[2] == 7);
    end(&bed);
}

/* Mean distance to the shape of what the engine makes of a cloud. */
static double off_result(const struct vt_shape *shape, const struct vor_cloud *in,
                         struct vor_report *report)
{
    struct vt_engine engine;
    struct vor_cloud out;
    double mean;

    vt_engine_open(&engine, 2);
    vt_ask_set(&engine, "points=2000 polish=10");
    vt_engine_resample(&engine, &out, report, in);
    mean = vt_off_mean(shape, &out);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return mean;
}

/* A lattice shaken by a twentieth of its cell is none, and hardly another cloud. */
VT_TEST_FIGURES(a_result_lies_nearer_to_the_surface_than_without, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    for (int i = 0; i < VT_SMOOTH; i++) {
        const struct vt_shape *shape = &vt_shapes[i];
        struct vor_cloud cloud;
        struct vor_report with, without;
        double cell = 1.2 * sqrt(shape->area / MANY), nearer, farther;

        shape->make(&cloud, (uint64_t)_i, MANY);
        snap_even(&cloud, cell);
        nearer = off_result(shape, &cloud, &with);
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(with.lattice[c], cell, 1e-4 * cell);
        ck_assert_uint_gt(with.off_lattice, 1000);
        for (size_t j = 0; j < 3 * cloud.n; j += 3) /* those of a cell alike */
            for (size_t c = 0; c < 3; c++)
                cloud.xyz[j + c] +=
                    (float)(0.05 * cell * (vt_unit(vt_hash(&cloud.xyz[j], 12), c) - 0.5));
        farther = off_result(shape, &cloud, &without);
        ck_assert_uint_eq(without.off_lattice, 0);
        ck_assert(without.lattice[0] == 0);
        ck_assert_msg(nearer < 0.97 * farther, "%s: %g, without %g", shape->name, nearer, farther);
        vor_cloud_free(&cloud);
    }
}

static void restore(struct vor_cloud *cloud, struct vor_report *report, unsigned threads)
{
    struct vt_engine engine;

    vt_engine_open(&engine, threads);
    memset(report, 0, sizeof *report);
    vt_assert_ok(vor_restore_cloud(cloud, report, &engine.spec, &engine.run, &vt_err));
    vt_engine_close(&engine);
}

/* Of cells; no other lattice has both. */
#define FINER 0.61803399

/* One lattice, of cells of half a spacing to one and a half; or one on each side of y or z = 0; or
 * for each half of the points, all over the shape; or on each side, one after the other; or on one
 * side a part of the other's places. */
VT_TEST_FIGURES(restored_points_lie_nearer_each_in_its_cell, VT_FEWER(SEEDS))
{
    for (int i = 0; i < 7; i++) {
        const struct vt_shape *shape = &vt_shapes[(_i + i) % VT_SMOOTH];
        size_t axis = shape == &vt_shapes[VT_TORUS] ? 1 : 2;
        double wide = (i < 3 ? 0.5 * i + 0.5 : 1.2) * spacing(shape), was2 = 0, is2 = 0;
        struct vor_cloud cloud[4]; /* truth, coded, restored by one thread and by three */
        struct vor_report report, spread;

        for (int j = 0; j < 4; j++)
            shape->make(&cloud[j], (uint64_t)_i, N);
        for (size_t j = axis; i == 5 && j < 3 * N; j += 3)
            cloud[0].xyz[j] = copysignf(cloud[0].xyz[j], j < 3 * N / 2 ? -1 : 1);
        for (size_t j = 0; j < 9 * N; j++) {
            const float *at = &cloud[0].xyz[j % (3 * N) - j % 3];
            int first = i == 4 ? j / 3 % N < N / 2 : at[axis] < 0;
            double h = i >= 3 && first ? (i == 6 ? 0.25 : FINER) * wide : wide;

            cloud[1 + j / (3 * N)].xyz[j % (3 * N)] = (float)(h * rint((double)at[j % 3] / h));
        }
        restore(&cloud[2], &report, 1);
        restore(&cloud[3], &report, 3);
        ck_assert_mem_eq(cloud[2].xyz, cloud[3].xyz, 3 * N * sizeof(float));
        ck_assert_uint_eq(report.warnings_count, i < 3 ? 0 : i == 6 ? 1 : 2);
        (void)off_result(shape, &cloud[1], &spread);
        ck_assert_uint_eq(spread.warnings_count, i >= 3 && i < 6);
        if (i >= 3) {
            ck_assert_uint_eq(report.warnings[0].says, VOR_WARNING_PITCHES);
            ck_assert_double_eq_tol(report.warnings[0].value, wide, 1e-4 * wide);
        }
        if (i >= 3 && i < 6) {
            ck_assert_uint_eq(spread.warnings[0].says, VOR_WARNING_PITCHES);
            ck_assert_double_eq_tol(spread.warnings[0].limit, FINER * wide, 1e-4 * wide);
        }
        ck_assert_uint_gt(report.off_lattice, i == 3 ? N / 3 : i == 4 ? N / 2 : 9 * N / 10);
        ck_assert_uint_eq(vt_coincident(&cloud[2]), vt_coincident(&cloud[1]));
        for (size_t j = 0; j < 3 * N; j++) {
            ck_assert(fabsf(cloud[2].xyz[j] - cloud[1].xyz[j]) < (float)(0.501 * wide));
            was2 += pow((double)(cloud[1].xyz[j] - cloud[0].xyz[j]), 2);
            is2 += pow((double)(cloud[2].xyz[j] - cloud[0].xyz[j]), 2);
        }
        ck_assert_double_lt(is2 / was2, i >= 3 ? 0.9 : 0.8);
        ck_assert_double_lt(vt_off_mean(shape, &cloud[2]) / vt_off_mean(shape, &cloud[1]),
                            i >= 3 ? 0.8 : 0.45);
        for (int j = 0; j < 4; j++)
            vor_cloud_free(&cloud[j]);
    }
}

/* No lattice, cells of a twentieth of the distance between points, too few points. */
VT_TEST_FIGURES(restore_leaves_alone_what_it_cannot_tell, 1)
{
    for (int i = 0; i < 3; i++) {
        struct vor_cloud cloud;
        struct vor_report report;
        uint64_t was;

        vt_cloud_torus(&cloud, (uint64_t)_i, i == 2 ? 3 : N);
        if (i == 1)
            snap_even(&cloud, 0.05 * 0.5 * spacing(&vt_shapes[VT_TORUS]));
        was = vt_cloud_hash(&cloud);
        restore(&cloud, &report, 2);
        ck_assert_uint_eq(vt_cloud_hash(&cloud), was);
        ck_assert_uint_eq(report.off_lattice, 0);
        ck_assert_int_eq(report.warnings[0].says, VOR_WARNING_NOT_RESTORED);
        ck_assert_uint_eq(report.warnings_count, 1);
        vor_cloud_free(&cloud);
    }
}

/* Whole numbers; cells that a codec has; more points than cells that a plane has; no lattice. */
VT_TEST_FIGURES(a_result_on_the_lattice_of_its_input_has_each_place_once, VT_FEWER(SEEDS))
{
    static const struct {
        double cell, shift;
        const char *points;
        vor_status status;
    } rows[] = {{1, 0, "9000", VOR_OK},
                {0.7, 1e5, "9000", VOR_OK},
                {1, 0, "2500", VOR_E_TARGET},
                {0, 0, "900", VOR_E_PARAM}};
    uint64_t hash = 0;

    for (size_t k = 0; k < 2 * sizeof rows / sizeof rows[0]; k++) {
        double cell = rows[k / 2].cell, shift = rows[k / 2].shift;
        int is_flat = rows[k / 2].status == VOR_E_TARGET;
        struct vor_cloud in, out;
        struct vor_report report;
        struct vt_engine engine;

        vt_cloud_sphere(&in, (uint64_t)_i, 6000);
        for (size_t j = 0; j < 3 * in.n; j++) {
            double x = is_flat ? (double)(j % 3 == 0   ? j / 3 % 40
                                          : j % 3 == 1 ? j / 120 % 40
                                                       : 5)
                               : 40 * (double)in.xyz[j];

            in.xyz[j] = (float)(cell > 0 ? rint(x) * cell + shift : x);
        }
        vt_engine_open(&engine, 1 + 2 * (k % 2));
        vt_engine_set(&engine, "points", rows[k / 2].points);
        vt_engine_set(&engine, "lattice", "keep");
        ck_assert_int_eq(vt_engine_try(&engine, &out, &report, &in), rows[k / 2].status);
        if (rows[k / 2].status == VOR_OK) {
            ck_assert_uint_eq(out.n, 9000);
            ck_assert_uint_eq(vt_coincident(&out), 0);
            ck_assert(k % 2 == 0 || hash == vt_cloud_hash(&out));
            hash = vt_cloud_hash(&out);
        }
        for (size_t j = 0; j < 3 * out.n; j++) {
            double i = (out.origin[j % 3] + (double)out.xyz[j] - shift) / cell;

            ck_assert(fabs(i - rint(i)) <= (shift > 0 ? 0.03 : 0));
        }
        vor_cloud_free(&out);
        vt_engine_close(&engine);
        vor_cloud_free(&in);
    }
    vt_assert_no_leak();
}
