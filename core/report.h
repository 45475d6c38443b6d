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
    X(ITERATE, "iterate", "iteration", "Moves each point towards the centroid of its cell")        \
    X(POLISH, "polish", "polish step", "Moves points away from their neighbours")                  \
    X(BASELINES, "baselines", "baseline", "Runs simple methods for comparison")                    \
    X(PROJECT, "project", "projection step",                                                       \
      "Pulls each point towards nearby input points and away from its neighbours")                 \
    X(INSERT, "insert", "inserted point", "Inserts points in the largest gaps")

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

/** What is known after a step of a run: the same record in SSE, NDJSON, traces and the metrics of a
 *  job. A run begins with a record of 0 steps of its first stage. Members are only ever added, at
 *  the end: traces keep them in this order. */
#define VOR_RECORD_TABLE(X)                                                                        \
    X(U32, iteration, "iteration", "", "Iterations or projection steps done; 0 is the start")      \
    X(U32, polish, "polish", "", "Polish steps done; 0 during the iterations")                     \
    X(REAL, delta, "delta", "",                                                                    \
      "Uniformity: the relative standard deviation of the distances to the nearest neighbour; "    \
      "lower is better")                                                                           \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "Mean absolute deviation of those distances from their mean")                                \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "Mean of those distances divided by their root mean square, 0 to 1; higher is better")       \
    X(REAL, energy, "energy", "unit of the cloud^4",                                               \
      "Energy of the tessellation; during the polish, that of the last iteration")                 \
    X(REAL, max_move, "max_move", "unit of the cloud", "Longest distance that a point moved")      \
    X(U64, held, "held", "points", "Points held back at the border of the input")                  \
    X(REAL, seconds, "seconds", "s", "Time since the run began")                                   \
    X(RUN_STAGE, stage, "run_stage", "", "Stage of the run")                                       \
    X(U32, step, "step", "", "Steps of this stage done")                                           \
    X(U32, of, "of", "", "Largest number of steps of this stage; 0 if it is not known")            \
    X(U32, ahead, "ahead", "", "Largest number of steps in all later stages together")             \
    X(U32, best_iteration, "best.iteration", "",                                                   \
      "Iteration of the best result so far, which the run would return now")                       \
    X(U32, best_polish, "best.polish", "", "Polish step of the best result so far")                \
    X(REAL, best_delta, "best.delta", "",                                                          \
      "delta of the best result so far; in the last record of a run, that of the report")          \
    X(REAL, best_sigma, "best.sigma", "unit of the cloud", "sigma of the best result so far")      \
    X(REAL, best_epsilon, "best.epsilon", "", "epsilon of the best result so far")

struct vor_record {
    VOR_RECORD_TABLE(VOR_FIELD)
};

extern const struct vor_members vor_record_members;

/** Sets the members best of a record that was written before records had them: what would have been
 *  handed back was not written, its delta, sigma and epsilon become NAN. */
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

/** The word of a row; stopped must be one. */
const char *vor_stopped_word(enum vor_stopped stopped);

#define VOR_FIELD_STOPPED(field) enum vor_stopped field;

