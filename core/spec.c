#include "core/spec.h"

#include "core/base/nearest.h"
#include "core/base/quote.h"
#include "core/spec/decimal.h"
#include "core/spec/kinds.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    SHOWN_SIZE = 64,                                          /* of a value in a message */
    MEANT_SIZE = VOR_KIND_NUMBER_SIZE + sizeof ", which is ", /* of what it comes to, beside it */

/* All names with a comma and a blank each. */
#define NAME_SIZE(id, name, kind, group, unit, min, max, fallback, choices, sentence)              \
    +(int)sizeof #name + 1
    NAMES_SIZE = 1 VOR_PARAMETER_TABLE(NAME_SIZE),
#undef NAME_SIZE
    PARAMETER_SIZE = sizeof((struct vor_error *)NULL)->parameter,
    MESSAGE_SIZE = sizeof((struct vor_error *)NULL)->message,
    REST_SIZE = 160 /* of a message: its other words */
};

/* Every message that the tables can produce fits, with the name and the value at fault. */
_Static_assert(NAMES_SIZE + PARAMETER_SIZE + REST_SIZE <= MESSAGE_SIZE, "the names do not fit");
_Static_assert(VOR_KIND_WORDS_SIZE + PARAMETER_SIZE + SHOWN_SIZE + MEANT_SIZE + REST_SIZE <=
                   MESSAGE_SIZE,
               "what a parameter wants does not fit");

/* In a message, words have ", " between them where the row has a blank, so they take less than
 * twice the room. A value as text is at most all words, or one of them and a text. */
