/* The methods wlop and ear on inputs whose points do not lie as the result's are to: far denser in
 * one place than in another, or exactly on planes that face each other. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N = 6000, TO = 2000, METHODS = 2 };
#define NOISE 0.02F

static const char *const methods[METHODS] = {"method=wlop points=2000", "method=ear points=2000"};

/* Leaves n points of a sphere, of which the lower half has one for ten of the upper half. */
static void half_dense(struct vor_cloud *cloud, size_t n)
{
    struct vor_cloud all;
    size_t left = 0;

    vt_cloud_sphere(&all, 17, 3 * n);
    for (size_t i = 0; i < all.n && left < n; i++)
        if (all.xyz[3 * i + 2] > 0 || vt_unit(18, i) < 0.1)
            memmove(&all.xyz[3 * left++], &all.xyz[3 * i], 3 * sizeof *all.xyz);
    ck_assert_uint_eq(left, n);
    all.n = n;
    *cloud = all;
}

/* Delta of the result, and how many of its points lie below the equator. */
static double delta_of(const struct vor_cloud *in, const char *options, size_t *below)
{
    struct vor_report report;
    struct vor_cloud out;

    vt_ask(&out, &report, &(struct vt_ask){in, options, 2});
    ck_assert_uint_eq(out.n, TO);
    *below = 0;
    for (size_t i = 0; i < out.n; i++)
        *below += out.xyz[3 * i + 2] < 0;
    vor_cloud_free(&out);
    return report.delta;
}

VT_TEST_LOOP(the_density_of_the_input_does_not_show, METHODS)
{
    struct vor_cloud uneven, even;
    double delta, reached;
    size_t below;

    vt_cloud_sphere(&even, 19, N);
    reached = delta_of(&even, methods[_i], &below);
    half_dense(&uneven, N);
    delta = delta_of(&uneven, methods[_i], &below);
    printf("# %s: delta %.4f, of an even input %.4f; %zu points below\n", methods[_i], delta,
           reached, below);
    fflush(stdout);
    ck_assert_double_le(delta, reached + 0.02);
    ck_assert_uint_ge(below, TO / 2 - TO / 25);
    ck_assert_uint_le(below, TO / 2 + TO / 25);
    vt_free_last(&even, &uneven);
}

/* Points inserted by their priorities stand in clusters where noise turns normals, which evening
 * out does not undo. */
VT_TEST(a_surface_without_edges_gets_no_more_points_where_it_bends)
{
    struct vor_cloud in;
    size_t below;
    double delta;

    vt_cloud_sphere(&in, 21, N);
    for (size_t i = 0; i < 3 * in.n; i++)
        in.xyz[i] *= 1 + NOISE * ((float)vt_unit(22, i / 3) - 0.5F);
    delta = delta_of(&in, "method=ear points=2000 samples=1500 rho=10", &below);
    printf("# of a sphere: delta %.4f\n", delta);
    fflush(stdout);
    ck_assert_double_le(delta, 0.025);
    vor_cloud_free(&in);
}

/* Normals of two such sides are exactly opposite. */
VT_TEST(points_on_exact_planes_have_a_place)
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_metrics[VT_PLATE].make(&in, 4, N / 2, 0.08);
    vt_ask(&out, &report, &(struct vt_ask){&in, "method=ear points=1500 polish=0", 2});
    for (size_t i = 0; i < 3 * out.n; i++)
        ck_assert(isfinite(out.xyz[i]) && fabsf(out.xyz[i]) < 2);
    vt_free_last(&out, &in);
}
