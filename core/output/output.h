/** From the points that a method placed to what a run hands out: the cloud and the report. */
#ifndef VOR_OUTPUT_OUTPUT_H
#define VOR_OUTPUT_OUTPUT_H

#include "core/cloud/cloud.h"
#include "core/report.h"
#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** What a method left, and what it started from. All borrowed. */
struct vor_placed {
    const struct vor_cloud *in;     /**< the cloud that the domain was made of */
    struct vor_seeds *seeds;        /**< on the whole domain */
    const struct vor_outcome *told; /**< what the method said */
    const struct vor_spec *spec;    /**< read: order, attributes, normals */
};

/** Measures how even the points are, compares them with the input, puts them into the order asked
 *  for, and carries attributes over.
 *
 *  @param[out]    out     an initialised, empty cloud; filled only when VOR_OK is returned
 *  @param[in,out] report  gets everything that follows from the points, what the method said, and
 *                         what is known of the domain; its seconds and parameters are the caller's
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *  @retval VOR_E_LIMIT too many attributes
 *
 *  O(n log n). The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_output_make(struct vor_cloud *out, struct vor_report *report,
                                         const struct vor_placed *placed, struct vor_error *err);

#endif
