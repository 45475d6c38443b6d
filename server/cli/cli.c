#include "server/cli/cli.h"

#include "server/cli/health.h"
#include "server/cli/help.h"
#include "server/cli/here.h"
#include "server/cli/interrupt.h"
#include "server/cli/options.h"
#include "server/cli/say.h"
#include "server/cli/there.h"

#include <signal.h>
#include <string.h>

/* The commands that run no process. */
static const struct vor_command others[] = {
    {"health", "Ask whether a daemon is ready", "Asks whether a daemon is ready to take jobs",
     VOR_COMMAND_ASKS, NULL, vor_cli_health},
};

enum { OTHERS = sizeof others / sizeof others[0] };

static int run_process(const struct vor_cli *cli)
{
    return cli->option[VOR_OPTION_SERVER] != NULL ? vor_cli_process_there(cli)
                                                  : vor_cli_process_here(cli);
}

/* The client sends one file, as the body; forms it does not make. */
static struct vor_command command_of(const struct vor_process_info *process)
{
    int is_remote = process->on_http && process->inputs[1].name == NULL;
    unsigned does = VOR_COMMAND_RUNS | (is_remote ? VOR_COMMAND_REMOTE : 0u);

    return (struct vor_command){process->id, process->title, process->sentence,
                                does,        process,        run_process};
}

/* The command of that name; false after it was said that there is none. */
static int find(struct vor_command *out, const char *name)
{
    const struct vor_process_info *process = vor_process_find(name);

    if (process != NULL) {
        *out = command_of(process);
        return 1;
    }
    for (int i = 0; i < OTHERS; i++)
        if (strcmp(others[i].name, name) == 0) {
            *out = others[i];
            return 1;
        }
    vor_cli_say(name, "no such command; see voronoid --help");
    return 0;
}

static int printed(FILE *out)
{
    return fflush(out) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
}

int vor_cli_main(int argc, char **argv)
{
    struct vor_error err = {.status = VOR_OK};
    struct vor_command command;
    struct vor_cli cli = {.command = &command};

    if (!find(&command, argv[0]))
        return VOR_EXIT_USAGE;
    if (vor_cli_read(&cli, &command, argc, argv, &err) != VOR_OK)
        return vor_cli_fail(command.name, &err);
    if (cli.option[VOR_OPTION_HELP] != NULL) {
        vor_help_command(stdout, &command);
        return printed(stdout);
    }
    /* A reader that left shows as an error of the write, not as our sudden death. */
    (void)signal(SIGPIPE, SIG_IGN);
    vor_interrupt_catch();
    return command.run(&cli);
}

int vor_cli_help(FILE *out, const char *name)
{
    struct vor_command command;

    if (!find(&command, name))
        return VOR_EXIT_USAGE;
    vor_help_command(out, &command);
    return printed(out);
}

void vor_cli_overview(FILE *out)
{
    const struct vor_process_info *process;

    vor_help_begin(out);
    vor_help_line(out, "serve", "Run the daemon");
    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        vor_help_line(out, process->id, process->title);
    for (int i = 0; i < OTHERS; i++)
        vor_help_line(out, others[i].name, others[i].title);
    vor_help_end(out);
}
