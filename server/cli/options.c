#include "server/cli/options.h"

#include "core/base/parallel.h"
#include "core/base/quote.h"
#include "proto/codec.h"
#include "proto/text.h"
#include "server/base/machine.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static const struct vor_option_info options[VOR_OPTION_COUNT] = {
#define OPTION_ROW(id, name, letter, value, variable, commands, sentence)                          \
    {name, value, variable, sentence, commands, letter},
    VOR_OPTION_TABLE(OPTION_ROW)
#undef OPTION_ROW
};

enum { SHOWN_SIZE = 48 /* of what a caller wrote, in a message */ };

/* The word that is being read, and where it goes. */
struct reader {
    struct vor_cli *cli;
    char **argv;
    int argc, at;
    struct vor_error *err;
};

const struct vor_option_info *vor_option_info(enum vor_option option)
{
    assert((unsigned)option < VOR_OPTION_COUNT);
    return &options[option];
}

static int is_name(const char *text, size_t length, const char *name)
{
    return strlen(name) == length && memcmp(text, name, length) == 0;
}

/* The option of that name (length bytes) or letter, VOR_OPTION_COUNT when the command has none. */
static int find_option(const struct vor_command *command, const char *name, size_t length,
                       char letter)
{
    int i = 0;

    for (; i < VOR_OPTION_COUNT; i++) {
        if ((options[i].commands & command->does) == 0)
            continue;
        if (letter != 0 ? options[i].letter == letter : is_name(name, length, options[i].name))
            break;
    }
    return i;
}

/* The input of that name that is an option; 0, the operand, when there is none. */
static unsigned find_input(const struct vor_command *command, const char *name, size_t length)
{
    const struct vor_process_info *process = command->process;

    for (unsigned i = 1; process != NULL && process->inputs[i].name != NULL; i++)
        if (is_name(name, length, process->inputs[i].name))
            return i;
    return 0;
}

/* The parameter of that name, whether the process takes it or not; VOR_PARAMETER_COUNT when there
 * is none, or no process. */
static enum vor_parameter find_parameter(const struct vor_command *command, const char *name,
                                         size_t length)
{
    int i = 0;

    while (i < VOR_PARAMETER_COUNT &&
           !is_name(name, length, vor_parameter_info((enum vor_parameter)i)->name))
        i++;
    return command->process != NULL ? (enum vor_parameter)i : VOR_PARAMETER_COUNT;
}