#define CHECK_PARAMETER(id, name, kind, group, unit, min, max, fallback, choices, sentence)        \
    _Static_assert(sizeof #name <= PARAMETER_SIZE, "the name of a parameter is too long");         \
    _Static_assert(2 * sizeof(choices) + REST_SIZE <= VOR_KIND_WORDS_SIZE, "too many choices");    \
    _Static_assert(sizeof(choices) + VOR_SPEC_TEXTS_SIZE <= VOR_SPEC_VALUE_SIZE,                   \
                   "a value does not fit as text");
VOR_PARAMETER_TABLE(CHECK_PARAMETER)
#undef CHECK_PARAMETER
#define LIST_SIZE(list) (sizeof((const struct vor_artefact_info[])VOR_LIST list))
#define CHECK_PROCESS(id, name, http, groups, methods, least, most, inputs, outputs, title, text)  \
    _Static_assert(sizeof #name <= PARAMETER_SIZE, "the id of a process is too long");             \
    _Static_assert(LIST_SIZE(inputs) <= VOR_INPUTS_MAX * sizeof(struct vor_artefact_info) &&       \
                       LIST_SIZE(outputs) <= VOR_OUTPUTS_MAX * sizeof(struct vor_artefact_info),   \
                   "a process has too many inputs or outputs");
VOR_PROCESS_TABLE(CHECK_PROCESS)
#undef CHECK_PROCESS
#undef LIST_SIZE

void vor_spec_preset(struct vor_spec *spec, const struct vor_process_info *process)
{
    memset(spec, 0, sizeof *spec);
    spec->process = process;
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
        spec->value[i] = vor_process_parameter(process, (enum vor_parameter)i).fallback;
    spec->value[VOR_PARAM_RATIO] = VOR_UNSET; /* points or spacing may come in its place */
}

void vor_spec_init(struct vor_spec *spec)
{
    vor_spec_preset(spec, vor_process_info(0));
}

/* The texts of a request: those of the parameters that have one, in their order. */

static int has_text(const struct vor_spec *spec, int parameter)
{
    enum vor_form form =
        vor_kind_form_of(vor_parameter_info((enum vor_parameter)parameter), spec->value[parameter]);

    return form == VOR_FORM_TEXT || form == VOR_FORM_NAME || form == VOR_FORM_VECTOR ||
           form == VOR_FORM_COUNTS;
}

int vor_spec_is_default(const struct vor_spec *spec, enum vor_parameter parameter)
{
    return !has_text(spec, (int)parameter) &&
           (spec->value[parameter] == VOR_UNSET ||
            spec->value[parameter] == vor_process_parameter(spec->process, parameter).fallback);
}

int vor_spec_counts(const struct vor_spec *spec, enum vor_parameter parameter)
{
    const struct vor_when *when = vor_parameter_when(parameter);
    const char *word, *at;
    size_t length;

    if (when == NULL)
        return 1;
    length = vor_parameter_choice(vor_parameter_info(when->other),
                                  (unsigned)spec->value[when->other], &word);
    for (at = when->words; *at != '\0'; at += strspn(at, " ")) {
        size_t size = strcspn(at, " ");

        if (size == length && strncmp(at, word, size) == 0)
            return 1;
        at += size;
    }
    return 0;
}

const char *vor_spec_name(const struct vor_spec *spec, enum vor_parameter parameter)
{
    const char *text = spec->texts;

    if (!has_text(spec, (int)parameter))
        return NULL;
    for (int i = 0; i < (int)parameter; i++)
        if (has_text(spec, i))
            text += strlen(text) + 1;
    return text;
}

int vor_spec_vector(const struct vor_spec *spec, enum vor_parameter parameter, double out[3])
{
    return spec->value[parameter] == VOR_VECTOR &&
           vor_kind_form_of(vor_parameter_info(parameter), VOR_VECTOR) == VOR_FORM_VECTOR &&
           vor_decimal_read_vector(out, vor_spec_name(spec, parameter));
}

int vor_spec_count_at(const struct vor_spec *spec, enum vor_parameter parameter, unsigned index,
                      double *out)
{
    return vor_spec_form(spec, parameter) == VOR_FORM_COUNTS &&
           vor_decimal_read_at(out, vor_spec_name(spec, parameter), index);
}

static vor_status refuse_size(enum vor_parameter parameter, const char *text, struct vor_error *err)
{
    const char *name = vor_parameter_info(parameter)->name;

    return vor_fail_param(
        err, VOR_E_PARAM, name,
        "%s has %zu bytes, want at most %d in all text values of the request together", name,
        text != NULL ? strlen(text) : 0, VOR_SPEC_TEXTS_SIZE);
}

/* Sets a value, and lays the texts out anew where one comes or goes. */
static vor_status store(struct vor_spec *spec, enum vor_parameter parameter,
                        const struct vor_value *value, struct vor_error *err)
{
    struct vor_spec next;
    size_t at = 0;

    if (value->text == NULL && !has_text(spec, (int)parameter)) {
        spec->value[parameter] = value->number;
        return VOR_OK;
    }
    next = *spec;
    next.value[parameter] = value->number;
    memset(next.texts, 0, sizeof next.texts);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        const char *text =
            i == (int)parameter ? value->text : vor_spec_name(spec, (enum vor_parameter)i);
        size_t size;

        if (text == NULL)
            continue;
        size = strlen(text) + 1;
        if (size > sizeof next.texts - at)
            return refuse_size(parameter, value->text, err);
        memcpy(next.texts + at, text, size);
        at += size;
    }
    *spec = next;
    return VOR_OK;
}

/* All names if they are few, else the nearest; none if the unknown one is like none of many. */
static vor_status refuse_name(const struct vor_process_info *process, const char *name,
                              struct vor_error *err)
{
    char quoted[PARAMETER_SIZE], names[NAMES_SIZE] = "";
    struct vor_nearest nearest;
    size_t at = 0;
    int count = 0;

    vor_nearest_init_any(&nearest, name, strlen(name));
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        const char *taken = vor_parameter_info((enum vor_parameter)i)->name;

        if (!vor_process_takes(process, (enum vor_parameter)i))
            continue;
        vor_nearest_try(&nearest, taken, strlen(taken));
        count++;
    }
    for (unsigned i = 0; i < nearest.count; i++)
        at += (size_t)snprintf(names + at, sizeof names - at, "%s%s",
                               i > 0                      ? ", "
                               : count <= VOR_NEAREST_MAX ? "; want "
                                                          : "; nearest: ",
                               nearest.found[i].word);
    vor_quote(quoted, sizeof quoted, name, strlen(name));
    return vor_fail_param(err, VOR_E_PARAM, quoted, "unknown parameter \"%s\" of %s%s", quoted,
                          process->id, names);
}

