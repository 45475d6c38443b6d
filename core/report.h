/** What a run tells: its stages, the progress record, the report, the measure. Each is one table,
 *  which makes the C struct and the description that JSON, CSV, traces and openapi.yaml's test read
 *  (core/base/members.h).
 *
 *  Symbols: delta is Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds",
 *  Eq. 6; sigma and epsilon Sec. V-B; energy Eq. 2. */
#ifndef VOR_REPORT_H
#define VOR_REPORT_H

#include "core/base/members.h"
#include "core/cloud/cloud.h"
#include "core/report/parts.h"
#include "core/spec.h"

#include <stdint.h>

/** Stages that a run may go through: identifier, name, what one of its steps is called, sentence.
 *  Traces keep the number of a row, so rows are only ever added, at the end. */
#define VOR_RUN_STAGE_TABLE(X)                                                                     \
    X(ITERATE, "iterate", "iteration",                                                             \
      "Moves each point towards the centroid of its cell or, with method=isotropic, remeshes "     \
      "the points")                                                                                \
    X(POLISH, "polish", "polish step", "Moves points away from their neighbours")                  \
    X(BASELINES, "baselines", "baseline", "Runs simple methods for comparison")                    \
    X(PROJECT, "project", "projection step",                                                       \
      "Pulls each point towards nearby input points and away from its neighbours")                 \
    X(INSERT, "insert", "inserted point", "Inserts points in the largest gaps")                    \
    X(ALIGN, "align", "alignment step", "Refines the poses that a cloud may have")

enum vor_run_stage {
#define VOR_RUN_STAGE_ENUM(id, name, step, sentence) VOR_RUN_STAGE_##id,
    VOR_RUN_STAGE_TABLE(VOR_RUN_STAGE_ENUM)
#undef VOR_RUN_STAGE_ENUM
        VOR_RUN_STAGE_COUNT
};

/** One row of the table. */
struct vor_run_stage_info {
    const char *name, *step, *sentence;
};

/** The row of a stage. A number that is no stage, as a record of another build may have, gets a row
 *  that only says "step". */
const struct vor_run_stage_info *vor_run_stage_info(enum vor_run_stage stage);

/** The stage of that name; VOR_RUN_STAGE_COUNT when there is none. */
enum vor_run_stage vor_run_stage_find(const char *name);

#define VOR_FIELD_RUN_STAGE(field) enum vor_run_stage field;

/** What is known after a step of a run, for SSE, NDJSON, traces and the metrics of a job. The first
 *  is of 0 steps. Members are only ever added, at the end: traces keep them in this order. */
#define VOR_RECORD_TABLE(X)                                                                        \
    X(U32, iteration, "iteration", "",                                                             \
      "Number of iterations, projection steps or alignment steps so far (0 in the first record)")  \
    X(U32, polish, "polish", "",                                                                   \
      "Number of steps so far of the polish, the optimisation that follows the iterations (0 "     \
      "during the iterations)")                                                                    \
    X(REAL, delta, "delta", "",                                                                    \
      "Standard deviation of the distances from points to their nearest neighbours, divided by "   \
      "the mean of these distances; lower is more even")                                           \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "Mean absolute deviation: how far the distances to the nearest neighbour differ from "       \
      "their mean, on average")                                                                    \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "Mean distance to the nearest neighbour, divided by the root mean square of these "          \
      "distances: 0 to 1, higher is more even")                                                    \
    X(REAL, energy, "energy", "unit of the cloud^4",                                               \
      "Energy of the Voronoi tessellation. During the polish, it is not updated: it keeps its "    \
      "value from the last iteration")                                                             \
    X(REAL, max_move, "max_move", "unit of the cloud",                                             \
      "Longest distance that a point moved in this step")                                          \
    X(U64, held, "held", "points",                                                                 \
      "Number of points that were prevented from moving beyond the border of the input")           \
    X(REAL, seconds, "seconds", "s", "Time since the run began")                                   \
    X(RUN_STAGE, stage, "run_stage", "", "Stage of the run")                                       \
    X(U32, step, "step", "", "Number of steps of the stage so far")                                \
    X(U32, of, "of", "",                                                                           \
      "Largest number of steps that the stage may have (0 if the number is not known)")            \
    X(U32, ahead, "ahead", "", "Largest possible total number of steps in all later stages")       \
    X(U32, best_iteration, "best.iteration", "",                                                   \
      "Number of the iteration that gave the most even result so far; if the run ends now, it "    \
      "returns the result of this iteration")                                                      \
    X(U32, best_polish, "best.polish", "",                                                         \
      "Index of the polish step that gave the most even result so far")                            \
    X(REAL, best_delta, "best.delta", "",                                                          \
      "delta of the most even result so far; in the last record, the same as delta in the report") \
    X(REAL, best_sigma, "best.sigma", "unit of the cloud", "sigma of the most even result so far") \
    X(REAL, best_epsilon, "best.epsilon", "", "epsilon of the most even result so far")            \
    VOR_RECORD_LV2022_TABLE(X)

