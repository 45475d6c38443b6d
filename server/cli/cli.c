#include "server/cli/cli.h"

#include "core/base/nearest.h"
#include "server/base/topics.h"
#include "server/cli/cli_log.h"
#include "server/cli/commands.h"
#include "server/cli/help.h"
#include "server/cli/interrupt.h"
#include "server/cli/options.h"

#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#define FILES " IN..."

enum { ASKS_JOBS = VOR_COMMAND_ASKS | VOR_COMMAND_JOBS };

static int no_process(const struct vor_cli *cli);
static int run_process(const struct vor_cli *cli);

/* The commands that are no process. */
static const struct vor_command others[] = {
    {"serve", "Run the daemon", "Runs the daemon. Its manual page is voronoid(8)",
     VOR_COMMAND_SERVES, "", 0, 0, NULL, NULL},
    {"submit", "Send clouds to a daemon",
     "Sends each cloud to a daemon and prints the ID of its job",
     VOR_COMMAND_ASKS | VOR_COMMAND_SUBMITS, " PROCESS" FILES, 0, INT_MAX, NULL, no_process},
    {"jobs", "List a daemon's jobs",
     "Lists jobs with their status, progress, age and name, newest first",
     ASKS_JOBS | VOR_COMMAND_LISTS, " [JOB]...", 0, INT_MAX, NULL, vor_cli_jobs},
    {"wait", "Wait for jobs",
     "Shows the progress of jobs until they end, and exits with 0 if all succeeded", ASKS_JOBS,
     " JOB...", 1, INT_MAX, NULL, vor_cli_wait},
    {"fetch", "Fetch results of jobs", "Writes results of jobs into files",
     ASKS_JOBS | VOR_COMMAND_FETCHES, " JOB...", 1, INT_MAX, NULL, vor_cli_fetch},
    {"cancel", "Cancel jobs", "Cancels waiting and running jobs, which then have no result",
     ASKS_JOBS, " JOB...", 1, INT_MAX, NULL, vor_cli_cancel},
    {"stop", "Stop jobs and keep their best results",
     "Stops running jobs. The result of each job is its best cloud so far", ASKS_JOBS, " JOB...", 1,
     INT_MAX, NULL, vor_cli_stop},
    {"health", "Check whether a daemon is ready", "Checks whether a daemon is ready to accept jobs",
     VOR_COMMAND_ASKS, "", 0, 0, NULL, vor_cli_health},
    {"key", "Make a key for a daemon",
     "Prints a new key on stderr and, on stdout, the line to add to the file of voronoid serve "
     "--api-keys. The key cannot be shown again",
     VOR_COMMAND_KEYS, " NAME", 1, 1, NULL, vor_cli_key},
    {"migrate", "Move a daemon's jobs to PostgreSQL and S3",
     "Copies the jobs and files in a data folder, DATA, into another database and another place "
     "for "
     "files. No daemon may use them meanwhile. DATA stays as it is. A copy that was broken off "
     "continues when the command is started again",
     VOR_COMMAND_MOVES, " DATA", 1, 1, NULL, vor_cli_migrate},
    {"sequence", "Resample the frames of a sequence",
     "Resamples each cloud starting from the result for the one before: points move little from "
     "frame to frame and keep their number, in the attribute track. Frames are taken in the order "
     "given, and each result is written before the next one is computed. If a frame fails, the "
     "next starts from the last result. Default for the number of points: as many as each frame "
     "has. Attributes that not all frames have are left out; with --server, those that the result "
     "before does not have",
     VOR_COMMAND_RUNS | VOR_COMMAND_REMOTE | VOR_COMMAND_FRAMES, FILES, 1, INT_MAX, NULL,
     run_process},
};

enum { OTHERS = sizeof others / sizeof others[0], SERVE = 0, SUBMIT };

static struct vor_command other(unsigned index)
{
    struct vor_command command = others[index];

    if ((command.does & VOR_COMMAND_FRAMES) != 0)
        command.process = vor_process_find("resample");
    return command;
}

/* The command that a command line begins with. */
struct chosen {
    struct vor_command command;
    char name[64]; /* of two words */
    int words;
};

static int run_one(const struct vor_cli *cli)
{
    return cli->option[VOR_OPTION_SERVER] != NULL ? vor_cli_run_remote(cli)
                                                  : vor_cli_run_local(cli);
}

static int run_process(const struct vor_cli *cli)
{
    return vor_cli_into_folder(cli) ? vor_cli_batch(cli, run_one) : run_one(cli);
}

