/** Whether the engine works on this machine: a tiny run whose answer is known. A library that does
 *  not fit, or a processor that cannot do what the binary was built for, shows at the start and not
 *  in somebody's job. */
#ifndef VOR_SERVER_WORK_SELF_TEST_H
#define VOR_SERVER_WORK_SELF_TEST_H

#include "core/base/parallel.h"
#include "core/cloud/cloud.h"

/** Points of the run: of the sphere, and of the result. */
enum { VOR_SELF_TEST_INPUT = 600, VOR_SELF_TEST_POINTS = 150 };

/** Resamples points of the unit sphere, and judges the result.
 *
 *  @param[in] memory  of the run, 1 MB at four threads
 *
 *  @retval VOR_E_INTERNAL the result is wrong; the message says what of it
 *  @retval others         as vor_engine_run
 *
 *  Cost: some 20 ms of one core, on the pool. */
VOR_NODISCARD vor_status vor_self_test(struct vor_pool *pool, struct vor_memory *memory,
                                       struct vor_error *err);

/** Judges the result of such a run: the number of its points, how far they are from the sphere, and
 *  how even.
 *
 *  @param[in] made   relative to its own origin
 *  @param[in] delta  uniformity, as the run reports it
 *
 *  @retval VOR_E_INTERNAL as above */
VOR_NODISCARD vor_status vor_self_test_judge(const struct vor_cloud *made, double delta,
                                             struct vor_error *err);

#endif
