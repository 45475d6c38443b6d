/** Clouds that jobs left, in another format than the job's: each is made once, when it is first
 *  asked for, and kept beside the job's own results for as long as those. */
#ifndef VOR_SERVER_WORK_CONVERSION_H
#define VOR_SERVER_WORK_CONVERSION_H

#include "proto/origin.h"
#include "server/work/codec_run.h"
#include "server/work/job_service.h"
#include "server/work/thread_pool.h"

#include <stddef.h>

/** Makes conversions. Thread-safe. */
struct vor_conversions;

struct vor_conversions_config {
    struct vor_store *store; /**< borrowed, as the next three */
    struct vor_blobs *blobs;
    struct vor_job_service *service;
    struct vor_thread_pool *pool; /**< that decodes */
    struct vor_codec_place place; /**< where that is done */
    size_t memory;                /**< bytes that one may have */
};

/** @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_conversions_create(struct vor_conversions **out,
                                                const struct vor_conversions_config *config,
                                                struct vor_error *err);

/** The pool has ended. conversions may be NULL. */
void vor_conversions_destroy(struct vor_conversions *conversions);

/** Begins a conversion, or joins the one of the same job, output and format that is on its way.
 *
 *  @param[in] row     of a successful job
 *  @param[in] output  index of one of its clouds
 *  @param[in] format  index of vor_format, not that of the output
 *
 *  @retval VOR_DONE  asker->wake will be called: then look for it (vor_converted_open), and if it
 *                    is not there, ask again
 *  @retval VOR_FULL, VOR_DRAINING  as vor_thread_pool_submit
 *  @retval VOR_FAILED  as err says: it could not be begun (VOR_E_NOMEM; VOR_E_IO: there is no
 *                      thread for it), or has failed in the last seconds: VOR_E_IO, VOR_E_NOMEM,
 *                      VOR_E_ORIGIN (as vor_origin_resolve), VOR_E_INTERNAL, VOR_E_CANCELLED (the
 *                      daemon goes down)
 *
 *  The cloud is read and written, with its faces, with the request's own parameters; cells of Draco
 * follow the spacing that the report tells, and an origin that we choose follows from the result,
 * as its input may be gone. It is durable once it is there, and is made even if nobody waits for it
 * any more. Costs the disk as much as the file has. */
VOR_NODISCARD enum vor_job_outcome vor_convert(struct vor_conversions *conversions,
                                               const struct vor_job_view *row, unsigned output,
                                               unsigned format, const struct vor_asker *asker,
                                               struct vor_error *err);

/** A converted cloud as it is kept. */
struct vor_converted {
    int fd; /**< to be closed; -1 for none */
    uint64_t size;
    char sha256[VOR_DIGEST_SIZE];
    char origin[VOR_ORIGIN_TEXT_SIZE]; /**< that its positions count from; "" in a format that
                                            takes none */
};

/** Opens what a conversion has made.
 *
 *  @param[out] out  fd is -1 if it was not made yet
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_converted_open(struct vor_converted *out, struct vor_blobs *blobs,
                                            const struct vor_uuid *id, const char *output,
                                            unsigned format, struct vor_error *err);

#endif
