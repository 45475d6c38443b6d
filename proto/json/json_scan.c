/* Recursion is as deep as the text may be nested. */
#include "core/base/utf8.h"
#include "proto/json/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct scan {
    const unsigned char *bytes;
    size_t size, at;
    unsigned depth;
    size_t tokens;
    struct vor_error *err;
};

static vor_status reject(const struct scan *s, size_t at, const char *what)
{
    (void)vor_fail(s->err, VOR_E_REQUEST, "JSON: %s at byte %zu", what, at);
    return vor_fail_at(s->err, VOR_E_REQUEST, at);
}

static vor_status exceed(const struct scan *s, const char *what, size_t limit, size_t got)
{
    (void)vor_fail(s->err, VOR_E_REQUEST, "JSON: %s: %zu, want at most %zu", what, got, limit);
    (void)vor_fail_over(s->err, VOR_E_REQUEST, limit, got);
    return vor_fail_at(s->err, VOR_E_REQUEST, s->at);
}

/* The byte at hand, or -1 at the end. */
static int peek(const struct scan *s)
{
    return s->at < s->size ? s->bytes[s->at] : -1;
}

static void skip_blanks(struct scan *s)
{
    int c;

    while ((c = peek(s)) == ' ' || c == '\t' || c == '\n' || c == '\r')
        s->at++;
}

static vor_status unexpected(const struct scan *s, const char *wanted)
{
    char what[96];
    int c = peek(s);

    if (c < 0)
        (void)snprintf(what, sizeof what, "the text ends, want %s", wanted);
    else if (c > 0x20 && c < 0x7f)
        (void)snprintf(what, sizeof what, "'%c', want %s", c, wanted);
    else
        (void)snprintf(what, sizeof what, "byte 0x%02x, want %s", (unsigned)c, wanted);
    return reject(s, s->at, what);
}

static vor_status count_token(struct scan *s)
{
    if (++s->tokens > VOR_JSON_TOKENS_MAX)
        return exceed(s, "too many tokens", VOR_JSON_TOKENS_MAX, s->tokens);
    return VOR_OK;
}

