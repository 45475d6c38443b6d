#include "core/input/carried.h"

#include "core/base/linalg.h"

#include <math.h>

enum { BLOCK = 1 << 16 }; /* points of one task */

struct count {
    const struct vor_attribute *carried;
    size_t n, *bad, *first; /* of each block */
};

const struct vor_attribute *vor_carried(const struct vor_cloud *in)
{
    const struct vor_attribute *carried = vor_cloud_find(in, VOR_NORMAL);

    return carried != NULL && carried->components >= 3 ? carried : NULL;
}

int vor_carried_normal(const struct vor_attribute *carried, size_t i, double normal[3])
{
    int is_zero = 1, is_finite = 1;

    for (size_t c = 0; c < 3; c++) {
        normal[c] = vor_attribute_scalar(carried, i * carried->components + c);
        is_zero = is_zero && normal[c] == 0;
        is_finite = is_finite && isfinite(normal[c]);
    }
    return is_finite && !is_zero;
}

static void count_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct count *count = ctx;
    size_t block = begin / BLOCK;
    double normal[3];

    (void)worker;
    count->bad[block] = 0;
    count->first[block] = count->n;
    for (size_t i = begin; i < end; i++)
        if (!vor_carried_normal(count->carried, i, normal) && count->bad[block]++ == 0)
            count->first[block] = i;
}

vor_status vor_carried_count(size_t *bad, size_t *first, const struct vor_attribute *carried,
                             size_t n, const struct vor_run *run, struct vor_error *err)
{
    size_t blocks = vor_blocks_of(n, BLOCK);
    struct count count = {.carried = carried, .n = n};
    vor_status status;

    count.bad = vor_malloc(run->memory, blocks, 2 * sizeof *count.bad);
    if (count.bad == NULL)
        return vor_fail(err, VOR_E_NOMEM, "counting %zu normals", n);
    count.first = count.bad + blocks;
    status = vor_run_for(run, n, BLOCK, count_block, &count, err);
    *bad = 0;
    *first = n;
    for (size_t i = 0; status == VOR_OK && i < blocks; i++) {
        *bad += count.bad[i];
        *first = count.first[i] < *first ? count.first[i] : *first;
    }
    vor_free(run->memory, count.bad);
    return status;
}

vor_status vor_carried_check(const struct vor_cloud *in, const struct vor_spec *spec,
                             const struct vor_run *run, struct vor_error *err)
{
    const struct vor_attribute *carried = vor_carried(in);
    size_t bad = in->n, first = 0;
    vor_status status = VOR_OK;

    if (spec->value[VOR_PARAM_INPUT_NORMALS] != VOR_INPUT_NORMALS_USE)
        return VOR_OK;
    if (carried == NULL)
        return vor_fail_param(
            err, VOR_E_NORMALS, "inputNormals",
            "inputNormals is use, but none of the input's %zu points has a normal", in->n);
    status = vor_carried_count(&bad, &first, carried, in->n, run, err);
    if (status != VOR_OK || bad == 0)
        return status;
    return vor_fail_param(err, VOR_E_NORMALS, "inputNormals",
                          "inputNormals is use, but %zu of %zu normals are zero or not finite, "
                          "the first at point %zu",
                          bad, in->n, first);
}
