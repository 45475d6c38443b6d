#include "server/base/postgres_library.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/library.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

static struct vor_pg functions;
static const char *const names[] = {
#define VOR_PG_NAME(name, result, parameters) "PQ" #name,
    VOR_PG_TABLE(VOR_PG_NAME)
#undef VOR_PG_NAME
};

vor_status vor_pg_load(const struct vor_pg **out, struct vor_error *err)
{
    static struct vor_library library = {
        "libpq.so.5", "libpq5", names, sizeof names / sizeof names[0], &functions, false};

    *out = &functions;
    return vor_library_load(&library, err);
}

char *vor_pg_where(const char *place)
{
    size_t size = strlen(place) + sizeof "postgres:";
    char *where = malloc(size);

    if (where != NULL)
        (void)snprintf(where, size, "%s%s", strncmp(place, "//", 2) == 0 ? "postgres:" : "", place);
    return where;
}

/* VOR_E_IO with the first line of a reason. */
static void fail(const char *what, const char *why, struct vor_error *err)
{
    (void)vor_fail(err, VOR_E_IO, "%s reports: %.*s", what, (int)strcspn(why, "\n"), why);
}

/* False for a string that is none. The library's reason may show a part of it, and so a password:
 * it is told only where it names an option. */
static int is_sound(const char *where, const char *what, struct vor_error *err)
{
    static const char named[] = "invalid connection option",
                      of_uri[] = "invalid URI query parameter";
    char *why = NULL;
    void *parsed = functions.conninfoParse(where, &why);

    if (parsed == NULL && why != NULL &&
        (strncmp(why, named, sizeof named - 1) == 0 ||
         strncmp(why, of_uri, sizeof of_uri - 1) == 0))
        fail(what, why, err);
    else if (parsed == NULL)
        fail(what,
             "the connection string is malformed, want "
             "postgresql://USER:PASSWORD@HOST/DATABASE with special characters as %XX",
             err);
    functions.freemem(why);
    functions.conninfoFree(parsed);
    return parsed != NULL;
}

/* Notices and warnings, which libpq would print. */
static void ignore(VOR_UNUSED void *ctx, VOR_UNUSED const char *message)
{
}

PGconn *vor_pg_connect(const char *where, const char *what, struct vor_error *err)
{
    static const char *const names_of_options[] = {"client_encoding", "fallback_application_name",
                                                   "connect_timeout", "tcp_user_timeout",
                                                   "dbname",          NULL};
    const char *const values[] = {"UTF8", "voronoid", "5", "10000", where, NULL};
    PGconn *connection = NULL;

    if (!is_sound(where, what, err))
        return NULL;
    connection = functions.connectdbParams(names_of_options, values, 1);
    if (connection == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "a connection to %s", what);
        return NULL;
    }
    (void)functions.setNoticeProcessor(connection, ignore, NULL);
    if (functions.status(connection) == VOR_PG_OK && functions.setnonblocking(connection, 1) == 0)
        return connection;
    fail(what, functions.errorMessage(connection), err);
    functions.finish(connection);
    return NULL;
}

/* Waits until the socket has bytes, or room for some; false when it is not to be waited for. */
static int await(PGconn *connection, int is_full, double until,
                 const struct vor_pg_question *question)
{
    enum { SLICE_MS = 200 };
    struct pollfd fd = {.fd = functions.socket(connection),
                        .events = (short)(POLLIN | (is_full ? POLLOUT : 0))};

    while (poll(&fd, 1, SLICE_MS) == 0)
        if (vor_clock_seconds() > until ||
            (question->is_wanted != NULL && !question->is_wanted(question->ctx)))
            return 0;
    return 1;
}

/* Sends what is to be sent and takes in one result; false where await is. */
static int take_result(PGresult **out, PGconn *connection, double until,
                       const struct vor_pg_question *question)
{
    int left = functions.flush(connection);

    while (left >= 0 && (left > 0 || functions.isBusy(connection))) {
        if (!await(connection, left > 0, until, question))
            return 0;
        if (!functions.consumeInput(connection))
            break; /* the result says why */
        left = functions.flush(connection);
    }
    *out = functions.getResult(connection);
    return 1;
}

/* The server may be stopped, or behind a network that drops what we send: nothing more is sent. */
static vor_status give_up(PGconn *connection, const struct vor_pg_question *question,
                          struct vor_error *err)
{
    (void)shutdown(functions.socket(connection), SHUT_RDWR);
    while (functions.status(connection) == VOR_PG_OK && functions.consumeInput(connection))
        continue;
    return vor_fail_errno(err, ETIMEDOUT, question->what);
}

vor_status vor_pg_ask(PGresult **out, PGconn *connection, const struct vor_pg_question *question,
                      struct vor_error *err)
{
    enum { SEVERITY_PRIMARY = 'M', SQLSTATE = 'C' };
    double until = vor_clock_seconds() + question->seconds;
    const char *why = NULL, *state = NULL;
    PGresult *next = NULL;
    int code;

    *out = NULL;
    if (question->count > 0 || question->is_binary
            ? functions.sendQueryParams(connection, question->sql, question->count, question->type,
                                        question->value, question->length, question->format,
                                        question->is_binary)
            : functions.sendQuery(connection, question->sql))
        do {
            functions.clear(next != NULL ? *out : NULL);
            *out = next != NULL ? next : *out;
            if (!take_result(&next, connection, until, question))
                return give_up(connection, question, err);
        } while (next != NULL);
    code = functions.resultStatus(*out);
    if (code == VOR_PG_COMMAND_OK || code == VOR_PG_TUPLES_OK)
        return VOR_OK;
    if (*out != NULL) {
        why = functions.resultErrorField(*out, SEVERITY_PRIMARY);
        state = functions.resultErrorField(*out, SQLSTATE);
    }
    fail(question->what, why != NULL ? why : functions.errorMessage(connection), err);
    if (err != NULL)
        err->got = state != NULL && atoi(state) == VOR_PG_DISK_FULL ? ENOSPC : 0;
    return VOR_E_IO;
}
