/* Filters: smoothing by moving least squares, outliers pulled in or dropped, thinning; and results
 * that filters alone make, in which points keep their order and their attributes. */
#include "core/geom/graph.h"
#include "core/input/input.h"
#include "core/input/mls.h"
#include "core/metrics/measure.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 2, N = 3000, SMALL = 300, STRAYS = 60 };

/* Gives each point its number as an attribute. */
static void number(struct vor_cloud *cloud)
{
    struct vor_attribute *id;
    uint32_t *value;

    vt_assert_ok(vor_cloud_add_attribute(cloud, "id", VOR_GENERIC, VOR_UINT32, 1, &id, &vt_err));
    value = id->data;
    for (size_t i = 0; i < cloud->n; i++)
        value[i] = (uint32_t)i;
}

/* The number of the point of the input that point i was. */
static size_t number_of(const struct vor_cloud *cloud, size_t i)
{
    const struct vor_attribute *id = vor_cloud_find_name(cloud, "id");

    ck_assert_ptr_nonnull(id);
    return ((const uint32_t *)id->data)[i];
}

/* Moves every point of a sphere or square along its normal by normally distributed lengths. */
static void add_noise(struct vor_cloud *cloud, uint64_t seed, double deviation, int is_sphere)
{
    for (size_t i = 0; i < cloud->n; i++) {
        float off = (float)(deviation * vt_normal(seed + 1000, i));

        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] += off * (is_sphere ? cloud->xyz[3 * i + c] : (float)(c == 2));
    }
}

/* Moves the first points off the sphere, by a tenth of its radius to a whole one. */
static void stray(struct vor_cloud *cloud, uint64_t seed)
{
    for (size_t i = 0; i < STRAYS; i++)
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] *= (float)(1.1 + 0.9 * vt_unit(seed + 2000, i));
}

static double off_sphere(const struct vor_cloud *cloud, size_t i)
{
    const float *x = &cloud->xyz[3 * i];

    return fabs(sqrt((double)x[0] * x[0] + (double)x[1] * x[1] + (double)x[2] * x[2]) - 1);
}

static double rms_off_sphere(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t i = 0; i < cloud->n; i++)
        sum += off_sphere(cloud, i) * off_sphere(cloud, i);
    return sqrt(sum / (double)cloud->n);
}

static double rms_height(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t i = 0; i < cloud->n; i++)
        sum += (double)cloud->xyz[3 * i + 2] * cloud->xyz[3 * i + 2];
    return sqrt(sum / (double)cloud->n);
}

/* One request: names and values in turn, up to a NULL. */
static vor_status try_filter(struct vor_cloud *out, struct vor_report *report,
                             const struct vor_cloud *in, unsigned threads,
                             const char *const options[])
{
    struct vt_engine engine;
    vor_status status;

    vt_engine_open(&engine, threads);
    for (size_t i = 0; options[i] != NULL; i += 2)
        vt_engine_set(&engine, options[i], options[i + 1]);
    status = vt_engine_try(&engine, out, report, in);
    vt_engine_close(&engine);
    return status;
}

static void filter(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                   const char *filters, const char *outliers)
{
    const char *const options[] = {"filters", filters, "outliers", outliers, NULL};

    vt_assert_ok(try_filter(out, report, in, 2, options));
}