static vor_status no_option(const struct reader *r, const char *text)
{
    char quoted[SHOWN_SIZE];

    return vor_fail(r->err, VOR_E_PARAM, "no option %s; see voronoid %s --help",
                    vor_quote(quoted, sizeof quoted, text, strlen(text)), r->cli->command->name);
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

static vor_status set_input(struct reader *r, unsigned input, const char *shown,
                            const char *attached)
{
    r->cli->input[input] = take_value(r, shown, attached);
    return r->cli->input[input] != NULL ? VOR_OK : VOR_E_PARAM;
}

/* A flag that stands alone is true; what follows it is not its value. */
static vor_status set_parameter(struct reader *r, enum vor_parameter parameter, const char *shown,
                                const char *attached)
{
    const struct vor_parameter_info *info = vor_parameter_info(parameter);
    struct vor_spec *spec = &r->cli->spec;
    const char *value;

    if (!vor_process_takes(spec->process, parameter))
        return vor_spec_set(spec, info->name, "", r->err); /* refuses the name */
    if (info->kind == VOR_KIND_FLAG && attached == NULL)
        value = "true";
    else
        value = take_value(r, shown, attached);
    if (value == NULL)
        return VOR_E_PARAM;
    r->cli->given[parameter] = 1;
    return vor_spec_set(spec, info->name, value, r->err);
}

/* --name, --name value, --name=value */
static vor_status read_long(struct reader *r, const char *text)
{
    const char *name = text + 2, *equals = strchr(name, '=');
    size_t length = equals != NULL ? (size_t)(equals - name) : strlen(name);
    const struct vor_command *command = r->cli->command;
    const char *attached = equals != NULL ? equals + 1 : NULL;
    int option = find_option(command, name, length, 0);
    unsigned input = find_input(command, name, length);
    enum vor_parameter parameter = find_parameter(command, name, length);
    char shown[SHOWN_SIZE];

    vor_quote(shown, sizeof shown, text, length + 2);
    if (option != VOR_OPTION_COUNT)
        return set_option(r, option, shown, attached);
    if (input > 0)
        return set_input(r, input, shown, attached);
    if (parameter != VOR_PARAMETER_COUNT)
        return set_parameter(r, parameter, shown, attached);
    return no_option(r, shown);
}

/* -n value, -nvalue; one letter a word */
static vor_status read_short(struct reader *r, const char *text)
{
    const char shown[] = {'-', text[1], '\0'};
    const char *attached = text[2] != '\0' ? text + 2 : NULL;
    const struct vor_command *command = r->cli->command;
    int option = find_option(command, NULL, 0, text[1]);

    if (option != VOR_OPTION_COUNT)
        return set_option(r, option, shown, attached);
    if (text[1] == 'n' && command->process != NULL &&
        vor_process_takes(command->process, VOR_PARAM_POINTS))
        return set_parameter(r, VOR_PARAM_POINTS, shown, attached);
    return no_option(r, text);
}

static vor_status read_operand(struct reader *r, const char *text)
{
    char quoted[SHOWN_SIZE];

    if (r->cli->command->process == NULL || r->cli->input[0] != NULL)
        return vor_fail(r->err, VOR_E_PARAM, "one operand too many: %s",
                        vor_quote(quoted, sizeof quoted, text, strlen(text)));
    r->cli->input[0] = text;
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
        if (cli->option[i] == NULL && (options[i].commands & cli->command->does) != 0 &&
            options[i].variable[0] != '\0')
            cli->option[i] = getenv(options[i].variable);
    /* An empty URL is none, so that the variable can be overridden. */
    if (cli->option[VOR_OPTION_SERVER] != NULL && cli->option[VOR_OPTION_SERVER][0] == '\0')
        cli->option[VOR_OPTION_SERVER] = NULL;
}

static vor_status resolve_threads(struct vor_cli *cli, struct vor_error *err)
{
    const char *text = cli->option[VOR_OPTION_THREADS];
    unsigned long threads;
    char *end, quoted[SHOWN_SIZE];

    threads = text != NULL ? strtoul(text, &end, 10) : 0;
    if (text != NULL &&
        (text[0] < '0' || text[0] > '9' || *end != '\0' || threads > VOR_THREADS_MAX))
        return vor_fail_param(
            err, VOR_E_PARAM, "threads", "threads is %s, want a whole number from 0 to %d",
            vor_quote(quoted, sizeof quoted, text, strlen(text)), VOR_THREADS_MAX);
    cli->threads = threads > 0 ? (unsigned)threads : vor_machine_cores();
    return VOR_OK;
}

/* The end of a file's name from its last dot on; NULL where it has none, or begins with it. */
static const char *suffix_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;
    const char *dot = strrchr(name, '.');

    return dot != NULL && dot != name && dot[1] != '\0' ? dot : NULL;
}

/* A cloud in a file whose name promises a format that is not written is refused, unless the request
 * names the format. */
