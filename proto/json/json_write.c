#include "core/base/utf8.h"
#include "proto/json/json.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Every value begins here: the comma before it, and the note that the next one needs one. */
static void before_value(struct vor_text *text)
{
    if (text->comma)
        vor_text_append(text, ",", 1);
    text->comma = 1;
}

static void open_bracket(struct vor_text *text, const char *bracket)
{
    before_value(text);
    vor_text_append(text, bracket, 1);
    text->comma = 0;
}

static void close_bracket(struct vor_text *text, const char *bracket)
{
    vor_text_append(text, bracket, 1);
    text->comma = 1;
}

void vor_json_begin_object(struct vor_text *text)
{
    open_bracket(text, "{");
}

void vor_json_end_object(struct vor_text *text)
{
    close_bracket(text, "}");
}

void vor_json_begin_array(struct vor_text *text)
{
    open_bracket(text, "[");
}

void vor_json_end_array(struct vor_text *text)
{
    close_bracket(text, "]");
}

/* One character that cannot stand as it is. */
static void append_escape(struct vor_text *text, unsigned char c)
{
    static const char short_of[] = "\"\"\\\\\bb\ff\nn\rr\tt";
    char escape[8];

    for (const char *s = short_of; *s != '\0'; s += 2) {
        if ((unsigned char)s[0] != c)
            continue;
        escape[0] = '\\';
        escape[1] = s[1];
        vor_text_append(text, escape, 2);
        return;
    }
    vor_text_append(text, escape, (size_t)snprintf(escape, sizeof escape, "\\u%04x", c));
}

static void append_quoted(struct vor_text *text, const char *value, size_t size)
{
    const unsigned char *p = (const unsigned char *)value;

    vor_text_append(text, "\"", 1);
    for (size_t i = 0, run; i < size; i += run) {
        for (run = 0; i + run < size && p[i + run] >= 0x20 && p[i + run] < 0x7f &&
                      p[i + run] != '"' && p[i + run] != '\\';
             run++)
            ;
        if (run > 0) {
            vor_text_append(text, p + i, run);
        } else if (p[i] < 0x80) {
            run = 1;
            append_escape(text, p[i]);
        } else if ((run = vor_utf8_length(p + i, size - i)) > 0) {
            vor_text_append(text, p + i, run);
        } else {
            run = 1;
            vor_text_append(text, "\xef\xbf\xbd", 3);
        }
    }
    vor_text_append(text, "\"", 1);
}

void vor_json_key(struct vor_text *text, const char *key)
{
    before_value(text);
    append_quoted(text, key, strlen(key));
    vor_text_append(text, ":", 1);
    text->comma = 0;
}

void vor_json_string(struct vor_text *text, const char *value)
{
    if (value == NULL)
        vor_json_null(text);
    else
        vor_json_bytes(text, value, strlen(value));
}

void vor_json_bytes(struct vor_text *text, const char *value, size_t size)
{
    before_value(text);
    append_quoted(text, value, size);
}

size_t vor_json_format_double(char out[VOR_JSON_NUMBER_MAX], double value)
{
    int length = 0;

    for (int digits = 15; digits <= 17; digits++) {
        length = snprintf(out, VOR_JSON_NUMBER_MAX, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            break;
    }
    return (size_t)length;
}

void vor_json_double(struct vor_text *text, double value)
{
    char number[VOR_JSON_NUMBER_MAX];

    if (!isfinite(value)) {
        vor_json_null(text);
        return;
    }
    before_value(text);
    vor_text_append(text, number, vor_json_format_double(number, value));
}

void vor_json_u64(struct vor_text *text, uint64_t value)
{
    char number[VOR_JSON_NUMBER_MAX];

    before_value(text);
    vor_text_append(text, number, (size_t)snprintf(number, sizeof number, "%" PRIu64, value));
}

void vor_json_i64(struct vor_text *text, int64_t value)
{
    char number[VOR_JSON_NUMBER_MAX];

    before_value(text);
    vor_text_append(text, number, (size_t)snprintf(number, sizeof number, "%" PRId64, value));
}

void vor_json_bool(struct vor_text *text, int value)
{
    vor_json_raw(text, value ? "true" : "false", value ? 4 : 5);
}

void vor_json_null(struct vor_text *text)
{
    vor_json_raw(text, "null", 4);
}

void vor_json_raw(struct vor_text *text, const char *json, size_t size)
{
    before_value(text);
    vor_text_append(text, json, size);
}

void vor_json_put_string(struct vor_text *text, const char *key, const char *value)
{
    vor_json_key(text, key);
    vor_json_string(text, value);
}

void vor_json_put_object(struct vor_text *text, const char *key)
{
    vor_json_key(text, key);
    vor_json_begin_object(text);
}

void vor_json_put_array(struct vor_text *text, const char *key)
{
    vor_json_key(text, key);
    vor_json_begin_array(text);
}

void vor_json_put_double(struct vor_text *text, const char *key, double value)
{
    vor_json_key(text, key);
    vor_json_double(text, value);
}

void vor_json_put_u64(struct vor_text *text, const char *key, uint64_t value)
{
    vor_json_key(text, key);
    vor_json_u64(text, value);
}

void vor_json_put_i64(struct vor_text *text, const char *key, int64_t value)
{
    vor_json_key(text, key);
    vor_json_i64(text, value);
}

void vor_json_put_bool(struct vor_text *text, const char *key, int value)
{
    vor_json_key(text, key);
    vor_json_bool(text, value);
}
