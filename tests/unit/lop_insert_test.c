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

/* Huang 2013, Sec. 5: the projection preserves sharp features. Points lie on the two planes, each
 * with the normal of its own and not beyond the edge, and come near it. */
START_TEST(points_inserted_lie_on_the_two_planes_of_a_wedge)
{
    static const double degrees[] = {90, 120, 150};
    double normal[2][3], spacing, nearest = 1;
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how;

    vt_lop_wedge(&samples, degrees[_i % 3], 800, (uint64_t)_i, &spacing);
    vt_lop_wedge_normals(degrees[_i % 3], normal);
    how = how_of(spacing, _i < 3 ? 0 : 5);
    insert(&samples, 4000, &how);
    for (size_t i = 0; i < samples.n; i++) {
        double x = (double)samples.xyz[3 * i], turned;
        int side = x > 0;

        ck_assert_double_lt(off_plane(&samples, i, normal[side], &turned), 1e-6);
        ck_assert_double_lt(turned, 0.1);
        nearest = fmin(nearest, fabs(x));
    }
    ck_assert_double_lt(nearest, 0.15 * spacing);
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

START_TEST(the_number_of_points_is_exact_and_samples_stay)
{
    static const size_t wanted[] = {0, 599, 600, 601, 1200, 9600};
    struct vor_lop_samples samples, before;
    struct vor_lop_insert_how how;
    double spacing;

    vt_lop_cube(&before, 600, 7, &spacing);
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        vt_lop_cube(&samples, 600, 7, &spacing);
        how = how_of(spacing, 5);
        insert(&samples, wanted[i], &how);
        ck_assert_uint_eq(samples.n, wanted[i] > 600 ? wanted[i] : 600);
        ck_assert_mem_eq(samples.xyz, before.xyz, 600 * 3 * sizeof(float));
        ck_assert_mem_eq(samples.normal, before.normal, 600 * 3 * sizeof(float));
        vor_lop_samples_free(&samples);
    }
    vor_lop_samples_free(&before);
    vt_assert_no_leak();
}
END_TEST

/* Share of the points inserted that lie within nine tenths of a spacing of an edge of the cube:
 * between those nearest to it and those of the second row. */
static double share_at_edges(double rho)
{
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how;
    double spacing, edges = 0;
    size_t begun;

    vt_lop_cube(&samples, 850, 3, &spacing);
    begun = samples.n;
    how = how_of(spacing, rho);
    insert(&samples, 1500, &how);
    for (size_t i = begun; i < samples.n; i++) {
        int faces = 0;

        for (size_t c = 0; c < 3; c++)
            faces += fabs((double)samples.xyz[3 * i + c]) > 0.6 - 0.9 * spacing;
        edges += faces > 1;
    }
    vor_lop_samples_free(&samples);
    return edges / (double)(1500 - begun);
}

/* Huang 2013, Fig. 8: from 850 to 1,500 points, the larger rho the more lie along the edges. */
START_TEST(a_larger_rho_puts_insertions_on_edges)
{
    static const double rho[] = {0, 1, 2.5, 5, 10};
    double before = 0;

    for (size_t i = 0; i < sizeof rho / sizeof *rho; i++) {
        double share = share_at_edges(rho[i]);

        ck_assert_double_ge(share, before);
        before = share;
    }
    ck_assert_double_lt(share_at_edges(0), 0.5);
    ck_assert_double_gt(before, 0.9);
    vt_assert_no_leak();
}
END_TEST

START_TEST(points_do_not_depend_on_threads)
{
    uint64_t hash[2][2] = {{0}};

    for (unsigned more = 0; more < 2; more++) {
        struct vor_lop_samples samples;
        struct vor_lop_insert_how how;
        struct vt_engine engine;
        double spacing;

        vt_lop_sphere(&samples, 1500, &spacing);
        how = how_of(spacing, 2.5);
        vt_engine_open(&engine, more ? 8 : 1);
        vt_assert_ok(try_insert(&samples, 4000, &how, &engine.run));
        vt_engine_close(&engine);
        hash[more][0] = vt_hash(samples.xyz, 3 * samples.n * sizeof(float));
        hash[more][1] = vt_hash(samples.normal, 3 * samples.n * sizeof(float));
        vor_lop_samples_free(&samples);
    }
    ck_assert_mem_eq(hash[0], hash[1], sizeof hash[0]);
    vt_assert_no_leak();
}
END_TEST