struct vor_record {
    VOR_RECORD_TABLE(VOR_FIELD)
};

extern const struct vor_members vor_record_members;

/** Sets the members best of a record that was written before records had them: what would have
 * been handed back was not written, its delta, sigma and epsilon become NAN. */
void vor_record_unknown_best(struct vor_record *record);

/** Why a run ended: identifier, word in the report. */
#define VOR_STOPPED_TABLE(X)                                                                       \
    X(ITERATIONS, "iterations")                                                                    \
    X(DELTA, "delta")                                                                              \
    X(SECONDS, "seconds")                                                                          \
    X(PLATEAU, "plateau")                                                                          \
    X(CALLER, "stopped")                                                                           \
    X(MOVE, "moveStop")                                                                            \
    X(ETA, "eta")

enum vor_stopped {
#define VOR_STOPPED_ENUM(id, word) VOR_STOPPED_##id,
    VOR_STOPPED_TABLE(VOR_STOPPED_ENUM)
#undef VOR_STOPPED_ENUM
        VOR_STOPPED_COUNT
};

#define VOR_FIELD_STOPPED(field) enum vor_stopped field;

/** A stage that a run went through. */
#define VOR_STAGE_DONE_TABLE(X)                                                                    \
    X(RUN_STAGE, stage, "stage", "", "Name of the stage")                                          \
    X(U32, steps, "steps", "", "Number of steps")                                                  \
    X(REAL, seconds, "seconds", "s", "Time of the stage")

struct vor_stage_done {
    VOR_STAGE_DONE_TABLE(VOR_FIELD)
};

#define VOR_FIELD_STAGES(field)                                                                    \
    struct vor_stage_done field[VOR_RUN_STAGE_COUNT];                                              \
    unsigned field##_count;

#define VOR_FIELD_SPEC(field) struct vor_spec field;

/** What a run did. Lengths are in the unit of the cloud. The engine sets all but the seconds of
 *  reading and writing and the origin, which the caller sets. */
