/** From seeds to a cloud: positions back in the input's frame, attributes from the nearest input
 * point (Xiao et al. 2024, Sec. V: colours), normals. */
#ifndef VOR_OUTPUT_TRANSFER_H
#define VOR_OUTPUT_TRANSFER_H

#include "core/seeds/seeds.h"
#include "core/spec.h"

/** Fills out (initialised, empty) from the seeds and the input they stand for.
 *
 *  Positions: float32 where the input has float32 and its step there is at most 1 / 200 of the
 * spacing; else double. Attributes and normals: as the request says. Fitted normals take the side
 * of the nearest input normal, without input normals the side away from the middle of the cloud.
 *
 *  @param[in] spacing  mean distance between seeds, in the input's unit
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_LIMIT (attributes) */
VOR_NODISCARD vor_status vor_transfer(struct vor_cloud *out, const struct vor_cloud *in,
                                      struct vor_seeds *seeds, double spacing,
                                      const struct vor_spec *spec, struct vor_error *err);

#endif
