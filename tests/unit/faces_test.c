/* Points drawn from triangles: how many each gets, where they lie in it, and what they carry. */
#include "core/cloud/faces.h"
#include "tests/support/vt_ask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A cloud of n points with the triangles; positions are set by the caller. */
static void make(struct vor_cloud *cloud, size_t n, const uint32_t *triangles, size_t count)
{
    vt_cloud_make(cloud, n);
    cloud->triangles = vor_malloc(&vt_memory, count, 3 * sizeof *triangles);
    ck_assert_ptr_nonnull(cloud->triangles);
    memcpy(cloud->triangles, triangles, count * 3 * sizeof *triangles);
    cloud->triangle_count = count;
}

/* Triangles apart from each other, of areas from 0 to a hundred times each other. */
enum { LOOSE = 40 };

static void make_loose(struct vor_cloud *cloud, uint64_t seed)
{
    uint32_t triangles[3 * LOOSE];

    for (uint32_t i = 0; i < 3 * LOOSE; i++)
        triangles[i] = i;
    make(cloud, (size_t)3 * LOOSE, triangles, LOOSE);
    for (uint32_t i = 0; i < 3 * LOOSE; i++)
        for (uint32_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] = (float)(vt_unit(seed, 3 * i + c) + (c == 0 ? 4 * (i / 3) : 0));
    /* The 8th, which has no area. */
    memcpy(&cloud->xyz[9 * 7 + 6], &cloud->xyz[9 * 7 + 3], 3 * sizeof(float));
}

static double area_of(const struct vor_cloud *cloud, size_t t)
{
    struct vor_cloud one = *cloud;

    one.triangles = &cloud->triangles[3 * t];
    one.triangle_count = 1;
    return vor_faces_area(&one);
}

/* Which of the loose triangles a sample belongs to. */
static size_t which_of(const float x[3])
{
    return (size_t)(x[0] / 4);
}

static void draw(struct vor_cloud *out, const struct vor_cloud *in, size_t n, uint64_t seed)
{
    vor_cloud_init(out, &vt_memory);
    vt_assert_ok(vor_faces_sample(out, in, n, seed, &vt_err));
    ck_assert_uint_eq(out->n, n);
    ck_assert_uint_eq(out->triangle_count, 0);
}

/* Property: the count of a triangle is its share of the area, rounded up or down. */
VT_TEST_LOOP(a_triangle_gets_its_share_of_the_area, 40)
{
    struct vor_cloud in, out;
    size_t n = 1 + (size_t)(vt_unit((uint64_t)_i, 1) * 3000), counts[LOOSE] = {0};
    double area;

    make_loose(&in, (uint64_t)_i);
    area = vor_faces_area(&in);
    draw(&out, &in, n, (uint64_t)_i);
    for (size_t i = 0; i < n; i++)
        counts[which_of(&out.xyz[3 * i])]++;
    for (size_t t = 0; t < LOOSE; t++) {
        double want = (double)n * area_of(&in, t) / area;

        ck_assert_msg(fabs((double)counts[t] - want) < 1 + 1e-9, "triangle %zu: %zu, want %g", t,
                      counts[t], want);
    }
    ck_assert_uint_eq(counts[7], 0);
    vt_free_last(&in, &out);
}

static const uint32_t single[] = {0, 1, 2};

/* One triangle, whose weights of a point are z, x and y. */
static void make_single(struct vor_cloud *cloud)
{
    static const float xyz[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};

    make(cloud, 3, single, 1);
    memcpy(cloud->xyz, xyz, sizeof xyz);
}

/* Which of the 64 parts of that triangle a point lies in: by the rows and whether it points up. */
static unsigned part_of(const float x[3])
{
    unsigned column = (unsigned)(x[0] * 8), row = (unsigned)(x[1] * 8);
    int up = (double)x[0] * 8 - column + (double)x[1] * 8 - row < 1;

    return row * 16 + column * 2 + (unsigned)!up;
}

