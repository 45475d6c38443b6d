#include "server/cli/options.h"

#include "core/base/nearest.h"
#include "core/base/quote.h"
#include "core/spec/decimal.h"
#include "proto/codec.h"
#include "proto/text.h"
#include "server/base/config.h"
#include "server/base/machine.h"
#include "server/base/option.h"
#include "server/base/reference.h"
#include "server/base/uuid.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* What getopt_long returns for a long option is its row behind one of the last, above every letter.
 */
enum {
    OPERAND = 1, /* what it returns for an operand, and for letters */
    LONG_OPTION = 256,
    LONG_INPUT = LONG_OPTION + VOR_OPTION_COUNT,
    LONG_PARAMETER = LONG_INPUT + VOR_INPUTS_MAX,
    LONGS_MAX = VOR_OPTION_COUNT + VOR_INPUTS_MAX + 2 * VOR_PARAMETER_COUNT,
    SHOWN_SIZE = 48, /* of what a caller wrote, in a message */
    NAMES_SIZE = 256 /* of the names that an ambiguous one may stand for */
};

static const struct vor_option_row options[VOR_OPTION_COUNT] = {
#define OPTION_ROW(id, name, letter, type, unit, min, max, fallback, variable, commands, sentence) \
    {name, VOR_TYPE_##type, unit, min, max, fallback, sentence, variable, commands, letter},
    VOR_OPTION_TABLE(OPTION_ROW)
#undef OPTION_ROW
};

/* The word that is being read, and where it goes. */
struct reader {
    struct vor_cli *cli;
    char **argv;
    struct vor_error *err;
    struct option longs[LONGS_MAX + 1]; /* the last one is zero */
    int count;
    char parameters[VOR_PARAMETER_COUNT][VOR_REFERENCE_NAME_SIZE];
    char letters[2 * VOR_OPTION_COUNT + 8];
};

const struct vor_option_row *vor_option_info(enum vor_option option)
{
    return &options[option];
}

int vor_command_takes(const struct vor_command *command, enum vor_option option)
{
    if (option == VOR_OPTION_PRESET &&
        (command->process == NULL || vor_named_preset(command->process->id, 0) == NULL))
        return 0;
    return (options[option].commands & command->does) != 0;
}

const struct vor_option_row *vor_command_option(const struct vor_command *command, unsigned index)
{
    if ((command->does & VOR_COMMAND_SERVES) != 0) {
        if (index < VOR_SETTING_COUNT)
            return &vor_setting_infos[index];
        index -= VOR_SETTING_COUNT;
    }
    for (int i = 0; i < VOR_OPTION_COUNT; i++)
        if (vor_command_takes(command, (enum vor_option)i) && index-- == 0)
            return &options[i];
    return NULL;
}

int vor_cli_into_folder(const struct vor_cli *cli)
{
    enum vor_option option =
        vor_command_takes(cli->command, VOR_OPTION_INTO) ? VOR_OPTION_INTO : VOR_OPTION_OUTPUT;
    const char *output = cli->option[option];
    size_t length = output != NULL ? strlen(output) : 0;

    return length > 0 && output[length - 1] == '/';
}

/* Refusals. */

/* A word that getopt_long does not know. */
static vor_status refuse_word(const struct reader *r, const char *word)
{
    char names[NAMES_SIZE] = "";
    const struct vor_process_info *process = r->cli->command->process;
    size_t length = strcspn(word, "=");
    char exact[SHOWN_SIZE], option[VOR_REFERENCE_NAME_SIZE];
    const char *name = exact;
    enum vor_parameter parameter = (enum vor_parameter)0;

    (void)snprintf(exact, sizeof exact, "%.*s", (int)(length < SHOWN_SIZE ? length : 0), word);
    name += strspn(exact, "-"); /* with capitals or with dashes */
    while (parameter < VOR_PARAMETER_COUNT &&
           strcmp(name, vor_parameter_info(parameter)->name) != 0 &&
           strcmp(name, vor_reference_option(option, parameter)) != 0)
        parameter++;
    if (word[1] == '-' && process != NULL && parameter != VOR_PARAMETER_COUNT &&
        !vor_process_takes(process, parameter)) {
        for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++) {
            size_t at = strlen(names);

            if (vor_process_takes(process, parameter))
                (void)snprintf(names + at, sizeof names - at, "%s%s", at > 0 ? ", " : "",
                               process->id);
        }
        return vor_fail(r->err, VOR_E_PARAM, "%s is an option of %s, not of %s",
                        VOR_QUOTED(SHOWN_SIZE, word, length), names, r->cli->command->process->id);
    }
    return vor_option_refuse(r->longs, word, r->cli->command->name, r->err);
}

