#include "core/seeds/target.h"

#include "core/geom/patch.h"
#include "core/input/islands.h"
#include "core/seeds/area.h"

#include <math.h>

vor_status vor_target_resolve(struct vor_target *out, const struct vor_domain *domain, size_t input,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    double target = vor_spec_target(spec, input), method = spec->value[VOR_PARAM_METHOD];
    int spaced = vor_spec_given(spec, VOR_PARAM_SPACING);
    vor_status status = VOR_OK;

    *out = (struct vor_target){0, 0};
    if (vor_spec_only_filters(spec))
        return VOR_OK;
    if (spaced || method == VOR_METHOD_INSERT || method == VOR_METHOD_KMEANS)
        status = vor_area_of_surface(&out->area, domain, (uint64_t)spec->value[VOR_PARAM_SEED], run,
                                     err);
    if (status != VOR_OK && (spaced || status != VOR_E_DEGENERATE))
        return status;
    if (spaced) {
        double spacing = spec->value[VOR_PARAM_SPACING] / domain->unit;

        target = rint(out->area / (VOR_HEXAGON_HEIGHT * spacing * spacing));
        if (target <= (double)VOR_POINTS_MAX)
            target += (double)vor_islands_beside(domain, (size_t)target);
    }
    status = vor_spec_check_target(spec, target, input, err);
    if (status == VOR_OK)
        out->n = (size_t)target;
    return status;
}