static int no_process(const struct vor_cli *cli)
{
    const struct vor_process_info *process;
    char line[512] = "write the name of a process after submit: ";

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++) {
        size_t at = strlen(line);

        if (process->on_http)
            (void)snprintf(line + at, sizeof line - at, "%s%s", i > 0 ? ", " : "", process->id);
    }
    vor_cli_say(cli->command->name, line);
    return VOR_EXIT_USAGE;
}

static struct vor_command command_of(const struct vor_process_info *process)
{
    unsigned does = VOR_COMMAND_RUNS | (process->on_http ? VOR_COMMAND_REMOTE : 0u);

    return (struct vor_command){process->id, process->title, process->sentence, does,       FILES,
                                1,           INT_MAX,        process,           run_process};
}

static void refuse_name(const char *name, int may_be_topic)
{
    static const char *const more[] = {"help", "version"};
    char meant[VOR_NEAREST_TEXT_SIZE], line[sizeof meant + 64];
    const struct vor_process_info *process;
    struct vor_nearest nearest;
    struct vor_topic topic;

    vor_nearest_init(&nearest, name, strlen(name));
    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        vor_nearest_try(&nearest, process->id, strlen(process->id));
    for (int i = 0; i < OTHERS; i++)
        vor_nearest_try(&nearest, others[i].name, strlen(others[i].name));
    for (size_t i = 0; i < sizeof more / sizeof more[0]; i++)
        vor_nearest_try(&nearest, more[i], strlen(more[i]));
    for (unsigned i = 0; may_be_topic && vor_topic_at(&topic, i); i++)
        vor_nearest_try(&nearest, topic.name, strlen(topic.name));
    (void)snprintf(line, sizeof line, "no such command%s%s", may_be_topic ? " or topic" : "",
                   nearest.count > 0 ? vor_nearest_text(&nearest, "", meant)
                                     : "; see voronoid --help");
    vor_cli_say(name, line);
}

/* The command of that name, and of the next word where that belongs to it; false when there is
 * none. */
static int find(struct chosen *out, const char *name, const char *next)
{
    const struct vor_process_info *process = vor_process_find(name);
    const struct vor_process_info *submitted = vor_process_find(next != NULL ? next : "");

    out->words = 1;
    if (process != NULL) {
        out->command = command_of(process);
        return 1;
    }
    if (strcmp(name, others[SUBMIT].name) == 0 && submitted != NULL && submitted->on_http) {
        /* Its parameters are those of the process. */
        out->command = others[SUBMIT];
        (void)snprintf(out->name, sizeof out->name, "submit %s", submitted->id);
        out->command.name = out->name;
        out->command.operands = FILES;
        out->command.process = submitted;
        out->command.run = vor_cli_submit;
        out->words = 2;
        return 1;
    }
    for (int i = 0; i < OTHERS; i++)
        if (strcmp(others[i].name, name) == 0) {
            out->command = other((unsigned)i);
            return 1;
        }
    return 0;
}

static int printed(FILE *out)
{
    return fflush(out) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
}

int vor_cli_main(int argc, char **argv)
{
    struct vor_error err = {.status = VOR_OK};
    struct chosen chosen;
    struct vor_cli cli = {.command = &chosen.command};
    int skipped;

    if (!find(&chosen, argv[0], argc > 1 ? argv[1] : NULL)) {
        refuse_name(argv[0], 0);
        return VOR_EXIT_USAGE;
    }
    skipped = chosen.words - 1;
    if (vor_cli_read(&cli, &chosen.command, argc - skipped, argv + skipped, &err) != VOR_OK)
        return vor_cli_fail(chosen.command.name, &err);
    if (cli.option[VOR_OPTION_HELP] != NULL) {
        vor_help_command(stdout, &chosen.command);
        return printed(stdout);
    }
    /* A reader that left shows as an error of the write, not as our sudden death. */
    (void)signal(SIGPIPE, SIG_IGN);
    vor_interrupt_catch();
    return chosen.command.run(&cli);
}

int vor_cli_help(FILE *out, const char *name)
{
    struct chosen chosen;

    if (!find(&chosen, name, NULL)) {
        refuse_name(name, 1);
        return VOR_EXIT_USAGE;
    }
    vor_help_command(out, &chosen.command);
    return printed(out);
}

const struct vor_command *vor_cli_command(struct vor_command *out, unsigned index)
{
    const struct vor_process_info *process;
    unsigned i = 0;

    if (index == 0) {
        *out = others[SERVE];
        return out;
    }
    for (; (process = vor_process_info(i)) != NULL; i++)
        if (i + 1 == index) {
            *out = command_of(process);
            return out;
        }
    if (index - i >= OTHERS)
        return NULL;
    *out = other(index - i);
    return out;
}
