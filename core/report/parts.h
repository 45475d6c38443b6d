/** Parts of a report: tables of their own that members of its tables are made of. Included
 * through core/report.h. */
#ifndef VOR_REPORT_PARTS_H
#define VOR_REPORT_PARTS_H

#include "core/base/members.h"
#include "core/spec.h"

#include <stdint.h>

/** Distances from points to the nearest of others. */
#define VOR_APART_TABLE(X)                                                                         \
    X(REAL, mean, "mean", "unit of the cloud", "Mean distance")                                    \
    X(REAL, rms, "rms", "unit of the cloud", "Root mean square distance")                          \
    X(REAL, max, "max", "unit of the cloud", "Largest distance")                                   \
    X(U64, points, "points", "points", "Number of points that were measured")

struct vor_apart {
    VOR_APART_TABLE(VOR_FIELD)
};

#define VOR_FIELD_APART(field) struct vor_apart field;

/** How many points of the result have a surface that was fitted to a given number of input points.
 */
#define VOR_FITTED_TABLE(X)                                                                        \
    X(U32, neighbors, "neighbors", "points", "A number of input points")                           \
    X(U64, points, "points", "points",                                                             \
      "Number of result points with a local surface that was fitted to `neighbors` input points")

struct vor_fitted {
    VOR_FITTED_TABLE(VOR_FIELD)
};

/** Most different numbers in a report: those of the ladder in input/neighbors.c, VOR_REFINED_TO and
 *  a given one; the lowest of more. */
#define VOR_FITTED_MAX 8
#define VOR_FIELD_FITTED(field)                                                                    \
    struct vor_fitted field[VOR_FITTED_MAX];                                                       \
    unsigned field##_count;

/** No and yes, as a member. */
enum vor_answered { VOR_NO, VOR_YES };

#define VOR_FIELD_ANSWERED(field) enum vor_answered field;

/** How the normals of a result face: identifier, word. */
#define VOR_ORIENTED_TABLE(X)                                                                      \
    X(NOT_ASKED, "not-asked")                                                                      \
    X(CARRIED, "carried")                                                                          \
    X(CONSISTENT, "consistent")                                                                    \
    X(ONE_SIDED, "one-sided")

enum vor_oriented {
#define VOR_ORIENTED_ENUM(id, word) VOR_ORIENTED_##id,
    VOR_ORIENTED_TABLE(VOR_ORIENTED_ENUM)
#undef VOR_ORIENTED_ENUM
        VOR_ORIENTED_COUNT
};

#define VOR_FIELD_ORIENTED(field) enum vor_oriented field;

/** What a run of any method may warn of, as it did what was asked and that came to little:
 *  identifier, what it is about (a parameter, or a member of the report), sentence. There is
 * another kind for each row of VOR_WHEN_TABLE. */
#define VOR_WARNING_KIND_TABLE(X)                                                                  \
    X(SIGMA_P, "sigmaP",                                                                           \
      "sigmaP is smaller than the distance between neighbouring points, so no point attracts or "  \
      "repels another point")                                                                      \
    X(ONE_SIDED, "orientation",                                                                    \
      "Some connected parts of the input have only one side, so their normals cannot be "          \
      "consistent")                                                                                \
    X(NOISE, "neighbors",                                                                          \
      "Noise hides parts of the surface, and no value of the parameter `neighbors` can show "      \
      "them. In these parts, the result may be farther from the surface than the input")           \
    X(NOT_RESTORED, "lattice",                                                                     \
      "Points were moved only where a grid was found and its cells are not smaller than a tenth "  \
      "of the spacing. The value counts these places, the threshold all places")                   \
    X(PITCHES, "lattice",                                                                          \
      "Parts of the input were rounded to different grids. The value is the width of the largest " \
      "grid cells, the threshold that of the smallest")

enum vor_warning_kind {
#define VOR_WARNING_ENUM(id, about, sentence) VOR_WARNING_##id,
    VOR_WARNING_KIND_TABLE(VOR_WARNING_ENUM)
#undef VOR_WARNING_ENUM
#define VOR_WARNING_UNUSED(parameter, name, other, words, when) VOR_WARNING_UNUSED_##parameter,
        VOR_WHEN_TABLE(VOR_WARNING_UNUSED)
#undef VOR_WARNING_UNUSED
            VOR_WARNING_COUNT
};

#define VOR_FIELD_WARNING_SAYS(field) enum vor_warning_kind field;

