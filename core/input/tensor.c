#include "core/input/tensor.h"

#include "core/input/field.h"

#include <string.h>

/* Weighted sums of the points around a place. */
struct sums {
    double normal[3], tensor[6];
};

/* Adds a point whose normal is to agree with that of the nearest one. */
static void add(struct sums *sums, const struct vor_tensors *tensors, uint32_t j, uint32_t nearest,
                double weight)
{
    const float *normal = &tensors->normal[3 * (size_t)j];
    const float *like = &tensors->normal[3 * (size_t)nearest];
    double cosine = 0;

    for (int c = 0; c < 3; c++)
        cosine += (double)normal[c] * (double)like[c];
    if (j != nearest && !(fabs(cosine) >= VOR_SAME_WAY))
        return;
    for (int c = 0; c < 3; c++)
        sums->normal[c] += (cosine < 0 ? -weight : weight) * (double)normal[c];
    for (size_t c = 0; c < 6; c++)
        sums->tensor[c] += weight * (double)tensors->tensor[6 * (size_t)j + c];
}

void vor_tensor_find(struct vor_tensor_near *out, const struct vor_tensors *tensors,
                     const float x[3])
{
    unsigned count = tensors->n < VOR_FIELD_AROUND ? (unsigned)tensors->n : VOR_FIELD_AROUND;
    uint32_t index[VOR_FIELD_AROUND];
    float distance2[VOR_FIELD_AROUND];
    struct sums sums = {{0}, {0}};
    double axis[2][3], plane[3], length, end2;

    vor_knn_search(tensors->knn, x, 1, count, index, distance2);
    end2 = VOR_FIELD_ENDS2 * (double)distance2[count - 1];
    for (unsigned j = 0; j < count; j++) {
        double inside = end2 > 0 ? 1 - (double)distance2[j] / end2 : 1;

        add(&sums, tensors, index[j], index[0], inside * inside);
    }
    length = sqrt(vor_dot(sums.normal, sums.normal));
    for (int c = 0; c < 3; c++)
        sums.normal[c] /= length;
    vor_metric_axes(axis, sums.normal);
    vor_metric_restrict(plane, sums.tensor, axis);
    (void)vor_metric_even(plane, tensors->most);
    out->aspect = (float)vor_metric_aspect(plane);
    vor_metric_raise(sums.tensor, plane, axis, sums.normal);
    for (int c = 0; c < 6; c++)
        out->tensor[c] = (float)sums.tensor[c];
    for (int c = 0; c < 3; c++) {
        out->normal[c] = (float)sums.normal[c];
        out->at[c] = x[c];
    }
    out->reach = (float)(VOR_FIELD_REACH * sqrt((double)distance2[count - 1]));
}

void vor_tensors_free(struct vor_tensors *tensors)
{
    vor_knn_free(tensors->knn);
    VOR_FREE_ALL(tensors->memory, tensors->tensor, tensors->normal, tensors->xyz);
    memset(tensors, 0, sizeof *tensors);
}
