
#include "server/base/option.h"
#include "server/cli/cli_log.h"
#include "server/cli/commands.h"
#include "server/cli/remote.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LISTEN_VARIABLE "VORONOID_LISTEN"
#define ADMIN_VARIABLE "VORONOID_ADMIN_LISTEN"
#define LISTEN_DEFAULT "127.0.0.1:8080"
#define PORT_MAX 65535
#define HEALTH_SECONDS 5

/* Room for what a command appends to the URL: a path, and a query of one parameter. */
enum { PATH_ROOM = 256 };

static int is(const char *text, size_t length, const char *word)
{
    return strlen(word) == length && memcmp(text, word, length) == 0;
}

/* A Unix socket, as --listen has it: the URL's host is that of the Host header alone. */
static vor_status from_socket(char out[VOR_REMOTE_URL_MAX], const char *text, struct vor_error *err)
{
    static const char host[] = "http://localhost";

    memcpy(out, host, sizeof host);
    return vor_remote_use_socket(text + 5, err);
}

/* "HOST:PORT" or "unix:PATH" of a setting as the URL to ask. */
static vor_status from_setting(char out[VOR_REMOTE_URL_MAX], const char *variable,
                               const char *listen, struct vor_error *err)
{
    const char *colon = strrchr(listen, ':');
    size_t host = colon != NULL ? (size_t)(colon - listen) : 0;
    unsigned port;

    if (strncmp(listen, "unix:", 5) == 0)
        return from_socket(out, listen, err);
    if (host == 0 || host > PATH_ROOM || !vor_whole_read(&port, colon + 1, 1, PORT_MAX))
        return vor_fail(
            err, VOR_E_PARAM,
            "%s is \"%.80s\", want HOST:PORT with a port from 1 to %d, or give --server "
            "URL",
            variable, listen, PORT_MAX);
    if (is(listen, host, "0.0.0.0"))
        (void)snprintf(out, VOR_REMOTE_URL_MAX, "http://127.0.0.1:%u", port);
    else if (is(listen, host, "[::]"))
        (void)snprintf(out, VOR_REMOTE_URL_MAX, "http://[::1]:%u", port);
    else
        (void)snprintf(out, VOR_REMOTE_URL_MAX, "http://%.*s:%u", (int)host, listen, port);
    return VOR_OK;
}

vor_status vor_cli_server(char out[VOR_REMOTE_URL_MAX], const struct vor_cli *cli,
                          struct vor_error *err)
{
    const char *url = cli->option[VOR_OPTION_SERVER], *listen = getenv(LISTEN_VARIABLE);
    size_t length;

    if (url == NULL)
        return from_setting(out, LISTEN_VARIABLE,
                            listen != NULL && listen[0] != '\0' ? listen : LISTEN_DEFAULT, err);
    if (strncmp(url, "unix:", 5) == 0)
        return from_socket(out, url, err);
    length = strlen(url);
    while (length > 0 && url[length - 1] == '/')
        length--;
    if (length >= VOR_REMOTE_URL_MAX - PATH_ROOM)
        return vor_fail(err, VOR_E_PARAM, "the server's URL has %zu bytes, want at most %d", length,
                        VOR_REMOTE_URL_MAX - PATH_ROOM - 1);
    memcpy(out, url, length);
    out[length] = '\0';
    return VOR_OK;
}

/* The same for a health check, which asks the listener that VORONOID_ADMIN_LISTEN names where there
 * is one: that answers while the other is overrun. */
static vor_status health_server(char out[VOR_REMOTE_URL_MAX], const struct vor_cli *cli,
                                struct vor_error *err)
{
    const char *admin = getenv(ADMIN_VARIABLE);

    if (cli->option[VOR_OPTION_SERVER] == NULL && admin != NULL && admin[0] != '\0')
        return from_setting(out, ADMIN_VARIABLE, admin, err);
    return vor_cli_server(out, cli, err);
}

int vor_cli_health(const struct vor_cli *cli)
{
    struct vor_json *json;
    struct vor_text line;
    const char *detail;
    char server[VOR_REMOTE_URL_MAX], url[VOR_REMOTE_URL_MAX + 16];
    struct vor_remote_call call = {.method = "GET", .url = url, .timeout_seconds = HEALTH_SECONDS};
    struct vor_remote *remote = NULL;
    struct vor_error err;
    int code;

    if (health_server(server, cli, &err) != VOR_OK)
        return vor_cli_fail(cli->command->name, &err);
    (void)snprintf(url, sizeof url, "%s/readyz", server);
    if (vor_remote_open(&remote, &err) != VOR_OK)
        return vor_cli_fail(NULL, &err);
    if (vor_remote_perform(remote, &call, &err) == VOR_OK) {
        json = call.http != 200 ? vor_remote_json(&call) : NULL;
        detail = vor_json_get_string(vor_json_get(json, "detail"));
        vor_text_init(&line, 0);
        vor_text_printf(&line, "not ready: the server responded with %d%s%s", call.http,
                        detail != NULL ? ": " : "", detail != NULL ? detail : "");
        code = VOR_EXIT_UNREACHABLE;
        if (call.http != 200)
            vor_cli_say(server, line.data != NULL ? line.data : "not ready");
        else
            code = printf("%s: ready\n", server) > 0 && fflush(stdout) == 0 ? VOR_EXIT_OK
                                                                            : VOR_EXIT_FAILED;
        vor_text_free(&line);
        vor_json_free(json);
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
