#include "core/input/tensor.h"

#include <string.h>

/* Points that the metric around a place is the mean of, as many as for a density (input/field.c).
 */
enum { AROUND = 12 };

/* As in input/field.c. */
#define WEIGHT_ENDS2 1.5
#define REACH 0.5

/* Cosine between normals below which a point lies on another face, beyond a crease, and has no part
 * in the mean. */
#define SAME_FACE 0.5

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
    if (j != nearest && !(fabs(cosine) >= SAME_FACE))
        return;
    for (int c = 0; c < 3; c++)
        sums->normal[c] += (cosine < 0 ? -weight : weight) * (double)normal[c];
    for (size_t c = 0; c < 6; c++)
        sums->tensor[c] += weight * (double)tensors->tensor[6 * (size_t)j + c];
}

void vor_tensor_find(struct vor_tensor_near *out, const struct vor_tensors *tensors,
                     const float x[3])
{
    unsigned count = tensors->n < AROUND ? (unsigned)tensors->n : AROUND;
    uint32_t index[AROUND];
    float distance2[AROUND];
    struct sums sums = {{0}, {0}};
    double axis[2][3], plane[3], length, end2;

    vor_knn_search(tensors->knn, x, 1, count, index, distance2);
    end2 = WEIGHT_ENDS2 * (double)distance2[count - 1];
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
    out->reach = (float)(REACH * sqrt((double)distance2[count - 1]));
}

void vor_tensors_free(struct vor_tensors *tensors)
{
    if (tensors->memory == NULL)
        return;
    vor_knn_free(tensors->knn);
    vor_free(tensors->memory, tensors->tensor);
    vor_free(tensors->memory, tensors->normal);
    vor_free(tensors->memory, tensors->xyz);
    memset(tensors, 0, sizeof *tensors);
}
