#include "core/spec/tables.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static const struct vor_parameter_info infos[VOR_PARAMETER_COUNT] = {
#define INFO_ROW(id, name, kind, group, unit, min, max, fallback, choices, sentence)               \
    {#name, VOR_KIND_##kind, VOR_GROUP_##group, unit, min, max, fallback, choices, sentence, ~0ull},
    VOR_PARAMETER_TABLE(INFO_ROW)
#undef INFO_ROW
};

static const struct vor_process_info processes[] = {
#define PROCESS_ROW(id, name, http, groups, methods, least, most, inputs, outputs, title,          \
                    sentence)                                                                      \
    {#name, http, groups, methods, least, most, VOR_LIST inputs, VOR_LIST outputs, title, sentence},
    VOR_PROCESS_TABLE(PROCESS_ROW)
#undef PROCESS_ROW
};

enum { PROCESS_COUNT = sizeof processes / sizeof processes[0] };

enum {
#define PROCESS_INDEX(id, name, http, groups, methods, least, most, inputs, outputs, title, text)  \
    PROCESS_##id,
    VOR_PROCESS_TABLE(PROCESS_INDEX)
#undef PROCESS_INDEX
};

static const struct {
    unsigned process;
    enum vor_parameter parameter;
    double value;
} presets[] = {
#define PRESET_ROW(process, parameter, value) {PROCESS_##process, VOR_PARAM_##parameter, value},
    VOR_PRESET_TABLE(PRESET_ROW)
#undef PRESET_ROW
};

enum { PRESET_COUNT = sizeof presets / sizeof presets[0] };

static const char *const needs[VOR_PARAMETER_COUNT] = {
#define NEED_ROW(parameter, input) [VOR_PARAM_##parameter] = (input),
    VOR_NEED_TABLE(NEED_ROW)
#undef NEED_ROW
};

static const char *const group_titles[VOR_GROUP_COUNT] = {
#define GROUP_ROW(id, title) title,
    VOR_GROUP_TABLE(GROUP_ROW)
#undef GROUP_ROW
};

static const enum vor_form kind_forms[VOR_KINDS][2] = {
#define KIND_ROW(id, form, other) {VOR_FORM_##form, VOR_FORM_##other},
    VOR_KIND_TABLE(KIND_ROW)
#undef KIND_ROW
};

_Static_assert(VOR_GROUP_COUNT <= 32 && VOR_METHODS <= 32, "sets are 32 bits wide");

const struct vor_parameter_info *vor_parameter_info(enum vor_parameter parameter)
{
    assert((unsigned)parameter < VOR_PARAMETER_COUNT);
    return &infos[parameter];
}

enum vor_parameter vor_parameter_find(const char *name)
{
    int i = 0;

    while (i < VOR_PARAMETER_COUNT && strcmp(infos[i].name, name) != 0)
        i++;
    return (enum vor_parameter)i;
}

const char *vor_parameter_needs(enum vor_parameter parameter)
{
    assert((unsigned)parameter < VOR_PARAMETER_COUNT);
    return needs[parameter];
}

const char *vor_group_title(enum vor_group group)
{
    assert((unsigned)group < VOR_GROUP_COUNT);
    return group_titles[group];
}

size_t vor_parameter_choice(const struct vor_parameter_info *info, unsigned index,
                            const char **word)
{
    const char *at = info->choices + strspn(info->choices, " ");
    size_t length = strcspn(at, " ");

    for (; index > 0; index--) {
        at += length + strspn(at + length, " ");
        length = strcspn(at, " ");
    }
    *word = at;
    return length;
}

int vor_list_has(double value, unsigned index)
{
    return value > 0 && ((uint64_t)value >> index & 1) != 0;
}

enum vor_form vor_kind_form(enum vor_kind kind, unsigned index)
{
    assert((unsigned)kind < VOR_KINDS);
    return index < 2 ? kind_forms[kind][index] : VOR_FORM_NONE;
}

const struct vor_process_info *vor_process_info(unsigned index)
{
    return index < PROCESS_COUNT ? &processes[index] : NULL;
}

const struct vor_process_info *vor_process_find(const char *id)
{
    for (unsigned i = 0; i < PROCESS_COUNT; i++)
        if (strcmp(processes[i].id, id) == 0)
            return &processes[i];
    return NULL;
}

const struct vor_artefact_info *vor_artefact_find(const struct vor_artefact_info *list,
                                                  const char *name)
{
    while (list->name != NULL && strcmp(list->name, name) != 0)
        list++;
    return list->name != NULL ? list : NULL;
}

int vor_process_takes(const struct vor_process_info *process, enum vor_parameter parameter)
{
    return (process->groups >> vor_parameter_info(parameter)->group & 1) != 0;
}

struct vor_parameter_info vor_process_parameter(const struct vor_process_info *process,
                                                enum vor_parameter parameter)
{
    struct vor_parameter_info info = *vor_parameter_info(parameter);

    assert(process != NULL);
    for (int i = 0; i < PRESET_COUNT; i++)
        if (&processes[presets[i].process] == process && presets[i].parameter == parameter)
            info.fallback = presets[i].value;
    if (parameter == VOR_PARAM_RATIO) {
        info.min = fmax(info.min, process->ratio_min);
        info.max = fmin(info.max, process->ratio_max);
    }
    if (parameter == VOR_PARAM_METHOD)
        info.allowed = process->methods;
    return info;
}
