/** The artefacts of a run, out of and into the files of its job. */
#ifndef VOR_SERVER_WORK_ARTEFACTS_H
#define VOR_SERVER_WORK_ARTEFACTS_H

#include "core/process.h"
#include "proto/codec.h"
#include "server/work/codec_run.h"
#include "server/work/run_executor.h"

/** Reads every input of a process, as the admission kept it, into a set under its name.
 *
 *  @param[in,out] in     initialised, empty; its clouds allocate from in->memory. To be freed, also
 *                        after a failure
 *  @param[in]     input  as in struct vor_order; the process outlives *in
 *
 *  @retval VOR_E_INTERNAL an input is not what was written
 *  @retval VOR_E_NOMEM, VOR_E_IO */
VOR_NODISCARD vor_status vor_artefacts_load(struct vor_artefacts *in,
                                            const struct vor_process_info *process,
                                            const int input[VOR_INPUTS_MAX], struct vor_error *err);

/** What outputs are written with. */
struct vor_writing {
    const struct vor_order *order;
    const struct vor_result_facts *facts;
    const struct vor_codec_place *place; /**< where clouds are encoded */
};

/** Writes an output to the file that its order has for it: a cloud, with its faces, in the format
 *  that the request asks for, else in that of the main input; a document as JSON. Whoever gave the
 *  file makes it durable.
 *
 *  @param[out] out    what was written; only when VOR_OK is returned
 *  @param[in]  index  of the output
 *
 *  @retval VOR_E_ORIGIN   as vor_write_options_from
 *  @retval VOR_E_IO       the disk refuses (vor_error_storage_full tells a full one apart)
 *  @retval VOR_E_NOMEM, VOR_E_INTERNAL, VOR_E_CANCELLED  as vor_encode */
VOR_NODISCARD vor_status vor_artefact_write(struct vor_job_output *out,
                                            const struct vor_writing *writing, unsigned index,
                                            const struct vor_artefact *artefact,
                                            struct vor_error *err);

/** Writes the cloud of a result in a format: on the calling thread, or in a codec child where its
 *  attributes, which are a stranger's, may crash the writer (vor_format.is_fragile). The bytes are
 *  the same wherever that is done.
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
