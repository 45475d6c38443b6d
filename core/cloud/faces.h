/** Points drawn from the triangles of a cloud, so that the surface of a mesh may be resampled and
 *  not its vertices, which lie as its author left them. */
#ifndef VOR_CLOUD_FACES_H
#define VOR_CLOUD_FACES_H

#include "core/cloud/cloud.h"

/** Area of all triangles, in the square of the cloud's unit; 0 where there are none. O(triangles).
 */
double vor_faces_area(const struct vor_cloud *cloud);

/** Checks that points can be drawn.
 *
 *  @retval VOR_E_FACES the cloud has no triangles, or none with an area; the message names the
 *                      parameter `sample` */
VOR_NODISCARD vor_status vor_faces_check(const struct vor_cloud *cloud, struct vor_error *err);

/** How many points to draw where a result of that many is asked for (below 0 or NaN: not known),
 *  out of a mesh of that many vertices: eight for each, at most 10,000,000, but 10,000 and as many
 *  as the mesh has vertices at least. What half and twice as many come to stands in faces.c. */
size_t vor_faces_samples(double points, size_t vertices);

/** Draws n points from the triangles of a cloud.
 *
 *  They lie at equal steps of the cumulated area of the triangles, the first at random: any run of
 *  triangles of the file gets as many as its share of the area, rounded up or down, so that their
 *  number does not vary as that of independent points does. Those of one triangle each get another
 *  of the 4^d triangles it is halved into, d the least for which these are enough, in the order of
 *  [1], whose successive ones lie apart; and in it a place at random.
 *
 *  Attributes of type float or double, and colours in integers of up to 32 bits, are interpolated
 *  linearly, colours rounded; normals then get length 1. Other integers (labels, say), and values
 *  that would not be finite or have no length, are those of the corner that is nearest by the
 *  weights of the interpolation.
 *
 *  @param[out] out  an initialised, empty cloud; gets origin, position type and attributes of `in`,
 *                   no triangles and no notes
 *  @param[in]  in   vor_faces_check lets it pass
 *  @param[in]  n    1 .. VOR_POINTS_MAX
 *
 *  @retval VOR_E_NOMEM they do not fit; *out is empty
 *
 *  O(triangles + n log n) time, on one thread: 0.1 us a point. Depends on the arguments alone.
 *
 *  [1] Basu and Owen 2015, "Low discrepancy constructions in the triangle", Sec. 3. */
VOR_NODISCARD vor_status vor_faces_sample(struct vor_cloud *out, const struct vor_cloud *in,
                                          size_t n, uint64_t seed, struct vor_error *err);

#endif
