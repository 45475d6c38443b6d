/* A request as JSON: what is written of it, what of a stranger's object is taken for one, and the
 * schema of a parameter. */
#include "proto/json/json.h"

#include "core/base/quote.h"

#include <assert.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* The value of a parameter, in each form. */

static void put_number(struct vor_text *text, const struct vor_spec *spec,
                       enum vor_parameter parameter)
{
    vor_json_double(text, spec->value[parameter]);
}

static void put_flag(struct vor_text *text, const struct vor_spec *spec,
                     enum vor_parameter parameter)
{
    vor_json_bool(text, spec->value[parameter] != 0);
}

static void put_text(struct vor_text *text, const struct vor_spec *spec,
                     enum vor_parameter parameter)
{
    char value[VOR_SPEC_VALUE_SIZE];

    vor_json_string(text, vor_spec_text(spec, parameter, value));
}

static void put_list(struct vor_text *text, const struct vor_spec *spec,
                     enum vor_parameter parameter)
{
    const char *word;
    size_t length;

    vor_json_begin_array(text);
    for (unsigned i = 0;
         (length = vor_parameter_choice(vor_parameter_info(parameter), i, &word)) > 0; i++)
        if (vor_list_has(spec->value[parameter], i))
            vor_json_bytes(text, word, length);
    vor_json_end_array(text);
}

static void put_counts(struct vor_text *text, const struct vor_spec *spec,
                       enum vor_parameter parameter)
{
    double number;

    vor_json_begin_array(text);
    for (unsigned i = 0; vor_spec_count_at(spec, parameter, i, &number); i++)
        vor_json_double(text, number);
    vor_json_end_array(text);
}

/* The members of a schema that a form answers to. */

static void put_range(struct vor_text *text, const struct vor_parameter_info *info,
                      const char *type)
{
    vor_json_put_string(text, "type", type);
    vor_json_put_double(text, "minimum", info->min);
    vor_json_put_double(text, "maximum", info->max);
}

static void schema_whole(struct vor_text *text, const struct vor_parameter_info *info)
{
    put_range(text, info, "integer");
}

static void schema_real(struct vor_text *text, const struct vor_parameter_info *info)
{
    put_range(text, info, "number");
}

/* The words without a name that the process allows. */
static void schema_words(struct vor_text *text, const struct vor_parameter_info *info)
{
    const char *word;
    size_t length;

    vor_json_put_string(text, "type", "string");
    vor_json_key(text, "enum");
    vor_json_begin_array(text);
    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++)
        if (memchr(word, ':', length) == NULL && (info->allowed >> i & 1) != 0)
            vor_json_bytes(text, word, length);
    vor_json_end_array(text);
}

static void schema_name(struct vor_text *text, const struct vor_parameter_info *info)
{
    const char *word, *before = "";
    char pattern[VOR_SPEC_VALUE_SIZE] = "^(";
    size_t length, at = 2;

    vor_json_put_string(text, "type", "string");
    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++) {
        const char *colon = memchr(word, ':', length);

        if (colon == NULL)
            continue;
        at += (size_t)snprintf(pattern + at, sizeof pattern - at, "%s%.*s", before,
                               (int)(colon - word), word);
        before = "|";
    }
    (void)snprintf(pattern + at, sizeof pattern - at, "):.{1,%.0f}$", info->max);
    vor_json_put_string(text, "pattern", pattern);
}

static void schema_vector(struct vor_text *text, const struct vor_parameter_info *info)
{
    (void)info;
    vor_json_put_string(text, "type", "string");
    vor_json_put_string(text, "pattern", "^[-+.0-9eE]+,[-+.0-9eE]+,[-+.0-9eE]+$");
}

static void schema_flag(struct vor_text *text, const struct vor_parameter_info *info)
{
    (void)info;
    vor_json_put_string(text, "type", "boolean");
}

static void schema_text(struct vor_text *text, const struct vor_parameter_info *info)
{
    vor_json_put_string(text, "type", "string");
    vor_json_put_double(text, "minLength", info->min > 0 ? 1 : 0);
    vor_json_put_double(text, "maxLength", info->max);
}

