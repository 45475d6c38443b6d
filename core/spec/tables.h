/** What can be asked for: the tables of parameters and of processes. The command line, the query
 *  string, JSON, the process descriptions, the routes and the docs all read them. Included through
 *  core/spec.h. */
#ifndef VOR_SPEC_TABLES_H
#define VOR_SPEC_TABLES_H

#include "core/base/extensions.h"

#include <stddef.h>
#include <stdint.h>

/** Forms: the ways in which one value may be written. */
enum vor_form {
    VOR_FORM_WHOLE,  /**< a whole number; as text, k or M may end it: thousands, millions */
    VOR_FORM_REAL,   /**< a finite number */
    VOR_FORM_CHOICE, /**< one of the words; the value is its index */
    VOR_FORM_WORD,   /**< one of the words beside a number; the value is VOR_WORD(index) */
    VOR_FORM_NAME,   /**< a word that ends in :NAME, with a name for NAME; the value is its index */
    VOR_FORM_VECTOR, /**< X,Y,Z, three numbers; the value is VOR_VECTOR, they stand in the text */
    VOR_FORM_FLAG,   /**< true or false; 1 or 0 */
    VOR_FORM_TEXT,   /**< UTF-8 without control characters; the value is 1 */
    VOR_FORM_LIST,   /**< some of the words, or "none"; bit i of the value is word i */
    VOR_FORM_COUNTS, /**< whole numbers, each once; the value is VOR_COUNTS; they are in the text */
    VOR_FORM_AUTO,   /**< the word auto; the value is VOR_UNSET */
    VOR_FORM_NONE    /**< of a value that is not given; also the number of forms */
};

/** Kinds: how a parameter is written. Identifier, form, other form. */
#define VOR_KIND_TABLE(X)                                                                          \
    X(COUNT, WHOLE, NONE)                                                                          \
    X(REAL, REAL, NONE)                                                                            \
    X(CHOICE, CHOICE, NONE)                                                                        \
    X(FLAG, FLAG, NONE)                                                                            \
    X(TEXT, TEXT, NONE)                                                                            \
    X(LIST, LIST, NONE)                                                                            \
    X(CHOICE_OR_NAME, CHOICE, NAME)                                                                \
    X(CHOICE_OR_VECTOR, CHOICE, VECTOR)                                                            \
    X(COUNT_OR_AUTO, WHOLE, AUTO)                                                                  \
    X(REAL_OR_AUTO, REAL, AUTO)                                                                    \
    X(REAL_OR_WORD, REAL, WORD)                                                                    \
    X(LIST_OR_AUTO, LIST, AUTO)                                                                    \
    X(COUNTS_OR_AUTO, COUNTS, AUTO)

enum vor_kind {
#define VOR_KIND_ENUM(id, form, other) VOR_KIND_##id,
    VOR_KIND_TABLE(VOR_KIND_ENUM)
#undef VOR_KIND_ENUM
        VOR_KINDS
};

/** The value that means "auto" if the kind has that word, else "not given". Every range begins
 *  above it. */
#define VOR_UNSET (-1.0)

/** The value that means word number `index` of a REAL_OR_WORD. */
#define VOR_WORD(index) (-2.0 - (index))

/** The value that means the numbers of a vector, which stand in the text. */
#define VOR_VECTOR (-2.0)

/** The value that means whole numbers that stand in the text. */
#define VOR_COUNTS VOR_VECTOR

/** Groups: a process takes whole groups of parameters. Identifier, title in the help. */
#define VOR_GROUP_TABLE(X)                                                                         \
    X(TARGET, "How many points")                                                                   \
    X(SPREAD, "How points are spread")                                                             \
    X(CVT, "Iterations and polish")                                                                \
    X(LOP, "Edge-aware projection")                                                                \
    X(READ, "Reading the input")                                                                   \
    X(INPUT, "The input")                                                                          \
    X(FILTER, "Filters")                                                                           \
    X(OUTPUT, "The result")                                                                        \
    X(MESH, "Faces of the result")                                                                 \
    X(FORMAT, "File format")                                                                       \
    X(ALIGN, "Registration")                                                                       \
    X(MEASURE, "Measurement")                                                                      \
    X(INSPECT, "Inspection")                                                                       \
    VOR_EXTRA_GROUPS(X)

enum vor_group {
#define VOR_GROUP_ENUM(id, title) VOR_GROUP_##id,
    VOR_GROUP_TABLE(VOR_GROUP_ENUM)
#undef VOR_GROUP_ENUM
        VOR_GROUP_COUNT
};

/** Methods: identifier, word. The engine's table has a row for each, at the same index. */
#define VOR_METHOD_CHOICE_TABLE(X)                                                                 \
    X(CVT, "cvt")                                                                                  \
    X(KMEANS, "kmeans")                                                                            \
    X(WLOP, "wlop")                                                                                \
    X(EAR, "ear")                                                                                  \
    X(ISOTROPIC, "isotropic")                                                                      \
    X(INSERT, "insert")                                                                            \
    VOR_EXTRA_METHOD_CHOICES(X)

enum vor_method_choice {
#define VOR_METHOD_ENUM(id, word) VOR_METHOD_##id,
    VOR_METHOD_CHOICE_TABLE(VOR_METHOD_ENUM)
#undef VOR_METHOD_ENUM
        VOR_METHODS
};

#define VOR_METHOD_WORD(id, word) " " word
#define VOR_METHOD_WORDS VOR_METHOD_CHOICE_TABLE(VOR_METHOD_WORD)

