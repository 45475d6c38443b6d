#include "core/process.h"

#include <stdlib.h>

vor_status vor_toy_poison(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    volatile int *volatile nowhere = NULL;

    (void)out;
    (void)in;
    (void)run;
    if (spec->value[VOR_PARAM_VENOM] > 0)
        abort();
    *nowhere = 1;
    return vor_fail(err, VOR_E_INTERNAL, "the poison does not work");
}
