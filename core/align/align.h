/** Registration: lays a cloud on a reference that shows the same object, or parts of it.
 *
 *  Source: Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec. 5, whose
 *  idea is to make both clouds evenly dense first (align/samples.h), then to find the pose coarsely
 *  (align/match.h) and to refine it (align/fit.h). Departure: the paper assumes that both clouds
 *  show the whole object; here a share may be missing, and `trust` says whether the pose can be
 *  relied on. */
#ifndef VOR_ALIGN_ALIGN_H
#define VOR_ALIGN_ALIGN_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/report.h"
#include "core/spec.h"

/** Finds the pose of a cloud and moves the cloud.
 *
 *  @param[in,out] cloud      gets new positions and turned normals; on failure only fit to be freed
 *  @param[in]     reference  checked (vor_cloud_check), like the cloud
 *  @param[out]    report     its registration is set, and its lengths follow the scale
 *  @param[in]     spec       read: scale, overlap
 *
 *  @retval VOR_E_SPLATS      the cloud is a 3D Gaussian splat
 *  @retval VOR_E_DEGENERATE  as vor_align_samples_make
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  The run's watch gets a record of each step; a stop changes nothing.
 *
 *  O(n) and some seconds at most for the rest, on the run's pool. The same bytes for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_align_cloud(struct vor_cloud *cloud, struct vor_report *report,
                                         const struct vor_cloud *reference,
                                         const struct vor_spec *spec, const struct vor_run *run,
                                         struct vor_error *err);

#endif
