#include "proto/origin.h"

#include "proto/json/json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double absolute[3] = {0, 0, 0};

/* The origin that the request names; false where it leaves that to us. */
static int is_named(double out[3], const struct vor_spec *spec)
{
    if (spec->value[VOR_PARAM_ORIGIN] == VOR_ORIGIN_ABSOLUTE) {
        memcpy(out, absolute, sizeof absolute);
        return 1;
    }
    return vor_spec_vector(spec, VOR_PARAM_ORIGIN, out);
}

static vor_status check_step(const double origin[3], const struct vor_spec *spec,
                             const struct vor_extent *input, double spacing, struct vor_error *err)
{
    double step = vor_extent_step(input, origin), most = spacing / VOR_ORIGIN_STEPS_LEAST;
    char text[VOR_SPEC_VALUE_SIZE];

    if (step <= most || (spacing <= 0 && isfinite(step)))
        return VOR_OK;
    return vor_fail_param(
        err, VOR_E_ORIGIN, "origin",
        "with origin=%.160s, float32 has steps of %g at the farthest point, want at most %.3g "
        "(1/%d of the spacing of the result): use origin=auto or origin=relative",
        vor_spec_text(spec, VOR_PARAM_ORIGIN, text), step, most, VOR_ORIGIN_STEPS_LEAST);
}

vor_status vor_origin_check(const struct vor_spec *spec, const struct vor_extent *input,
                            struct vor_error *err)
{
    double target = vor_spec_target(spec, input->n), named[3];
    /* The largest spacing that the result may have, as far as that is known; 0 where it is not. */
    double spacing = vor_spec_given(spec, VOR_PARAM_SPACING) ? spec->value[VOR_PARAM_SPACING]
                     : target >= 1 ? VOR_ORIGIN_MARGIN * vor_extent_spacing(input, target)
                                   : 0;

    if (spacing <= 0 || !is_named(named, spec))
        return VOR_OK;
    return check_step(named, spec, input, spacing, err);
}

vor_status vor_origin_resolve(double out[3], const struct vor_spec *spec,
                              const struct vor_extent *input, double spacing, struct vor_error *err)
{
    double finest = vor_extent_spacing(input, (double)input->n) / VOR_ORIGIN_STEPS_AUTO;
    double named[3];
    vor_status status = VOR_OK;

    if (is_named(named, spec)) {
        status = check_step(named, spec, input, spacing, err);
        if (status == VOR_OK)
            memcpy(out, named, sizeof named);
    } else if (spec->value[VOR_PARAM_ORIGIN] == VOR_ORIGIN_AUTO &&
               vor_extent_step(input, absolute) <= finest) {
        memcpy(out, absolute, sizeof absolute);
    } else {
        vor_extent_middle(out, input, finest);
    }
    return status;
}

const char *vor_origin_text(const double origin[3], char out[VOR_ORIGIN_TEXT_SIZE])
{
    char number[3][VOR_JSON_NUMBER_MAX];

    for (int c = 0; c < 3; c++)
        (void)vor_json_format_double(number[c], origin[c]);
    (void)snprintf(out, VOR_ORIGIN_TEXT_SIZE, "%.25s,%.25s,%.25s", number[0], number[1], number[2]);
    return out;
}
