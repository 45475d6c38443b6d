/** Where work with strangers' bytes is done: in a child that can do nothing else, one for each
 * piece of work, or, where there is no zygote (tests of rooms above it), on the calling thread. */
#ifndef VOR_SERVER_WORK_CODEC_RUN_H
#define VOR_SERVER_WORK_CODEC_RUN_H

#include "server/proc/sandbox.h"
#include "server/proc/zygote.h"
#include "server/work/codec_work.h"

/** Where, and for whom: a plain value, copied for each who asks. All zero: on the calling thread,
 * for somebody who stays. */
struct vor_codec_place {
    struct vor_zygote *zygote; /**< borrowed; NULL for none */
    unsigned kind;             /**< the number of vor_codec_child among the zygote's kinds */
    enum vor_sandbox_kind sandbox;
    double patience;            /**< a factor of the wall clock, for tests; 0 stands for 1 */
    int (*has_left)(void *ctx); /**< asked some 20 times a second, on the calling thread; the work
                                   then ends. NULL: nobody leaves */
    void *ctx;
};

/** Does one piece of work.
 *
 *  @param[in]  input   order->size bytes, from its first on; read only
 *  @param[in]  sink    as vor_codec_do, on the calling thread
 *  @param[out] facts   as vor_codec_do; their ranges are checked, and that the format takes them
 *
 *  @retval as vor_codec_do, with the same words and offsets; and where a child did not live to say
 * so:
 *  @retval VOR_E_FORMAT     it crashed, did what it may not, or took too long: it is the input's
 *                           fault, if that is a stranger's
 *  @retval VOR_E_INTERNAL   the same, where it is our own
 *  @retval VOR_E_NOMEM      the machine had no memory for it
 *  @retval VOR_E_CANCELLED  the caller has left
 *  @retval VOR_E_IO         the sink took no more, the input cannot be mapped, or there is no child
 *
 *  Thread-safe. Takes at most 10 s of CPU and a second more for each 4 MiB; not for HTTP threads.
 */
VOR_NODISCARD vor_status vor_codec_run(struct vor_codec_facts *facts,
                                       const struct vor_codec_place *place,
                                       const struct vor_codec_order *order, int input,
                                       const struct vor_sink *sink, struct vor_error *err);

#endif
