/* The polish of oriented points: repulsion along their planes. */
#include "core/base/linalg.h"
#include "core/lop/even.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 4, N = 900, TWINS = 90 };

/* The unit square at z = 0: samples of it of which the first ones have a twin so much farther in x
 * and y. */
static void make_twins(struct vor_lop_samples *out, uint64_t seed, double apart)
{
    vt_assert_ok(vor_lop_samples_init(out, N + TWINS, &vt_memory, &vt_err));
    for (size_t i = 0; i < N + TWINS; i++) {
        size_t of = i < N ? i : i - N;
        double by = i < N ? 0 : apart;

        out->xyz[3 * i] = (float)(vt_unit(seed, 2 * of) + by);
        out->xyz[3 * i + 1] = (float)(vt_unit(seed, 2 * of + 1) + by);
        out->xyz[3 * i + 2] = 0;
        memcpy(&out->normal[3 * i], (const float[]){0, 0, 1}, 3 * sizeof(float));
    }
    out->n = N + TWINS;
}

static void even_out(struct vor_lop_samples *samples, uint32_t steps, double spacing)
{
    const struct vor_domain domain = {.unit = 1};
    struct vor_lop_latent latent;
    struct vor_outcome told;
    struct vt_engine engine;

    memset(&told, 0, sizeof told);
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_lop_latent_init(&latent, samples, 0.3, 3 * spacing, &engine.run, &vt_err));
    vt_assert_ok(vor_lop_even(samples, &latent,
                              &(struct vor_lop_even_how){.steps = steps, .spec = &engine.spec},
                              &domain, &told, &engine.run, &vt_err));
    ck_assert_uint_eq(told.steps[VOR_RUN_STAGE_POLISH], steps);
    vor_lop_latent_free(&latent);
    vt_engine_close(&engine);
}

/* However near they are. The nearest two of all: 0.22 to 0.30 spacings; where not the force but the
 * weight of a distance is bounded, at most 0.06. */
START_TEST(points_that_are_nearly_one_are_pushed_apart)
{
    static const double apart[] = {1e-1, 1e-2, 1e-3, 1e-5};
    double spacing = 1 / sqrt(N + TWINS), nearest2 = INFINITY;
    struct vor_lop_samples samples;

    make_twins(&samples, (uint64_t)_i / 4, apart[_i % 4] * spacing);
    even_out(&samples, VOR_LOP_EVEN_MOST, spacing);
    for (size_t i = 0; i < samples.n; i++)
        for (size_t j = 0; j < i; j++)
            nearest2 = fmin(nearest2, vor_distance2f(&samples.xyz[3 * i], &samples.xyz[3 * j]));
    ck_assert_double_gt(nearest2, 0.15 * 0.15 * spacing * spacing);
    vor_lop_samples_free(&samples);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("lop_even");

    vt_add_loop(suite, points_that_are_nearly_one_are_pushed_apart, 4 * SEEDS);
    return vt_run(suite);
}
