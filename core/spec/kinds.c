#include "core/spec/kinds.h"

#include "core/base/status.h"
#include "core/base/utf8.h"
#include "core/spec/decimal.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A buffer that text is appended to; cuts what does not fit. */
struct line {
    char *text;
    size_t size, at;
};

static void add(struct line *line, const char *format, ...) VOR_PRINTF(2, 3);

static void add(struct line *line, const char *format, ...)
{
    va_list args;
    int length;

    va_start(args, format);
    length = vsnprintf(line->text + line->at, line->size - line->at, format, args);
    va_end(args);
    assert(length >= 0);
    line->at += (size_t)length;
    if (line->at >= line->size)
        line->at = line->size - 1;
}

/* A row of the table of forms. */
struct form {
    /* Reads text; true when it is in this form and in range. */
    int (*read)(const struct vor_parameter_info *info, const char *text, struct vor_value *out);

    /* Writes a value that is. */
    void (*write)(const struct vor_parameter_info *info, double value, const char *name,
                  struct line *out);

    /* What may be given, in a sentence and in a list: as `say` writes them. */
    const char *want, *values;
};

/* Numbers. */

static int read_real(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    double number;

    if (!vor_decimal_read(&number, text, strlen(text)) ||
        !(number >= info->min && number <= info->max))
        return 0;
    out->number = number;
    return 1;
}

static int read_whole(const struct vor_parameter_info *info, const char *text,
                      struct vor_value *out)
{
    double number;

    if (!vor_decimal_read_count(&number, text) || !(number >= info->min && number <= info->max) ||
        number != rint(number))
        return 0;
    out->number = number;
    return 1;
}

/* With the fewest of 15, 16 and 17 digits that read back as the value. */
static void write_number(const struct vor_parameter_info *info, double value, const char *name,
                         struct line *out)
{
    char text[32];
    int digits = 15;

    (void)info, (void)name;
    do
        (void)snprintf(text, sizeof text, "%.*g", digits, value);
    while (strtod(text, NULL) != value && ++digits <= 17);
    add(out, "%s", text);
}

/* Words. A word with a colon is a pattern of the form NAME. */

static int is_named(const char *word, size_t length)
{
    return memchr(word, ':', length) != NULL;
}

/* Finds the next allowed choice from *index on, among those with a colon or those without. Returns
 * its length, 0 past the last, and sets *index to its index. */
static size_t next_choice(const struct vor_parameter_info *info, int named, unsigned *index,
                          const char **word)
{
    size_t length;

    while ((length = vor_parameter_choice(info, *index, word)) > 0 &&
           ((info->allowed >> *index & 1) == 0 || is_named(*word, length) != named))
        ++*index;
    return length;
}

/* The index of a word of `length` bytes; -1 when it is none. */
static int find_word(const struct vor_parameter_info *info, const char *text, size_t length)
{
    const char *word;
    size_t of_word;

    for (unsigned i = 0; (of_word = next_choice(info, 0, &i, &word)) > 0; i++)
        if (of_word == length && memcmp(word, text, length) == 0)
            return (int)i;
    return -1;
}

static void list_words(const struct vor_parameter_info *info, int named, const char *between,
                       struct line *out)
{
    const char *word, *before = "";
    size_t length;

    for (unsigned i = 0; (length = next_choice(info, named, &i, &word)) > 0; i++) {
        add(out, "%s%.*s", before, (int)length, word);
        before = between;
    }
}

static int read_choice(const struct vor_parameter_info *info, const char *text,
                       struct vor_value *out)
{
    int index = find_word(info, text, strlen(text));

    out->number = index;
    return index >= 0;
}

static void write_choice(const struct vor_parameter_info *info, double value, const char *name,
                         struct line *out)
{
    const char *word;
    size_t length = vor_parameter_choice(info, (unsigned)value, &word);

    (void)name;
    add(out, "%.*s", (int)length, word);
}

static int read_word(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    int index = find_word(info, text, strlen(text));

    out->number = VOR_WORD(index);
    return index >= 0;
}

static void write_word(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    write_choice(info, VOR_WORD(value), name, out);
}

/* Texts. */

static int is_text(const struct vor_parameter_info *info, const char *text)
{
    size_t size = strlen(text);

    return (double)size >= info->min && (double)size <= info->max && vor_utf8_is_plain(text, size);
}

