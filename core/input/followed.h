/** What a request wants the points to follow besides the surface: a density, a metric. */
#ifndef VOR_INPUT_FOLLOWED_H
#define VOR_INPUT_FOLLOWED_H

#include "core/input/anisotropy.h"
#include "core/input/density.h"

/** vor_density_check, then vor_anisotropy_check; fails as they do. */
VOR_NODISCARD static inline vor_status vor_followed_check(const struct vor_cloud *in,
                                                          const struct vor_spec *spec,
                                                          const struct vor_run *run,
                                                          struct vor_error *err)
{
    vor_status status = vor_density_check(in, spec, run, err);

    return status == VOR_OK ? vor_anisotropy_check(in, spec, run, err) : status;
}

/** vor_density_make, then vor_anisotropy_make; fails as they do. */
VOR_NODISCARD static inline vor_status
vor_followed_make(struct vor_domain *domain, const struct vor_cloud *in, size_t n,
                  const struct vor_spec *spec, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = vor_density_make(domain, in, n, spec, run, err);

    return status == VOR_OK ? vor_anisotropy_make(domain, in, n, spec, run, err) : status;
}

#endif
