/** What people are shown of a request: titles and levels of parameters, and presets. Included
 *  through core/spec.h. */
#ifndef VOR_SPEC_SHOWN_H
#define VOR_SPEC_SHOWN_H

#include "core/spec/tables.h"

/** Levels: identifier, word, title in the help. A form shows the basic ones, and the others when it
 *  is asked for them. */
#define VOR_LEVEL_TABLE(X)                                                                         \
    X(BASIC, "basic", "Parameters of the request")                                                 \
    X(ADVANCED, "advanced", "Advanced parameters")

enum vor_level {
#define VOR_LEVEL_ENUM(id, word, title) VOR_LEVEL_##id,
    VOR_LEVEL_TABLE(VOR_LEVEL_ENUM)
#undef VOR_LEVEL_ENUM
        VOR_LEVELS
};

/** Titles: parameter, level, a few words. A parameter without a row is advanced, and its name is
 *  its title. */
#define VOR_TITLE_TABLE(X)                                                                         \
    X(POINTS, BASIC, "Points")                                                                     \
    X(RATIO, BASIC, "Ratio to the input's points")                                                 \
    X(SPACING, BASIC, "Spacing")                                                                   \
    X(METHOD, ADVANCED, "Method")                                                                  \
    X(PATCH, ADVANCED, "Local surface")                                                            \
    X(DENSITY, BASIC, "Density")                                                                   \
    X(CONTRAST, ADVANCED, "Contrast of the density")                                               \
    X(GRADING, ADVANCED, "Grading of the density")                                                 \
    X(GROUPS, ADVANCED, "Groups of the density")                                                   \
    X(METRIC, ADVANCED, "Shape of cells")                                                          \
    X(MAX_ASPECT, ADVANCED, "Longest cells")                                                       \
    X(P, ADVANCED, "Power of the metric")                                                          \
    X(CELLS, ADVANCED, "Distance for cells")                                                       \
    X(ITERATIONS, ADVANCED, "Iterations")                                                          \
    X(DELTA, ADVANCED, "Target delta")                                                             \
    X(ETA, ADVANCED, "Target eta")                                                                 \
    X(MOVE_STOP, ADVANCED, "Smallest move")                                                        \
    X(SECONDS, BASIC, "Time limit")                                                                \
    X(NEIGHBORS, ADVANCED, "Neighbors per fit")                                                    \
    X(ANDERSON, ADVANCED, "Anderson window")                                                       \
    X(POLISH, ADVANCED, "Steps of the polish")                                                     \
    X(EVENNESS, ADVANCED, "Kind of evenness")                                                      \
    X(BOUNDARY, BASIC, "Borders and holes")                                                        \
    X(HOLES, ADVANCED, "Holes to fill")                                                            \
    X(HOLE_MAX, ADVANCED, "Longest hole to fill")                                                  \
    X(EDGES, BASIC, "Sharp edges")                                                                 \
    X(COHERENCE, ADVANCED, "Coherence of a sequence")                                              \
    X(OUTLIERS, BASIC, "Outliers")                                                                 \
    X(SAMPLE, ADVANCED, "Resampled part of a mesh")                                                \
    X(FILTERS, BASIC, "Filters")                                                                   \
    X(SIGMA_N, ADVANCED, "Angle between normals")                                                  \
    X(SIGMA_P, ADVANCED, "Radius of the projection")                                               \
    X(MU, ADVANCED, "Repulsion")                                                                   \
    X(ROUNDS, ADVANCED, "Rounds of projection")                                                    \
    X(STEPS, ADVANCED, "Steps of a round")                                                         \
    X(RHO, ADVANCED, "Preference for edges")                                                       \
    X(PHASES, ADVANCED, "Phases")                                                                  \
    X(SAMPLES, ADVANCED, "Points before insertion")                                                \
    X(GAPS, ADVANCED, "Gaps")                                                                      \
    X(INPUT_NORMALS, ADVANCED, "Normals of the input")                                             \
    X(INTRINSIC, ADVANCED, "Sheets")                                                               \
    X(INVALID, ADVANCED, "Points that are not finite")                                             \
    X(SEED, ADVANCED, "Seed")                                                                      \
    X(ORDER, ADVANCED, "Order of points")                                                          \
    X(LATTICE, ADVANCED, "Grid of the input")                                                      \
    X(FORMAT, BASIC, "Format")                                                                     \
    X(QUANTIZATION, ADVANCED, "Quantization")                                                      \
    X(COMPRESSION, ADVANCED, "Compression")                                                        \
    X(ORIGIN, ADVANCED, "Origin")                                                                  \
    X(ATTRIBUTES, ADVANCED, "Attributes")                                                          \
    X(NORMALS, BASIC, "Normals")                                                                   \
    X(SOUP, ADVANCED, "Voronoi cells as faces")                                                    \
    X(REPAIR, ADVANCED, "Repair of triangles")                                                     \
    X(BASELINES, ADVANCED, "Baselines")                                                            \
    X(PEAK, BASIC, "Peak of the PSNR")                                                             \
    X(SCALE, BASIC, "Scale")                                                                       \
    X(OVERLAP, ADVANCED, "Overlap")                                                                \
    X(VCM, ADVANCED, "Edges by VCM")