static vor_status refuse_as(vor_status status, const struct vor_parameter_info *info,
                            const char *what, const char *meant, struct vor_error *err)
{
    char want[VOR_KIND_WORDS_SIZE];

    vor_kind_want(info, want);
    return vor_fail_param(err, status, info->name, "%s is %s, want %s%s", info->name, what, want,
                          meant);
}

static vor_status refuse_value(const struct vor_parameter_info *info, const char *what,
                               struct vor_error *err)
{
    return refuse_as(VOR_E_PARAM, info, what, "", err);
}

/* The words of the parameter that are like a text; see vor_nearest_text. */
static const char *find_nearest(const struct vor_parameter_info *info, const char *text,
                                char out[VOR_NEAREST_TEXT_SIZE])
{
    struct vor_nearest nearest;
    const char *word;
    size_t length;

    vor_nearest_init(&nearest, text, strlen(text));
    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++)
        if ((info->allowed >> i & 1) != 0)
            vor_nearest_try(&nearest, word, length);
    return vor_nearest_text(&nearest, "", out);
}

/* A text that is no number stands in quotes; of a count with k or M, what it comes to stands beside
 * it. A list with a word that is unknown is well-formed, and has a status of its own. */
static vor_status refuse_text(const struct vor_parameter_info *info, const char *text,
                              struct vor_error *err)
{
    char quoted[SHOWN_SIZE - 2], what[SHOWN_SIZE + MEANT_SIZE], meant[VOR_KIND_NUMBER_SIZE];
    char nearest[VOR_NEAREST_TEXT_SIZE];
    enum vor_form first = vor_kind_form(info->kind, 0);
    int is_number = first == VOR_FORM_WHOLE || first == VOR_FORM_REAL;

    if (text[0] == '\0')
        return refuse_value(info, "empty", err);
    vor_quote(quoted, sizeof quoted, text, strlen(text));
    if (vor_kind_expand(info, text, meant))
        (void)snprintf(what, sizeof what, "%s, which is %s", quoted, meant);
    else
        (void)snprintf(what, sizeof what, is_number ? "%s" : "\"%s\"", quoted);
    return refuse_as(vor_kind_has_unknown_word(info, text) ? VOR_E_WORD : VOR_E_PARAM, info, what,
                     find_nearest(info, text, nearest), err);
}

/* The parameter of that name as the process has it; false when it takes none. */
static int find(const struct vor_spec *spec, const char *name, enum vor_parameter *out,
                struct vor_parameter_info *info)
{
    *out = vor_parameter_find(name);
    if (*out == VOR_PARAMETER_COUNT || !vor_process_takes(spec->process, *out))
        return 0;
    *info = vor_process_parameter(spec->process, *out);
    return 1;
}

vor_status vor_spec_refuse(const struct vor_spec *spec, const char *name, const char *what,
                           struct vor_error *err)
{
    struct vor_parameter_info info;
    enum vor_parameter parameter;

    return find(spec, name, &parameter, &info) ? refuse_value(&info, what, err)
                                               : refuse_name(spec->process, name, err);
}

vor_status vor_spec_set(struct vor_spec *spec, const char *name, const char *text,
                        struct vor_error *err)
{
    struct vor_parameter_info info;
    enum vor_parameter parameter;
    struct vor_value value;
    enum vor_form first;

