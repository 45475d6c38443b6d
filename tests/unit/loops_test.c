/* Where an input ends: loops of surfaces whose borders are known, and of closed ones. */
#include "core/input/loops.h"

#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 2, N = 4000, LARGE = 8000, CLOSED = 20, HOLES = 10 };

static vor_status try(struct vor_inspect *out, const struct vor_cloud *in, struct vt_engine *engine)
{
    struct vor_artefacts inputs, outputs;
    vor_status status;

    vor_spec_preset(&engine->spec, vor_process_find("inspect"));
    vor_artefacts_init(&inputs, &vt_memory);
    vor_artefacts_init(&outputs, &vt_memory);
    inputs.item[inputs.count++] =
        (struct vor_artefact){.name = "cloud", .kind = VOR_ARTEFACT_CLOUD, .cloud = *in};
    status = vor_engine_run(&outputs, &inputs, &engine->spec, &engine->run, &vt_err);
    if (status == VOR_OK)
        *out = *(const struct vor_inspect *)vor_artefacts_values(&outputs, "inspect",
                                                                 &vor_inspect_members);
    vor_artefacts_free(&outputs);
    return status;
}

/* The document of a cloud, which is freed. */
static struct vor_inspect inspect(struct vor_cloud *cloud)
{
    struct vt_engine engine;
    struct vor_inspect told;

    vt_engine_open(&engine, 2);
    vt_assert_ok(try(&told, cloud, &engine));
    vt_engine_close(&engine);
    vor_cloud_free(cloud);
    vt_assert_no_leak();
    for (unsigned i = 0; i < told.loops_count; i++)
        ck_assert_uint_eq(told.loops[i].id, i + 1);
    return told;
}

/* The next larger loop is told first. */
static void assert_loop(const struct vor_inspect *told, unsigned i, enum vor_loop_kind kind,
                        enum vor_loop_why why, double length, double share)
{
    const struct vor_loop_told *loop = &told->loops[i];

    ck_assert_uint_lt(i, told->loops_count);
    ck_assert_msg(loop->kind == kind && loop->why == why, "loop %u: kind %d, why %d, %g turns", i,
                  (int)loop->kind, (int)loop->why, loop->turns);
    ck_assert_msg(fabs(loop->length - length) < share * length, "loop %u: %g long, want %g", i,
                  loop->length, length);
    ck_assert(i == 0 || loop->length <= told->loops[i - 1].length);
}

static void assert_centre(const struct vor_inspect *told, unsigned i, double x, double y, double z,
                          double most)
{
    const double *c = told->loops[i].centre;
    double off = sqrt((c[0] - x) * (c[0] - x) + (c[1] - y) * (c[1] - y) + (c[2] - z) * (c[2] - z));

    ck_assert_msg(off <= most, "loop %u: %g off its centre, want at most %g", i, off, most);
}

VT_TEST_FIGURES(a_square_has_one_rim, SEEDS)
{
    double spacing = 1 / sqrt(N);
    struct vor_cloud cloud;
    struct vor_inspect told;

    vt_cloud_square(&cloud, (uint64_t)_i, N);
    told = inspect(&cloud);
    ck_assert_uint_eq(told.border_loops, 1);
    ck_assert_uint_eq(told.border_holes, 0);
    ck_assert_uint_eq(told.border_open, 0);
    assert_loop(&told, 0, VOR_LOOP_RIM, VOR_LOOP_WITHIN, 4, 0.04);
    assert_centre(&told, 0, 0.5, 0.5, 0, spacing);
    ck_assert_double_eq_tol(told.loops[0].turns, -1, 0.2);
    ck_assert_double_eq(told.border_length, told.loops[0].length);
}

VT_TEST_FIGURES(a_tube_has_two_rims, SEEDS)
{
    double spacing = vt_spacing(&vt_metrics[VT_CYLINDER], N);
    struct vor_cloud cloud;
    struct vor_inspect told;

    vt_metrics[VT_CYLINDER].make(&cloud, (uint64_t)_i, N, 0);
    told = inspect(&cloud);
    ck_assert_uint_eq(told.border_loops, 2);
    ck_assert_uint_eq(told.border_open, 0);
    for (unsigned i = 0; i < 2; i++) {
        assert_loop(&told, i, VOR_LOOP_RIM, VOR_LOOP_ONE_SIDE, M_PI, 0.06);
        assert_centre(&told, i, 0, 0, told.loops[i].centre[2] > 1 ? 2 : 0, spacing);
    }
    ck_assert_double_gt(fabs(told.loops[0].centre[2] - told.loops[1].centre[2]), 1.9);
}

/* Takes the points nearer to the axis point at the given z than `radius` out. */
static void punch(struct vor_cloud *cloud, double z, double radius)
{
    size_t left = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        const float *p = &cloud->xyz[3 * i];
        double d = sqrt((double)p[0] * (double)p[0] + (double)p[1] * (double)p[1] +
                        ((double)p[2] - z) * ((double)p[2] - z));

        if (d >= radius)
            memmove(&cloud->xyz[3 * left++], p, 3 * sizeof *p);
    }
    cloud->n = left;
}

/* A ball of radius 1 with a hole at the top and one half as wide, in spacings, at the bottom. */
static double punched(struct vor_cloud *cloud, uint64_t seed, double wide)
{
    double spacing = sqrt(4 * M_PI / LARGE);

    vt_cloud_sphere(cloud, seed, LARGE);
    punch(cloud, 1, wide / 2 * spacing);
    punch(cloud, -1, wide / 4 * spacing);
    return spacing;
}

