/** PLY 1.0 files (.ply): the vertices of any PLY in, and its faces where they are wanted; binary
 *  little-endian PLY out, with faces where the points have some. */
#ifndef VOR_PROTO_PLY_H
#define VOR_PROTO_PLY_H

#include "proto/format.h"

/** Reads the element `vertex`, and if limits->keep_faces says so `face` and `tristrips` into
 *  triangles (proto/ply/ply_faces.h), of an ascii, binary_little_endian or binary_big_endian file.
 *
 *  Signature, ownership and failures as vor_format.read.
 *
 *  Coordinates of type float are kept bit for bit; char to ushort become float32, exactly; where
 *  one of the three is int, uint or double, all three go through vor_cloud_set_double and, if
 * limits->keep_doubles says so, vor_cloud_keep_double. nx ny nz, or else normal_x ..., become a
 * NORMAL and red green blue [alpha], or else diffuse_red ... or r g b [a], a COLOR where the parts
 * share a type, and tex_coord_0 tex_coord_1 [tex_coord_2] a TEX_COORD; every other scalar property
 * becomes a GENERIC under its name, byte by byte. What is not named like that may be named so in
 * other letters: X, Red. List properties of a vertex are skipped, and so are elements before
 * `vertex`; what follows the last vertex, or the last face that is wanted, is not looked at. In
 * ascii a vertex is a line, and blank lines do not count. The cloud's notes get the remarks
 * (comment, obj_info), and what is skipped or not looked at, in the numbers that the header
 * declares.
 *
 *  Points with a coordinate that is not finite are refused, or dropped (vor_cloud_sift).
 *
 *  Refused as VOR_E_FORMAT before anything is allocated for the points: a header of more than
 *  limits->header_bytes, a line of more than 1,024 bytes, more than 64 properties of an element or
 *  16 elements, and counts that need more bytes than the file has.
 *
 *  Numbers in ascii are decimal and correctly rounded, whatever the locale, whole ones with a point
 *  or without; outside the coordinates, nan and inf are taken for floating-point properties, as any
 *  C library prints them. A byte order mark of UTF-8 may stand before the magic, and blanks behind.
 *
 *  Cost: one pass. Thread-safe. */
VOR_NODISCARD vor_status vor_ply_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                                      const struct vor_limits *limits, struct vor_error *err);

/** Writes binary_little_endian. Of options, which may be NULL, the mesh alone is looked at.
 *
 *  Signature and failures as vor_format.write. Coordinates are absolute, of the cloud's position
 *  type; a NORMAL of three is written as nx ny nz, a COLOR of three or four as red green blue
 *  [alpha], a TEX_COORD of two or three as tex_coord_0 ..., everything else under its name, with
 * _0, _1 ... appended where it has several components. Names are made free of blanks and control
 * characters and unique; 64-bit integers, which PLY lacks, become double. The cloud's remarks
 * follow one of our own. Faces, if there are any, are an element `face` behind the vertices, lists
 * `vertex_indices` of uchar 3 and int. What vor_ply_read yields comes back the same, bit for bit.
 *
 *  Cost: one pass and 64 KiB from cloud->memory, more where the attributes are many. Deterministic;
 *  thread-safe. */
VOR_NODISCARD vor_status vor_ply_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                                       const struct vor_write_options *options,
                                       struct vor_error *err);

#endif