    if (!find(spec, name, &parameter, &info))
        return refuse_name(spec->process, name, err);
    first = vor_kind_form(info.kind, 0);
    if ((first == VOR_FORM_LIST || first == VOR_FORM_COUNTS) && strlen(text) >= VOR_SPEC_TEXTS_SIZE)
        return refuse_size(parameter, text, err);
    if (!vor_kind_read(&info, text, &value))
        return refuse_text(&info, text, err);
    return store(spec, parameter, &value, err);
}

vor_status vor_spec_set_number(struct vor_spec *spec, const char *name, double number,
                               struct vor_error *err)
{
    char text[32];

    (void)snprintf(text, sizeof text, "%.17g", number);
    return vor_spec_set(spec, name, text, err);
}

static int counts_given(const struct vor_spec *spec)
{
    return vor_spec_given(spec, VOR_PARAM_POINTS) + vor_spec_given(spec, VOR_PARAM_RATIO) +
           vor_spec_given(spec, VOR_PARAM_SPACING);
}

static int has_target(const struct vor_spec *spec)
{
    return vor_process_takes(spec->process, VOR_PARAM_POINTS);
}

int vor_spec_only_filters(const struct vor_spec *spec)
{
    double filters = spec->value[VOR_PARAM_FILTERS];

    return counts_given(spec) == 0 && has_target(spec) &&
           (vor_list_has(filters, VOR_FILTER_MLS) || vor_list_has(filters, VOR_FILTER_OUTLIERS));
}

int vor_spec_keeps_points(const struct vor_spec *spec)
{
    return spec->process->outputs[0].kind == VOR_ARTEFACT_CLOUD &&
           (!has_target(spec) || vor_spec_only_filters(spec) ||
            spec->value[VOR_PARAM_METHOD] == VOR_METHOD_INSERT) &&
           spec->value[VOR_PARAM_SAMPLE] != VOR_SAMPLE_FACES;
}

enum vor_spec_faces vor_spec_faces(const struct vor_spec *spec)
{
    if (spec->value[VOR_PARAM_SAMPLE] == VOR_SAMPLE_FACES)
        return VOR_FACES_NEEDED;
    return vor_spec_keeps_points(spec) && !has_target(spec) ? VOR_FACES_KEPT : VOR_FACES_IGNORED;
}

/* Checks a request in which an energy may be minimised. */
static vor_status check_descent(const struct vor_spec *spec, struct vor_error *err)
{
    const char *name = spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP ? "metric" : "cells";
    const char *word = spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP ? "lp" : "euclid";
    double p = spec->value[VOR_PARAM_P];

    if (p != 2 * floor(p / 2))
        return vor_fail_param(err, VOR_E_PARAM, "p", "p is %.0f, want an even number from 2 to 8",
                              p);
    if (!vor_spec_descends(spec))
        return VOR_OK;
    if (spec->value[VOR_PARAM_METHOD] != VOR_METHOD_CVT)
        return vor_fail_param(err, VOR_E_PARAM, name, "%s=%s works only with method=cvt", name,
                              word);
    if (spec->value[VOR_PARAM_DENSITY] != VOR_DENSITY_UNIFORM)
        return vor_fail_param(err, VOR_E_PARAM, name, "%s=%s works only with density=uniform", name,
                              word);
    return VOR_OK;
}