static int read_text(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    *out = (struct vor_value){1, text};
    return is_text(info, text);
}

static void write_text(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    (void)info, (void)value;
    add(out, "%s", name);
}

static int read_name(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    const char *word;
    size_t length;

    for (unsigned i = 0; (length = next_choice(info, 1, &i, &word)) > 0; i++) {
        size_t before = strcspn(word, ":") + 1;

        if (strncmp(text, word, before) != 0)
            continue;
        *out = (struct vor_value){i, text + before};
        return is_text(info, text + before);
    }
    return 0;
}

static void write_name(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    const char *word;

    (void)vor_parameter_choice(info, (unsigned)value, &word);
    add(out, "%.*s%s", (int)strcspn(word, ":") + 1, word, name);
}

/* Vectors, three numbers, and counts, whole ones: with commas between; they stand in the text. */

static int read_vector(const struct vor_parameter_info *info, const char *text,
                       struct vor_value *out)
{
    double numbers[3];

    *out = (struct vor_value){VOR_VECTOR, text};
    if (!vor_decimal_read_vector(numbers, text))
        return 0;
    for (int c = 0; c < 3; c++)
        if (!(numbers[c] >= info->min && numbers[c] <= info->max))
            return 0;
    return 1;
}

static int read_counts(const struct vor_parameter_info *info, const char *text,
                       struct vor_value *out)
{
    *out = (struct vor_value){VOR_COUNTS, text};
    return vor_decimal_are_counts(text, info->min, info->max);
}

/* Flags. */

static int read_flag(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    (void)info;
    out->number = strcmp(text, "true") == 0;
    return out->number == 1 || strcmp(text, "false") == 0;
}

static void write_flag(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    (void)info, (void)name;
    add(out, "%s", value != 0 ? "true" : "false");
}

/* Lists: words with commas between, each at most once; an empty one is written "none". */

#define EMPTY_LIST "none"

static int read_list(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    uint64_t set = 0;
    size_t length;

    out->number = 0;
    if (strcmp(text, EMPTY_LIST) == 0)
        return 1;
    for (;; text += length + 1) {
        int index;

        length = strcspn(text, ",");
        index = find_word(info, text, length);
        if (index < 0 || (set >> index & 1) != 0)
            return 0;
        set |= (uint64_t)1 << index;
        if (text[length] == '\0')
            break;
    }
    out->number = (double)set;
    return 1;
}

static int has_unknown(const struct vor_parameter_info *info, const char *text)
{
    int is_unknown = 0;
    size_t length;

    for (;; text += length + 1) {
        length = strcspn(text, ",");
        if (length == 0)
            return 0;
        is_unknown |= find_word(info, text, length) < 0;
        if (text[length] == '\0')
            return is_unknown;
    }
}

static void write_list(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    const char *word, *before = "";
    size_t length;

    (void)name;
    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++) {
        if (!vor_list_has(value, i))
            continue;
        add(out, "%s%.*s", before, (int)length, word);
        before = ",";
    }
    if (value == 0)
        add(out, EMPTY_LIST);
}

/* Auto. */

static int read_auto(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    (void)info;
    out->number = VOR_UNSET;
    return strcmp(text, "auto") == 0;
}

static void write_auto(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    (void)info, (void)value, (void)name;
    add(out, "auto");
}

#define RANGE "< to >^"

static const struct form forms[VOR_FORM_NONE] = {
    [VOR_FORM_WHOLE] = {read_whole, write_number, "a whole number from < to >", RANGE},
    [VOR_FORM_REAL] = {read_real, write_number, "a number from < to >", RANGE},
    [VOR_FORM_CHOICE] = {read_choice, write_choice, "one of *", "*"},
    [VOR_FORM_WORD] = {read_word, write_word, "one of *", "*"},
    [VOR_FORM_NAME] = {read_name, write_name, "@ of < to > bytes", "@"},
    [VOR_FORM_VECTOR] = {read_vector, write_text, "X,Y,Z of numbers from < to >", "X,Y,Z"},
    [VOR_FORM_FLAG] = {read_flag, write_flag, "true or false", "true | false"},
    [VOR_FORM_TEXT] = {read_text, write_text, "text of < to > bytes", "text of < to > bytes"},
    [VOR_FORM_LIST] = {read_list, write_list,
                       "words separated by commas, each at most once: *, or " EMPTY_LIST,
                       "some of + | " EMPTY_LIST},
    [VOR_FORM_COUNTS] = {read_counts, write_text,
                         "whole numbers from < to >, each once, separated by commas", RANGE},
    [VOR_FORM_AUTO] = {read_auto, write_auto, "auto", "auto"},
};

