/** Refuses 3D Gaussian splats where their points would move. */
#ifndef VOR_INPUT_SPLATS_H
#define VOR_INPUT_SPLATS_H

#include "core/cloud/cloud.h"
#include "core/spec.h"

/** Checks that a request keeps splats where they are, or leaves out what makes them splats. Scales
 *  and rotations fit the place, the size and the overlap of each splat: nearest ones at other
 *  places are a wrong picture. A cloud counts as splats if it has scalars f_dc_0, opacity, scale_0
 *  and rot_0 (Kerbl et al. 2023).
 *
 *  @retval VOR_E_SPLATS the cloud is splats; the message says what may be requested */
VOR_NODISCARD vor_status vor_splats_check(const struct vor_cloud *cloud,
                                          const struct vor_spec *spec, struct vor_error *err);

#endif
