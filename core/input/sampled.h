/** What of a mesh is resampled: its vertices, or points drawn from its faces. */
#ifndef VOR_INPUT_SAMPLED_H
#define VOR_INPUT_SAMPLED_H

#include "core/cloud/cloud.h"
#include "core/spec.h"

/** Chooses the points that a process spreads others over. With sample=faces they are drawn from the
 *  faces (core/cloud/faces.h), under the seed of the request and as many as go with the number of
 *  points that it asks for; where spacing says that, by the area of the faces.
 *
 *  @param[out] points   given, or own
 *  @param[out] own      initialised, empty; stays so where points is given. The caller frees it
 *  @param[in]  given    checked (vor_cloud_check); borrowed for as long as points is used
 *  @param[in]  spec     read: sample, seed, points, ratio, spacing
 *
 *  @retval VOR_E_FACES  as vor_faces_check
 *  @retval VOR_E_TARGET as vor_spec_check_target, so that no more are drawn than may be asked for
 *  @retval VOR_E_NOMEM
 *
 *  Cost: as vor_faces_sample. */
VOR_NODISCARD vor_status vor_input_sampled(const struct vor_cloud **points, struct vor_cloud *own,
                                           const struct vor_cloud *given,
                                           const struct vor_spec *spec, struct vor_error *err);

#endif
