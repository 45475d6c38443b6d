/* A completion is a script of its shell, docker/pages/voronoid.*, and behind it what it asks for:
 * which options a command takes, and what may follow each. */
#include "docker/pages/options.h"
#include "docker/pages/pages.h"
#include "server/cli/cli.h"

#include <string.h>

/* Where a line for an option goes, and whose option it is. */
struct script {
    FILE *out;
    const char *command;
};

/* Calls visit for every command with options, and for submit with each process. */
static void each_command(struct script *script,
                         void (*visit)(struct script *script, const struct vor_command *command))
{
    const struct vor_process_info *process;
    struct vor_command command;
    char name[64];

    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        script->command = command.name;
        visit(script, &command);
        if ((command.does & VOR_COMMAND_SUBMITS) == 0)
            continue;
        for (unsigned k = 0; (process = vor_process_info(k)) != NULL; k++) {
            if (!process->on_http)
                continue;
            (void)snprintf(name, sizeof name, "%s %s", command.name, process->id);
            script->command = name;
            command.process = process;
            visit(script, &command);
        }
    }
}

static void print_names(FILE *out)
{
    struct vor_command command;

    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++)
        fprintf(out, "%s%s", i > 0 ? " " : "", command.name);
}

static void print_submittable(FILE *out)
{
    const struct vor_process_info *process;
    const char *before = "";

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++) {
        if (!process->on_http)
            continue;
        fprintf(out, "%s%s", before, process->id);
        before = " ";
    }
}

/* bash. */

static void bash_name(void *ctx, const struct vor_page_option *option)
{
    const struct script *script = ctx;

    if (option->letter != 0)
        fprintf(script->out, " -%c", option->letter);
    fprintf(script->out, " --%s", option->name);
}

static void bash_names(struct script *script, const struct vor_command *command)
{
    fprintf(script->out, "    \"%s\") echo \"", script->command);
    vor_page_command(command, bash_name, script);
    fputs("\" ;;\n", script->out);
}

static void bash_value(void *ctx, const struct vor_page_option *option)
{
    static const char *const kinds[] = {
        [VOR_VALUE_NONE] = "",      [VOR_VALUE_FLAG] = "@flag",     [VOR_VALUE_ANY] = "@any",
        [VOR_VALUE_FILE] = "@file", [VOR_VALUE_FOLDER] = "@folder", [VOR_VALUE_WORD] = "@word",
        [VOR_VALUE_LIST] = "@list",
    };
    const struct script *script = ctx;

    if (option->kind == VOR_VALUE_NONE)
        return;
    fprintf(script->out, "    \"%s --%s\"", script->command, option->name);
    if (option->letter != 0)
        fprintf(script->out, " | \"%s -%c\"", script->command, option->letter);
    fprintf(script->out, ") echo \"%s%s%s\" ;;\n", kinds[option->kind],
            option->words[0] != '\0' ? " " : "", option->words);
}

static void bash_values(struct script *script, const struct vor_command *command)
{
    vor_page_command(command, bash_value, script);
}

static void print_bash(FILE *out)
{
    struct script script = {out, NULL};

    fputs("\n_voronoid_commands=\"", out);
    print_names(out);
    fputs("\"\n_voronoid_processes=\"", out);
    print_submittable(out);
    fputs("\"\n\n_voronoid_names()\n{\n    case $1 in\n", out);
    each_command(&script, bash_names);
    fputs("    esac\n}\n\n_voronoid_values()\n{\n    case $1 in\n", out);
    each_command(&script, bash_values);
    fputs("    esac\n}\n", out);
}

/* zsh. */

/* Text between single quotes, within the brackets of a specification. */
static void zsh_text(FILE *out, const char *text)
{
    for (; *text != '\0'; text++) {
        if (*text == '\'')
            fputs("'\\''", out);
        else if (strchr("[]:\\", *text) != NULL)
            fprintf(out, "\\%c", *text);
        else
            fputc(*text, out);
    }
}

/* What stands behind the description: ":VALUE:" and how it is completed. */
static void zsh_action(FILE *out, const struct vor_page_option *option)
{
    fputc(':', out);
    zsh_text(out, option->value);
    fputc(':', out);
    switch (option->kind) {
    case VOR_VALUE_FILE:
        fputs("_files", out);
        break;
    case VOR_VALUE_FOLDER:
        fputs("_files -/", out);
        break;
    case VOR_VALUE_FLAG:
    case VOR_VALUE_WORD:
        fputc('(', out);
        zsh_text(out, option->words);
        fputc(')', out);
        break;
    case VOR_VALUE_LIST:
        fprintf(out, "_values -s , %s %s", option->name, option->words);
        break;
    case VOR_VALUE_NONE:
    case VOR_VALUE_ANY:
        break;
    }
}