/** Parameters: identifier, name, kind, group, unit, min, max, default, choices, sentence. min and
 *  max are the range of a number, also in a vector, or of the bytes of a text or a name. The
 * default VOR_UNSET means auto if the kind has that word, else that there is none; a text has no
 * default. Choices are words with blanks between. */
#define VOR_PARAMETER_TABLE(X)                                                                     \
    X(POINTS, points, COUNT, TARGET, "points", 1, 10000000, VOR_UNSET, "",                         \
      "Number of points of the result. A request may have only one of the parameters `points`, "   \
      "`ratio` and `spacing`")                                                                     \
    X(RATIO, ratio, REAL, TARGET, "", 1e-6, 16, VOR_UNSET, "",                                     \
      "Number of points of the result, divided by the number of points of the input. If a "        \
      "process has a default for this parameter, the default applies only to requests with "       \
      "neither `points` nor `spacing`")                                                            \
    X(SPACING, spacing, REAL, TARGET, "unit of the cloud", 1e-30, 1e30, VOR_UNSET, "",             \
      "Distance between neighbouring points of the result. The number of points is the area of "   \
      "the surface divided by (sqrt(3)/2 * spacing^2)")                                            \
    X(METHOD, method, CHOICE, SPREAD, "", 0, 0, VOR_METHOD_CVT, VOR_METHOD_WORDS,                  \
      "Method that spreads the points. cvt: centroidal Voronoi tessellation of the surface; "      \
      "wlop: weighted locally optimal projection, in which points repel each other and input "     \
      "points attract them; ear: edge-aware resampling (Huang 2013), which first moves points "    \
      "onto the surface, but away from sharp edges, then inserts points up to the edges; "         \
      "isotropic: isotropic remeshing (Lv 2022), which splits long edges of a "                    \
      "triangulation, collapses short ones and flips others; kmeans: a baseline that moves "       \
      "each point to the mean of the input points nearest to it; insert (only with the process "   \
      "upsample): the points of the input stay as they are, with the same positions, in their "    \
      "order, and as many new points as are missing follow them, equally many around each point "  \
      "of the input, but none around one far from others. A polish (see the parameter `polish`) "  \
      "follows every method but kmeans and insert. The result of kmeans is denser where the "      \
      "input is denser, and cannot have more points than the input")                               \
    X(PATCH, patch, CHOICE, SPREAD, "", 0, 0, VOR_PATCH_QUADRIC, "quadric plane",                  \
      "Kind of local surface that is fitted to the input. quadric: a curved surface; plane: a "    \
      "flat surface, as in Chen 2018, which rounds sharp edges")                                   \
    X(DENSITY, density, CHOICE_OR_NAME, SPREAD, "", 1, 63, VOR_DENSITY_UNIFORM,                    \
      "uniform curvature edges attribute:NAME",                                                    \
      "How the density of the result's points varies. uniform: equally dense everywhere; "         \
      "curvature: denser where the surface bends more; edges: denser along sharp edges (an "       \
      "error if the input has none); attribute:NAME: denser where this scalar attribute of the "   \
      "input is larger; its values must be 0 or more. The distance between neighbours is "         \
      "proportional to density^(-1/4)")                                                            \
    X(CONTRAST, contrast, REAL, SPREAD, "", 1, 100, 4, "",                                         \
      "Ratio of the largest to the smallest distance between neighbours. The parameter has an "    \
      "effect only if the parameter `density` is not uniform")                                     \
    X(GRADING, grading, REAL, SPREAD, "", 0.001, 1, 0.2, "",                                       \
      "How fast the distance between neighbours may change along the surface: largest change "     \
      "per unit of length. The parameter has an effect only if the parameter `density` is not "    \
      "uniform")                                                                                   \
    X(GROUPS, groups, CHOICE, SPREAD, "", 0, 0, VOR_GROUPS_NONE, "none 3 5",                       \
      "Number of groups of points with the same distance between neighbours (Lv 2022). none: the " \
      "distance changes smoothly with the density; 3 or 5: the surface is divided by density "     \
      "into groups of equal area, and the distances are in the ratio 1.5 : 1 : 0.6 or "            \
      "2 : 1.5 : 1 : 0.8 : 0.6, or closer together with a small `contrast`. The parameter "        \
      "`grading` limits how fast they change from one group to the next. With density=edges, "     \
      "the groups depend on the distance from the nearest edge. The parameter has an effect only " \
      "if the parameter `density` is not uniform")                                                 \
    X(METRIC, metric, CHOICE_OR_NAME, SPREAD, "", 1, 60, VOR_METRIC_ISOTROPIC,                     \
      "isotropic anisotropic attribute:NAME lp",                                                   \
      "Shape of the Voronoi cells around the points. isotropic: as long as wide; anisotropic: "    \
      "longer in the direction in which the surface bends less (length divided by width is the "   \
      "square root of the ratio of the principal curvatures); attribute:NAME: the shape of "       \
      "positive definite tensors in the input (six scalars NAME_xx, NAME_xy, NAME_xz, NAME_yy, "   \
      "NAME_yz, NAME_zz); lp: squares along the directions of principal curvature (the run "       \
      "minimises an L_p energy and has no polish)")                                                \
    X(MAX_ASPECT, maxAspect, REAL, SPREAD, "", 1, 10, 6, "",                                       \
      "Largest ratio of length to width of a Voronoi cell. This parameter has no effect with "     \
      "metric=isotropic")                                                                          \
    X(P, p, COUNT, SPREAD, "", 2, 8, 8, "",                                                        \
      "Exponent of the distances in the energy that metric=lp minimises. It must be even: 2 "      \
      "gives hexagonal cells, 8 gives square cells")                                               \
    X(CELLS, cells, CHOICE, SPREAD, "", 0, 0, VOR_CELLS_METRIC, "metric euclid",                   \
      "Kind of distance used to compute the Voronoi cells. metric: the distance that the "         \
      "parameter `metric` defines; euclid: the Euclidean distance, as in Chen 2018. With "         \
      "cells=euclid, the energy is still computed in the metric, and there is no polish. "         \
      "cells=euclid requires method=cvt and density=uniform")                                      \
    X(ITERATIONS, iterations, COUNT, CVT, "", 0, 10000, VOR_UNSET, "",                             \
      "Number of iterations. Default: up to 12; up to 100 without polish; up to 35 with "          \
      "method=kmeans, metric=lp or cells=euclid; 6 with method=isotropic, 18 without polish. "     \
      "On a smooth closed surface, the run starts with fewer points and splits them; then 1 "      \
      "with method=cvt, none with method=isotropic. The run stops earlier if further "             \
      "iterations would not spread the points more evenly. If given, the run starts with all "     \
      "points")                                                                                    \
    X(DELTA, delta, REAL, CVT, "", 0, 10, VOR_UNSET, "",                                           \
      "The run ends as soon as delta is this low. delta is the standard deviation of the "         \
      "distances to the nearest neighbour, divided by their mean")                                 \
    X(ETA, eta, REAL, CVT, "", 0, 10, VOR_UNSET, "",                                               \
      "The run ends as soon as eta is this low. eta = E / H - 1, where E is the energy of the "    \
      "Voronoi tessellation and H is the energy of as many regular hexagons as there are cells")   \
    X(MOVE_STOP, moveStop, REAL, CVT, "spacings", 0, 1, VOR_UNSET, "",                             \
      "The iterations of method=cvt end as soon as no point moves farther than this distance. 1 "  \
      "is the distance between neighbours in a perfectly even result")                             \
    X(SECONDS, seconds, REAL, CVT, "s", 0, 86400, VOR_UNSET, "", "Time limit of the run")          \
    X(NEIGHBORS, neighbors, COUNT_OR_AUTO, SPREAD, "points", 6, 500, VOR_UNSET, "",                \
      "Number of input points in the fit of each local surface. auto: the number depends on the "  \
      "noise in each region")                                                                      \
    X(ANDERSON, anderson, COUNT, CVT, "", 0, 16, VOR_UNSET, "",                                    \
      "Number of previous iterations that Anderson acceleration uses. 0: plain Lloyd iterations "  \
      "without acceleration. Default: momentum instead of Anderson acceleration")                  \
    X(POLISH, polish, COUNT, CVT, "", 0, 10000, 100, "",                                           \
      "Largest number of steps of the polish. The polish follows the iterations: points repel "    \
      "each other until the distances between them are more even. 0: no polish")                   \
    X(EVENNESS, evenness, CHOICE, CVT, "", 0, 0, VOR_EVENNESS_SPACING, "spacing cover",            \
      "Aim of the polish. spacing: all points are equally far from their nearest neighbours; "     \
      "cover: every place on the surface is close to a point. With evenness=cover, the second "    \
      "half of the polish moves each point towards the centroid of its Voronoi cell, and delta "   \
      "is about 0.04 instead of 0.02")                                                             \
    X(SIGMA_N, sigmaN, REAL, LOP, "degrees", 1, 90, 15, "",                                        \
      "Largest angle at which two normals still count as similar. A smaller angle also "           \
      "preserves blunt edges; a larger angle smooths more. The parameter has an effect only "      \
      "with method=ear")                                                                           \
    X(SIGMA_P, sigmaP, REAL_OR_WORD, LOP, "unit of the cloud", 1e-30, 1e30, VOR_WORD(0),           \
      "auto paper",                                                                                \
      "Distance up to which points attract or repel each other. auto: twice the distance "         \
      "between neighbouring points during the projection, or more if the input is noisy; paper: "  \
      "the diagonal of the input's bounding box divided by the square root of the number of "      \
      "input points. The parameter has an effect only with method=wlop or method=ear")             \
    X(MU, mu, REAL, LOP, "", 0, 0.499, 0.45, "",                                                   \
      "Strength of the repulsion between points of the result, relative to the attraction by "     \
      "input points. The parameter has an effect only with method=wlop or method=ear")             \
    X(ROUNDS, rounds, COUNT, LOP, "", 0, 20, 3, "",                                                \
      "Number of rounds of projection. With method=ear, each round smooths the normals before "    \
      "it projects the points. 0: the points stay at their initial positions, which are random. "  \
      "The parameter has an effect only with method=wlop or method=ear")                           \
    X(STEPS, steps, COUNT, LOP, "", 1, 100, VOR_UNSET, "",                                         \
      "Number of projection steps in each round. Default: 4 with method=ear if a polish "          \
      "follows, otherwise 12. The parameter has an effect only with method=wlop or method=ear")    \
    X(RHO, rho, REAL, LOP, "", 0, 20, 5, "",                                                       \
      "How strongly method=ear prefers places near sharp edges when it inserts points. With "      \
      "rho=0, points are inserted evenly everywhere")                                              \
    X(PHASES, phases, CHOICE, LOP, "", 0, 0, VOR_PHASES_BOTH, "both resample insert",              \
      "Phases of method=ear. resample: it only projects points onto the surface; insert: it "      \
      "only inserts points between the input points; both: it projects points, then inserts "      \
      "more")                                                                                      \
    X(SAMPLES, samples, COUNT_OR_AUTO, LOP, "points", 1, 10000000, VOR_UNSET, "",                  \
      "Number of points that method=ear starts with before it inserts more: projected points "     \
      "or, with phases=insert, input points. Points are inserted only if the result has more "     \
      "points than this. auto: half the number of input points (with phases=insert, the full "     \
      "number), or the number of points of the result if that is smaller")                         \
    X(GAPS, gaps, CHOICE, LOP, "", 0, 0, VOR_GAPS_KEEP, "keep fill",                               \
      "What method=ear does with gaps in the input that are wider than the distance between "      \
      "input points. keep: it leaves them empty; fill: it inserts points into them, each at "      \
      "most sigmaP from another point")                                                            \
    X(BOUNDARY, boundary, CHOICE, SPREAD, "", 0, 0, VOR_BOUNDARY_KEEP, "keep free sites fill",     \
      "Treatment of the borders of the input, the lines where its surface ends. keep: no point "   \
      "moves beyond a border; free: points may move beyond a border; sites: the first points "     \
      "are placed evenly along the borders and stay there; fill: holes are filled first, then "    \
      "the other borders are treated as with keep")                                                \
    X(HOLES, holes, COUNTS_OR_AUTO, SPREAD, "", 1, 10000000, VOR_UNSET, "",                        \
      "Numbers of the border loops that boundary=fill closes. Run inspect to list the loops "      \
      "with their numbers. These loops may be holes or outer borders (rims). auto: all holes "     \
      "with a border that is shorter than the parameter holeMax")                                  \
    X(HOLE_MAX, holeMax, REAL_OR_AUTO, SPREAD, "unit of the cloud", 1e-30, 1e30, VOR_UNSET, "",    \
      "holes=auto fills only holes with a border that is shorter than this length. "               \
      "holeMax=auto: the diagonal of the input's bounding box")                                    \
    X(EDGES, edges, CHOICE, SPREAD, "", 0, 0, VOR_EDGES_IGNORE, "ignore sites",                    \
      "Treatment of the sharp edges of the input. ignore: no special treatment; sites: the "       \
      "first points are placed evenly along the edges and stay there")                             \
    X(COHERENCE, coherence, REAL, SPREAD, "", 0, 1, VOR_UNSET, "",                                 \
      "How much of the previous result is kept. 1: points move as far as the surface and an "      \
      "even spread need, but not with noise; less: they move more, in more iterations; 0: all "    \
      "points are new. Default: 1. If it is given without a previous result, the cloud is the "    \
      "first one of a sequence: the points of the result are numbered in the attribute track")     \
    X(OUTLIERS, outliers, CHOICE, INPUT, "", 0, 0, VOR_UNSET, "keep drop pull",                    \
      "Treatment of outliers: input points off the surface, isolated or scattered. keep: they "    \
      "are used like all other points, with method=ear or very far away as islands; drop: they "   \
      "are ignored; pull: they are moved onto the surface. Default: drop for denoise, for "        \
      "inspect, and for any process with method=ear; otherwise keep")                              \
    X(SAMPLE, sample, CHOICE, FILTER, "", 0, 0, VOR_SAMPLE_VERTICES, "vertices faces",             \
      "Which part of a mesh is resampled. vertices: the vertices of the mesh; faces: points "      \
      "drawn evenly from its faces, at least eight for each point of the result; an input "        \
      "without faces is an error")                                                                 \
    X(FILTERS, filters, LIST, FILTER, "", 0, 0, 0, "mls outliers thin",                            \
      "Filters that are applied to the input, always in the order outliers, mls, thin. "           \
      "outliers: drops outliers or, with outliers=pull, moves them onto the surface; mls: moves "  \
      "each point onto a smooth surface fitted around it; thin: drops points until no two are "    \
      "closer together than the mean distance, over all points, from a point to its three "        \
      "nearest neighbours. If a request has the filter mls or outliers and none of the "           \
      "parameters `points`, `ratio` and `spacing`, its result is the filtered input: the points "  \
      "of the input in their order, with their attributes. upsample never returns the filtered "   \
      "input itself, because its parameter `ratio` always has a value. The process `denoise` "     \
      "applies the filters `outliers` and `mls` by default, but not with method=wlop or ear")      \
    X(INPUT_NORMALS, inputNormals, CHOICE, OUTPUT, "", 0, 0, VOR_INPUT_NORMALS_AUTO,               \
      "auto use estimate",                                                                         \
      "How the normals of the input are used. use: fitted normals are oriented like the normals "  \
      "of the input; estimate: the normals of the input are ignored; auto: like "                  \
      "inputNormals=use if all normals of the input are finite and non-zero, otherwise each "      \
      "connected part is oriented by its valid normals. With use and auto, the normals also show " \
      "that two nearby layers of the surface face each other")                                     \
    X(INTRINSIC, intrinsic, CHOICE, INPUT, "", 0, 0, VOR_INTRINSIC_LOCAL, "local satellites none", \
      "Rule that decides whether two nearby points lie on the same layer of the surface "          \
      "(sheet), such as one side of a thin wall. local: if a short path over points in between "   \
      "connects them; satellites: if they have similar distances along the surface from three "    \
      "reference points; none: any two nearby points count as points of the same layer")           \
    X(INVALID, invalid, CHOICE, READ, "", 0, 0, VOR_INVALID_REFUSE, "refuse drop",                 \
      "Treatment of input points with a coordinate that is not finite. refuse: the input is "      \
      "refused; drop: these points are left out and counted")                                      \
    X(SEED, seed, COUNT, SPREAD, "", 0, 9007199254740991, 1, "", "Seed of the random numbers")     \
    X(ORDER, order, CHOICE, OUTPUT, "", 0, 0, VOR_ORDER_SPATIAL, "spatial progressive",            \
      "Order of the points in the result. spatial: most points come directly before or after "     \
      "one of their neighbours; progressive: for every N, the first N points are spread evenly")   \
    X(LATTICE, lattice, CHOICE, OUTPUT, "", 0, 0, VOR_LATTICE_FREE, "free keep",                   \
      "Whether the points of the result lie on the grid that the coordinates of the input were "   \
      "rounded to, such as the centres of voxels. free: they lie anywhere on the surface; keep: "  \
      "they lie on that grid, no two at the same place; whole numbers stay whole numbers. It is "  \
      "an error if the input has no grid, or if the surface passes through too few grid cells. "   \
      "lattice=keep does not work with the process mesh. A Draco file keeps the grid exactly "     \
      "with quantization=0")                                                                       \
    X(FORMAT, format, CHOICE, FORMAT, "", 0, 0, VOR_UNSET, "ply drc",                              \
      "Format of the result. Default: the format given by the suffix of the output file or by "    \
      "the Accept header, otherwise the format of the input")                                      \
    X(QUANTIZATION, quantization, COUNT_OR_AUTO, FORMAT, "bits", 0, 30, VOR_UNSET, "",             \
      "Bits per coordinate in a Draco file. 0: positions are stored without loss; auto: the "      \
      "smallest number of bits that keeps the rounding step below 1/200 of the distance between "  \
      "neighbours")                                                                                \
    X(COMPRESSION, compression, COUNT, FORMAT, "", 0, 10, 7, "",                                   \
      "Compression level of Draco. 10 gives the smallest files")                                   \
    X(ORIGIN, origin, CHOICE_OR_VECTOR, FORMAT, "", -1e30, 1e30, VOR_ORIGIN_AUTO,                  \
      "auto absolute relative",                                                                    \
      "Point that the positions in a Draco file are relative to. absolute: 0,0,0; relative: a "    \
      "point with whole-number coordinates near the middle of the input; X,Y,Z: this point; "      \
      "auto: like origin=relative if float32 is too coarse for the coordinates of the input, "     \
      "otherwise like origin=absolute")                                                            \
    X(ATTRIBUTES, attributes, CHOICE, OUTPUT, "", 0, 0, VOR_ATTRIBUTES_NEAREST,                    \
      "nearest blend drop",                                                                        \
      "Attributes of the result. nearest: each point has the attributes of the nearest input "     \
      "point; blend: likewise, but colours are the mean of those of six input points around the "  \
      "point, weighted by 1/distance^2; drop: the result has only positions")                      \
    X(NORMALS, normals, CHOICE, OUTPUT, "", 0, 0, VOR_NORMALS_NEAREST,                             \
      "nearest oriented fit drop",                                                                 \
      "Normals of the result. nearest: copied from the nearest input point; oriented: copied "     \
      "and then oriented consistently or, if the input has no normals, computed as with fit; "     \
      "fit: normals of the fitted surface, on the side of the input's normals, or outward if "     \
      "the input has none; drop: no normals")                                                      \
    X(SOUP, soup, FLAG, MESH, "", 0, 0, 0, "",                                                     \
      "The faces of the result are the Voronoi cells around the points, not triangles between "    \
      "the points. The faces are polygons that share no vertices; in a Draco file they are cut "   \
      "into triangles")                                                                            \
    X(REPAIR, repair, CHOICE, MESH, "", 0, 0, VOR_REPAIR_NONE, "none auto",                        \
      "Repair of the triangulation. none: no repair; auto: around points that have more or fewer " \
      "than six triangles, edges are flipped, and a point is removed in one place and added in "   \
      "another, where that makes the triangles better, and then corners of the worst triangles "   \
      "move, and edges near them are flipped. The worst triangles become better, distances at "    \
      "creases a little less even, and the run takes up to 60 percent longer, on a rough scan up " \
      "to three times as long. Used only with a polish, density=uniform and metric=isotropic, "    \
      "not with a previous result or an input of several layers")                                  \
    X(BASELINES, baselines, FLAG, OUTPUT, "", 0, 0, 0, "",                                         \
      "Also run four simple methods on the same input and add their figures to the report: "       \
      "k-means, random sampling, voxel grid and farthest-point sampling")                          \
    X(PEAK, peak, REAL_OR_AUTO, MEASURE, "unit of the cloud", 1e-30, 1e30, VOR_UNSET, "",          \
      "Peak value in the formulas of d1_psnr and d2_psnr. auto: the largest distance from a "      \
      "reference point to its nearest neighbour")                                                  \
    X(SCALE, scale, CHOICE, ALIGN, "", 0, 0, VOR_SCALE_FIXED, "fixed free",                        \
      "Whether the cloud may be scaled. fixed: the cloud keeps its scale (right if both clouds "   \
      "have the same unit); free: register also finds the scale, which is reliable only if both "  \
      "clouds show the whole object")                                                              \
    X(OVERLAP, overlap, REAL_OR_AUTO, ALIGN, "", 0.1, 1, VOR_UNSET, "",                            \
      "Share of the cloud that has a counterpart in the reference. auto: the share is computed "   \
      "from the distances")                                                                        \
    X(VCM, vcm, FLAG, INSPECT, "", 0, 0, 0, "",                                                    \
      "Also find sharp edges by the Voronoi covariance measure (VCM), as Lv 2022 does. The run "   \
      "takes about 1.5 times as long, with noise up to 2.5 times")                                 \
    VOR_EXTRA_PARAMETERS(X)