/** A stage that a run went through. */
#define VOR_STAGE_DONE_TABLE(X)                                                                    \
    X(RUN_STAGE, stage, "stage", "", "Name of the stage")                                          \
    X(U32, steps, "steps", "", "Steps done")                                                       \
    X(REAL, seconds, "seconds", "s", "Time that the stage took")

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
    X(U64, points_in, "points.in", "points", "Points of the input, or vertices if it is a mesh")   \
    X(U64, points_out, "points.out", "points", "Points of the result")                             \
    X(REAL, delta, "delta", "",                                                                    \
      "Uniformity of the result: the relative standard deviation of the distances to the nearest " \
      "neighbour; lower is better. With a density, each distance is divided by the target "        \
      "spacing there; with a metric, distances are measured in it. The same applies to sigma and " \
      "epsilon, also in events and traces")                                                        \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "Mean absolute deviation of those distances from their mean")                                \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "Mean of those distances divided by their root mean square, 0 to 1; higher is better")       \
    X(U32, iterations, "iterations", "", "Iterations or projection steps done")                    \
    X(U32, polish_steps, "polish_steps", "", "Polish steps done")                                  \
    X(STOPPED, stopped, "stopped", "", "Why the run ended")                                        \
    X(WARNINGS, warnings, "warnings", "",                                                          \
      "Warnings: parameters that had no effect, and problems of the input. Empty for most runs")   \
    X(STAGES, stages, "stages", "",                                                                \
      "Stages of the run, in order. Their seconds are included in the member seconds, except "     \
      "those of baselines")                                                                        \
    X(REAL, seconds_read, "seconds.read", "s", "Decoding the input")                               \
    X(REAL, seconds_index, "seconds.index", "s", "Sorting and indexing the input")                 \
    X(REAL, seconds_init, "seconds.init", "s", "Placing the first points")                         \
    X(REAL, seconds_iterate, "seconds.iterate", "s",                                               \
      "Iterations, or the corresponding stages of other methods")                                  \
    X(REAL, seconds_polish, "seconds.polish", "s",                                                 \
      "Polish, and moving points outside the input onto it")                                       \
    X(REAL, seconds_write, "seconds.write", "s", "Encoding the result")                            \
    X(U64, memory_peak_bytes, "memory_peak_bytes", "bytes", "Peak memory of the job")              \
    X(U64, invalid, "invalid", "points",                                                           \
      "Input points that were left out because a coordinate was not finite; points.in does not "   \
      "count them")                                                                                \
    X(U64, faces, "faces", "",                                                                     \
      "Number of faces that the input's file declares; a triangle strip counts as one. "           \
      "sample=faces resamples them")                                                               \
    X(U64, samples, "samples", "points",                                                           \
      "Points drawn from the faces; 0 without sample=faces. All figures about input points, "      \
      "except points.in, are about these")                                                         \
    X(DROPPED, dropped, "dropped", "",                                                             \
      "Contents of the input's file that are not in the result's: faces, other elements and "      \
      "lists of a PLY file, attributes that the request drops, and comments if the format of the " \
      "result has none")                                                                           \
    X(U64, outliers, "outliers", "points",                                                         \
      "Outliers among the input points: ignored, or pulled onto the surface")                      \
    X(U64, parts, "components", "", "Separate parts of the input")                                 \
    X(U64, islands, "islands.components", "",                                                      \
      "Separate parts with few points: fewer than twice the number that a local surface is "       \
      "fitted to (neighbors)")                                                                     \
    X(U64, in_islands, "islands.points_in", "points", "Input points on islands")                   \
    X(U64, on_islands, "islands.points_out", "points",                                             \
      "Points of the result on islands, each at the position of an input point; 0 if "             \
      "filters alone make the result")                                                             \
    X(REAL, delta_beside, "islands.delta_beside", "",                                              \
      "delta of the points of the result that are not on islands; delta of all points includes "   \
      "the gaps around islands")                                                                   \
    X(OPTIONAL, has_holes, "holes", "",                                                            \
      "Holes of the input; only if the request fills holes. The points added there count as "      \
      "input points from then on")                                                                 \
    X(U64, holes_loops, "holes.loops", "", "Border loops of the input")                            \
    X(U64, holes_filled, "holes.filled", "", "Loops that were filled")                             \
    X(U64, holes_not_closed, "holes.not_closed", "", "Loops that could not be closed")             \
    X(U64, holes_points, "holes.points", "points", "Points added in holes")                        \
    X(HOLES, holes, "holes.each", "",                                                              \
      "The loops, at most 100: if there are more, those that could not be closed and the longest") \
    X(OPTIONAL, has_density, "density", "",                                                        \
      "How well the result follows the density; only if the request has one")                      \
    X(REAL, density_span, "density.span", "",                                                      \
      "Ratio of the 95th to the 5th percentile of the density on the surface, after contrast and " \
      "grading")                                                                                   \
    X(REAL, density_least, "density.spacing_min", "unit of the cloud", "Smallest target spacing")  \
    X(REAL, density_most, "density.spacing_max", "unit of the cloud", "Largest target spacing")    \
    X(OPTIONAL, has_metric, "metric", "",                                                          \
      "How well the result follows the metric; only if the request has one")                       \
    X(REAL, metric_median, "metric.aspect_median", "",                                             \
      "Ratio of length to width of cells in the metric: median over places of the surface")        \
    X(REAL, metric_high, "metric.aspect_p95", "",                                                  \
      "Ratio of length to width of cells in the metric: 95th percentile")                          \
    X(REAL, metric_cells, "metric.cells_median", "",                                               \
      "Ratio of length to width of the cells of the result, as the root of the ratio of "          \
      "their principal second moments: median")                                                    \
    X(REAL, metric_off, "metric.off_median", "",                                                   \
      "Relative difference between the ratio of length to width of a cell and that of the "        \
      "metric: median")                                                                            \
    X(REAL, metric_off_high, "metric.off_p90", "",                                                 \
      "Relative difference between these two ratios of a cell: 90th percentile")                   \
    X(OPTIONAL, has_descent, "descent", "",                                                        \
      "How the energy was minimised; only with metric=lp or cells=euclid")                         \
    X(U64, descent_steps, "descent.steps", "", "Steps of L-BFGS, at most five per iteration")      \
    X(U64, descent_evaluations, "descent.evaluations", "", "Evaluations of the energy")            \
    X(REAL, descent_worst, "descent.worst", "",                                                    \
      "Largest ratio of the energy after an iteration to that before it; below 1")                 \
    X(REAL, descent_aspect, "descent.aspect", "",                                                  \
      "Median aspect of the cells, the root of the ratio of their second moments; 1 for squares "  \
      "and regular hexagons")                                                                      \
    X(VECTOR, lattice, "lattice", "unit of the cloud",                                             \
      "Size of the cells that the input's coordinates were rounded to; 0 if none was found")       \
    X(U64, off_lattice, "lattice.moved", "points",                                                 \
      "Input points that were moved within their cell; 0 if cells are small compared with the "    \
      "spacing of the input")                                                                      \
    X(ORIENTED, orientation, "orientation", "",                                                    \
      "Orientation of the result's normals. not-asked: as in the input, or there are none; "       \
      "carried: the side of the input's normals; consistent: outward or upward, found from the "   \
      "input's points; one-sided: likewise, but parts of the input have only one side")            \
    X(U64, one_sided, "one_sided", "",                                                             \
      "Connected parts of the input with only one side, like a Moebius band: their normals "       \
      "cannot be consistent. 0 if the run did not determine sides")                                \
    X(APART, ref_to_out, "ref_to_out", "",                                                         \
      "Distances from the input's points to the nearest point of the result. Points at the same "  \
      "position count once, ignored outliers do not count, and points moved off a lattice count "  \
      "from their new position. If there are more than 200000, only 200000 count, at equal "       \
      "steps along a curve through the input: mean and rms are then estimates, and max is a "      \
      "lower bound")                                                                               \
    X(APART, out_to_ref, "out_to_ref", "",                                                         \
      "Distances from all points of the result to the nearest of the same input points")           \
    X(U64, boundary_points, "boundary_points", "points",                                           \
      "Points of the result at borders of the input, for any value of boundary: 0 on a closed "    \
      "smooth surface, else about the length of the border divided by the spacing")                \
    X(FITTED, fitted, "neighbors_histogram", "",                                                   \
      "Histogram of the numbers of input points that local surfaces were fitted to in the last "   \
      "step, in ascending order. neighbors is such a number; points is the number of points of "   \
      "the result with such a fit. Together they are points.out")                                  \
    X(U64, held, "held", "points", "Points held back at the border in the last iteration")         \
    X(U64, held_ever, "held_ever", "points", "Points held back at the border in any iteration")    \
    X(U64, fallback_plane, "fallbacks.plane", "points",                                            \
      "Points fitted with a plane in the last iteration because no quadric was found; 0 with "     \
      "patch=plane")                                                                               \
    X(U64, fallback_left, "fallbacks.left", "points",                                              \
      "Points left in place in the last iteration because no surface was found")                   \
    X(REAL, area, "area", "unit of the cloud^2",                                                   \
      "Area of the surface: if the request has spacing, the area that the number of points was "   \
      "computed from, else the sum of the areas of the cells at the end")                          \
    X(REAL, spacing_mean, "spacing", "unit of the cloud",                                          \
      "Mean distance to the nearest neighbour in the result")                                      \
    X(REAL, min_over_mean, "min_over_mean", "",                                                    \
      "Smallest of those distances, divided by their mean")                                        \
    X(REAL, max_over_mean, "max_over_mean", "",                                                    \
      "Largest of those distances, divided by their mean")                                         \
    X(REAL, six_share, "six_share", "",                                                            \
      "Share of the points of the result with six Voronoi neighbours, borders left out")           \
    X(OPTIONAL, has_cells, "cells", "",                                                            \
      "How far the Voronoi cells are from regular hexagons; absent if the request has a density "  \
      "or metric, or if filters alone make the result")                                            \
    VOR_CELLS_TABLE(X, "cells.")                                                                   \
    X(REAL, bisectors_per_cell, "bisectors_per_cell", "",                                          \
      "Planes that cut a cell: mean over all cells computed")                                      \
    X(REAL, triangles_per_cell, "triangles_per_cell", "",                                          \
      "Triangles of the patch that a cell is cut from: mean over all cells computed")              \
    X(U64, queries, "queries", "",                                                                 \
      "Searches for nearest neighbours, among the input or the points")                            \
    X(U64, list_rebuilds, "list_rebuilds", "", "Rebuilds of the neighbour lists of all points")    \
    X(VECTOR, origin, "origin", "unit of the cloud",                                               \
      "Origin of the positions in the result's file: added to them, it gives the coordinates of "  \
      "the input. 0,0,0 if positions are written unchanged, as in PLY")                            \
    X(OPTIONAL, has_mesh, "mesh", "",                                                              \
      "Properties of the triangle mesh; only for the process mesh")                                \
    X(U64, mesh_triangles, "mesh.triangles", "", "Triangles")                                      \
    X(U64, mesh_polygons, "mesh.polygons", "",                                                     \
      "Polygons, with soup; points then counts all their corners, and the other members are 0")    \
    X(U64, mesh_points, "mesh.points", "points",                                                   \
      "Points of the result that are corners of triangles")                                        \
    X(U64, mesh_components, "mesh.components", "", "Connected components")                         \
    X(REAL, mesh_euler, "mesh.euler", "",                                                          \
      "Euler characteristic: points minus edges plus triangles; 2 for each closed component "      \
      "without handles")                                                                           \
    X(ANSWERED, mesh_closed, "mesh.closed", "", "Whether every edge has two triangles")            \
    X(ANSWERED, mesh_manifold, "mesh.manifold", "",                                                \
      "Whether no edge has more than two triangles and the triangles at every point form one fan") \
    X(U64, mesh_one_sided, "mesh.one_sided", "",                                                   \
      "Components with only one side, like a Moebius band: along some of their edges neighbours "  \
      "face opposite ways")                                                                        \
    X(REAL, mesh_quality_mean, "mesh.quality_mean", "",                                            \
      "Mean quality of the triangles, 6 S / (sqrt(3) p h) of area S, half the perimeter p and "    \
      "longest edge h: 1 where all edges are equal")                                               \
    X(REAL, mesh_quality_p001, "mesh.quality_p001", "",                                            \
      "Quality that one triangle in a thousand does not reach")                                    \
    X(REAL, mesh_quality_min, "mesh.quality_min", "", "Lowest quality of a triangle")              \
    X(REAL, mesh_angle_min, "mesh.angle_min", "degrees", "Smallest angle of a triangle")           \
    X(U64, mesh_loops, "mesh.loops", "", "Border loops of the mesh: rims and holes of the input")  \
    X(U64, mesh_filled, "mesh.filled", "",                                                         \
      "Small loops that were filled because the input continues under them")                       \
    X(U64, mesh_unsure, "mesh.unsure", "",                                                         \
      "Triangles that may connect two sheets of the input that cross or are too close together: "  \
      "the surface fitted at one corner misses another corner by more than a fifth of the "        \
      "distance between the two. If no sheets were found in the input: triangles with an edge "    \
      "that is longer than the distance from one of its points to another sheet")                  \
    X(U64, mesh_left_out, "mesh.left_out", "",                                                     \
      "Triangles left out if the input has several sheets nearly everywhere: those at points "     \
      "where two sheets meet, those that pass through others, and pieces that this cuts off")      \
    X(MESH_LOOPS, mesh_longest, "mesh.longest_loops", "",                                          \
      "The loops with the most edges, at most 32")                                                 \
    X(REAL, mesh_seconds, "mesh.seconds", "s", "Time to make the triangles")                       \
    X(OPTIONAL, has_baselines, "baselines", "",                                                    \
      "Results of simple methods on the same input; only with baselines=true, and not if filters " \
      "alone made the result or the caller stopped the run")                                       \
    X(BASELINE, kmeans, "baselines.kmeans", "", "The method kmeans, 35 iterations")                \
    X(BASELINE, random, "baselines.random", "", "Points of the input, chosen at random")           \
    X(BASELINE, voxel, "baselines.voxel", "",                                                      \
      "Means of the input's points in each cell of a grid")                                        \
    X(BASELINE, farthest, "baselines.farthest", "",                                                \
      "Points of the input by farthest-point sampling: each is the farthest from all before it")   \
    X(SPEC, parameters, "parameters", "",                                                          \
      "Parameters of the request, with points computed from ratio or spacing, and each auto "      \
      "replaced by its value (for neighbors, the most frequent one)")

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
    X(U64, n, "n", "points", "Points of the cloud")                                                \
    X(REAL, delta, "delta", "",                                                                    \
      "Uniformity: the relative standard deviation of the distances to the nearest neighbour; "    \
      "lower is better")                                                                           \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "Mean absolute deviation of those distances from their mean")                                \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "Mean of those distances divided by their root mean square, 0 to 1; higher is better")       \
    X(REAL, mean_nn, "mean_nn", "unit of the cloud",                                               \
      "Mean distance to the nearest other point: the spacing")                                     \
    X(REAL, min_over_mean, "min_over_mean", "",                                                    \
      "Smallest of those distances, divided by their mean")                                        \
    X(REAL, max_over_mean, "max_over_mean", "",                                                    \
      "Largest of those distances, divided by their mean")                                         \
    X(U64, invalid, "invalid", "points",                                                           \
      "Points that were left out because a coordinate was not finite")                             \
    X(U64, coincident, "coincident", "points", "Points at the same position as another one")       \
    X(REAL, six_share, "six_share", "", "Share of the points with six Voronoi neighbours")         \
    X(OPTIONAL, has_cells, "cells", "",                                                            \
      "How far the Voronoi cells are from regular hexagons; absent if no cell is closed")          \
    VOR_CELLS_TABLE(X, "cells.")                                                                   \
    X(OPTIONAL, has_reference, "input", "",                                                        \
      "The cloud compared with the reference; only if there is one")                               \
    X(REAL, far_over_knn6_mean, "input.far_over_knn6_mean", "",                                    \
      "The largest distance to the reference, divided by the mean distance from reference points " \
      "to their sixth neighbours")                                                                 \
    X(REAL, far_over_knn6_p999, "input.far_over_knn6_p999", "",                                    \
      "The same, divided by the 99.9th percentile of those distances")                             \
    X(REAL, out_to_ref_mean, "input.out_to_ref_mean", "unit of the cloud",                         \
      "Mean distance from a point to the nearest reference point")                                 \
    X(REAL, out_to_ref_rms, "input.out_to_ref_rms", "unit of the cloud",                           \
      "Root mean square of those distances")                                                       \
    X(REAL, out_to_ref_max, "input.out_to_ref_max", "unit of the cloud",                           \
      "Largest of those distances")                                                                \
    X(REAL, ref_to_out_mean, "input.ref_to_out_mean", "unit of the cloud",                         \
      "Mean distance from a reference point to the nearest point")                                 \
    X(REAL, ref_to_out_rms, "input.ref_to_out_rms", "unit of the cloud",                           \
      "Root mean square of those distances")                                                       \
    X(REAL, ref_to_out_max, "input.ref_to_out_max", "unit of the cloud",                           \
      "Largest of those distances")                                                                \
    X(REAL, hausdorff, "input.hausdorff", "unit of the cloud",                                     \
      "Hausdorff distance: the larger of out_to_ref_max and ref_to_out_max")                       \
    X(REAL, hausdorff_relative, "input.hausdorff_relative", "",                                    \
      "hausdorff divided by the diagonal of the reference's bounding box")                         \
    X(REAL, chamfer, "input.chamfer", "unit of the cloud",                                         \
      "Chamfer distance: out_to_ref_mean plus ref_to_out_mean (of distances, not of "              \
      "their squares)")                                                                            \
    X(REAL, d1_mse, "input.d1_mse", "unit of the cloud^2",                                         \
      "Mean squared error point to point, in the worse direction")                                 \
    X(REAL, d1_psnr, "input.d1_psnr", "dB", "10 log10(3 peak^2 / d1_mse); null if the error is 0") \
    X(REAL, d2_mse, "input.d2_mse", "unit of the cloud^2",                                         \
      "Mean squared error point to plane, in the worse direction")                                 \
    X(REAL, d2_psnr, "input.d2_psnr", "dB", "10 log10(3 peak^2 / d2_mse); null if the error is 0") \
    X(REAL, peak, "input.peak", "unit of the cloud", "Peak value used for both PSNR")

