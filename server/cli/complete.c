/* A script is fixed text around two tables: which options a command takes, and what may follow
 * each. */
#include "server/cli/complete.h"

#include "server/cli/cli.h"
#include "server/cli/complete_words.h"
#include "server/cli/say.h"

#include <string.h>

/* Where a line for an option goes, and whose option it is. */
struct script {
    FILE *out;
    const char *command;
};

/* Calls visit for every command with options: serve, the others, submit with each process. */
static void each_command(struct script *script,
                         void (*visit)(struct script *script, const struct vor_command *command))
{
    const struct vor_process_info *process;
    struct vor_command command;
    char name[64];

    script->command = "serve";
    visit(script, NULL);
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

static void each_option(struct script *script, const struct vor_command *command,
                        void (*visit)(void *ctx, const struct vor_completion *option))
{
    if (command == NULL)
        vor_complete_serve(visit, script);
    else
        vor_complete_command(command, visit, script);
}

static void print_names(FILE *out)
{
    struct vor_command command;

    fputs("serve", out);
    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++)
        fprintf(out, " %s", command.name);
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

static void bash_name(void *ctx, const struct vor_completion *option)
{
    const struct script *script = ctx;

    if (option->letter != 0)
        fprintf(script->out, " -%c", option->letter);
    fprintf(script->out, " --%s", option->name);
}

static void bash_names(struct script *script, const struct vor_command *command)
{
    fprintf(script->out, "    \"%s\") echo \"", script->command);
    each_option(script, command, bash_name);
    fputs("\" ;;\n", script->out);
}

static void bash_value(void *ctx, const struct vor_completion *option)
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
    each_option(script, command, bash_value);
}

/* bash takes --name=value apart at the sign, which is then a word of its own. Of a list, what
 * stands before the last comma stays. */
static const char bash_head[] =
    "# Completion of voronoid for bash, made by voronoid --completion bash.\n"
    "# shellcheck shell=bash disable=SC2207\n";

static const char bash_body[] =
    "_voronoid_reply()\n"
    "{\n"
    "    local IFS=$'\\n'\n"
    "    COMPREPLY=($(compgen \"$@\"))\n"
    "}\n"
    "\n"
    "_voronoid_operand()\n"
    "{\n"
    "    case $1 in\n"
    "    wait | fetch | cancel | stop | jobs)\n"
    "        _voronoid_reply -W \"$(timeout 2 \"${COMP_WORDS[0]}\" jobs -q 2>/dev/null)\" -- "
    "\"$2\" ;;\n"
    "    health | serve | submit) ;;\n"
    "    help) _voronoid_reply -W \"${_voronoid_commands// /$'\\n'}\" -- \"$2\" ;;\n"
    "    *)\n"
    "        compopt -o filenames 2>/dev/null\n"
    "        _voronoid_reply -f -- \"$2\" ;;\n"
    "    esac\n"
    "}\n"
    "\n"
    "# COMMAND OPTION WORD SIGN: what may follow the option; SIGN is 1 behind a =.\n"
    "_voronoid_follow()\n"
    "{\n"
    "    local kind words\n"
    "    read -r kind words <<<\"$(_voronoid_values \"$1 $2\")\"\n"
    "    words=${words// /$'\\n'}\n"
    "    case $kind in\n"
    "    @file | @folder)\n"
    "        compopt -o filenames 2>/dev/null\n"
    "        if [ \"$kind\" = @file ]; then _voronoid_reply -f -- \"$3\"; else _voronoid_reply -d "
    "-- "
    "\"$3\"; fi ;;\n"
    "    @word) _voronoid_reply -W \"$words\" -- \"$3\" ;;\n"
    "    @list)\n"
    "        local before=''\n"
    "        [[ $3 != *,* ]] || before=${3%,*},\n"
    "        _voronoid_reply -P \"$before\" -W \"$words\" -- \"${3##*,}\" ;;\n"
    "    @flag)\n"
    "        [ \"$4\" = 1 ] || return 1\n"
    "        _voronoid_reply -W \"$words\" -- \"$3\" ;;\n"
    "    @any) ;;\n"
    "    *) return 1 ;;\n"
    "    esac\n"
    "}\n"
    "\n"
    "_voronoid()\n"
    "{\n"
    "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} sign=0\n"
    "    local command=${COMP_WORDS[1]}\n"
    "    COMPREPLY=()\n"
    "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
    "        _voronoid_reply -W \"${_voronoid_commands// "
    "/$'\\n'}\"$'\\nhelp\\n--help\\n--version\\n"
    "--completion\\n--man' -- \"$word\"\n"
    "        return\n"
    "    fi\n"
    "    case $command in\n"
    "    --completion) _voronoid_reply -W $'bash\\nzsh\\nfish' -- \"$word\"; return ;;\n"
    "    --man) _voronoid_reply -W $'1\\n8' -- \"$word\"; return ;;\n"
    "    submit)\n"
    "        if [ \"$COMP_CWORD\" -eq 2 ]; then\n"
    "            _voronoid_reply -W \"${_voronoid_processes// /$'\\n'}\" -- \"$word\"\n"
    "            return\n"
    "        fi\n"
    "        command=\"submit ${COMP_WORDS[2]}\" ;;\n"
    "    esac\n"
    "    if [ \"$word\" = = ]; then\n"
    "        word='' sign=1\n"
    "    elif [ \"$before\" = = ]; then\n"
    "        before=${COMP_WORDS[COMP_CWORD - 2]} sign=1\n"
    "    fi\n"
    "    if _voronoid_follow \"$command\" \"$before\" \"$word\" \"$sign\"; then\n"
    "        return\n"
    "    elif [[ $word == -* ]]; then\n"
    "        local names\n"
    "        names=$(_voronoid_names \"$command\")\n"
    "        _voronoid_reply -W \"${names// /$'\\n'}\" -- \"$word\"\n"
    "    else\n"
    "        _voronoid_operand \"$command\" \"$word\"\n"
    "    fi\n"
    "}\n"
    "\n"
    "complete -F _voronoid voronoid\n";

