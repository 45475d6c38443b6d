/* What ear does with an input whose noise is as wide as its fits: it works on fewer points, and
 * drops samples far from all others before it inserts points. */
#include "core/input/coarsen.h"
#include "core/lop/strays.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { N = 24000, FEWEST = 1200, EDGE = 20, GRID = EDGE * EDGE, STRAYS = 3 };

/* A layer over a unit square, as thick as fits are wide, one that they see over, a ball (the 150
 * points nearest to one reach 0.055 where they fill space), two noisy walls 2.3 spacings apart. */
VT_TEST_LOOP(a_layer_as_thick_as_fits_are_wide_has_fewer_points, 4)
{
    static const float heights[] = {0.1F, 0.02F, 1, 0.0226F};
    struct vor_cloud cloud, other;
    struct vor_domain whole, few;
    struct vt_engine engine;

    vt_cloud_square(&cloud, 5, N);
    vt_cloud_square(&other, 6, N);
    for (size_t i = 0; i < N; i++)
        cloud.xyz[3 * i + 2] =
            heights[_i] * (_i < 3 ? other.xyz[3 * i] : (float)(i % 2 + 0.13 * vt_normal(7, i)));
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_domain_init(&whole, &cloud, &engine.run, &vt_err));
    vt_assert_ok(vor_domain_coarsen(&few, &whole, &engine.run, &vt_err));
    if (_i == 0) {
        ck_assert(few.n > FEWEST && few.n <= N / 2 && few.unit == whole.unit);
        ck_assert_ptr_nonnull(few.knn);
    } else {
        ck_assert(few.n == 0 && few.knn == NULL);
    }
    vor_domain_free(&few);
    vor_domain_free(&whole);
    vt_engine_close(&engine);
    vt_free_last(&other, &cloud);
}

/* Of a hexagonal lattice and three points over it; points of the zigzag sides may go. */
VT_TEST(samples_far_from_an_even_spread_are_dropped)
{
    struct vor_lop_samples samples;

    vt_assert_ok(vor_lop_samples_init(&samples, GRID + STRAYS, &vt_memory, &vt_err));
    samples.n = GRID + STRAYS;
    memset(samples.normal, 0, 3 * samples.n * sizeof *samples.normal);
    for (size_t i = 0; i < samples.n; i++) {
        float *x = &samples.xyz[3 * i];

        x[0] = 0.04F * ((float)(i % EDGE) + (i / EDGE % 2 ? 0.5F : 0));
        x[1] = 0.04F * 0.866F * (float)(i / EDGE % EDGE);
        x[2] = i < GRID ? 0 : 0.15F + 0.2F * (float)(i - GRID);
        samples.normal[3 * i + 2] = i < GRID ? 1 : -1;
    }
    vt_assert_ok(vor_lop_strays_drop(&samples, &vt_err));
    ck_assert(samples.n >= GRID - 2 * EDGE && samples.n <= GRID);
    for (size_t i = 0; i < samples.n; i++)
        ck_assert(samples.xyz[3 * i + 2] == 0 && samples.normal[3 * i + 2] == 1);
    samples.n = 4;
    vt_assert_ok(vor_lop_strays_drop(&samples, &vt_err));
    ck_assert_uint_ge(samples.n, 2);
    vor_lop_samples_free(&samples);
}
