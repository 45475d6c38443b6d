/** What a format is: how files become clouds and clouds files. The table of formats is codec.h. */
#ifndef VOR_PROTO_FORMAT_H
#define VOR_PROTO_FORMAT_H

#include "core/cloud/cloud.h"
#include "core/cloud/mesh.h"
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
    int has_origin;        /**< positions are written relative to origin; else to the cloud's own */
    double origin[3];      /**< only of a format that takes one */
    const struct vor_mesh *mesh; /**< faces over the points, of indices below their number; NULL or
                                      empty for none */
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
    int has_remarks;        /**< its files hold a cloud's remarks */
    int has_int64;          /**< they hold integers of 64 bits, or else make doubles of them */
    int has_blanks;         /**< names of attributes hold blanks, or else get '_' for them */
    vor_status (*read)(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                       const struct vor_limits *limits, struct vor_error *err);
    vor_status (*write)(const struct vor_sink *sink, const struct vor_cloud *cloud,
                        const struct vor_write_options *options, struct vor_error *err);
    int takes_origin; /**< its positions are float32, relative to an origin; else absolute */
    int has_polygons; /**< faces may have more than three corners, or else are cut into triangles */
    int is_fragile;   /**< attributes of strangers may crash its writer, a library's */
};

/** A format that is not read. */
struct vor_foreign {
    const char *name; /**< "LAS" */
    const char *hint; /**< how to make a PLY file of it, or what probably happened */
};

/** What a whole file is by its bytes, for refusals that help; NULL if no format that is known
 * begins like that. */
const struct vor_foreign *vor_foreign_sniff(const uint8_t *bytes, size_t size);

#endif
