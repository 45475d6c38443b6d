/** Hands out the points of an input that filters alone made the result of: each with its own
 *  attributes, in the order of the input. */
#ifndef VOR_OUTPUT_FILTERED_H
#define VOR_OUTPUT_FILTERED_H

#include "core/input/domain.h"
#include "core/report.h"
#include "core/spec.h"

/** A filtered input. */
struct vor_filtered {
    const struct vor_cloud *in;      /**< that the domain was made of */
    const struct vor_domain *domain; /**< filtered */
    const struct vor_spec *spec;     /**< read: filters, outliers, attributes, normals,
                                          inputNormals, order */
};

/** Makes the result of a request with vor_spec_only_filters.
 *
 *  A point of the input goes where its point of the domain is, and stays where it was, bit for bit,
 *  if that was not moved. Points that share a place move together, or are dropped together; with
 *  the filter thin one of them is left. With normals=fit, normals are those of the surface around
 *  the point, on the side that output/sides.h finds; with oriented they are its own, with
 *  consistent signs. With order=progressive the points are in that order (output/order.h) instead.
 *
 *  The report gets the numbers of points and of outliers, how even the result is, and how far it
 *  and the input are from each other, without the points that were dropped. What a method tells
 *  stays 0.
 *
 *  @param[out] out  initialised, empty; filled only when VOR_OK is returned
 *
 *  @retval VOR_E_NOMEM      8 bytes for each point of the input, 85 for each of the result, and the
 *                           result do not fit; 60 more for each point of the input where the domain
 *                           does not have them all, and what vor_sides_find takes
 *  @retval VOR_E_CANCELLED
 *  @retval VOR_E_LIMIT      too many attributes
 *
 *  O(n log n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_output_filtered(struct vor_cloud *out, struct vor_report *report,
                                             const struct vor_filtered *filtered,
                                             const struct vor_run *run, struct vor_error *err);

#endif
