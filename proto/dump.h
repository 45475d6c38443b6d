/** A decoded cloud as a job keeps it. */
#ifndef VOR_PROTO_DUMP_H
#define VOR_PROTO_DUMP_H

#include "proto/format.h"

/** Our own exact dump of a decoded cloud, for the machine that wrote it: what a job keeps so that
 * no retry parses the upload again. The reader checks sizes and finiteness but is not for
 * strangers' bytes. Another form, or another seal (server/blob/seal.h), makes the stores' schemas
 * new ones: jobs that wait have the old. Same failures as vor_format.read and .write. */
VOR_NODISCARD vor_status vor_dump_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                                        struct vor_error *err);
/** Bytes that the dump of a cloud will have. No cost: nothing is copied. */
uint64_t vor_dump_size(const struct vor_cloud *cloud);

VOR_NODISCARD vor_status vor_dump_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                                       struct vor_error *err);

/** Checks bytes as vor_dump_read does, and takes no memory: what another process wrote is believed
 *  after this.
 *
 *  @param[out] points  how many the cloud has
 *
 *  @retval VOR_E_FORMAT, VOR_E_NONFINITE
 *
 *  O(size) time: 0.3 ns a byte. */
VOR_NODISCARD vor_status vor_dump_check(size_t *points, const uint8_t *bytes, size_t size,
                                        struct vor_error *err);

#endif
