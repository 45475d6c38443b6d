/** What is done to bytes that strangers sent, or that go to them, wherever it is done: in this
 * process, or in a child that can do nothing else (codec_run.h decides). */
#ifndef VOR_SERVER_WORK_CODEC_WORK_H
#define VOR_SERVER_WORK_CODEC_WORK_H

#include "core/cloud/extent.h"
#include "core/spec.h"
#include "proto/codec.h"

#include <stddef.h>
#include <stdint.h>

enum vor_codec_op {
    VOR_CODEC_INFLATE, /**< gzip to what was compressed */
    VOR_CODEC_DECODE,  /**< a cloud in any format to a dump (proto/dump.h) */
    VOR_CODEC_CONVERT, /**< a result of ours to another format */
    VOR_CODEC_ENCODE,  /**< a result of the engine to a format; its input: triangles, then a dump */
    VOR_CODEC_OPS
};

/** One piece of work. A plain value: a child gets it as bytes. */
struct vor_codec_order {
    enum vor_codec_op op;
    uint64_t size;                    /**< bytes of the input */
    size_t memory;                    /**< bytes that clouds may take */
    uint64_t most;                    /**< bytes that may come of it */
    struct vor_limits limits;         /**< of decoding */
    unsigned format;                  /**< CONVERT, ENCODE: which one to; an index of vor_format */
    double spacing;                   /**< CONVERT: of the result, 0 where that is not known */
    struct vor_spec spec;             /**< CONVERT: the request */
    struct vor_write_options options; /**< ENCODE; its mesh lies in the input: */
    size_t triangles;                 /**< three indices each; then comes the dump */
    int polygons;                     /**< as in struct vor_mesh */
};

/** What it found. Numbers that it does not concern are 0. */
struct vor_codec_facts {
    unsigned format; /**< DECODE: of the input; an index of vor_format */
    uint64_t points;
    struct vor_extent extent;
    int has_origin; /**< CONVERT: positions count from origin */
    double origin[3];
    size_t memory; /**< ENCODE: bytes that it took at the most */
};

/** Does it.
 *
 *  @param[in]  bytes  order->size of them
 *  @param[out] facts  written only when VOR_OK is returned
 *  @param[in]  sink   takes what comes of it, which is worth nothing on failure
 *
 *  @retval as vor_gzip_inflate, vor_codec_read, vor_write_options_from and vor_format.write
 *  @retval VOR_E_INTERNAL  CONVERT, ENCODE: the result cannot be read
 *
 *  Thread-safe; no globals, no files. */
VOR_NODISCARD vor_status vor_codec_do(struct vor_codec_facts *facts, const struct vor_sink *sink,
                                      const struct vor_codec_order *order, const uint8_t *bytes,
                                      struct vor_error *err);

#endif
