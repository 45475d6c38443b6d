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
    enum vor_shape shape;

    /* Reads text; true when it is in this form and in range. */
    int (*read)(const struct vor_parameter_info *info, const char *text, struct vor_value *out);

    /* True when the value is in this form. */
    int (*owns)(const struct vor_parameter_info *info, double value);

    /* Writes a value that is. */
    void (*write)(const struct vor_parameter_info *info, double value, const char *name,
                  struct line *out);

    /* What may be given, in a sentence and in a list. */
    void (*want)(const struct vor_parameter_info *info, struct line *out);
    void (*values)(const struct vor_parameter_info *info, struct line *out);
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

static int owns_number(const struct vor_parameter_info *info, double value)
{
    (void)info;
    return value > VOR_UNSET;
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

static void want_whole(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "a whole number from %.16g to %.16g", info->min, info->max);
}

static void want_real(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "a number from %.16g to %.16g", info->min, info->max);
}

static void list_range(const struct vor_parameter_info *info, struct line *out)
{
    const char *before = strncmp(info->unit, "unit ", 5) == 0 ? ", in the " : " ";

    add(out, "%.16g to %.16g%s%s", info->min, info->max, info->unit[0] != '\0' ? before : "",
        info->unit);
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

static int owns_choice(const struct vor_parameter_info *info, double value)
{
    const char *word;
    size_t length = value >= 0 ? vor_parameter_choice(info, (unsigned)value, &word) : 0;

    return length > 0 && !is_named(word, length);
}

static void write_choice(const struct vor_parameter_info *info, double value, const char *name,
                         struct line *out)
{
    const char *word;
    size_t length = vor_parameter_choice(info, (unsigned)value, &word);

    (void)name;
    add(out, "%.*s", (int)length, word);
}

static void want_choice(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "one of ");
    list_words(info, 0, ", ", out);
}

static void list_choices(const struct vor_parameter_info *info, struct line *out)
{
    list_words(info, 0, " | ", out);
}

static int read_word(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    int index = find_word(info, text, strlen(text));

    out->number = VOR_WORD(index);
    return index >= 0;
}

static int owns_word(const struct vor_parameter_info *info, double value)
{
    (void)info;
    return value < VOR_UNSET;
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

static void want_text(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "text of %.16g to %.16g bytes", info->min, info->max);
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

static int owns_name(const struct vor_parameter_info *info, double value)
{
    const char *word;
    size_t length = value >= 0 ? vor_parameter_choice(info, (unsigned)value, &word) : 0;

    return length > 0 && is_named(word, length);
}

static void write_name(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    const char *word;

    (void)vor_parameter_choice(info, (unsigned)value, &word);
    add(out, "%.*s%s", (int)strcspn(word, ":") + 1, word, name);
}

static void want_name(const struct vor_parameter_info *info, struct line *out)
{
    list_words(info, 1, ", ", out);
    add(out, " of %.16g to %.16g bytes", info->min, info->max);
}

static void list_names(const struct vor_parameter_info *info, struct line *out)
{
    list_words(info, 1, " | ", out);
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

static int owns_vector(const struct vor_parameter_info *info, double value)
{
    (void)info;
    return value == VOR_VECTOR;
}

static void want_vector(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "X,Y,Z of numbers from %.16g to %.16g", info->min, info->max);
}

static void list_vector(const struct vor_parameter_info *info, struct line *out)
{
    (void)info;
    add(out, "X,Y,Z");
}

static int read_counts(const struct vor_parameter_info *info, const char *text,
                       struct vor_value *out)
{
    *out = (struct vor_value){VOR_COUNTS, text};
    return vor_decimal_are_counts(text, info->min, info->max);
}

static void want_counts(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "whole numbers from %.16g to %.16g, each once, separated by commas", info->min,
        info->max);
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

static void want_flag(const struct vor_parameter_info *info, struct line *out)
{
    (void)info;
    add(out, "true or false");
}

static void list_flag(const struct vor_parameter_info *info, struct line *out)
{
    (void)info;
    add(out, "true | false");
}

/* Lists: words with commas between, each at most once; an empty one is written "none". */

static const char empty_list[] = "none";

static int read_list(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    uint64_t set = 0;
    size_t length;

    out->number = 0;
    if (strcmp(text, empty_list) == 0)
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
        add(out, "%s", empty_list);
}

static void want_list(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "words separated by commas, each at most once: ");
    list_words(info, 0, ", ", out);
    add(out, ", or %s", empty_list);
}

static void list_list(const struct vor_parameter_info *info, struct line *out)
{
    add(out, "some of ");
    list_words(info, 0, ",", out);
    add(out, " | %s", empty_list);
}

/* Auto. */

static int read_auto(const struct vor_parameter_info *info, const char *text, struct vor_value *out)
{
    (void)info;
    out->number = VOR_UNSET;
    return strcmp(text, "auto") == 0;
}

static int owns_auto(const struct vor_parameter_info *info, double value)
{
    (void)info;
    return value == VOR_UNSET;
}

