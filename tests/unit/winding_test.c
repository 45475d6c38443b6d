/* Patches that face the wrong way: those that winding numbers tell, and those that they do not. */
#include "core/geom/winding.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { SEEDS = 4, N = 4000, HALF = N / 2 };

/* A surface of two halves, the second of which is a patch. */
struct halves {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_span span;
    struct vor_winding_points points;
    uint32_t first[N], next[N];
    unsigned char odd[N];
    float normal[3 * N], area[N];
};

static void make(struct halves *halves, double area, double support)
{
    vt_engine_open(&halves->engine, 2);
    halves->span = (struct vor_span){
        .n = N, .first = halves->first, .next = halves->next, .odd = halves->odd, .joins = 1};
    halves->span.join[0] = (struct vor_span_join){HALF, HALF, support};
    halves->points = (struct vor_winding_points){halves->cloud.xyz, halves->normal, halves->area};
    for (size_t i = 0; i < N; i++) {
        halves->first[i] = 0;
        halves->next[i] = i + 1 < N ? (uint32_t)i + 1 : UINT32_MAX;
        halves->odd[i] = i >= HALF;
        halves->area[i] = (float)area / N;
    }
}

/* Asserts that the patch, which starts turned, ends so or not, and that this is where it stays. */
static void turn_twice(struct halves *halves, unsigned odd)
{
    for (int k = 0; k < 2; k++) {
        vt_assert_ok(
            vor_winding_turn(&halves->span, &halves->points, &halves->engine.run, &vt_err));
        for (size_t i = 0; i < N; i++)
            ck_assert_uint_eq(halves->odd[i], i >= HALF && odd);
    }
    vt_engine_close(&halves->engine);
    vor_cloud_free(&halves->cloud);
    vt_assert_no_leak();
}

/* Two spheres that touch: the second is inside out. */
START_TEST(a_part_that_is_inside_out_is_turned)
{
    struct halves halves;

    vt_cloud_sphere(&halves.cloud, (uint64_t)_i, N);
    memcpy(halves.normal, halves.cloud.xyz, sizeof halves.normal);
    for (size_t i = HALF; i < N; i++)
        halves.cloud.xyz[3 * i] += 2;
    make(&halves, 8 * 3.14159265, 1);
    turn_twice(&halves, 0);
}
END_TEST

/* Half a square: which side is right, numbers do not say, though edges are at odds over it. */
START_TEST(a_flat_patch_stays_as_edges_have_it)
{
    struct halves halves;

    vt_cloud_square(&halves.cloud, (uint64_t)_i, N);
    for (size_t i = 0; i < N; i++) {
        halves.cloud.xyz[3 * i] = 0.5F * halves.cloud.xyz[3 * i] + (i < HALF ? 0 : 0.5F);
        memcpy(&halves.normal[3 * i], (float[3]){0, 0, 1}, 3 * sizeof *halves.normal);
    }
    make(&halves, 1, 0);
    turn_twice(&halves, 1);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("winding");

    vt_add_loop(suite, a_part_that_is_inside_out_is_turned, VT_FEWER(SEEDS));
    vt_add_loop(suite, a_flat_patch_stays_as_edges_have_it, VT_FEWER(SEEDS));
    return vt_run(suite);
}