/* Property: over seeds each place of a triangle is as likely as the others, whatever their number.
 * 103.4 is the 99.9th percentile of chi-square for 63 degrees of freedom. */
VT_TEST_LOOP(places_in_a_triangle_are_alike, 6)
{
    enum { SEEDS = 3000 };
    size_t each = (size_t)_i + 1;
    double counts[128] = {0}, want = SEEDS * (double)each / 64, chi2 = 0;
    struct vor_cloud in, out;

    make_single(&in);
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        draw(&out, &in, each, seed);
        for (size_t i = 0; i < each; i++) {
            const float *x = &out.xyz[3 * i];

            ck_assert(x[0] >= 0 && x[1] >= 0 && x[2] >= 0);
            ck_assert_double_eq_tol((double)x[0] + (double)x[1] + (double)x[2], 1, 1e-6);
            counts[part_of(x)]++;
        }
        vor_cloud_free(&out);
    }
    for (int part = 0; part < 128; part++)
        if (part / 16 + part % 16 / 2 + part % 2 < 8)
            chi2 += (counts[part] - want) * (counts[part] - want) / want;
    ck_assert_msg(chi2 < 103.4, "%zu points: chi-square is %g", each, chi2);
    vor_cloud_free(&in);
}

/* Property: 64 points of a triangle lie in 64 different parts of it; of independent ones 23 parts
 * or so would have none. */
VT_TEST_LOOP(points_of_a_triangle_keep_clear_of_each_other, 20)
{
    int taken[128] = {0};
    struct vor_cloud in, out;

    make_single(&in);
    draw(&out, &in, 64, (uint64_t)_i);
    for (size_t i = 0; i < 64; i++)
        ck_assert_int_eq(taken[part_of(&out.xyz[3 * i])]++, 0);
    vor_cloud_free(&in);
    vor_cloud_free(&out);
}

static void *add(struct vor_cloud *cloud, const char *name, enum vor_semantic semantic,
                 enum vor_type type, unsigned components)
{
    struct vor_attribute *attribute;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, name, semantic, type, components, &attribute, &vt_err));
    return attribute->data;
}

static void add_attributes(struct vor_cloud *cloud)
{
    static const uint8_t colors[9] = {0, 100, 255, 200, 100, 0, 50, 100, 255};
    static const float heat[3] = {10, 20, -30}, holes[3] = {1, NAN, 3};
    static const float normals[9] = {0, 0, 2, 0, 2, 0, 2, 0, 0};
    static const double wide[3] = {1e300, -1e300, 0}; /* the square of which is no number */
    static const int32_t labels[3] = {7, -8, 2000000001};

    memcpy(add(cloud, "color", VOR_COLOR, VOR_UINT8, 3), colors, sizeof colors);
    memcpy(add(cloud, "heat", VOR_GENERIC, VOR_FLOAT32, 1), heat, sizeof heat);
    memcpy(add(cloud, "holes", VOR_GENERIC, VOR_FLOAT32, 1), holes, sizeof holes);
    memcpy(add(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3), normals, sizeof normals);
    memcpy(add(cloud, "wide", VOR_GENERIC, VOR_FLOAT64, 1), wide, sizeof wide);
    memcpy(add(cloud, "label", VOR_GENERIC, VOR_INT32, 1), labels, sizeof labels);
}

