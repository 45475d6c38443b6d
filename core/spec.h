/** The request: a process and a value for each of its parameters, read from text or JSON by the
 *  tables. */
#ifndef VOR_SPEC_H
#define VOR_SPEC_H

#include "core/base/status.h"
#include "core/spec/shown.h"
#include "core/spec/tables.h"

#include <stddef.h>
#include <stdint.h>

/** Bytes that the texts and names of a request may have together, each with a NUL. */
#define VOR_SPEC_TEXTS_SIZE 512

/** A request: a process (a row of the table) and one value for each parameter. It owns nothing and
 *  is copied by assignment; equal requests are equal bytes. A request of zero bytes has no process,
 *  and vor_spec_form finds no value in it.
 *
 *  enum vor_form says which number stands for a value; counts are exact up to 2^53. A parameter
 *  that the process does not take has the default of the table, so that the engine may read every
 *  value. Only vor_spec_set and the functions like it set a text or a name. */
struct vor_spec {
    const struct vor_process_info *process;
    double value[VOR_PARAMETER_COUNT];
    char texts[VOR_SPEC_TEXTS_SIZE]; /**< one after another, in the order of the parameters */
};

/** Makes a request for a process: every parameter has the process's default, but none of points,
 *  ratio and spacing is given. vor_spec_init: for resample. */
void vor_spec_preset(struct vor_spec *spec, const struct vor_process_info *process);
void vor_spec_init(struct vor_spec *spec);

/** True when a parameter has the value that the process gives it, or none. */
int vor_spec_is_default(const struct vor_spec *spec, enum vor_parameter parameter);

/** True when a parameter has an effect: the one that it hangs on has one of the words of
 *  VOR_WHEN_TABLE, or it hangs on none. */
int vor_spec_counts(const struct vor_spec *spec, enum vor_parameter parameter);

/** Sets one parameter from text, as the command line and the query string carry it. The locale does
 *  not matter. A whole number may end in k or M, which stand for 1000 and 1,000,000: 1.5M. A flag
 * is written true or false, a list as words with commas between, or none. name and text may hold
 * any bytes: messages quote them.
 *
 *  @retval VOR_E_PARAM the process takes no parameter of that name (the message names the nearest
 *                      ones); the text is not of the kind or out of range (the message names value
 *                      and range); or the texts of the request do not fit. spec is unchanged
 *  @retval VOR_E_WORD  a list has a word that is none of the parameter's (the message lists those);
 *                      spec is unchanged */
VOR_NODISCARD vor_status vor_spec_set(struct vor_spec *spec, const char *name, const char *text,
                                      struct vor_error *err);

/** The same from a number. */
VOR_NODISCARD vor_status vor_spec_set_number(struct vor_spec *spec, const char *name, double number,
                                             struct vor_error *err);

/** Refuses a value that no text stands for, an object say: "NAME is WHAT, want ...". A name that
 *  the process does not take is refused as vor_spec_set does.
 *
 *  @retval VOR_E_PARAM always */
vor_status vor_spec_refuse(const struct vor_spec *spec, const char *name, const char *what,
                           struct vor_error *err);

/** True when filters alone make the result: the request has the filter mls or outliers, and none of
 *  points, ratio and spacing. Each point of the input is then one of the result, or dropped. */
int vor_spec_only_filters(const struct vor_spec *spec);

/** What a process does with the faces of its input. */
enum vor_spec_faces {
    VOR_FACES_IGNORED,
    VOR_FACES_NEEDED, /**< points are drawn from them */
    VOR_FACES_KEPT    /**< if there are any, the result has them */
};

enum vor_spec_faces vor_spec_faces(const struct vor_spec *spec);

/** Checks what concerns several parameters: if the process takes points, ratio and spacing, exactly
 *  one of them is given, or none where filters alone make the result; an energy is minimised by
 *  cvt, without a density; wlop and ear follow no density and no metric, and have no sites. And
 *  that p is even.
 *
 *  @retval VOR_E_PARAM otherwise */
VOR_NODISCARD vor_status vor_spec_check(const struct vor_spec *spec, struct vor_error *err);

/** Completes a request that a caller made: if the process takes the three and none is given, ratio
 *  gets the process's default, if it has one. A default of 1, as many points as the input has,
 *  gives way to filters. Then checks the request, as vor_spec_check. */
VOR_NODISCARD vor_status vor_spec_complete(struct vor_spec *spec, struct vor_error *err);