enum vor_parameter {
#define VOR_PARAMETER_ENUM(id, name, kind, group, unit, min, max, def, choices, sentence)          \
    VOR_PARAM_##id,
    VOR_PARAMETER_TABLE(VOR_PARAMETER_ENUM)
#undef VOR_PARAMETER_ENUM
        VOR_PARAMETER_COUNT
};

enum { VOR_PATCH_QUADRIC, VOR_PATCH_PLANE };
enum { VOR_DENSITY_UNIFORM, VOR_DENSITY_CURVATURE, VOR_DENSITY_EDGES, VOR_DENSITY_ATTRIBUTE };
enum { VOR_GROUPS_NONE, VOR_GROUPS_3, VOR_GROUPS_5 };
/** Distances between neighbours in each group, from the lowest density to the highest, over that of
 *  an even spread: Lv 2022, Fig. 10, D and A. */
#define VOR_GROUPS_OF_3 1.5, 1, 0.6
#define VOR_GROUPS_OF_5 2, 1.5, 1, 0.8, 0.6
enum { VOR_METRIC_ISOTROPIC, VOR_METRIC_ANISOTROPIC, VOR_METRIC_ATTRIBUTE, VOR_METRIC_LP };
enum { VOR_CELLS_METRIC, VOR_CELLS_EUCLID };
enum { VOR_EVENNESS_SPACING, VOR_EVENNESS_COVER };
enum { VOR_REPAIR_NONE, VOR_REPAIR_AUTO };
enum { VOR_LATTICE_FREE, VOR_LATTICE_KEEP };
enum { VOR_BOUNDARY_KEEP, VOR_BOUNDARY_FREE, VOR_BOUNDARY_SITES, VOR_BOUNDARY_FILL };
enum { VOR_EDGES_IGNORE, VOR_EDGES_SITES };
enum { VOR_OUTLIERS_KEEP, VOR_OUTLIERS_DROP, VOR_OUTLIERS_PULL };
enum { VOR_SAMPLE_VERTICES, VOR_SAMPLE_FACES };
enum { VOR_FILTER_MLS, VOR_FILTER_OUTLIERS, VOR_FILTER_THIN }; /* words of the list filters */
enum { VOR_INTRINSIC_LOCAL, VOR_INTRINSIC_SATELLITES, VOR_INTRINSIC_NONE };
enum { VOR_INVALID_REFUSE, VOR_INVALID_DROP };
enum { VOR_ORDER_SPATIAL, VOR_ORDER_PROGRESSIVE };
enum { VOR_FORMAT_PLY, VOR_FORMAT_DRC };
enum { VOR_ORIGIN_AUTO, VOR_ORIGIN_ABSOLUTE, VOR_ORIGIN_RELATIVE };
enum { VOR_ATTRIBUTES_NEAREST, VOR_ATTRIBUTES_BLEND, VOR_ATTRIBUTES_DROP };
enum { VOR_SIGMA_P_AUTO, VOR_SIGMA_P_PAPER }; /* words of the number sigmaP */
enum { VOR_PHASES_BOTH, VOR_PHASES_RESAMPLE, VOR_PHASES_INSERT };
enum { VOR_GAPS_KEEP, VOR_GAPS_FILL };
enum { VOR_NORMALS_NEAREST, VOR_NORMALS_ORIENTED, VOR_NORMALS_FIT, VOR_NORMALS_DROP };
enum { VOR_SCALE_FIXED, VOR_SCALE_FREE };
enum { VOR_INPUT_NORMALS_AUTO, VOR_INPUT_NORMALS_USE, VOR_INPUT_NORMALS_ESTIMATE };