/* What the attributes of a point must be, by its weights. */
static void check_attributes(const struct vor_cloud *in, const struct vor_cloud *out, size_t i)
{
    const float *x = &out->xyz[3 * i];
    double weight[3] = {(double)x[2], (double)x[0], (double)x[1]};
    int most = weight[1] > weight[0], length = 0;
    const uint8_t *color = (const uint8_t *)out->attributes[0].data + 3 * i;
    const float *normal = (const float *)out->attributes[3].data + 3 * i;

    most = weight[2] > weight[most] ? 2 : most;
    ck_assert_double_eq_tol(color[0], 200 * weight[1] + 50 * weight[2], 0.501);
    ck_assert_uint_eq(color[1], 100);
    ck_assert_double_eq_tol(vor_attribute_scalar(&out->attributes[1], i),
                            10 * weight[0] + 20 * weight[1] - 30 * weight[2], 1e-4);
    for (int c = 0; c < 3; c++)
        length += (int)lrint(1e6 * (double)normal[c] * (double)normal[c]);
    ck_assert_int_le(abs(length - 1000000), 3);
    ck_assert_double_eq_tol((double)normal[0] * weight[1], (double)normal[1] * weight[2], 1e-6);
    for (int a = 2; a < 6; a += a == 2 ? 2 : 1) { /* holes, wide, label: of the nearest corner */
        double want = vor_attribute_scalar(&in->attributes[a], (size_t)most);
        double got = vor_attribute_scalar(&out->attributes[a], i);

        ck_assert(got == want || (isnan(got) && isnan(want)));
    }
}

VT_TEST(attributes_are_interpolated_or_those_of_the_nearest_corner)
{
    struct vor_cloud in, out;

    make_single(&in);
    add_attributes(&in);
    draw(&out, &in, 500, 3);
    ck_assert_uint_eq(out.attribute_count, 6);
    for (size_t i = 0; i < out.n; i++)
        check_attributes(&in, &out, i);
    vt_free_last(&in, &out);
}

/* Property: neither the unit of a cloud nor its origin says where points are drawn, up to the
 * ends of float32. */
VT_TEST_LOOP(points_are_drawn_alike_in_every_unit, 4)
{
    static const double units[] = {1e-20, 1e-6, 1e6, 1e34};
    double unit = ldexp(1, ilogb(units[_i]));
    struct vor_cloud in, small, out;

    make_loose(&in, 9);
    draw(&out, &in, 700, 2);
    for (size_t i = 0; i < 3 * in.n; i++)
        in.xyz[i] = (float)((double)in.xyz[i] * unit);
    in.origin[1] = 5e6;
    in.position_type = VOR_FLOAT64;
    draw(&small, &in, 700, 2);
    ck_assert_double_eq(small.origin[1], 5e6);
    ck_assert_int_eq(small.position_type, VOR_FLOAT64);
    for (size_t i = 0; i < 3 * out.n; i++)
        ck_assert_float_eq(small.xyz[i], (float)((double)out.xyz[i] * unit));
    vor_cloud_free(&in);
    vor_cloud_free(&small);
    vor_cloud_free(&out);
}

VT_TEST(the_number_of_points_drawn_follows_the_rule)
{
    ck_assert_uint_eq(vor_faces_samples(5000, 3000), 40000);
    ck_assert_uint_eq(vor_faces_samples(5000, 100000), 100000);
    ck_assert_uint_eq(vor_faces_samples(50, 8), 10000);
    ck_assert_uint_eq(vor_faces_samples(-1, 20000), 20000);
    ck_assert_uint_eq(vor_faces_samples((double)NAN, 20000), 20000);
    ck_assert_uint_eq(vor_faces_samples((double)INFINITY, 8), 10000000);
    ck_assert_uint_eq(vor_faces_samples(1e7, 40000000), 40000000);
}

/* Refusal: memory that runs out at any point leaves nothing. */
VT_TEST(points_that_do_not_fit_leave_nothing)
{
    struct vor_cloud in, out;
    vor_status status = VOR_E_NOMEM;
    size_t at = 0;

    make_single(&in);
    add_attributes(&in);
    vor_cloud_init(&out, &vt_memory);
    for (; status == VOR_E_NOMEM; at++) {
        vt_memory.fail_at = atomic_load(&vt_memory.calls) + at + 1;
        status = vor_faces_sample(&out, &in, 10, 1, &vt_err);
        ck_assert(status == VOR_OK || out.xyz == NULL);
    }
    vt_memory.fail_at = 0;
    vt_assert_ok(status);
    ck_assert_uint_gt(at, 1);
    vt_free_last(&in, &out);
}

