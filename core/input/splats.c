#include "core/input/splats.h"

#include <string.h>

static int has_attribute(const struct vor_cloud *cloud, const char *name)
{
    for (size_t i = 0; i < cloud->attribute_count; i++)
        if (strcmp(cloud->attributes[i].name, name) == 0)
            return 1;
    return 0;
}

/* Outliers go, and the others stay as they are. */
static int moves_no_point(const struct vor_spec *spec)
{
    double filters = spec->value[VOR_PARAM_FILTERS];

    return vor_spec_only_filters(spec) && !vor_list_has(filters, VOR_FILTER_MLS) &&
           !vor_list_has(filters, VOR_FILTER_THIN) && vor_spec_outliers(spec) != VOR_OUTLIERS_PULL;
}

vor_status vor_splats_check(const struct vor_cloud *cloud, const struct vor_spec *spec,
                            struct vor_error *err)
{
    if (spec->value[VOR_PARAM_ATTRIBUTES] == VOR_ATTRIBUTES_DROP || moves_no_point(spec) ||
        !(has_attribute(cloud, "f_dc_0") && has_attribute(cloud, "opacity") &&
          has_attribute(cloud, "scale_0") && has_attribute(cloud, "rot_0")))
        return VOR_OK;
    return vor_fail_param(
        err, VOR_E_SPLATS, "attributes",
        "the cloud is a 3D Gaussian splat (f_dc_0, opacity, scale_0, rot_0); moving the points "
        "would make its scales and rotations wrong. attributes=drop resamples the positions alone; "
        "filters=outliers removes outliers and keeps the other splats unchanged");
}
