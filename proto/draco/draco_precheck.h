/** What can be told about a Draco file without the library, so that nothing absurd reaches it. */
#ifndef VOR_PROTO_DRACO_PRECHECK_H
#define VOR_PROTO_DRACO_PRECHECK_H

#include "core/base/status.h"
#include "proto/limits.h"

#include <stddef.h>
#include <stdint.h>

/** A byte of file never stands for more points than this, plus VOR_DRACO_POINTS_FREE a file. */
#define VOR_DRACO_POINTS_PER_BYTE 64
#define VOR_DRACO_POINTS_FREE 100000

/** Most scalars of a point in kd-tree encoding. n points of s scalars can take the decoder n s^2
 *  steps, so all scalars together must also be in proportion to the bytes, three for a point. */
#define VOR_DRACO_KD_SCALARS 64

/** Levels of nested metadata; the library frees them by recursion. */
#define VOR_DRACO_METADATA_DEPTH 16

/** A stream in a larger file, as of 3D tiles and glTF, is padded with zeros to a multiple of 8
 * bytes. More bytes behind it are refused: whatever stands for nothing would make room for points.
 */
#define VOR_DRACO_PADDING_MAX 7

/** Most points a file of that size may hold: the limit, or what its bytes can stand for. */
uint64_t vor_draco_points_max(size_t size, const struct vor_limits *limits);

/** Walks header, metadata, counts and, in point clouds, the attribute table.
 *
 *  @retval VOR_E_FORMAT  not Draco, a bitstream or method the library does not know, truncated,
 *                        counts that contradict each other, more than padding behind a kd-tree, or
 *                        what limits->strict_draco leaves out; byte_offset says where
 *  @retval VOR_E_EMPTY   no points
 *  @retval VOR_E_LIMIT   more points than vor_draco_points_max (or, in a mesh, more than twice as
 *                        many faces), more attributes than a cloud may have, or more scalars
 *                        than a kd-tree may have; limit and got are set
 *
 *  O(metadata + attributes) time, no allocation. Thread-safe.
 *
 *  Source: the Draco bitstream specification, draft of 2017, and files of every version. */
VOR_NODISCARD vor_status vor_draco_precheck(const uint8_t *bytes, size_t size,
                                            const struct vor_limits *limits, struct vor_error *err);

#endif
