#include "server/cli/cli_log.h"

#include "server/cli/interrupt.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>

size_t vor_cli_control(const char *text)
{
    unsigned char c = (unsigned char)text[0], next = c != 0 ? (unsigned char)text[1] : 0;

    if (c == 0xc2 && next >= 0x80 && next <= 0x9f)
        return 2;
    return (c > 0 && c < 0x20) || c == 0x7f;
}

void vor_cli_put(FILE *out, const char *text)
{
    for (size_t size; *text != '\0'; text += size > 0 ? size : 1) {
        size = vor_cli_control(text);
        fputc(size > 0 ? '?' : *text, out);
    }
}

void vor_cli_ask(const char *subject, const char *question)
{
    fputs("voronoid: ", stderr);
    if (subject != NULL) {
        vor_cli_put(stderr, subject);
        fputs(": ", stderr);
    }
    vor_cli_put(stderr, question);
}

void vor_cli_say(const char *subject, const char *message)
{
    vor_cli_ask(subject, message);
    fputc('\n', stderr);
}

int vor_cli_exit_code(int http, const char *type)
{
    /* What is at fault stands on the command line, whatever its HTTP status. */
    static const char *const usage[] = {"invalid-parameter", "invalid-query-parameter-value",
                                        "unknown-word", "unusable-faces"};
    const char *slug = type != NULL ? strrchr(type, '/') : NULL;

    slug = slug != NULL ? slug + 1 : type != NULL ? type : "";
    for (size_t i = 0; i < sizeof usage / sizeof usage[0]; i++)
        if (strcmp(slug, usage[i]) == 0)
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

int vor_cli_interrupted(void)
{
    return vor_interrupt_stops() || vor_interrupt_seen() == SIGINT ? VOR_EXIT_INTERRUPTED
                                                                   : VOR_EXIT_CANCELLED;
}

int vor_cli_fail(const char *subject, const struct vor_error *err)
{
    if (err->status == VOR_E_CANCELLED) {
        vor_cli_say(subject, vor_interrupt_seen() ? "cancelled" : err->message);
        return vor_cli_interrupted();
    }
    vor_cli_say(subject, err->message);
    return vor_cli_exit_code(vor_status_http(err->status), vor_status_slug(err->status));
}
