/* Fewer points of an input whose noise is as wide as its fits. */
#include "core/input/coarsen.h"
#include "tests/support/vt_engine.h"

enum { N = 24000, FEWEST = 1200 };

/* Heights of the layers that points over a unit square fill, as of 24,000: the 150 points nearest
 * to one reach 0.055 where they fill space. */
#define WIDE 0.1F
#define NARROW 0.02F

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain whole, few;
};

static void start(struct bed *bed, unsigned threads, float height)
{
    struct vor_cloud other;

    vt_engine_open(&bed->engine, threads);
    vt_cloud_square(&bed->cloud, 5, N);
    vt_cloud_square(&other, 6, N);
    for (size_t i = 0; i < bed->cloud.n; i++)
        bed->cloud.xyz[3 * i + 2] = height * other.xyz[3 * i];
    vor_cloud_free(&other);
    vt_assert_ok(vor_domain_init(&bed->whole, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_domain_coarsen(&bed->few, &bed->whole, &bed->engine.run, &vt_err));
}

static void end(struct bed *bed)
{
    vor_domain_free(&bed->few);
    vor_domain_free(&bed->whole);
    vt_engine_close(&bed->engine);
    vor_cloud_free(&bed->cloud);
    vt_assert_no_leak();
}

START_TEST(a_layer_as_thick_as_fits_are_wide_has_fewer_points)
{
    struct bed bed;

    start(&bed, 2, WIDE);
    ck_assert_uint_gt(bed.few.n, FEWEST);
    ck_assert_uint_le(bed.few.n, N / 2);
    ck_assert(bed.few.unit == bed.whole.unit);
    ck_assert_ptr_nonnull(bed.few.knn);
    end(&bed);
}
END_TEST

START_TEST(a_layer_that_fits_see_over_stays_as_it_is)
{
    struct bed bed;

    start(&bed, 2, NARROW);
    ck_assert_uint_eq(bed.few.n, 0);
    ck_assert_ptr_null(bed.few.knn);
    end(&bed);
}
END_TEST

START_TEST(a_ball_of_points_stays_as_it_is)
{
    struct bed bed;

    start(&bed, 2, 1);
    ck_assert_uint_eq(bed.few.n, 0);
    end(&bed);
}
END_TEST

START_TEST(one_two_three_and_eight_threads_take_the_same_points)
{
    static const unsigned threads_of[4] = {1, 2, 3, 8};
    uint64_t taken = 0;

    for (int t = 0; t < 4; t++) {
        struct bed bed;
        uint64_t hash;

        start(&bed, threads_of[t], WIDE);
        hash = vt_hash(bed.few.source, bed.few.n * sizeof *bed.few.source);
        taken = t == 0 ? hash : taken;
        ck_assert(hash == taken);
        end(&bed);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("coarsen");

    vt_add(suite, a_layer_as_thick_as_fits_are_wide_has_fewer_points);
    vt_add(suite, a_layer_that_fits_see_over_stays_as_it_is);
    vt_add(suite, a_ball_of_points_stays_as_it_is);
    vt_add(suite, one_two_three_and_eight_threads_take_the_same_points);
    return vt_run(suite);
}
