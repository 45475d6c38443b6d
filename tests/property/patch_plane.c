/* Chen et al. 2018, Sec. 3 to 5.1: with planes for patches points are spread as evenly as with
 * quadrics, and lie as far off a curved surface as its planes do. */
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { N = 4000, OUT = 800 };

static uint64_t resample(struct vor_report *report, const struct vor_cloud *in, unsigned threads,
                         const char *patch, const char *polish, double *off)
{
    struct vt_engine engine;
    struct vor_cloud out;
    uint64_t hash;

    vt_engine_open(&engine, threads);
    vt_engine_count(&engine, "points", OUT);
    vt_engine_set(&engine, "patch", patch);
    vt_engine_set(&engine, "polish", polish);
    vt_engine_resample(&engine, &out, report, in);
    ck_assert_uint_eq(out.n, OUT);
    *off = vt_off_mean(&vt_shapes[VT_SPHERE], &out);
    hash = vt_cloud_hash(&out);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return hash;
}

/* The 20 neighbours of a fit lie on a cap of the unit sphere of radius r = sqrt(4 20 / N). Their
 * plane lies a quarter of r^2, 20 / N, below its middle. */
VT_TEST(a_sphere_is_spread_evenly_and_its_points_are_off_as_a_plane_is)
{
    struct vor_report plane, quadric;
    struct vor_cloud in;
    double off, off_quadric;
    uint64_t hash, hash_quadric;

    vt_shapes[VT_SPHERE].make(&in, 3, N);
    hash = resample(&plane, &in, 2, "plane", "100", &off);
    hash_quadric = resample(&quadric, &in, 2, "quadric", "100", &off_quadric);
    ck_assert(hash != hash_quadric);
    ck_assert_double_le(plane.delta, 0.03);
    ck_assert_double_le(plane.delta, 1.3 * quadric.delta);
    ck_assert_double_eq_tol(off, 20.0 / N, 0.1 * 20.0 / N);
    ck_assert_double_lt(off_quadric, 0.05 * off);
    ck_assert_uint_eq(plane.fallback_plane, 0);
    ck_assert_double_eq(plane.triangles_per_cell, 1);
    vor_cloud_free(&in);
}