#define VOR_REPORT_TABLE(X)                                                                        \
    X(U64, points_in, "points.in", "points",                                                       \
      "Number of points of the input, or of its vertices if the input is a mesh")                  \
    X(U64, points_out, "points.out", "points", "Points of the result")                             \
    X(REAL, delta, "delta", "",                                                                    \
      "Standard deviation of the distances from points of the result to their nearest "            \
      "neighbours, divided by the mean of these distances; lower is more even. With a density, "   \
      "each distance is first divided by the target spacing at its point; with a metric, "         \
      "distances are measured in the metric. sigma, epsilon and the records in events and "        \
      "traces are computed in the same way")                                                       \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "Mean absolute deviation: how far the distances to the nearest neighbour differ from "       \
      "their mean, on average")                                                                    \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "Mean distance to the nearest neighbour, divided by the root mean square of these "          \
      "distances: 0 to 1, higher is more even")                                                    \
    X(U32, iterations, "iterations", "", "Number of iterations or projection steps")               \
    X(U32, polish_steps, "polish_steps", "", "Number of polish steps")                             \
    X(STOPPED, stopped, "stopped", "", "Why the run ended")                                        \
    X(WARNINGS, warnings, "warnings", "",                                                          \
      "Warnings about parameters that had no effect and about problems of the input. Most runs "   \
      "have no warnings")                                                                          \
    X(STAGES, stages, "stages", "",                                                                \
      "Stages of the run, in order. The report's `seconds` include the times of all stages "       \
      "except the stage `baselines`")                                                              \
    X(REAL, seconds_read, "seconds.read", "s", "Time to decode the input")                         \
    X(REAL, seconds_index, "seconds.index", "s", "Time to sort and index the input")               \
    X(REAL, seconds_init, "seconds.init", "s",                                                     \
      "Time to place the points at their initial positions")                                       \
    X(REAL, seconds_iterate, "seconds.iterate", "s",                                               \
      "Time of the iterations; with method=wlop or method=ear, time of the projection steps and "  \
      "insertions")                                                                                \
    X(REAL, seconds_polish, "seconds.polish", "s",                                                 \
      "Time of the polish, and of the last step, which moves points that lie outside the input "   \
      "onto its surface")                                                                          \
    X(REAL, seconds_write, "seconds.write", "s", "Time to encode the result")                      \
    X(U64, memory_peak_bytes, "memory_peak_bytes", "bytes", "Peak memory of the job")              \
    X(U64, invalid, "invalid", "points",                                                           \
      "Number of input points that were left out because a coordinate was not finite. points.in "  \
      "does not include them")                                                                     \
    X(U64, faces, "faces", "",                                                                     \
      "Number of faces that the file of the input declares; a triangle strip counts as one. "      \
      "With sample=faces, the points that are resampled are drawn from the faces of the input")    \
    X(U64, samples, "samples", "points",                                                           \
      "Number of points drawn from the faces of the input (0 unless sample=faces). With "          \
      "sample=faces, all figures for input points (except points.in) refer to the points that "    \
      "were drawn from the faces")                                                                 \
    X(DROPPED, dropped, "dropped", "",                                                             \
      "Contents of the input file that are missing from the result file: faces, other elements "   \
      "and lists of a PLY file, attributes that the request drops, and comments if the format "    \
      "of the result has no comments")                                                             \
    X(U64, outliers, "outliers", "points",                                                         \
      "Number of outliers among the input points; they were ignored or moved onto the surface")    \
    X(U64, parts, "components", "", "Number of separate parts of the input")                       \
    X(U64, islands, "islands.components", "",                                                      \
      "Number of islands: separate parts with fewer than 2 x `neighbors` points (those that a "    \
      "local surface is fitted to), and each outlier kept by method=ear or very far away")         \
    X(U64, in_islands, "islands.points_in", "points", "Number of input points on islands")         \
    X(U64, on_islands, "islands.points_out", "points",                                             \
      "Number of result points that lie on islands; each of them has the position of an input "    \
      "point (0 if the run only filtered the input)")                                              \
    X(REAL, delta_beside, "islands.delta_beside", "",                                              \
      "delta of the points that are not on islands, so that the gaps around islands do not "       \
      "count")                                                                                     \
    X(OPTIONAL, has_holes, "holes", "",                                                            \
      "Holes of the input; present only if the request fills holes. Points that are added to "     \
      "fill holes count as input points in all other numbers of the report")                       \
    X(U64, holes_loops, "holes.loops", "",                                                         \
      "Number of border loops of the input, closed lines where its surface ends")                  \
    X(U64, holes_filled, "holes.filled", "", "Number of loops that were filled")                   \
    X(U64, holes_not_closed, "holes.not_closed", "", "Number of loops that could not be closed")   \
    X(U64, holes_points, "holes.points", "points", "Number of points added in holes")              \
    X(HOLES, holes, "holes.each", "",                                                              \
      "Border loops of the input, at most 100: the loops that could not be closed, and the "       \
      "longest of the other loops")                                                                \
    X(OPTIONAL, has_density, "density", "",                                                        \
      "How well the result follows the requested density; present only if the request has a "      \
      "density")                                                                                   \
    X(REAL, density_span, "density.span", "",                                                      \
      "Ratio of the 95th to the 5th percentile of the density on the surface, after the "          \
      "parameters `contrast`, `grading` and `groups` were applied")                                \
    X(REAL, density_least, "density.spacing_min", "unit of the cloud", "Smallest target spacing")  \
    X(REAL, density_most, "density.spacing_max", "unit of the cloud", "Largest target spacing")    \
    X(OPTIONAL, has_metric, "metric", "",                                                          \
      "How well the result follows the requested metric; present only if the request has a "       \
      "metric")                                                                                    \
    X(REAL, metric_median, "metric.aspect_median", "",                                             \
      "Ratio of length to width that the metric prescribes for the cells (median over the "        \
      "surface)")                                                                                  \
    X(REAL, metric_high, "metric.aspect_p95", "",                                                  \
      "Ratio of length to width that cells should have according to the metric: 95th percentile "  \
      "over the surface")                                                                          \
    X(REAL, metric_cells, "metric.cells_median", "",                                               \
      "Median, over all cells of the result, of the ratio of a cell's length to its width. This "  \
      "ratio is computed for each cell as the square root of the ratio of its principal second "   \
      "moments")                                                                                   \
    X(REAL, metric_off, "metric.off_median", "",                                                   \
      "Median, over the cells, of the relative error of a cell's ratio of length to width: its "   \
      "difference from the prescribed ratio, divided by the prescribed ratio")                     \
    X(REAL, metric_off_high, "metric.off_p90", "",                                                 \
      "90th percentile, over the cells, of the relative error of a cell's ratio of length to "     \
      "width: its difference from the prescribed ratio, divided by the prescribed ratio")          \
    X(OPTIONAL, has_descent, "descent", "",                                                        \
      "How the energy was minimised; present only with metric=lp or cells=euclid")                 \
    X(U64, descent_steps, "descent.steps", "",                                                     \
      "Number of steps of the L-BFGS optimiser, at most five per iteration")                       \
    X(U64, descent_evaluations, "descent.evaluations", "", "Number of evaluations of the energy")  \
    X(REAL, descent_worst, "descent.worst", "",                                                    \
      "Energy after an iteration divided by the energy before it: the largest such ratio in the "  \
      "run; it is always below 1")                                                                 \
    X(REAL, descent_aspect, "descent.aspect", "",                                                  \
      "Median, over all cells, of the ratio of a cell's length to its width. This ratio is "       \
      "computed for each cell as the square root of the ratio of its principal second moments; "   \
      "squares and regular hexagons have the ratio 1")                                             \
    X(VECTOR, lattice, "lattice", "unit of the cloud",                                             \
      "Step of the grid that the input's coordinates were rounded to (0 if no grid was found)")    \
    X(U64, off_lattice, "lattice.moved", "points",                                                 \
      "Number of input points that were moved within their grid cell (0 if the grid cells are "    \
      "small compared with the distance between input points)")                                    \
    X(ORIENTED, orientation, "orientation", "",                                                    \
      "How the normals of the result were oriented. not-asked: they are copied from the input, "   \
      "or the result has none; carried: they are on the side of the input's normals; "             \
      "consistent: they face outward or upward, which voronoid decides from the points of the "    \
      "input; one-sided: like consistent, but parts of the input are one-sided surfaces, like a "  \
      "Moebius band")                                                                              \
    X(U64, one_sided, "one_sided", "",                                                             \
      "Number of one-sided connected parts of the input, like a Moebius band; their "              \
      "normals cannot be consistent (0 if the run did not have to orient normals)")                \
    X(APART, ref_to_out, "ref_to_out", "",                                                         \
      "Distances from points of the input to the nearest point of the result. Points at the "      \
      "same position count once; outliers that were ignored do not count. Points that were "       \
      "moved within their grid cell are measured from their new position. If there are more "      \
      "than 200000 points, only 200000 of them are measured, taken at equal steps along a "        \
      "space-filling curve; mean and rms are then estimates, and max is a lower bound")            \
    X(APART, out_to_ref, "out_to_ref", "",                                                         \
      "Distances from all points of the result to the nearest input point. The same input "        \
      "points are used as for ref_to_out: ignored outliers do not count, and points that were "    \
      "moved within their grid cell count at their new position")                                  \
    VOR_MLS_ERROR_TABLE(X)                                                                         \
    X(U64, boundary_points, "boundary_points", "points",                                           \
      "Number of points of the result that lie at borders of the input. 0 for a closed smooth "    \
      "surface; for a surface with borders, approximately the length of the borders divided by "   \
      "the spacing")                                                                               \
    X(FITTED, fitted, "neighbors_histogram", "",                                                   \
      "Histogram of the number of input points per local surface in the last step. Each entry "    \
      "says that, at `points` points of the result, the local surface was fitted to `neighbors` "  \
      "input points. Entries are sorted by `neighbors`. The numbers of points add up to "          \
      "points.out")                                                                                \
    X(U64, held, "held", "points",                                                                 \
      "Number of points that were prevented from moving beyond the border in the last iteration")  \
    X(U64, held_ever, "held_ever", "points",                                                       \
      "Number of points that were prevented from moving beyond the border in at least one "        \
      "iteration")                                                                                 \
    X(U64, fallback_plane, "fallbacks.plane", "points",                                            \
      "Number of points for which no curved surface (quadric) could be fitted in the last "        \
      "iteration, so that a plane was fitted instead (0 with patch=plane)")                        \
    X(U64, fallback_left, "fallbacks.left", "points",                                              \
      "Number of points that did not move in the last iteration, because no surface could be "     \
      "fitted")                                                                                    \
    X(REAL, area, "area", "unit of the cloud^2",                                                   \
      "Area of the surface. If the request has the parameter `spacing`, this is the area from "    \
      "which the number of points was computed, and with method=insert or kmeans it is computed "  \
      "in the same way; else it is the sum of the areas of all Voronoi cells of the result")       \
    X(REAL, spacing_mean, "spacing", "unit of the cloud",                                          \
      "Mean distance to the nearest neighbour in the result")                                      \
    X(REAL, min_over_mean, "min_over_mean", "",                                                    \
      "Smallest of the distances from points to their nearest neighbours, divided by the mean "    \
      "of these distances")                                                                        \
    X(REAL, max_over_mean, "max_over_mean", "",                                                    \
      "Largest of the distances from points to their nearest neighbours, divided by the mean of "  \
      "these distances")                                                                           \
    X(REAL, six_share, "six_share", "",                                                            \
      "Share of the points of the result that have six Voronoi neighbours. Points at borders "     \
      "are left out")                                                                              \
    X(OPTIONAL, has_cells, "cells", "",                                                            \
      "How far the Voronoi cells are from regular hexagons; absent if the request has a density "  \
      "or a metric, or if the run only filtered the input")                                        \
    VOR_CELLS_TABLE(X, "cells.")                                                                   \
    X(REAL, bisectors_per_cell, "bisectors_per_cell", "",                                          \
      "Mean number of planes that bound or have cut a Voronoi cell, over all computed cells")      \
    X(REAL, triangles_per_cell, "triangles_per_cell", "",                                          \
      "Number of triangles in the local surface from which a Voronoi cell is cut or made (mean "   \
      "over all computed cells)")                                                                  \
    X(U64, queries, "queries", "",                                                                 \
      "Number of searches for nearest neighbours among the points of the input or result")         \
    X(U64, list_rebuilds, "list_rebuilds", "",                                                     \
      "How often the neighbour lists of all points were rebuilt")                                  \
    X(VECTOR, origin, "origin", "unit of the cloud",                                               \
      "Origin of the positions in the file of the result. Add the origin to a "                    \
      "position to get its coordinates in the input. 0,0,0 if positions are written unchanged, "   \
      "as in PLY")                                                                                 \
    X(OPTIONAL, has_mesh, "mesh", "",                                                              \
      "Properties of the triangle mesh; present only in reports of the process mesh")              \
    X(U64, mesh_triangles, "mesh.triangles", "", "Triangles")                                      \
    X(U64, mesh_polygons, "mesh.polygons", "",                                                     \
      "Number of polygons with soup=true, else 0. If there are polygons, mesh.points is the "      \
      "number of their corners, and all other members are 0")                                      \
    X(U64, mesh_points, "mesh.points", "points",                                                   \
      "Number of points of the result that are corners of triangles")                              \
    X(U64, mesh_components, "mesh.components", "", "Number of connected components")               \
    X(REAL, mesh_euler, "mesh.euler", "",                                                          \
      "Euler characteristic: number of points, minus number of edges, plus number of triangles. "  \
      "A closed component without handles, such as a sphere, adds 2 to this number")               \
    X(ANSWERED, mesh_closed, "mesh.closed", "", "Whether every edge belongs to two triangles")     \
    X(ANSWERED, mesh_manifold, "mesh.manifold", "",                                                \
      "True if no edge belongs to more than two triangles, and the triangles at each point form "  \
      "a single fan")                                                                              \
    X(U64, mesh_one_sided, "mesh.one_sided", "",                                                   \
      "Number of components with only one side, like a Moebius band; along some edges of such a "  \
      "component, adjacent triangles face opposite ways")                                          \
    X(REAL, mesh_quality_mean, "mesh.quality_mean", "",                                            \
      "Mean quality of the triangles. The quality of a triangle with area S, half perimeter p "    \
      "and longest edge h is 6 S / (sqrt(3) p h); it is 1 if all edges have the same length")      \
    X(REAL, mesh_quality_p001, "mesh.quality_p001", "",                                            \
      "0.1th percentile of the quality: one triangle in a thousand has a lower quality")           \
    X(REAL, mesh_quality_min, "mesh.quality_min", "", "Lowest quality of a triangle")              \
    X(REAL, mesh_angle_min, "mesh.angle_min", "degrees", "Smallest angle of a triangle")           \
    X(U64, mesh_loops, "mesh.loops", "",                                                           \
      "Number of border loops of the mesh: holes and outer borders of the input")                  \
    X(U64, mesh_filled, "mesh.filled", "",                                                         \
      "Number of small gaps that were filled because the input has points there")                  \
    X(U64, mesh_unsure, "mesh.unsure", "",                                                         \
      "Number of triangles that possibly connect two layers of the surface (sheets) by mistake, "  \
      "because the sheets cross or are too close together. A triangle is counted if the surface "  \
      "fitted at one corner misses another corner by more than a fifth of the distance between "   \
      "the two corners. If no sheets of the input are close together, a different rule applies: "  \
      "a triangle is counted if one of its edges is longer than the distance from an end of "      \
      "this edge to another sheet")                                                                \
    X(U64, mesh_left_out, "mesh.left_out", "",                                                     \
      "Number of triangles that were left out: triangles where two sheets meet, triangles that "   \
      "intersect other triangles, and triangles that are then no longer connected to the mesh. "   \
      "Triangles are left out only if the input has several layers (sheets) nearly everywhere")    \
    X(MESH_LOOPS, mesh_longest, "mesh.longest_loops", "",                                          \
      "Border loops of the mesh, at most 32: the loops with the most edges")                       \
    X(REAL, mesh_seconds, "mesh.seconds", "s", "Time to make the triangles")                       \
    VOR_REGISTRATION_TABLE(X)                                                                      \
    X(OPTIONAL, has_baselines, "baselines", "",                                                    \
      "Results of simple methods on the same input; present with baselines=true, but not if the "  \
      "run only filtered the input or was stopped by the caller")                                  \
    X(BASELINE, kmeans, "baselines.kmeans", "", "The method kmeans, 35 iterations")                \
    X(BASELINE, random, "baselines.random", "", "Points of the input, chosen at random")           \
    X(BASELINE, voxel, "baselines.voxel", "",                                                      \
      "The mean of the input's points in each cell of a grid")                                     \
    X(BASELINE, farthest, "baselines.farthest", "",                                                \
      "Points of the input that were chosen by farthest-point sampling, where each step adds "     \
      "the input point that is farthest from all points chosen so far")                            \
    X(SPEC, parameters, "parameters", "",                                                          \
      "Parameters of the request. If the request has `ratio` or `spacing`, the value of "          \
      "`points` is the number computed from that parameter. A parameter that was auto has the "    \
      "value that the run used instead; `neighbors` has the value that was used most often")

