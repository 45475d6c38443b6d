/** A request as JSON. */
#ifndef VOR_PROTO_JSON_SPEC_H
#define VOR_PROTO_JSON_SPEC_H

#include "core/base/status.h"
#include "core/spec.h"
#include "proto/json/json_read.h"
#include "proto/text.h"

/** A request as an object: numbers as numbers, choices and auto as strings, unset ones left out. */
void vor_json_spec(struct vor_text *text, const struct vor_spec *spec);

/** Sets what an object's members name; the others keep what spec has.
 *
 *  @param[in,out] spec     unchanged on failure
 *  @param[out]    pointer  JSON pointer to the member at fault below object, "" on success or when
 *                          object itself is at fault; cut at its size
 *  @retval VOR_E_PARAM object is no object, a member is unknown (parameter names it), of the wrong
 *                      type or out of range. vor_spec_check is the caller's to call. */
#define VOR_JSON_POINTER_MAX 80
VOR_NODISCARD vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                                            char pointer[VOR_JSON_POINTER_MAX],
                                            struct vor_error *err);

#endif