/** Checks which inputs come with the request: every required one does, and so does the input that a
 *  parameter needs (VOR_NEED_TABLE) if the parameter differs from its default.
 *
 *  @param[in] inputs bit i: input i of the process comes
 *  @retval VOR_E_PARAM otherwise; err->parameter is the parameter, or the input that is missing */
VOR_NODISCARD vor_status vor_spec_check_inputs(const struct vor_spec *spec, unsigned inputs,
                                               struct vor_error *err);

/** Whether the result is points of the input, which none of them need leave: of a process without a
 *  target, or of filters alone. */
int vor_spec_keeps_points(const struct vor_spec *spec);

/** Number of points that a checked request asks for, given the number of points of the input.
 *  VOR_UNSET if spacing decides, because only the engine knows the area, if filters do, and if the
 *  process has no such target. */
double vor_spec_target(const struct vor_spec *spec, uint64_t input);

/** Checks the number of points asked for against the range of points, and against what the process
 *  allows for an input of that many. A process without such a target allows any, and so do filters
 *  alone. Where faces are sampled, their vertices bound the number only if the process may not
 *  add points.
 *
 *  @param[in] target vor_spec_target, or what spacing comes to; may be NaN
 *  @retval VOR_E_TARGET out of range (the message names the value, what it comes to and the range)
 */
VOR_NODISCARD vor_status vor_spec_check_target(const struct vor_spec *spec, double target,
                                               uint64_t input, struct vor_error *err);

/** Bytes of the longest text that vor_spec_text writes, with the NUL. */
#define VOR_SPEC_VALUE_SIZE 640

/** Writes a parameter's value as text from which vor_spec_set reads the same value; "" if it is not
 *  given. Returns out. */
const char *vor_spec_text(const struct vor_spec *spec, enum vor_parameter parameter,
                          char out[VOR_SPEC_VALUE_SIZE]);

/** The text of a TEXT, the name in a CHOICE_OR_NAME, the X,Y,Z of a CHOICE_OR_VECTOR or the numbers
 *  of a COUNTS_OR_AUTO; points into spec. NULL if there is none. */
const char *vor_spec_name(const struct vor_spec *spec, enum vor_parameter parameter);

/** The numbers of a vector; false, and *out unchanged, if the parameter's value is none. */
int vor_spec_vector(const struct vor_spec *spec, enum vor_parameter parameter, double out[3]);

/** Whole number `index` of a COUNTS_OR_AUTO; false past the last, and if the value has none. */
int vor_spec_count_at(const struct vor_spec *spec, enum vor_parameter parameter, unsigned index,
                      double *out);

/** The form of a parameter's value; VOR_FORM_NONE if it is not given, or the process does not take
 *  the parameter. */
enum vor_form vor_spec_form(const struct vor_spec *spec, enum vor_parameter parameter);

/** True when the parameter has a value (given, or by default); auto counts as one. */
int vor_spec_given(const struct vor_spec *spec, enum vor_parameter parameter);

/** True when the request asks for an energy to be minimised, by metric lp or cells euclid; then no
 *  polish follows. */
int vor_spec_descends(const struct vor_spec *spec);

/** Steps of projection of a round of wlop or ear: those given, else 12, or 4 of ear before a
 * polish. Measured, 3 / 4 / 5 / 8 / 12 steps, ear to 10,000 points, two seeds: delta of
 * fandisk30k_noisy .0994 / .0961 / .0926 / .0938 / .0946, of fandisk30k_noise2 .0800 / .0746 /
 * .0728 / .0686 / .0698; rms near its edges over the input's .47 / .49 / .48 / .48 / .46, armadillo
 * with noise 6.5e-4 / 6.6e-4 / - / - / 6.6e-4 of the diagonal. Each step takes 1.7 % of the
 * armadillo's time. Without a polish the steps alone even the points out. */
uint32_t vor_spec_steps(const struct vor_spec *spec);

/** What is done with outliers: what the request says, else ear drops them and other methods keep
 *  them. They hide the edges that ear is asked for: a wedge of 90 degrees, 18,000 points with noise
 *  of 1 % of the diagonal, to as many: normals near the edge that are those of neither side 68 %,
 *  and 2 % without the 422 points that noise took farthest off.
 *
 *  @return a VOR_OUTLIERS_... of core/spec/tables.h */
int vor_spec_outliers(const struct vor_spec *spec);

/** Most iterations that the request allows: those given, else 35 where an energy is minimised, 12
 *  before a polish and 100 without one. Of wlop and ear, projection steps. */
uint32_t vor_spec_iterations(const struct vor_spec *spec);

/** Most steps of the polish that follows them; 0 where an energy is minimised. */
uint32_t vor_spec_polish(const struct vor_spec *spec);

#endif