/** A warning. */
#define VOR_WARNING_TABLE(X)                                                                       \
    X(TEXT, about, "about", "",                                                                    \
      "Subject of the warning: the name of a parameter or of a member of the report")              \
    X(REAL, value, "value", "",                                                                    \
      "The number that the warning is about: the value of a parameter or member, in its unit, "    \
      "or a count of points, places or parts; null if the warning is about a parameter that had "  \
      "no effect")                                                                                 \
    X(REAL, limit, "limit", "",                                                                    \
      "Threshold of the warning, in the unit of the member `value`; null if the warning is "       \
      "about a parameter that had no effect")                                                      \
    X(WARNING_SAYS, says, "says", "", "Text of the warning")

struct vor_warning {
    VOR_WARNING_TABLE(VOR_FIELD)
};

/** A list of warnings, each kind at most once. */
#define VOR_FIELD_WARNINGS(field)                                                                  \
    struct vor_warning field[VOR_WARNING_COUNT];                                                   \
    unsigned field##_count;

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
    X(TEXT, name, "name", "",                                                                      \
      "Name of the attribute: `normal` for the normals, `color` for the colours")                  \
    X(TEXT, type, "type", "", "Type of the scalars: int8 to uint64, float32 or float64")           \
    X(U32, components, "components", "", "Number of scalars for each point")

struct vor_column {
    VOR_COLUMN_TABLE(VOR_FIELD)
};

#define VOR_FIELD_COLUMNS(field)                                                                   \
    struct vor_column field[VOR_ATTRIBUTES_MAX];                                                   \
    unsigned field##_count;

/** A loop of edges that have one triangle: where a mesh ends. */
#define VOR_MESH_LOOP_TABLE(X)                                                                     \
    X(U64, edges, "edges", "", "Number of edges of the loop")                                      \
    X(REAL, length, "length", "unit of the cloud", "Length of the loop")                           \
    X(VECTOR, middle, "middle", "unit of the cloud", "Mean position of the points of the loop")

struct vor_mesh_loop {
    VOR_MESH_LOOP_TABLE(VOR_FIELD)
};

/** Most loops that are told one by one. */
#define VOR_MESH_LOOPS_TOLD 32
#define VOR_FIELD_MESH_LOOPS(field)                                                                \
    struct vor_mesh_loop field[VOR_MESH_LOOPS_TOLD];                                               \
    unsigned field##_count;

/** What a loop of border points goes around. */
enum vor_loop_kind { VOR_LOOP_HOLE, VOR_LOOP_RIM };

#define VOR_FIELD_LOOP_KIND(field) enum vor_loop_kind field;

/** What became of a loop where holes are filled. */
enum vor_hole_outcome {
    VOR_HOLE_FILLED,
    VOR_HOLE_RIM,
    VOR_HOLE_TOO_LONG,
    VOR_HOLE_NOT_CHOSEN,
    VOR_HOLE_NOT_CLOSED
};

#define VOR_FIELD_HOLE_OUTCOME(field) enum vor_hole_outcome field;

/** A loop of border points, and what became of it. */
#define VOR_HOLE_TABLE(X)                                                                          \
    X(U32, id, "id", "", "Number that identifies the loop, as in the output of inspect")           \
    X(LOOP_KIND, kind, "kind", "", "Kind of the loop, as in the output of inspect")                \
    X(HOLE_OUTCOME, outcome, "outcome", "",                                                        \
      "What happened to the loop. filled: it was filled; rim: it is an outer border, and "         \
      "holes=auto fills only holes; too-long: it is longer than the parameter holeMax; "           \
      "not-chosen: its number is not in the parameter `holes`; not-closed: no surface was found "  \
      "that closes it, another part of the input is in the way, or time ran out")                  \
    X(REAL, length, "length", "unit of the cloud", "Length of the loop")                           \
    X(VECTOR, centre, "centre", "unit of the cloud",                                               \
      "Centroid of the closed line through the points of the loop, in the coordinates of the "     \
      "cloud")                                                                                     \
    X(U64, points, "points", "points", "Number of points added to fill the loop")

struct vor_hole_told {
    VOR_HOLE_TABLE(VOR_FIELD)
};

/** Most loops that are told one by one; if there are more, those that were not closed come first.
 */
#define VOR_HOLES_TOLD 100
#define VOR_FIELD_HOLES(field)                                                                     \
    struct vor_hole_told field[VOR_HOLES_TOLD];                                                    \
    unsigned field##_count;

