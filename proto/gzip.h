/** Inflates what came with Content-Encoding: gzip. The one door to zlib. */
#ifndef VOR_PROTO_GZIP_H
#define VOR_PROTO_GZIP_H

#include "core/base/status.h"
#include "proto/format.h"

#include <stddef.h>
#include <stdint.h>

/** Bytes that may always come of a body, and how many times its own size may where more do. Deflate
 *  reaches 1032 times. Measured with gzip -6: bunny, kitti, autzen and scannet 1.1 to 2.6 times, a
 *  grid of whole numbers 5.1 times in binary PLY, 3.9 in ASCII. */
enum { VOR_GZIP_FREE = 1 << 20, VOR_GZIP_RATIO_MAX = 100 };

/** Inflates a whole body (RFC 1952) into a sink.
 *
 *  @param[in] bytes  size of them; one member, or several one behind the other
 *  @param[in] most   bytes that may come of it, besides the ratio above
 *
 *  @retval VOR_E_EMPTY    size is 0
 *  @retval VOR_E_REQUEST  no gzip, damaged, cut short, or followed by something else (byte_offset
 *                         says where)
 *  @retval VOR_E_BYTES    more than `most`, or beyond the ratio (limit and got are set); at most
 *                         that many bytes went to the sink
 *  @retval VOR_E_IO       the sink refused
 *  @retval VOR_E_NOMEM
 *
 *  O(size + what comes of it) time, some 100 KiB of memory. */
VOR_NODISCARD vor_status vor_gzip_inflate(const struct vor_sink *sink, const uint8_t *bytes,
                                          size_t size, uint64_t most, struct vor_error *err);

#endif