/** One row of the table of parameters. */
struct vor_parameter_info {
    const char *name;
    enum vor_kind kind;
    enum vor_group group;
    const char *unit;    /**< "" for none */
    double min, max;     /**< inclusive: of a number, also in a vector, or of a text's bytes */
    double fallback;     /**< default */
    const char *choices; /**< words with blanks between; "" for none */
    const char *sentence;
    uint64_t allowed; /**< bit i: choice i may be taken */
};

/** What goes into a run and comes out of it. */
enum vor_artefact_kind { VOR_ARTEFACT_CLOUD, VOR_ARTEFACT_DOCUMENT };

/** A named input or output of a process. */
struct vor_artefact_info {
    const char *name; /**< NULL ends a list */
    enum vor_artefact_kind kind;
    int is_required; /**< of an input; an output always comes */
    const char *sentence;
};

#define VOR_INPUTS_MAX 4
#define VOR_OUTPUTS_MAX 4

/** Lists of inputs and of outputs, the main one first; in parentheses, as they have commas. */
#define VOR_LIST(...)                                                                              \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
#define VOR_CLOUD_SENTENCE                                                                         \
    "The point cloud. Its format is detected from the data. Over HTTP, the cloud is the body of "  \
    "the request or a part of a form"
#define VOR_CLOUD_IN ({"cloud", VOR_ARTEFACT_CLOUD, 1, VOR_CLOUD_SENTENCE})
/* A frame of a sequence of clouds, which may be its only one. */
#define VOR_FRAME_IN                                                                               \
    ({"cloud", VOR_ARTEFACT_CLOUD, 1, VOR_CLOUD_SENTENCE},                                         \
     {"previous", VOR_ARTEFACT_CLOUD, 0,                                                           \
      "Result for the previous frame, in a sequence of clouds: points start where they were and "  \
      "keep their number, in the attribute track. Over HTTP, it is a part of a form"})
