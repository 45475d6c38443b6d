#include "server/cli/health.h"

#include "server/cli/cli_log.h"
#include "server/cli/remote.h"
#include "server/cli/server.h"

#define HEALTH_SECONDS 5

static int report(const char *server, const struct vor_remote_call *call)
{
    struct vor_json *json;
    struct vor_text line;
    const char *detail;

    if (call->http == 200) {
        printf("%s: ready\n", server);
        return fflush(stdout) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
    }
    json = vor_remote_json(call);
    detail = vor_json_get_string(vor_json_get(json, "detail"));
    vor_text_init(&line, 0);
    vor_text_printf(&line, "not ready: the server responded with %d%s%s", call->http,
                    detail != NULL ? ": " : "", detail != NULL ? detail : "");
    vor_cli_say(server, line.data != NULL ? line.data : "not ready");
    vor_text_free(&line);
    vor_json_free(json);
    return VOR_EXIT_UNREACHABLE;
}

int vor_cli_health(const struct vor_cli *cli)
{
    char server[VOR_REMOTE_URL_MAX], url[VOR_REMOTE_URL_MAX + 16];
    struct vor_remote_call call = {.method = "GET", .url = url, .timeout_seconds = HEALTH_SECONDS};
    struct vor_remote *remote = NULL;
    struct vor_error err;
    int code;

    if (vor_cli_health_server(server, cli, &err) != VOR_OK)
        return vor_cli_fail(cli->command->name, &err);
    (void)snprintf(url, sizeof url, "%s/readyz", server);
    if (vor_remote_open(&remote, &err) != VOR_OK)
        return vor_cli_fail(NULL, &err);
    if (vor_remote_perform(remote, &call, &err) == VOR_OK) {
        code = report(server, &call);
    } else if (err.status == VOR_E_CANCELLED) {
        code = vor_cli_fail(server, &err);
    } else {
        vor_cli_say(server, err.message);
        code = VOR_EXIT_UNREACHABLE;
    }
    vor_text_free(&call.text);
    vor_remote_close(remote);
    return code;
}