/* Length of the circle on the ball at that distance from its pole. */
static double circle(double distance)
{
    return 2 * M_PI * distance * sqrt(1 - distance * distance / 4);
}

/* Ten and twenty spacings across. */
VT_TEST_FIGURES(holes_are_told_with_length_and_centre, VT_SOAK_LOOPS(SEEDS, 8 * SEEDS))
{
    struct vor_cloud cloud;
    double spacing = punched(&cloud, (uint64_t)_i, 20), large = 10 * spacing, small = 5 * spacing;
    struct vor_inspect told = inspect(&cloud);

    ck_assert_uint_eq(told.border_loops, 2);
    ck_assert_uint_eq(told.border_holes, 2);
    assert_loop(&told, 0, VOR_LOOP_HOLE, VOR_LOOP_AROUND, circle(large), 0.1);
    assert_loop(&told, 1, VOR_LOOP_HOLE, VOR_LOOP_AROUND, circle(small), 0.1);
    assert_centre(&told, 0, 0, 0, 1 - large * large / 2, spacing);
    assert_centre(&told, 1, 0, 0, small * small / 2 - 1, spacing);
}

/* The smaller hole of a ball with two. Points lie so unevenly around it that one in forty is not
 * found, and that lengths differ by 8 %; on the mean they are 7 % short. */
VT_TEST_FIGURES(holes_of_five_spacings_are_mostly_found, VT_ONCE(1))
{
    struct vt_engine engine;
    unsigned found = 0;
    double sum = 0;

    vt_engine_open(&engine, 2);
    for (uint64_t seed = 0; seed < HOLES; seed++) {
        struct vor_loops loops;
        struct vor_domain domain;
        struct vor_cloud cloud;
        double spacing = punched(&cloud, seed, 10);

        vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
        vt_assert_ok(vor_loops_find(&loops, &domain, &engine.run, &vt_err));
        ck_assert(loops.count == 1 || loops.count == 2);
        for (size_t i = 1; i < loops.count; i++, found++)
            sum += loops.loop[i].length * domain.unit / circle(2.5 * spacing);
        vor_loops_free(&loops);
        vor_domain_free(&domain);
        vor_cloud_free(&cloud);
    }
    vt_engine_close(&engine);
    vt_assert_no_leak();
    ck_assert_uint_ge(found, HOLES - 2);
    ck_assert_double_eq_tol(sum / found, 0.93, 0.07);
}

/* White noise has empty discs of its own: one sphere in some may be told a loop. */
VT_TEST_FIGURES(hardly_any_closed_surface_has_a_loop, VT_SMOOTH)
{
    struct vt_engine engine;
    unsigned with = 0;

    vt_engine_open(&engine, 2);
    for (uint64_t seed = 0; seed < CLOSED; seed++) {
        struct vor_loops loops;
        struct vor_domain domain;
        struct vor_cloud cloud;

        vt_shapes[_i].make(&cloud, seed, N);
        vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
        vt_assert_ok(vor_loops_find(&loops, &domain, &engine.run, &vt_err));
        with += loops.count > 0;
        ck_assert_uint_le(loops.count, 1);
        vor_loops_free(&loops);
        vor_domain_free(&domain);
        vor_cloud_free(&cloud);
    }
    vt_engine_close(&engine);
    vt_assert_no_leak();
    ck_assert_uint_le(with, 1);
}

VT_TEST_FIGURES(a_small_sheet_over_a_large_one_hides_no_rim, 3)
{
    static const double gaps[] = {0.5, 1, 1.5};
    double gap = gaps[_i] / sqrt(2 * N);
    struct vor_cloud cloud;
    struct vor_inspect told;

    vt_cloud_square(&cloud, 5, 2 * N + N / 2);
    for (size_t i = 0; i < N / 2; i++) {
        cloud.xyz[3 * i] = (float)(0.25 + 0.5 * (double)cloud.xyz[3 * i]);
        cloud.xyz[3 * i + 1] = (float)(0.25 + 0.5 * (double)cloud.xyz[3 * i + 1]);
        cloud.xyz[3 * i + 2] = (float)gap;
    }
    told = inspect(&cloud);
    ck_assert_int_eq(told.sheets, VOR_YES);
    ck_assert_uint_eq(told.border_loops, 2);
    assert_loop(&told, 0, VOR_LOOP_RIM, VOR_LOOP_WITHIN, 4, 0.05);
    assert_loop(&told, 1, VOR_LOOP_RIM, VOR_LOOP_WITHIN, 2, 0.05);
}

VT_TEST_FIGURES(places_far_from_zero_keep_their_digits, VT_ONCE(1))
{
    const double origin[3] = {500000, 4100000, 300};
    struct vor_cloud cloud;
    struct vor_inspect here, there;

    (void)punched(&cloud, 1, 20);
    here = inspect(&cloud);
    (void)punched(&cloud, 1, 20);
    memcpy(cloud.origin, origin, sizeof origin);
    there = inspect(&cloud);
    ck_assert_uint_eq(here.loops_count, 2);
    ck_assert_uint_eq(there.loops_count, 2);
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(there.loops[i].centre[c], origin[c] + here.loops[i].centre[c],
                                    1e-8);
}
