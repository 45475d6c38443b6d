#include "core/lop/beside.h"

#include "core/base/linalg.h"
#include "core/lop/normals.h"
#include "core/lop/weights.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 256, /* points of one task */
    /* Data whose distance says how far from one a point may lie, and the share of it: half of their
     * spacing. Else samples that start between two sheets, where a datum's normal is wrong, stay
     * there. */
    BESIDE = 7
};
#define BESIDE_REACH 0.4

struct putting {
    struct vor_lop_samples *samples;
    const struct vor_lop_beside *beside;
    size_t first;
    double scale; /* of vor_lop_alike */
};

static double cosine_of(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

/* Puts a place onto the plane of a datum whose neighbours end at a squared distance. */
static void face(float *x, const float *datum, const float *normal, double distance2)
{
    double height = 0, away2 = 0, part;

    for (size_t c = 0; c < 3; c++)
        height += ((double)x[c] - (double)datum[c]) * (double)normal[c];
    for (size_t c = 0; c < 3; c++) {
        x[c] = (float)((double)x[c] - height * (double)normal[c]);
        away2 += ((double)x[c] - (double)datum[c]) * ((double)x[c] - (double)datum[c]);
    }
    part = fmin(1, BESIDE_REACH * sqrt(distance2 / fmax(away2, 1e-30)));
    for (size_t c = 0; c < 3; c++)
        x[c] = (float)((double)datum[c] + part * ((double)x[c] - (double)datum[c]));
}

size_t vor_lop_beside_face(float *x, const struct vor_lop_beside *beside, struct vor_knn_last *last)
{
    unsigned k = beside->domain->n < BESIDE ? (unsigned)beside->domain->n : BESIDE;
    uint32_t index[BESIDE];
    float distance2[BESIDE];

    vor_knn_search_next(beside->domain->knn, last, x, k, index, distance2);
    face(x, &beside->data->xyz[3 * (size_t)index[0]], &beside->data->normal[3 * (size_t)index[0]],
         (double)distance2[k - 1]);
    return index[0];
}

/* Whether a datum of the side of point i is nearer to it than half of the way to that datum's
 * twelfth neighbour: about a spacing. */
static int has_side(const struct putting *putting, size_t i, struct vor_knn_last *last)
{
    const struct vor_lop_samples *data = putting->beside->data;
    const float *x = &putting->samples->xyz[3 * i], *n = &putting->samples->normal[3 * i];
    unsigned k = data->n < VOR_LOP_AREA_OF ? (unsigned)data->n : VOR_LOP_AREA_OF;
    uint32_t index[VOR_LOP_AREA_OF];
    float distance2[VOR_LOP_AREA_OF];

    vor_knn_search_next(putting->beside->domain->knn, last, x, k, index, distance2);
    for (unsigned j = 0; j < k; j++) {
        size_t at = index[j];

        if (vor_lop_alike(cosine_of(n, &data->normal[3 * at]), putting->scale) > 0 &&
            4 * vor_distance2f(x, &data->xyz[3 * at]) < (double)data->area[at])
            return 1;
    }
    return 0;
}

static void put_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct putting *putting = ctx;
    struct vor_knn_last side = {.k = 0}, near = {.k = 0};

    for (size_t i = putting->first + begin; i < putting->first + end; i++) {
        float *x = &putting->samples->xyz[3 * i], *n = &putting->samples->normal[3 * i], at[3];
        const float *m;

        if (has_side(putting, i, &side))
            continue;
        memcpy(at, x, sizeof at);
        m = &putting->beside->data->normal[3 * vor_lop_beside_face(at, putting->beside, &near)];
        if (cosine_of(n, m) >= 0)
            continue;
        memcpy(x, at, sizeof at);
        memcpy(n, m, sizeof at);
    }
}

vor_status vor_lop_beside_put(struct vor_lop_samples *samples, size_t first,
                              const struct vor_lop_beside *beside, const struct vor_run *run,
                              struct vor_error *err)
{
    struct putting putting = {samples, beside, first, vor_lop_scale(beside->sigma_n)};

    if (beside->data == NULL)
        return VOR_OK;
    return vor_run_for(run, samples->n - first, BLOCK, put_block, &putting, err);
}
