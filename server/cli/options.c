/* What stands on the command line, read by the tables. */
#include "server/cli/cli.h"

#include "core/base/parallel.h"
#include "core/base/quote.h"
#include "core/engine.h"
#include "core/spec/kinds.h"
#include "server/base/machine.h"

#include <stdlib.h>
#include <string.h>

struct option_row {
    const char *name, *value, *variable, *sentence;
    unsigned commands;
    char letter;
};

static const struct option_row options[VOR_OPTION_COUNT] = {
#define OPTION_ROW(id, name, letter, value, variable, commands, sentence)                          \
    {name, value, variable, sentence, commands, letter},
    VOR_OPTION_TABLE(OPTION_ROW)
#undef OPTION_ROW
};

struct command_row {
    const char *name, *operand, *sentence;
};

static const struct command_row commands[VOR_COMMAND_COUNT] = {
#define COMMAND_ROW(id, name, operand, sentence) {name, operand, sentence},
    VOR_COMMAND_TABLE(COMMAND_ROW)
#undef COMMAND_ROW
};

/* Where the reading stands. */
struct reader {
    struct vor_cli *cli;
    char **argv;
    int argc, at;
    struct vor_error *err;
};

enum vor_command vor_cli_find(const char *name)
{
    int i = 0;

    while (i < VOR_COMMAND_COUNT && strcmp(commands[i].name, name) != 0)
        i++;
    return (enum vor_command)i;
}

/* The process that a command runs; NULL when it runs none. */
static const struct vor_process_info *process_of(enum vor_command command)
{
    const struct vor_process_info *process = vor_process_find(commands[command].name);

    return process != NULL && process->outputs[0].kind == VOR_ARTEFACT_CLOUD ? process : NULL;
}

static int takes(enum vor_command command, int option)
{
    return (options[option].commands >> command & 1) != 0;
}

/* The option of that name (length bytes) or letter, VOR_OPTION_COUNT when the command has none. */
static int find_option(enum vor_command command, const char *name, size_t length, char letter)
{
    int i = 0;

    for (; i < VOR_OPTION_COUNT; i++) {
        if (!takes(command, i))
            continue;
        if (letter != 0
                ? options[i].letter == letter
                : strlen(options[i].name) == length && memcmp(options[i].name, name, length) == 0)
            break;
    }
    return i;
}

static vor_status no_option(const struct reader *r, const char *text)
{
    char quoted[48];

    return vor_fail(r->err, VOR_E_PARAM, "no option %s; see voronoid %s --help",
                    vor_quote(quoted, sizeof quoted, text, strlen(text)),
                    commands[r->cli->command].name);
}

/* The value of the option at hand: what is attached to it, or the next word; NULL is a failure that
 * is told. */
static const char *take_value(struct reader *r, const char *shown, const char *attached)
{
    if (attached != NULL)
        return attached;
    if (r->at + 1 < r->argc)
        return r->argv[++r->at];
    (void)vor_fail(r->err, VOR_E_PARAM, "%s needs a value", shown);
    return NULL;
}

static vor_status set_option(struct reader *r, int option, const char *shown, const char *attached)
{
    if (options[option].value[0] != '\0') {
        r->cli->option[option] = take_value(r, shown, attached);
        return r->cli->option[option] != NULL ? VOR_OK : VOR_E_PARAM;
    }
    if (attached != NULL)
        return vor_fail(r->err, VOR_E_PARAM, "%s takes no value", shown);
    r->cli->option[option] = "";
    return VOR_OK;
}

static vor_status set_parameter(struct reader *r, enum vor_parameter parameter, const char *shown,
                                const char *attached)
{
    const char *value = take_value(r, shown, attached);

    if (value == NULL)
        return VOR_E_PARAM;
    r->cli->given[parameter] = 1;
    return vor_spec_set(&r->cli->spec, vor_parameter_info(parameter)->name, value, r->err);
}

static enum vor_parameter find_parameter(const struct reader *r, const char *name, size_t length)
{
    enum vor_parameter parameter;
    char word[64];

    if (process_of(r->cli->command) == NULL || length >= sizeof word)
        return VOR_PARAMETER_COUNT;
    memcpy(word, name, length);
    word[length] = '\0';
    parameter = vor_parameter_find(word);
    return parameter != VOR_PARAMETER_COUNT && vor_process_takes(r->cli->spec.process, parameter)
               ? parameter
               : VOR_PARAMETER_COUNT;
}

