#include "server/cli/help.h"

#include "server/base/markup.h"
#include "server/base/reference.h"
#include "server/base/topics.h"
#include "server/cli/cli_log.h"

#include <ctype.h>
#include <string.h>

static const struct {
    int code;
    const char *command, *serve;
} exits[] = {
#define EXIT_ROW(id, code, command, serve) {code, command, serve},
    VOR_EXIT_TABLE(EXIT_ROW)
#undef EXIT_ROW
};

/* Bytes of a title and a sentence; the longest of today has 600. */
enum {
    SENTENCE_SIZE = 2048,
    MEANING_COLUMN = 6,
    PRESET_COLUMN = 12,
    CODE_COLUMN = 4,
    EXAMPLES_MAX = 3
};

static void print_block(void *ctx, const struct vor_markup_block *block)
{
    struct vor_span_of_text line, text = block->text;
    FILE *out = ctx;

    switch (block->kind) {
    case VOR_MARKUP_HEADING:
        fprintf(out, "\n%.*s:\n", (int)block->text.length, block->text.at);
        break;
    case VOR_MARKUP_PARAGRAPH:
        fputc('\n', out);
        vor_markup_wrap(out, block->text, 0, 0);
        break;
    case VOR_MARKUP_ITEM:
        fprintf(out, "\n  %.*s\n%*s", (int)block->term.length, block->term.at, MEANING_COLUMN, "");
        vor_markup_wrap(out, block->text, MEANING_COLUMN, MEANING_COLUMN);
        break;
    case VOR_MARKUP_CODE:
        fputc('\n', out);
        while (vor_markup_line(&line, &text))
            fprintf(out, "%*s%.*s\n", line.length > 0 ? CODE_COLUMN : 0, "", (int)line.length,
                    line.at);
        break;
    case VOR_MARKUP_TABLE:
        break;
    }
}

int vor_cli_topic(FILE *out, const char *name)
{
    struct vor_topic topic;

    if (!vor_topic_find(&topic, name))
        return -1;
    fprintf(out, "%.*s\n", topic.title_length, topic.title);
    if (!vor_topic_blocks(&topic, print_block, out) || fflush(out) != 0)
        return VOR_EXIT_FAILED;
    return VOR_EXIT_OK;
}

struct examples {
    FILE *out;
    const char *command;
    size_t length; /* of the command */
    int count;
};

/* Whether a line calls the command: "voronoid wait ..." calls wait. */
static int calls(const struct examples *examples, struct vor_span_of_text line)
{
    static const char program[] = "voronoid ";
    size_t before = sizeof program - 1, length = before + examples->length;

    for (size_t i = 0; i + length <= line.length; i++) {
        const char *at = line.at + i;

        if (memcmp(at, program, before) == 0 &&
            memcmp(at + before, examples->command, examples->length) == 0 &&
            (i + length == line.length || !isalnum((unsigned char)at[length])))
            return 1;
    }
    return 0;
}

static void print_examples(void *ctx, const struct vor_markup_block *block)
{
    struct vor_span_of_text line, text = block->text;
    struct examples *examples = ctx;

    if (block->kind != VOR_MARKUP_CODE)
        return;
    while (examples->count < EXAMPLES_MAX && vor_markup_line(&line, &text)) {
        if (!calls(examples, line))
            continue;
        fprintf(examples->out, "%s  %.*s\n", examples->count == 0 ? "\nExamples:\n" : "",
                (int)line.length, line.at);
        examples->count++;
    }
}

/* The first lines of code in the topics that call a command, such as "submit resample"; those of
 * its first word where there are none. */
static void print_examples_of(FILE *out, const char *command)
{
    size_t lengths[] = {strlen(command), strcspn(command, " ")};
    struct examples examples = {out, command, 0, 0};
    struct vor_topic topic;

    for (size_t k = 0; k < sizeof lengths / sizeof lengths[0] && examples.count == 0; k++) {
        examples.length = lengths[k];
        for (unsigned i = 0; examples.count < EXAMPLES_MAX && vor_topic_at(&topic, i); i++)
            (void)vor_topic_blocks(&topic, print_examples, &examples);
    }
}

