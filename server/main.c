#include "server/cli/cli.h"
#include "server/cli/cli_log.h"
#include "server/cli/help.h"
#include "server/serve.h"

#include <stdio.h>
#include <string.h>

static int is(const char *word, const char *a, const char *b)
{
    return strcmp(word, a) == 0 || strcmp(word, b) == 0;
}

static int help(const char *command)
{
    if (command == NULL || strcmp(command, "help") == 0) {
        vor_help_overview(stdout, vor_cli_command);
    } else {
        int code = vor_cli_topic(stdout, command);

        return code >= 0 ? code : vor_cli_help(stdout, command);
    }
    return fflush(stdout) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
}

static int wants_help(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (is(argv[i], "--help", "-h"))
            return 1;
    return 0;
}

int main(int argc, char **argv)
{
    const char *word = argc > 1 ? argv[1] : NULL;

    if (word == NULL) {
        vor_help_brief(stderr);
        return VOR_EXIT_USAGE;
    }
    if (is(word, "--help", "-h") || strcmp(word, "help") == 0)
        return help(argc > 2 ? argv[2] : NULL);
    if (is(word, "--version", "version") || strcmp(word, "-V") == 0) {
        printf("voronoid %s\n", VOR_VERSION);
        return fflush(stdout) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
    }
    if (is(word, "--completion", "--man"))
        return vor_cli_page(stdout, word, argc > 2 ? argv[2] : "");
    if (strcmp(word, "serve") != 0)
        return vor_cli_main(argc - 1, argv + 1);
    return wants_help(argc - 1, argv + 1) ? help(word) : vor_serve_main(argc - 1, argv + 1);
}
