#include "server/base/reference.h"

#include "core/spec/shown.h"
#include "server/base/config.h"
#include "server/base/metrics.h"

#include <string.h>

const char *vor_reference_option(char out[VOR_REFERENCE_NAME_SIZE], enum vor_parameter parameter)
{
    const char *name = vor_parameter_info(parameter)->name;
    size_t at = 0;

    for (; *name != '\0' && at < VOR_REFERENCE_NAME_SIZE - 2; name++) {
        int is_upper = *name >= 'A' && *name <= 'Z';

        if (is_upper)
            out[at++] = '-';
        out[at++] = is_upper ? (char)(*name - 'A' + 'a') : *name;
    }
    out[at] = '\0';
    return out;
}

void vor_reference_values(char out[VOR_REFERENCE_VALUES_SIZE],
                          const struct vor_process_info *process, enum vor_parameter parameter)
{
    struct vor_parameter_info info = vor_process_parameter(process, parameter);
    char values[VOR_KIND_WORDS_SIZE], text[VOR_SPEC_VALUE_SIZE], option[VOR_REFERENCE_NAME_SIZE];
    int has_alias = strcmp(vor_reference_option(option, parameter), info.name) != 0;
    struct vor_spec spec;

    vor_spec_preset(&spec, process);
    spec.value[parameter] = info.fallback; /* that of ratio stands aside in a preset */
    vor_spec_text(&spec, parameter, text);
    vor_kind_values(&info, values);
    (void)snprintf(out, VOR_REFERENCE_VALUES_SIZE, "%s%s%s%s%s", values,
                   text[0] != '\0' ? ", default " : "", text, has_alias ? "; over HTTP " : "",
                   has_alias ? info.name : "");
}

/* What may be given, and where that differs from process to process. */
static void add_values(struct vor_text *text, enum vor_parameter parameter)
{
    char first[VOR_REFERENCE_VALUES_SIZE] = "", values[VOR_REFERENCE_VALUES_SIZE];
    const struct vor_process_info *process;

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++) {
        if (!vor_process_takes(process, parameter))
            continue;
        vor_reference_values(values, process, parameter);
        if (first[0] == '\0') {
            memcpy(first, values, sizeof first);
            vor_text_printf(text, "      %s", values);
        } else if (strcmp(values, first) != 0) {
            vor_text_printf(text, "; for %s: %s", process->id, values);
        }
    }
    vor_text_puts(text, ".\n");
}

static void add_parameters(struct vor_text *text)
{
    const struct vor_process_info *process;
    int count;

    for (int group = 0; group < VOR_GROUP_COUNT; group++) {
        const char *title = vor_group_title((enum vor_group)group);

        vor_text_printf(text, "%s\n---\n\n", title);
        for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
            enum vor_parameter parameter = (enum vor_parameter)i;
            const struct vor_parameter_info *info = vor_parameter_info(parameter);
            char option[VOR_REFERENCE_NAME_SIZE];

            if ((int)info->group != group)
                continue;
            vor_text_printf(text, "  %s--%s%s\n      %s.\n",
                            parameter == VOR_PARAM_POINTS ? "-n, " : "",
                            vor_reference_option(option, parameter),
                            info->kind == VOR_KIND_FLAG ? "[=VALUE]" : " VALUE", info->sentence);
            add_values(text, parameter);
            count = 0;
            for (unsigned k = 0; (process = vor_process_info(k)) != NULL; k++)
                if (vor_process_takes(process, parameter))
                    vor_text_printf(text, "%s %s",
                                    count++ > 0 ? "," : "      Applies to:", process->id);
            vor_text_puts(text, ".\n");
        }
        vor_text_puts(text, "\n");
    }
}

static void add_presets(struct vor_text *text)
{
    const struct vor_process_info *process;
    const struct vor_named_preset *preset;

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        for (unsigned k = 0; (preset = vor_named_preset(process->id, k)) != NULL; k++)
            vor_text_printf(text, "  %s, for %s\n      %s: %s.\n", preset->name, process->id,
                            preset->sentence,
                            preset->values[0] != '\0' ? preset->values : "the defaults");
}

static void add_settings(struct vor_text *text)
{
    char range[VOR_OPTION_RANGE_SIZE];

    for (int i = 0; i < VOR_SETTING_COUNT; i++) {
        const struct vor_option_row *info = &vor_setting_infos[i];
        const char *value = vor_option_value(info);

        vor_option_range(info, range);
        vor_text_printf(text, "  --%s%s%s\n      %s (%s%senvironment: %s).\n", info->name,
                        value[0] != '\0' ? " " : "", value, info->sentence, range,
                        range[0] != '\0' ? "; " : "", info->variable);
    }
}

static void add_metrics(struct vor_text *text)
{
#define KIND_WORD(id, word) static const char word_##id[] = word;
    VOR_METRIC_KIND_TABLE(KIND_WORD)
#undef KIND_WORD
#define METRIC(id, name, kind, unit, labels, sentence)                                             \
    vor_text_printf(text, "  voronoid_%s\n      %s%s%s. %s.\n", name, word_##kind,                 \
                    (labels)[0] != '\0' ? " by " : "", labels, sentence);
    VOR_METRIC_TABLE(METRIC)
#undef METRIC
}

void vor_reference_write(struct vor_text *text, const char *name, size_t length)
{
    static const struct {
        const char *name;
        void (*add)(struct vor_text *text);
    } tables[] = {{"parameters", add_parameters},
                  {"presets", add_presets},
                  {"settings", add_settings},
                  {"metrics", add_metrics}};

    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; i++)
        if (strlen(tables[i].name) == length && memcmp(tables[i].name, name, length) == 0) {
            tables[i].add(text);
            return;
        }
    text->failed = 1;
}