static void print_option(FILE *out, char letter, const char *name, const char *value,
                         const char *sentence)
{
    fputs("  ", out);
    if (letter != 0)
        fprintf(out, "-%c, ", letter);
    fprintf(out, "--%s%s\n", name, value);
    vor_markup_wrap_string(out, sentence, MEANING_COLUMN);
}

/* The inputs that are options, then the options proper. */
static void print_options(FILE *out, const struct vor_command *command)
{
    const struct vor_process_info *process = command->process;
    const struct vor_option_row *o;
    char sentence[SENTENCE_SIZE], value[32], range[VOR_OPTION_RANGE_SIZE];

    for (unsigned i = 1; process != NULL && process->inputs[i].name != NULL; i++) {
        (void)snprintf(sentence, sizeof sentence, "%s%s", process->inputs[i].sentence,
                       process->inputs[i].is_required ? " (required)" : "");
        print_option(out, 0, process->inputs[i].name, " FILE", sentence);
    }
    for (unsigned i = 0; (o = vor_command_option(command, i)) != NULL; i++) {
        (void)snprintf(value, sizeof value, " %s", vor_option_value(o));
        print_option(out, o->letter, o->name, value[1] != '\0' ? value : "", o->sentence);
        vor_option_range(o, range);
        if (range[0] != '\0' || o->variable[0] != '\0')
            fprintf(out, "%*s%s%s%s%s%s\n", MEANING_COLUMN, "", range,
                    range[0] != '\0' && o->variable[0] != '\0' ? " " : "",
                    o->variable[0] != '\0' ? "(env: " : "", o->variable,
                    o->variable[0] != '\0' ? ")" : "");
    }
}

/* The parameters of one group and one level that a process takes. */
static void print_group(FILE *out, const struct vor_process_info *process, enum vor_group group,
                        enum vor_level level)
{
    const char *title = vor_group_title(group);
    const struct vor_parameter_info *info;
    char values[VOR_REFERENCE_VALUES_SIZE], option[VOR_REFERENCE_NAME_SIZE];

    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;

        if (vor_parameter_info(parameter)->group != group ||
            vor_parameter_level(parameter) != level || !vor_process_takes(process, parameter))
            continue;
        if (title != NULL)
            fprintf(out, "\n%s:\n", title);
        title = NULL;
        info = vor_parameter_info(parameter);
        vor_reference_values(values, process, parameter);
        print_option(out, parameter == VOR_PARAM_POINTS ? 'n' : 0,
                     vor_reference_option(option, parameter),
                     info->kind == VOR_KIND_FLAG ? "[=VALUE]" : " VALUE", info->sentence);
        fprintf(out, "%*s%s\n", MEANING_COLUMN, "", values);
    }
}

static int has_level(const struct vor_process_info *process, enum vor_level level)
{
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
        if (vor_parameter_level((enum vor_parameter)i) == level &&
            vor_process_takes(process, (enum vor_parameter)i))
            return 1;
    return 0;
}

static void print_presets(FILE *out, const struct vor_process_info *process)
{
    const struct vor_named_preset *preset;
    char line[SENTENCE_SIZE];

    if (vor_named_preset(process->id, 0) == NULL)
        return;
    fputs("\nPresets:\n", out);
    for (unsigned i = 0; (preset = vor_named_preset(process->id, i)) != NULL; i++) {
        (void)snprintf(line, sizeof line, "%s%s%s", preset->sentence,
                       preset->values[0] != '\0' ? ": " : "", preset->values);
        fprintf(out, "  %-9s ", preset->name);
        vor_markup_wrap(out, (struct vor_span_of_text){line, strlen(line)}, PRESET_COLUMN,
                        PRESET_COLUMN);
    }
}