struct vor_report {
    VOR_REPORT_TABLE(VOR_FIELD)
};

extern const struct vor_members vor_report_members;

/** Adds a warning to a list, if it has none of this kind.
 *
 *  @param[in] value, limit  as the table of warnings has them */
void vor_warn(struct vor_warning list[VOR_WARNING_COUNT], unsigned *list_count,
              enum vor_warning_kind kind, double value, double limit);

/** Adds a warning for each parameter with a value other than its default that has no effect beside
 *  the other parameters. */
void vor_warn_unused(struct vor_report *report, const struct vor_spec *spec);

/** Adds steps and seconds to a stage of the report. stage must be a row of the table. */
void vor_report_stage(struct vor_report *report, enum vor_run_stage stage, uint32_t steps,
                      double seconds);

/** Writes the steps of each stage, "12 iterations and 100 polish steps" or "no steps", cut to
 *  size > 0. Returns out. */
const char *vor_report_steps(const struct vor_report *report, char *out, size_t size);

/** How evenly a cloud is spread and, with a reference, how far it is from that; names and
 *  definitions of Xiao 2024 Sec. V-B. mse and psnr as mpeg-pcc-dmetric (metrics/distortion.h). */
#define VOR_MEASURE_TABLE(X)                                                                       \
    X(U64, n, "n", "points", "Number of points of the cloud")                                      \
    X(REAL, delta, "delta", "",                                                                    \
      "Standard deviation of the distances from points to their nearest neighbours, divided by "   \
      "the mean of these distances; lower is more even")                                           \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "Mean absolute deviation: how far the distances to the nearest neighbour differ from "       \
      "their mean, on average")                                                                    \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "Mean distance to the nearest neighbour, divided by the root mean square of these "          \
      "distances: 0 to 1, higher is more even")                                                    \
    X(REAL, mean_nn, "mean_nn", "unit of the cloud",                                               \
      "Mean distance from a point to its nearest neighbour")                                       \
    X(REAL, min_over_mean, "min_over_mean", "",                                                    \
      "Smallest of the distances from points to their nearest neighbours, divided by the mean "    \
      "of these distances")                                                                        \
    X(REAL, max_over_mean, "max_over_mean", "",                                                    \
      "Largest of the distances from points to their nearest neighbours, divided by the mean of "  \
      "these distances")                                                                           \
    X(U64, invalid, "invalid", "points",                                                           \
      "Number of points that were left out because a coordinate was not finite")                   \
    X(U64, coincident, "coincident", "points",                                                     \
      "Number of points that share a position with another point")                                 \
    X(REAL, six_share, "six_share", "", "Share of the points that have six Voronoi neighbours")    \
    X(OPTIONAL, has_cells, "cells", "",                                                            \
      "How far the Voronoi cells are from regular hexagons; absent if no cell is closed")          \
    VOR_CELLS_TABLE(X, "cells.")                                                                   \
    X(OPTIONAL, has_reference, "input", "",                                                        \
      "Comparison of the cloud with the reference; present only if the request has a reference")   \
    X(REAL, far_over_knn6_mean, "input.far_over_knn6_mean", "",                                    \
      "Largest distance from a point to the reference, divided by the mean distance from a "       \
      "reference point to its sixth nearest neighbour")                                            \
    X(REAL, far_over_knn6_p999, "input.far_over_knn6_p999", "",                                    \
      "Largest distance from a point to the reference, divided by the 99.9th percentile of the "   \
      "distances from reference points to their sixth nearest neighbours")                         \
    X(REAL, out_to_ref_mean, "input.out_to_ref_mean", "unit of the cloud",                         \
      "Mean distance from a point of the cloud to the nearest reference point")                    \
    X(REAL, out_to_ref_rms, "input.out_to_ref_rms", "unit of the cloud",                           \
      "Root mean square distance from a point of the cloud to the nearest reference point")        \
    X(REAL, out_to_ref_max, "input.out_to_ref_max", "unit of the cloud",                           \
      "Largest distance from a point of the cloud to the nearest reference point")                 \
    X(REAL, ref_to_out_mean, "input.ref_to_out_mean", "unit of the cloud",                         \
      "Mean distance from a reference point to the nearest point of the cloud")                    \
    X(REAL, ref_to_out_rms, "input.ref_to_out_rms", "unit of the cloud",                           \
      "Root mean square distance from a reference point to the nearest point of the cloud")        \
    X(REAL, ref_to_out_max, "input.ref_to_out_max", "unit of the cloud",                           \
      "Largest distance from a reference point to the nearest point of the cloud")                 \
    X(REAL, hausdorff, "input.hausdorff", "unit of the cloud",                                     \
      "Hausdorff distance: the larger of out_to_ref_max and ref_to_out_max")                       \
    X(REAL, hausdorff_relative, "input.hausdorff_relative", "",                                    \
      "Hausdorff distance divided by the diagonal of the reference's bounding box")                \
    X(REAL, chamfer, "input.chamfer", "unit of the cloud",                                         \
      "Chamfer distance: out_to_ref_mean plus ref_to_out_mean (of distances, not their squares)")  \
    X(REAL, d1_mse, "input.d1_mse", "unit of the cloud^2",                                         \
      "Mean squared point-to-point error, in the direction in which it is larger")                 \
    X(REAL, d1_psnr, "input.d1_psnr", "dB",                                                        \
      "Peak signal-to-noise ratio of d1_mse: 10 log10(3 peak^2 / d1_mse); null if d1_mse is 0")    \
    X(REAL, d2_mse, "input.d2_mse", "unit of the cloud^2",                                         \
      "Mean squared point-to-plane error, in the direction in which it is larger")                 \
    X(REAL, d2_psnr, "input.d2_psnr", "dB",                                                        \
      "Peak signal-to-noise ratio of d2_mse: 10 log10(3 peak^2 / d2_mse); null if d2_mse is 0")    \
    X(REAL, peak, "input.peak", "unit of the cloud",                                               \
      "Peak value in the formulas of d1_psnr and d2_psnr")                                         \
    VOR_MLS_ERROR_TABLE(X)

