/* A request as JSON: what is written of it, what of a stranger's object is taken for one, and the
 * schema of a parameter. */
#include "proto/json/json.h"

#include <assert.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* The value of a parameter, in the form that it has. */
static void put_value(struct vor_text *text, const struct vor_spec *spec,
                      enum vor_parameter parameter, enum vor_form form)
{
    const struct vor_parameter_info *info = vor_parameter_info(parameter);
    char value[VOR_SPEC_VALUE_SIZE];
    const char *word;
    double number;
    size_t length;

    switch (form) {
    case VOR_FORM_WHOLE:
    case VOR_FORM_REAL:
        vor_json_double(text, spec->value[parameter]);
        break;
    case VOR_FORM_FLAG:
        vor_json_bool(text, spec->value[parameter] != 0);
        break;
    case VOR_FORM_LIST:
        vor_json_begin_array(text);
        for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++)
            if (vor_list_has(spec->value[parameter], i))
                vor_json_bytes(text, word, length);
        vor_json_end_array(text);
        break;
    case VOR_FORM_COUNTS:
        vor_json_begin_array(text);
        for (unsigned i = 0; vor_spec_count_at(spec, parameter, i, &number); i++)
            vor_json_double(text, number);
        vor_json_end_array(text);
        break;
    default:
        vor_json_string(text, vor_spec_text(spec, parameter, value));
    }
}

/* The words of an enum: those without a name that the process allows. */
static void put_words(struct vor_text *text, const struct vor_parameter_info *info)
{
    const char *word;
    size_t length;

    vor_json_put_array(text, "enum");
    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++)
        if (memchr(word, ':', length) == NULL && (info->allowed >> i & 1) != 0)
            vor_json_bytes(text, word, length);
    vor_json_end_array(text);
}

/* "^(NAME|NAME):.{1,64}$" */
static void put_pattern(struct vor_text *text, const struct vor_parameter_info *info)
{
    const char *word, *before = "";
    char pattern[VOR_SPEC_VALUE_SIZE] = "^(";
    size_t length, at = 2;

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

/* The members of a schema that a form answers to. */
static void put_schema(struct vor_text *text, const struct vor_parameter_info *info,
                       enum vor_form form)
{
    static const char *const types[VOR_FORM_NONE] = {
        [VOR_FORM_WHOLE] = "integer", [VOR_FORM_REAL] = "number",  [VOR_FORM_FLAG] = "boolean",
        [VOR_FORM_LIST] = "array",    [VOR_FORM_COUNTS] = "array",
    };

    vor_json_put_string(text, "type", types[form] != NULL ? types[form] : "string");
    switch (form) {
    case VOR_FORM_WHOLE:
    case VOR_FORM_REAL:
        vor_json_put_double(text, "minimum", info->min);
        vor_json_put_double(text, "maximum", info->max);
        break;
    case VOR_FORM_CHOICE:
    case VOR_FORM_WORD:
        put_words(text, info);
        break;
    case VOR_FORM_NAME:
        put_pattern(text, info);
        break;
    case VOR_FORM_VECTOR:
        vor_json_put_string(text, "pattern", "^[-+.0-9eE]+,[-+.0-9eE]+,[-+.0-9eE]+$");
        break;
    case VOR_FORM_TEXT:
        vor_json_put_double(text, "minLength", info->min > 0 ? 1 : 0);
        vor_json_put_double(text, "maxLength", info->max);
        break;
    case VOR_FORM_LIST:
    case VOR_FORM_COUNTS:
        vor_json_put_bool(text, "uniqueItems", 1);
        vor_json_put_object(text, "items");
        put_schema(text, info, form == VOR_FORM_LIST ? VOR_FORM_WORD : VOR_FORM_WHOLE);
        vor_json_end_object(text);
        break;
    case VOR_FORM_AUTO:
        vor_json_put_array(text, "enum");
        vor_json_string(text, "auto");
        vor_json_end_array(text);
        break;
    case VOR_FORM_FLAG:
    case VOR_FORM_NONE:
        break;
    }
}

void vor_json_spec_value(struct vor_text *text, const struct vor_spec *spec,
                         enum vor_parameter parameter)
{
    enum vor_form form = vor_spec_form(spec, parameter);

    assert(form != VOR_FORM_NONE);
    put_value(text, spec, parameter, form);
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
        put_value(text, spec, parameter, form);
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
        vor_json_put_array(text, "oneOf");
    }
    for (unsigned i = 0; (form = vor_kind_form(info.kind, i)) != VOR_FORM_NONE; i++) {
        if (has_two)
            vor_json_begin_object(text);
        put_schema(text, &info, form);
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
        put_value(text, &spec, parameter, form);
    }
    if (info.unit[0] != '\0')
        vor_json_put_string(text, "x-unit", info.unit);
    vor_json_end_object(text);
}

/* As the query has it: an array is a list of words, which has commas between. */
static vor_status set_member(struct vor_spec *spec, const struct vor_json *member,
                             struct vor_error *err)
{
    int is_list = vor_json_kind(member) == VOR_JSON_ARRAY;
    const struct vor_json *part = is_list ? vor_json_first(member) : member;
    struct vor_text text;
    vor_status status;

    vor_text_init(&text, 0);
    for (; part != NULL; part = is_list ? vor_json_next(part) : NULL) {
        if (text.size > 0)
            vor_text_puts(&text, ",");
        if (vor_json_get_string(part) != NULL)
            vor_text_puts(&text, vor_json_get_string(part));
        else
            vor_json_copy(&text, part);
    }
    status = vor_text_status(&text, err);
    VOR_THEN(status, vor_spec_set(spec, vor_json_name(member),
                                  text.size > 0 ? text.data
                                  : is_list     ? "none"
                                                : "",
                                  err));
    vor_text_free(&text);
    return status;
}

vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                              struct vor_error *err)
{
    struct vor_spec next = *spec;
    vor_status status = VOR_OK;

    if (vor_json_kind(object) != VOR_JSON_OBJECT)
        return vor_fail(err, VOR_E_PARAM, "the parameters are no object");
    for (const struct vor_json *m = vor_json_first(object); m != NULL && status == VOR_OK;
         m = vor_json_next(m))
        status = set_member(&next, m, err);
    if (status == VOR_OK)
        *spec = next;
    return status;
}
