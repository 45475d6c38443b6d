/** Writes JSON, value after value, as it is produced. */
#ifndef VOR_PROTO_JSON_WRITE_H
#define VOR_PROTO_JSON_WRITE_H

#include "proto/text.h"

#include <stddef.h>
#include <stdint.h>

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

/** The shortest of "%.15g", "%.16g", "%.17g" that reads back as value (which must be finite), with
 *  a point. out has room for VOR_JSON_NUMBER_MAX. Returns its length. */
#define VOR_JSON_NUMBER_MAX 32
size_t vor_json_format_double(char out[VOR_JSON_NUMBER_MAX], double value);

#endif
