/* The energy of all cells while their planes stand still, and its gradient (Chen 2018, Sec. 4.3.3;
 * rows C6, C8, C9; errata 002.8). */
#include "core/cvt/frozen.h"
#include "core/opt/lbfgs.h"
#include "core/seeds/start.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { IN = 4000, N = 200 };

/* Seeds on a sphere, a torus, a square with a border, by loop % 3. */
struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_frozen frozen;
    double y[2 * N], gradient[2 * N];
};

static void open_bed(struct bed *bed, int loop, unsigned power, unsigned threads)
{
    vt_engine_open(&bed->engine, threads);
    vt_engine_count(&bed->engine, "seed", (size_t)loop + 1);
    if (loop % 3 == 0)
        vt_cloud_sphere(&bed->cloud, (uint64_t)loop, IN);
    else if (loop % 3 == 1)
        vt_cloud_torus(&bed->cloud, (uint64_t)loop, IN);
    else
        vt_cloud_square(&bed->cloud, (uint64_t)loop, IN);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_start_seeds(&bed->seeds, &bed->domain, N, &bed->engine.spec, &bed->engine.run,
                                 &vt_err));
    vt_assert_ok(vor_frozen_init(&bed->frozen, &bed->seeds, loop % 2, &vt_err));
    vt_assert_ok(vor_frozen_set(&bed->frozen, power, bed->y, &bed->engine.run, &vt_err));
}

static void close_bed(struct bed *bed)
{
    vor_frozen_free(&bed->frozen);
    vor_seeds_free(&bed->seeds);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
}

static double energy_at(struct bed *bed)
{
    double value;

    vt_assert_ok(vor_frozen_at(&bed->frozen, bed->y, &value, bed->gradient, &vt_err));
    return value;
}

/* Moves every seed a little off the middle of its patch. */
static void scatter(struct bed *bed, uint64_t seed)
{
    for (size_t i = 0; i < (size_t)2 * N; i++)
        bed->y[i] = 0.4 * bed->frozen.planes.plane[i / 2].reach * (2 * vt_unit(seed, i) - 1);
}

/* The step is so short that hardly a corner appears or goes within it: there the second derivative
 * jumps. */
VT_TEST_FIGURES(the_gradient_is_that_of_finite_differences, 24)
{
    static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    const double h = 2e-6;
    static struct bed bed;
    double gradient[2 * N], most = 0;
    unsigned power = _i % 4 == 0 ? 2 : _i % 4 == 1 ? 4 : 8;

    open_bed(&bed, _i, power, 2);
    for (size_t i = 0; i < N; i++) { /* anisotropic in every second loop of four */
        bed.frozen.planes.plane[i].flat.factor[0] = _i % 4 < 2 ? 1 : 0.6 + vt_unit(5, i);
        bed.frozen.planes.plane[i].flat.radius *=
            _i % 5 == 0 ? 0.5 : 1; /* cut by the disc as well */
    }
    scatter(&bed, (uint64_t)_i);
    (void)energy_at(&bed);
    memcpy(gradient, bed.gradient, sizeof gradient);
    for (size_t k = 0; k < (size_t)2 * N; k++)
        most = fmax(most, fabs(gradient[k]));
    ck_assert_double_gt(most, 1e-3);
    for (size_t k = (size_t)_i; k < (size_t)2 * N; k += 13) {
        double from = bed.y[k], slope = 0;

        for (int s = 0; s < 4; s++) {
            bed.y[k] = from + at[s] * h;
            slope += weight[s] * energy_at(&bed) / (12 * h);
        }
        bed.y[k] = from;
        ck_assert_double_eq_tol(slope / most, gradient[k] / most, 1e-6);
    }
    close_bed(&bed);
}

/* Two seeds that share a place would keep it: their gradients are the same. */
VT_TEST_FIGURES(seeds_that_share_a_place_come_apart, 3)
{
    static struct bed bed;
    struct vor_lbfgs_function function;
    struct vor_lbfgs_told told;
    struct vor_lbfgs lbfgs;
    double apart[2];

    open_bed(&bed, _i, 2, 1);
    memcpy(&bed.seeds.xyz[3], &bed.seeds.xyz[0], 3 * sizeof(float));
    vt_assert_ok(vor_lbfgs_init(&lbfgs, 2 * N, &vt_memory, &vt_err));
    vt_assert_ok(vor_frozen_set(&bed.frozen, 2, bed.y, &bed.engine.run, &vt_err));
    function = (struct vor_lbfgs_function){&bed.frozen, vor_frozen_at, vor_frozen_shorten,
                                           bed.frozen.bend};
    vt_assert_ok(vor_lbfgs_run(&lbfgs, bed.y, &function, VOR_LBFGS_STEPS, &told, &vt_err));
    for (int d = 0; d < 2; d++)
        apart[d] = bed.y[d] - bed.y[2 + d];
    ck_assert_double_gt(hypot(apart[0], apart[1]), 0.1);
    vor_lbfgs_free(&lbfgs);
    close_bed(&bed);
}
