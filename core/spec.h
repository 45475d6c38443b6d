/** The request: a process and a value for each of its parameters, read from text or JSON by the
 *  tables. */
#ifndef VOR_SPEC_H
#define VOR_SPEC_H

#include "core/base/status.h"
#include "core/spec/tables.h"

#include <stddef.h>
#include <stdint.h>

/** Bytes that the texts and names of a request may have together, each with a NUL. */
#define VOR_SPEC_TEXTS_SIZE 512

/** A request: a process (a row of the table) and one value for each parameter. A plain value that
 *  owns nothing, to be copied by assignment; two that ask for the same are the same bytes. One that
 *  is all zero has no process; vor_spec_form finds nothing in it.
 *
 *  Counts are exact in a double up to 2^53; how other forms stand there says enum vor_form. The
 * value of a parameter that the process does not take is the default of the table, so that what
 * runs it may read all. A text or a name is set by vor_spec_set and its like alone. */
struct vor_spec {
    const struct vor_process_info *process;
    double value[VOR_PARAMETER_COUNT];
    char texts[VOR_SPEC_TEXTS_SIZE]; /**< one after another, in the order of the parameters */
};

/** A request for a process, with every parameter at the process's default and none of points, ratio
 *  and spacing given; vor_spec_init: for resample. */
void vor_spec_preset(struct vor_spec *spec, const struct vor_process_info *process);
void vor_spec_init(struct vor_spec *spec);

/** Sets one parameter from text, as the command line and the query string carry it. Numbers are
 *  read without regard to the locale; a flag is true or false; a list is words with commas between,
 *  or none. name and text may hold any bytes: messages quote them.
 *
 *  @retval VOR_E_PARAM the process has no parameter of that name (the message lists those it
 * takes), the text is not of the kind or out of range (the message names value and range), or all
 * texts together do not fit; spec is unchanged */
VOR_NODISCARD vor_status vor_spec_set(struct vor_spec *spec, const char *name, const char *text,
                                      struct vor_error *err);

/** The same from a notation that tells shapes apart, as JSON does: text stands for a number, a
 *  boolean (true, false), a string or an array (as a list is written) and is taken for nothing
 * else.
 *
 *  @retval VOR_E_PARAM as vor_spec_set; also when the kind has no such shape */
VOR_NODISCARD vor_status vor_spec_set_as(struct vor_spec *spec, const char *name,
                                         enum vor_shape shape, const char *text,
                                         struct vor_error *err);

/** The same from a number. */
VOR_NODISCARD vor_status vor_spec_set_number(struct vor_spec *spec, const char *name, double number,
                                             struct vor_error *err);

/** Refuses a value that has no text: "NAME is WHAT, want ...", or the name as vor_spec_set does.
 *
 *  @retval VOR_E_PARAM always */
vor_status vor_spec_refuse(const struct vor_spec *spec, const char *name, const char *what,
                           struct vor_error *err);

/** Checks what concerns several parameters: where the process takes points, ratio and spacing,
 *  exactly one of them is given.
 *
 *  @retval VOR_E_PARAM otherwise */
VOR_NODISCARD vor_status vor_spec_check(const struct vor_spec *spec, struct vor_error *err);

/** Ends a request that a caller made: where the process takes the three and none is given, ratio
 * gets the process's default, if there is one. Then as vor_spec_check. */
VOR_NODISCARD vor_status vor_spec_complete(struct vor_spec *spec, struct vor_error *err);

/** Checks which inputs come along: those that are required do, and so does the one that a parameter
 *  needs which is given.
 *
 *  @param[in] inputs bit i: input i of the process is there
 *  @retval VOR_E_PARAM otherwise; parameter is that of the message, or the name of the input */
VOR_NODISCARD vor_status vor_spec_check_inputs(const struct vor_spec *spec, unsigned inputs,
                                               struct vor_error *err);

/** Points that a checked request asks for of an input of that many; VOR_UNSET where spacing
 *  decides, which only the engine can tell, and where the process has no such target. */
double vor_spec_target(const struct vor_spec *spec, uint64_t input);

/** Checks what points, ratio or spacing come to against the range of points and what the process
 *  allows for an input of that many. A process without such a target allows all.
 *
 *  @param[in] target vor_spec_target, or what spacing comes to; may be NaN
 *  @retval VOR_E_TARGET out of range (the message names the value, what it comes to and the range)
 */
VOR_NODISCARD vor_status vor_spec_check_target(const struct vor_spec *spec, double target,
                                               uint64_t input, struct vor_error *err);

/** Bytes of the longest text that vor_spec_text writes, with the NUL. */
#define VOR_SPEC_VALUE_SIZE 640

/** Writes a parameter's value as text, so that vor_spec_set reads the same value from it; "" when
 * it is not given. Returns out. */
const char *vor_spec_text(const struct vor_spec *spec, enum vor_parameter parameter,
                          char out[VOR_SPEC_VALUE_SIZE]);

/** The text of a TEXT, or the name in a CHOICE_OR_NAME: lies in spec. NULL where there is none. */
const char *vor_spec_name(const struct vor_spec *spec, enum vor_parameter parameter);

/** The form that a parameter's value has; VOR_FORM_NONE when it is not given, or the process does
 *  not take it. */
enum vor_form vor_spec_form(const struct vor_spec *spec, enum vor_parameter parameter);

/** True when the parameter has a value (given, or by default); auto counts as one. */
int vor_spec_given(const struct vor_spec *spec, enum vor_parameter parameter);

/** Iterations that the request allows: those given, else 12 where a polish follows and 100 where
 * none does. */
uint32_t vor_spec_iterations(const struct vor_spec *spec);

#endif