/** What parameters hang on: parameter, its name, another one, words of it with blanks between, when
 *  it has an effect. Without one of these words the parameter changes nothing: a form need not show
 *  it, and a report warns of it. One without a row always counts. */
#define VOR_WHEN_TABLE(X)                                                                          \
    X(CONTRAST, contrast, DENSITY, "curvature edges attribute:NAME", "if density is not uniform")  \
    X(GRADING, grading, DENSITY, "curvature edges attribute:NAME", "if density is not uniform")    \
    X(GROUPS, groups, DENSITY, "curvature edges attribute:NAME", "if density is not uniform")      \
    X(MAX_ASPECT, maxAspect, METRIC, "anisotropic lp attribute:NAME",                              \
      "if metric is not isotropic")                                                                \
    X(P, p, METRIC, "lp", "with metric=lp")                                                        \
    X(ITERATIONS, iterations, METHOD, "cvt kmeans isotropic",                                      \
      "with method=cvt, kmeans or isotropic")                                                      \
    X(DELTA, delta, METHOD, "cvt kmeans wlop ear isotropic", "with methods other than insert")     \
    X(ETA, eta, DENSITY, "uniform", "with density=uniform")                                        \
    X(REPAIR, repair, DENSITY, "uniform", "with density=uniform")                                  \
    X(MOVE_STOP, moveStop, METHOD, "cvt", "with method=cvt")                                       \
    X(ANDERSON, anderson, METHOD, "cvt", "with method=cvt")                                        \
    X(POLISH, polish, METHOD, "cvt wlop ear isotropic", "with method=cvt, wlop, ear or isotropic") \
    X(EVENNESS, evenness, METHOD, "cvt wlop ear isotropic",                                        \
      "with method=cvt, wlop, ear or isotropic")                                                   \
    X(SIGMA_N, sigmaN, METHOD, "ear", "with method=ear")                                           \
    X(SIGMA_P, sigmaP, METHOD, "wlop ear", "with method=wlop or ear")                              \
    X(MU, mu, METHOD, "wlop ear", "with method=wlop or ear")                                       \
    X(ROUNDS, rounds, METHOD, "wlop ear", "with method=wlop or ear")                               \
    X(STEPS, steps, METHOD, "wlop ear", "with method=wlop or ear")                                 \
    X(RHO, rho, METHOD, "ear", "with method=ear")                                                  \
    X(PHASES, phases, METHOD, "ear", "with method=ear")                                            \
    X(SAMPLES, samples, METHOD, "ear", "with method=ear")                                          \
    X(GAPS, gaps, METHOD, "ear", "with method=ear")                                                \
    X(HOLES, holes, BOUNDARY, "fill", "with boundary=fill")                                        \
    X(HOLE_MAX, holeMax, BOUNDARY, "fill", "with boundary=fill")

/** One row of the table. */
struct vor_when {
    enum vor_parameter parameter, other;
    const char *words;
};

/** Presets: name, title, id of the process, values with blanks between, sentence. Each is a request
 * that can be made as it is; a caller may change any of its values. */
#define VOR_NAMED_PRESET_TABLE(X)                                                                  \
    X("even", "Even 10,000", "resample", "points=10000", "Ten thousand points, evenly spread")     \
    X("edges", "Keep edges", "resample", "ratio=1 method=ear rho=0",                               \
      "As many points as the input has, with normals and sharp edges")                             \
    X("denoise", "Denoise", "denoise", "",                                                         \
      "As many points as the input has, without noise and outliers")                               \
    X("decoded", "After a codec", "restore", "",                                                   \
      "The same points in the same order, moved back towards the surface after a codec rounded "   \
      "their positions")                                                                           \
    X("fourfold",                                                                                  \
      "\xc3\x97"                                                                                   \
      "4 points",                                                                                  \
      "upsample", "ratio=4", "Four times as many points")                                          \
    X("quarter", "A quarter", "simplify", "ratio=0.25", "A quarter of the points")                 \
    X("mesh", "Mesh", "mesh", "points=10000", "Ten thousand points, connected by triangles")

/** One row of the table. */
struct vor_named_preset {
    const char *name, *title, *process, *values, *sentence;
};

/** The title of a parameter, never empty. */
const char *vor_parameter_title(enum vor_parameter parameter);

/** Its level, and the words of one. */
enum vor_level vor_parameter_level(enum vor_parameter parameter);
const char *vor_level_word(enum vor_level level);
const char *vor_level_title(enum vor_level level);

/** What a parameter hangs on; NULL where it always counts. */
const struct vor_when *vor_parameter_when(enum vor_parameter parameter);

/** Preset number `index` of a process, by its id; NULL past the last. */
const struct vor_named_preset *vor_named_preset(const char *process, unsigned index);

/** The preset of that name of a process; NULL when there is none. */
const struct vor_named_preset *vor_named_preset_find(const char *process, const char *name);

/** A walk over the values of a preset: at the beginning *at is its values.
 *
 *  @param[out] parameter  of the value; VOR_PARAMETER_COUNT where the table names none
 *  @param[out] value      as vor_spec_set takes it
 *  @return false past the last */
enum { VOR_PRESET_VALUE_SIZE = 64 };
int vor_named_preset_next(const char **at, enum vor_parameter *parameter,
                          char value[VOR_PRESET_VALUE_SIZE]);

#endif