/* --name, --name value, --name=value */
static vor_status read_long(struct reader *r, const char *text)
{
    const char *name = text + 2, *equals = strchr(name, '=');
    size_t length = equals != NULL ? (size_t)(equals - name) : strlen(name);
    int option = find_option(r->cli->command, name, length, 0);
    enum vor_parameter parameter = find_parameter(r, name, length);
    const char *attached = equals != NULL ? equals + 1 : NULL;
    char shown[40];

    vor_quote(shown, sizeof shown, text, length + 2);
    if (option != VOR_OPTION_COUNT)
        return set_option(r, option, shown, attached);
    if (parameter != VOR_PARAMETER_COUNT)
        return set_parameter(r, parameter, shown, attached);
    return no_option(r, shown);
}

/* -n value, -nvalue; one letter a word */
static vor_status read_short(struct reader *r, const char *text)
{
    const char shown[] = {'-', text[1], '\0'};
    const char *attached = text[2] != '\0' ? text + 2 : NULL;
    int option = find_option(r->cli->command, NULL, 0, text[1]);

    if (option != VOR_OPTION_COUNT)
        return set_option(r, option, shown, attached);
    if (text[1] == 'n' && process_of(r->cli->command) != NULL)
        return set_parameter(r, VOR_PARAM_POINTS, shown, attached);
    return no_option(r, text);
}

static vor_status read_operand(struct reader *r, const char *text)
{
    char quoted[64];

    if (commands[r->cli->command].operand[0] == '\0' || r->cli->input != NULL)
        return vor_fail(r->err, VOR_E_PARAM, "one operand too many: %s",
                        vor_quote(quoted, sizeof quoted, text, strlen(text)));
    r->cli->input = text;
    return VOR_OK;
}

static vor_status read_words(struct reader *r)
{
    int only_operands = 0;
    vor_status status = VOR_OK;

    for (r->at = 1; r->at < r->argc && status == VOR_OK; r->at++) {
        const char *text = r->argv[r->at];

        if (only_operands || text[0] != '-' || text[1] == '\0')
            status = read_operand(r, text);
        else if (strcmp(text, "--") == 0)
            only_operands = 1;
        else
            status = text[1] == '-' ? read_long(r, text) : read_short(r, text);
    }
    return status;
}

static void read_environment(struct vor_cli *cli)
{
    for (int i = 0; i < VOR_OPTION_COUNT; i++)
        if (cli->option[i] == NULL && takes(cli->command, i) && options[i].variable[0] != '\0')
            cli->option[i] = getenv(options[i].variable);
    /* An empty URL is none, so that the variable can be overridden. */
    if (cli->option[VOR_OPTION_SERVER] != NULL && cli->option[VOR_OPTION_SERVER][0] == '\0')
        cli->option[VOR_OPTION_SERVER] = NULL;
}

static vor_status resolve_threads(struct vor_cli *cli, struct vor_error *err)
{
    const char *text = cli->option[VOR_OPTION_THREADS];
    unsigned long threads;
    char *end, quoted[48];

    threads = text != NULL ? strtoul(text, &end, 10) : 0;
    if (text != NULL &&
        (text[0] < '0' || text[0] > '9' || *end != '\0' || threads > VOR_THREADS_MAX))
        return vor_fail_param(
            err, VOR_E_PARAM, "threads", "threads is %s, want a whole number from 0 to %d",
            vor_quote(quoted, sizeof quoted, text, strlen(text)), VOR_THREADS_MAX);
    cli->threads = threads > 0 ? (unsigned)threads : vor_machine_cores();
    return VOR_OK;
}

static vor_status resolve_peak(struct vor_cli *cli, struct vor_error *err)
{
    const char *text = cli->option[VOR_OPTION_PEAK], *shown = "empty";
    char *end, quoted[48];

    if (text == NULL)
        return VOR_OK;
    if (text[0] != '\0')
        shown = vor_quote(quoted, sizeof quoted, text, strlen(text));
    /* strtod alone would take blanks, hexadecimal numbers, infinity and nan. */
    cli->peak = strtod(text, &end);
    if (end == text || text[strspn(text, "0123456789.eE+-")] != '\0' || *end != '\0' ||
        !(cli->peak >= 1e-30 && cli->peak <= 1e30))
        return vor_fail_param(err, VOR_E_PARAM, "peak", "peak is %s, want a number from %g to %g",
                              shown, 1e-30, 1e30);
    if (cli->option[VOR_OPTION_REFERENCE] == NULL)
        return vor_fail_param(err, VOR_E_PARAM, "peak",
                              "peak is %s without a reference: give --reference FILE too", shown);
    return VOR_OK;
}

