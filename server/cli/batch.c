#include "server/cli/commands.h"

#include "proto/codec.h"
#include "proto/json/json.h"
#include "server/cli/cli_log.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Number of the input of resample that is the result for the frame before. */
enum { PREVIOUS = 1 };

/* A result and the input that it is of. */
struct result {
    const char *input;
    char *output;
    int replace; /* a file that has its name */
    int is_done;
};

static int is_interrupted(void)
{
    return vor_interrupt_seen() || vor_interrupt_stops();
}

int vor_cli_each(const struct vor_cli *cli,
                 int (*one)(const struct vor_cli *cli, int index, void *ctx), void *ctx)
{
    int failed = 0, done = 0, first = VOR_EXIT_OK;
    char line[64];

    for (; done < cli->operand_count && !is_interrupted(); done++) {
        int code = one(cli, done, ctx);

        failed += code != VOR_EXIT_OK;
        if (first == VOR_EXIT_OK)
            first = code;
    }
    if (is_interrupted() && (failed > 0 || done < cli->operand_count))
        return vor_cli_interrupted();
    if (failed > 0 && cli->operand_count > 1) {
        (void)snprintf(line, sizeof line, "%d of %d failed", failed, cli->operand_count);
        vor_cli_say(cli->command->name, line);
    }
    return first;
}

/* FOLDER/BASE with the suffix in the place of that of a format; NULL without memory. */
static char *name_output(const char *folder, const char *base, const char *suffix)
{
    const struct vor_format *format = vor_format_by_suffix(base);
    size_t stem = strlen(base), size;
    char *name;

    if (suffix != NULL && format != NULL)
        stem -= strlen(format->suffix);
    size = strlen(folder) + stem + (suffix != NULL ? strlen(suffix) : 0) + 1;
    name = malloc(size);
    if (name != NULL)
        (void)snprintf(name, size, "%s%.*s%s", folder, (int)stem, base,
                       suffix != NULL ? suffix : "");
    return name;
}

static vor_status name_results(struct result *results, const struct vor_cli *cli,
                               struct vor_error *err)
{
    const char *suffix =
        NULL; /* that replaces the input's; NULL: the result keeps its name whole */
    struct vor_error why;

    if (cli->spec.process->outputs[0].kind == VOR_ARTEFACT_DOCUMENT)
        suffix = ".json";
    else if (vor_process_takes(cli->spec.process, VOR_PARAM_FORMAT) &&
             vor_spec_given(&cli->spec, VOR_PARAM_FORMAT))
        suffix = vor_format((unsigned)cli->spec.value[VOR_PARAM_FORMAT])->suffix;
    for (int i = 0; i < cli->operand_count; i++) {
        const char *input = cli->operands[i], *slash = strrchr(input, '/');
        const char *base = slash != NULL ? slash + 1 : input;

        if (strcmp(input, "-") == 0 || base[0] == '\0')
            return vor_fail(err, VOR_E_PARAM,
                            "%s has no file name, so the result in %s cannot be named after it",
                            input[0] != '\0' ? input : "an empty input",
                            cli->option[VOR_OPTION_OUTPUT]);
        results[i].input = input;
        results[i].output = name_output(cli->option[VOR_OPTION_OUTPUT], base, suffix);
        if (results[i].output == NULL)
            return vor_fail(err, VOR_E_NOMEM, "the names of %d results", cli->operand_count);
        if (vor_cli_check_suffix(cli, results[i].output, &why) != VOR_OK)
            return vor_fail(err, why.status, "the result of %.300s cannot be written: %.300s",
                            input, why.message);
    }
    return VOR_OK;
}

static int by_output(const void *a, const void *b)
{
    const struct result *left = a, *right = b;

    return strcmp(left->output, right->output);
}

