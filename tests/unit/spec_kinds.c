/* Each kind of parameter on a row of the test's own: what it takes, what it refuses, how it is
 * written, and what it says that it wants. */
#include "core/spec/kinds.h"
#include "tests/support/vt.h"

#include <string.h>

#define WORDS "mls outliers thin"

static const struct vor_parameter_info rows[VOR_KINDS] = {
    [VOR_KIND_COUNT] = {.min = 0, .max = 9007199254740991, .unit = "points", .choices = ""},
    [VOR_KIND_REAL] = {.min = 1e-30, .max = 1e30, .unit = "", .choices = ""},
    [VOR_KIND_CHOICE] = {.unit = "", .choices = WORDS},
    [VOR_KIND_FLAG] = {.unit = "", .choices = ""},
    [VOR_KIND_TEXT] = {.min = 1, .max = 8, .unit = "", .choices = ""},
    [VOR_KIND_LIST] = {.unit = "", .choices = WORDS},
    [VOR_KIND_CHOICE_OR_NAME] = {.min = 1, .max = 8, .unit = "", .choices = "even attribute:NAME"},
    [VOR_KIND_CHOICE_OR_VECTOR] = {.min = -10, .max = 1e6, .unit = "", .choices = "auto near"},
    [VOR_KIND_COUNT_OR_AUTO] = {.min = 6, .max = 500, .unit = "points", .choices = ""},
    [VOR_KIND_REAL_OR_AUTO] = {.min = 0, .max = 2.5, .unit = "s", .choices = ""},
    [VOR_KIND_REAL_OR_WORD] = {.min = 0, .max = 10, .unit = "", .choices = "mean max"},
    [VOR_KIND_LIST_OR_AUTO] = {.unit = "", .choices = WORDS},
    [VOR_KIND_COUNTS_OR_AUTO] = {.min = 1, .max = 1000, .unit = "", .choices = ""},
};

static struct vor_parameter_info row_of(enum vor_kind kind)
{
    struct vor_parameter_info row = rows[kind];

    row.kind = kind;
    row.name = "it";
    row.allowed = ~0ull;
    return row;
}

