/** Makes a cloud of seeds: positions in the input's frame, attributes from the nearest input point
 *  (Xiao et al. 2024, Sec. V, does so for colours) or colours of several, normals. */
#ifndef VOR_OUTPUT_TRANSFER_H
#define VOR_OUTPUT_TRANSFER_H

#include "core/output/sides.h"
#include "core/seeds/seeds.h"
#include "core/spec.h"

/** What decides how a cloud is made. All borrowed. */
struct vor_transfer_how {
    double spacing;                /**< mean distance between seeds, in the input's unit */
    const struct vor_spec *spec;   /**< read: attributes, normals */
    const struct vor_sides *sides; /**< as the request needs them (vor_sides_find) */
};

/** Makes a cloud of the seeds and the input that they stand for.
 *
 *  Positions are float32 if the input's are and float32 is fine enough for the spacing
 *  (STEPS_PER_SPACING in transfer.c), else double. With method=insert the points of the input come
 *  first, bit for bit, and then the seeds that may move, in the input's type. Attributes and
 * normals are as the request says. Fitted normals point to the side that `sides` says. With
 * normals=oriented the carried ones do, in float32 and as long as they are; a point whose nearest
 * input point has none with a direction gets a fitted one. Seeds with tracks give them as the
 * attribute "track", the first one.
 *
 *  @param[out] out      initialised, empty; filled only when VOR_OK is returned
 *  @param[in]  in       the cloud that the domain was made of
 *  @param[in]  seeds    on the whole domain
 *  @param[in]  how      see there
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *  @retval VOR_E_LIMIT  too many attributes
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_transfer(struct vor_cloud *out, const struct vor_cloud *in,
                                      struct vor_seeds *seeds, const struct vor_transfer_how *how,
                                      struct vor_error *err);

/** Numbers the points of the first result of a sequence from 0, in the attribute "track", its first
 *  one.
 *
 *  @retval VOR_E_LIMIT, VOR_E_NOMEM as vor_cloud_add_attribute */
VOR_NODISCARD vor_status vor_transfer_number(struct vor_cloud *cloud, struct vor_error *err);

/** Frees the attributes of a result that the one before, in a sequence, does not have. */
void vor_transfer_keep_common(struct vor_cloud *cloud, const struct vor_cloud *previous);

/** Gives a cloud the attributes that the request asks for.
 *
 *  @param[in,out] out  with positions and no attributes; may have some of them on failure
 *  @param[in] source   for each point of out, the point of `in` whose values it gets
 *  @param[in] normal   out->n x 3 fitted normals to add, or NULL
 *  @param[in] spec     read: attributes, normals
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_LIMIT  too many attributes
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_transfer_attributes(struct vor_cloud *out, const struct vor_cloud *in,
                                                 const uint32_t *source, const float *normal,
                                                 const struct vor_spec *spec,
                                                 struct vor_error *err);

#endif