#define VOR_CLOUD_AND_REFERENCE_IN                                                                 \
    ({"cloud", VOR_ARTEFACT_CLOUD, 1, VOR_CLOUD_SENTENCE},                                         \
     {"reference", VOR_ARTEFACT_CLOUD, 0,                                                          \
      "Reference cloud. Distances are measured from the cloud to the reference and back. Over "    \
      "HTTP, the reference is a part of a form"})
#define VOR_CLOUD_ONTO_REFERENCE_IN                                                                \
    ({"cloud", VOR_ARTEFACT_CLOUD, 1,                                                              \
      "The point cloud that is moved. Its format is detected from the data. Over HTTP, the "       \
      "cloud is a part of a form"},                                                                \
     {"reference", VOR_ARTEFACT_CLOUD, 1,                                                          \
      "Reference cloud: the other cloud is moved onto it. Over HTTP, the reference is a part of "  \
      "a form"})
#define VOR_CLOUD_OUT                                                                              \
    ({"cloud", VOR_ARTEFACT_CLOUD, 1, "The resulting cloud"},                                      \
     {"report", VOR_ARTEFACT_DOCUMENT, 1, "Report: what the run did, and how even the result is"})
#define VOR_MEASURE_OUT                                                                            \
    ({"measure", VOR_ARTEFACT_DOCUMENT, 1,                                                         \
      "How evenly the cloud is spread and, with a reference, how far the two clouds are apart"})
