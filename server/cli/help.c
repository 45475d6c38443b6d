#include "server/cli/help.h"

#include "core/spec/kinds.h"

#include <string.h>

static void print_option(FILE *out, char letter, const char *name, const char *value,
                         const char *sentence)
{
    fprintf(out, "  %c%c%c --%s%s\n      %s", letter != 0 ? '-' : ' ', letter != 0 ? letter : ' ',
            letter != 0 ? ',' : ' ', name, value, sentence);
}

/* The inputs that are options, then the options proper. */
static void print_options(FILE *out, const struct vor_command *command)
{
    const struct vor_process_info *process = command->process;

    for (unsigned i = 1; process != NULL && process->inputs[i].name != NULL; i++) {
        print_option(out, 0, process->inputs[i].name, " FILE", process->inputs[i].sentence);
        fputs(process->inputs[i].is_required ? " (required)\n" : "\n", out);
    }
    for (int i = 0; i < VOR_OPTION_COUNT; i++) {
        const struct vor_option_info *o = vor_option_info((enum vor_option)i);
        char value[32];

        if ((o->commands & command->does) == 0)
            continue;
        (void)snprintf(value, sizeof value, "%s%s", o->value[0] != '\0' ? " " : "", o->value);
        print_option(out, o->letter, o->name, value, o->sentence);
        if (o->variable[0] != '\0')
            fprintf(out, " (env: %s)", o->variable);
        fputc('\n', out);
    }
}

/* "1 to 10000000 points, default 100" or "keep | free, default keep". */
static void print_parameter(FILE *out, const struct vor_process_info *process,
                            enum vor_parameter parameter)
{
    struct vor_parameter_info info = vor_process_parameter(process, parameter);
    char values[VOR_KIND_WORDS_SIZE], text[VOR_SPEC_VALUE_SIZE];
    struct vor_spec spec;

    vor_spec_preset(&spec, process);
    spec.value[parameter] = info.fallback; /* that of ratio stands aside in a preset */
    vor_spec_text(&spec, parameter, text);
    vor_kind_values(&info, values);
    print_option(out, parameter == VOR_PARAM_POINTS ? 'n' : 0, info.name,
                 info.kind == VOR_KIND_FLAG ? "[=VALUE]" : " VALUE", info.sentence);
    fprintf(out, "\n      %s%s%s\n", values, text[0] != '\0' ? ", default " : "", text);
}

static void print_group(FILE *out, const struct vor_process_info *process, enum vor_group group)
{
    const char *title = vor_group_title(group);

    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;

        if (vor_parameter_info(parameter)->group != group || !vor_process_takes(process, parameter))
            continue;
        if (title != NULL)
            fprintf(out, "\n%s:\n", title);
        title = NULL;
        print_parameter(out, process, parameter);
    }
}

void vor_help_command(FILE *out, const struct vor_command *command)
{
    const struct vor_process_info *process = command->process;

    fprintf(out, "usage: voronoid %s%s [OPTION]...\n%s.%s\n\nOptions:\n", command->name,
            process != NULL ? " IN" : "", command->sentence,
            process != NULL ? " - as a file is stdin or stdout." : "");
    print_options(out, command);
    if (process == NULL)
        return;
    fprintf(out, "\nParameters of the request%s:\n",
            process->on_http ? ", the same over HTTP" : "");
    for (int group = 0; group < VOR_GROUP_COUNT; group++)
        print_group(out, process, (enum vor_group)group);
}

void vor_help_begin(FILE *out)
{
    fputs("usage: voronoid COMMAND [OPTION]...\n\nCommands:\n", out);
}

void vor_help_line(FILE *out, const char *name, const char *title)
{
    fprintf(out, "  %-9s %s\n", name, title);
}

void vor_help_end(FILE *out)
{
    fputs("\nvoronoid COMMAND --help shows the options of a command, voronoid --version the "
          "version.\nExit codes: 0 ok, 1 failed, 2 usage, 3 input rejected, 4 cancelled (130 on "
          "^C), 5 server unreachable\nor busy.\n",
          out);
}