/* Reading. */

static void add_long(struct reader *r, const char *name, int argument, int value)
{
    r->longs[r->count++] = (struct option){name, argument, NULL, value};
}

static void add_letter(struct reader *r, char letter, int has_value)
{
    size_t at = strlen(r->letters);

    (void)snprintf(r->letters + at, sizeof r->letters - at, "%c%s", letter, has_value ? ":" : "");
}

/* What getopt_long takes. "-" has operands come in their order, whatever POSIXLY_CORRECT says; ":"
 * tells a missing value from an unknown option, and prints nothing. A parameter whose name has
 * capitals has two rows, one behind the other: "max-aspect", "maxAspect". */
static void name_options(struct reader *r)
{
    const struct vor_command *command = r->cli->command;
    const struct vor_process_info *process = command->process;

    memcpy(r->letters, "-:", sizeof "-:");
    for (int i = 0; i < VOR_OPTION_COUNT; i++) {
        int has_value = options[i].type != VOR_TYPE_FLAG;

        if (!vor_command_takes(command, (enum vor_option)i))
            continue;
        add_long(r, options[i].name, has_value ? required_argument : no_argument, LONG_OPTION + i);
        if (options[i].letter != 0)
            add_letter(r, options[i].letter, has_value);
    }
    for (int i = 1; process != NULL && process->inputs[i].name != NULL; i++)
        add_long(r, process->inputs[i].name, required_argument, LONG_INPUT + i);
    for (int i = 0; process != NULL && i < VOR_PARAMETER_COUNT; i++) {
        const struct vor_parameter_info *info = vor_parameter_info((enum vor_parameter)i);
        int argument = info->kind == VOR_KIND_FLAG ? optional_argument : required_argument;

        if (!vor_process_takes(process, (enum vor_parameter)i))
            continue;
        add_long(r, vor_reference_option(r->parameters[i], (enum vor_parameter)i), argument,
                 LONG_PARAMETER + i);
        if (strcmp(r->parameters[i], info->name) != 0)
            add_long(r, info->name, argument, LONG_PARAMETER + i);
        if (i == VOR_PARAM_POINTS)
            add_letter(r, 'n', 1);
    }
}

/* A flag that stands alone is true; what follows it is not its value. A ratio may be in percent. */
static vor_status set_parameter(struct reader *r, enum vor_parameter parameter, const char *value)
{
    const struct vor_parameter_info *info = vor_parameter_info(parameter);
    size_t length = value != NULL ? strlen(value) : 0;
    double percent;

    r->cli->given[parameter] = 1;
    if (parameter == VOR_PARAM_RATIO && length > 1 && value[length - 1] == '%' &&
        vor_decimal_read(&percent, value, length - 1))
        return vor_spec_set_number(&r->cli->spec, info->name, percent / 100, r->err);
    return vor_spec_set(&r->cli->spec, info->name, value != NULL ? value : "true", r->err);
}

/* Operands are gathered in front of what is still to be read. */
static vor_status add_operand(struct reader *r, char *text)
{
    struct vor_cli *cli = r->cli;

    if (cli->operand_count == cli->command->most)
        return vor_fail(r->err, VOR_E_PARAM, "%s is one operand too many",
                        VOR_QUOTED(SHOWN_SIZE, text, strlen(text)));
    cli->operands[cli->operand_count++] = text;
    return VOR_OK;
}