/* Whether a value is in a form. */
static int owns(enum vor_form form, const struct vor_parameter_info *info, double value)
{
    const char *word;
    size_t length;

    switch (form) {
    case VOR_FORM_AUTO:
        return value == VOR_UNSET;
    case VOR_FORM_WORD:
        return value < VOR_UNSET;
    case VOR_FORM_VECTOR:
    case VOR_FORM_COUNTS:
        return value == VOR_VECTOR;
    case VOR_FORM_CHOICE:
    case VOR_FORM_NAME:
        length = value >= 0 ? vor_parameter_choice(info, (unsigned)value, &word) : 0;
        return length > 0 && is_named(word, length) == (form == VOR_FORM_NAME);
    default:
        return value > VOR_UNSET;
    }
}

/* Writes a text of the table: < and > are the bounds and ^ the unit, * the words and @ the names
 * with `between` between them, + the words with commas. */
static void say(const struct vor_parameter_info *info, const char *text, const char *between,
                struct line *out)
{
    const char *unit = strncmp(info->unit, "unit ", 5) == 0 ? ", in the " : " ";

    for (; *text != '\0'; text++)
        if (*text == '<' || *text == '>')
            add(out, "%.16g", *text == '<' ? info->min : info->max);
        else if (*text == '^')
            add(out, "%s%s", info->unit[0] != '\0' ? unit : "", info->unit);
        else if (*text == '*' || *text == '@' || *text == '+')
            list_words(info, *text == '@', *text == '+' ? "," : between, out);
        else
            add(out, "%c", *text);
}

enum vor_form vor_kind_form_of(const struct vor_parameter_info *info, double value)
{
    enum vor_form form;

    for (unsigned i = 0; (form = vor_kind_form(info->kind, i)) != VOR_FORM_NONE; i++)
        if (owns(form, info, value))
            break;
    return form;
}

int vor_kind_read(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    enum vor_form form;

    for (unsigned i = 0; (form = vor_kind_form(info->kind, i)) != VOR_FORM_NONE; i++) {
        struct vor_value value = {0, NULL};

        if (!forms[form].read(info, text, &value))
            continue;
        *out = value;
        return 1;
    }
    return 0;
}

int vor_kind_has_unknown_word(const struct vor_parameter_info *info, const char *text)
{
    return vor_kind_form(info->kind, 0) == VOR_FORM_LIST && has_unknown(info, text);
}

int vor_kind_expand(const struct vor_parameter_info *info, const char *text,
                    char out[VOR_KIND_NUMBER_SIZE])
{
    double number;

    if (vor_kind_form(info->kind, 0) != VOR_FORM_WHOLE ||
        vor_decimal_read(&number, text, strlen(text)) || !vor_decimal_read_count(&number, text))
        return 0;
    (void)snprintf(out, VOR_KIND_NUMBER_SIZE, "%.15g", number);
    return 1;
}

void vor_kind_write(const struct vor_parameter_info *info, double value, const char *name,
                    char *out, size_t size)
{
    enum vor_form form = vor_kind_form_of(info, value);
    struct line line = {out, size, 0};

    assert(size > 0);
    out[0] = '\0';
    if (form != VOR_FORM_NONE)
        forms[form].write(info, value, name, &line);
}

/* Writes what may be given in each form of a kind. */
static void say_all(const struct vor_parameter_info *info, int values, char *text)
{
    struct line line = {text, VOR_KIND_WORDS_SIZE, 0};
    enum vor_form form;

    for (unsigned i = 0; (form = vor_kind_form(info->kind, i)) != VOR_FORM_NONE; i++) {
        if (i > 0)
            add(&line, values ? " | " : " or ");
        say(info, values ? forms[form].values : forms[form].want, values ? " | " : ", ", &line);
    }
}

void vor_kind_want(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE])
{
    say_all(info, 0, out);
}

void vor_kind_values(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE])
{
    say_all(info, 1, out);
}