struct vor_measure {
    VOR_MEASURE_TABLE(VOR_FIELD)
};

extern const struct vor_members vor_measure_members;

/** A box along the axes. */
#define VOR_BOX_TABLE(X)                                                                           \
    X(VECTOR, low, "min", "unit of the cloud", "Lowest coordinates")                               \
    X(VECTOR, high, "max", "unit of the cloud", "Highest coordinates")

struct vor_corners {
    VOR_BOX_TABLE(VOR_FIELD)
};

#define VOR_FIELD_BOX(field) struct vor_corners field;

/** An attribute of a cloud. */
#define VOR_COLUMN_TABLE(X)                                                                        \
    X(TEXT, name, "name", "", "normal, color, or its own name")                                    \
    X(TEXT, type, "type", "", "Type of its scalars: int8 to uint64, float32, float64")             \
    X(U32, components, "components", "", "Scalars of a point")

struct vor_column {
    VOR_COLUMN_TABLE(VOR_FIELD)
};

#define VOR_FIELD_COLUMNS(field)                                                                   \
    struct vor_column field[VOR_ATTRIBUTES_MAX];                                                   \
    unsigned field##_count;

/** Why: a hole, the end of a tube, the outer border of a sheet. */
enum vor_loop_why { VOR_LOOP_AROUND, VOR_LOOP_ONE_SIDE, VOR_LOOP_WITHIN };