/* The table of exit codes as lines: of commands, or of serve. */
static void print_exit_codes(FILE *out, int of_serve)
{
    for (size_t i = 0; i < sizeof exits / sizeof exits[0]; i++) {
        const char *sentence = of_serve ? exits[i].serve : exits[i].command;

        if (sentence[0] != '\0')
            fprintf(out, "  %3d  %s\n", exits[i].code, sentence);
    }
}

void vor_help_command(FILE *out, const struct vor_command *command)
{
    const struct vor_process_info *process = command->process;

    char sentence[SENTENCE_SIZE];

    (void)snprintf(sentence, sizeof sentence, "%s.%s", command->sentence,
                   process != NULL ? " The file name - means stdin or stdout."
                   : (command->does & VOR_COMMAND_JOBS) != 0 ? " " VOR_HELP_JOBS
                                                             : "");
    fprintf(out, "usage: voronoid %s%s [OPTION]...\n", command->name, command->operands);
    vor_markup_wrap_string(out, sentence, 0);
    fputs("\nOptions:\n", out);
    print_options(out, command);
    if (process != NULL) {
        print_presets(out, process);
        for (int level = 0; level < VOR_LEVELS; level++) {
            if (!has_level(process, (enum vor_level)level))
                continue;
            fprintf(out, "\n%s%s:\n", vor_level_title((enum vor_level)level),
                    process->on_http ? ", the same over HTTP" : "");
            for (int group = 0; group < VOR_GROUP_COUNT; group++)
                print_group(out, process, (enum vor_group)group, (enum vor_level)level);
        }
        fputs("\n" VOR_HELP_COUNTS "\n", out);
    }
    fputc('\n', out);
    vor_markup_wrap_string(out, VOR_HELP_WORDS, 0);
    if ((command->does & VOR_COMMAND_SERVES) != 0)
        vor_markup_wrap_string(out,
                               "A flag overrides the environment variable of the same setting, and "
                               "the variable overrides the file of --config. A variable with a "
                               "name that ends in _FILE has the path of a file that contains the "
                               "value. See also voronoid help settings.",
                               0);
    fputs("\nExit codes:\n", out);
    print_exit_codes(out, (command->does & VOR_COMMAND_SERVES) != 0);
    print_examples_of(out, command->name);
}

void vor_help_brief(FILE *out)
{
    fputs("voronoid resamples 3D point clouds (PLY, Draco) to the number of points that you "
          "want,\nevenly spread over the surface. To begin:\n\n  voronoid resample cloud.ply "
          "-n 10k -o even.ply\n      spreads 10,000 points evenly\n  voronoid inspect "
          "cloud.ply\n      describes a cloud: spacing, noise, holes, edges\n  voronoid "
          "serve\n      runs the daemon; its web page is http://127.0.0.1:8080\n\nvoronoid "
          "help lists commands and topics. voronoid help choosing says when to use "
          "which\ncommand.\n",
          out);
}

void vor_help_overview(FILE *out,
                       const struct vor_command *(*at)(struct vor_command *out, unsigned index))
{
    struct vor_command command;
    struct vor_topic topic;

    fputs("usage: voronoid COMMAND [OPTION]...\n\nCommands:\n", out);
    for (unsigned i = 0; at(&command, i) != NULL; i++)
        fprintf(out, "  %-9s %s\n", command.name, command.title);
    fputs("\nTopics, shown by voronoid help TOPIC:\n", out);
    for (unsigned i = 0; vor_topic_at(&topic, i); i++)
        fprintf(out, "  %-12s %.*s\n", topic.name, topic.title_length, topic.title);
    fputs("\nvoronoid COMMAND --help lists the options of a command. voronoid --version prints the "
          "version,\n"
          "voronoid --man 1|8 a manual page, voronoid --completion bash|zsh|fish a completion "
          "script.\n\nExit codes:\n",
          out);
    print_exit_codes(out, 0);
    fputs("\nExit codes of serve:\n", out);
    print_exit_codes(out, 1);
}