/* Vectors: a text, the value it stands for, its form and how it is written back. */
static const struct {
    enum vor_kind kind;
    const char *text;
    double value;
    enum vor_form form;
    const char *written; /* NULL: as text */
} taken[] = {
    {VOR_KIND_COUNT, "0", 0, VOR_FORM_WHOLE, NULL},
    {VOR_KIND_COUNT, "9007199254740991", 9007199254740991, VOR_FORM_WHOLE, NULL},
    {VOR_KIND_COUNT, "+1.20e2", 120, VOR_FORM_WHOLE, "120"},
    {VOR_KIND_COUNT, "0100.", 100, VOR_FORM_WHOLE, "100"},
    {VOR_KIND_COUNT, "1.0E+2", 100, VOR_FORM_WHOLE, "100"},
    {VOR_KIND_COUNT, "10k", 10000, VOR_FORM_WHOLE, "10000"},
    {VOR_KIND_COUNT, "1K", 1000, VOR_FORM_WHOLE, "1000"},
    {VOR_KIND_COUNT, "1.5M", 1500000, VOR_FORM_WHOLE, "1500000"},
    {VOR_KIND_COUNT, "0.001k", 1, VOR_FORM_WHOLE, "1"},
    {VOR_KIND_COUNT, "+1.001k", 1001, VOR_FORM_WHOLE, "1001"}, /* 1.001 * 1000 is less */
    {VOR_KIND_COUNT_OR_AUTO, "0.5k", 500, VOR_FORM_WHOLE, "500"},
    {VOR_KIND_REAL, "1e-30", 1e-30, VOR_FORM_REAL, NULL},
    {VOR_KIND_REAL, "0.10000000000000001", 0.1, VOR_FORM_REAL, "0.1"},
    {VOR_KIND_REAL, "0.30000000000000004", 0.30000000000000004, VOR_FORM_REAL, NULL},
    {VOR_KIND_REAL, "0.5", 0.5, VOR_FORM_REAL, NULL},
    {VOR_KIND_CHOICE, "mls", 0, VOR_FORM_CHOICE, NULL},
    {VOR_KIND_CHOICE, "thin", 2, VOR_FORM_CHOICE, NULL},
    {VOR_KIND_FLAG, "true", 1, VOR_FORM_FLAG, NULL},
    {VOR_KIND_FLAG, "false", 0, VOR_FORM_FLAG, NULL},
    {VOR_KIND_TEXT, "a", 1, VOR_FORM_TEXT, NULL},
    {VOR_KIND_TEXT, "a \"b\" \\c", 1, VOR_FORM_TEXT, NULL},
    {VOR_KIND_TEXT, "\xc3\xa9\xe2\x82\xac\xc2\xb2x", 1, VOR_FORM_TEXT, NULL},
    {VOR_KIND_LIST, "none", 0, VOR_FORM_LIST, NULL},
    {VOR_KIND_LIST, "outliers", 2, VOR_FORM_LIST, NULL},
    {VOR_KIND_LIST, "thin,mls", 5, VOR_FORM_LIST, "mls,thin"},
    {VOR_KIND_LIST, "mls,outliers,thin", 7, VOR_FORM_LIST, NULL},
    {VOR_KIND_CHOICE_OR_NAME, "even", 0, VOR_FORM_CHOICE, NULL},
    {VOR_KIND_CHOICE_OR_NAME, "attribute:a", 1, VOR_FORM_NAME, NULL},
    {VOR_KIND_CHOICE_OR_NAME, "attribute:a:b c,d", 1, VOR_FORM_NAME, NULL},
    {VOR_KIND_CHOICE_OR_VECTOR, "auto", 0, VOR_FORM_CHOICE, NULL},
    {VOR_KIND_CHOICE_OR_VECTOR, "near", 1, VOR_FORM_CHOICE, NULL},
    {VOR_KIND_CHOICE_OR_VECTOR, "-10,1e6,+0.5", VOR_VECTOR, VOR_FORM_VECTOR, NULL},
    {VOR_KIND_COUNT_OR_AUTO, "6", 6, VOR_FORM_WHOLE, NULL},
    {VOR_KIND_COUNT_OR_AUTO, "auto", VOR_UNSET, VOR_FORM_AUTO, NULL},
    {VOR_KIND_REAL_OR_AUTO, "0", 0, VOR_FORM_REAL, NULL},
    {VOR_KIND_REAL_OR_AUTO, "2.5", 2.5, VOR_FORM_REAL, NULL},
    {VOR_KIND_REAL_OR_AUTO, "auto", VOR_UNSET, VOR_FORM_AUTO, NULL},
    {VOR_KIND_REAL_OR_WORD, "0", 0, VOR_FORM_REAL, NULL},
    {VOR_KIND_REAL_OR_WORD, "mean", VOR_WORD(0), VOR_FORM_WORD, NULL},
    {VOR_KIND_REAL_OR_WORD, "max", VOR_WORD(1), VOR_FORM_WORD, NULL},
    {VOR_KIND_LIST_OR_AUTO, "auto", VOR_UNSET, VOR_FORM_AUTO, NULL},
    {VOR_KIND_LIST_OR_AUTO, "none", 0, VOR_FORM_LIST, NULL},
    {VOR_KIND_LIST_OR_AUTO, "mls", 1, VOR_FORM_LIST, NULL},
    {VOR_KIND_COUNTS_OR_AUTO, "auto", VOR_UNSET, VOR_FORM_AUTO, NULL},
    {VOR_KIND_COUNTS_OR_AUTO, "3", VOR_COUNTS, VOR_FORM_COUNTS, NULL},
    {VOR_KIND_COUNTS_OR_AUTO, "7,1,1000", VOR_COUNTS, VOR_FORM_COUNTS, NULL},
};

VT_TEST_LOOP(a_text_is_read_as_its_value_and_written_back, (int)(sizeof taken / sizeof taken[0]))
{
    struct vor_parameter_info row = row_of(taken[_i].kind);
    struct vor_value value;
    char text[64];

    ck_assert_msg(vor_kind_read(&row, taken[_i].text, &value), "%s", taken[_i].text);
    ck_assert(value.number == taken[_i].value);
    ck_assert_int_eq(vor_kind_form_of(&row, value.number), taken[_i].form);
    vor_kind_write(&row, value.number, value.text, text, sizeof text);
    ck_assert_str_eq(text, taken[_i].written != NULL ? taken[_i].written : taken[_i].text);
}

