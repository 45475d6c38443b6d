/** The one door to the engine: a function of (cloud, request, seed). No files, sockets, logs or
 *  globals behind it, nor a clock of its own. */
#ifndef VOR_ENGINE_H
#define VOR_ENGINE_H

#include "core/process.h"
#include "core/report.h"

/** Runs the process of the request.
 *
 *  @param[out] out   initialised, empty; receives every output of the process's row when VOR_OK is
 *                    returned; the caller frees it in any case
 *  @param[in]  in    every required input of the row, clouds checked (vor_cloud_check); borrowed
 *                    for the call
 *  @param[in]  spec  checked (vor_spec_check, vor_spec_check_inputs)
 *  @param[in]  run   pool, memory, watch, saved and every are read; the run begins with this call
 *  @param[out] err   may be NULL
 *
 *  @retval VOR_E_TARGET     the number of points, given or from ratio or spacing, is out of range
 *                           (vor_spec_check_target)
 *  @retval VOR_E_PARAM      the attribute track of the earlier result has unusable values
 *  @retval VOR_E_NORMALS    inputNormals is use, and the cloud has none, or some that are zero or
 *                           not finite
 *  @retval VOR_E_FACES      sample is faces, and the cloud has none with an area
 *  @retval VOR_E_SPLATS     the cloud is a 3D Gaussian splat (vor_splats_check)
 *  @retval VOR_E_DEGENERATE the cloud has no surface: fewer than four distinct points, or all on a
 *                           line; `measure`: as vor_measure_clouds
 *  @retval VOR_E_NOMEM      the job does not fit under its cap
 *  @retval VOR_E_CANCELLED  the watch answered VOR_CANCEL
 *
 *  A run leaves the report's seconds of reading and writing and its origin 0; the caller sets them.
 *
 *  Departure (the processes that spread points): an input of ten times as many points as asked for,
 *  and of 40,000, is thinned for all but the last iterations or steps (input/thin.h).
 *  Departure: if the input's coordinates were rounded to cells that are not small against its
 *  spacing, its points are first moved within them (input/lattice.h).
 *
 *  Departure: small parts of the input, clear of all others, get at most their own points, in their
 *  places (input/islands.h).
 *
 *  With sample=faces the input is points drawn from its faces (core/cloud/faces.h), which take 12
 *  bytes each and their attributes besides.
 *
 *  With an earlier result, seeds start where its points were (seeds/warm_start.h); it takes 53
 * bytes a point while they do.
 *
 *  Memory: at most 54 bytes for each input point (position, order, index), 67 with noise, 94 more
 * where lists of neighbours on one sheet are made (input/lists.h) and 28 while they are, 192 more
 * where that is of at most 2,048, for meshes 450 (at worst 780, input/regions.h). For each point of
 * the result 6 k + 393 bytes (surface, lists, index; k neighbors), twice that while the start is
 * drawn from cells, which is the case unless the input has ten times as many points; then 6 k + 502
 * while iterating. Baselines take as many again, one after another, once the result is made
 * (baselines/baselines.h). After the polish a progressive order takes 34 instead, and a copy of the
 * widest column. With a metric each takes 56 more, and 4 for each further neighbour listed (53 at
 * an aspect of 6). Where an energy is minimised (cvt/descend.h) each takes 1,060 more while
 * iterating. wlop and ear take 6 k + 542, or up to 570 and 680 for each point of the input where
 * that is more. 200 KiB a thread. After the first iteration a run allocates only that order, and
 * the points' index when it is made anew.
 *
 *  Cost: O(N log N) for the index, O(n) an iteration, O(n log n) a progressive order; on the run's
 *  pool. Thread-safe. The same bytes for any number of threads, unless a time budget or the caller
 *  ended the run; and whether it goes on from a checkpoint or not (seeds/checkpoint.h). */
VOR_NODISCARD vor_status vor_engine_run(struct vor_artefacts *out, const struct vor_artefacts *in,
                                        const struct vor_spec *spec, const struct vor_run *run,
                                        struct vor_error *err);

#endif
