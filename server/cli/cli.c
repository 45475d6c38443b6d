#include "server/cli/cli.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static atomic_int caught; /* the first signal; lock-free, so that a handler may set it */

static void on_signal(int signal)
{
    int none = 0;

    (void)atomic_compare_exchange_strong(&caught, &none, signal);
}

void vor_interrupt_catch(void)
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    sigemptyset(&action.sa_mask);
    action.sa_handler = on_signal;
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
}

int vor_interrupt_seen(void)
{
    return atomic_load_explicit(&caught, memory_order_relaxed);
}

vor_status vor_interrupt_fail(struct vor_error *err)
{
    return vor_fail(err, VOR_E_CANCELLED, "cancelled");
}

int vor_interrupt_exit_code(void)
{
    return vor_interrupt_seen() == SIGINT ? VOR_EXIT_INTERRUPTED : VOR_EXIT_CANCELLED;
}

/* Control characters would break the line, or the terminal. */
static void print_line(const char *text)
{
    for (; *text != '\0'; text++) {
        unsigned char c = (unsigned char)*text;

        fputc(c < 0x20 || c == 0x7f ? '?' : c, stderr);
    }
}

void vor_cli_say(const char *subject, const char *message)
{
    fputs("voronoid: ", stderr);
    if (subject != NULL) {
        print_line(subject);
        fputs(": ", stderr);
    }
    print_line(message);
    fputc('\n', stderr);
}

int vor_cli_exit_code(int http, const char *type)
{
    const char *slug = type != NULL ? strrchr(type, '/') : NULL;

    slug = slug != NULL ? slug + 1 : type != NULL ? type : "";
    if (strcmp(slug, "invalid-parameter") == 0 ||
        strcmp(slug, "invalid-query-parameter-value") == 0)
        return VOR_EXIT_USAGE;
    switch (http) {
    case 200:
        return VOR_EXIT_OK;
    case 400:
    case 413:
    case 415:
    case 422:
        return VOR_EXIT_REJECTED;
    case 429:
    case 503:
        return VOR_EXIT_UNREACHABLE;
    case 499:
        return VOR_EXIT_CANCELLED;
    default:
        return VOR_EXIT_FAILED;
    }
}

int vor_cli_fail(const char *subject, const struct vor_error *err)
{
    if (err->status == VOR_E_CANCELLED) {
        vor_cli_say(subject, vor_interrupt_seen() ? "cancelled" : err->message);
        return vor_interrupt_exit_code();
    }
    vor_cli_say(subject, err->message);
    return vor_cli_exit_code(vor_status_http(err->status), vor_status_slug(err->status));
}

static int run(const struct vor_cli *cli)
{
    switch (cli->command) {
    case VOR_COMMAND_MEASURE:
        return vor_cli_measure(cli);
    case VOR_COMMAND_HEALTH:
        return vor_cli_health(cli);
    default:
        return cli->option[VOR_OPTION_SERVER] != NULL ? vor_cli_process_there(cli)
                                                      : vor_cli_process_here(cli);
    }
}

int vor_cli_main(int argc, char **argv)
{
    enum vor_command command = vor_cli_find(argv[0]);
    struct vor_cli cli = {.command = command};
    struct vor_error err = {.status = VOR_OK};

    if (command == VOR_COMMAND_COUNT) {
        vor_cli_say(argv[0], "no such command; see voronoid --help");
        return VOR_EXIT_USAGE;
    }
    if (vor_cli_read(&cli, command, argc, argv, &err) != VOR_OK)
        return vor_cli_fail(argv[0], &err);
    if (cli.option[VOR_OPTION_HELP] != NULL) {
        vor_cli_help(stdout, command);
        return fflush(stdout) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
    }
    /* A reader that left shows as an error of the write, not as our sudden death. */
    (void)signal(SIGPIPE, SIG_IGN);
    vor_interrupt_catch();
    return run(&cli);
}