static void print_bash(FILE *out)
{
    struct script script = {out, NULL};

    fputs(bash_head, out);
    fputs("_voronoid_commands=\"", out);
    print_names(out);
    fputs("\"\n_voronoid_processes=\"", out);
    print_submittable(out);
    fputs("\"\n\n_voronoid_names()\n{\n    case $1 in\n", out);
    each_command(&script, bash_names);
    fputs("    esac\n}\n\n_voronoid_values()\n{\n    case $1 in\n", out);
    each_command(&script, bash_values);
    fputs("    esac\n}\n\n", out);
    fputs(bash_body, out);
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
static void zsh_action(FILE *out, const struct vor_completion *option)
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

static void zsh_spec(void *ctx, const struct vor_completion *option)
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
    each_option(script, command, zsh_spec);
    if (command == NULL || command->operands[0] == '\0')
        operand = "";
    else if ((command->does & VOR_COMMAND_JOBS) != 0)
        operand = "'*:JOB:_voronoid_jobs'";
    else if ((command->does & VOR_COMMAND_KEYS) != 0)
        operand = "'1:NAME: '";
    fprintf(script->out, "      %s\n    ;;\n", operand);
}

static void zsh_names(FILE *out)
{
    struct vor_command command;

    fputs("  commands=(\n    'serve:Run the daemon'\n", out);
    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        fprintf(out, "    '%s:", command.name);
        zsh_text(out, command.title);
        fputs("'\n", out);
    }
    fputs("    'help:Explain a command'\n  )\n", out);
}

