/** Writes the cloud of a result in a format: on the calling thread, or in a codec child where its
 * attributes, which are a stranger's, may crash the writer (vor_format.is_fragile). */
#ifndef VOR_SERVER_WORK_ENCODE_H
#define VOR_SERVER_WORK_ENCODE_H

#include "server/work/codec_run.h"

/** Writes it; the bytes are the same wherever that is done.
 *
 *  @param[in] place    as vor_codec_run
 *  @param[in] format   index of vor_format
 *  @param[in] options  their mesh too
 *
 *  A child has a copy of the cloud, which goes through a file in memory: both, and what the encoder
 *  takes, are charged to cloud->memory, as if it were done here.
 *
 *  @retval VOR_E_INTERNAL   the library failed; or the child crashed or took too long
 *  @retval VOR_E_NOMEM      it does not fit
 *  @retval VOR_E_CANCELLED  place->has_left said so
 *  @retval VOR_E_IO         the sink refused, or there is no child */
VOR_NODISCARD vor_status vor_encode(const struct vor_sink *sink,
                                    const struct vor_codec_place *place,
                                    const struct vor_cloud *cloud, unsigned format,
                                    const struct vor_write_options *options, struct vor_error *err);

#endif
