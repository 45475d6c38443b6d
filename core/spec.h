/** The request: one table of parameters and one of processes. The command line, the query string,
 *  JSON, the process descriptions and the docs all read them. */
#ifndef VOR_SPEC_H
#define VOR_SPEC_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** How a parameter is written. */
enum vor_kind {
    VOR_KIND_COUNT,         /**< whole number */
    VOR_KIND_REAL,          /**< finite number */
    VOR_KIND_CHOICE,        /**< one word of `choices` */
    VOR_KIND_COUNT_OR_AUTO, /**< whole number or the word auto */
};

/** Stands for "auto" in a COUNT_OR_AUTO and for "not given" in a parameter without a default. */
#define VOR_UNSET (-1.0)

/** Parameters: identifier, name, kind, unit, min, max, default, choices, sentence. A default of
 *  VOR_UNSET means there is none (or, for COUNT_OR_AUTO, auto). Choices are stored as their index.
 */
#define VOR_PARAMETER_TABLE(X)                                                                     \
    X(POINTS, points, COUNT, "points", 1, 10000000, VOR_UNSET, "",                                 \
      "Number of points of the result; one of points, ratio and spacing says how many")            \
    X(RATIO, ratio, REAL, "", 1e-6, 16, VOR_UNSET, "",                                             \
      "Number of points of the result over that of the input; a default holds only without the "   \
      "other two")                                                                                 \
    X(SPACING, spacing, REAL, "unit of the cloud", 1e-30, 1e30, VOR_UNSET, "",                     \
      "Distance between neighbours of the result; points = area / (sqrt(3)/2 spacing^2)")          \
    X(METHOD, method, CHOICE, "", 0, 0, 0, "cvt", "How the points are spread")                     \
    X(PATCH, patch, CHOICE, "", 0, 0, 0, "quadric", "Local surface that stands for the input")     \
    X(ITERATIONS, iterations, COUNT, "", 0, 10000, VOR_UNSET, "",                                  \
      "Iterations; not given: at most 12, or 100 where no polish follows, and the plateau")        \
    X(DELTA, delta, REAL, "", 0, 10, VOR_UNSET, "", "Stop once delta is this low")                 \
    X(SECONDS, seconds, REAL, "s", 0, 86400, VOR_UNSET, "", "Stop after this much time")           \
    X(NEIGHBORS, neighbors, COUNT_OR_AUTO, "points", 6, 500, VOR_UNSET, "",                        \
      "Input points that a local surface is fitted to; auto: as many as the input's noise asks "   \
      "for, region by region")                                                                     \
    X(ANDERSON, anderson, COUNT, "", 0, 16, VOR_UNSET, "",                                         \
      "Window of the Anderson acceleration; 0 is plain Lloyd; momentum when not given")            \
    X(POLISH, polish, COUNT, "", 0, 10000, 100, "",                                                \
      "Most steps of repulsion after the iterations, which even the spacing out; 0 is none")       \
    X(BOUNDARY, boundary, CHOICE, "", 0, 0, 0, "keep free",                                        \
      "keep: no point leaves the input at its border; free: no restriction")                       \
    X(OUTLIERS, outliers, CHOICE, "", 0, 0, 0, "keep drop",                                        \
      "drop: input points that none of those around them count among their nearest are ignored")   \
    X(SEED, seed, COUNT, "", 0, 9007199254740991, 1, "", "Seed of every random choice")            \
    X(ORDER, order, CHOICE, "", 0, 0, 0, "spatial progressive",                                    \
      "Of the points of the result. spatial: neighbours mostly follow each other; progressive: "   \
      "the first ones, however many, lie evenly over the whole")                                   \
    X(FORMAT, format, CHOICE, "", 0, 0, VOR_UNSET, "ply drc",                                      \
      "Format of the result; else by file suffix, Accept, or the input's")                         \
    X(QUANTIZATION, quantization, COUNT_OR_AUTO, "bits", 0, 30, VOR_UNSET, "",                     \
      "Bits a coordinate in Draco; 0 is lossless, auto keeps cells below spacing / 200")           \
    X(COMPRESSION, compression, COUNT, "", 0, 10, 7, "", "Effort of Draco, 10 is the smallest")    \
    X(ATTRIBUTES, attributes, CHOICE, "", 0, 0, 0, "nearest drop",                                 \
      "nearest: from the nearest input point; drop: positions only")                               \
    X(NORMALS, normals, CHOICE, "", 0, 0, 0, "nearest fit drop",                                   \
      "nearest: from the nearest input point; fit: of the local surface; drop: none")

enum vor_parameter {
#define VOR_PARAMETER_ENUM(id, name, kind, unit, min, max, def, choices, sentence) VOR_PARAM_##id,
    VOR_PARAMETER_TABLE(VOR_PARAMETER_ENUM)
#undef VOR_PARAMETER_ENUM
        VOR_PARAMETER_COUNT
};

/** One row of the table. */
struct vor_parameter_info {
    const char *name;
    enum vor_kind kind;
    const char *unit;    /**< "" for none */
    double min, max;     /**< inclusive; for numbers */
    double fallback;     /**< default */
    const char *choices; /**< words separated by one blank; for CHOICE */
    const char *sentence;
};

enum { VOR_BOUNDARY_KEEP, VOR_BOUNDARY_FREE };
enum { VOR_OUTLIERS_KEEP, VOR_OUTLIERS_DROP };
enum { VOR_ORDER_SPATIAL, VOR_ORDER_PROGRESSIVE };
enum { VOR_FORMAT_PLY, VOR_FORMAT_DRC };
enum { VOR_ATTRIBUTES_NEAREST, VOR_ATTRIBUTES_DROP };
enum { VOR_NORMALS_NEAREST, VOR_NORMALS_FIT, VOR_NORMALS_DROP };

