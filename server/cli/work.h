/** What the commands that work here share: a cloud off a file, and where a run gets its threads and
 *  memory from. */
#ifndef VOR_CLI_WORK_H
#define VOR_CLI_WORK_H

#include "core/engine.h"
#include "proto/codec.h"
#include "proto/limits.h"
#include "server/cli/options.h"
#include "server/cli/progress.h"

struct vor_work {
    struct vor_memory memory; /**< without a cap: it is the caller's own machine */
    struct vor_watch watch;   /**< cancels on a signal, shows progress, knows the time */
    struct vor_run run;
    struct vor_limits limits;
};

/** Starts the threads. progress may be NULL. End with vor_work_end, also after a failure.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_work_start(struct vor_work *work, const struct vor_cli *cli,
                                        struct vor_progress *progress, struct vor_error *err);
void vor_work_end(struct vor_work *work);

/** Reads and checks a cloud, of any size. cloud is initialised here; *format may be NULL.
 *
 *  @retval as vor_input_read and vor_codec_read */
VOR_NODISCARD vor_status vor_work_load(struct vor_work *work, struct vor_cloud *cloud,
                                       const struct vor_format **format, const char *path,
                                       struct vor_error *err);

#endif
