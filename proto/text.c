#include "proto/text.h"

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

void vor_text_append(struct vor_text *text, const void *bytes, size_t size)
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
    vor_text_append(text, bytes, size);
    text->comma = 0;
}

void vor_text_puts(struct vor_text *text, const char *string)
{
    vor_text_add(text, string, strlen(string));
}

void vor_text_escape(struct vor_text *text, const char *string)
{
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";

    for (; *string != '\0'; string++)
        vor_text_printf(text, strchr(plain, *string) != NULL ? "%c" : "%%%02X",
                        (unsigned char)*string);
}

void vor_text_printf(struct vor_text *text, const char *format, ...)
{
    int length;
    va_list args;

    text->comma = 0;
    va_start(args, format);
    length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    if (length < 0 || !grow(text, (size_t)length)) {
        text->failed = 1;
        return;
    }
    va_start(args, format);
    (void)vsnprintf(text->data + text->size, (size_t)length + 1, format, args);
    va_end(args);
    text->size += (size_t)length;
}

vor_status vor_text_status(const struct vor_text *text, struct vor_error *err)
{
    if (!text->failed)
        return VOR_OK;
    return vor_fail(err, VOR_E_NOMEM, "a text of more than %zu bytes (at most %zu are allowed)",
                    text->size, text->cap);
}

int vor_text_take(void *text, const void *bytes, size_t size)
{
    struct vor_text *out = text;

    vor_text_append(out, bytes, size);
    return out->failed ? -1 : 0;
}

size_t vor_line_length(const char *text, size_t size)
{
    size_t length = 0;

    while (length < size && text[length] != '\r' && text[length] != '\n')
        length++;
    return length;
}