static vor_status check_suffix(const struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_process_info *process = cli->command->process;
    const char *suffix = suffix_of(cli->option[VOR_OPTION_OUTPUT]);
    char quoted[SHOWN_SIZE];
    struct vor_text served;
    vor_status status;

    if (process->outputs[0].kind != VOR_ARTEFACT_CLOUD || suffix == NULL ||
        cli->given[VOR_PARAM_FORMAT] || vor_format_by_suffix(suffix) != NULL)
        return VOR_OK;
    vor_text_init(&served, 0);
    for (unsigned i = 0; vor_format(i) != NULL; i++)
        vor_text_printf(&served, "%s%s", i > 0 ? ", " : "", vor_format(i)->suffix);
    status = vor_text_status(&served, err);
    if (status == VOR_OK)
        status =
            vor_fail(err, VOR_E_PARAM, "the output's suffix is %s, want one of %s; or say --format",
                     vor_quote(quoted, sizeof quoted, suffix, strlen(suffix)), served.data);
    vor_text_free(&served);
    return status;
}

/* A cloud needs a place to go to; a document is printed when it has none. */
static vor_status resolve_output(struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_artefact_info *main_output = &cli->command->process->outputs[0];
    const char **output = &cli->option[VOR_OPTION_OUTPUT];

    if (*output == NULL && main_output->kind == VOR_ARTEFACT_DOCUMENT)
        *output = "-";
    if (*output == NULL || (*output)[0] == '\0')
        return vor_fail(err, VOR_E_PARAM, "no output: give -o FILE, or -o - for stdout");
    return VOR_OK;
}

/* A parameter or the process itself may need an input that is an option. */
static vor_status check_inputs(const struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_process_info *process = cli->command->process;
    const char *needed = NULL;
    struct vor_error why;
    unsigned inputs = 0;

    for (unsigned i = 0; process->inputs[i].name != NULL; i++)
        inputs |= cli->input[i] != NULL ? 1u << i : 0;
    if (vor_spec_check_inputs(&cli->spec, inputs, &why) == VOR_OK)
        return VOR_OK;
    needed = find_input(cli->command, why.parameter, strlen(why.parameter)) > 0
                 ? why.parameter
                 : vor_parameter_needs(vor_parameter_find(why.parameter));
    return vor_fail_param(err, why.status, why.parameter, "%s: give --%s FILE too", why.message,
                          needed);
}

static vor_status check_files(const struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_process_info *process = cli->command->process;
    int stdins = 0;

    if (cli->input[0] == NULL)
        return vor_fail(err, VOR_E_PARAM, "no input: give a file, or - for stdin");
    for (unsigned i = 0; process->inputs[i].name != NULL; i++) {
        if (cli->input[i] == NULL)
            continue;
        stdins += strcmp(cli->input[i], "-") == 0;
        if (i > 0 && cli->option[VOR_OPTION_SERVER] != NULL)
            return vor_fail(err, VOR_E_PARAM,
                            "--%s does not go with --server: a request carries one cloud",
                            process->inputs[i].name);
    }
    if (stdins > 1)
        return vor_fail(err, VOR_E_PARAM, "both clouds are -, and there is only one stdin");
    return VOR_OK;
}

static vor_status check(struct vor_cli *cli, struct vor_error *err)
{
    vor_status status;

    if (cli->command->process == NULL)
        return VOR_OK;
    status = check_files(cli, err);
    if (status == VOR_OK)
        status = resolve_output(cli, err);
    if (status == VOR_OK)
        status = check_suffix(cli, err);
    if (status == VOR_OK)
        status = vor_spec_complete(&cli->spec, err);
    return status == VOR_OK ? check_inputs(cli, err) : status;
}

vor_status vor_cli_read(struct vor_cli *out, const struct vor_command *command, int argc,
                        char **argv, struct vor_error *err)
{
    struct reader r = {out, argv, argc, 0, err};
    vor_status status;

    memset(out, 0, sizeof *out);
    out->command = command;
    if (command->process != NULL)
        vor_spec_preset(&out->spec, command->process);
    status = read_words(&r);
    if (out->option[VOR_OPTION_HELP] != NULL)
        return VOR_OK;
    read_environment(out);
    if (status == VOR_OK)
        status = resolve_threads(out, err);
    return status == VOR_OK ? check(out, err) : status;
}
