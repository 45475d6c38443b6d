#include "core/spec.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct vor_parameter_info infos[VOR_PARAMETER_COUNT] = {
#define INFO_ROW(id, name, kind, unit, min, max, fallback, choices, sentence)                      \
    {#name, VOR_KIND_##kind, unit, min, max, fallback, choices, sentence},
    VOR_PARAMETER_TABLE(INFO_ROW)
#undef INFO_ROW
};

static const struct vor_process_info processes[] = {
#define PROCESS_ROW(id, name, ratio_min, ratio_max, title, sentence)                               \
    {#name, ratio_min, ratio_max, title, sentence},
    VOR_PROCESS_TABLE(PROCESS_ROW)
#undef PROCESS_ROW
};

enum { PROCESS_COUNT = sizeof processes / sizeof processes[0] };

enum {
#define PROCESS_INDEX(id, name, ratio_min, ratio_max, title, sentence) PROCESS_##id,
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

size_t vor_parameter_choice(enum vor_parameter parameter, unsigned index, const char **word)
{
    const char *at = vor_parameter_info(parameter)->choices;
    size_t length;

    for (;; at += length + 1) {
        length = strcspn(at, " ");
        if (index-- == 0) {
            *word = at;
            return length;
        }
        if (at[length] == '\0')
            return 0;
    }
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
    return info;
}

void vor_spec_preset(struct vor_spec *spec, const struct vor_process_info *process)
{
    spec->process = process;
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
        spec->value[i] = vor_process_parameter(process, (enum vor_parameter)i).fallback;
    spec->value[VOR_PARAM_RATIO] = VOR_UNSET; /* points or spacing may come in its place */
}

void vor_spec_init(struct vor_spec *spec)
{
    vor_spec_preset(spec, &processes[PROCESS_RESAMPLE]);
}

static vor_status unknown_name(const char *name, struct vor_error *err)
{
    char names[200] = "";
    size_t at = 0;

    for (int i = 0; i < VOR_PARAMETER_COUNT && at < sizeof names; i++)
        at += (size_t)snprintf(names + at, sizeof names - at, "%s%s", i > 0 ? ", " : "",
                               infos[i].name);
    return vor_fail_param(err, VOR_E_PARAM, name, "no parameter %.20s; there are %s", name, names);
}

/* "a, b or c" for messages. */
static void list_choices(const struct vor_parameter_info *info, char *out, size_t size)
{
    size_t at = 0;

    for (const char *c = info->choices; *c != '\0' && at + 2 < size; c++) {
        if (*c == ' ')
            out[at++] = ',';
        out[at++] = *c;
    }
    out[at] = '\0';
}

static vor_status bad_choice(const struct vor_parameter_info *info, const char *text,
                             struct vor_error *err)
{
    char words[64];

    list_choices(info, words, sizeof words);
    return vor_fail_param(err, VOR_E_PARAM, info->name, "%s is \"%.40s\", want one of %s",
                          info->name, text, words);
}

static vor_status bad_number(const struct vor_parameter_info *info, const char *text,
                             struct vor_error *err)
{
    int whole = info->kind != VOR_KIND_REAL;

    return vor_fail_param(
        err, VOR_E_PARAM, info->name, "%s is %.40s, want %s from %.16g to %.16g%s", info->name,
        text[0] != '\0' ? text : "empty", whole ? "a whole number" : "a number", info->min,
        info->max, info->kind == VOR_KIND_COUNT_OR_AUTO ? " or auto" : "");
}

static int in_range(const struct vor_parameter_info *info, double number)
{
    if (!(number >= info->min && number <= info->max))
        return 0;
    return info->kind == VOR_KIND_REAL || number == rint(number);
}

/* A decimal number and nothing else. strtod would also take hexadecimal, blanks, "inf" and, in some
 * locales, a comma: only digits, sign, point and exponent reach it, and only in the C locale that a
 * program starts with. */
static int parse_number(const char *text, double *out)
{
    char *end;

    if (text[0] == '\0' || strlen(text) > 40 || text[strspn(text, "+-.0123456789eE")] != '\0' ||
        strcspn(text, "0123456789") == strlen(text))
        return 0;
    *out = strtod(text, &end);
    return *end == '\0' && isfinite(*out);
}

static vor_status set_choice(struct vor_spec *spec, enum vor_parameter parameter, const char *text,
                             struct vor_error *err)
{
    const char *word;
    size_t length;

    for (unsigned i = 0; (length = vor_parameter_choice(parameter, i, &word)) > 0; i++) {
        if (strlen(text) != length || memcmp(word, text, length) != 0)
            continue;
        spec->value[parameter] = i;
        return VOR_OK;
    }
    return bad_choice(&infos[parameter], text, err);
}

vor_status vor_spec_set(struct vor_spec *spec, const char *name, const char *text,
                        struct vor_error *err)
{
    enum vor_parameter parameter = vor_parameter_find(name);
    struct vor_parameter_info info;
    double number;

    if (parameter == VOR_PARAMETER_COUNT)
        return unknown_name(name, err);
    info = vor_process_parameter(spec->process, parameter);
    if (info.kind == VOR_KIND_CHOICE)
        return set_choice(spec, parameter, text, err);
    if (info.kind == VOR_KIND_COUNT_OR_AUTO && strcmp(text, "auto") == 0) {
        spec->value[parameter] = VOR_UNSET;
        return VOR_OK;
    }
    if (!parse_number(text, &number) || !in_range(&info, number))
        return bad_number(&info, text, err);
    spec->value[parameter] = number;
    return VOR_OK;
}

vor_status vor_spec_set_number(struct vor_spec *spec, const char *name, double number,
                               struct vor_error *err)
{
    enum vor_parameter parameter = vor_parameter_find(name);
    struct vor_parameter_info info;
    char text[32];

    if (parameter == VOR_PARAMETER_COUNT)
        return unknown_name(name, err);
    info = vor_process_parameter(spec->process, parameter);
    (void)snprintf(text, sizeof text, "%.17g", number);
    if (info.kind == VOR_KIND_CHOICE)
        return bad_choice(&info, text, err);
    if (!in_range(&info, number))
        return bad_number(&info, text, err);
    spec->value[parameter] = number;
    return VOR_OK;
}

static int counts_given(const struct vor_spec *spec)
{
    return vor_spec_given(spec, VOR_PARAM_POINTS) + vor_spec_given(spec, VOR_PARAM_RATIO) +
           vor_spec_given(spec, VOR_PARAM_SPACING);
}

vor_status vor_spec_check(const struct vor_spec *spec, struct vor_error *err)
{
    int given = counts_given(spec);

    if (given == 1)
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "points",
                          "%d of points, ratio and spacing are given, want exactly one", given);
}

vor_status vor_spec_complete(struct vor_spec *spec, struct vor_error *err)
{
    if (counts_given(spec) == 0)
        spec->value[VOR_PARAM_RATIO] =
            vor_process_parameter(spec->process, VOR_PARAM_RATIO).fallback;
    return vor_spec_check(spec, err);
}

double vor_spec_target(const struct vor_spec *spec, uint64_t input)
{
    if (vor_spec_given(spec, VOR_PARAM_RATIO))
        return rint(spec->value[VOR_PARAM_RATIO] * (double)input);
    return spec->value[VOR_PARAM_POINTS];
}

static enum vor_parameter count_given(const struct vor_spec *spec)
{
    if (vor_spec_given(spec, VOR_PARAM_RATIO))
        return VOR_PARAM_RATIO;
    return vor_spec_given(spec, VOR_PARAM_SPACING) ? VOR_PARAM_SPACING : VOR_PARAM_POINTS;
}

vor_status vor_spec_check_target(const struct vor_spec *spec, double target, uint64_t input,
                                 struct vor_error *err)
{
    const struct vor_parameter_info *points = &infos[VOR_PARAM_POINTS];
    const struct vor_process_info *process = spec->process;
    enum vor_parameter from = count_given(spec);
    double least = fmax(points->min, process->ratio_min * (double)input);
    double most = fmin(points->max, process->ratio_max * (double)input);
    char asked[48] = "", times[32] = "up to";

    if (target >= least && target <= most)
        return VOR_OK;
    if (least > most)
        return vor_fail_param(err, VOR_E_TARGET, infos[from].name,
                              "%s of %llu points asks for %.0f or more, want at most %.0f",
                              process->id, (unsigned long long)input, least, most);
    if (from != VOR_PARAM_POINTS)
        (void)snprintf(asked, sizeof asked, " and asks for %.16g points", target);
    if (process->ratio_min > 0)
        (void)snprintf(times, sizeof times, "%g to", process->ratio_min);
    return vor_fail_param(
        err, VOR_E_TARGET, infos[from].name,
        "%s is %.10g%s, want %.0f to %.0f: %s gives %s %g for each of the input's %llu",
        infos[from].name, spec->value[from], asked, least, most, process->id, times,
        process->ratio_max, (unsigned long long)input);
}

int vor_spec_given(const struct vor_spec *spec, enum vor_parameter parameter)
{
    return vor_parameter_info(parameter)->kind == VOR_KIND_COUNT_OR_AUTO ||
           spec->value[parameter] != VOR_UNSET;
}

uint32_t vor_spec_iterations(const struct vor_spec *spec)
{
    enum { BEFORE_POLISH = 12, ALONE = 100 };

    if (vor_spec_given(spec, VOR_PARAM_ITERATIONS))
        return (uint32_t)spec->value[VOR_PARAM_ITERATIONS];
    return spec->value[VOR_PARAM_POLISH] > 0 ? BEFORE_POLISH : ALONE;
}

const char *vor_spec_text(const struct vor_spec *spec, enum vor_parameter parameter, char *out,
                          size_t size)
{
    const struct vor_parameter_info *info = vor_parameter_info(parameter);
    double value = spec->value[parameter];
    const char *word = "";

    assert(size > 0);
    out[0] = '\0';
    if (value == VOR_UNSET) {
        if (info->kind == VOR_KIND_COUNT_OR_AUTO)
            (void)snprintf(out, size, "auto");
    } else if (info->kind == VOR_KIND_CHOICE) {
        size_t length = vor_parameter_choice(parameter, (unsigned)value, &word);

        (void)snprintf(out, size, "%.*s", (int)length, word);
    } else {
        (void)snprintf(out, size, "%.17g", value);
    }
    return out;
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