static void schema_list(struct vor_text *text, const struct vor_parameter_info *info)
{
    vor_json_put_string(text, "type", "array");
    vor_json_put_bool(text, "uniqueItems", 1);
    vor_json_key(text, "items");
    vor_json_begin_object(text);
    schema_words(text, info);
    vor_json_end_object(text);
}

static void schema_counts(struct vor_text *text, const struct vor_parameter_info *info)
{
    vor_json_put_string(text, "type", "array");
    vor_json_put_bool(text, "uniqueItems", 1);
    vor_json_key(text, "items");
    vor_json_begin_object(text);
    schema_whole(text, info);
    vor_json_end_object(text);
}

static void schema_auto(struct vor_text *text, const struct vor_parameter_info *info)
{
    (void)info;
    vor_json_put_string(text, "type", "string");
    vor_json_key(text, "enum");
    vor_json_begin_array(text);
    vor_json_string(text, "auto");
    vor_json_end_array(text);
}

static const struct {
    void (*put)(struct vor_text *text, const struct vor_spec *spec, enum vor_parameter parameter);
    void (*schema)(struct vor_text *text, const struct vor_parameter_info *info);
} forms[VOR_FORM_NONE] = {
    [VOR_FORM_WHOLE] = {put_number, schema_whole},   [VOR_FORM_REAL] = {put_number, schema_real},
    [VOR_FORM_CHOICE] = {put_text, schema_words},    [VOR_FORM_WORD] = {put_text, schema_words},
    [VOR_FORM_NAME] = {put_text, schema_name},       [VOR_FORM_VECTOR] = {put_text, schema_vector},
    [VOR_FORM_FLAG] = {put_flag, schema_flag},       [VOR_FORM_TEXT] = {put_text, schema_text},
    [VOR_FORM_LIST] = {put_list, schema_list},       [VOR_FORM_AUTO] = {put_text, schema_auto},
    [VOR_FORM_COUNTS] = {put_counts, schema_counts},
};

void vor_json_spec_value(struct vor_text *text, const struct vor_spec *spec,
                         enum vor_parameter parameter)
{
    enum vor_form form = vor_spec_form(spec, parameter);

    assert(form != VOR_FORM_NONE);
    forms[form].put(text, spec, parameter);
}

static void put_parameters(struct vor_text *text, const struct vor_spec *spec, bool only_changed)
{
    vor_json_begin_object(text);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;
        enum vor_form form = vor_spec_form(spec, parameter);

        if (form == VOR_FORM_NONE || (only_changed && vor_spec_is_default(spec, parameter)))
            continue;
        vor_json_key(text, vor_parameter_info(parameter)->name);
        forms[form].put(text, spec, parameter);
    }
    vor_json_end_object(text);
}

void vor_json_spec(struct vor_text *text, const struct vor_spec *spec)
{
    put_parameters(text, spec, false);
}

void vor_json_spec_changed(struct vor_text *text, const struct vor_spec *spec)
{
    put_parameters(text, spec, true);
}

void vor_json_parameter_schema(struct vor_text *text, const struct vor_process_info *process,
                               enum vor_parameter parameter)
{
    struct vor_parameter_info info = vor_process_parameter(process, parameter);
    int has_two = vor_kind_form(info.kind, 1) != VOR_FORM_NONE;
    struct vor_spec spec;
    enum vor_form form;

    vor_json_begin_object(text);
    if (has_two) {
        vor_json_key(text, "oneOf");
        vor_json_begin_array(text);
    }
    for (unsigned i = 0; (form = vor_kind_form(info.kind, i)) != VOR_FORM_NONE; i++) {
        if (has_two)
            vor_json_begin_object(text);
        forms[form].schema(text, &info);
        if (has_two)
            vor_json_end_object(text);
    }
    if (has_two)
        vor_json_end_array(text);
    vor_spec_preset(&spec, process);
    spec.value[parameter] = info.fallback; /* that of ratio stands aside in a preset */
    form = vor_spec_form(&spec, parameter);
    if (form != VOR_FORM_NONE) {
        vor_json_key(text, "default");
        forms[form].put(text, &spec, parameter);
    }
    if (info.unit[0] != '\0')
        vor_json_put_string(text, "x-unit", info.unit);
    vor_json_end_object(text);
}

