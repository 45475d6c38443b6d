/** Makes what a run hands out, the cloud and the report, from the points that a method placed. */
#ifndef VOR_OUTPUT_OUTPUT_H
#define VOR_OUTPUT_OUTPUT_H

#include "core/cloud/cloud.h"
#include "core/metrics/uniformity.h"
#include "core/report.h"
#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** The points that a method placed, and what it started from. All borrowed. */
struct vor_placed {
    const struct vor_cloud *in;     /**< the cloud that the domain was made of */
    struct vor_seeds *seeds;        /**< on the whole domain */
    const struct vor_outcome *told; /**< what the method told */
    const struct vor_spec *spec;    /**< read: order, attributes, normals, inputNormals, lattice */
    uint32_t *order;                /**< NULL, or seeds->n: receives which seed each point of the
                                         result is */
};

/** Measures how even the points are, compares them with the input, orders them as the request says,
 *  and transfers attributes. With lattice=keep it first puts the points onto the input's lattice.
 *
 *  @param[out]    out     an initialised, empty cloud; filled only when VOR_OK is returned
 *  @param[in,out] report  receives what follows from the points, what the method told and what is
 *                         known of the domain; the caller sets its seconds and parameters
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *  @retval VOR_E_LIMIT too many attributes
 *  @retval VOR_E_PARAM, VOR_E_TARGET  lattice=keep: as vor_levels_find, vor_snap_seeds
 *
 *  O(n log n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_output_make(struct vor_cloud *out, struct vor_report *report,
                                         const struct vor_placed *placed, struct vor_error *err);

/** Reports how even points are; unit is the length of a unit of *even in the cloud's own. */
void vor_output_report_uniformity(struct vor_report *report, const struct vor_uniformity *even,
                                  double unit);

/** Reports what is known of the input, and what was done to it. */
void vor_output_report_input(struct vor_report *report, const struct vor_domain *domain);

#endif