/* Takes what getopt_long returned. */
static vor_status take(struct reader *r, int got)
{
    int option = LONG_OPTION <= got && got < LONG_INPUT ? got - LONG_OPTION : 0;

    while (got < LONG_OPTION && option < VOR_OPTION_COUNT &&
           !(options[option].letter == got &&
             vor_command_takes(r->cli->command, (enum vor_option)option)))
        option++;
    if (got == '?' || got == ':') {
        const char letter[] = {'-', (char)optopt, '\0'};
        const char *word = 0 < optopt && optopt < LONG_OPTION ? letter : r->argv[optind - 1];
        char shown[SHOWN_SIZE];

        /* '?', or ':' for a value that is missing. optopt is then what it would have returned, or 0
         * for a long option that it does not know. One that it knows is shown as it was written. */
        if (got == '?' && optopt < LONG_OPTION)
            return refuse_word(r, word);
        return vor_fail(r->err, VOR_E_PARAM, "%s %s",
                        vor_quote(shown, sizeof shown, word, strcspn(word, "=")),
                        got == ':' ? "needs a value" : "takes no value");
    }
    if (got == OPERAND)
        return add_operand(r, optarg);
    if (got >= LONG_PARAMETER)
        return set_parameter(r, (enum vor_parameter)(got - LONG_PARAMETER), optarg);
    if (got >= LONG_INPUT)
        r->cli->input[got - LONG_INPUT] = optarg;
    else if (option == VOR_OPTION_COUNT)
        return set_parameter(r, VOR_PARAM_POINTS, optarg);
    else
        r->cli->option[option] = optarg != NULL ? optarg : "";
    return VOR_OK;
}

/* What no option has given is its variable's; what is a number, or has a default that is one, is
 * read. */
static vor_status take_values(struct vor_cli *cli, struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (int i = 0; i < VOR_OPTION_COUNT && status == VOR_OK; i++) {
        const struct vor_option_row *info = &options[i];

        if (!vor_command_takes(cli->command, (enum vor_option)i))
            continue;
        if (cli->option[i] == NULL && info->variable[0] != '\0')
            cli->option[i] = getenv(info->variable);
        if (info->type == VOR_TYPE_COUNT_OF)
            status = vor_option_read(&cli->number[i], info,
                                     cli->option[i] != NULL ? cli->option[i] : info->fallback, err);
    }
    /* An empty URL is none, so that the variable can be overridden. */
    if (cli->option[VOR_OPTION_SERVER] != NULL && cli->option[VOR_OPTION_SERVER][0] == '\0')
        cli->option[VOR_OPTION_SERVER] = NULL;
    cli->threads = (unsigned)cli->number[VOR_OPTION_THREADS];
    if (cli->threads == 0)
        cli->threads = vor_machine_cores();
    return status;
}

/* Checks. */

vor_status vor_cli_check_suffix(const struct vor_cli *cli, const char *path, struct vor_error *err)
{
    const struct vor_process_info *process = cli->command->process;
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;
    const char *suffix = strrchr(name, '.');
    struct vor_text served;
    vor_status status;

    if (process->outputs[0].kind != VOR_ARTEFACT_CLOUD || suffix == NULL || suffix == name ||
        suffix[1] == '\0' || cli->given[VOR_PARAM_FORMAT] || vor_format_by_suffix(suffix) != NULL)
        return VOR_OK;
    vor_text_init(&served, 0);
    for (unsigned i = 0; vor_format(i) != NULL; i++)
        vor_text_printf(&served, "%s%s", i > 0 ? ", " : "", vor_format(i)->suffix);
    status = vor_text_status(&served, err);
    VOR_THEN(status, vor_fail(err, VOR_E_PARAM,
                              "the suffix of the output is %s, want one of %s, or give --format",
                              VOR_QUOTED(SHOWN_SIZE, suffix, strlen(suffix)), served.data));
    vor_text_free(&served);
    return status;
}

/* Where results go, in these forms: a folder gets a slash at its end, and several results, of what
 * the operands are, need one. */