#define VOR_INSPECT_OUT                                                                            \
    ({"inspect", VOR_ARTEFACT_DOCUMENT, 1,                                                         \
      "Properties of the cloud: parts, spacing, noise, layers of the surface"})

/** Sets of groups and of methods. */
#define VOR_IN(group) (1u << VOR_GROUP_##group)
#define VOR_BY(method) (1u << VOR_METHOD_##method)
#define VOR_SPREAD_GROUPS                                                                          \
    (VOR_IN(TARGET) | VOR_IN(SPREAD) | VOR_IN(CVT) | VOR_IN(LOP) | VOR_IN(INPUT) |                 \
     VOR_IN(FILTER) | VOR_IN(READ) | VOR_IN(OUTPUT) | VOR_IN(FORMAT))
#define VOR_EVERY_METHOD (~VOR_BY(INSERT))

/** Processes: identifier, id, whether HTTP offers it (1 or 0), groups of parameters that it takes,
 * methods that it may use, least and most points of the result over those of the input (0, 0
 * without the group TARGET), inputs, outputs, title, sentence. core/engine.c says which function
 * runs it. */
#define VOR_PROCESS_TABLE(X)                                                                       \
    X(RESAMPLE, resample, 1, VOR_SPREAD_GROUPS, VOR_EVERY_METHOD, 0, 16, VOR_FRAME_IN,             \
      VOR_CLOUD_OUT, "Resample a point cloud",                                                     \
      "Spreads exactly the requested number of points evenly over the surface of the input")       \
    X(DENOISE, denoise, 1, VOR_SPREAD_GROUPS, VOR_EVERY_METHOD, 0, 16, VOR_FRAME_IN,               \
      VOR_CLOUD_OUT, "Denoise a point cloud",                                                      \
      "Removes the noise and outliers of the input, then spreads points evenly over its "          \
      "surface: the requested number or, by default, as many as the input has")                    \
    X(UPSAMPLE, upsample, 1, VOR_SPREAD_GROUPS, ~VOR_BY(KMEANS), 1, 16, VOR_FRAME_IN,              \
      VOR_CLOUD_OUT, "Upsample a point cloud",                                                     \
      "Spreads points evenly over the surface of the input: the requested number or, by "          \
      "default, four times as many as the input has")                                              \
    X(SIMPLIFY, simplify, 1, VOR_SPREAD_GROUPS, VOR_EVERY_METHOD, 0, 1, VOR_FRAME_IN,              \
      VOR_CLOUD_OUT, "Simplify a point cloud",                                                     \
      "Spreads points evenly over the surface of the input: exactly the requested number, which "  \
      "cannot be larger than the number of points of the input")                                   \
    X(MEASURE, measure, 1, VOR_IN(READ) | VOR_IN(MEASURE), 0, 0, 0, VOR_CLOUD_AND_REFERENCE_IN,    \
      VOR_MEASURE_OUT, "Measure a point cloud",                                                    \
      "Measures how evenly a cloud is spread and, if a reference is given, how far apart the "     \
      "cloud and the reference are")                                                               \
    X(INSPECT, inspect, 1, VOR_IN(READ) | VOR_IN(INPUT) | VOR_IN(INSPECT), 0, 0, 0, VOR_CLOUD_IN,  \
      VOR_INSPECT_OUT, "Inspect a point cloud",                                                    \
      "Describes a cloud: its parts, spacing, noise, layers, sharp edges, borders and holes")      \
    X(CONVERT, convert, 1, VOR_IN(READ) | VOR_IN(FORMAT), 0, 0, 0, VOR_CLOUD_IN, VOR_CLOUD_OUT,    \
      "Convert a point cloud",                                                                     \
      "Writes a cloud, with its attributes and faces, in another format or in the same format. "   \
      "Positions do not change, except that the format may round them")                            \
    X(MESH, mesh, 1, VOR_SPREAD_GROUPS | VOR_IN(MESH), VOR_EVERY_METHOD, 0, 16, VOR_FRAME_IN,      \
      VOR_CLOUD_OUT, "Mesh a point cloud",                                                         \
      "Spreads points like the process resample, then joins them into a manifold triangle "        \
      "mesh that faces outward")                                                                   \
    X(RESTORE, restore, 1, VOR_IN(READ) | VOR_IN(FORMAT), 0, 0, 0, VOR_CLOUD_IN, VOR_CLOUD_OUT,    \
      "Restore a decoded point cloud",                                                             \
      "Moves the points of a cloud back towards the surface after a codec rounded them to a "      \
      "grid. Each point stays within its grid cell; order, attributes and faces stay the same")    \
    X(REGISTER, register, 1, VOR_IN(READ) | VOR_IN(ALIGN) | VOR_IN(FORMAT), 0, 0, 0,               \
      VOR_CLOUD_ONTO_REFERENCE_IN, VOR_CLOUD_OUT, "Register two point clouds",                     \
      "Moves a cloud onto a reference that shows the same object or parts of it, from any pose, "  \
      "and says how far the result can be trusted")                                                \
    VOR_EXTRA_PROCESSES(X)