/* Checks a request for a method that cannot do everything that cvt can. */
static vor_status check_method(const struct vor_spec *spec, struct vor_error *err)
{
    static const struct {
        enum vor_parameter parameter;
        double refused, wanted; /* refused VOR_UNSET: all but the wanted one are */
        const char *use;
    } rules[] = {{VOR_PARAM_DENSITY, VOR_UNSET, VOR_DENSITY_UNIFORM, "uniform"},
                 {VOR_PARAM_METRIC, VOR_UNSET, VOR_METRIC_ISOTROPIC, "isotropic"},
                 {VOR_PARAM_BOUNDARY, VOR_BOUNDARY_SITES, 0, "keep"},
                 {VOR_PARAM_EDGES, VOR_UNSET, VOR_EDGES_IGNORE, "ignore"},
                 {VOR_PARAM_BOUNDARY, VOR_BOUNDARY_FILL, 0, "keep"},
                 {VOR_PARAM_FILTERS, VOR_UNSET, 0, "none"},
                 {VOR_PARAM_SAMPLE, VOR_UNSET, VOR_SAMPLE_VERTICES, "vertices"},
                 {VOR_PARAM_ORDER, VOR_UNSET, VOR_ORDER_SPATIAL, "spatial"},
                 {VOR_PARAM_LATTICE, VOR_UNSET, VOR_LATTICE_FREE, "free"}};
    double method = spec->value[VOR_PARAM_METHOD];
    size_t count = method == VOR_METHOD_INSERT ? sizeof rules / sizeof rules[0] : 4;
    char is[VOR_SPEC_VALUE_SIZE];
    const char *word;

    if (method == VOR_METHOD_CVT || method == VOR_METHOD_KMEANS)
        return VOR_OK;
    (void)vor_parameter_choice(vor_parameter_info(VOR_PARAM_METHOD), (unsigned)method, &word);
    for (size_t i = method == VOR_METHOD_ISOTROPIC; i < count; i++) { /* it follows a density */
        const char *name = vor_parameter_info(rules[i].parameter)->name;
        double value = spec->value[rules[i].parameter];

        if (rules[i].refused == VOR_UNSET ? value != rules[i].wanted : value == rules[i].refused)
            return vor_fail_param(err, VOR_E_PARAM, name,
                                  "%s=%.*s does not work with method=%.*s: use %s or method=cvt",
                                  name, SHOWN_SIZE, vor_spec_text(spec, rules[i].parameter, is),
                                  (int)strcspn(word, " "), word, rules[i].use);
    }
    return VOR_OK;
}

vor_status vor_spec_check(const struct vor_spec *spec, struct vor_error *err)
{
    int given = counts_given(spec);
    vor_status status = check_descent(spec, err);

    VOR_THEN(status, check_method(spec, err));
    if (status == VOR_OK && spec->value[VOR_PARAM_LATTICE] == VOR_LATTICE_KEEP &&
        (vor_process_takes(spec->process, VOR_PARAM_SOUP) || vor_spec_only_filters(spec)))
        status = vor_fail_param(err, VOR_E_PARAM, "lattice",
                                "lattice=keep works neither with the process mesh nor if the "
                                "result is only the filtered input");
    if (status != VOR_OK || given == 1 || !has_target(spec) || vor_spec_only_filters(spec))
        return status;
    if (given == 0)
        return vor_fail_param(err, VOR_E_PARAM, "points",
                              "give exactly one of the parameters points, ratio and spacing: "
                              "none is given");
    return vor_fail_param(err, VOR_E_PARAM, "points",
                          "give exactly one of the parameters points, ratio and spacing, not "
                          "%d",
                          given);
}

vor_status vor_spec_complete(struct vor_spec *spec, struct vor_error *err)
{
    double fallback = vor_process_parameter(spec->process, VOR_PARAM_RATIO).fallback;

    if (counts_given(spec) == 0 && has_target(spec) &&
        !(fallback == 1 && vor_spec_only_filters(spec)))
        spec->value[VOR_PARAM_RATIO] = fallback;
    return vor_spec_check(spec, err);
}

/* Checks a request with an earlier result, which only one method starts from. */
static vor_status check_previous(const struct vor_spec *spec, unsigned inputs,
                                 struct vor_error *err)
{
    const struct vor_artefact_info *of = spec->process->inputs,
                                   *previous = vor_artefact_find(of, "previous");

