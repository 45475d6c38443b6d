/** A run of one order on a pool of this process: reads the inputs, runs the engine, writes the
 *  outputs. */
#ifndef VOR_SERVER_WORK_EXECUTE_H
#define VOR_SERVER_WORK_EXECUTE_H

#include "server/work/codec_run.h"
#include "server/work/run_executor.h"

/** What a run works with. */
struct vor_run_means {
    struct vor_pool *pool;        /**< borrowed */
    struct vor_codec_place codec; /**< where its clouds are encoded; who has left is the run's */
};

/** Runs an order.
 *
 *  @param[out] result  unless it fails
 *  @param[out] kept    initialised; gets the output that is kept in the row
 *
 *  @retval VOR_E_CANCELLED  the listener answered VOR_CANCEL
 *  @retval VOR_E_INTERNAL   an input is not what was written
 *  @retval VOR_E_IO         the disk refuses (vor_error_storage_full tells a full one apart)
 *  @retval others           as vor_engine_run and vor_artefact_write */
VOR_NODISCARD vor_status vor_execute(struct vor_run_result *result, struct vor_text *kept,
                                     const struct vor_order *order,
                                     const struct vor_run_means *means,
                                     const struct vor_listener *listener, struct vor_error *err);

#endif
