/** The artefacts of a run, out of and into the blobs of its job. */
#ifndef VOR_SERVER_WORK_ARTEFACTS_H
#define VOR_SERVER_WORK_ARTEFACTS_H

#include "core/process.h"
#include "proto/codec.h"
#include "server/blob/blob.h"
#include "server/store/row.h"

/** Reads every input of a job, as the admission kept it, into a set under its name.
 *
 *  @param[in,out] in   initialised, empty; its clouds allocate from in->memory. To be freed, also
 *                      after a failure
 *  @param[in]     row  whose inputs; its process outlives *in
 *
 *  @retval VOR_E_INTERNAL an input is gone, or is not what was written
 *  @retval VOR_E_NOMEM, VOR_E_IO */
VOR_NODISCARD vor_status vor_artefacts_load(struct vor_artefacts *in, struct vor_blobs *blobs,
                                            const struct vor_job_view *row, struct vor_error *err);

/** Makes an output of a job durable under its name: a cloud, with its faces, in the format that the
 * request asks for, else that of the job's main input; a document as JSON.
 *
 *  @param[out] out      what was written; only when VOR_OK is returned
 *
 *  @retval VOR_E_ORIGIN   as vor_write_options_from
 *  @retval VOR_E_IO       the disk refuses (vor_error_storage_full tells a full one apart)
 *  @retval VOR_E_NOMEM, VOR_E_INTERNAL  as vor_format.write
 *
 *  Cost: that of encoding, and an fsync. */
VOR_NODISCARD vor_status vor_artefact_save(struct vor_job_output *out, struct vor_blobs *blobs,
                                           const struct vor_job_view *row,
                                           const struct vor_artefact *artefact,
                                           const struct vor_result_facts *facts,
                                           struct vor_error *err);

#endif