struct vor_measure {
    VOR_MEASURE_TABLE(VOR_FIELD)
};

extern const struct vor_members vor_measure_members;

/** Why: a hole, the end of a tube, the outer border of a sheet. */
enum vor_loop_why { VOR_LOOP_AROUND, VOR_LOOP_ONE_SIDE, VOR_LOOP_WITHIN };

#define VOR_FIELD_LOOP_WHY(field) enum vor_loop_why field;

/** A closed row of points where the input ends. */
#define VOR_LOOP_TABLE(X)                                                                          \
    X(U32, id, "id", "",                                                                           \
      "Number that identifies the loop. Loops are numbered from 1, the longest first; the same "   \
      "input always gives the same numbers")                                                       \
    X(REAL, length, "length", "unit of the cloud", "Length of the loop")                           \
    X(U64, points, "points", "points", "Number of points of the cloud along the loop")             \
    X(VECTOR, centre, "centre", "unit of the cloud",                                               \
      "Centroid of the closed line through the points of the loop, in the coordinates of the "     \
      "cloud")                                                                                     \
    X(LOOP_KIND, kind, "kind", "",                                                                 \
      "hole: a gap inside a surface; rim: an outer border of an open surface")                     \
    X(LOOP_WHY, why, "why", "",                                                                    \
      "Reason for the kind of the loop: where the surface lies relative to the loop")              \
    X(REAL, turns, "turns", "",                                                                    \
      "How many full turns the direction of the loop makes, measured along the surface: 1 for a "  \
      "hole in a plane, 0 for the end of a tube, -1 for the outer border of a plane. A loop "      \
      "with 0.3 turns or more is a hole")