static vor_status check_output(struct vor_cli *cli, const char **output, const char *forms,
                               const char *operands, struct vor_error *err)
{
    struct stat info;

    if (*output == NULL || (*output)[0] == '\0')
        return vor_fail(err, VOR_E_PARAM, "no output: give %s or -o - for stdout", forms);
    if (!vor_cli_into_folder(cli) && stat(*output, &info) == 0 && S_ISDIR(info.st_mode) &&
        snprintf(cli->folder, sizeof cli->folder, "%s/", *output) < (int)sizeof cli->folder)
        *output = cli->folder;
    if (cli->operand_count > 1 && !vor_cli_into_folder(cli))
        return vor_fail(err, VOR_E_PARAM, "%d %s need a folder for their results: give -o DIR/",
                        cli->operand_count, operands);
    return (cli->command->does & VOR_COMMAND_RUNS) != 0 ? vor_cli_check_suffix(cli, *output, err)
                                                        : VOR_OK;
}

/* A parameter or the process itself may need an input that is an option. */
static vor_status check_inputs(const struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_process_info *process = cli->command->process;
    const struct vor_artefact_info *input;
    const char *needed = NULL;
    struct vor_error why;
    unsigned inputs = 0;
    long option; /* 0: the operand, or none */

    for (unsigned i = 0; process->inputs[i].name != NULL; i++)
        inputs |=
            cli->input[i] != NULL || (cli->command->does & VOR_COMMAND_FRAMES) != 0 ? 1u << i : 0;
    if (vor_spec_check_inputs(&cli->spec, inputs, &why) == VOR_OK)
        return VOR_OK;
    input = vor_artefact_find(process->inputs, why.parameter);
    option = input != NULL ? input - process->inputs : 0;
    if (option > 0 && (inputs >> option & 1) != 0) /* it is there, but does not fit */
        return vor_fail_param(err, why.status, why.parameter, "%s", why.message);
    needed = option > 0 ? why.parameter : vor_parameter_needs(vor_parameter_find(why.parameter));
    return vor_fail_param(err, why.status, why.parameter, "%s: give --%s FILE too", why.message,
                          needed);
}

static vor_status check_files(struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_process_info *process = cli->command->process;
    int stdins = 0;

    if (cli->operand_count == 0)
        return vor_fail(err, VOR_E_PARAM, "no input: give a file, or - for stdin");
    cli->input[0] = cli->operands[0];
    for (unsigned i = 0; process->inputs[i].name != NULL; i++)
        stdins += cli->input[i] != NULL && strcmp(cli->input[i], "-") == 0;
    if (cli->option[VOR_OPTION_NAME] != NULL && cli->option[VOR_OPTION_SERVER] == NULL)
        return vor_fail(err, VOR_E_PARAM, "--name names the job on a daemon: give --server too");
    if (stdins > 1)
        return vor_fail(err, VOR_E_PARAM,
                        "both clouds are given as - (stdin), but stdin has only one cloud: want a "
                        "file for one of them");
    return VOR_OK;
}

/* Whether a parameter was named, or one that says the same in its place. */
static int is_given(const struct vor_cli *cli, enum vor_parameter parameter)
{
    /* One of the three that say how many points stands for all. */
    if (parameter == VOR_PARAM_POINTS || parameter == VOR_PARAM_RATIO ||
        parameter == VOR_PARAM_SPACING)
        return cli->given[VOR_PARAM_POINTS] || cli->given[VOR_PARAM_RATIO] ||
               cli->given[VOR_PARAM_SPACING];
    return cli->given[parameter];
}

/* Sets what a preset says of parameters that were not named; they count as named from then on. */
static vor_status take_preset(struct vor_cli *cli, struct vor_error *err)
{
    const char *name = cli->option[VOR_OPTION_PRESET];
    const struct vor_named_preset *preset =
        name != NULL ? vor_named_preset_find(cli->command->process->id, name) : NULL;
    const char *at = preset != NULL ? preset->values : "";
    char value[VOR_PRESET_VALUE_SIZE];
    enum vor_parameter parameter;
    vor_status status = VOR_OK;

    if (name != NULL && preset == NULL) {
        const char *process = cli->command->process->id;
        char names[NAMES_SIZE], meant[VOR_NEAREST_TEXT_SIZE];
        struct vor_nearest nearest;
        size_t end = 0;

        vor_nearest_init(&nearest, name, strlen(name));
        for (unsigned i = 0; (preset = vor_named_preset(process, i)) != NULL && end < sizeof names;
             i++) {
            end += (size_t)snprintf(names + end, sizeof names - end, "%s%s", i > 0 ? ", " : "",
                                    preset->name);
            vor_nearest_try(&nearest, preset->name, strlen(preset->name));
        }
        return vor_fail(err, VOR_E_PARAM, "--preset is %s, want one of %s%s",
                        VOR_QUOTED(SHOWN_SIZE, name, strlen(name)), names,
                        vor_nearest_text(&nearest, "", meant));
    }
    while (status == VOR_OK && vor_named_preset_next(&at, &parameter, value)) {
        if (is_given(cli, parameter))
            continue;
        cli->given[parameter] = 1;
        status = vor_spec_set(&cli->spec, vor_parameter_info(parameter)->name, value, err);
    }
    return status;
}

