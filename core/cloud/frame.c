#include "core/cloud/frame.h"

#include <math.h>
#include <string.h>

void vor_frame_choose(struct vor_frame *out, const struct vor_cloud *a, const struct vor_cloud *b)
{
    const struct vor_cloud *clouds[2] = {a, b != NULL ? b : a};
    double x[3], low[3], high[3], largest = 0;
    int exponent;

    vor_cloud_position(a, 0, low);
    memcpy(high, low, sizeof high);
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < clouds[k]->n; i++) {
            vor_cloud_position(clouds[k], i, x);
            for (int c = 0; c < 3; c++) {
                low[c] = fmin(low[c], x[c]);
                high[c] = fmax(high[c], x[c]);
            }
        }
    for (int c = 0; c < 3; c++) {
        out->middle[c] = low[c] / 2 + high[c] / 2;
        largest = fmax(largest, high[c] / 2 - low[c] / 2);
    }
    (void)frexp(largest, &exponent);
    out->unit = largest > 0 ? ldexp(1, exponent) : 1;
}

vor_status vor_frame_positions(float **out, const struct vor_cloud *cloud,
                               const struct vor_frame *frame, struct vor_memory *memory,
                               struct vor_error *err)
{
    float *xyz = vor_malloc(memory, cloud->n, 3 * sizeof *xyz);
    double x[3];

    if (xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    for (size_t i = 0; i < cloud->n; i++) {
        vor_cloud_position(cloud, i, x);
        for (size_t c = 0; c < 3; c++)
            xyz[3 * i + c] = (float)((x[c] - frame->middle[c]) / frame->unit);
    }
    *out = xyz;
    return VOR_OK;
}
