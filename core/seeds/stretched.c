#include "core/seeds/stretched.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"

#include <string.h>

enum {
    BLOCK = 256, /* seeds of one task */
    /* Seeds nearest in the metric that a cell is first clipped by, and that act on a seed: all
     * within 2.4 spacings. */
    NEAR_IN_METRIC = 24
};

/* Spacings that the seeds of a list may have moved. */
#define MOVED 0.8
vor_status vor_stretched_init(struct vor_stretched *out, const struct vor_tensors *field, size_t n,
                              struct vor_memory *memory, struct vor_error *err)
{
    struct vor_stretched stretched = {.field = field, .n = n};

    if (!vor_tensors_are(field))
        return VOR_OK;
    stretched.near = vor_calloc(memory, n, sizeof *stretched.near);
    if (stretched.near == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    *out = stretched;
    return VOR_OK;
}

void vor_stretched_free(struct vor_stretched *stretched, struct vor_memory *memory)
{
    vor_free(memory, stretched->near);
    memset(stretched, 0, sizeof *stretched);
}

struct renew {
    struct vor_stretched *stretched;
    const float *xyz;
};

static void renew_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct renew *renew = ctx;
    struct vor_tensor_near *near = &renew->stretched->near[i];
    const float *x = &renew->xyz[3 * i];
    double reach = (double)near->reach;

    if (near->aspect == 0 || vor_distance2f(near->at, x) > reach * reach)
        vor_tensor_find(near, renew->stretched->field, x);
}

vor_status vor_stretched_renew(struct vor_stretched *stretched, const float *xyz,
                               const struct vor_run *run, struct vor_error *err)
{
    struct renew renew = {stretched, xyz};

    if (stretched->near == NULL)
        return VOR_OK;
    return vor_run_rows(run, stretched->n, BLOCK, renew_row, &renew, err);
}

unsigned vor_stretched_listed(const struct vor_tensors *field, unsigned listed)
{
    double radius, wanted;

    if (!vor_tensors_are(field))
        return listed;
    radius = VOR_HARD_REACH * sqrt(field->most) + MOVED;
    wanted = fmax(ceil(VOR_HEXAGON_WITHIN * radius * radius), listed);
    return (unsigned)fmin(wanted, VOR_POINT_LISTS_LISTED_MAX);
}

/* Squared distance of seeds i and j in the metric of seed i. */
static float distance2_in(const float *xyz, size_t i, size_t j, const struct vor_surface *surface,
                          const struct vor_stretch *stretch)
{
    const float *a = &xyz[3 * i], *b = &xyz[3 * j];
    double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                   (double)b[2] - (double)a[2]};
    double offset[3] = {vor_dot(surface->axis[0], d), vor_dot(surface->axis[1], d),
                        vor_dot(surface->axis[2], d)};

    vor_stretch_local(stretch, offset);
    return (float)vor_dot(offset, offset);
}

void vor_stretched_crowd(struct vor_crowd *crowd, const float *xyz, size_t i,
                         const struct vor_surface *surface, const struct vor_stretch *stretch)
{
    uint32_t index[NEAR_IN_METRIC + 1] = {0}; /* cppcheck takes kept for more than was set */
    float distance2[NEAR_IN_METRIC + 1] = {0};
    double sure = crowd->sure * stretch->least;
    unsigned kept = 0;

    for (unsigned j = 0; j < crowd->count; j++) {
        float d2 = distance2_in(xyz, i, crowd->index[j], surface, stretch);
        unsigned at = kept;

        for (; at > 0 && d2 < distance2[at - 1]; at--) {
            distance2[at] = distance2[at - 1];
            index[at] = index[at - 1];
        }
        distance2[at] = d2;
        index[at] = crowd->index[j];
        if (kept < NEAR_IN_METRIC)
            kept++;
        else
            sure = fmin(sure, sqrt((double)distance2[NEAR_IN_METRIC]) * (1 - VOR_ROUNDED));
    }
    memcpy(crowd->index, index, kept * sizeof *index);
    memcpy(crowd->distance2, distance2, kept * sizeof *distance2);
    crowd->count = kept;
    crowd->sure = sure;
}

void vor_stretched_distances(struct vor_crowd *crowd, const struct vor_stretched *stretched,
                             const float *xyz, size_t i)
{
    if (!vor_stretched_are(stretched))
        return;
    for (unsigned j = 0; j < crowd->count; j++) {
        const float *a = &xyz[3 * i], *b = &xyz[3 * (size_t)crowd->index[j]];
        double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                       (double)b[2] - (double)a[2]};

        crowd->distance2[j] = (float)vor_stretched_length2(stretched, i, crowd->index[j], d);
    }
}
