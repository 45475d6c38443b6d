#include "proto/json/json_spec.h"

#include "core/base/quote.h"
#include "proto/json/json_write.h"

#include <string.h>

void vor_json_spec(struct vor_text *text, const struct vor_spec *spec)
{
    vor_json_begin_object(text);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;
        const struct vor_parameter_info *info = vor_parameter_info(parameter);
        char word[64];

        if (!vor_spec_given(spec, parameter))
            continue;
        if (info->kind == VOR_KIND_CHOICE || spec->value[i] == VOR_UNSET)
            vor_json_put_string(text, info->name,
                                vor_spec_text(spec, parameter, word, sizeof word));
        else
            vor_json_put_double(text, info->name, spec->value[i]);
    }
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

/* Text is for choices and auto: a number in quotes is a mistake that is better named. Names and
 * words are quoted for the message; those that are right stay as they are. */
static vor_status set_member(struct vor_spec *spec, const struct vor_json *member,
                             struct vor_error *err)
{
    const char *word = vor_json_get_string(member);
    struct vor_parameter_info info;
    char name[32], quoted[64];
    double number;

    vor_quote(name, sizeof name, vor_json_name(member), strlen(vor_json_name(member)));
    if (vor_parameter_find(name) == VOR_PARAMETER_COUNT) /* refuses the name */
        return vor_spec_set(spec, name, "", err);
    info = vor_process_parameter(spec->process, vor_parameter_find(name));
    if (vor_json_get_number(member, &number))
        return vor_spec_set_number(spec, name, number, err);
    if (word != NULL && (info.kind == VOR_KIND_CHOICE ||
                         (info.kind == VOR_KIND_COUNT_OR_AUTO && strcmp(word, "auto") == 0)))
        return vor_spec_set(spec, name, vor_quote(quoted, sizeof quoted, word, strlen(word)), err);
    if (info.kind == VOR_KIND_CHOICE)
        return vor_fail_param(err, VOR_E_PARAM, name, "%s is %s, want one of the words %s", name,
                              vor_json_kind_word(member), info.choices);
    return vor_fail_param(err, VOR_E_PARAM, name, "%s is %s, want a number from %.16g to %.16g%s",
                          name, vor_json_kind_word(member), info.min, info.max,
                          info.kind == VOR_KIND_COUNT_OR_AUTO ? " or \"auto\"" : "");
}

vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                              char pointer[VOR_JSON_POINTER_MAX], struct vor_error *err)
{
    struct vor_spec next = *spec;

    pointer[0] = '\0';
    if (vor_json_kind(object) != VOR_JSON_OBJECT)
        return vor_fail(err, VOR_E_PARAM, "the parameters are %s, want an object",
                        vor_json_kind_word(object));
    for (const struct vor_json *m = vor_json_first(object); m != NULL; m = vor_json_next(m)) {
        vor_status status = set_member(&next, m, err);

        if (status != VOR_OK) {
            write_pointer(pointer, vor_json_name(m));
            return status;
        }
    }
    *spec = next;
    return VOR_OK;
}
