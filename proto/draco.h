/** Draco files (.drc): point clouds and the vertices of meshes in, point clouds out. */
#ifndef VOR_PROTO_DRACO_H
#define VOR_PROTO_DRACO_H

#include "proto/codec.h"

/** Reads a point cloud, or the vertices of a mesh, of bitstream 1.0 .. 1.3 and 2.0 .. 2.3.
 *
 *  Signature, ownership and failures as vor_format.read. Attributes keep type (booleans become
 *  UINT8), number of components, meaning and name: the attribute's metadata entry "name" where it
 *  has one, else "normal", "color", "tex_coord" or "generic". Integers that are flagged as
 *  normalised stay integers.
 *
 *  A mesh may split a vertex into several points where its attributes have seams: points that share
 *  one position value are merged into the first of them, whose attributes are kept. Vertices that
 *  merely coincide are not.
 *
 *  Where the file is ours, origin and position type are restored from its metadata; otherwise
 *  float32 positions are kept bit for bit and other types go through vor_cloud_set_double.
 *
 *  The file header is checked and the declared number of points is read, where the bitstream lets
 *  us, before the library sees a byte; more points than limits->points or than 64 x size + 100,000
 *  are refused. The library's own memory is charged to out->memory for the time of the call and is
 *  bounded by its cap and by 64 MiB + 40 B x the points that may come; past that VOR_E_NOMEM.
 *
 *  Cost: O(n) time. Thread-safe: calls share nothing. */
VOR_NODISCARD vor_status vor_draco_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                                        const struct vor_limits *limits, struct vor_error *err);

/** Writes a point cloud as bitstream 2.3.
 *
 *  Signature and failures as vor_format.write. Positions are written relative to the origin;
 *  origin and position type go into the metadata, so that a reader that ignores those still gets a
 *  valid cloud.
 *
 *  Deterministic: the same cloud and options give the same bytes. Thread-safe. */
VOR_NODISCARD vor_status vor_draco_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                                         const struct vor_write_options *options,
                                         struct vor_error *err);

#endif
