/* Insertion of points between oriented samples. */
#include "core/lop/insert.h"

#include "core/base/linalg.h"
#include "core/lop/between.h"
#include "core/lop/power.h"
#include "core/lop/tree.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_lop.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static struct vor_lop_insert_how how_of(double spacing, double rho)
{
    static struct vor_spec spec;

    vor_spec_preset(&spec, vor_process_find("resample"));
    return (struct vor_lop_insert_how){
        .rho = rho, .sigma_n = 15 * pi / 180, .sigma_p = 2 * spacing, .spec = &spec};
}

/* Points that the last call inserted, those put between others not counted. */
static size_t inserted;

static vor_status try_insert(struct vor_lop_samples *samples, size_t n,
                             const struct vor_lop_insert_how *how, const struct vor_run *run)
{
    struct vor_outcome told;
    struct vor_domain domain = {.unit = 1};
    vor_status status;
    size_t before = samples->n;

    memset(&told, 0, sizeof told);
    status = vor_lop_insert(samples, n, how, &domain, &told, run, &vt_err);
    inserted = told.steps[VOR_RUN_STAGE_INSERT];
    if (status == VOR_OK && n > before) {
        ck_assert_uint_eq(samples->n, n);
        if (told.stopped == VOR_STOPPED_CALLER)
            return status;
        ck_assert_uint_eq(inserted, n - before);
        ck_assert_uint_eq(told.last.step, how->polish > 0 ? how->polish : n - before);
    }
    return status;
}

static void insert(struct vor_lop_samples *samples, size_t n, const struct vor_lop_insert_how *how)
{
    struct vt_engine engine;

    vt_engine_open(&engine, 2);
    vt_assert_ok(try_insert(samples, n, how, &engine.run));
    vt_engine_close(&engine);
}

/* How far point i is from the plane through the origin with a normal, and how far its own normal
 * from that, in degrees. */
static double off_plane(const struct vor_lop_samples *samples, size_t i, const double normal[3],
                        double *turned)
{
    double x[3], n[3];

    for (size_t c = 0; c < 3; c++) {
        x[c] = (double)samples->xyz[3 * i + c];
        n[c] = (double)samples->normal[3 * i + c];
    }
    *turned = acos(fmin(1, vor_dot(n, normal))) * 180 / pi;
    return fabs(vor_dot(x, normal));
}

/* Points of a wedge that are put between others: on its planes, with their normals, none past the
 * edge, the same for any number of threads. */
VT_TEST(points_between_others_stay_on_their_side_of_an_edge)
{
    enum { MANY = 7001 };
    double normal[2][3], spacing, turned;
    struct vor_lop_samples samples[2];

    vt_lop_wedge_normals(90, normal);
    for (unsigned k = 0; k < 2; k++) {
        struct vor_lop_samples begun;
        struct vt_engine engine;

        vt_engine_open(&engine, 1 + 2 * k);
        vt_lop_wedge(&begun, 90, 800, 5, &spacing);
        vt_assert_ok(vor_lop_samples_init(&samples[k], MANY, &vt_memory, &vt_err));
        samples[k].n = begun.n;
        memcpy(samples[k].xyz, begun.xyz, begun.n * 3 * sizeof(float));
        memcpy(samples[k].normal, begun.normal, begun.n * 3 * sizeof(float));
        vt_assert_ok(vor_lop_between(&samples[k], MANY, 1, &engine.run, &vt_err));
        ck_assert_uint_eq(samples[k].n, MANY);
        vor_lop_samples_free(&begun);
        vt_engine_close(&engine);
    }
    for (size_t i = 0; i < MANY; i++) {
        int side = (double)samples[0].xyz[3 * i] > 0;

        ck_assert_double_lt(off_plane(&samples[0], i, normal[side], &turned), 1e-6);
        ck_assert_double_lt(turned, 0.1);
    }
    ck_assert_mem_eq(samples[0].xyz, samples[1].xyz, MANY * 3 * sizeof(float));
    ck_assert_mem_eq(samples[0].normal, samples[1].normal, MANY * 3 * sizeof(float));
    vor_lop_samples_free(&samples[0]);
    vor_lop_samples_free(&samples[1]);
}

VT_TEST(points_that_all_coincide_leave_no_place)
{
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how = how_of(0.1, 0);
    struct vt_engine engine;

    vt_engine_open(&engine, 1);
    vt_assert_ok(vor_lop_samples_init(&samples, 30, &vt_memory, &vt_err));
    for (samples.n = 0; samples.n < 30; samples.n++) {
        memcpy(&samples.xyz[3 * samples.n], (float[3]){0.1F, 0.2F, 0.3F}, 3 * sizeof(float));
        memcpy(&samples.normal[3 * samples.n], (float[3]){0, 0, 1}, 3 * sizeof(float));
    }
    vt_assert_fails(VOR_E_DEGENERATE, try_insert(&samples, 60, &how, &engine.run));
    vor_lop_samples_free(&samples);
    vt_engine_close(&engine);
}