/** Defaults of a process that differ from the table of parameters: process, parameter, value. That
 *  of ratio holds only if none of points, ratio and spacing is given; a default of 1 not where
 *  filters alone make the result either (vor_spec_only_filters). */
#define VOR_PRESET_TABLE(X)                                                                        \
    X(DENOISE, RATIO, 1)                                                                           \
    X(DENOISE, OUTLIERS, VOR_OUTLIERS_DROP)                                                        \
    X(INSPECT, OUTLIERS, VOR_OUTLIERS_DROP)                                                        \
    X(UPSAMPLE, RATIO, 4)                                                                          \
    X(UPSAMPLE, ITERATIONS, 1)                                                                     \
    X(UPSAMPLE, POLISH, 12)                                                                        \
    X(UPSAMPLE, ATTRIBUTES, VOR_ATTRIBUTES_BLEND)                                                  \
    X(MESH, POLISH, 120)                                                                           \
    VOR_EXTRA_PRESETS(X)

/** Parameters that mean nothing without an optional input: parameter, name of the input. */
#define VOR_NEED_TABLE(X)                                                                          \
    X(PEAK, "reference")                                                                           \
    VOR_EXTRA_NEEDS(X)

/** One row of the table of processes. */
struct vor_process_info {
    const char *id;
    int on_http;                 /**< HTTP offers it */
    unsigned groups, methods;    /**< bit i: takes group i, may use method i */
    double ratio_min, ratio_max; /**< points of the result over those of the input, inclusive */
    struct vor_artefact_info inputs[VOR_INPUTS_MAX + 1];   /**< at least one, required */
    struct vor_artefact_info outputs[VOR_OUTPUTS_MAX + 1]; /**< at least one */
    const char *title, *sentence;
};