/* Two inputs of one name would leave one result. */
static vor_status check_names(const struct result *results, int count, struct vor_error *err)
{
    vor_status status = VOR_OK;
    struct result *sorted;

    assert(count > 0);
    sorted = calloc((size_t)count, sizeof *sorted);
    if (sorted == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the names of %d results", count);
    memcpy(sorted, results, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, by_output);
    for (int i = 1; i < count && status == VOR_OK; i++)
        if (by_output(&sorted[i - 1], &sorted[i]) == 0)
            status = vor_fail(err, VOR_E_PARAM,
                              "the results of %.300s and %.300s would have the "
                              "same file name, %.300s",
                              sorted[i - 1].input, sorted[i].input, sorted[i].output);
    free(sorted);
    return status;
}

/* What a batch is about. */
struct batch {
    const struct vor_cli *cli;
    struct result *results;            /* one for each operand */
    struct vor_attribute_names common; /* that all frames have, of a sequence */
    int (*run)(const struct vor_cli *cli);
};

/* The result for the last frame before that has one; else what the command line says. */
static const char *previous_of(const struct batch *batch, int index)
{
    while (index-- > 0)
        if (batch->results[index].is_done)
            return batch->results[index].output;
    return batch->cli->input[PREVIOUS];
}

/* A process without a report has no summary: its results get one here. */
static int run_one(const struct vor_cli *cli, int index, void *ctx)
{
    struct vor_text text;
    const struct batch *batch = ctx;
    struct result *result = &batch->results[index];
    struct vor_cli one = *cli;
    int is_quiet = one.option[VOR_OPTION_QUIET] != NULL || one.option[VOR_OPTION_JSON] != NULL ||
                   vor_artefact_find(one.spec.process->outputs, "report") != NULL;
    int code;

    one.operand_count = 1;
    one.input[0] = result->input;
    if ((one.command->does & VOR_COMMAND_FRAMES) != 0) {
        one.keep = &batch->common;
        one.input[PREVIOUS] = previous_of(batch, index);
    }
    one.option[VOR_OPTION_OUTPUT] = result->output;
    if (result->replace)
        one.option[VOR_OPTION_FORCE] = "";
    if (one.option[VOR_OPTION_JSON] != NULL) { /* says whose lines follow */
        vor_text_init(&text, 0);
        vor_json_begin_object(&text);
        vor_json_put_string(&text, "input", result->input);
        vor_json_put_string(&text, "output", result->output);
        vor_json_end_object(&text);
        if (!text.failed)
            (void)puts(text.data);
        (void)fflush(stdout);
        vor_text_free(&text);
    }
    code = batch->run(&one);
    result->is_done = code == VOR_EXIT_OK;
    if (code == VOR_EXIT_OK && !is_quiet)
        vor_cli_say(result->output, "written");
    return code;
}

int vor_cli_batch(const struct vor_cli *cli, int (*run)(const struct vor_cli *cli))
{
    struct batch batch = {.cli = cli,
                          .results = calloc((size_t)cli->operand_count, sizeof *batch.results),
                          .run = run};
    struct vor_error err;
    vor_status status;
    int code;

    if (batch.results == NULL) {
        (void)vor_fail(&err, VOR_E_NOMEM, "%d results", cli->operand_count);
        return vor_cli_fail(cli->command->name, &err);
    }
    status = name_results(batch.results, cli, &err);
    VOR_THEN(status, check_names(batch.results, cli->operand_count, &err));
    /* What may not be written is told before any work; what may is not asked about again. */
    for (int i = 0; i < cli->operand_count && status == VOR_OK; i++) {
        struct result *result = &batch.results[i];
        struct vor_error why;

        if (vor_overwrite_check(cli, result->output, &result->replace, &why) != VOR_OK)
            status = vor_fail(&err, why.status, "%.300s: %.300s", result->output, why.message);
    }
    VOR_THEN(status, vor_folder_make(cli->option[VOR_OPTION_OUTPUT], &err));
    if (status == VOR_OK && (cli->command->does & VOR_COMMAND_FRAMES) != 0 &&
        cli->option[VOR_OPTION_SERVER] == NULL)
        status = vor_sequence_common(&batch.common, cli, &err);
    code = status == VOR_OK ? vor_cli_each(cli, run_one, &batch)
                            : vor_cli_fail(cli->command->name, &err);
    for (int i = 0; i < cli->operand_count; i++)
        free(batch.results[i].output);
    free(batch.results);
    return code;
}
