/* What ear and wlop fit to where an input is dense and rough: means of its points. */
#include "core/input/thin.h"
#include "tests/support/vt_engine.h"

#include <math.h>

enum { N = 150000, FEW = 500 };

/* Root of the mean square of the height over the square, in its sides. */
static double height(const struct vor_domain *domain)
{
    double sum = 0;

    for (size_t i = 0; i < domain->n; i++)
        sum += pow((double)domain->xyz[3 * i + 2] * domain->unit + domain->shift[2], 2);
    return sqrt(sum / (double)domain->n);
}

/* An input whose fits take few of its points, or that has sheets, has none. */
VT_TEST_LOOP(means_have_less_noise_and_fits_take_fewer_of_them, 3)
{
    static const struct vor_conditioning known[] = {
        {.neighbors = {.usual = 100, .most = 100}},
        {.neighbors = {.usual = 20, .most = 20}},
        {.neighbors = {.usual = 100, .most = 100}, .sheets = 1},
    };
    struct vor_domain whole, thin;
    struct vt_engine engine;
    struct vor_cloud cloud;

    vt_cloud_square(&cloud, 1, N);
    for (size_t i = 0; i < N; i++)
        cloud.xyz[3 * i + 2] = i % 2 == 0 ? 0.002F : -0.002F;
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_domain_init(&whole, &cloud, &engine.run, &vt_err));
    whole.known.neighbors = known[_i].neighbors;
    whole.known.sheets = known[_i].sheets;
    vt_assert_ok(vor_domain_means_for(&thin, &whole, FEW, 1 / (whole.unit * whole.unit),
                                      &engine.run, &vt_err));
    ck_assert_int_eq(thin.n > 0, _i == 0);
    if (_i == 0) {
        ck_assert_uint_lt(thin.n, N / 4);
        ck_assert_uint_eq(thin.known.neighbors.usual,
                          (unsigned)fmax(100.0 * (double)thin.n / N, 20));
        ck_assert_double_lt(height(&thin), 0.6 * height(&whole));
    }
    vor_domain_free(&thin);
    vor_domain_free(&whole);
    vt_engine_close(&engine);
    vor_cloud_free(&cloud);
}
