#include "core/input/carried.h"

#include "core/base/count.h"

#include <math.h>

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

static int is_bad(const void *carried, size_t i)
{
    double normal[3];

    return !vor_carried_normal(carried, i, normal);
}

vor_status vor_carried_count(size_t *bad, size_t *first, const struct vor_attribute *carried,
                             size_t n, const struct vor_run *run, struct vor_error *err)
{
    return vor_count(bad, first, n, is_bad, carried, run, err);
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
            "inputNormals=use needs normals, but none of the input's %zu points has a normal",
            in->n);
    status = vor_carried_count(&bad, &first, carried, in->n, run, err);
    if (status != VOR_OK || bad == 0)
        return status;
    return vor_fail_param(err, VOR_E_NORMALS, "inputNormals",
                          "inputNormals=use needs valid normals, but %zu of %zu normals are "
                          "zero or not finite, the first at point %zu",
                          bad, in->n, first);
}