#define VOR_FIELD_LOOP_WHY(field) enum vor_loop_why field;

/** A closed row of points where the input ends. */
#define VOR_LOOP_TABLE(X)                                                                          \
    X(U32, id, "id", "",                                                                           \
      "Number of the loop, from 1, the longest first; the same for the same input")                \
    X(REAL, length, "length", "unit of the cloud", "Length of the loop")                           \
    X(U64, points, "points", "points", "Points of the cloud along the loop")                       \
    X(VECTOR, centre, "centre", "unit of the cloud",                                               \
      "Centroid of the closed line through these points, in the coordinates of the cloud")         \
    X(LOOP_KIND, kind, "kind", "",                                                                 \
      "hole: a gap inside a surface; rim: an outer border of an open surface")                     \
    X(LOOP_WHY, why, "why", "", "Evidence for the kind: where the surface lies")                   \
    X(REAL, turns, "turns", "",                                                                    \
      "How often the loop winds around the gap, seen along the surface: 1 for a hole in a plane, " \
      "0 for the end of a tube, -1 for the outer border of a plane. Holes have 0.3 or more")

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
    X(TEXT, format, "format", "", "Format of the file: a value of the parameter format")           \
    X(BOX, bounds, "bounds", "", "Axis-aligned bounding box of all points")                        \
    X(VECTOR, origin, "origin", "unit of the cloud", "Point that positions are relative to")       \
    X(COLUMNS, attributes, "attributes", "", "Attributes of the points besides positions")         \
    X(U64, points, "points.all", "points", "Points of the cloud")                                  \
    X(U64, invalid, "points.invalid", "points",                                                    \
      "Points that were left out because a coordinate was not finite; `all` does not count them")  \
    X(U64, distinct, "points.distinct", "points", "Points at different positions")                 \
    X(U64, outliers, "points.outliers", "points",                                                  \
      "Points off every surface; 0 with outliers=keep. All figures below are about the other "     \
      "points")                                                                                    \
    X(U64, components, "components.count", "",                                                     \
      "Separate parts: no two points of different parts are among each other's neighbours")        \
    X(U64, largest, "components.largest", "points", "Points of the largest part")                  \
    X(U64, small, "components.small", "",                                                          \
      "Parts with too few points to show a surface: fewer than twice the number that a local "     \
      "surface is fitted to (neighbors)")                                                          \
    X(U64, small_points, "components.small_points", "points", "Points on islands")                 \
    X(REAL, spacing, "spacing.mean", "unit of the cloud",                                          \
      "Mean distance from a point to its nearest neighbour")                                       \
    X(REAL, spacing_p01, "spacing.p01", "unit of the cloud", "1st percentile of that distance")    \
    X(REAL, spacing_p50, "spacing.p50", "unit of the cloud", "Median of that distance")            \
    X(REAL, spacing_p99, "spacing.p99", "unit of the cloud", "99th percentile of that distance")   \
    X(REAL, noise, "noise", "unit of the cloud",                                                   \
      "Root mean square distance from points to the surface fitted to them: median of 512 places") \
    X(U32, neighbors, "neighbors", "points",                                                       \
      "Number of points that a surface is fitted to: what neighbors=auto chooses in most places")  \
    X(VECTOR, lattice, "lattice", "unit of the cloud",                                             \
      "Size of the cells that the coordinates were rounded to; 0 if none was found")               \
    X(ANSWERED, lattice_matters, "lattice.matters", "",                                            \
      "Whether the cells are so large compared with the spacing that points are moved within "     \
      "them")                                                                                      \
    X(ANSWERED, sheets, "sheets.found", "",                                                        \
      "Whether sheets lie closer together than a fit reaches, on much of the cloud")               \
    X(REAL, own, "sheets.own", "",                                                                 \
      "Share of the points with neighbours that are not simply the nearest points")                \
    X(U64, edge_points, "edges.points", "points", "Points that lie on a sharp edge")               \
    X(REAL, edge_length, "edges.length", "unit of the cloud", "Estimated length of all edges")     \
    X(REAL, area, "area", "unit of the cloud^2",                                                   \
      "Area of the surface, the sum of the cells of its points")                                   \
    X(U64, border_loops, "border.loops", "",                                                       \
      "Border loops: closed lines of points where the surface ends")                               \
    X(U64, border_holes, "border.holes", "", "Loops that are holes")                               \
    X(REAL, border_length, "border.length", "unit of the cloud", "Length of all loops")            \
    X(U64, border_open, "border.open", "",                                                         \
      "Open border lines: lines of three or more points where the surface ends that form no "      \
      "closed loop")                                                                               \
    X(LOOPS, loops, "loops", "", "The longest of the loops, at most 100")

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
