/** Clouds that jobs left, in another format than the job's: each is made once, when it is first
 *  asked for, and kept beside the job's own results for as long as those. */
#ifndef VOR_SERVER_WORK_CONVERSION_H
#define VOR_SERVER_WORK_CONVERSION_H

#include "proto/origin.h"
#include "server/work/codec_run.h"
#include "server/work/worker.h"

#include <stddef.h>

/** Makes conversions. Thread-safe. */
struct vor_conversions;

/** One that is on its way. */
struct vor_conversion;

struct vor_conversions_config {
    struct vor_store *store; /**< borrowed, as the next three */
    struct vor_blobs *blobs;
    struct vor_worker *worker;
    struct vor_crew *crew;        /**< that decodes */
    struct vor_codec_place place; /**< where that is done */
    size_t memory;                /**< bytes that one may have */
};

/** @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_conversions_create(struct vor_conversions **out,
                                                const struct vor_conversions_config *config,
                                                struct vor_error *err);

/** The crew has ended, and everyone who waited has left. conversions may be NULL. */
void vor_conversions_destroy(struct vor_conversions *conversions);

/** Somebody who waits for a conversion. He fills in the first three members and keeps the struct
 *  until he leaves. */
struct vor_conversion_waiter {
    void (*wake)(void *ctx); /**< once it is over, on a thread of the crew; must not call back */
    void *ctx;
    struct vor_fairness_key caller;     /**< whom a conversion that he begins is for */
    struct vor_conversion_waiter *next; /**< from here: the conversion's own */
};

/** Begins a conversion, or joins the one of the same job, output and format that is on its way.
 *
 *  @param[in]  row     of a successful job
 *  @param[in]  output  index of one of its clouds
 *  @param[in]  format  index of vor_format, not that of the output
 *  @param[out] out     to be left with vor_conversion_leave
 *
 *  @retval VOR_DONE
 *  @retval VOR_FULL, VOR_DRAINING  as vor_crew_take
 *  @retval VOR_FAILED  VOR_E_NOMEM, or VOR_E_IO: there is no thread for it
 *
 *  The cloud is read and written, with its faces, with the request's own parameters; cells of Draco
 * follow the spacing that the report tells, and an origin that we choose follows from the result,
 * as its input may be gone. Costs the disk as much as the file has. */
VOR_NODISCARD enum vor_job_outcome
vor_conversion_begin(struct vor_conversion **out, struct vor_conversions *conversions,
                     const struct vor_job_view *row, unsigned output, unsigned format,
                     struct vor_conversion_waiter *waiter, struct vor_error *err);

/** True once it is over; *status and *err then say how: VOR_OK (the blob is durable, if the job is
 *  still there), VOR_E_CANCELLED (the daemon goes down), VOR_E_IO, VOR_E_NOMEM, VOR_E_ORIGIN (as
 *  vor_origin_resolve), VOR_E_INTERNAL. */
int vor_conversion_over(struct vor_conversion *conversion, vor_status *status,
                        struct vor_error *err);

/** Ends waiting. The conversion goes on if it is not over. */
void vor_conversion_leave(struct vor_conversion *conversion, struct vor_conversion_waiter *waiter);

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