static void zsh_spec(void *ctx, const struct vor_page_option *option)
{
    const struct script *script = ctx;
    int has_value = option->kind != VOR_VALUE_NONE;
    const char *sign = option->kind == VOR_VALUE_FLAG ? "=-" : has_value ? "=" : "";

    fputs("      ", script->out);
    if (option->letter != 0)
        fprintf(script->out, "'(-%c --%s)'{-%c%s,--%s%s}'[", option->letter, option->name,
                option->letter, has_value ? "+" : "", option->name, sign);
    else
        fprintf(script->out, "'--%s%s[", option->name, sign);
    zsh_text(script->out, option->sentence);
    fputc(']', script->out);
    if (option->kind == VOR_VALUE_FLAG)
        fputc(':', script->out); /* the value may be left out */
    if (has_value)
        zsh_action(script->out, option);
    fputs("' \\\n", script->out);
}

static void zsh_command(struct script *script, const struct vor_command *command)
{
    const char *operand = "'*:IN:_files'";

    fprintf(script->out, "  '%s')\n    _arguments -S \\\n", script->command);
    vor_page_command(command, zsh_spec, script);
    if (command->operands[0] == '\0')
        operand = "";
    else if ((command->does & VOR_COMMAND_JOBS) != 0)
        operand = "'*:JOB:_voronoid_jobs'";
    else if ((command->does & VOR_COMMAND_KEYS) != 0)
        operand = "'1:NAME: '";
    fprintf(script->out, "      %s\n    ;;\n", operand);
}

static void print_zsh(FILE *out)
{
    struct script script = {out, NULL};
    struct vor_command command;

    fputs("\n_voronoid_processes=(", out);
    print_submittable(out);
    fputs(")\n_voronoid_commands=(\n", out);
    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        fprintf(out, "    '%s:", command.name);
        zsh_text(out, command.title);
        fputs("'\n", out);
    }
    fputs(")\n\n_voronoid_options() {\n  case $1 in\n", out);
    each_command(&script, zsh_command);
    fputs("  esac\n}\n\n_voronoid \"$@\"\n", out);
}

/* fish. */

/* Text between single quotes: its first sentence, which is what fits beside a name. */
static void fish_text(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text != '\0' && strncmp(text, ". ", 2) != 0; text++)
        fprintf(out, *text == '\'' || *text == '\\' ? "\\%c" : "%c", *text);
    fputc('\'', out);
}

static void fish_option(void *ctx, const struct vor_page_option *option)
{
    const struct script *script = ctx;
    FILE *out = script->out;

    fprintf(out, "complete -c voronoid -n '__voronoid_is %s' -l %s", script->command, option->name);
    if (option->letter != 0)
        fprintf(out, " -s %c", option->letter);
    switch (option->kind) {
    case VOR_VALUE_NONE:
    case VOR_VALUE_FLAG: /* a value that may be left out is nothing that fish knows */
        break;
    case VOR_VALUE_ANY:
        fputs(" -x", out);
        break;
    case VOR_VALUE_FILE:
        fputs(" -r -F", out);
        break;
    case VOR_VALUE_FOLDER:
        fputs(" -x -a '(__fish_complete_directories)'", out);
        break;
    case VOR_VALUE_WORD:
        fprintf(out, " -x -a '%s'", option->words);
        break;
    case VOR_VALUE_LIST:
        fprintf(out, " -x -a '(__voronoid_list %s)'", option->words);
        break;
    }
    fputs(" -d ", out);
    fish_text(out, option->sentence);
    fputc('\n', out);
}

static void fish_command(struct script *script, const struct vor_command *command)
{
    FILE *out = script->out;

    vor_page_command(command, fish_option, script);
    if ((command->does & VOR_COMMAND_JOBS) != 0)
        fprintf(out, "complete -c voronoid -n '__voronoid_is %s' -a '(__voronoid_jobs)'\n",
                script->command);
    else if (command->process != NULL)
        fprintf(out, "complete -c voronoid -n '__voronoid_is %s' -F\n", script->command);
}

static void print_fish(FILE *out)
{
    struct script script = {out, NULL};
    struct vor_command command;

    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        fprintf(out, "complete -c voronoid -n '__voronoid_is' -a %s -d ", command.name);
        fish_text(out, command.title);
        fputc('\n', out);
    }
    fputs("complete -c voronoid -n '__voronoid_is submit' -a '", out);
    print_submittable(out);
    fputs("'\ncomplete -c voronoid -n '__voronoid_is help' -a '", out);
    print_names(out);
    fputs("'\n", out);
    each_command(&script, fish_command);
}

int vor_page_completion(FILE *out, const char *shell)
{
    if (strcmp(shell, "bash") == 0)
        print_bash(out);
    else if (strcmp(shell, "zsh") == 0)
        print_zsh(out);
    else if (strcmp(shell, "fish") == 0)
        print_fish(out);
    else
        return -1;
    return 0;
}