/* IDs become part of URLs and of file names. */
static vor_status check_jobs(const struct vor_cli *cli, struct vor_error *err)
{
    if (cli->operand_count < cli->command->least)
        return vor_fail(err, VOR_E_PARAM, "no job: give its ID; see voronoid jobs");
    for (int i = 0; i < cli->operand_count; i++) {
        const char *text = cli->operands[i];

        if (!vor_uuid_begins(text, strlen(text)))
            return vor_fail(err, VOR_E_PARAM,
                            "\"%s\" is not a job, want an ID such as "
                            "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11 or its beginning",
                            VOR_QUOTED(SHOWN_SIZE, text, strlen(text)));
    }
    return VOR_OK;
}

vor_status vor_cli_read(struct vor_cli *out, const struct vor_command *command, int argc,
                        char **argv, struct vor_error *err)
{
    struct reader r = {.cli = out, .argv = argv, .err = err};
    vor_status status = VOR_OK;
    int got;

    memset(out, 0, sizeof *out);
    out->command = command;
    if (command->process != NULL)
        vor_spec_preset(&out->spec, command->process);
    name_options(&r);
    out->operands = argv + 1;
    optind = 0; /* glibc's word for a new command line */
    while (status == VOR_OK && (got = getopt_long(argc, argv, r.letters, r.longs, NULL)) != -1)
        status = take(&r, got);
    while (status == VOR_OK && optind < argc)
        status = add_operand(&r, argv[optind++]);
    if (out->option[VOR_OPTION_HELP] != NULL)
        return VOR_OK;
    VOR_THEN(status, take_values(out, err));
    if (status == VOR_OK && command->process != NULL) {
        status = check_files(out, err);
        if (status == VOR_OK && (command->does & VOR_COMMAND_RUNS) != 0) {
            const char **output = &out->option[VOR_OPTION_OUTPUT];

            /* A cloud needs a place to go to; a document is printed when it has none. */
            if (*output == NULL && command->process->outputs[0].kind == VOR_ARTEFACT_DOCUMENT)
                *output = "-";
            status = check_output(out, output, "-o FILE,", "inputs", err);
        }
        VOR_THEN(status, take_preset(out, err));
        if (status == VOR_OK && (command->does & VOR_COMMAND_FRAMES) != 0) {
            /* What the process asks for, or takes for a cloud that is alone. */
            static const enum vor_parameter of_frames[] = {VOR_PARAM_RATIO, VOR_PARAM_COHERENCE};

            for (size_t i = 0; i < sizeof of_frames / sizeof of_frames[0]; i++) {
                if (is_given(out, of_frames[i]))
                    continue;
                out->given[of_frames[i]] = 1;
                out->spec.value[of_frames[i]] = 1;
            }
        }
        VOR_THEN(status, vor_spec_complete(&out->spec, err));
        VOR_THEN(status, check_inputs(out, err));
    }
    if (status == VOR_OK && (command->does & VOR_COMMAND_JOBS) != 0)
        status = check_jobs(out, err);
    if (status == VOR_OK && (command->does & VOR_COMMAND_FETCHES) != 0) {
        if (out->option[VOR_OPTION_INTO] == NULL)
            out->option[VOR_OPTION_INTO] = "./";
        status = check_output(out, &out->option[VOR_OPTION_INTO], "-o FILE, -o DIR/,", "jobs", err);
    }
    return status;
}
