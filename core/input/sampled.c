#include "core/input/sampled.h"

#include "core/cloud/faces.h"

#include <math.h>

/* How many points the request asks for, about; below 0 where it does not. */
static double points_wanted(const struct vor_cloud *given, const struct vor_spec *spec)
{
    const double hexagon = sqrt(3) / 2; /* area of a cell over the square of the spacing */
    double spacing = spec->value[VOR_PARAM_SPACING];

    if (!vor_spec_given(spec, VOR_PARAM_SPACING))
        return vor_spec_target(spec, given->n);
    return rint(vor_faces_area(given) / (hexagon * spacing * spacing));
}

vor_status vor_input_sampled(const struct vor_cloud **points, struct vor_cloud *own,
                             const struct vor_cloud *given, const struct vor_spec *spec,
                             struct vor_error *err)
{
    uint64_t seed = (uint64_t)spec->value[VOR_PARAM_SEED];
    vor_status status;
    double wanted;

    *points = given;
    if (spec->value[VOR_PARAM_SAMPLE] != VOR_SAMPLE_FACES)
        return VOR_OK;
    status = vor_faces_check(given, err);
    if (status != VOR_OK)
        return status;
    wanted = points_wanted(given, spec);
    status = vor_spec_check_target(spec, wanted, given->n, err);
    if (status != VOR_OK)
        return status;
    *points = own;
    return vor_faces_sample(own, given, vor_faces_samples(wanted, given->n), seed, err);
}