static void print_zsh(FILE *out)
{
    struct script script = {out, NULL};

    fputs("#compdef voronoid\n"
          "# Completion of voronoid for zsh, made by voronoid --completion zsh.\n"
          "\n"
          "_voronoid_jobs() {\n"
          "  local -a jobs\n"
          "  jobs=(${(f)\"$(timeout 2 voronoid jobs -q 2>/dev/null)\"})\n"
          "  compadd -a jobs\n"
          "}\n"
          "\n"
          "_voronoid() {\n"
          "  local -a commands\n"
          "  local command\n",
          out);
    zsh_names(out);
    fputs("  if (( CURRENT == 2 )); then\n"
          "    _describe -t commands command commands\n"
          "    return\n"
          "  fi\n"
          "  command=$words[2]\n"
          "  shift words\n"
          "  (( CURRENT-- ))\n"
          "  if [[ $command == submit ]]; then\n"
          "    if (( CURRENT == 2 )); then\n"
          "      compadd ",
          out);
    print_submittable(out);
    fputs("\n      return\n"
          "    fi\n"
          "    command=\"submit $words[2]\"\n"
          "    shift words\n"
          "    (( CURRENT-- ))\n"
          "  fi\n"
          "  case $command in\n",
          out);
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

static void fish_option(void *ctx, const struct vor_completion *option)
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

    each_option(script, command, fish_option);
    if (command == NULL)
        return;
    if ((command->does & VOR_COMMAND_JOBS) != 0)
        fprintf(out, "complete -c voronoid -n '__voronoid_is %s' -a '(__voronoid_jobs)'\n",
                script->command);
    else if (command->process != NULL)
        fprintf(out, "complete -c voronoid -n '__voronoid_is %s' -F\n", script->command);
}

static void fish_name(FILE *out, const char *name, const char *title)
{
    fprintf(out, "complete -c voronoid -n '__voronoid_is' -a %s -d ", name);
    fish_text(out, title);
    fputc('\n', out);
}

static const char fish_head[] =
    "# Completion of voronoid for fish, made by voronoid --completion fish.\n"
    "\n"
    "# Whether the words before the cursor are those of a command; of none without one.\n"
    "function __voronoid_is\n"
    "    set -l words (commandline -opc)\n"
    "    set -e words[1]\n"
    "    set -q words[1]; or return (count $argv)\n"
    "    set -q argv[1]; or return 1\n"
    "    test \"$words[1]\" = submit; and set -q words[2]; or set words $words[1]\n"
    "    test \"$words[1..2]\" = \"$argv\"\n"
    "end\n"
    "\n"
    "# What stands before the last comma of a list stays.\n"
    "function __voronoid_list\n"
    "    set -l word (commandline -ct | string replace -r '^--[^=]*=' '')\n"
    "    printf '%s\\n' (string replace -r '[^,]*$' '' -- $word)$argv\n"
    "end\n"
    "\n"
    "function __voronoid_jobs\n"
    "    set -l words (commandline -opc)\n"
    "    timeout 2 $words[1] jobs -q 2>/dev/null\n"
    "end\n"
    "\n"
    "complete -c voronoid -f\n";

static void print_fish(FILE *out)
{
    struct script script = {out, NULL};
    struct vor_command command;

    fputs(fish_head, out);
    fish_name(out, "serve", "Run the daemon");
    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++)
        fish_name(out, command.name, command.title);
    fish_name(out, "help", "Explain a command or a topic");
    fputs("complete -c voronoid -n '__voronoid_is' -l help -d 'List the commands'\n"
          "complete -c voronoid -n '__voronoid_is' -l version -d 'Print the version'\n"
          "complete -c voronoid -n '__voronoid_is' -l completion -x -a 'bash zsh fish'\n"
          "complete -c voronoid -n '__voronoid_is' -l man -x -a '1 8'\n"
          "complete -c voronoid -n '__voronoid_is submit' -a '",
          out);
    print_submittable(out);
    fputs("'\ncomplete -c voronoid -n '__voronoid_is help' -a '", out);
    print_names(out);
    fputs("'\n", out);
    each_command(&script, fish_command);
}

int vor_cli_complete(FILE *out, const char *shell)
{
    if (strcmp(shell, "bash") == 0) {
        print_bash(out);
    } else if (strcmp(shell, "zsh") == 0) {
        print_zsh(out);
    } else if (strcmp(shell, "fish") == 0) {
        print_fish(out);
    } else {
        vor_cli_say("--completion", "want bash, zsh or fish");
        return VOR_EXIT_USAGE;
    }
    return fflush(out) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
}
