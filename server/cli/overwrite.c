#include "server/cli/overwrite.h"

#include "server/cli/cli_log.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int is_same(const struct stat *output, const char *input)
{
    struct stat info;

    return (strcmp(input, "-") == 0 ? fstat(STDIN_FILENO, &info) : stat(input, &info)) == 0 &&
           info.st_dev == output->st_dev && info.st_ino == output->st_ino;
}

/* The input that the output is; NULL if it is none. */
static const char *find_input(const struct vor_cli *cli, const struct stat *output)
{
    if (cli->command->process == NULL)
        return NULL;
    for (int i = 0; i < cli->operand_count; i++)
        if (is_same(output, cli->operands[i]))
            return cli->operands[i];
    for (int i = 0; i < VOR_INPUTS_MAX; i++)
        if (cli->input[i] != NULL && is_same(output, cli->input[i]))
            return cli->input[i];
    return NULL;
}

static int reads_stdin(const struct vor_cli *cli)
{
    for (int i = 0; i < VOR_INPUTS_MAX; i++)
        if (cli->input[i] != NULL && strcmp(cli->input[i], "-") == 0)
            return 1;
    return 0;
}

/* Whether --force is not needed: the user says yes at the terminal. */
static int is_allowed(const struct vor_cli *cli, const char *path)
{
    char answer[16];

    if (reads_stdin(cli) || !isatty(STDIN_FILENO) || !isatty(STDERR_FILENO))
        return 0;
    vor_cli_ask(path, "the file exists. Overwrite it? [y/N] ");
    if (fgets(answer, sizeof answer, stdin) != NULL)
        return answer[0] == 'y' || answer[0] == 'Y';
    fputc('\n', stderr);
    return 0;
}

vor_status vor_overwrite_check(const struct vor_cli *cli, const char *path, int *replace,
                               struct vor_error *err)
{
    int is_stdout = strcmp(path, "-") == 0;
    struct stat output;
    const char *input;

    *replace = 0;
    if ((is_stdout ? fstat(STDOUT_FILENO, &output) : stat(path, &output)) != 0 ||
        !S_ISREG(output.st_mode))
        return VOR_OK;
    input = find_input(cli, &output);
    if (input != NULL)
        return vor_fail(err, VOR_E_PARAM,
                        "the output is the input %.300s itself: give another "
                        "output",
                        strcmp(input, "-") == 0 ? "on stdin" : input);
    if (is_stdout)
        return VOR_OK;
    *replace = cli->option[VOR_OPTION_FORCE] != NULL || is_allowed(cli, path);
    return *replace ? VOR_OK
                    : vor_fail(err, VOR_E_PARAM,
                               "the file exists: use --force (-f) to "
                               "overwrite it");
}