VT_TEST(powers_are_those_of_pow)
{
    for (uint64_t i = 0; i < 500; i++) {
        double x = 1 + 2 * vt_unit(1, i), y = 20 * vt_unit(2, i), want = pow(x, y);

        ck_assert_double_eq_tol(vor_lop_power(x, y), want, 3e-6 * want);
        ck_assert_double_eq_tol(vor_lop_power(x, floor(y)), pow(x, floor(y)), 1e-14 * want);
    }
    ck_assert(vor_lop_power(1.5, 0) <= 1 && vor_lop_power(1.5, 0) >= 1);
    ck_assert_double_eq_tol(vor_lop_power(2.25, 0.5), 1.5, 1e-15);
}

/* A point of a cloud that is dense here and there, with a few that coincide. */
static void clustered(uint64_t seed, size_t i, float xyz[3], float normal[3])
{
    double length = 0, n[3];
    size_t at = i % 17 == 0 ? 0 : i;

    for (size_t c = 0; c < 3; c++) {
        double u = 2 * vt_unit(seed, 3 * at + c) - 1;

        xyz[c] = (float)(at % 2 ? u : 0.3 + 0.02 * u);
        n[c] = vt_unit(seed + 1, 3 * i + c) - 0.5;
        length += n[c] * n[c];
    }
    for (size_t c = 0; c < 3; c++)
        normal[c] = (float)(n[c] / sqrt(length));
}

VT_TEST_LOOP(the_tree_finds_what_looking_at_every_point_finds, VT_SOAK_LOOPS(2, 20))
{
    enum { MANY = 3000 };
    static float xyz[MANY][3], normal[MANY][3];
    struct vor_lop_gathered gathered;
    struct vor_lop_tree tree;

    vt_assert_ok(vor_lop_tree_init(&tree, &vt_memory, &vt_err));
    for (size_t i = 0; i < MANY; i++) {
        double radius = (i % 5 ? 0.004 : 0.15) * vt_unit((uint64_t)_i + 2, i), clear2 = 0.01;
        struct vor_lop_base base = {.radius2 = radius * radius, .end = {normal[0], normal[i / 2]}};
        uint64_t sum = 0;
        unsigned count = 0;

        clustered((uint64_t)_i, i, xyz[i], normal[i]);
        vt_assert_ok(vor_lop_tree_add(&tree, (uint32_t)i, xyz[i], normal[i], &vt_err));
        memcpy(base.xyz, xyz[i], sizeof base.xyz);
        vor_lop_tree_gather(&gathered, &tree, xyz[i], radius);
        for (size_t j = 0; j <= i; j++)
            if (vor_distance2f(xyz[i], xyz[j]) <= radius * radius) {
                count++;
                sum += j;
            }
        if (count > VOR_LOP_GATHERED_MAX)
            continue;
        ck_assert_uint_eq(gathered.count, count);
        for (unsigned j = 0; j < count; j++)
            sum -= gathered.index[j];
        ck_assert_uint_eq(sum, 0);
        clear2 = vor_lop_tree_clearance2(&tree, &base, clear2);
        ck_assert(clear2 >= vor_lop_gathered_clearance2(&gathered, &base, 0.01) &&
                  clear2 <= vor_lop_gathered_clearance2(&gathered, &base, 0.01));
    }
    vor_lop_tree_free(&tree);
}

VT_TEST(the_polish_pushes_no_point_over_an_open_border)
{
    enum { SIDE = 24 };
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how = how_of(1.0 / SIDE, 0);
    double most = 0, before = 0;

    how.polish = 60;
    vt_assert_ok(vor_lop_samples_init(&samples, (size_t)SIDE * SIDE, &vt_memory, &vt_err));
    vt_lop_square(&samples, SIDE, 0.1, 1, 0, 9);
    for (size_t i = 0; i < 2 * samples.n; i++)
        before = fmax(before, fabs((double)samples.xyz[3 * (i / 2) + i % 2]));
    insert(&samples, 2400, &how);
    for (size_t i = 0; i < 2 * samples.n; i++)
        most = fmax(most, fabs((double)samples.xyz[3 * (i / 2) + i % 2]));
    ck_assert_double_lt(most, before + 0.25 / SIDE);
    vor_lop_samples_free(&samples);
}
