/** JSON: writing it, reading bytes from outside, and the values of this product. cJSON only reads.
 */
#ifndef VOR_PROTO_JSON_H
#define VOR_PROTO_JSON_H

#include "core/base/members.h"
#include "core/base/status.h"
#include "core/report.h"
#include "core/spec.h"
#include "proto/text.h"

#include <stddef.h>
#include <stdint.h>

/* Writes JSON, value after value, as it is produced. */

/** The writer puts the commas in. The caller must alternate keys and values in an object and close
 *  each bracket.
 *
 *  Strings may hold any bytes: the writer escapes control characters (C0, DEL) and writes U+FFFD
 *  for bytes that are not UTF-8, so the text is always valid JSON. A NULL string becomes null.
 *  Doubles get the fewest of 15, 16 or 17 digits that read back as the same value; NaN and
 *  infinities become null. The program must be in the "C" locale. A failure sticks to the text. */
void vor_json_begin_object(struct vor_text *text);
void vor_json_end_object(struct vor_text *text);
void vor_json_begin_array(struct vor_text *text);
void vor_json_end_array(struct vor_text *text);
void vor_json_key(struct vor_text *text, const char *key);
void vor_json_string(struct vor_text *text, const char *value);
void vor_json_bytes(struct vor_text *text, const char *value, size_t size);
void vor_json_double(struct vor_text *text, double value);
void vor_json_u64(struct vor_text *text, uint64_t value);
void vor_json_i64(struct vor_text *text, int64_t value);
void vor_json_bool(struct vor_text *text, int value);
void vor_json_null(struct vor_text *text);

/** Writes size bytes that are JSON already; the caller vouches for that. */
void vor_json_raw(struct vor_text *text, const char *json, size_t size);

/** Writes a key and its value. */
void vor_json_put_string(struct vor_text *text, const char *key, const char *value);
void vor_json_put_double(struct vor_text *text, const char *key, double value);
void vor_json_put_u64(struct vor_text *text, const char *key, uint64_t value);
void vor_json_put_i64(struct vor_text *text, const char *key, int64_t value);
void vor_json_put_bool(struct vor_text *text, const char *key, int value);

/** Writes a key and begins its value. */
void vor_json_put_object(struct vor_text *text, const char *key);
void vor_json_put_array(struct vor_text *text, const char *key);

/** The shortest of "%.15g", "%.16g", "%.17g" that reads back as value (which must be finite), with
 *  a point. out has room for VOR_JSON_NUMBER_MAX. Returns its length. */
#define VOR_JSON_NUMBER_MAX 32
size_t vor_json_format_double(char out[VOR_JSON_NUMBER_MAX], double value);

/* Checks a stranger's JSON before cJSON sees it, for what cJSON lets pass: 01, 1., 0x10, 1e999,
 * \u0000 (which cuts a string short), raw control characters, what is not UTF-8, and bombs, which
 * cost it 41 bytes of memory for a byte of text. */

/** What a text must keep to before cJSON sees it. */
#define VOR_JSON_SIZE_MAX ((size_t)1 << 20)
#define VOR_JSON_DEPTH_MAX 32
#define VOR_JSON_TOKENS_MAX 20000 /**< values, keys and opening brackets */
#define VOR_JSON_NUMBER_LENGTH_MAX 63

/** Checks a text without reading it: RFC 8259 to the letter, within the limits above, valid UTF-8,
 *  no NUL and no \u0000, numbers that fit a double, and nothing after the value. Keys may stand
 *  there twice.
 *
 *  @retval VOR_E_REQUEST byte_offset says where and the message why; limit and got are set when a
 *                        limit was exceeded
 *
 *  O(size) time, no memory. */
VOR_NODISCARD vor_status vor_json_scan(const char *bytes, size_t size, struct vor_error *err);

/* Reads a stranger's JSON. The one door to cJSON. */

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

/** Reads a stranger's text: vor_json_scan, then cJSON. bytes need no NUL at the end.
 *
 *  @param[out] out to be freed with vor_json_free; NULL on failure
 *  @retval VOR_E_REQUEST as vor_json_scan
 *  @retval VOR_E_NOMEM
 *
 *  O(size) time, under 4 MiB of memory. */
VOR_NODISCARD vor_status vor_json_parse(struct vor_json **out, const char *bytes, size_t size,
                                        struct vor_error *err);
void vor_json_free(struct vor_json *json);

enum vor_json_kind vor_json_kind(const struct vor_json *value);