START_TEST(noise_on_a_plane_and_on_a_sphere_falls_to_less_than_half)
{
    for (int is_sphere = 0; is_sphere < 2; is_sphere++) {
        struct vor_cloud in, out;
        struct vor_report report;
        double before, after;

        (is_sphere ? vt_cloud_sphere : vt_cloud_square)(&in, (uint64_t)_i, N);
        add_noise(&in, (uint64_t)_i, is_sphere ? 0.02 : 0.005, is_sphere);
        filter(&out, &report, &in, "mls", "drop");
        ck_assert_uint_eq(out.n, N);
        before = is_sphere ? rms_off_sphere(&in) : rms_height(&in);
        after = is_sphere ? rms_off_sphere(&out) : rms_height(&out);
        ck_assert_msg(after < 0.4 * before, "sphere %d: %g of %g", is_sphere, after, before);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
    vt_assert_no_leak();
}
END_TEST

/* A quadric has no plane's error, and a sphere's only of fourth order: 2e-4 at 20 of 6,000 points.
 */
START_TEST(exact_planes_and_spheres_stay_where_they_are)
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_square(&in, (uint64_t)_i, N);
    filter(&out, &report, &in, "mls", "keep");
    for (size_t i = 0; i < 3 * (size_t)N; i++)
        ck_assert_float_eq_tol(out.xyz[i], in.xyz[i], 1e-6f);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_cloud_sphere(&in, (uint64_t)_i, N);
    filter(&out, &report, &in, "mls", "keep");
    ck_assert_double_lt(rms_off_sphere(&out), 2e-4);
    ck_assert_double_lt(report.out_to_in.rms, 2e-4);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(every_point_keeps_its_place_in_the_order_and_its_attributes)
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    add_noise(&in, (uint64_t)_i, 0.02, 1);
    number(&in);
    filter(&out, &report, &in, "mls", "drop");
    ck_assert_uint_eq(out.n, N);
    ck_assert_uint_eq(out.attribute_count, 1);
    for (size_t i = 0; i < N; i++) {
        double moved = 0;

        ck_assert_uint_eq(number_of(&out, i), i);
        for (size_t c = 0; c < 3; c++)
            moved = fmax(moved, fabs((double)out.xyz[3 * i + c] - (double)in.xyz[3 * i + c]));
        ck_assert_double_lt(moved, 0.12);
    }
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(the_filter_outliers_drops_strays_and_moves_no_other_point)
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t strays = 0;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    stray(&in, (uint64_t)_i);
    number(&in);
    filter(&out, &report, &in, "outliers", "keep");
    ck_assert_uint_eq(report.outliers, N - out.n);
    ck_assert_uint_ge(out.n, N - STRAYS - N / 1000);
    for (size_t i = 0; i < out.n; i++) {
        size_t was = number_of(&out, i);

        strays += was < STRAYS;
        ck_assert(i == 0 || was > number_of(&out, i - 1));
        ck_assert_mem_eq(&out.xyz[3 * i], &in.xyz[3 * was], 3 * sizeof *in.xyz);
    }
    ck_assert_uint_le(strays, STRAYS / 50);
    ck_assert(report.in_to_out.max == 0 && report.out_to_in.max == 0);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(pull_moves_strays_onto_the_surface_and_keeps_every_point)
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t off = 0;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    stray(&in, (uint64_t)_i);
    number(&in);
    filter(&out, &report, &in, "outliers", "pull");
    ck_assert_uint_eq(out.n, N);
    ck_assert_uint_ge(report.outliers, STRAYS * 49 / 50);
    for (size_t i = 0; i < N; i++) {
        ck_assert_uint_eq(number_of(&out, i), i);
        off += off_sphere(&out, i) > 0.01;
    }
    ck_assert_msg(off <= STRAYS / 50, "%zu are off", off);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_resampling_takes_pulled_points_for_a_part_of_the_surface)
{
    const char *const options[] = {"points", "800", "outliers", "pull", "polish", "5", NULL};
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    stray(&in, (uint64_t)_i);
    vt_assert_ok(try_filter(&out, &report, &in, 2, options));
    ck_assert_uint_eq(out.n, 800);
    ck_assert_uint_ge(report.outliers, STRAYS * 49 / 50);
    ck_assert_double_lt(rms_off_sphere(&out), 0.005);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(mls_before_a_resampling_brings_it_nearer_to_the_surface)
{
    static const char *const filters[2] = {"none", "mls"};
    struct vor_cloud in, out;
    struct vor_report report;
    double off[2];

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    add_noise(&in, (uint64_t)_i, 0.02, 1);
    for (int k = 0; k < 2; k++) {
        const char *const options[] = {"points", "800",    "filters", filters[k], "neighbors",
                                       "20",     "polish", "5",       NULL};

        vt_assert_ok(try_filter(&out, &report, &in, 2, options));
        ck_assert_uint_eq(out.n, 800);
        off[k] = rms_off_sphere(&out);
        vor_cloud_free(&out);
    }
    ck_assert_msg(off[1] < 0.9 * off[0], "%g, without %g", off[1], off[0]);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* Every fifth point once more, and a stray twice: twins go together. */
START_TEST(points_that_share_a_place_stay_together)
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t pairs = 0;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    add_noise(&in, (uint64_t)_i, 0.02, 1);
    for (size_t c = 0; c < 3; c++)
        in.xyz[c] *= 1.8f;
    for (size_t i = 4; i < N; i += 5)
        memcpy(&in.xyz[3 * i], &in.xyz[3 * (i - 4)], 3 * sizeof *in.xyz);
    number(&in);
    filter(&out, &report, &in, "mls,outliers", "drop");
    ck_assert_uint_eq(report.outliers, N - out.n);
    ck_assert(report.min_over_mean == 0);
    for (size_t i = 0; i + 1 < out.n; i++) {
        size_t was = number_of(&out, i), next = i + 1;

        ck_assert_uint_ne(was, 0);
        ck_assert_uint_ne(was, 4);
        if (was % 5 != 0)
            continue;
        while (next < out.n && number_of(&out, next) < was + 4)
            next++;
        ck_assert_uint_lt(next, out.n);
        ck_assert_uint_eq(number_of(&out, next), was + 4);
        ck_assert_mem_eq(&out.xyz[3 * i], &out.xyz[3 * next], 3 * sizeof *out.xyz);
        pairs++;
    }
    ck_assert_uint_gt(pairs, N / 6);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* Half of the sphere has nine times as many points. */
START_TEST(thin_evens_the_density_and_leaves_no_twins)
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t north[2] = {0}, south[2] = {0};

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    for (size_t i = 0; i < N; i++)
        if (i % 9 != 0)
            in.xyz[3 * i + 2] = fabsf(in.xyz[3 * i + 2]);
    memcpy(&in.xyz[3], in.xyz, 3 * sizeof *in.xyz);
    filter(&out, &report, &in, "outliers,thin", "drop");
    for (size_t i = 0; i < N; i++)
        (*(in.xyz[3 * i + 2] > 0 ? &north[0] : &south[0]))++;
    for (size_t i = 0; i < out.n; i++)
        (*(out.xyz[3 * i + 2] > 0 ? &north[1] : &south[1]))++;
    ck_assert_uint_lt(out.n, N);
    ck_assert_uint_eq(vt_coincident(&out), 0);
    ck_assert_msg(north[1] * south[0] * 3 < 2 * north[0] * south[1], "%zu and %zu of %zu and %zu",
                  north[1], south[1], north[0], south[0]);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* The report against `measure`, and all that only a method tells. */
START_TEST(the_report_measures_the_result_and_tells_of_no_step)
{
    const size_t points = N / 2;
    struct vor_cloud in, out;
    struct vor_report report;
    struct vor_measure measure;
    struct vt_engine engine;

    vt_cloud_sphere(&in, (uint64_t)_i, points);
    add_noise(&in, (uint64_t)_i, 0.02, 1);
    stray(&in, (uint64_t)_i);
    filter(&out, &report, &in, "outliers,mls", "drop");
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_measure_clouds(&measure, &out, &in, 0, &engine.run, &vt_err));
    ck_assert_double_eq_tol(report.delta, measure.delta, 1e-5);
    ck_assert_double_eq_tol(report.spacing_mean, measure.mean_nn, 1e-6);
    ck_assert_double_eq_tol(report.max_over_mean, measure.max_over_mean, 1e-4);
    ck_assert_uint_eq(report.points_in, points);
    ck_assert_uint_eq(report.points_out, out.n);
    ck_assert_uint_eq(report.out_to_in.points, out.n);
    ck_assert_uint_eq(report.iterations + report.polish_steps + report.stages_count, 0);
    ck_assert_uint_eq(report.fitted_count, 0);
    ck_assert(report.area == 0 && report.six_share == 0);
    ck_assert(!vor_spec_given(&report.parameters, VOR_PARAM_POINTS));
    ck_assert_double_gt(report.out_to_in.rms, 0);
    ck_assert_double_lt(report.out_to_in.max, 0.2);
    vt_engine_close(&engine);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

static uint64_t hash_of(const struct vor_cloud *in, unsigned threads, const char *filters,
                        const char *outliers)
{
    const char *const options[] = {"filters", filters, "outliers", outliers,
                                   "normals", "fit",   NULL};
    struct vor_cloud out;
    struct vor_report report;
    uint64_t hash;

    vt_assert_ok(try_filter(&out, &report, in, threads, options));
    hash = vt_cloud_hash(&out);
    for (size_t i = 0; i < out.attribute_count; i++)
        hash ^= vt_hash(out.attributes[i].data, out.n * out.attributes[i].components *
                                                    vor_type_size(out.attributes[i].type));
    vor_cloud_free(&out);
    return hash;
}

START_TEST(the_order_of_the_words_and_the_number_of_threads_change_nothing)
{
    struct vor_cloud in;
    uint64_t hash;

    vt_cloud_torus(&in, 1, N / 3);
    stray(&in, 1);
    number(&in);
    hash = hash_of(&in, 1, "mls,outliers,thin", "pull");
    ck_assert(hash_of(&in, 2, "thin,outliers,mls", "pull") == hash);
    ck_assert(hash_of(&in, 3, "outliers,thin,mls", "pull") == hash);
    ck_assert(hash_of(&in, 3, "mls,outliers", "pull") != hash);
    hash = hash_of(&in, 1, "mls,outliers", "drop");
    ck_assert(hash_of(&in, 2, "mls,outliers", "drop") == hash);
    ck_assert(hash_of(&in, 3, "outliers,mls", "keep") == hash);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(fitted_normals_are_those_of_the_sphere_and_follow_the_carried_ones)
{
    const char *const options[] = {"filters", "mls", "normals", "fit", NULL};

    for (int inward = 0; inward < 2; inward++) {
        struct vor_attribute *carried;
        struct vor_cloud in, out;
        struct vor_report report;
        const float *normal;

        vt_cloud_sphere(&in, (uint64_t)_i, N);
        if (inward) {
            vt_assert_ok(vor_cloud_add_attribute(&in, "normal", VOR_NORMAL, VOR_FLOAT32, 3,
                                                 &carried, &vt_err));
            for (size_t i = 0; i < 3 * (size_t)N; i++)
                ((float *)carried->data)[i] = -in.xyz[i];
        }
        vt_assert_ok(try_filter(&out, &report, &in, 2, options));
        ck_assert_uint_eq(out.attribute_count, 1);
        normal = vor_cloud_find(&out, VOR_NORMAL)->data;
        for (size_t i = 0; i < N; i++) {
            const float *x = &out.xyz[3 * i], *a = &normal[3 * i];
            double along = (double)x[0] * a[0] + (double)x[1] * a[1] + (double)x[2] * a[2];

            ck_assert_double_gt(inward ? -along : along, 0.99);
        }
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
    vt_assert_no_leak();
}
END_TEST

/* Of the carried normals, twice as long as they should be, every other one points inward. */
START_TEST(oriented_normals_are_the_carried_ones_all_outward)
{
    const char *const options[] = {"filters", "mls", "normals", "oriented", NULL};
    struct vor_attribute *carried;
    struct vor_cloud in, out;
    struct vor_report report;
    const float *normal;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_assert_ok(
        vor_cloud_add_attribute(&in, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &carried, &vt_err));
    for (size_t i = 0; i < 3 * (size_t)N; i++)
        ((float *)carried->data)[i] = in.xyz[i] * (i / 3 % 2 ? 2.0f : -2.0f);
    vt_assert_ok(try_filter(&out, &report, &in, 2, options));
    ck_assert_uint_eq(out.attribute_count, 1);
    ck_assert_uint_eq(report.one_sided, 0);
    normal = vor_cloud_find(&out, VOR_NORMAL)->data;
    for (size_t i = 0; i < 3 * (size_t)N; i++)
        ck_assert_float_eq_tol(normal[i], 2 * in.xyz[i], 1e-6f);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(islands_are_counted_and_stay_in_their_places_of_the_order)
{
    enum { ISLAND = 8 };
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    for (size_t i = 0; i < 3 * (size_t)ISLAND; i++)
        in.xyz[i] = (float)(5 + 0.02 * vt_unit((uint64_t)_i, i));
    number(&in);
    filter(&out, &report, &in, "mls", "keep");
    ck_assert_uint_eq(out.n, N);
    for (size_t i = 0; i < N; i++)
        ck_assert_uint_eq(number_of(&out, i), i);
    ck_assert_uint_eq(report.parts, 2);
    ck_assert_uint_eq(report.islands, 1);
    ck_assert_uint_eq(report.in_islands, ISLAND);
    ck_assert_uint_eq(report.on_islands, 0);
    ck_assert_double_eq(report.delta_beside, report.delta);
    vor_cloud_free(&out);
    filter(&out, &report, &in, "outliers", "drop");
    ck_assert_uint_eq(report.outliers, ISLAND);
    ck_assert_uint_eq(number_of(&out, 0), ISLAND);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_progressive_order_is_one_of_the_same_points)
{
    const char *const options[] = {"filters", "mls", "order", "progressive", NULL};
    unsigned char seen[N] = {0};
    struct vor_cloud in, plain, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    number(&in);
    filter(&plain, &report, &in, "mls", "keep");
    vt_assert_ok(try_filter(&out, &report, &in, 2, options));
    ck_assert_uint_eq(out.n, N);
    for (size_t i = 0; i < N; i++) {
        size_t was = number_of(&out, i);

        ck_assert_uint_eq(seen[was]++, 0);
        ck_assert_mem_eq(&out.xyz[3 * i], &plain.xyz[3 * was], 3 * sizeof *out.xyz);
    }
    vor_cloud_free(&out);
    vor_cloud_free(&plain);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(double_positions_far_from_the_origin_stay_exact)
{
    double xyz[3 * SMALL];
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, SMALL);
    for (size_t i = 0; i < 3 * (size_t)SMALL; i++)
        xyz[i] = 6.4e5 + (double)in.xyz[i];
    vt_assert_ok(vor_cloud_set_double(&in, xyz, &vt_err));
    filter(&out, &report, &in, "outliers", "drop");
    ck_assert_uint_eq(out.n, SMALL);
    ck_assert_int_eq(out.position_type, VOR_FLOAT64);
    ck_assert(vt_cloud_hash(&out) == vt_cloud_hash(&in));
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* Two sheets two of their spacings apart, told apart by layers; away from the border, where there
 * are too few points on one side to tell (geom/layers.h). */
START_TEST(noisy_sheets_are_not_pulled_together)
{
    enum { MANY = 3000 };
    const double gap = 0.057;
    struct vor_cloud in, out;
    struct vor_report report;
    double sum = 0;
    size_t between = 0, inside = 0;

    vt_cloud_sheets(&in, (uint64_t)_i, MANY, gap);
    for (size_t i = 0; i < MANY; i++)
        in.xyz[3 * i + 2] += (float)(0.05 * gap * vt_normal((uint64_t)_i + 1000, i));
    filter(&out, &report, &in, "mls", "keep");
    for (size_t i = 0; i < MANY; i++) {
        const float *x = &out.xyz[3 * i];
        double off = (double)x[2] - (in.xyz[3 * i + 2] > 0.5 * gap ? gap : 0);

        if (fabsf(x[0] - 0.5f) > 0.4f || fabsf(x[1] - 0.5f) > 0.4f)
            continue;
        inside++;
        sum += off * off;
        between += fabs(off) > 0.3 * gap;
    }
    ck_assert_msg(between <= MANY / 1000, "%zu points in between", between);
    ck_assert_double_lt(sqrt(sum / (double)inside), 0.05 * gap);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* A square lattice twice, nearer to each other than its points are: only lists tell them apart. */
START_TEST(lists_of_neighbours_keep_a_point_on_its_sheet)
{
    enum { SIDE = 30, SHEET = SIDE * SIDE };
    const double gap = 0.4;
    struct vt_engine engine;
    struct vor_domain domain;
    struct vor_cloud in;

    vt_cloud_make(&in, 2 * (size_t)SHEET);
    for (size_t i = 0; i < in.n; i++) {
        in.xyz[3 * i] = (float)(i % SIDE);
        in.xyz[3 * i + 1] = (float)(i % SHEET / SIDE);
        in.xyz[3 * i + 2] = (float)((i / SHEET) * gap);
    }
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_domain_init(&domain, &in, &engine.run, &vt_err));
    vt_assert_ok(vor_graph_init(&domain.graph, domain.n, 4, &vt_memory, &vt_err));
    for (size_t i = 0; i < domain.n; i++)
        for (size_t j = 0; j < domain.n; j++) {
            size_t a = domain.source[i], b = domain.source[j];
            double dx = fabs((double)in.xyz[3 * a] - (double)in.xyz[3 * b]),
                   dy = fabs((double)in.xyz[3 * a + 1] - (double)in.xyz[3 * b + 1]);

            if (a / SHEET == b / SHEET && dx + dy == 1)
                domain.graph.list[4 * i + domain.graph.count[i]++] = (uint32_t)j;
        }
    vt_assert_ok(vor_mls_project(&domain, &engine.run, &vt_err));
    for (size_t i = 0; i < domain.n; i++)
        ck_assert_double_eq_tol((double)domain.xyz[3 * i + 2] * domain.unit + domain.shift[2],
                                (double)in.xyz[3 * (size_t)domain.source[i] + 2], 1e-4);
    vor_domain_free(&domain);
    vt_engine_close(&engine);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* A ring: around each point come its two neighbours, then theirs. */
START_TEST(points_around_one_come_in_rings)
{
    enum { RING = 40 };
    static const uint32_t rings[6] = {7, 8, 6, 9, 5, 10};
    struct vor_graph graph;
    uint32_t found[RING];

    vt_assert_ok(vor_graph_init(&graph, RING + 1, 2, &vt_memory, &vt_err));
    for (uint32_t i = 0; i < RING; i++) {
        graph.list[2 * i] = (i + 1) % RING;
        graph.list[2 * i + 1] = (i + RING - 1) % RING;
        graph.count[i] = 2;
    }
    ck_assert_uint_eq(vor_graph_around(&graph, 7, found, 6), 6);
    ck_assert_mem_eq(found, rings, sizeof rings);
    ck_assert_uint_eq(vor_graph_around(&graph, RING, found, 6), 1);
    vor_graph_free(&graph);
    vt_assert_no_leak();
}
END_TEST

static enum vor_answer say_cancel(void *ctx)
{
    size_t *left = ctx;

    return (*left)-- == 0 ? VOR_CANCEL : VOR_CONTINUE;
}

/* A run whose watch cancels at poll number `at`, or whose allocation number `fail` fails. */
static vor_status interrupted(const struct vor_cloud *in, size_t at, size_t fail)
{
    struct vor_watch watch = {.ctx = &at, .poll = say_cancel};
    struct vor_memory memory;
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;
    vor_status status;

    vor_memory_init(&memory, SIZE_MAX);
    memory.fail_at = fail;
    vt_engine_open(&engine, 1);
    engine.run.memory = &memory;
    if (fail == 0)
        engine.run.watch = &watch;
    vt_engine_set(&engine, "filters", fail == 0 ? "mls,outliers,thin" : "mls,outliers");
    vt_engine_set(&engine, "outliers", "pull");
    vt_engine_set(&engine, "normals", "fit");
    status = vt_engine_try(&engine, &out, &report, in);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    return status;
}

START_TEST(a_run_that_is_cancelled_anywhere_leaves_nothing)
{
    vor_status status = VOR_E_CANCELLED;
    struct vor_cloud in;
    size_t polls;

    vt_cloud_sphere(&in, 1, 2 * (size_t)SMALL);
    stray(&in, 1);
    for (polls = 0; status == VOR_E_CANCELLED && polls < 10000; polls += 31)
        status = interrupted(&in, polls, 0);
    vt_assert_ok(status);
    ck_assert_uint_gt(polls, 20);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(whichever_allocation_fails_nothing_is_left)
{
    vor_status status = VOR_E_NOMEM;
    struct vor_cloud in;
    size_t fail;

    vt_cloud_sphere(&in, 1, SMALL * 7 / 10);
    for (size_t c = 0; c < 3; c++)
        in.xyz[c] *= 1.5f;
    memcpy(&in.xyz[3], in.xyz, 3 * sizeof *in.xyz);
    for (fail = 1; status == VOR_E_NOMEM && fail < 1000; fail++)
        status = interrupted(&in, SIZE_MAX, fail);
    vt_assert_ok(status);
    ck_assert_uint_gt(fail, 40);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

START_TEST(clouds_without_a_surface_are_refused_as_ever_and_few_points_pass)
{
    static const char *const options[] = {"filters", "mls,outliers,thin", NULL};
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_make(&in, 30);
    for (size_t i = 0; i < 90; i++)
        in.xyz[i] = (float)(i / 3);
    vt_assert_fails(VOR_E_DEGENERATE, try_filter(&out, &report, &in, 1, options));
    vor_cloud_free(&in);
    for (size_t n = 4; n < 25; n++) {
        vt_cloud_sphere(&in, n, n);
        vt_assert_ok(try_filter(&out, &report, &in, 1, options));
        ck_assert_uint_ge(out.n, n < 20 ? n : 20);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("filters");

    vt_add_loop(suite, noise_on_a_plane_and_on_a_sphere_falls_to_less_than_half,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, exact_planes_and_spheres_stay_where_they_are,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, every_point_keeps_its_place_in_the_order_and_its_attributes,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, the_filter_outliers_drops_strays_and_moves_no_other_point,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, pull_moves_strays_onto_the_surface_and_keeps_every_point,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, a_resampling_takes_pulled_points_for_a_part_of_the_surface, VT_ONCE(1));
    vt_add_loop(suite, mls_before_a_resampling_brings_it_nearer_to_the_surface, VT_ONCE(1));
    vt_add_loop(suite, points_that_share_a_place_stay_together, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, thin_evens_the_density_and_leaves_no_twins,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_loop(suite, the_report_measures_the_result_and_tells_of_no_step,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add(suite, the_order_of_the_words_and_the_number_of_threads_change_nothing);
    vt_add(suite, fitted_normals_are_those_of_the_sphere_and_follow_the_carried_ones);
    vt_add(suite, oriented_normals_are_the_carried_ones_all_outward);
    vt_add(suite, islands_are_counted_and_stay_in_their_places_of_the_order);
    vt_add(suite, a_progressive_order_is_one_of_the_same_points);
    vt_add(suite, double_positions_far_from_the_origin_stay_exact);
    vt_add_loop(suite, noisy_sheets_are_not_pulled_together, VT_ONCE(1));
    vt_add(suite, lists_of_neighbours_keep_a_point_on_its_sheet);
    vt_add(suite, points_around_one_come_in_rings);
    vt_add(suite, a_run_that_is_cancelled_anywhere_leaves_nothing);
    vt_add(suite, whichever_allocation_fails_nothing_is_left);
    vt_add(suite, clouds_without_a_surface_are_refused_as_ever_and_few_points_pass);
    return vt_run(suite);
}