    if (previous == NULL || (inputs >> (previous - of) & 1) == 0 ||
        (spec->value[VOR_PARAM_METHOD] == VOR_METHOD_CVT && !vor_spec_only_filters(spec)))
        return VOR_OK;
    return vor_fail_param(
        err, VOR_E_PARAM, "previous",
        "previous works only with method=cvt, and not if the result is only the filtered input");
}

vor_status vor_spec_check_inputs(const struct vor_spec *spec, unsigned inputs,
                                 struct vor_error *err)
{
    const struct vor_process_info *process = spec->process;
    const struct vor_artefact_info *input;
    char text[VOR_SPEC_VALUE_SIZE];

    for (unsigned i = 0; (input = &process->inputs[i])->name != NULL; i++)
        if (input->is_required && (inputs >> i & 1) == 0)
            return vor_fail_param(err, VOR_E_PARAM, input->name,
                                  "%s needs a %s, but the request has none", process->id,
                                  input->name);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;
        const char *needed = vor_parameter_needs(parameter);
        struct vor_parameter_info info = vor_process_parameter(process, parameter);

        if (needed == NULL || spec->value[i] == info.fallback)
            continue;
        input = vor_artefact_find(process->inputs, needed);
        if (input != NULL && (inputs >> (input - process->inputs) & 1) != 0)
            continue;
        vor_spec_text(spec, parameter, text);
        return vor_fail_param(err, VOR_E_PARAM, info.name,
                              "the parameter %s is %.*s, which needs a %s cloud, but the "
                              "request has none",
                              info.name, SHOWN_SIZE, text, needed);
    }
    return check_previous(spec, inputs, err);
}

double vor_spec_target(const struct vor_spec *spec, uint64_t input)
{
    if (vor_spec_given(spec, VOR_PARAM_RATIO))
        return rint(spec->value[VOR_PARAM_RATIO] * (double)input);
    return spec->value[VOR_PARAM_POINTS];
}

/* Whether the process lets any number of points be drawn from faces. */
static int is_unbounded(const struct vor_spec *spec)
{
    return spec->value[VOR_PARAM_SAMPLE] == VOR_SAMPLE_FACES && spec->process->ratio_max > 1;
}

vor_status vor_spec_check_target(const struct vor_spec *spec, double target, uint64_t input,
                                 struct vor_error *err)
{
    const struct vor_parameter_info *points = vor_parameter_info(VOR_PARAM_POINTS);
    const struct vor_process_info *process = spec->process;
    enum vor_parameter from = vor_spec_given(spec, VOR_PARAM_RATIO)     ? VOR_PARAM_RATIO
                              : vor_spec_given(spec, VOR_PARAM_SPACING) ? VOR_PARAM_SPACING
                                                                        : VOR_PARAM_POINTS;
    const char *name = vor_parameter_info(from)->name;
    double least = fmax(points->min, process->ratio_min * (double)input);
    double most =
        is_unbounded(spec) ? points->max : fmin(points->max, process->ratio_max * (double)input);
    char asked[48] = "", times[32] = "up to";

    if ((target >= least && target <= most) || !has_target(spec) || vor_spec_only_filters(spec))
        return VOR_OK;
    if (least > most)
        return vor_fail_param(
            err, VOR_E_TARGET, name,
            "the result of %s has at least as many points as the input (%llu), so %.0f or "
            "more, but a result may have at most %.0f points",
            process->id, (unsigned long long)input, least, most);
    if (from != VOR_PARAM_POINTS)
        (void)snprintf(asked, sizeof asked, " and needs %.16g points", target);
    if (is_unbounded(spec))
        return vor_fail_param(err, VOR_E_TARGET, name, "%s is %.10g%s, want %.0f to %.0f", name,
                              spec->value[from], asked, least, most);
    if (process->ratio_min == 0 && process->ratio_max == 1)
        return vor_fail_param(err, VOR_E_TARGET, name,
                              "%s is %.10g%s, want %.0f to %.0f: %s cannot give more points than "
                              "the input has (%llu)",
                              name, spec->value[from], asked, least, most, process->id,
                              (unsigned long long)input);
    if (process->ratio_min > 0)
        (void)snprintf(times, sizeof times, "%g to", process->ratio_min);
    return vor_fail_param(
        err, VOR_E_TARGET, name,
        "%s is %.10g%s, want %.0f to %.0f: the result of %s may have %s %g times as many "
        "points as the input (%llu)",
        name, spec->value[from], asked, least, most, process->id, times, process->ratio_max,
        (unsigned long long)input);
}

