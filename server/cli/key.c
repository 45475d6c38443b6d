#include "server/cli/commands.h"

#include "server/base/disk.h"
#include "server/cli/cli_log.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KEY_VARIABLE "VORONOID_KEY"
#define SCOPES_DEFAULT "submit,read"

int vor_cli_key(const struct vor_cli *cli)
{
    const char *scopes = cli->option[VOR_OPTION_SCOPES];
    char key[VOR_KEY_SIZE], line[VOR_KEY_LINE_SIZE];
    struct vor_error err;

    if (cli->operand_count == 0) {
        vor_cli_say(cli->command->name, "no name: give a name for the key");
        return VOR_EXIT_USAGE;
    }
    if (vor_key_make(cli->operands[0], scopes != NULL ? scopes : SCOPES_DEFAULT,
                     cli->option[VOR_OPTION_QUOTAS], key, line, &err) != VOR_OK)
        return vor_cli_fail(cli->command->name, &err);
    puts(line);
    if (fflush(stdout) != 0)
        return VOR_EXIT_FAILED;
    (void)fprintf(stderr, "%s\n", key);
    return VOR_EXIT_OK;
}

vor_status vor_cli_key_read(char out[VOR_KEY_SENT_MAX + 1], const struct vor_cli *cli,
                            struct vor_error *err)
{
    const char *path = cli->option[VOR_OPTION_API_KEY_FILE], *variable = getenv(KEY_VARIABLE);
    const char *from = path != NULL ? path : KEY_VARIABLE;
    char text[VOR_KEY_SENT_MAX + 3] = ""; /* with CR and LF */
    vor_status status = VOR_OK;

    out[0] = '\0';
    if (path != NULL) {
        FILE *file = fopen(path, "re");

        if (file == NULL)
            return vor_fail_errno(err, errno, path);
        if (fgets(text, sizeof text, file) == NULL)
            text[0] = '\0';
        if (ferror(file))
            status = vor_fail_errno(err, errno, path);
        (void)fclose(file);
    } else if (variable != NULL)
        (void)snprintf(text, sizeof text, "%s", variable);
    if (status != VOR_OK)
        return status;
    text[strcspn(text, "\r\n")] = '\0';
    for (const char *at = text; *at != '\0'; at++)
        if (*at <= ' ' || *at > '~' || at - text == VOR_KEY_SENT_MAX)
            return vor_fail(err, VOR_E_PARAM,
                            "%s has no valid key, want at most %d visible ASCII characters", from,
                            VOR_KEY_SENT_MAX);
    if (path != NULL && text[0] == '\0')
        return vor_fail(err, VOR_E_PARAM, "%s is empty, want a key on its first line", path);
    memcpy(out, text, strlen(text) + 1);
    return VOR_OK;
}