/* Departure in lop/latent.h: the distance is exact on a sphere. */
START_TEST(points_inserted_lie_on_a_sphere)
{
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how;
    double spacing;

    vt_lop_sphere(&samples, 500, &spacing);
    how = how_of(spacing, 0);
    insert(&samples, 4000, &how);
    for (size_t i = 0; i < samples.n; i++) {
        double x[3], n[3], r;

        for (size_t c = 0; c < 3; c++) {
            x[c] = (double)samples.xyz[3 * i + c];
            n[c] = (double)samples.normal[3 * i + c];
        }
        r = sqrt(vor_dot(x, x));
        ck_assert_double_eq_tol(r, 0.9, 1e-3);
        ck_assert_double_eq_tol(vor_dot(n, n), 1, 1e-5);
        ck_assert_double_gt(vor_dot(n, x) / r, cos(4 * pi / 180));
    }
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

/* Huang 2013, Fig. 7: whether an inner border is kept is decided by the size of neighbourhoods.
 * What is no wider than the spacing that the samples should have is no hole. */
START_TEST(a_hole_of_a_few_spacings_is_kept_or_filled)
{
    enum { SIDE = 40 };
    double radius = 2.0 / SIDE;

    for (int kind = 0; kind < 3; kind++) {
        struct vor_lop_samples samples;
        struct vor_lop_insert_how how = how_of(1.0 / SIDE, 0);
        size_t inside = 0;

        vt_assert_ok(vor_lop_samples_init(&samples, (size_t)SIDE * SIDE, &vt_memory, &vt_err));
        vt_lop_square(&samples, SIDE, 0.3, 1, radius, 5);
        how.fill = kind == 1;
        how.spacing = kind == 2 ? 2.0 / SIDE : 0;
        insert(&samples, 6000, &how);
        for (size_t i = 0; i < samples.n; i++)
            inside +=
                hypot((double)samples.xyz[3 * i], (double)samples.xyz[3 * i + 1]) < radius / 2;
        if (kind > 0)
            ck_assert_uint_gt(inside, 8);
        else
            ck_assert_uint_eq(inside, 0);
        vor_lop_samples_free(&samples);
    }
    vt_assert_no_leak();
}
END_TEST

/* Two sides of a plate thinner than the spacing: each is filled as evenly as if it were alone. */
START_TEST(sides_of_a_thin_plate_do_not_mix)
{
    enum { SIDE = 24, MANY = 5000 };
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how = how_of(1.0 / SIDE, 5);
    double thick = 0.2 / SIDE;
    size_t up = 0;

    vt_assert_ok(vor_lop_samples_init(&samples, (size_t)2 * SIDE * SIDE, &vt_memory, &vt_err));
    vt_lop_square(&samples, SIDE, thick / 2, 1, 0, 1);
    vt_lop_square(&samples, SIDE, -thick / 2, -1, 0, 2);
    insert(&samples, MANY, &how);
    for (size_t i = 0; i < samples.n; i++) {
        double facing = (double)samples.normal[3 * i + 2];

        ck_assert_double_eq_tol(fabs(facing), 1, 1e-6);
        ck_assert_double_eq_tol((double)samples.xyz[3 * i + 2], facing * thick / 2, 1e-6);
        up += facing > 0;
    }
    ck_assert_uint_gt(up, MANY / 2 - MANY / 20);
    ck_assert_uint_lt(up, MANY / 2 + MANY / 20);
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

/* Two sheets that face the same way, nearer than partners are looked for. */
START_TEST(sheets_over_each_other_do_not_mix)
{
    enum { SIDE = 24, MANY = 4000 };
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how = how_of(1.0 / SIDE, 0);
    double gap = 1.9 / SIDE;

    vt_assert_ok(vor_lop_samples_init(&samples, (size_t)2 * SIDE * SIDE, &vt_memory, &vt_err));
    vt_lop_square(&samples, SIDE, gap / 2, 1, 0, 1);
    vt_lop_square(&samples, SIDE, -gap / 2, 1, 0, 2);
    insert(&samples, MANY, &how);
    for (size_t i = 0; i < samples.n; i++)
        ck_assert_double_eq_tol(fabs((double)samples.xyz[3 * i + 2]), gap / 2, 0.05 * gap);
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

/* Answers `then` when it has been asked `left` times. */
struct waiter {
    int left;
    enum vor_answer then;
};

static enum vor_answer wait_poll(void *ctx)
{
    struct waiter *waiter = ctx;

    return waiter->left-- > 0 ? VOR_CONTINUE : waiter->then;
}

static enum vor_answer wait_progress(void *ctx, const struct vor_record *record)
{
    struct waiter *waiter = ctx;

    (void)record;
    return waiter->left < 0 ? waiter->then : VOR_CONTINUE;
}

/* How far the farthest point is from a sphere about the origin. */
static double off_sphere(const struct vor_lop_samples *samples, double radius)
{
    double most = 0;

    for (size_t i = 0; i < samples->n; i++) {
        double x[3] = {(double)samples->xyz[3 * i], (double)samples->xyz[3 * i + 1],
                       (double)samples->xyz[3 * i + 2]};

        most = fmax(most, fabs(sqrt(vor_dot(x, x)) - radius));
    }
    return most;
}

/* Inserts up to 20,000 points into 500 on a sphere under a watch that answers `then` when asked
 * `left` times. */
static vor_status insert_watched(int left, enum vor_answer then, size_t *n)
{
    struct waiter waiter = {left, then};
    struct vor_watch watch = {.ctx = &waiter, .progress = wait_progress, .poll = wait_poll};
    struct vor_no_stop no_stop;
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how;
    struct vt_engine engine;
    double spacing;
    vor_status status;

    vt_engine_open(&engine, 1);
    engine.run.watch = &watch;
    engine.run.no_stop = vor_no_stop_watch(&no_stop, &watch);
    vt_lop_sphere(&samples, 500, &spacing);
    how = how_of(spacing, 0);
    status = try_insert(&samples, 20000, &how, &engine.run);
    *n = samples.n;
    if (status == VOR_OK) /* chords of the 500 are 7e-3 off in their middles */
        ck_assert_double_lt(off_sphere(&samples, 0.9), 1e-3);
    vor_lop_samples_free(&samples);
    vt_engine_close(&engine);
    vt_assert_no_leak();
    return status;
}

START_TEST(a_cancel_or_a_stop_ends_the_insertion_soon)
{
    size_t n;

    for (int left = 0; left < 40; left += 13) {
        vt_assert_fails(VOR_E_CANCELLED, insert_watched(left, VOR_CANCEL, &n));
        ck_assert_uint_le(n, 500 + 256 * ((size_t)left + 1));
        vt_assert_ok(insert_watched(left, VOR_STOP, &n));
        ck_assert_uint_eq(n, 20000);
        ck_assert_uint_le(inserted, 256 * ((size_t)left + 1));
    }
}
END_TEST

/* Points of a wedge that are put between others: on its planes, with their normals, none past the
 * edge, the same for any number of threads. */
START_TEST(points_between_others_stay_on_their_side_of_an_edge)
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
    vt_assert_no_leak();
}
END_TEST

START_TEST(points_that_all_coincide_leave_no_place)
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
    vt_assert_no_leak();
}
END_TEST

START_TEST(each_allocation_may_fail)
{
    struct vt_engine engine;
    vor_status status = VOR_E_NOMEM;

    vt_engine_open(&engine, 1);
    for (size_t fail = 1; status == VOR_E_NOMEM; fail++) {
        struct vor_lop_samples samples;
        struct vor_lop_insert_how how;
        double spacing;

        ck_assert_uint_lt(fail, 100);
        vt_lop_sphere(&samples, 200, &spacing);
        how = how_of(spacing, 0);
        how.polish = 2;
        vt_memory.fail_at = vt_memory.calls + fail;
        status = try_insert(&samples, 1500, &how, &engine.run);
        vt_memory.fail_at = 0;
        vor_lop_samples_free(&samples);
        if (status != VOR_OK)
            ck_assert_int_eq(status, VOR_E_NOMEM);
    }
    vt_engine_close(&engine);
    vt_assert_no_leak();
}
END_TEST

START_TEST(powers_are_those_of_pow)
{
    for (uint64_t i = 0; i < 500; i++) {
        double x = 1 + 2 * vt_unit(1, i), y = 20 * vt_unit(2, i), want = pow(x, y);

        ck_assert_double_eq_tol(vor_lop_power(x, y), want, 3e-6 * want);
        ck_assert_double_eq_tol(vor_lop_power(x, floor(y)), pow(x, floor(y)), 1e-14 * want);
    }
    ck_assert(vor_lop_power(1.5, 0) <= 1 && vor_lop_power(1.5, 0) >= 1);
    ck_assert_double_eq_tol(vor_lop_power(2.25, 0.5), 1.5, 1e-15);
}
END_TEST

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

/* Oracle: the tree finds what looking at every point finds. */
START_TEST(the_tree_finds_what_looking_at_every_point_finds)
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
    vt_assert_no_leak();
}
END_TEST

