#include "docker/pages/options.h"

#include "server/base/reference.h"
#include "server/store/row.h"

#include <stdio.h>
#include <string.h>

static void add_word(char out[VOR_VALUE_WORDS_SIZE], const char *word, size_t length)
{
    size_t at = strlen(out);

    (void)snprintf(out + at, VOR_VALUE_WORDS_SIZE - at, "%s%.*s", at > 0 ? " " : "", (int)length,
                   word);
}

/* The words that a parameter takes: its choices, the beginnings of names, auto, none, true, false.
 */
static void add_words(char out[VOR_VALUE_WORDS_SIZE], const struct vor_parameter_info *info)
{
    const char *word;
    size_t length;

    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &word)) > 0; i++) {
        const char *colon = memchr(word, ':', length);

        if ((info->allowed >> i & 1) != 0)
            add_word(out, word, colon != NULL ? (size_t)(colon - word) + 1 : length);
    }
    for (unsigned i = 0; vor_kind_form(info->kind, i) != VOR_FORM_NONE; i++) {
        enum vor_form form = vor_kind_form(info->kind, i);
        const char *more = form == VOR_FORM_AUTO   ? "auto"
                           : form == VOR_FORM_LIST ? "none"
                           : form == VOR_FORM_FLAG ? "true false"
                                                   : NULL;

        if (more != NULL)
            add_word(out, more, strlen(more));
    }
}

static enum vor_value_kind kind_of(const struct vor_parameter_info *info, const char *words)
{
    if (info->kind == VOR_KIND_FLAG)
        return VOR_VALUE_FLAG;
    if (words[0] == '\0')
        return VOR_VALUE_ANY;
    return vor_kind_form(info->kind, 0) == VOR_FORM_LIST ? VOR_VALUE_LIST : VOR_VALUE_WORD;
}

static struct vor_page_option of_parameter(const struct vor_process_info *process,
                                           enum vor_parameter parameter,
                                           char name[VOR_REFERENCE_NAME_SIZE])
{
    const struct vor_parameter_info info = vor_process_parameter(process, parameter);
    struct vor_page_option out = {.name = vor_reference_option(name, parameter),
                                  .sentence = info.sentence,
                                  .letter = parameter == VOR_PARAM_POINTS ? 'n' : '\0',
                                  .value = "VALUE"};

    add_words(out.words, &info);
    out.kind = kind_of(&info, out.words);
    return out;
}

/* The names of all outputs, each once. */
static void add_results(char out[VOR_VALUE_WORDS_SIZE])
{
    const struct vor_process_info *process;

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        for (unsigned k = 0; process->on_http && process->outputs[k].name != NULL; k++)
            if (strstr(out, process->outputs[k].name) == NULL)
                add_word(out, process->outputs[k].name, strlen(process->outputs[k].name));
}

static void add_statuses(char out[VOR_VALUE_WORDS_SIZE])
{
    for (int i = 0; i < VOR_JOB_STATUSES; i++) {
        const char *word = vor_job_status_word((enum vor_job_status)i);

        add_word(out, word, strlen(word));
    }
}

/* The presets of the command's process, or of none. */
static void add_presets(char out[VOR_VALUE_WORDS_SIZE], const struct vor_command *command)
{
    const struct vor_named_preset *preset;

    for (unsigned i = 0;
         command->process != NULL && (preset = vor_named_preset(command->process->id, i)) != NULL;
         i++)
        add_word(out, preset->name, strlen(preset->name));
}

static struct vor_page_option of_option(const struct vor_command *command,
                                        const struct vor_option_row *info)
{
    struct vor_page_option out = {.name = info->name,
                                  .sentence = info->sentence,
                                  .letter = info->letter,
                                  .value = vor_option_value(info),
                                  .kind = VOR_VALUE_ANY};

    if (info->type == VOR_TYPE_FLAG)
        out.kind = VOR_VALUE_NONE;
    else if (strcmp(info->unit, "OUT") == 0 || strcmp(info->unit, "FILE") == 0)
        out.kind = VOR_VALUE_FILE;
    else if (strcmp(info->unit, "DIR") == 0)
        out.kind = VOR_VALUE_FOLDER;
    if (info->type == VOR_TYPE_CHOICE) {
        out.kind = VOR_VALUE_WORD;
        add_word(out.words, info->unit, strlen(info->unit));
    } else if (info == vor_option_info(VOR_OPTION_RESULT)) {
        out.kind = VOR_VALUE_WORD;
        add_results(out.words);
    } else if (info == vor_option_info(VOR_OPTION_STATUS)) {
        out.kind = VOR_VALUE_LIST;
        add_statuses(out.words);
    } else if (info == vor_option_info(VOR_OPTION_PRESET)) {
        out.kind = VOR_VALUE_WORD;
        add_presets(out.words, command);
    }
    return out;
}

void vor_page_command(const struct vor_command *command,
                      void (*visit)(void *ctx, const struct vor_page_option *option), void *ctx)
{
    const struct vor_process_info *process = command->process;
    const struct vor_option_row *info;
    struct vor_page_option option;
    char name[VOR_REFERENCE_NAME_SIZE];

    for (unsigned i = 1; process != NULL && process->inputs[i].name != NULL; i++) {
        option = (struct vor_page_option){.name = process->inputs[i].name,
                                          .sentence = process->inputs[i].sentence,
                                          .value = "FILE",
                                          .kind = VOR_VALUE_FILE};
        visit(ctx, &option);
    }
    for (unsigned i = 0; (info = vor_command_option(command, i)) != NULL; i++) {
        option = of_option(command, info);
        visit(ctx, &option);
    }
    for (int i = 0; process != NULL && i < VOR_PARAMETER_COUNT; i++) {
        option = of_parameter(process, (enum vor_parameter)i, name);
        if (vor_process_takes(process, (enum vor_parameter)i))
            visit(ctx, &option);
    }
}
