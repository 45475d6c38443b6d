/* The thinner domain that dense inputs are iterated on, and how seeds get off it. */
#include "core/input/input.h"
#include "core/input/thin.h"
#include "core/seeds/attach.h"
#include "core/seeds/start.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 4, N = 150000, FEW = 500 }; /* N: several blocks */

#define GAP 0.02

/* Heights over the square that means are made of, and less: three quarters of a spacing. */
#define NOISE 0.002f

/* Points of a unit square, or of two, and their area where there are two. */
enum { DENSE = 60000 };
#define DENSE_AREA 2.0

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain whole, thin;
};

/* bed->cloud is there already. */
static void start(struct bed *bed, unsigned threads, double gap)
{
    vt_engine_open(&bed->engine, threads);
    vt_engine_set(&bed->engine, "neighbors", "20");
    vt_assert_ok(vor_domain_init(&bed->whole, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_domain_thin(&bed->thin, &bed->whole, gap, &bed->engine.run, &vt_err));
}

static void end(struct bed *bed)
{
    vor_domain_free(&bed->thin);
    vor_domain_free(&bed->whole);
    vt_engine_close(&bed->engine);
    vor_cloud_free(&bed->cloud);
    vt_assert_no_leak();
}

/* Distance from every point of `from` to the nearest of `to`. */
static float *distances(const struct vor_domain *from, const struct vor_domain *to)
{
    float *out = vor_malloc(&vt_memory, from->n, sizeof *out);
    uint32_t index;

    for (size_t i = 0; i < from->n; i++) {
        vor_knn_search(to->knn, &from->xyz[3 * i], 1, 1, &index, &out[i]);
        out[i] = sqrtf(out[i]);
    }
    return out;
}

static double squared(const float *a, const float *b)
{
    double x = (double)a[0] - (double)b[0], y = (double)a[1] - (double)b[1],
           z = (double)a[2] - (double)b[2];

    return x * x + y * y + z * z;
}

START_TEST(dropped_points_are_within_a_gap_of_kept_ones_and_those_a_gap_apart_in_the_order)
{
    struct bed bed;
    float *off;
    size_t near = 0;

    vt_cloud_box(&bed.cloud, (uint64_t)_i, N);
    start(&bed, 2, GAP);
    ck_assert_uint_lt(bed.thin.n, N / 4);
    ck_assert(bed.thin.unit == bed.whole.unit);
    ck_assert(memcmp(bed.thin.shift, bed.whole.shift, sizeof bed.thin.shift) == 0);
    off = distances(&bed.whole, &bed.thin);
    for (size_t i = 0; i < bed.whole.n; i++)
        ck_assert_float_lt(off[i], (float)GAP);
    for (size_t i = 1; i < bed.thin.n; i++)
        near += squared(&bed.thin.xyz[3 * i], &bed.thin.xyz[3 * (i - 1)]) < GAP * GAP;
    ck_assert_uint_le(near, N >> 16); /* where a block begins */
    vor_free(&vt_memory, off);
    end(&bed);
}
END_TEST

START_TEST(kept_points_are_the_whole_domains_in_its_order)
{
    struct bed bed;
    size_t at = 0;

    vt_cloud_sphere(&bed.cloud, (uint64_t)_i, N / 5);
    start(&bed, 2, GAP);
    ck_assert_uint_gt(bed.thin.n, 1000);
    for (size_t i = 0; i < bed.thin.n; i++, at++) {
        while (at < bed.whole.n && bed.whole.source[at] != bed.thin.source[i])
            at++;
        ck_assert_uint_lt(at, bed.whole.n);
        ck_assert(memcmp(&bed.thin.xyz[3 * i], &bed.whole.xyz[3 * at], 3 * sizeof(float)) == 0);
    }
    end(&bed);
}
END_TEST

START_TEST(one_two_three_and_eight_threads_keep_the_same_points)
{
    static const unsigned threads_of[4] = {1, 2, 3, 8};
    uint64_t kept = 0;

    for (int t = 0; t < 4; t++) {
        struct bed bed;
        uint64_t hash;

        vt_cloud_box(&bed.cloud, 3, N);
        start(&bed, threads_of[t], GAP);
        hash = vt_hash(bed.thin.source, bed.thin.n * sizeof *bed.thin.source);
        kept = t == 0 ? hash : kept;
        ck_assert(hash == kept);
        end(&bed);
    }
}
END_TEST

START_TEST(where_more_than_half_would_be_kept_nothing_is)
{
    struct bed bed;

    vt_cloud_lattice(&bed.cloud, 40);
    start(&bed, 2, 0.001);
    ck_assert_uint_eq(bed.thin.n, 0);
    ck_assert_ptr_null(bed.thin.knn);
    end(&bed);
}
END_TEST

/* A sheet with waves that the thinner domain is too coarse to follow. */
static void make_waves(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_square(cloud, seed, N);
    for (size_t i = 0; i < cloud->n; i++)
        cloud->xyz[3 * i + 2] = 0.01f * sinf(60 * cloud->xyz[3 * i]);
}

/* Farthest of the seeds from the waves, straight down. */
static double off_waves(const struct vor_seeds *seeds)
{
    const struct vor_domain *domain = seeds->whole;
    double most = 0;

    for (size_t i = 0; i < seeds->n; i++) {
        double x = (double)seeds->xyz[3 * i] * domain->unit + domain->shift[0];
        double z = (double)seeds->xyz[3 * i + 2] * domain->unit + domain->shift[2];

        most = fmax(most, fabs(z - 0.01 * sin(60 * x)));
    }
    return most;
}

/* Puts every seed onto the surface of the domain at hand. */
static void project_all(struct vor_seeds *seeds)
{
    for (size_t i = 0; i < seeds->n; i++) {
        double x[3];

        ck_assert_int_ne(vor_seeds_fit(seeds, &seeds->scratch[0], i), VOR_SURFACE_NONE);
        vor_seeds_position(seeds, i, x);
        vor_surface_put(&seeds->scratch[0].here.surface, x);
        for (size_t c = 0; c < 3; c++)
            seeds->xyz[3 * i + c] = (float)x[c];
    }
}

START_TEST(who_lands_lies_on_the_surface_of_the_whole)
{
    struct vor_seeds seeds;
    struct bed bed;
    uint64_t landed;
    double before;

    make_waves(&bed.cloud, (uint64_t)_i);
    start(&bed, 2, GAP);
    vt_assert_ok(
        vor_start_seeds(&seeds, &bed.whole, FEW, &bed.engine.spec, &bed.engine.run, &vt_err));
    vor_seeds_onto(&seeds, &bed.thin);
    ck_assert_ptr_eq(seeds.domain, &bed.thin);
    project_all(&seeds);
    before = off_waves(&seeds);
    vt_assert_ok(vor_attach_to_whole(&seeds, 0, &vt_err));
    ck_assert_ptr_eq(seeds.domain, &bed.whole);
    ck_assert_msg(off_waves(&seeds) < before / 10, "%g off after %g", off_waves(&seeds), before);
    landed = vt_hash(seeds.xyz, 3 * FEW * sizeof *seeds.xyz);
    vt_assert_ok(vor_attach_to_whole(&seeds, 0, &vt_err)); /* nothing more to do */
    ck_assert(vt_hash(seeds.xyz, 3 * FEW * sizeof *seeds.xyz) == landed);
    vor_seeds_free(&seeds);
    end(&bed);
}
END_TEST

static enum vor_answer say_continue(void *ctx)
{
    (void)ctx;
    return VOR_CONTINUE;
}

static enum vor_answer say_stop(void *ctx)
{
    (void)ctx;
    return VOR_STOP;
}

static enum vor_answer say_cancel(void *ctx)
{
    (void)ctx;
    return VOR_CANCEL;
}

START_TEST(a_stop_does_not_keep_seeds_from_landing_and_a_cancel_does)
{
    struct vor_watch watch = {.poll = say_continue};
    struct vor_no_stop no_stop;
    struct vor_seeds seeds;
    struct bed bed;

    make_waves(&bed.cloud, 1);
    start(&bed, 2, GAP);
    bed.engine.run.watch = &watch;
    bed.engine.run.no_stop = vor_no_stop_watch(&no_stop, &watch);
    vt_assert_ok(
        vor_start_seeds(&seeds, &bed.whole, FEW, &bed.engine.spec, &bed.engine.run, &vt_err));
    vor_seeds_onto(&seeds, &bed.thin);
    watch.poll = say_stop;
    vt_assert_ok(vor_attach_to_whole(&seeds, 0, &vt_err));
    ck_assert_ptr_eq(seeds.domain, &bed.whole);
    vor_seeds_onto(&seeds, &bed.thin);
    watch.poll = say_cancel;
    vt_assert_fails(VOR_E_CANCELLED, vor_attach_to_whole(&seeds, 0, &vt_err));
    vor_seeds_free(&seeds);
    end(&bed);
}
END_TEST

/* Whether a dense cloud has sheets once it is thinned; it has none before. */
static int thinned_has_sheets(const struct vor_cloud *cloud, const char *intrinsic)
{
    struct vt_engine engine;
    struct vor_domain whole, thin;
    int sheets;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "intrinsic", intrinsic);
    vt_assert_ok(vor_input_prepare(&whole, cloud, &engine.spec, &engine.run, &vt_err));
    vt_assert_ok(vor_domain_thin_for(&thin, &whole, FEW, DENSE_AREA, &engine.run, &vt_err));
    ck_assert_uint_gt(thin.n, 0);
    ck_assert(!whole.known.sheets);
    sheets = thin.known.sheets;
    vor_domain_free(&thin);
    vor_domain_free(&whole);
    vt_engine_close(&engine);
    return sheets;
}