/* Share of delta's definition that a test needs: mean and delta of the nearest distances. */
static double delta_of(const struct vor_lop_samples *samples, double *mean)
{
    double sum = 0, sum2 = 0;

    for (size_t i = 0; i < samples->n; i++) {
        double nearest2 = INFINITY;

        for (size_t j = 0; j < samples->n; j++)
            if (j != i)
                nearest2 =
                    fmin(nearest2, vor_distance2f(&samples->xyz[3 * i], &samples->xyz[3 * j]));
        sum += sqrt(nearest2);
        sum2 += nearest2;
    }
    *mean = sum / (double)samples->n;
    return sqrt(sum2 / (double)samples->n - *mean * *mean) / *mean;
}

/* The points on the edge of a wedge leave no longer stretch of it empty. */
static double longest_gap(const struct vor_lop_samples *samples, double *most)
{
    static unsigned char bin[200];
    size_t run = 0, longest = 0;

    *most = 0;
    memset(bin, 0, sizeof bin);
    for (size_t i = 0; i < samples->n; i++)
        if (fabs((double)samples->xyz[3 * i]) < 1e-6) {
            bin[(size_t)(((double)samples->xyz[3 * i + 1] + 0.5) * 199.9)] = 1;
            (*most)++;
        }
    for (size_t i = 4; i < 196; i++) {
        run = bin[i] ? 0 : run + 1;
        longest = run > longest ? run : longest;
    }
    return (double)longest / 200;
}