static vor_status check(struct vor_cli *cli, struct vor_error *err)
{
    const char *operand = commands[cli->command].operand;
    const char *reference = cli->option[VOR_OPTION_REFERENCE];

    if (operand[0] != '\0' && cli->input == NULL)
        return vor_fail(err, VOR_E_PARAM, "no input: give a file, or - for stdin");
    if (reference != NULL && strcmp(reference, "-") == 0 && strcmp(cli->input, "-") == 0)
        return vor_fail(err, VOR_E_PARAM, "both clouds are -, and there is only one stdin");
    if (process_of(cli->command) == NULL)
        return VOR_OK;
    if (cli->option[VOR_OPTION_OUTPUT] == NULL || cli->option[VOR_OPTION_OUTPUT][0] == '\0')
        return vor_fail(err, VOR_E_PARAM, "no output: give -o FILE, or -o - for stdout");
    return vor_spec_complete(&cli->spec, err);
}

vor_status vor_cli_read(struct vor_cli *out, enum vor_command command, int argc, char **argv,
                        struct vor_error *err)
{
    struct reader r = {out, argv, argc, 0, err};
    vor_status status;

    memset(out, 0, sizeof *out);
    out->command = command;
    if (process_of(command) != NULL)
        vor_spec_preset(&out->spec, process_of(command));
    status = read_words(&r);
    if (out->option[VOR_OPTION_HELP] != NULL)
        return VOR_OK;
    read_environment(out);
    if (status == VOR_OK)
        status = resolve_threads(out, err);
    if (status == VOR_OK)
        status = resolve_peak(out, err);
    return status == VOR_OK ? check(out, err) : status;
}

/* "from 1 to 10000000 points, default 100" or "keep | free, default keep". */
static void print_values(FILE *out, enum vor_parameter parameter,
                         const struct vor_parameter_info *info)
{
    char values[VOR_KIND_WORDS_SIZE], text[VOR_SPEC_VALUE_SIZE];
    struct vor_spec spec;

    vor_spec_init(&spec);
    spec.value[parameter] = info->fallback;
    vor_spec_text(&spec, parameter, text);
    vor_kind_values(info, values);
    fprintf(out, "%s%s%s\n", values, text[0] != '\0' ? ", default " : "", text);
}

static void print_options(FILE *out, enum vor_command command)
{
    for (int i = 0; i < VOR_OPTION_COUNT; i++) {
        const struct option_row *o = &options[i];

        if (!takes(command, i))
            continue;
        fprintf(out, "  %c%c%c --%s%s%s\n      %s", o->letter ? '-' : ' ',
                o->letter ? o->letter : ' ', o->letter ? ',' : ' ', o->name, o->value[0] ? " " : "",
                o->value, o->sentence);
        if (o->variable[0] != '\0')
            fprintf(out, " (env: %s)", o->variable);
        fputc('\n', out);
    }
}

void vor_cli_help(FILE *out, enum vor_command command)
{
    const struct command_row *c = &commands[command];
    const struct vor_process_info *process = process_of(command);

    fprintf(out, "usage: voronoid %s%s%s [OPTION]...\n%s.%s\n\nOptions:\n", c->name,
            c->operand[0] ? " " : "", c->operand, c->sentence,
            c->operand[0] ? " - as a file is stdin or stdout." : "");
    print_options(out, command);
    if (process == NULL)
        return;
    fputs("\nParameters of the request, the same over HTTP:\n", out);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;
        struct vor_parameter_info info = vor_process_parameter(process, parameter);

        if (!vor_process_takes(process, parameter))
            continue;
        fprintf(out, "  %s --%s VALUE\n      %s\n      ", i == VOR_PARAM_POINTS ? "-n," : "   ",
                info.name, info.sentence);
        print_values(out, parameter, &info);
    }
}

void vor_cli_overview(FILE *out)
{
    fputs("usage: voronoid COMMAND [OPTION]...\n\nCommands:\n", out);
    fprintf(out, "  %-9s %s\n", "serve", "Run the daemon");
    for (int i = 0; i < VOR_COMMAND_COUNT; i++)
        fprintf(out, "  %-9s %s\n", commands[i].name, commands[i].sentence);
    fputs("\nvoronoid COMMAND --help shows the options of a command, voronoid --version the "
          "version.\nExit codes: 0 ok, 1 failed, 2 usage, 3 input rejected, 4 cancelled (130 on "
          "^C), 5 server unreachable\nor busy.\n",
          out);
}