/** How far the Voronoi cells of points are from regular hexagons (metrics/cells.h). */
#define VOR_CELLS_TABLE(X, object)                                                                 \
    X(REAL, eta, object "eta", "",                                                                 \
      "Energy of the Voronoi tessellation divided by the energy of the same number of regular "    \
      "hexagons, minus 1; lower is better")                                                        \
    X(REAL, gap, object "gap", "",                                                                 \
      "Largest distance from any place on the surface to the nearest point, divided by the "       \
      "spacing of a hexagonal lattice with the same number of points (0.577 is the lowest "        \
      "possible value)")                                                                           \
    X(U64, wide, object "wide", "places",                                                          \
      "Number of gaps: places of the surface that are farther than 0.64 spacings from the "        \
      "nearest point")                                                                             \
    X(U64, open, object "open", "points",                                                          \
      "Number of points without a closed Voronoi cell, such as points along a border. These "      \
      "points do not count in the members `eta`, `gap` and `wide`")

/** How far an input is from the surface of a result (metrics/mls_error.h). */
#define VOR_MLS_ERROR_TABLE(X)                                                                     \
    X(OPTIONAL, has_mls_error, "mls_error", "",                                                    \
      "Geometric error of Lv 2022: distances from points of the input (of the reference in "       \
      "measure) to a smooth surface through the points of the result (moving least squares), "     \
      "divided by half of the longest side of the input's bounding box. In a report, at most "     \
      "10000 points of the input are measured, and the largest error may be too low. Absent if "   \
      "the result has fewer than 13 points, and if there is nothing to compare it with")           \
    X(REAL, mls_error_max, "mls_error.max", "", "Largest error")                                   \
    X(REAL, mls_error_mean, "mls_error.mean", "", "Mean error")

/** Step by step, as in Lv 2022: how good the triangles are that join the points (Fig. 25), and how
 *  far a cloud is from its reference (Fig. 26). */
#define VOR_RECORD_LV2022_TABLE(X)                                                                 \
    X(REAL, quality, "quality", "",                                                                \
      "Mean quality of the triangles that join the points, computed as mesh.quality_mean in the "  \
      "report. Only the iterations of method=isotropic join them: without iterations, it is 0. "   \
      "During the polish, it keeps its value from the last iteration")                             \
    X(REAL, angle, "angle", "degrees",                                                             \
      "Mean, over these triangles, of the smallest angle: 60 if all edges have the same length "   \
      "(see quality)")                                                                             \
    X(REAL, mse, "mse", "unit of the reference^2",                                                 \
      "In the stage align, mean squared distance to the reference in the best pose so far, "       \
      "computed as registration.mse in the report; it may rise in the last step, which moves all " \
      "points towards planes, not samples. 0 in other stages")

/** Sharp edges of an input, found in another way (metrics/vcm.h). */
#define VOR_VCM_TABLE(X)                                                                           \
    X(OPTIONAL, has_vcm, "vcm", "",                                                                \
      "Sharp edges by the Voronoi covariance measure (VCM); only with vcm=true. Unlike "           \
      "edges.points, this counts all points within about two spacings of an edge, and points at "  \
      "borders")                                                                                   \
    X(U64, vcm_points, "vcm.points", "points", "Number of points that lie on edges by VCM")        \
    X(U64, vcm_common, "vcm.common", "points", "How many of them edges.points counts, too")

/** Why the pose of a registered cloud may be wrong: identifier, word. */
#define VOR_DOUBT_TABLE(X)                                                                         \
    X(NONE, "none")                                                                                \
    X(SLIDE, "free-slide")                                                                         \
    X(TURN, "free-turn")                                                                           \
    X(SCALE, "free-scale")                                                                         \
    X(POSE, "another-pose")                                                                        \
    X(CONFLICT, "conflict")                                                                        \
    X(OVERLAP, "little-overlap")                                                                   \
    X(IMPRECISE, "imprecise")

enum vor_doubt {
#define VOR_DOUBT_ENUM(id, word) VOR_DOUBT_##id,
    VOR_DOUBT_TABLE(VOR_DOUBT_ENUM)
#undef VOR_DOUBT_ENUM
        VOR_DOUBT_COUNT
};

#define VOR_FIELD_DOUBT(field) enum vor_doubt field;
#define VOR_FIELD_MATRIX(field) double field[16];
#define VOR_FIELD_AXIS(field) double field[3];

/** Where a registered cloud might lie. */
#define VOR_RUNNER_UP_TABLE(X)                                                                     \
    X(MATRIX, transform, "transform", "", "As registration.transform")                             \
    X(REAL, score, "score", "", "As registration.score")

struct vor_runner_up {
    VOR_RUNNER_UP_TABLE(VOR_FIELD)
};