enum vor_form vor_spec_form(const struct vor_spec *spec, enum vor_parameter parameter)
{
    if (spec->process == NULL || !vor_process_takes(spec->process, parameter))
        return VOR_FORM_NONE;
    return vor_kind_form_of(vor_parameter_info(parameter), spec->value[parameter]);
}

int vor_spec_given(const struct vor_spec *spec, enum vor_parameter parameter)
{
    return vor_kind_form_of(vor_parameter_info(parameter), spec->value[parameter]) != VOR_FORM_NONE;
}

int vor_spec_descends(const struct vor_spec *spec)
{
    return spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP ||
           spec->value[VOR_PARAM_CELLS] == VOR_CELLS_EUCLID;
}

uint32_t vor_spec_steps(const struct vor_spec *spec)
{
    enum { ALONE = 12, BEFORE_POLISH = 4 };

    if (vor_spec_given(spec, VOR_PARAM_STEPS))
        return (uint32_t)spec->value[VOR_PARAM_STEPS];
    return spec->value[VOR_PARAM_METHOD] == VOR_METHOD_EAR && vor_spec_polish(spec) > 0
               ? BEFORE_POLISH
               : ALONE;
}

int vor_spec_outliers(const struct vor_spec *spec)
{
    if (vor_spec_given(spec, VOR_PARAM_OUTLIERS))
        return (int)spec->value[VOR_PARAM_OUTLIERS];
    return spec->value[VOR_PARAM_METHOD] == VOR_METHOD_EAR ? VOR_OUTLIERS_DROP : VOR_OUTLIERS_KEEP;
}

uint32_t vor_spec_iterations(const struct vor_spec *spec)
{
    enum { DESCENT = 35, BEFORE_POLISH = 12, ALONE = 100, REMESH = 6 };
    double method = spec->value[VOR_PARAM_METHOD], polish = spec->value[VOR_PARAM_POLISH];

    if (method == VOR_METHOD_INSERT ||
        (method == VOR_METHOD_EAR && spec->value[VOR_PARAM_PHASES] == VOR_PHASES_INSERT))
        return 0;
    if (method == VOR_METHOD_WLOP || method == VOR_METHOD_EAR)
        return (uint32_t)spec->value[VOR_PARAM_ROUNDS] * vor_spec_steps(spec);
    if (vor_spec_given(spec, VOR_PARAM_ITERATIONS))
        return (uint32_t)spec->value[VOR_PARAM_ITERATIONS];
    if (method == VOR_METHOD_ISOTROPIC)
        return polish > 0 ? REMESH : 3 * REMESH;
    return vor_spec_descends(spec) ? DESCENT : polish > 0 ? BEFORE_POLISH : ALONE;
}

uint32_t vor_spec_polish(const struct vor_spec *spec)
{
    int none = spec->value[VOR_PARAM_METHOD] == VOR_METHOD_INSERT || vor_spec_descends(spec);

    return none ? 0 : (uint32_t)spec->value[VOR_PARAM_POLISH];
}

const char *vor_spec_text(const struct vor_spec *spec, enum vor_parameter parameter,
                          char out[VOR_SPEC_VALUE_SIZE])
{
    vor_kind_write(vor_parameter_info(parameter), spec->value[parameter],
                   vor_spec_name(spec, parameter), out, VOR_SPEC_VALUE_SIZE);
    return out;
}
