#include "core/lop/samples.h"

vor_status vor_lop_samples_init(struct vor_lop_samples *out, size_t room, struct vor_memory *memory,
                                struct vor_error *err)
{
    float *xyz = vor_malloc(memory, room, 3 * sizeof *xyz);
    float *normal = vor_malloc(memory, room, 3 * sizeof *normal);

    if (xyz == NULL || normal == NULL) {
        VOR_FREE_ALL(memory, normal, xyz);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", room);
    }
    *out = (struct vor_lop_samples){memory, 0, room, xyz, normal, NULL};
    return VOR_OK;
}

void vor_lop_samples_free(struct vor_lop_samples *samples)
{
    VOR_FREE_ALL(samples->memory, samples->area, samples->normal, samples->xyz);
    *samples = (struct vor_lop_samples){0};
}
