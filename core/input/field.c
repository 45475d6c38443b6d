#include "core/input/field.h"

#include "core/geom/surface.h"

#include <string.h>

/* Weighted sums of the points around a place. */
struct fit {
    unsigned count;
    double weight[VOR_FIELD_AROUND], total, mean[3], value;
};

static void weigh(struct fit *fit, const struct vor_field *field, const uint32_t *index,
                  const float *distance2)
{
    double end2 = VOR_FIELD_ENDS2 * (double)distance2[fit->count - 1];

    for (unsigned j = 0; j < fit->count; j++) {
        double inside = end2 > 0 ? 1 - (double)distance2[j] / end2 : 1;

        fit->weight[j] = inside * inside;
        fit->total += fit->weight[j];
        fit->value += fit->weight[j] * (double)field->value[index[j]];
        for (size_t c = 0; c < 3; c++)
            fit->mean[c] += fit->weight[j] * (double)field->xyz[3 * (size_t)index[j] + c];
    }
    fit->value /= fit->total;
    for (int c = 0; c < 3; c++)
        fit->mean[c] /= fit->total;
}

/* Least squares of the slope, with a ridge. */
static void find_slope(double slope[3], const struct fit *fit, const struct vor_field *field,
                       const uint32_t *index)
{
    double a[9] = {0}, ridge;

    memset(slope, 0, 3 * sizeof *slope);
    for (unsigned j = 0; j < fit->count; j++) {
        double d[3] = {0}; /* clang-analyzer cannot see that the loop sets all */

        for (size_t c = 0; c < 3; c++)
            d[c] = (double)field->xyz[3 * (size_t)index[j] + c] - fit->mean[c];
        for (int c = 0; c < 3; c++) {
            slope[c] += fit->weight[j] * d[c] * ((double)field->value[index[j]] - fit->value);
            for (int e = 0; e <= c; e++)
                a[3 * c + e] += fit->weight[j] * d[c] * d[e];
        }
    }
    /* keeps the slope across the surface, which the points do not show, at 0 */
    ridge = VOR_NEGLIGIBLE * (a[0] + a[4] + a[8]);
    for (int c = 0; c < 3; c++)
        a[4 * c] += ridge;
    if (!(vor_solve_spd(a, slope, 3, 0) > 0))
        memset(slope, 0, 3 * sizeof *slope);
}

void vor_field_find(struct vor_field_near *out, const struct vor_field *field, const float x[3])
{
    struct fit fit = {.count = field->n < VOR_FIELD_AROUND ? (unsigned)field->n : VOR_FIELD_AROUND};
    uint32_t index[VOR_FIELD_AROUND];
    float distance2[VOR_FIELD_AROUND];
    double slope[3], value;

    vor_knn_search(field->knn, x, 1, fit.count, index, distance2);
    weigh(&fit, field, index, distance2);
    find_slope(slope, &fit, field, index);
    value = fit.value;
    for (int c = 0; c < 3; c++) {
        value += slope[c] * ((double)x[c] - fit.mean[c]);
        out->at[c] = x[c];
        out->slope[c] = (float)slope[c];
    }
    out->value = (float)fmin(fmax(value, field->least), field->most);
    out->reach = (float)(VOR_FIELD_REACH * sqrt((double)distance2[fit.count - 1]));
}

void vor_field_free(struct vor_field *field)
{
    vor_knn_free(field->knn);
    VOR_FREE_ALL(field->memory, field->value, field->xyz);
    memset(field, 0, sizeof *field);
}
