#include "core/seeds/target.h"

#include "core/geom/patch.h"
#include "core/input/islands.h"
#include "core/seeds/area.h"

#include <math.h>

vor_status vor_target_resolve(struct vor_target *out, const struct vor_domain *domain, size_t input,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    double target = vor_spec_target(spec, input);
    vor_status status;

    *out = (struct vor_target){0, 0};
    if (vor_spec_only_filters(spec))
        return VOR_OK;
    if (vor_spec_given(spec, VOR_PARAM_SPACING)) {
        double spacing = spec->value[VOR_PARAM_SPACING] / domain->unit;

        status = vor_area_of_surface(&out->area, domain, (uint64_t)spec->value[VOR_PARAM_SEED], run,
                                     err);
        if (status != VOR_OK)
            return status;
        target = rint(out->area / (VOR_HEXAGON_HEIGHT * spacing * spacing));
        if (target <= (double)VOR_POINTS_MAX)
            target += (double)vor_islands_beside(domain, (size_t)target);
    }
    status = vor_spec_check_target(spec, target, input, err);
    if (status == VOR_OK)
        out->n = (size_t)target;
    return status;
}