#define VOR_FIELD_RUNNER_UP(field) struct vor_runner_up field;

/** How a registered cloud lies on its reference. */
#define VOR_REGISTRATION_TABLE(X)                                                                  \
    X(OPTIONAL, has_pose, "registration", "",                                                      \
      "Pose of the cloud on the reference; present only for the process register")                 \
    X(MATRIX, transform, "registration.transform", "",                                             \
      "4 x 4 matrix that moves a point (x, y, z, 1) of the cloud onto the reference; listed row "  \
      "by row")                                                                                    \
    X(REAL, pose_scale, "registration.scale", "",                                                  \
      "Factor by which the transform scales (1 with scale=fixed)")                                 \
    X(REAL, pose_rms, "registration.rms", "unit of the reference",                                 \
      "Root mean square of the distances from points of the moved cloud to the surface of the "    \
      "reference. The points are evenly spread over the region where the two clouds overlap")      \
    X(REAL, pose_mse, "registration.mse", "unit of the reference^2",                               \
      "Mean square distance: the square of the member `rms`, in squared units of the reference")   \
    X(REAL, pose_overlap, "registration.overlap", "",                                              \
      "Share of the cloud's surface that lies on the reference")                                   \
    X(REAL, pose_covered, "registration.covered", "",                                              \
      "Share of the reference's surface that the cloud lies on")                                   \
    X(REAL, pose_conflict, "registration.conflict", "",                                            \
      "Mismatch where the clouds overlap: share of the points over the inside of the other "       \
      "cloud's surface that do not lie on it; mean of the two clouds (0 if all overlapping parts " \
      "agree)")                                                                                    \
    X(REAL, pose_trust, "registration.trust", "",                                                  \
      "How far the pose can be trusted, from 0 to 1; if trust is below 0.5, look at the result "   \
      "before you use it")                                                                         \
    X(DOUBT, pose_doubt, "registration.reason", "",                                                \
      "Why trust is below 0.5, or none if trust is 0.5 or more. free-slide: the cloud can slide "  \
      "along the direction in the member `axis` and fits equally well; free-turn: it can turn "    \
      "about this axis; free-scale: it fits equally well at another scale; another-pose: where "   \
      "the clouds overlap, the pose in runner_up fits nearly as well; conflict: overlapping "      \
      "parts differ; little-overlap: too little of the clouds overlaps; imprecise: parts of the "  \
      "points lead to other poses than all of them, as there are too few or too sparse ones")      \
    X(AXIS, pose_axis, "registration.axis", "",                                                    \
      "Direction in which the cloud can slide, or axis about which it can turn: a unit vector "    \
      "in the coordinates of the reference. It is 0,0,0 if the member `reason` is neither "        \
      "free-slide nor free-turn")                                                                  \
    X(REAL, pose_score, "registration.score", "",                                                  \
      "Score of the pose (higher is better): the mean of the share of the cloud's points that "    \
      "lie on the reference and the share of the reference's points that lie on the cloud. "       \
      "It is reduced where the clouds contradict each other, or lie on each other less closely "   \
      "than their own noise")                                                                      \
    X(RUNNER_UP, runner_up, "registration.runner_up", "",                                          \
      "Of the other poses that were found, the one that casts most doubt on this pose; all "       \
      "members are 0 if there is no such pose")

/** How even the points of a simple method are, and how far from the input. */
#define VOR_BASELINE_TABLE(X)                                                                      \
    X(U64, points, "points", "points",                                                             \
      "Number of points: as many as the result has, or as many as the input has if that is "       \
      "fewer. A voxel grid gives only approximately this number of points")                        \
    X(REAL, delta, "delta", "", "delta of the points of this method, computed as for the result")  \
    X(REAL, sigma, "sigma", "unit of the cloud",                                                   \
      "sigma of the points of this method, computed as for the result")                            \
    X(REAL, epsilon, "epsilon", "",                                                                \
      "epsilon of the points that this method made, computed as for the result")                   \
    X(REAL, spacing, "spacing", "unit of the cloud", "Mean distance to the nearest neighbour")     \
    X(REAL, six_share, "six_share", "", "Share of the points that have six Voronoi neighbours")    \
    X(APART, ref_to_out, "ref_to_out", "",                                                         \
      "Distances from the input to the points that this method made, computed like the member "    \
      "`ref_to_out` of the report")

struct vor_baseline {
    VOR_BASELINE_TABLE(VOR_FIELD)
};

#define VOR_FIELD_BASELINE(field) struct vor_baseline field;

#endif
