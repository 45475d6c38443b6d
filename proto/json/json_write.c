#include "proto/json/json.h"
#include "proto/json/json_internal.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void vor_text_init(struct vor_text *text, size_t cap)
{
    memset(text, 0, sizeof *text);
    text->cap = cap > 0 ? cap : VOR_TEXT_CAP_DEFAULT;
}

void vor_text_free(struct vor_text *text)
{
    size_t cap = text->cap;

    free(text->data);
    vor_text_init(text, cap);
}

void vor_text_clear(struct vor_text *text)
{
    text->size = 0;
    text->comma = 0;
    text->failed = 0;
    if (text->data != NULL)
        text->data[0] = '\0';
}

/* Makes room for size more bytes and a NUL. */
static int grow(struct vor_text *text, size_t size)
{
    size_t wanted, capacity;
    char *data;

    if (text->failed || size > text->cap - text->size)
        return 0;
    wanted = text->size + size + 1;
    if (wanted <= text->capacity)
        return 1;
    capacity = text->capacity < 64 ? 64 : text->capacity * 2;
    if (capacity < wanted)
        capacity = wanted;
    data = realloc(text->data, capacity);
    if (data == NULL)
        return 0;
    text->data = data;
    text->capacity = capacity;
    return 1;
}

static void append(struct vor_text *text, const void *bytes, size_t size)
{
    if (!grow(text, size)) {
        text->failed = 1;
        return;
    }
    if (size > 0)
        memcpy(text->data + text->size, bytes, size);
    text->size += size;
    text->data[text->size] = '\0';
}

void vor_text_add(struct vor_text *text, const void *bytes, size_t size)
{
    append(text, bytes, size);
    text->comma = 0;
}

void vor_text_puts(struct vor_text *text, const char *string)
{
    vor_text_add(text, string, strlen(string));
}

static void print(struct vor_text *text, size_t length, const char *format, va_list args)
{
    if (!grow(text, length)) {
        text->failed = 1;
        return;
    }
    (void)vsnprintf(text->data + text->size, length + 1, format, args);
    text->size += length;
}

static size_t print_length(const char *format, va_list args)
{
    int length = vsnprintf(NULL, 0, format, args);

    return length < 0 ? SIZE_MAX : (size_t)length;
}

void vor_text_printf(struct vor_text *text, const char *format, ...)
{
    size_t length;
    va_list args;

    text->comma = 0;
    va_start(args, format);
    length = print_length(format, args);
    va_end(args);
    va_start(args, format);
    print(text, length, format, args);
    va_end(args);
}

vor_status vor_text_status(const struct vor_text *text, struct vor_error *err)
{
    if (!text->failed)
        return VOR_OK;
    return vor_fail(err, VOR_E_NOMEM, "a text needs more than the %zu bytes it has (at most %zu)",
                    text->size, text->cap);
}

/* Every value begins here: the comma before it, and the note that the next one needs one. */
static void before_value(struct vor_text *text)
{
    if (text->comma)
        append(text, ",", 1);
    text->comma = 1;
}

static void open_bracket(struct vor_text *text, const char *bracket)
{
    before_value(text);
    append(text, bracket, 1);
    text->comma = 0;
}

static void close_bracket(struct vor_text *text, const char *bracket)
{
    append(text, bracket, 1);
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
        append(text, escape, 2);
        return;
    }
    append(text, escape, (size_t)snprintf(escape, sizeof escape, "\\u%04x", c));
}

static int is_plain(unsigned char c)
{
    return c >= 0x20 && c < 0x7f && c != '"' && c != '\\';
}

static void append_quoted(struct vor_text *text, const char *value, size_t size)
{
    const unsigned char *p = (const unsigned char *)value;

    append(text, "\"", 1);
    for (size_t i = 0, run; i < size; i += run) {
        for (run = 0; i + run < size && is_plain(p[i + run]); run++)
            ;
        if (run > 0) {
            append(text, p + i, run);
        } else if (p[i] < 0x80) {
            run = 1;
            append_escape(text, p[i]);
        } else if ((run = vor_utf8_length(p + i, size - i)) > 0) {
            append(text, p + i, run);
        } else {
            run = 1;
            append(text, "\xef\xbf\xbd", 3);
        }
    }
    append(text, "\"", 1);
}

void vor_json_key(struct vor_text *text, const char *key)
{
    before_value(text);
    append_quoted(text, key, strlen(key));
    append(text, ":", 1);
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

/* A locale's decimal point, which may be several bytes, becomes a point. */
static size_t plain_point(char *number, size_t length)
{
    size_t at = 0;

    for (size_t i = 0; i < length; i++) {
        if (strchr("+-0123456789e", number[i]) != NULL)
            number[at++] = number[i];
        else if (at == 0 || number[at - 1] != '.')
            number[at++] = '.';
    }
    number[at] = '\0';
    return at;
}

size_t vor_json_format_double(char out[VOR_JSON_NUMBER_MAX], double value)
{
    int length = 0;

    for (int digits = 15; digits <= 17; digits++) {
        length = snprintf(out, VOR_JSON_NUMBER_MAX, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            break;
    }
    return plain_point(out, (size_t)length);
}

void vor_json_double(struct vor_text *text, double value)
{
    char number[VOR_JSON_NUMBER_MAX];

    if (!isfinite(value)) {
        vor_json_null(text);
        return;
    }
    before_value(text);
    append(text, number, vor_json_format_double(number, value));
}

void vor_json_u64(struct vor_text *text, uint64_t value)
{
    char number[VOR_JSON_NUMBER_MAX];

    before_value(text);
    append(text, number, (size_t)snprintf(number, sizeof number, "%" PRIu64, value));
}

void vor_json_i64(struct vor_text *text, int64_t value)
{
    char number[VOR_JSON_NUMBER_MAX];

    before_value(text);
    append(text, number, (size_t)snprintf(number, sizeof number, "%" PRId64, value));
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
    append(text, json, size);
}

void vor_json_put_string(struct vor_text *text, const char *key, const char *value)
{
    vor_json_key(text, key);
    vor_json_string(text, value);
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