/* The unit cube: eight vertices, twelve triangles. */
static void make_cube(struct vor_cloud *cloud)
{
    static const uint32_t faces[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};

    make(cloud, 8, faces, 12);
    for (size_t i = 0; i < 8; i++)
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] = (float)(i >> c & 1);
}

static void resample_cube(struct vor_cloud *out, struct vor_report *report, unsigned threads,
                          const char *name, const char *value)
{
    struct vt_engine engine;
    struct vor_cloud cube;

    make_cube(&cube);
    vt_engine_open(&engine, threads);
    vt_engine_set(&engine, "sample", "faces");
    vt_engine_set(&engine, name, value);
    vt_engine_resample(&engine, out, report, &cube);
    vt_engine_close(&engine);
    vor_cloud_free(&cube);
}

/* The eight corners of a cube become points all over it, for any number of threads. */
VT_TEST(a_cube_of_eight_vertices_is_resampled)
{
    struct vor_cloud out[2];
    struct vor_report report;

    for (unsigned k = 0; k < 2; k++)
        resample_cube(&out[k], &report, 1 + 2 * k, "points", "600");
    ck_assert_uint_eq(report.points_in, 8);
    ck_assert_uint_eq(report.points_out, 600);
    ck_assert_uint_eq(report.samples, 10000);
    ck_assert_uint_eq(report.ref_to_out.points, 10000);
    ck_assert_double_lt(report.delta, 0.1);
    ck_assert_uint_eq(vt_cloud_hash(&out[0]), vt_cloud_hash(&out[1]));
    for (size_t i = 0; i < out[0].n; i++) {
        const float *x = &out[0].xyz[3 * i];
        double off = 1;

        for (int c = 0; c < 3; c++)
            off = fmin(off, fmin(fabs((double)x[c]), fabs((double)x[c] - 1)));
        ck_assert_double_lt(off, 0.02);
    }
    vor_cloud_free(&out[0]);
    vor_cloud_free(&out[1]);
}

/* 6 / (sqrt(3)/2 * 0.1^2) = 693 points; a ratio counts vertices. */
VT_TEST(spacing_and_ratio_say_how_many)
{
    struct vor_cloud out;
    struct vor_report report;

    resample_cube(&out, &report, 2, "spacing", "0.1");
    ck_assert_int_le(abs((int)out.n - 693), 20);
    vor_cloud_free(&out);
    resample_cube(&out, &report, 2, "ratio", "16");
    ck_assert_uint_eq(out.n, 128);
    vor_cloud_free(&out);
}

static vor_status check_target(const char *process, const char *sample, double points)
{
    struct vor_spec spec;

    vor_spec_preset(&spec, vor_process_find(process));
    vt_assert_ok(vor_spec_set(&spec, "sample", sample, &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "spacing", "0.5", &vt_err));
    return vor_spec_check_target(&spec, points, 8, &vt_err);
}

/* Refusal: what may be asked of a mesh of eight vertices. */
VT_TEST(vertices_bound_only_what_adds_no_points)
{
    vt_assert_fails(VOR_E_TARGET, check_target("resample", "vertices", 129));
    vt_assert_ok(check_target("resample", "faces", 129));
    vt_assert_ok(check_target("upsample", "faces", 1e7));
    vt_assert_fails(VOR_E_TARGET, check_target("upsample", "faces", 7));
    ck_assert_str_eq(vt_err.message, "spacing is 0.5 and needs 7 points, want 8 to 10000000");
    vt_assert_fails(VOR_E_TARGET, check_target("resample", "faces", 1e7 + 1));
    vt_assert_fails(VOR_E_TARGET, check_target("simplify", "faces", 9));
}

VT_TEST(a_cloud_without_faces_is_refused)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, 1, 500);
    vt_engine_open(&engine, 1);
    vt_ask_set(&engine, "points=100 sample=faces");
    vt_assert_fails(VOR_E_FACES, vt_engine_try(&engine, &out, &report, &in));
    ck_assert_str_eq(vt_err.parameter, "sample");
    vt_engine_close(&engine);
    vor_cloud_free(&in);
}