START_TEST(the_polish_evens_out_and_fills_the_edge_of_a_wedge)
{
    static const double degrees[] = {90, 120, 150};
    double normal[2][3], spacing, mean, row, gap;
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how;

    vt_lop_wedge(&samples, degrees[_i], 800, (uint64_t)_i, &spacing);
    vt_lop_wedge_normals(degrees[_i], normal);
    how = how_of(spacing, 0);
    how.polish = 12;
    insert(&samples, 3000, &how);
    for (size_t i = 0; i < samples.n; i++) {
        double x = (double)samples.xyz[3 * i], turned, other;
        double off = off_plane(&samples, i, normal[x > 0], &turned);

        ck_assert_double_lt(off, 1e-6);
        if (fabs(x) < 1e-6) {
            (void)off_plane(&samples, i, normal[x <= 0], &other);
            turned = fmin(turned, other);
        }
        ck_assert_double_lt(turned, 0.1);
    }
    ck_assert_double_lt(delta_of(&samples, &mean), 0.07);
    gap = longest_gap(&samples, &row);
    ck_assert_double_lt(gap, 2.2 * mean);
    ck_assert_double_gt(row, 0.7 / mean);
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

/* Adds a sample on the left side of a wedge, so far past its edge. */
static void add_stray(struct vor_lop_samples *samples, size_t at, const double normal[3],
                      double past, double y)
{
    double xyz[3] = {past * normal[2], y, -past * normal[0]};

    for (size_t c = 0; c < 3; c++) {
        samples->xyz[3 * at + c] = (float)xyz[c];
        samples->normal[3 * at + c] = (float)normal[c];
    }
}

/* Samples past an edge on the plane of their own side, as noise leaves them, and one far away from
 * all others: the first come back with what was inserted beside them, the other harms nobody. */
START_TEST(the_polish_brings_back_what_lies_past_an_edge)
{
    double normal[2][3], spacing, mean;
    struct vor_lop_samples samples;
    struct vor_lop_insert_how how;
    size_t past = 0;

    vt_lop_wedge(&samples, 90, 800, 4, &spacing);
    vt_lop_wedge_normals(90, normal);
    for (size_t k = 0; k < 5; k++)
        add_stray(&samples, 90 * k, normal[0], 0.6 * spacing, 0.2 * (double)k - 0.4);
    samples.xyz[2] = 0.95F;
    how = how_of(spacing, 0);
    how.polish = 8;
    insert(&samples, 3000, &how);
    for (size_t i = 1; i < samples.n; i++) {
        double x = (double)samples.xyz[3 * i];

        past += ((double)samples.normal[3 * i] < 0 ? x : -x) > 0.15 * spacing;
    }
    ck_assert_uint_eq(past, 0);
    ck_assert_double_lt(delta_of(&samples, &mean), 1);
    ck_assert_double_lt(mean, spacing);
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

START_TEST(the_polish_keeps_a_sphere_and_does_not_depend_on_threads)
{
    uint64_t hash[2];

    for (unsigned more = 0; more < 2; more++) {
        struct vor_lop_samples samples;
        struct vor_lop_insert_how how;
        struct vt_engine engine;
        double spacing, mean;

        vt_lop_sphere(&samples, 600, &spacing);
        how = how_of(spacing, 0);
        how.polish = 20;
        vt_engine_open(&engine, more ? 8 : 1);
        vt_assert_ok(try_insert(&samples, 2500, &how, &engine.run));
        vt_engine_close(&engine);
        for (size_t i = 0; i < samples.n; i++) {
            const float *x = &samples.xyz[3 * i];

            ck_assert_double_eq_tol(vor_distance2f(x, (float[3]){0, 0, 0}), 0.81, 2e-3);
        }
        ck_assert_double_lt(delta_of(&samples, &mean), 0.05);
        hash[more] = vt_hash(samples.xyz, 3 * samples.n * sizeof(float)) ^
                     vt_hash(samples.normal, 3 * samples.n * sizeof(float));
        vor_lop_samples_free(&samples);
    }
    ck_assert(hash[0] == hash[1]);
    vt_assert_no_leak();
}
END_TEST

START_TEST(the_polish_pushes_no_point_over_an_open_border)
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
    vt_assert_no_leak();
}
END_TEST

/* Answers `then` in the third record of the polish. */
static enum vor_answer third_step(void *ctx, const struct vor_record *record)
{
    const struct waiter *waiter = ctx;

    return record->stage == VOR_RUN_STAGE_POLISH && record->step == 3 ? waiter->then : VOR_CONTINUE;
}

START_TEST(the_polish_ends_when_the_caller_says_so)
{
    static const enum vor_answer answers[] = {VOR_STOP, VOR_CANCEL};

    for (int i = 0; i < 2; i++) {
        struct waiter waiter = {0, answers[i]};
        struct vor_watch watch = {.ctx = &waiter, .progress = third_step};
        struct vor_domain domain = {.unit = 1};
        struct vor_lop_samples samples;
        struct vor_lop_insert_how how;
        struct vor_outcome told;
        struct vt_engine engine;
        double spacing;
        vor_status status;

        memset(&told, 0, sizeof told);
        vt_engine_open(&engine, 2);
        engine.run.watch = &watch;
        vt_lop_sphere(&samples, 300, &spacing);
        how = how_of(spacing, 0);
        how.polish = 10;
        status = vor_lop_insert(&samples, 900, &how, &domain, &told, &engine.run, &vt_err);
        ck_assert_int_eq(status, answers[i] == VOR_STOP ? VOR_OK : VOR_E_CANCELLED);
        ck_assert_uint_eq(told.steps[VOR_RUN_STAGE_POLISH], answers[i] == VOR_STOP ? 3 : 0);
        if (status == VOR_OK)
            ck_assert_int_eq(told.stopped, VOR_STOPPED_CALLER);
        vor_lop_samples_free(&samples);
        vt_engine_close(&engine);
    }
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("lop_insert");

    vt_add_loop(suite, points_inserted_lie_on_the_two_planes_of_a_wedge, 6);
    vt_add(suite, the_number_of_points_is_exact_and_samples_stay);
    vt_add(suite, a_larger_rho_puts_insertions_on_edges);
    vt_add(suite, points_do_not_depend_on_threads);
    vt_add(suite, points_inserted_lie_on_a_sphere);
    vt_add(suite, a_hole_of_a_few_spacings_is_kept_or_filled);
    vt_add(suite, sides_of_a_thin_plate_do_not_mix);
    vt_add(suite, sheets_over_each_other_do_not_mix);
    vt_add(suite, a_cancel_or_a_stop_ends_the_insertion_soon);
    vt_add(suite, points_between_others_stay_on_their_side_of_an_edge);
    vt_add(suite, points_that_all_coincide_leave_no_place);
    vt_add(suite, each_allocation_may_fail);
    vt_add(suite, powers_are_those_of_pow);
    vt_add_loop(suite, the_tree_finds_what_looking_at_every_point_finds, VT_SOAK_LOOPS(2, 20));
    vt_add_loop(suite, the_polish_evens_out_and_fills_the_edge_of_a_wedge, 3);
    vt_add(suite, the_polish_brings_back_what_lies_past_an_edge);
    vt_add(suite, the_polish_keeps_a_sphere_and_does_not_depend_on_threads);
    vt_add(suite, the_polish_pushes_no_point_over_an_open_border);
    vt_add(suite, the_polish_ends_when_the_caller_says_so);
    return vt_run(suite);
}
