/** Hands out the points of an input as they are, for another format. */
#ifndef VOR_OUTPUT_CONVERT_H
#define VOR_OUTPUT_CONVERT_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/cloud/mesh.h"
#include "core/report.h"
#include "core/spec.h"

/** Copies a cloud and its faces, and makes the report of the process convert: numbers of points,
 * what was left out. Where the request asks for Draco with quantization=auto, it also measures how
 * even the cloud is, as cells of the file follow the spacing; else the lengths and ratios that only
 * a measurement can tell are NaN.
 *
 *  @param[out] out   initialised, empty; filled only when VOR_OK is returned, like mesh
 *  @param[in]  spec  read: format, quantization
 *
 *  @retval VOR_E_NOMEM      a copy of the cloud does not fit; for the measurement 16 bytes a point
 *                           and an index (knn/knn.h)
 *  @retval VOR_E_CANCELLED
 *
 *  O(n), or O(n log n) on the run's pool where it measures. */
VOR_NODISCARD vor_status vor_convert_cloud(struct vor_cloud *out, struct vor_mesh *mesh,
                                           struct vor_report *report, const struct vor_cloud *in,
                                           const struct vor_spec *spec, const struct vor_run *run,
                                           struct vor_error *err);

#endif