/* "/name" with ~ and / escaped as RFC 6901 wants it. */
static void write_pointer(char pointer[VOR_JSON_POINTER_MAX], const char *name)
{
    size_t at = 0;

    pointer[at++] = '/';
    for (; *name != '\0' && at + 3 <= VOR_JSON_POINTER_MAX; name++) {
        if (*name == '~' || *name == '/') {
            pointer[at++] = '~';
            pointer[at++] = *name == '~' ? '0' : '1';
        } else {
            pointer[at++] = *name;
        }
    }
    pointer[at] = '\0';
}

static vor_status set_number(struct vor_spec *spec, const struct vor_json *member,
                             struct vor_error *err)
{
    double number = 0;

    (void)vor_json_get_number(member, &number);
    return vor_spec_set_number(spec, vor_json_name(member), number, err);
}

static vor_status set_flag(struct vor_spec *spec, const struct vor_json *member,
                           struct vor_error *err)
{
    int flag = 0;

    (void)vor_json_get_bool(member, &flag);
    return vor_spec_set_as(spec, vor_json_name(member), VOR_SHAPE_BOOLEAN, flag ? "true" : "false",
                           err);
}

static vor_status set_string(struct vor_spec *spec, const struct vor_json *member,
                             struct vor_error *err)
{
    return vor_spec_set_as(spec, vor_json_name(member), VOR_SHAPE_STRING,
                           vor_json_get_string(member), err);
}

/* The words with commas between, as a list is written. What is no word stands there as JSON, which
 * is none either, so that the refusal shows it. */
static vor_status set_array(struct vor_spec *spec, const struct vor_json *member,
                            struct vor_error *err)
{
    struct vor_text words;
    vor_status status;

    vor_text_init(&words, 0);
    for (const struct vor_json *e = vor_json_first(member); e != NULL; e = vor_json_next(e)) {
        const char *word = vor_json_get_string(e);

        if (words.size > 0)
            vor_text_puts(&words, ",");
        if (word != NULL && word[0] != '\0' && strchr(word, ',') == NULL)
            vor_text_puts(&words, word);
        else
            vor_json_copy(&words, e);
    }
    status = vor_text_status(&words, err);
    if (status == VOR_OK)
        status = vor_spec_set_as(spec, vor_json_name(member), VOR_SHAPE_ARRAY,
                                 words.size > 0 ? words.data : "none", err);
    vor_text_free(&words);
    return status;
}

static vor_status set_other(struct vor_spec *spec, const struct vor_json *member,
                            struct vor_error *err)
{
    return vor_spec_refuse(spec, vor_json_name(member), vor_json_kind_word(member), err);
}

vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                              char pointer[VOR_JSON_POINTER_MAX], struct vor_error *err)
{
    static vor_status (*const sets[])(struct vor_spec *, const struct vor_json *,
                                      struct vor_error *) = {
        [VOR_JSON_NULL] = set_other,    [VOR_JSON_BOOL] = set_flag,
        [VOR_JSON_NUMBER] = set_number, [VOR_JSON_STRING] = set_string,
        [VOR_JSON_ARRAY] = set_array,   [VOR_JSON_OBJECT] = set_other,
    };
    struct vor_spec next = *spec;

    pointer[0] = '\0';
    if (vor_json_kind(object) != VOR_JSON_OBJECT)
        return vor_fail(err, VOR_E_PARAM, "the parameters are %s, want an object",
                        vor_json_kind_word(object));
    for (const struct vor_json *m = vor_json_first(object); m != NULL; m = vor_json_next(m)) {
        vor_status status = sets[vor_json_kind(m)](&next, m, err);

        if (status != VOR_OK) {
            write_pointer(pointer, vor_json_name(m));
            return status;
        }
    }
    *spec = next;
    return VOR_OK;
}