static const struct {
    enum vor_kind kind;
    const char *text;
} refused[] = {
    {VOR_KIND_COUNT, "-1"},
    {VOR_KIND_COUNT, "0.5"},
    {VOR_KIND_COUNT, "9007199254740993"},
    {VOR_KIND_COUNT, "auto"},
    {VOR_KIND_COUNT, "1.2345k"},
    {VOR_KIND_COUNT, "k"},
    {VOR_KIND_COUNT, "+k"},
    {VOR_KIND_COUNT, ".M"},
    {VOR_KIND_COUNT, "1m"},
    {VOR_KIND_COUNT, "1kk"},
    {VOR_KIND_COUNT, "1 k"},
    {VOR_KIND_COUNT, "1e3k"},
    {VOR_KIND_COUNT, "-1k"},
    {VOR_KIND_COUNT, "0x1k"},
    {VOR_KIND_COUNT, "00000000000000000000000000000000000000001k"}, /* 42 bytes */
    {VOR_KIND_COUNT_OR_AUTO, "1k"},
    {VOR_KIND_REAL, "1k"},
    {VOR_KIND_REAL_OR_AUTO, "0.001k"},
    {VOR_KIND_REAL, "0"},
    {VOR_KIND_REAL, "1.1e30"},
    {VOR_KIND_REAL, "nan"},
    {VOR_KIND_REAL, "1e999"},
    {VOR_KIND_CHOICE, "ml"},
    {VOR_KIND_CHOICE, "mlss"},
    {VOR_KIND_CHOICE, "mls outliers"},
    {VOR_KIND_CHOICE, "0"},
    {VOR_KIND_FLAG, "1"},
    {VOR_KIND_FLAG, "yes"},
    {VOR_KIND_FLAG, "True"},
    {VOR_KIND_TEXT, "123456789"},                                /* nine bytes */
    {VOR_KIND_TEXT, "\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9"}, /* five characters, ten bytes */
    {VOR_KIND_TEXT, "a\nb"},
    {VOR_KIND_TEXT, "a\x7f"},
    {VOR_KIND_TEXT, "\xc3"},
    {VOR_KIND_TEXT, "\xed\xa0\x80"}, /* a surrogate */
    {VOR_KIND_LIST, "mls,"},
    {VOR_KIND_LIST, ",mls"},
    {VOR_KIND_LIST, "mls,,thin"},
    {VOR_KIND_LIST, "mls,mls"},
    {VOR_KIND_LIST, "mls thin"},
    {VOR_KIND_LIST, "mls,none"},
    {VOR_KIND_LIST, "auto"},
    {VOR_KIND_CHOICE_OR_NAME, "attribute:"},
    {VOR_KIND_CHOICE_OR_NAME, "attribute:NAMENAMEN"},
    {VOR_KIND_CHOICE_OR_NAME, "attribute"},
    {VOR_KIND_CHOICE_OR_NAME, "even:x"},
    {VOR_KIND_CHOICE_OR_NAME, "attribute:a\tb"},
    {VOR_KIND_CHOICE_OR_VECTOR, "far"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1,2"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1,2,3,4"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1,2,3,"},
    {VOR_KIND_CHOICE_OR_VECTOR, ",1,2"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1, 2,3"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1,2,3 "},
    {VOR_KIND_CHOICE_OR_VECTOR, "1,2,nan"},
    {VOR_KIND_CHOICE_OR_VECTOR, "1,0x2,3"},
    {VOR_KIND_CHOICE_OR_VECTOR, "-10.5,0,0"},
    {VOR_KIND_CHOICE_OR_VECTOR, "0,0,1000001"},
    {VOR_KIND_CHOICE_OR_VECTOR, "0,1e999,0"},
    {VOR_KIND_CHOICE_OR_VECTOR, "auto,auto,auto"},
    {VOR_KIND_COUNT_OR_AUTO, "5"},
    {VOR_KIND_COUNT_OR_AUTO, "Auto"},
    {VOR_KIND_COUNT_OR_AUTO, "-1"},
    {VOR_KIND_REAL_OR_AUTO, "2.6"},
    {VOR_KIND_REAL_OR_AUTO, "-1"},
    {VOR_KIND_REAL_OR_WORD, "-2"},
    {VOR_KIND_REAL_OR_WORD, "11"},
    {VOR_KIND_REAL_OR_WORD, "min"},
    {VOR_KIND_LIST_OR_AUTO, "mls,auto"},
    {VOR_KIND_LIST_OR_AUTO, "-1"},
    {VOR_KIND_COUNTS_OR_AUTO, "0"},
    {VOR_KIND_COUNTS_OR_AUTO, "1001"},
    {VOR_KIND_COUNTS_OR_AUTO, "1.5"},
    {VOR_KIND_COUNTS_OR_AUTO, "1,"},
    {VOR_KIND_COUNTS_OR_AUTO, ",1"},
    {VOR_KIND_COUNTS_OR_AUTO, "1,2,1"},
    {VOR_KIND_COUNTS_OR_AUTO, "2,2.0"},
    {VOR_KIND_COUNTS_OR_AUTO, "1, 2"},
    {VOR_KIND_COUNTS_OR_AUTO, "1,auto"},
    {VOR_KIND_COUNTS_OR_AUTO, "none"},
};

VT_TEST_LOOP(what_is_not_of_the_kind_is_refused, (int)(sizeof refused / sizeof refused[0]))
{
    struct vor_parameter_info row = row_of(refused[_i].kind);
    struct vor_value value = {42, "untouched"};

    ck_assert_msg(!vor_kind_read(&row, refused[_i].text, &value), "%s", refused[_i].text);
    ck_assert(value.number == 42);
    ck_assert_str_eq(value.text, "untouched");
}

VT_TEST_LOOP(no_kind_takes_nothing, VOR_KINDS)
{
    struct vor_parameter_info row = row_of((enum vor_kind)_i);
    struct vor_value value;

    ck_assert(!vor_kind_read(&row, "", &value));
    ck_assert(!vor_kind_read(&row, "\x01", &value));
}

VT_TEST_LOOP(a_kind_says_what_it_wants, VOR_KINDS)
{
    static const struct {
        const char *want, *values;
    } says[VOR_KINDS] = {
        [VOR_KIND_COUNT] = {"a whole number from 0 to 9007199254740991",
                            "0 to 9007199254740991 points"},
        [VOR_KIND_REAL] = {"a number from 1e-30 to 1e+30", "1e-30 to 1e+30"},
        [VOR_KIND_CHOICE] = {"one of mls, outliers, thin", "mls | outliers | thin"},
        [VOR_KIND_FLAG] = {"true or false", "true | false"},
        [VOR_KIND_TEXT] = {"text of 1 to 8 bytes", "text of 1 to 8 bytes"},
        [VOR_KIND_LIST] = {"words separated by commas, each at most once: mls, outliers, "
                           "thin, or none",
                           "some of mls,outliers,thin | none"},
        [VOR_KIND_CHOICE_OR_NAME] = {"one of even or attribute:NAME of 1 to 8 bytes",
                                     "even | attribute:NAME"},
        [VOR_KIND_CHOICE_OR_VECTOR] = {"one of auto, near or X,Y,Z of numbers from -10 to 1000000",
                                       "auto | near | X,Y,Z"},
        [VOR_KIND_COUNT_OR_AUTO] = {"a whole number from 6 to 500 or auto",
                                    "6 to 500 points | auto"},
        [VOR_KIND_REAL_OR_AUTO] = {"a number from 0 to 2.5 or auto", "0 to 2.5 s | auto"},
        [VOR_KIND_REAL_OR_WORD] = {"a number from 0 to 10 or one of mean, max",
                                   "0 to 10 | mean | max"},
        [VOR_KIND_LIST_OR_AUTO] = {"words separated by commas, each at most once: mls, "
                                   "outliers, thin, or none or auto",
                                   "some of mls,outliers,thin | none | auto"},
        [VOR_KIND_COUNTS_OR_AUTO] =
            {"whole numbers from 1 to 1000, each once, separated by commas or auto",
             "1 to 1000 | auto"},
    };
    struct vor_parameter_info row = row_of((enum vor_kind)_i);
    char text[VOR_KIND_WORDS_SIZE];

    vor_kind_want(&row, text);
    ck_assert_str_eq(text, says[_i].want);
    vor_kind_values(&row, text);
    ck_assert_str_eq(text, says[_i].values);
}

/* A word that a process does not allow is neither taken nor offered. */
VT_TEST_LOOP(a_word_that_is_not_allowed_is_no_word, 2)
{
    static const enum vor_kind kinds[] = {VOR_KIND_CHOICE, VOR_KIND_LIST};
    struct vor_parameter_info row = row_of(kinds[_i]);
    char text[VOR_KIND_WORDS_SIZE];
    struct vor_value value;

    row.allowed = 5; /* mls and thin */
    ck_assert(vor_kind_read(&row, "thin", &value));
    ck_assert(value.number == (_i == 0 ? 2 : 4));
    ck_assert(!vor_kind_read(&row, "outliers", &value));
    vor_kind_want(&row, text);
    ck_assert_ptr_null(strstr(text, "outliers"));
    ck_assert_ptr_nonnull(strstr(text, "mls, thin"));
}

VT_TEST_LOOP(a_value_that_is_not_given_has_no_form_and_no_text, 9)
{
    static const enum vor_kind kinds[] = {
        VOR_KIND_COUNT,          VOR_KIND_REAL,         VOR_KIND_CHOICE,
        VOR_KIND_FLAG,           VOR_KIND_TEXT,         VOR_KIND_LIST,
        VOR_KIND_CHOICE_OR_NAME, VOR_KIND_REAL_OR_WORD, VOR_KIND_CHOICE_OR_VECTOR};
    struct vor_parameter_info row = row_of(kinds[_i]);
    char text[16] = "x";

    ck_assert_int_eq(vor_kind_form_of(&row, VOR_UNSET), VOR_FORM_NONE);
    vor_kind_write(&row, VOR_UNSET, NULL, text, sizeof text);
    ck_assert_str_eq(text, "");
}
