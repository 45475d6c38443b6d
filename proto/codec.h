/** Bytes to clouds and back: one table of formats. */
#ifndef VOR_PROTO_CODEC_H
#define VOR_PROTO_CODEC_H

#include "core/cloud/extent.h"
#include "core/report.h"
#include "core/spec.h"
#include "proto/format.h"

#include <stddef.h>
#include <stdint.h>

/** Format number `index` (VOR_FORMAT_PLY, VOR_FORMAT_DRC), NULL past the last. */
const struct vor_format *vor_format(unsigned index);

/** The format whose magic the bytes begin with, or NULL. */
const struct vor_format *vor_format_sniff(const uint8_t *bytes, size_t size);

/** By the end of a file name (any case), or by media type (parameters after ';' ignored); or NULL.
 */
const struct vor_format *vor_format_by_suffix(const char *path);
const struct vor_format *vor_format_by_media_type(const char *media_type);

/** Sniffs and reads, then vor_cloud_check and, if faces are needed, vor_faces_check. out is an
 * initialised, empty cloud. *format (may be NULL) is set as soon as it is known.
 *
 *  @retval VOR_E_UNSUPPORTED no format begins like that (the message shows the first bytes)
 *  @retval VOR_E_FACES       faces are needed, and there are none with an area
 *  @retval others            as vor_format.read */
VOR_NODISCARD vor_status vor_codec_read(struct vor_cloud *out, const struct vor_format **format,
                                        const uint8_t *bytes, size_t size,
                                        const struct vor_limits *limits, struct vor_error *err);

/** What the file of a result follows from besides the request. */
struct vor_result_facts {
    struct vor_extent input; /**< of the main input */
    double spacing;          /**< mean distance between neighbours of the result; 0, or NaN, if that
                                  is not known */
};

/** Write options for a result in a format. Where the spacing is not known, an origin is judged by
 *  the estimate of vor_extent_spacing for the input.
 *
 *  @param[out] out  unchanged on failure; its origin is 0 for a format that takes none
 *  @retval VOR_E_ORIGIN as vor_origin_resolve */
VOR_NODISCARD vor_status vor_write_options_from(struct vor_write_options *out,
                                                const struct vor_format *format,
                                                const struct vor_spec *spec,
                                                const struct vor_result_facts *facts,
                                                struct vor_error *err);

/** Refuses before the work what vor_write_options_from would surely refuse after it.
 *
 *  @retval VOR_E_ORIGIN as vor_origin_check */
VOR_NODISCARD vor_status vor_write_check(const struct vor_format *format,
                                         const struct vor_spec *spec,
                                         const struct vor_extent *input, struct vor_error *err);

/** Adds to a report what a file of that format leaves out of a cloud and its mesh, which may be
 *  NULL or empty. */
void vor_codec_report_dropped(struct vor_report *report, const struct vor_cloud *cloud,
                              const struct vor_mesh *mesh, const struct vor_format *format);

#endif