/** The getters take NULL for value, so that calls can be nested. They compare names byte for byte.
 */

/** Member of an object; NULL when there is none or value is no object. */
const struct vor_json *vor_json_get(const struct vor_json *value, const char *name);

/** The string's text, without NUL inside; NULL when value is no string. */
const char *vor_json_get_string(const struct vor_json *value);

/** True and *out set when value is a number. *out is finite. */
int vor_json_get_number(const struct vor_json *value, double *out);

/** First element or member of an array or object, the one after it, and a member's name; NULL past
 *  the last. Cost: O(1) each. */
const struct vor_json *vor_json_first(const struct vor_json *value);
const struct vor_json *vor_json_next(const struct vor_json *element);
const char *vor_json_name(const struct vor_json *member);

/** Writes a value that was read, in one line, numbers as vor_json_double does. */
void vor_json_copy(struct vor_text *text, const struct vor_json *value);

/* Structs that describe themselves (core/base/members.h) as JSON. */

/** Writes the members of values, a struct with that description, into an open object. */
void vor_json_members(struct vor_text *text, const struct vor_members *members, const void *values);

/** Writes a document as an object. */
void vor_json_document(struct vor_text *text, const struct vor_document *document);

/** Reads the members of an object back into values, a struct with that description; the object may
 * have others. The description has numbers and words only. A member that is missing
 * becomes 0, and so does a number that is none, negative or too large for its type; but a REAL that
 * is null becomes NAN, as which it was written. A word that is not among the row's becomes
 * word_count. */
void vor_json_members_read(void *values, const struct vor_members *members,
                           const struct vor_json *object);

/** Writes a JSON schema of a struct into an open object, in the dialect of OpenAPI 3.0: types,
 * descriptions and, as "x-unit", units. Every member is required but the optional ones. */
void vor_json_members_schema(struct vor_text *text, const struct vor_members *members);

/* A request as JSON. */

/** A request as an object: the parameters that its process takes and that have a value; numbers as
 *  numbers, flags as booleans, lists as arrays, all else as strings. */
void vor_json_spec(struct vor_text *text, const struct vor_spec *spec);

/** The same of those parameters whose value is not the process's default. */
void vor_json_spec_changed(struct vor_text *text, const struct vor_spec *spec);

/** The value of one parameter of a request, which has one (vor_spec_given). */
void vor_json_spec_value(struct vor_text *text, const struct vor_spec *spec,
                         enum vor_parameter parameter);

/** Sets what an object's members name, as vor_json_spec writes them; the others keep what spec has.
 *
 *  @param[in,out] spec  unchanged on failure
 *  @retval VOR_E_PARAM object is no object, or as vor_spec_set (parameter names the member)
 *  @retval VOR_E_WORD  as vor_spec_set
 *
 *  vor_spec_check is the caller's to call. */
VOR_NODISCARD vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                                            struct vor_error *err);

/** The JSON Schema of a parameter as a process has it, with its default and "x-unit". */
void vor_json_parameter_schema(struct vor_text *text, const struct vor_process_info *process,
                               enum vor_parameter parameter);

/* Records and links, each written by one function, so that they have the same shape everywhere. */

/** Writes a progress record as an object, the same in SSE, NDJSON and traces. */
void vor_json_record(struct vor_text *text, const struct vor_record *record);

/** Reads a record from an object, which may have other members, as vor_json_members_read does.
 *  Returns 0 and leaves *out alone when the object has no iteration. */
int vor_json_record_read(struct vor_record *out, const struct vor_json *object);

/** Writes a key and its string, unless that is NULL or empty. */
void vor_json_put_given(struct vor_text *text, const char *key, const char *value);

/** A link; NULL members and a length of -1 are left out. */
struct vor_link {
    const char *rel, *type, *title, *href;
    int64_t length;
};

/** [{"rel","type","title","href","length"}, ...] */
void vor_json_link(struct vor_text *text, const struct vor_link *link);
void vor_json_links(struct vor_text *text, const struct vor_link *links, size_t count);

/* Descriptions of processes. */

/** Writes the summary of a process for a list, or its whole description: inputs from the parameter
 *  table, outputs cloud and report, and "x-record", the schema of its progress records. Links as in
 *  vor_json_links. */
void vor_json_process_summary(struct vor_text *text, const struct vor_process_info *process,
                              const struct vor_link *links, size_t link_count);
void vor_json_process(struct vor_text *text, const struct vor_process_info *process,
                      const struct vor_link *links, size_t link_count);

#endif
