/** Decodes and checks what clients upload, once, before a job exists. No other file of the daemon
 *  decodes. */
#ifndef VOR_SERVER_WORK_ADMIT_H
#define VOR_SERVER_WORK_ADMIT_H

#include "proto/limits.h"
#include "server/blob/blob.h"
#include "server/jobs/job.h"
#include "server/work/crew.h"

#include <stddef.h>

/** What decoding may cost. */
struct vor_admit_limits {
    struct vor_limits codec;
    size_t memory; /**< bytes */
};

/** Decodes and checks the bytes of an upload and keeps the cloud as blob (id, INPUT), durably.
 *
 *  @param[out] id      a fresh identifier: that of the job to be
 *  @param[out] input   what was found
 *  @param[in]  upload  borrowed
 *
 *  @retval VOR_E_EMPTY  no bytes, or no points
 *  @retval VOR_E_IO     the disk refuses (vor_error_storage_full tells a full one apart)
 *  @retval others       as vor_codec_read; then there is no blob
 *
 *  Cost: that of decoding and of writing 12 bytes a point and the attributes, with fsync. */
VOR_NODISCARD vor_status vor_admit_file(struct vor_uuid *id, struct vor_job_input *input,
                                        struct vor_blobs *blobs, struct vor_blob_writer *upload,
                                        const struct vor_admit_limits *limits,
                                        struct vor_error *err);

/** A pool of threads that admit uploads, so that HTTP threads do not wait. */
struct vor_admit;

/** One upload on its way. The caller fills in upload, done and ctx and keeps the struct until done
 *  was called. */
struct vor_admission {
    struct vor_blob_writer *upload;                /**< taken over, discarded before done */
    void (*done)(struct vor_admission *admission); /**< on an admission thread; may block, e.g. on
                                                        vor_worker_submit */
    void *ctx;
    vor_status status; /**< from here: the answer */
    struct vor_error error;
    struct vor_uuid id;
    struct vor_job_input input;
    struct vor_admit *admit; /**< from here: the admission's own */
    struct vor_task task;
};

/** Starts `threads` (at least 1) threads; at most `waiting_max` uploads wait for one.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_admit_create(struct vor_admit **out, struct vor_blobs *blobs,
                                          const struct vor_admit_limits *limits, unsigned threads,
                                          size_t waiting_max, struct vor_error *err);

/** Answers what waits with VOR_E_CANCELLED, finishes what is being decoded, ends the threads. admit
 *  may be NULL. */
void vor_admit_destroy(struct vor_admit *admit);

/** Hands an upload over.
 *
 *  @retval VOR_DONE      done will be called, exactly once
 *  @retval VOR_FULL, VOR_DRAINING  nothing was taken over */
VOR_NODISCARD enum vor_job_outcome vor_admit_submit(struct vor_admit *admit,
                                                    struct vor_admission *admission);

#endif