/** Process number `index`, NULL past the last; vor_process_find by id, NULL when there is none. */
const struct vor_process_info *vor_process_info(unsigned index);
const struct vor_process_info *vor_process_find(const char *id);

/** The input or output of that name in a list that ends with a name of NULL; NULL when there is
 *  none. */
const struct vor_artefact_info *vor_artefact_find(const struct vor_artefact_info *list,
                                                  const char *name);

/** True when the process takes the parameter. */
int vor_process_takes(const struct vor_process_info *process, enum vor_parameter parameter);

/** Row of the table of parameters. */
const struct vor_parameter_info *vor_parameter_info(enum vor_parameter parameter);

/** The same row as a process has it: with its default, its range of ratio and its methods. */
struct vor_parameter_info vor_process_parameter(const struct vor_process_info *process,
                                                enum vor_parameter parameter);

/** Finds a parameter by name; VOR_PARAMETER_COUNT when there is none. */
enum vor_parameter vor_parameter_find(const char *name);

/** The input without which a parameter means nothing (VOR_NEED_TABLE); NULL if it needs none. */
const char *vor_parameter_needs(enum vor_parameter parameter);

/** Title of a group, for the help. */
const char *vor_group_title(enum vor_group group);

/** Word number `index` of the row's choices, allowed or not, as "%.*s" arguments: returns its
 * length, 0 past the last. */
size_t vor_parameter_choice(const struct vor_parameter_info *info, unsigned index,
                            const char **word);

/** True when a list has word number `index`. */
int vor_list_has(double value, unsigned index);

/** Form number `index` of a kind; VOR_FORM_NONE past the last. */
enum vor_form vor_kind_form(enum vor_kind kind, unsigned index);

#endif
