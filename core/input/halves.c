#include "core/input/halves.h"

#include <string.h>

void vor_halves_init(struct vor_halves *out, const struct vor_domain *domain)
{
    memset(out, 0, sizeof *out);
    out->memory = domain->memory;
    out->levels = 1;
    out->level[0].n = domain->n;
    out->level[0].xyz = domain->xyz;
    out->level[0].knn = domain->knn;
}

vor_status vor_halves_add(struct vor_halves *halves, size_t least, const struct vor_run *run,
                          struct vor_error *err)
{
    unsigned to = halves->levels;
    size_t n = halves->level[0].n >> to;
    float *xyz;
    vor_status status;

    if (to == VOR_HALVES_SIZE || n < least)
        return VOR_OK;
    xyz = vor_malloc(halves->memory, n, 3 * sizeof *xyz);
    if (xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", halves->level[0].n);
    for (size_t i = 0; i < n; i++)
        memcpy(&xyz[3 * i], &halves->level[0].xyz[3 * (i << to)], 3 * sizeof *xyz);
    status = vor_knn_build_sorted(&halves->index[to], xyz, n, run, err);
    if (status != VOR_OK) {
        vor_free(halves->memory, xyz);
        return status;
    }
    halves->own[to] = xyz;
    halves->level[to].n = n;
    halves->level[to].xyz = xyz;
    halves->level[to].knn = halves->index[to];
    halves->levels++;
    return VOR_OK;
}

void vor_halves_free(struct vor_halves *halves)
{
    for (unsigned level = 1; level < halves->levels; level++) {
        vor_knn_free(halves->index[level]);
        vor_free(halves->memory, halves->own[level]);
    }
    halves->levels = 0;
}