static void write_auto(const struct vor_parameter_info *info, double value, const char *name,
                       struct line *out)
{
    (void)info, (void)value, (void)name;
    add(out, "auto");
}

static void want_auto(const struct vor_parameter_info *info, struct line *out)
{
    (void)info;
    add(out, "auto");
}

static const struct form forms[VOR_FORM_NONE] = {
    [VOR_FORM_WHOLE] = {VOR_SHAPE_NUMBER, read_whole, owns_number, write_number, want_whole,
                        list_range},
    [VOR_FORM_REAL] = {VOR_SHAPE_NUMBER, read_real, owns_number, write_number, want_real,
                       list_range},
    [VOR_FORM_CHOICE] = {VOR_SHAPE_STRING, read_choice, owns_choice, write_choice, want_choice,
                         list_choices},
    [VOR_FORM_WORD] = {VOR_SHAPE_STRING, read_word, owns_word, write_word, want_choice,
                       list_choices},
    [VOR_FORM_NAME] = {VOR_SHAPE_STRING, read_name, owns_name, write_name, want_name, list_names},
    [VOR_FORM_VECTOR] = {VOR_SHAPE_STRING, read_vector, owns_vector, write_text, want_vector,
                         list_vector},
    [VOR_FORM_FLAG] = {VOR_SHAPE_BOOLEAN, read_flag, owns_number, write_flag, want_flag, list_flag},
    [VOR_FORM_TEXT] = {VOR_SHAPE_STRING, read_text, owns_number, write_text, want_text, want_text},
    [VOR_FORM_LIST] = {VOR_SHAPE_ARRAY, read_list, owns_number, write_list, want_list, list_list},
    [VOR_FORM_COUNTS] = {VOR_SHAPE_ARRAY, read_counts, owns_vector, write_text, want_counts,
                         list_range},
    [VOR_FORM_AUTO] = {VOR_SHAPE_STRING, read_auto, owns_auto, write_auto, want_auto, want_auto},
};

static const char *const shape_words[] = {
    [VOR_SHAPE_NUMBER] = "a number",
    [VOR_SHAPE_BOOLEAN] = "a boolean",
    [VOR_SHAPE_STRING] = "a string",
    [VOR_SHAPE_ARRAY] = "an array",
};

const char *vor_shape_word(enum vor_shape shape)
{
    assert(shape > VOR_SHAPE_ANY && shape <= VOR_SHAPE_ARRAY);
    return shape_words[shape];
}

/* The row of form number `index` of a kind; NULL past the last. */
static const struct form *form_of(enum vor_kind kind, unsigned index)
{
    enum vor_form form = vor_kind_form(kind, index);

    return form != VOR_FORM_NONE ? &forms[form] : NULL;
}

int vor_kind_has_shape(enum vor_kind kind, enum vor_shape shape)
{
    const struct form *form;

    for (unsigned i = 0; (form = form_of(kind, i)) != NULL; i++)
        if (form->shape == shape)
            return 1;
    return shape == VOR_SHAPE_ANY;
}

enum vor_form vor_kind_form_of(const struct vor_parameter_info *info, double value)
{
    const struct form *form;

    for (unsigned i = 0; (form = form_of(info->kind, i)) != NULL; i++)
        if (form->owns(info, value))
            return vor_kind_form(info->kind, i);
    return VOR_FORM_NONE;
}

int vor_kind_read(const struct vor_parameter_info *info, enum vor_shape shape, const char *text,
                  struct vor_value *out)
{
    const struct form *form;

    for (unsigned i = 0; (form = form_of(info->kind, i)) != NULL; i++) {
        struct vor_value value = {0, NULL};

        if ((shape != VOR_SHAPE_ANY && shape != form->shape) || !form->read(info, text, &value))
            continue;
        *out = value;
        return 1;
    }
    return 0;
}

int vor_kind_has_unknown_word(const struct vor_parameter_info *info, enum vor_shape shape,
                              const char *text)
{
    enum vor_form form;

    for (unsigned i = 0; (form = vor_kind_form(info->kind, i)) != VOR_FORM_NONE; i++)
        if (form == VOR_FORM_LIST && (shape == VOR_SHAPE_ANY || shape == forms[form].shape))
            return has_unknown(info, text);
    return 0;
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

void vor_kind_want(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE])
{
    struct line line = {out, VOR_KIND_WORDS_SIZE, 0};
    const struct form *form;

    for (unsigned i = 0; (form = form_of(info->kind, i)) != NULL; i++) {
        if (i > 0)
            add(&line, " or ");
        form->want(info, &line);
    }
}

void vor_kind_values(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE])
{
    struct line line = {out, VOR_KIND_WORDS_SIZE, 0};
    const struct form *form;

    for (unsigned i = 0; (form = form_of(info->kind, i)) != NULL; i++) {
        if (i > 0)
            add(&line, " | ");
        form->values(info, &line);
    }
}
