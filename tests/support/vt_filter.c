#include "tests/support/vt_filter.h"

#include <math.h>

void vt_number(struct vor_cloud *cloud)
{
    struct vor_attribute *id;
    uint32_t *value;

    vt_assert_ok(vor_cloud_add_attribute(cloud, "id", VOR_GENERIC, VOR_UINT32, 1, &id, &vt_err));
    value = id->data;
    for (size_t i = 0; i < cloud->n; i++)
        value[i] = (uint32_t)i;
}

size_t vt_number_of(const struct vor_cloud *cloud, size_t i)
{
    const struct vor_attribute *id = vor_cloud_find_name(cloud, "id");

    ck_assert_ptr_nonnull(id);
    return ((const uint32_t *)id->data)[i];
}

void vt_noise_radial(struct vor_cloud *cloud, uint64_t seed, double deviation, int is_sphere)
{
    for (size_t i = 0; i < cloud->n; i++) {
        float off = (float)(deviation * vt_normal(seed + 1000, i));

        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] += off * (is_sphere ? cloud->xyz[3 * i + c] : (float)(c == 2));
    }
}

void vt_stray(struct vor_cloud *cloud, uint64_t seed)
{
    for (size_t i = 0; i < VT_STRAYS; i++)
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] *= (float)(1.1 + 0.9 * vt_unit(seed + 2000, i));
}

double vt_off_sphere(const struct vor_cloud *cloud, size_t i)
{
    const float *x = &cloud->xyz[3 * i];

    return fabs(sqrt((double)x[0] * x[0] + (double)x[1] * x[1] + (double)x[2] * x[2]) - 1);
}

double vt_rms_off_sphere(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t i = 0; i < cloud->n; i++)
        sum += vt_off_sphere(cloud, i) * vt_off_sphere(cloud, i);
    return sqrt(sum / (double)cloud->n);
}

void vt_filter(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
               const char *filters, const char *outliers)
{
    vt_resample(out, report, in, "filters=%s outliers=%s", filters, outliers);
}
