/* Samples far from all others are dropped before points are inserted. */
#include "core/lop/strays.h"
#include "tests/support/vt_engine.h"

enum { EDGE = 20, GRID = EDGE * EDGE, STRAYS = 3 };

/* A hexagonal lattice, and three points over it. */
static void make(struct vor_lop_samples *samples, struct vor_memory *memory)
{
    vt_assert_ok(vor_lop_samples_init(samples, GRID + STRAYS, memory, &vt_err));
    samples->n = GRID + STRAYS;
    memset(samples->normal, 0, 3 * samples->n * sizeof *samples->normal);
    for (size_t i = 0; i < GRID + STRAYS; i++) {
        float *x = &samples->xyz[3 * i];
        size_t row = i / EDGE;

        x[0] = 0.04F * ((float)(i % EDGE) + (row % 2 ? 0.5F : 0));
        x[1] = 0.04F * 0.866F * (float)(row % EDGE);
        x[2] = i < GRID ? 0 : 0.15F + 0.2F * (float)(i - GRID);
        samples->normal[3 * i + 2] = i < GRID ? 1 : -1;
    }
}

START_TEST(points_over_an_even_spread_are_dropped_and_its_sides_stay)
{
    struct vt_engine engine;
    struct vor_lop_samples samples;

    vt_engine_open(&engine, 1);
    make(&samples, engine.run.memory);
    vt_assert_ok(vor_lop_strays_drop(&samples, &vt_err));
    ck_assert_uint_ge(samples.n, GRID - 2 * EDGE); /* points of the zigzag sides may go */
    ck_assert_uint_le(samples.n, GRID);
    for (size_t i = 0; i < samples.n; i++) {
        ck_assert(samples.xyz[3 * i + 2] == 0);
        ck_assert(samples.normal[3 * i + 2] == 1);
    }
    vor_lop_samples_free(&samples);
    vt_engine_close(&engine);
    vt_assert_no_leak();
}
END_TEST

START_TEST(few_samples_stay_half_at_least)
{
    struct vt_engine engine;
    struct vor_lop_samples samples;

    vt_engine_open(&engine, 1);
    make(&samples, engine.run.memory);
    samples.n = 4;
    vt_assert_ok(vor_lop_strays_drop(&samples, &vt_err));
    ck_assert_uint_ge(samples.n, 2);
    vor_lop_samples_free(&samples);
    vt_engine_close(&engine);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("lop_strays");

    vt_add(suite, points_over_an_even_spread_are_dropped_and_its_sides_stay);
    vt_add(suite, few_samples_stay_half_at_least);
    return vt_run(suite);
}