START_TEST(sheets_that_only_the_thinned_points_show_are_found_there_if_they_are_asked_for)
{
    struct vor_cloud one, two;

    vt_cloud_square(&one, 1, DENSE);
    vt_cloud_sheets(&two, 1, DENSE, 5 * sqrt(DENSE_AREA / DENSE));
    ck_assert(thinned_has_sheets(&two, "local"));
    ck_assert(!thinned_has_sheets(&two, "none"));
    ck_assert(!thinned_has_sheets(&one, "local"));
    vor_cloud_free(&two);
    vor_cloud_free(&one);
    vt_assert_no_leak();
}
END_TEST

/* Root of the mean square of the height over the square, in its sides. */
static double height(const struct vor_domain *domain)
{
    double sum = 0;

    for (size_t i = 0; i < domain->n; i++) {
        double z = (double)domain->xyz[3 * i + 2] * domain->unit + domain->shift[2];

        sum += z * z;
    }
    return sqrt(sum / (double)domain->n);
}

/* Makes means of a square with noise, as if fits took k of its points. */
static void start_means(struct bed *bed, unsigned threads, unsigned k, int sheets)
{
    vt_cloud_square(&bed->cloud, 1, N);
    for (size_t i = 0; i < bed->cloud.n; i++)
        bed->cloud.xyz[3 * i + 2] = i % 2 == 0 ? NOISE : -NOISE;
    vt_engine_open(&bed->engine, threads);
    vt_engine_set(&bed->engine, "neighbors", "20");
    vt_assert_ok(vor_domain_init(&bed->whole, &bed->cloud, &bed->engine.run, &vt_err));
    bed->whole.known.neighbors = (struct vor_neighbors){.usual = k, .most = k};
    bed->whole.known.sheets = sheets;
    vt_assert_ok(vor_domain_means_for(&bed->thin, &bed->whole, FEW,
                                      1 / (bed->whole.unit * bed->whole.unit), &bed->engine.run,
                                      &vt_err));
}

