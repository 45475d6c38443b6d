/** Bytes to clouds and back: one table of formats. */
#ifndef VOR_PROTO_CODEC_H
#define VOR_PROTO_CODEC_H

#include "core/cloud/cloud.h"
#include "core/spec.h"
#include "proto/limits.h"

#include <stddef.h>
#include <stdint.h>

/** Where a writer puts its bytes: returns 0, or a negative number when they cannot be taken. */
struct vor_sink {
    void *ctx;
    int (*write)(void *ctx, const void *bytes, size_t size);
};

/** How a writer writes. */
struct vor_write_options {
    int quantization_bits; /**< Draco: 0 lossless, 1 .. 30, or -1: auto, cells <= spacing / 200 */
    int compression;       /**< Draco: 0 .. 10 */
    int keep_order;        /**< Draco: sequential encoding, the order of the points survives */
    double spacing;        /**< mean distance between neighbours, for auto; 0 when not known */
};

/** One format. Readers take a whole file in memory (the caller maps it), never trust it, allocate
 *  only from cloud->memory, and leave an initialised, empty cloud on failure.
 *
 *  read:  @retval VOR_E_FORMAT (byte_offset says where), VOR_E_EMPTY, VOR_E_NONFINITE, VOR_E_LIMIT
 *         (limit and got), VOR_E_NOMEM
 *  write: @retval VOR_E_IO the sink refused, VOR_E_NOMEM, VOR_E_INTERNAL the library failed */
struct vor_format {
    const char *name;       /**< "ply", "drc": the word of parameter `format`, same index */
    const char *label;      /**< "PLY", "Draco": for messages; statusInfo uses "ply", "draco" */
    const char *media_type; /**< first choice for answers */
    const char *suffix;     /**< ".ply" */
    const char *magic;      /**< how a file begins */
    vor_status (*read)(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                       const struct vor_limits *limits, struct vor_error *err);
    vor_status (*write)(const struct vor_sink *sink, const struct vor_cloud *cloud,
                        const struct vor_write_options *options, struct vor_error *err);
};

/** Format number `index` (VOR_FORMAT_PLY, VOR_FORMAT_DRC), NULL past the last. */
const struct vor_format *vor_format(unsigned index);

/** The format whose magic the bytes begin with, or NULL. */
const struct vor_format *vor_format_sniff(const uint8_t *bytes, size_t size);

/** By the end of a file name (any case), or by media type (parameters after ';' ignored); or NULL.
 */
const struct vor_format *vor_format_by_suffix(const char *path);
const struct vor_format *vor_format_by_media_type(const char *media_type);

/** Sniffs and reads, then vor_cloud_check. out is an initialised, empty cloud. *format (may be
 * NULL) is set as soon as it is known.
 *
 *  @retval VOR_E_UNSUPPORTED no format begins like that (the message shows the first bytes)
 *  @retval others            as vor_format.read */
VOR_NODISCARD vor_status vor_codec_read(struct vor_cloud *out, const struct vor_format **format,
                                        const uint8_t *bytes, size_t size,
                                        const struct vor_limits *limits, struct vor_error *err);

/** Write options from a request and the mean spacing of the cloud to be written. */
void vor_write_options_from(struct vor_write_options *out, const struct vor_spec *spec,
                            double spacing);

/** Our own exact dump of a decoded cloud, for the machine that wrote it: what a job keeps so that
 * no retry parses the upload again. The reader checks sizes and finiteness but is not for
 * strangers' bytes. Same failures as vor_format.read and .write. */
VOR_NODISCARD vor_status vor_dump_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                                        struct vor_error *err);
VOR_NODISCARD vor_status vor_dump_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                                       struct vor_error *err);

#endif