/** What one can ask for: identifier, name, least and most points of the result over those of the
 *  input, title, sentence. Every process takes every parameter. */
#define VOR_PROCESS_TABLE(X)                                                                       \
    X(RESAMPLE, resample, 0, 16, "Resample a point cloud",                                         \
      "Spreads exactly the number of points asked for evenly over the surface the input "          \
      "describes")                                                                                 \
    X(DENOISE, denoise, 0, 16, "Denoise a point cloud",                                            \
      "Spreads as many points as the input has, or as asked for, evenly over the surface it "      \
      "describes, which smooths its noise and leaves its outliers out")                            \
    X(UPSAMPLE, upsample, 1, 16, "Upsample a point cloud",                                         \
      "Spreads four times as many points as the input has, or as asked for, evenly over the "      \
      "surface it describes")                                                                      \
    X(SIMPLIFY, simplify, 0, 1, "Simplify a point cloud",                                          \
      "Spreads at most as many points as the input has, exactly the number asked for, evenly "     \
      "over the surface it describes")

/** Defaults in which a process differs from the table of parameters: process, parameter, value. The
 *  one of ratio stands in where none of points, ratio and spacing is given. */
#define VOR_PRESET_TABLE(X)                                                                        \
    X(DENOISE, RATIO, 1)                                                                           \
    X(DENOISE, OUTLIERS, VOR_OUTLIERS_DROP)                                                        \
    X(UPSAMPLE, RATIO, 4)                                                                          \
    X(UPSAMPLE, ITERATIONS, 1)                                                                     \
    X(UPSAMPLE, POLISH, 8)

struct vor_process_info {
    const char *id;
    double ratio_min, ratio_max; /**< points of the result over those of the input, inclusive */
    const char *title, *sentence;
};

/** Process number `index`, NULL past the last; vor_process_find by id, NULL when there is none. */
const struct vor_process_info *vor_process_info(unsigned index);
const struct vor_process_info *vor_process_find(const char *id);

/** A request: a process (a row of the table) and one value for each parameter. Counts are exact in
 *  a double up to 2^53. */
struct vor_spec {
    const struct vor_process_info *process;
    double value[VOR_PARAMETER_COUNT];
};

const struct vor_parameter_info *vor_parameter_info(enum vor_parameter parameter);

/** The same row with the default, and for ratio the range, that it has in a process. */
struct vor_parameter_info vor_process_parameter(const struct vor_process_info *process,
                                                enum vor_parameter parameter);

/** Finds a parameter by name; VOR_PARAMETER_COUNT when there is none. */
enum vor_parameter vor_parameter_find(const char *name);

/** Word number `index` of a CHOICE as "%.*s" arguments: its length, 0 past the last. */
size_t vor_parameter_choice(enum vor_parameter parameter, unsigned index, const char **word);

/** A request for a process, with every parameter at the process's default and none of points, ratio
 *  and spacing given; vor_spec_init: for resample. */
void vor_spec_preset(struct vor_spec *spec, const struct vor_process_info *process);
void vor_spec_init(struct vor_spec *spec);

/** Sets one parameter from text, as the command line and the query string carry it. Numbers are
 *  read without regard to the locale.
 *
 *  @retval VOR_E_PARAM unknown name (the message lists the names), not of the kind, or out of range
 *                      (the message names value and range); spec is unchanged */
VOR_NODISCARD vor_status vor_spec_set(struct vor_spec *spec, const char *name, const char *text,
                                      struct vor_error *err);

/** The same from a number, as JSON carries it.
 *
 *  @retval VOR_E_PARAM as vor_spec_set; also a number for a CHOICE */
VOR_NODISCARD vor_status vor_spec_set_number(struct vor_spec *spec, const char *name, double number,
                                             struct vor_error *err);

/** Checks what concerns several parameters: exactly one of points, ratio and spacing is given.
 *
 *  @retval VOR_E_PARAM otherwise */
VOR_NODISCARD vor_status vor_spec_check(const struct vor_spec *spec, struct vor_error *err);

/** Ends a request that a caller made: where none of the three is given, ratio gets the process's
 *  default, if there is one. Then as vor_spec_check. */
VOR_NODISCARD vor_status vor_spec_complete(struct vor_spec *spec, struct vor_error *err);

/** Points that a checked request asks for of an input of that many; VOR_UNSET where spacing
 *  decides, which only the engine can tell. */
double vor_spec_target(const struct vor_spec *spec, uint64_t input);

/** Checks what points, ratio or spacing come to against the range of points and what the process
 *  allows for an input of that many.
 *
 *  @param[in] target vor_spec_target, or what spacing comes to; may be NaN
 *  @retval VOR_E_TARGET out of range (the message names the value, what it comes to and the range)
 */
VOR_NODISCARD vor_status vor_spec_check_target(const struct vor_spec *spec, double target,
                                               uint64_t input, struct vor_error *err);

/** Writes a parameter's value as text ("auto" and choices as words, numbers so that reading them
 * back gives the same value), "" when unset. Returns out. */
const char *vor_spec_text(const struct vor_spec *spec, enum vor_parameter parameter, char *out,
                          size_t size);

/** True when the parameter has a value (given, or by default); auto counts as one. */
int vor_spec_given(const struct vor_spec *spec, enum vor_parameter parameter);

/** Iterations that the request allows: those given, else 12 where a polish follows and 100 where
 * none does. */
uint32_t vor_spec_iterations(const struct vor_spec *spec);

#endif
