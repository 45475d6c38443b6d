/* Fillets: the rounded wedge that is fitted to points, and the data of ear that are put onto one.
 */
#include "core/base/linalg.h"
#include "core/geom/fillet.h"
#include "core/input/input.h"
#include "core/lop/fillets.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 6, N = 4000, LIST = 40 };

#define NOISE 0.01

/* Two unit squares, x and z <= 0, whose edge along y is rounded off by a radius: how far x is from
 * that surface, with its normal there. */
static double off(const double x[3], double radius, double normal[3])
{
    double a = x[0] + radius, b = x[2] + radius, length = sqrt(a * a + b * b);

    if (radius > 0 && a > 0 && b > 0) {
        memcpy(normal, (const double[3]){a / length, 0, b / length}, 3 * sizeof *normal);
        return length - radius;
    }
    memcpy(normal, (const double[3]){x[0] > x[2], 0, x[0] <= x[2]}, 3 * sizeof *normal);
    return fmax(x[0], x[2]);
}

/* A point of it, with noise. */
static void scatter(float x[3], uint64_t seed, size_t i, double radius, double size)
{
    double at = (2 * vt_unit(seed, 3 * i) - 1) * size, normal[3], far;
    double y[3] = {at < 0 ? at : 0, (vt_unit(seed, 3 * i + 1) - 0.5) * size, at < 0 ? 0 : -at};

    far = off(y, radius, normal);
    for (size_t c = 0; c < 3; c++)
        x[c] = (float)(y[c] - far * normal[c] + NOISE * vt_normal(seed + 1000, 3 * i + c));
}

START_TEST(a_rounded_wedge_has_the_radius_of_its_points_and_a_sharp_one_has_none)
{
    double radius = 0.15 + 0.25 * vt_unit((uint64_t)_i, 1), height, normal[3];
    double place[2][3] = {{-0.5, 0, 0}, {0, 0, -0.5}}, side[2][3] = {{0, 0, 1}, {1, 0, 0}};
    const double over[3] = {0.3, 0.2, 0.3};
    struct vor_fillet fillet;
    float near[3 * 200];

    for (size_t i = 0; i < 200; i++)
        scatter(&near[3 * i], (uint64_t)_i, i, radius, 1);
    vor_fillet_fit(&fillet, near, 200, place, side, 0.5);
    ck_assert_double_ge(fillet.gain, 50);
    ck_assert_double_eq_tol(fillet.radius, radius, 0.1);
    ck_assert_double_le(fillet.off2, 1.3 * NOISE * NOISE);
    ck_assert(vor_fillet_at(&fillet, over, &height, normal));
    ck_assert_double_eq_tol(height, off(over, radius, normal), 1.5 * NOISE);
    for (size_t i = 0; i < 200; i++)
        scatter(&near[3 * i], (uint64_t)_i, i, 0, 1);
    vor_fillet_fit(&fillet, near, 200, place, side, 0.5);
    ck_assert_double_le(fillet.gain, 1);
}
END_TEST

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_lop_samples data, room;
    uint32_t *list;
    uint16_t *count;
};

static double *position(double x[3], const struct bed *bed, size_t i)
{
    vor_cloud_position(&bed->cloud, bed->domain.source[i], x);
    return x;
}

/* At its ends an edge is seen from one side. */
static int away_from_ends(const struct bed *bed, size_t i)
{
    double x[3];

    return fabs(position(x, bed, i)[1]) < 0.4;
}

/* Lists neighbours, and puts all points onto the planes of both sides, as smoothing has it. */
static void smooth(struct bed *bed)
{
    const struct vor_domain *domain = &bed->domain;
    float distance2[LIST];

    for (size_t i = 0; i < domain->n; i++) {
        double x[3], normal[3], far = off(position(x, bed, i), 0, normal);

        vor_knn_search(domain->knn, &domain->xyz[3 * i], 1, LIST, &bed->list[LIST * i], distance2);
        bed->count[i] = LIST;
        for (size_t c = 0; c < 3; c++) {
            bed->data.normal[3 * i + c] = (float)normal[c];
            bed->data.xyz[3 * i + c] =
                domain->xyz[3 * i + c] - (float)(far * normal[c] / domain->unit);
        }
    }
    bed->data.n = domain->n;
}

