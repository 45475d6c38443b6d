#include "server/base/markup.h"

#include <string.h>

enum { COLUMNS = 79, CODE_INDENT = 4, ITEM_INDENT = 2, MEANING_INDENT = 6 };

static size_t line_length(const char *at)
{
    return strcspn(at, "\n");
}

static const char *after_line(const char *at)
{
    at += line_length(at);
    return *at == '\n' ? at + 1 : at;
}

static int is_blank(const char *at)
{
    return at[strspn(at, " ")] == '\n';
}

static struct vor_span_of_text between(const char *begin, const char *end)
{
    while (end > begin && end[-1] == '\n')
        end--;
    return (struct vor_span_of_text){begin, (size_t)(end - begin)};
}

/* "term", "term   what it means", or "term" with what it means below. */
static const char *take_item(struct vor_markup_block *out, const char *at)
{
    const char *term = at + ITEM_INDENT;
    const char *end = after_line(at);
    const char *wide = strstr(term, "  ");

    out->kind = VOR_MARKUP_ITEM;
    out->term = between(term, wide != NULL && wide < end ? wide : end);
    while (*end != '\0' && !is_blank(end) && strspn(end, " ") >= MEANING_INDENT)
        end = after_line(end);
    out->text = between(term + out->term.length, end);
    return end;
}

/* Lines of code may have blank ones between them. The first is one, however deep. */
static const char *take_code(struct vor_markup_block *out, const char *at)
{
    const char *begin = at, *end = at;

    do {
        at = after_line(at);
        if (*at == '\0' || !is_blank(at))
            end = at;
    } while (*at != '\0' && (is_blank(at) || strspn(at, " ") >= CODE_INDENT));
    out->kind = VOR_MARKUP_CODE;
    out->text = between(begin, end);
    return end;
}

static const char *take_text(struct vor_markup_block *out, const char *at)
{
    const char *end = after_line(at);
    size_t dashes = strspn(end, "-");

    if (dashes >= 3 && dashes == line_length(end)) { /* an underline */
        out->kind = VOR_MARKUP_HEADING;
        out->text = between(at, end);
        return after_line(end);
    }
    while (*end != '\0' && !is_blank(end) && *end != ' ' && *end != '%')
        end = after_line(end);
    out->kind = VOR_MARKUP_PARAGRAPH;
    out->text = between(at, end);
    return end;
}

int vor_markup_next(struct vor_markup_block *out, const char **at)
{
    static const char table[] = "%table ";
    const char *from = *at;

    memset(out, 0, sizeof *out);
    for (; *from != '\0'; from = after_line(from)) {
        if (strncmp(from, table, sizeof table - 1) == 0) {
            out->kind = VOR_MARKUP_TABLE;
            out->term = between(from + sizeof table - 1, after_line(from));
            *at = after_line(from);
            return 1;
        }
        if (!is_blank(from) && *from != '%')
            break;
    }
    if (*from == '\0')
        return 0;
    switch (strspn(from, " ")) {
    case 0:
        *at = take_text(out, from);
        return 1;
    case ITEM_INDENT:
        *at = take_item(out, from);
        return 1;
    default:
        *at = take_code(out, from);
        return 1;
    }
}

int vor_markup_word(struct vor_span_of_text *out, struct vor_span_of_text *text)
{
    const char *end = text->at + text->length;

    while (text->at < end && (*text->at == ' ' || *text->at == '\n'))
        text->at++;
    out->at = text->at;
    while (text->at < end && *text->at != ' ' && *text->at != '\n')
        text->at++;
    out->length = (size_t)(text->at - out->at);
    text->length = (size_t)(end - text->at);
    return out->length > 0;
}

int vor_markup_line(struct vor_span_of_text *out, struct vor_span_of_text *text)
{
    const char *end = text->at + text->length;
    const char *newline;

    if (text->at >= end)
        return 0;
    newline = memchr(text->at, '\n', text->length);
    *out = between(text->at, newline != NULL ? newline : end);
    for (int i = 0; i < CODE_INDENT && out->length > 0; i++, out->at++)
        out->length--;
    text->at = newline != NULL ? newline + 1 : end;
    text->length = (size_t)(end - text->at);
    return 1;
}

void vor_markup_wrap(FILE *out, struct vor_span_of_text text, int column, int indent)
{
    struct vor_span_of_text word;
    int is_first = 1;

    while (vor_markup_word(&word, &text)) {
        int width = 0;

        for (size_t i = 0; i < word.length; i++) /* UTF-8: bytes that begin a character */
            width += ((unsigned char)word.at[i] & 0xc0) != 0x80;
        if (!is_first && column + 1 + width > COLUMNS) {
            (void)fprintf(out, "\n%*s", indent, "");
            column = indent;
        } else if (!is_first) {
            (void)fputc(' ', out);
            column++;
        }
        (void)fwrite(word.at, 1, word.length, out);
        column += width;
        is_first = 0;
    }
    (void)fputc('\n', out);
}

void vor_markup_wrap_string(FILE *out, const char *text, int indent)
{
    (void)fprintf(out, "%*s", indent, "");
    vor_markup_wrap(out, (struct vor_span_of_text){text, strlen(text)}, indent, indent);
}