START_TEST(means_have_less_noise_and_fits_take_fewer_of_them)
{
    struct bed bed;
    double share;

    start_means(&bed, 2, 100, 0);
    ck_assert_uint_gt(bed.thin.n, 10000);
    ck_assert_uint_lt(bed.thin.n, N / 4);
    share = (double)bed.thin.n / N;
    ck_assert_uint_eq(bed.thin.known.neighbors.usual, (unsigned)fmax(100 * share, 20));
    ck_assert_double_lt(height(&bed.thin), 0.6 * height(&bed.whole));
    end(&bed);
}
END_TEST

START_TEST(an_exact_input_and_one_with_sheets_have_no_means)
{
    struct bed bed;

    start_means(&bed, 2, 20, 0);
    ck_assert_uint_eq(bed.thin.n, 0);
    end(&bed);
    start_means(&bed, 2, 100, 1);
    ck_assert_uint_eq(bed.thin.n, 0);
    end(&bed);
}
END_TEST

START_TEST(one_two_three_and_eight_threads_make_the_same_means)
{
    static const unsigned threads_of[4] = {1, 2, 3, 8};
    uint64_t kept = 0;

    for (int t = 0; t < 4; t++) {
        struct bed bed;
        uint64_t hash;

        start_means(&bed, threads_of[t], 100, 0);
        hash = vt_hash(bed.thin.xyz, bed.thin.n * 3 * sizeof *bed.thin.xyz);
        kept = t == 0 ? hash : kept;
        ck_assert(hash == kept);
        end(&bed);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("thin");

    vt_add_loop(suite,
                dropped_points_are_within_a_gap_of_kept_ones_and_those_a_gap_apart_in_the_order,
                VT_FEWER(SEEDS));
    vt_add_loop(suite, kept_points_are_the_whole_domains_in_its_order, VT_FEWER(SEEDS));
    vt_add(suite, one_two_three_and_eight_threads_keep_the_same_points);
    vt_add(suite, where_more_than_half_would_be_kept_nothing_is);
    vt_add_loop(suite, who_lands_lies_on_the_surface_of_the_whole, VT_FEWER(SEEDS));
    vt_add(suite, sheets_that_only_the_thinned_points_show_are_found_there_if_they_are_asked_for);
    vt_add(suite, a_stop_does_not_keep_seeds_from_landing_and_a_cancel_does);
    vt_add(suite, means_have_less_noise_and_fits_take_fewer_of_them);
    vt_add(suite, an_exact_input_and_one_with_sheets_have_no_means);
    vt_add(suite, one_two_three_and_eight_threads_make_the_same_means);
    return vt_run(suite);
}
