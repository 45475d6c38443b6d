#include "server/base/postgres_library.h"

#include "server/base/library.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* The first line, without the newline at its end. */
vor_status vor_pg_fail(const char *what, const char *why, const char *state, struct vor_error *err)
{
    (void)vor_fail(err, VOR_E_IO, "%s reports: %.*s", what, (int)strcspn(why, "\n"), why);
    if (err != NULL)
        err->got = state != NULL && atoi(state) == VOR_PG_DISK_FULL ? ENOSPC : 0;
    return VOR_E_IO;
}

vor_status vor_pg_fail_result(const char *what, const PGconn *connection, const PGresult *result,
                              struct vor_error *err)
{
    enum { SEVERITY_PRIMARY = 'M', SQLSTATE = 'C' };
    const char *why = result != NULL ? functions.resultErrorField(result, SEVERITY_PRIMARY) : NULL;

    return vor_pg_fail(what, why != NULL ? why : functions.errorMessage(connection),
                       result != NULL ? functions.resultErrorField(result, SQLSTATE) : NULL, err);
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
        (void)vor_pg_fail(what, why, NULL, err);
    else if (parsed == NULL)
        (void)vor_pg_fail(what,
                          "the connection string is malformed, want "
                          "postgresql://USER:PASSWORD@HOST/DATABASE with special characters as %XX",
                          NULL, err);
    functions.freemem(why);
    functions.conninfoFree(parsed);
    return parsed != NULL;
}

/* Notices and warnings, which libpq would print. */
static void ignore(void *ctx, const char *message)
{
    (void)ctx;
    (void)message;
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
    if (functions.status(connection) == VOR_PG_OK)
        return connection;
    (void)vor_pg_fail(what, functions.errorMessage(connection), NULL, err);
    functions.finish(connection);
    return NULL;
}