/* Puts the data of such a wedge onto fillets. */
static void start(struct bed *bed, uint64_t seed, double radius, unsigned threads)
{
    vt_engine_open(&bed->engine, threads);
    vt_cloud_make(&bed->cloud, N);
    for (size_t i = 0; i < N; i++)
        scatter(&bed->cloud.xyz[3 * i], seed, i, radius, 1);
    vt_assert_ok(
        vor_input_prepare(&bed->domain, &bed->cloud, &bed->engine.spec, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_lop_samples_init(&bed->data, N, bed->engine.run.memory, &vt_err));
    vt_assert_ok(vor_lop_samples_init(&bed->room, N, bed->engine.run.memory, &vt_err));
    bed->list = malloc(bed->domain.n * LIST * sizeof *bed->list);
    bed->count = malloc(bed->domain.n * sizeof *bed->count);
    ck_assert(bed->list != NULL && bed->count != NULL);
    smooth(bed);
    vt_assert_ok(vor_lop_fillets(&bed->data, &bed->room, &bed->domain,
                                 &(struct vor_lop_lists){LIST, bed->list, bed->count},
                                 &bed->engine.run, &vt_err));
}

static void end(struct bed *bed)
{
    free(bed->list);
    free(bed->count);
    vor_lop_samples_free(&bed->room);
    vor_lop_samples_free(&bed->data);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
    vt_assert_no_leak();
}

/* Distance of datum i to the surface; *cosine between its normal and the surface's. */
static double datum_off(const struct bed *bed, size_t i, double radius, double *cosine)
{
    double x[3], raw[3], normal[3], far;

    position(raw, bed, i);
    for (size_t c = 0; c < 3; c++)
        x[c] = raw[c] + ((double)bed->data.xyz[3 * i + c] - (double)bed->domain.xyz[3 * i + c]) *
                            bed->domain.unit;
    far = fabs(off(x, radius, normal));
    *cosine = 0;
    for (size_t c = 0; c < 3; c++)
        *cosine += normal[c] * (double)bed->data.normal[3 * i + c];
    return far;
}

START_TEST(data_on_a_fillet_are_put_onto_it)
{
    double radius = 0.2, worst = 0, turned = 0, count = 0;
    struct bed bed = {.list = NULL};

    start(&bed, (uint64_t)_i, radius, 2);
    for (size_t i = 0; i < bed.domain.n; i++) {
        double x[3], cosine, far = datum_off(&bed, i, radius, &cosine);

        position(x, &bed, i);
        if (x[0] < -0.15 || x[2] < -0.15 || !away_from_ends(&bed, i))
            continue;
        count++;
        worst += far * far;
        turned += cosine < 0.97; /* 14 degrees */
    }
    ck_assert_double_gt(count, 100);
    ck_assert_double_le(sqrt(worst / count), NOISE); /* 0.05 on the planes */
    ck_assert_double_le(turned / count, 0.1);        /* all of them on the planes */
    end(&bed);
}
END_TEST

START_TEST(data_at_a_sharp_edge_stay)
{
    struct bed bed = {.list = NULL};
    size_t moved = 0;

    start(&bed, (uint64_t)_i, 0, 2);
    for (size_t i = 0; i < bed.domain.n; i++)
        moved +=
            bed.data.normal[3 * i] > 0 && bed.data.normal[3 * i] < 1 && away_from_ends(&bed, i);
    ck_assert_uint_le(moved, 2);
    end(&bed);
}
END_TEST

START_TEST(any_number_of_threads_puts_them_at_the_same_places)
{
    struct bed one = {.list = NULL}, three = {.list = NULL};

    start(&one, 1, 0.2, 1);
    start(&three, 1, 0.2, 3);
    ck_assert_mem_eq(one.data.xyz, three.data.xyz, 3 * one.data.n * sizeof *one.data.xyz);
    ck_assert_mem_eq(one.data.normal, three.data.normal, 3 * one.data.n * sizeof *one.data.normal);
    free(three.list);
    free(three.count);
    vor_lop_samples_free(&three.room);
    vor_lop_samples_free(&three.data);
    vor_domain_free(&three.domain);
    vor_cloud_free(&three.cloud);
    vt_engine_close(&three.engine);
    end(&one);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("lop_fillets");

    vt_add_loop(suite, a_rounded_wedge_has_the_radius_of_its_points_and_a_sharp_one_has_none,
                SEEDS);
    vt_add_loop(suite, data_on_a_fillet_are_put_onto_it, SEEDS);
    vt_add_loop(suite, data_at_a_sharp_edge_stay, SEEDS);
    vt_add(suite, any_number_of_threads_puts_them_at_the_same_places);
    return vt_run(suite);
}
