/** Reads a stranger's JSON. The one door to cJSON. */
#ifndef VOR_PROTO_JSON_READ_H
#define VOR_PROTO_JSON_READ_H

#include "core/base/status.h"
#include "proto/text.h"

#include <stddef.h>

/** A value that was read. The one that vor_json_parse returns owns all others and their strings. */
struct vor_json;

enum vor_json_kind {
    VOR_JSON_NULL,
    VOR_JSON_BOOL,
    VOR_JSON_NUMBER,
    VOR_JSON_STRING,
    VOR_JSON_ARRAY,
    VOR_JSON_OBJECT
};

/** Reads a stranger's text: vor_json_scan, then cJSON, then no two members of an object with the
 *  same name. bytes need no NUL at the end.
 *
 *  @param[out] out to be freed with vor_json_free; NULL on failure
 *  @retval VOR_E_REQUEST as vor_json_scan; a duplicate key (byte_offset of the second one)
 *  @retval VOR_E_NOMEM
 *
 *  O(size log size) time, under 4 MiB of memory. */
VOR_NODISCARD vor_status vor_json_parse(struct vor_json **out, const char *bytes, size_t size,
                                        struct vor_error *err);
void vor_json_free(struct vor_json *json);

enum vor_json_kind vor_json_kind(const struct vor_json *value);

/** "null", "a boolean", "a number", "a string", "an array", "an object": for messages. */
const char *vor_json_kind_word(const struct vor_json *value);

/** The getters take NULL for value, so that calls can be nested. They compare names byte for byte.
 */

/** Member of an object; NULL when there is none or value is no object. */
const struct vor_json *vor_json_get(const struct vor_json *value, const char *name);

/** The string's text, without NUL inside; NULL when value is no string. */
const char *vor_json_get_string(const struct vor_json *value);

/** True and *out set when value is a number, or a boolean (0, 1). *out is finite. */
int vor_json_get_number(const struct vor_json *value, double *out);
int vor_json_get_bool(const struct vor_json *value, int *out);

/** First element or member of an array or object, the one after it, and a member's name; NULL past
 *  the last. Cost: O(1) each. */
const struct vor_json *vor_json_first(const struct vor_json *value);
const struct vor_json *vor_json_next(const struct vor_json *element);
const char *vor_json_name(const struct vor_json *member);

/** Writes a value that was read, in one line, numbers as vor_json_double does. */
void vor_json_copy(struct vor_text *text, const struct vor_json *value);

#endif