static int hex_digit(int c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c |= 0x20;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* The four digits after \u at `at`; -1 when they are not four. */
static long code_unit(const struct scan *s, size_t at)
{
    long unit = 0;

    if (s->size - at < 4)
        return -1;
    for (size_t i = 0; i < 4; i++) {
        int digit = hex_digit(s->bytes[at + i]);

        if (digit < 0)
            return -1;
        unit = unit * 16 + digit;
    }
    return unit;
}

/* at stands on the backslash of \u. */
static vor_status scan_unicode(struct scan *s)
{
    long unit = code_unit(s, s->at + 2), low;

    if (unit < 0)
        return reject(s, s->at, "\\u without four hexadecimal digits");
    if (unit == 0)
        return reject(s, s->at, "\\u0000, which no string may hold,");
    if (unit >= 0xdc00 && unit <= 0xdfff)
        return reject(s, s->at, "a low surrogate without a high one");
    s->at += 6;
    if (unit < 0xd800 || unit > 0xdbff)
        return VOR_OK;
    low = -1;
    if (s->size - s->at >= 6 && s->bytes[s->at] == '\\' && s->bytes[s->at + 1] == 'u')
        low = code_unit(s, s->at + 2);
    if (low < 0xdc00 || low > 0xdfff)
        return reject(s, s->at - 6, "a high surrogate without a low one");
    s->at += 6;
    return VOR_OK;
}

static vor_status scan_escape(struct scan *s)
{
    int c = s->at + 1 < s->size ? s->bytes[s->at + 1] : -1;

    if (c == 'u')
        return scan_unicode(s);
    if (c <= 0 || strchr("\"\\/bfnrt", c) == NULL)
        return reject(s, s->at, "an escape other than a backslash before \" \\ / b f n r t u");
    s->at += 2;
    return VOR_OK;
}

static vor_status scan_string(struct scan *s)
{
    vor_status status;
    size_t length;
    int c;

    for (s->at++; (c = peek(s)) != '"'; s->at += length) {
        length = 0;
        if (c < 0)
            return unexpected(s, "the end of a string");
        if (c < 0x20)
            return reject(s, s->at, "a control character in a string");
        if (c == '\\') {
            status = scan_escape(s);
            if (status != VOR_OK)
                return status;
            continue;
        }
        length = vor_utf8_length(s->bytes + s->at, s->size - s->at);
        if (length == 0)
            return reject(s, s->at, "bytes that are not UTF-8");
    }
    s->at++;
    return VOR_OK;
}

/* One digit or more. */
static int skip_digits(struct scan *s)
{
    size_t from = s->at;
    int c;

    while ((c = peek(s)) >= '0' && c <= '9')
        s->at++;
    return s->at > from;
}

static vor_status scan_number(struct scan *s)
{
    size_t from = s->at;
    char number[VOR_JSON_NUMBER_LENGTH_MAX + 1];
    size_t length;

    if (peek(s) == '-')
        s->at++;
    if (peek(s) == '0')
        s->at++;
    else if (!skip_digits(s))
        return unexpected(s, "a digit");
    if (peek(s) == '.') {
        s->at++;
        if (!skip_digits(s))
            return unexpected(s, "a digit after the point");
    }
    if (peek(s) == 'e' || peek(s) == 'E') {
        s->at++;
        if (peek(s) == '+' || peek(s) == '-')
            s->at++;
        if (!skip_digits(s))
            return unexpected(s, "a digit of the exponent");
    }
    length = s->at - from;
    if (length > VOR_JSON_NUMBER_LENGTH_MAX)
        return exceed(s, "too many characters in a number", VOR_JSON_NUMBER_LENGTH_MAX, length);
    memcpy(number, s->bytes + from, length);
    number[length] = '\0';
    if (!isfinite(strtod(number, NULL)))
        return reject(s, from, "a number beyond the range of a double");
    return VOR_OK;
}

static vor_status scan_value(struct scan *s);

static vor_status scan_key(struct scan *s)
{
    vor_status status;

    if (peek(s) != '"')
        return unexpected(s, "a key");
    status = count_token(s);
    if (status != VOR_OK)
        return status;
    status = scan_string(s);
    if (status != VOR_OK)
        return status;
    skip_blanks(s);
    if (peek(s) != ':')
        return unexpected(s, "':'");
    s->at++;
    skip_blanks(s);
    return VOR_OK;
}

/* Elements or members up to the closing bracket; at stands on the opening one. */
static vor_status scan_nested(struct scan *s, int object)
{
    const char close = object ? '}' : ']';
    vor_status status = VOR_OK;

    if (++s->depth > VOR_JSON_DEPTH_MAX)
        return exceed(s, "nested too deeply", VOR_JSON_DEPTH_MAX, s->depth);
    s->at++;
    skip_blanks(s);
    if (peek(s) != close) {
        for (;;) {
            if (object)
                status = scan_key(s);
            VOR_THEN(status, scan_value(s));
            if (status != VOR_OK)
                return status;
            skip_blanks(s);
            if (peek(s) != ',')
                break;
            s->at++;
            skip_blanks(s);
        }
    }
    if (peek(s) != close)
        return unexpected(s, object ? "',' or '}'" : "',' or ']'");
    s->at++;
    s->depth--;
    return VOR_OK;
}

static vor_status scan_value(struct scan *s)
{
    vor_status status = count_token(s);
    const char *word;
    int c = peek(s);

    if (status != VOR_OK)
        return status;
    if (c == '{' || c == '[')
        return scan_nested(s, c == '{');
    if (c == '"')
        return scan_string(s);
    if (c == '-' || (c >= '0' && c <= '9'))
        return scan_number(s);
    word = c == 't' ? "true" : c == 'f' ? "false" : "null";
    if (s->size - s->at < strlen(word) || memcmp(s->bytes + s->at, word, strlen(word)) != 0)
        return unexpected(s, "a value");
    s->at += strlen(word);
    return VOR_OK;
}

vor_status vor_json_scan(const char *bytes, size_t size, struct vor_error *err)
{
    struct scan s = {(const unsigned char *)bytes, size, 0, 0, 0, err};
    vor_status status;

    if (size > VOR_JSON_SIZE_MAX)
        return exceed(&s, "too many bytes", VOR_JSON_SIZE_MAX, size);
    skip_blanks(&s);
    status = scan_value(&s);
    if (status != VOR_OK)
        return status;
    skip_blanks(&s);
    return s.at == size ? VOR_OK : unexpected(&s, "nothing after the value");
}
