/** Draco files (.drc): point clouds and the vertices of meshes in, point clouds and meshes out. */
#ifndef VOR_PROTO_DRACO_H
#define VOR_PROTO_DRACO_H

#include "proto/format.h"

/** Reads a point cloud, or the vertices of a mesh, of bitstream 1.0 .. 1.3 and 2.0 .. 2.3 (meshes:
 *  2.2).
 *
 *  Signature, ownership and failures as vor_format.read. Attributes keep type (booleans become
 *  UINT8), number of components (1 .. 16) and meaning; a normal of other than three components, a
 *  colour of other than three or four, or places in a texture of other than two or three, are
 * GENERIC, and so is a second position; what they mean is then among what is dropped. The name is
 * the attribute's metadata entry "name", control characters as '_', or else "normal", "color",
 * "tex_coord", "generic" or, of a second one, "position". Integers that are flagged as normalised
 * stay integers.
 *
 *  A mesh splits a vertex into several points where its attributes have seams: each of them is a
 *  point, as in other programs. If limits->keep_faces says so, the faces become triangles. Entries
 * of metadata that are none of ours are counted among what is dropped.
 *
 *  Positions in float32 are kept bit for bit, and where the file has the metadata of
 *  vor_draco_write, origin and position type are restored; positions of other types, with the
 *  origin added to them if there is one, go through vor_cloud_set_double and, if
 *  limits->keep_doubles says so, vor_cloud_keep_double.
 *
 *  Header, metadata and declared counts are walked before the library sees a byte
 *  (proto/draco/draco_precheck.h); more points than limits->points or than 64 x size + 100,000 are
 * refused. What the library allocates is charged to out->memory for the time of the call and is
 * bounded by its cap and by 64 MiB + 40 B x the smaller of those two numbers; past that
 * VOR_E_NOMEM.
 *
 *  Cost: O(n) time. Thread-safe: calls share nothing. */
VOR_NODISCARD vor_status vor_draco_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                                        const struct vor_limits *limits, struct vor_error *err);

/** Writes a point cloud as bitstream 2.3, or a mesh as 2.2, in one call of the sink.
 *
 *  Signature and failures as vor_format.write; also VOR_E_EMPTY and VOR_E_NONFINITE as
 *  vor_cloud_check, and VOR_E_LIMIT when an attribute has more than INT32_MAX scalars, or the faces
 *  so many corners.
 *
 *  Positions are written relative to the options' origin, rounded once to float32, or without one
 *  relative to the cloud's own, as they are. An origin other than 0, or of double positions, and
 *  the position type go into the geometry metadata (doubles "voronoid.origin.x", ".y" and ".z", a
 *  text "voronoid.position_type"), so that a reader that ignores them still gets a valid cloud.
 * Attributes keep type, components and meaning; a name that the meaning does not imply goes into
 * the attribute's metadata.
 *
 *  quantization_bits
 *   - 0: everything is kept bit for bit, positions as rounded above; sequential encoding.
 *   - 1 .. 30: positions move by at most half a cell of extent / (2^bits - 1), plus what float32
 *     rounds off.
 *   - -1: the smallest number of bits whose cells are at most spacing / 200 (spacing 0 counts as
 *     extent / sqrt(n)), and more until no two points that differ coincide; as 0 where 30 do not
 *     reach that.
 *  Other than with 0, FLOAT32 attributes are quantised too: exactly, where their values are
 *  multiples of a power of two within 22 bits (labels stored as floats); else 12 bits of their
 *  range for normals, 16 for others. One with values that are not finite is kept as it is, and in
 *  sequential encoding so is whatever takes more than 20 bits, positions included. Integers of
 *  every size and FLOAT64 are always exact; 32-bit integers that the library cannot take (in
 *  sequential encoding, steps beyond 2^20 from point to point) travel as INT64, with their type in
 *  the attribute's metadata ("voronoid.type").
 *  Floats that hold bits (vor_attribute_is_packed, or a number so small that nobody measures it,
 *  below 2^-125) travel as their bytes, four UINT8 each, with their type there too.
 *
 *  The encoding is the kd-tree, which forgets the order of the points, unless keep_order is set or
 *  the kd-tree cannot hold the cloud: it takes quantised FLOAT32 and integers of up to 32 bits, and
 *  at most 64 scalars a point. A mesh is written by edgebreaker, which forgets the order of points
 *  and faces and which corner of a face comes first, unless keep_order is set or it would split or
 *  lose points: those that no face has, or where surfaces touch. Then it is sequential, and where
 *  the library could not read it, having fewer faces than a third of its points, faces of one point
 *  stand behind the others. What is said of bits holds of both, and 0 does not keep the order;
 *  edgebreaker takes 32-bit integers within 2^20. A file that would be so small for its points that
 *  vor_draco_read refused it (all points in one place, say) is written as with 0 instead, in order.
 *
 *  Cost: O(n log n) time; about five times the bytes of the cloud, and 200 a point more for a mesh
 *  of two faces a point, are charged to cloud->memory for the time of the call.
 *  Deterministic: the same cloud and options give the same bytes. Thread-safe. */
VOR_NODISCARD vor_status vor_draco_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                                         const struct vor_write_options *options,
                                         struct vor_error *err);

#endif
