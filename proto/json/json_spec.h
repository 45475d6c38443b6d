/** A request as JSON. */
#ifndef VOR_PROTO_JSON_SPEC_H
#define VOR_PROTO_JSON_SPEC_H

#include "core/base/status.h"
#include "core/spec.h"
#include "proto/json/json_read.h"
#include "proto/text.h"

/** A request as an object: the parameters that its process takes and that have a value; numbers as
 *  numbers, flags as booleans, lists as arrays, all else as strings. */
void vor_json_spec(struct vor_text *text, const struct vor_spec *spec);

/** The same of those parameters whose value is not the process's default. */
void vor_json_spec_changed(struct vor_text *text, const struct vor_spec *spec);

/** The value of one parameter of a request, which has one (vor_spec_given). */
void vor_json_spec_value(struct vor_text *text, const struct vor_spec *spec,
                         enum vor_parameter parameter);

/** Sets what an object's members name; the others keep what spec has.
 *
 *  @param[in,out] spec     unchanged on failure
 *  @param[out]    pointer  JSON pointer to the member at fault below object, "" on success or when
 *                          object itself is at fault; cut at its size
 *  @retval VOR_E_PARAM object is no object, or as vor_spec_set_as (parameter names the member)
 *  @retval VOR_E_WORD  as vor_spec_set_as
 *
 *  vor_spec_check is the caller's to call. */
#define VOR_JSON_POINTER_MAX 80
VOR_NODISCARD vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                                            char pointer[VOR_JSON_POINTER_MAX],
                                            struct vor_error *err);

/** The JSON Schema of a parameter as a process has it, with its default and "x-unit". */
void vor_json_parameter_schema(struct vor_text *text, const struct vor_process_info *process,
                               enum vor_parameter parameter);

#endif
