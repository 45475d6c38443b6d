/** The table of methods: how seeds are moved. */
#ifndef VOR_METHOD_H
#define VOR_METHOD_H

#include "core/cvt/lloyd.h"

/** One method; its index is the value of parameter `method`. run: as vor_cvt_run. */
struct vor_method {
    const char *name;
    vor_status (*run)(struct vor_seeds *seeds, struct vor_cvt_result *out,
                      const struct vor_spec *spec, double start, struct vor_error *err);
};

const struct vor_method *vor_method(unsigned index);

#endif
