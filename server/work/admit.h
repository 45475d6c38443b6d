/** Decodes and checks what clients upload, once, before a job exists; where, codec_run.h says. */
#ifndef VOR_SERVER_WORK_ADMIT_H
#define VOR_SERVER_WORK_ADMIT_H

#include "core/cloud/extent.h"
#include "proto/limits.h"
#include "server/blob/blob.h"
#include "server/jobs/job.h"
#include "server/work/codec_run.h"
#include "server/work/thread_pool.h"
#include "server/work/upload.h"

#include <stddef.h>

/** What decoding may cost, where it is done, and for whom. */
struct vor_admit_limits {
    struct vor_codec_place place;
    struct vor_limits codec;
    size_t memory;     /**< bytes */
    uint64_t inflated; /**< bytes that may come of all gzip uploads of a request */
    uint64_t keep;     /**< uploads of at most so many bytes are kept as they came; 0: none is */
};

/** The inputs of a job to be: their bytes are kept, but no row needs them yet. A plain value, all
 *  zero before the first input. */
struct vor_admitted {
    struct vor_uuid id; /**< of the job to be; "" before the first input */
    unsigned count;
    struct vor_admitted_input {
        const char *name; /**< borrowed */
        struct vor_job_input found;
        struct vor_extent extent;
        int is_kept;      /**< the upload has a blob as well */
        uint64_t decoded; /**< bytes of the input's own blob */
    } item[VOR_INPUTS_MAX];
};

/** Decodes and checks the bytes of an upload and keeps the cloud, durably, as blob of an input.
 *
 *  @param[in,out] admitted  gets one input more, and with the first one a fresh identifier;
 *                           unchanged on failure
 *  @param[in]     name      of the input, out of the process's row; there is none of it yet, and
 *                           room for one more. Must outlive *admitted
 *  @param[in]     upload    borrowed
 *
 *  @retval VOR_E_EMPTY  no bytes, or no points
 *  @retval VOR_E_IO     the disk refuses (vor_error_storage_full tells a full one apart)
 *  @retval others       as vor_codec_run; then this input has no blob
 *
 *  Cost: that of decoding and of writing 12 bytes a point and the attributes, with fsync. */
VOR_NODISCARD vor_status vor_admit_file(struct vor_admitted *admitted, const char *name,
                                        struct vor_blobs *blobs, struct vor_blob_writer *upload,
                                        const struct vor_admit_limits *limits,
                                        struct vor_error *err);

/** Keeps the upload that the input added last came from, if the limits allow. Else, and when the
 *  disk refuses, which is logged, the job does without. upload is gone either way; it may be NULL,
 *  and then nothing is kept. The job does not need it, so nobody waits until it is durable: after a
 *  crash of the machine it may be damaged, which is found when it is read. */
void vor_admit_keep(struct vor_admitted *admitted, struct vor_blob_writer *upload,
                    const struct vor_admit_limits *limits);

/** Removes a file that no job needs. A failure is logged; the next start removes it. */
void vor_drop_file(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name);

/** Removes the bytes of inputs that will be no job's. A failure is logged; the next start removes
 *  them. */
void vor_admit_drop(struct vor_blobs *blobs, const struct vor_admitted *admitted);

/** A pool of threads that inflate and admit uploads, so that HTTP threads do not wait. */
struct vor_admit;

/** The uploads of a request on their way. Who submits it fills in uploads (at least one), caller,
 * spec, done, has_left and ctx and keeps the struct until done was called. */
struct vor_admission {
    struct vor_uploads uploads;                    /**< taken over, none left before done */
    struct vor_fairness_key caller;                /**< who shares the threads with others */
    const struct vor_spec *spec;                   /**< kept until done is called */
    void (*done)(struct vor_admission *admission); /**< on an admission thread; may block, e.g. on
                                                        vor_job_service_submit */
    int (*has_left)(void *ctx); /**< true once nobody waits for it any more, on such a thread: then
                                     the answer is VOR_E_CANCELLED; NULL: somebody stays */
    void *ctx;
    vor_status status;            /**< from here: the answer */
    struct vor_error error;       /**< names the input at fault if there are several */
    struct vor_admitted admitted; /**< all inputs, when status is VOR_OK; else none */
    struct vor_admit *admit;      /**< from here: the admission's own */
    struct vor_task task;
};

/** Starts `threads` (at least 1) threads; at most `waiting_max` uploads wait for one. Of two and
 * more threads one is left to other callers, whatever one caller sends, and a quarter of those that
 * wait are one caller's at most.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_admit_create(struct vor_admit **out, struct vor_blobs *blobs,
                                          const struct vor_admit_limits *limits, unsigned threads,
                                          size_t waiting_max, struct vor_error *err);

/** Answers what waits with VOR_E_CANCELLED, finishes what is being decoded, ends the threads. admit
 *  may be NULL. */
void vor_admit_destroy(struct vor_admit *admit);

/** The threads that decode, for conversions. */
struct vor_thread_pool *vor_admit_thread_pool(struct vor_admit *admit);

/** Hands an upload over.
 *
 *  @retval VOR_DONE      done will be called, exactly once
 *  @retval VOR_FULL, VOR_DRAINING  nothing was taken over
 *  @retval VOR_FAILED    likewise: there is no thread for it, as admission->error says */
VOR_NODISCARD enum vor_job_outcome vor_admit_submit(struct vor_admit *admit,
                                                    struct vor_admission *admission);

#endif