struct vor_loop_told {
    VOR_LOOP_TABLE(VOR_FIELD)
};

/** Most loops that are told: scans have thousands. */
#define VOR_LOOPS_TOLD 100
#define VOR_FIELD_LOOPS(field)                                                                     \
    struct vor_loop_told field[VOR_LOOPS_TOLD];                                                    \
    unsigned field##_count;

/** What a cloud is like. Lengths are in the unit of the cloud. */
#define VOR_INSPECT_TABLE(X)                                                                       \
    X(TEXT, format, "format", "", "Format of the file, as in the parameter `format`")              \
    X(BOX, bounds, "bounds", "", "Axis-aligned bounding box of all points")                        \
    X(VECTOR, origin, "origin", "unit of the cloud", "Origin of the positions in the file")        \
    X(COLUMNS, attributes, "attributes", "", "Attributes of the points besides positions")         \
    X(U64, points, "points.all", "points", "Number of points of the cloud")                        \
    X(U64, invalid, "points.invalid", "points",                                                    \
      "Number of points that were left out because a coordinate was not finite. points.all does "  \
      "not include them")                                                                          \
    X(U64, distinct, "points.distinct", "points", "Number of different positions")                 \
    X(U64, outliers, "points.outliers", "points",                                                  \
      "Number of points off the surface (0 with outliers=keep). The numbers that follow in this "  \
      "report do not include outliers")                                                            \
    X(U64, components, "components.count", "",                                                     \
      "Number of separate parts. Two parts are separate if no point of one is a neighbour of a "   \
      "point of the other")                                                                        \
    X(U64, largest, "components.largest", "points", "Number of points of the largest part")        \
    X(U64, small, "components.small", "",                                                          \
      "Number of small parts: parts with fewer than 2 x `neighbors` points, where `neighbors` "    \
      "is the number of points that a local surface is fitted to")                                 \
    X(U64, small_points, "components.small_points", "points",                                      \
      "Number of points in all small parts together")                                              \
    X(REAL, spacing, "spacing.mean", "unit of the cloud",                                          \
      "Mean distance from a point to its nearest neighbour")                                       \
    X(REAL, spacing_p01, "spacing.p01", "unit of the cloud",                                       \
      "1st percentile of the distances from points to their nearest neighbours")                   \
    X(REAL, spacing_p50, "spacing.p50", "unit of the cloud",                                       \
      "Median of the distances from points to their nearest neighbours")                           \
    X(REAL, spacing_p99, "spacing.p99", "unit of the cloud",                                       \
      "99th percentile of the distances from points to their nearest neighbours")                  \
    X(REAL, noise, "noise", "unit of the cloud",                                                   \
      "Root mean square distance from points to the local surface fitted to them: median over "    \
      "512 places")                                                                                \
    X(U32, neighbors, "neighbors", "points",                                                       \
      "With neighbors=auto: number of input points that a local surface is fitted to in most "     \
      "regions")                                                                                   \
    X(VECTOR, lattice, "lattice", "unit of the cloud",                                             \
      "Step of the grid to which the coordinates were rounded (0 if no grid was found)")           \
    X(ANSWERED, lattice_matters, "lattice.matters", "",                                            \
      "True if the grid is coarse compared with the distance between points. A run would then "    \
      "correct the rounding: it would move each point within its grid cell")                       \
    X(ANSWERED, sheets, "sheets.found", "",                                                        \
      "True if layers of the surface (sheets) are so close together, in much of the surface, "     \
      "that a local fit could mix their points")                                                   \
    X(REAL, own, "sheets.own", "",                                                                 \
      "Share of the result points with a surface fitted only to input points of their own "        \
      "sheet; the surfaces of the others are fitted to the nearest input points of any sheet")     \
    X(U64, edge_points, "edges.points", "points", "Number of points that lie on a sharp edge")     \
    X(REAL, edge_length, "edges.length", "unit of the cloud",                                      \
      "Estimated total length of all sharp edges")                                                 \
    VOR_VCM_TABLE(X)                                                                               \
    X(REAL, area, "area", "unit of the cloud^2",                                                   \
      "Area of the surface: the sum of the areas of the points' Voronoi cells")                    \
    X(U64, border_loops, "border.loops", "",                                                       \
      "Number of border loops: closed lines of points where the surface ends")                     \
    X(U64, border_holes, "border.holes", "", "Number of loops that are holes")                     \
    X(REAL, border_length, "border.length", "unit of the cloud", "Total length of all loops")      \
    X(U64, border_open, "border.open", "",                                                         \
      "Number of open border lines: rows of three or more border points that do not close into "   \
      "a loop")                                                                                    \
    X(LOOPS, loops, "loops", "",                                                                   \
      "Border loops of the surface; if there are more than 100, only the 100 longest")

struct vor_inspect {
    VOR_INSPECT_TABLE(VOR_FIELD)
};

extern const struct vor_members vor_inspect_members;

/** Documents that processes hand out: name, description. */
#define VOR_DOCUMENT_TABLE(X)                                                                      \
    X("report", vor_report_members)                                                                \
    X("measure", vor_measure_members)                                                              \
    X("inspect", vor_inspect_members)

/** The description of the document of that name; NULL when there is none. */
const struct vor_members *vor_document_members(const char *name);

#endif
