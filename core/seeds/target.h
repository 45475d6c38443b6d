/** How many points a request asks for. */
#ifndef VOR_SEEDS_TARGET_H
#define VOR_SEEDS_TARGET_H

#include "core/input/domain.h"
#include "core/spec.h"

/** What a request comes to. */
struct vor_target {
    size_t n;    /**< points; 0 where filters alone decide */
    double area; /**< of the surface, normalised, with spacing, insert and kmeans; else 0 */
};

/** Computes the number of points from points, ratio or spacing.
 *
 *  @param[in] input  points of the input
 *  @param[in] run    not ended by a stop
 *
 *  @retval VOR_E_TARGET  as vor_spec_check_target
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED  as vor_area_of_surface, where the area is wanted
 *  @retval VOR_E_DEGENERATE              so, too, with spacing
 *
 *  O(1), or as vor_area_of_surface. */
VOR_NODISCARD vor_status vor_target_resolve(struct vor_target *out, const struct vor_domain *domain,
                                            size_t input, const struct vor_spec *spec,
                                            const struct vor_run *run, struct vor_error *err);

#endif
