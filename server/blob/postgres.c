#include "server/blob/objects.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/metrics.h"
#include "server/base/postgres_library.h"
#include "server/blob/pieces.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    IDLE_MAX = 4,
    STATEMENT_SIZE = 1536,
    PAGE = 1000,
    STATEMENT_SECONDS = 15, /* in which one is to be answered */
    PROBE_SECONDS = 5
};

#define NOW_MS "(extract(epoch FROM clock_timestamp()) * 1000)::bigint"

static const char what[] = "the database of files";

struct database {
    struct vor_objects base;
    const struct vor_pg *pg;
    char *where;
    PGconn *idle[IDLE_MAX];
    int idles;
};

/* What is asked for, on a connection of its own. */
struct call {
    struct database *db;
    PGconn *connection;
    const char *verb; /* label of the metrics */
    const char *key, *to;
    int fd;
    uint64_t size;
    const struct vor_object_reader *reader;
    const struct vor_blob_patience *patience;
    double began; /* the statement */
    int found, is_probe, is_unwanted;
    int64_t object;
    PGresult *result; /* of the last question */
};

static void clear(struct call *call)
{
    call->db->pg->clear(call->result);
    call->result = NULL;
}

/* Tells of a failed statement whether it may succeed a little later, and whether we are refused. */
static vor_status fail(struct call *call, struct vor_error *err)
{
    /* No connection; a standby; a deadlock; no memory or connection; locks; it shuts down. And
     * another one put the same key. */
    static const char passing[] = "08 25 40 53 55 57";
    const struct vor_pg *pg = call->db->pg;
    const char *code = call->result != NULL ? pg->resultErrorField(call->result, 'C') : NULL;
    char class[3] = "";

    (void)snprintf(class, sizeof class, "%s", code != NULL ? code : "");
    if (err->got == ENOSPC)
        return VOR_E_IO;
    if (code == NULL || pg->status(call->connection) != VOR_PG_OK ||
        strstr(passing, class) != NULL || strcmp(code, "23505") == 0)
        err->got = EAGAIN;
    else if (strcmp(class, "42") == 0)
        err->got = EKEYREJECTED;
    return VOR_E_IO;
}

static int is_wanted(void *ctx)
{
    struct call *call = ctx;

    call->is_unwanted = !vor_objects_are_wanted(&call->db->base, call->patience, call->began);
    return !call->is_unwanted;
}

/* Runs a statement of numbers and keys, none of whose characters needs quoting; the result is in
 * binary, with numbers as text. $1 is bytes, where there are any. */
VOR_PRINTF(5, 6)
static vor_status ask(struct call *call, const void *bytes, size_t size, struct vor_error *err,
                      const char *format, ...)
{
    const unsigned type[] = {VOR_PG_BYTEA};
    const char *value[] = {bytes};
    const int length[] = {(int)size}, is_binary[] = {1};
    char sql[STATEMENT_SIZE];
    const struct vor_pg_question question = {.what = what,
                                             .sql = sql,
                                             .count = bytes != NULL,
                                             .type = type,
                                             .value = value,
                                             .length = length,
                                             .format = is_binary,
                                             .is_binary = 1,
                                             .seconds =
                                                 call->is_probe ? PROBE_SECONDS : STATEMENT_SECONDS,
                                             .is_wanted = is_wanted,
                                             .ctx = call};
    va_list args;
    int length_of_sql;

    va_start(args, format);
    length_of_sql = vsnprintf(sql, sizeof sql, format, args);
    va_end(args);
    assert(length_of_sql > 0 && (size_t)length_of_sql < sizeof sql);
    clear(call);
    call->began = vor_clock_seconds();
    return vor_pg_ask(&call->result, call->connection, &question, err) == VOR_OK ? VOR_OK
                                                                                 : fail(call, err);
}

/* --- connections ------------------------------------------------------------------------------ */

static PGconn *take_connection(struct database *db, struct vor_error *err)
{
    PGconn *connection = NULL;

    pthread_mutex_lock(&db->base.mutex);
    if (db->idles > 0)
        connection = db->idle[--db->idles];
    pthread_mutex_unlock(&db->base.mutex);
    if (connection != NULL)
        return connection;
    connection = vor_pg_connect(db->where, what, err);
    if (connection == NULL && err->status == VOR_E_IO)
        err->got = EAGAIN;
    return connection;
}

/* One on which something failed goes, and so does the transaction that it was in; and all that are
 * idle, which may have broken with it. */
static void give_connection(struct database *db, PGconn *connection, vor_status status)
{
    pthread_mutex_lock(&db->base.mutex);
    if (status == VOR_OK && db->idles < IDLE_MAX) {
        db->idle[db->idles++] = connection;
        connection = NULL;
    }
    while (status != VOR_OK && db->idles > 0)
        db->pg->finish(db->idle[--db->idles]);
    pthread_mutex_unlock(&db->base.mutex);
    if (connection != NULL)
        db->pg->finish(connection);
}

/* Does it as often as it may succeed. The result stays, for the caller to clear. */
static vor_status perform(struct call *call,
                          vor_status (*once)(struct call *call, struct vor_error *err),
                          struct vor_error *err)
{
    struct vor_error failure;
    double began = vor_clock_seconds();
    vor_status status;

    for (int i = 0;; i++) {
        double sent = vor_clock_seconds();

        failure = (struct vor_error){.status = VOR_OK};
        call->connection = take_connection(call->db, &failure);
        status = call->connection != NULL ? once(call, &failure) : failure.status;
        if (call->connection != NULL) {
            give_connection(call->db, call->connection, status);
            vor_metric_observe(VOR_METRIC_BLOB_SECONDS, vor_clock_seconds() - sent,
                               VOR_LABELS("postgres", call->verb));
        }
        if (status == VOR_OK || !vor_error_storage_away(&failure) || call->is_probe ||
            call->is_unwanted || !vor_objects_again(&call->db->base, i, began))
            break;
    }
    if ((status == VOR_OK || status == VOR_E_IO) && !call->is_unwanted)
        vor_objects_note(&call->db->base, &failure, call->is_probe);
    if (status != VOR_OK && err != NULL)
        *err = failure;
    return status;
}

/* The same for who does not need the result. */
static vor_status finish(struct call *call,
                         vor_status (*once)(struct call *call, struct vor_error *err),
                         struct vor_error *err)
{
    vor_status status = perform(call, once, err);

    clear(call);
    return status;
}

static struct database *of(struct vor_objects *objects)
{
    return (struct database *)objects;
}

/* --- writing ---------------------------------------------------------------------------------- */

static int64_t number_at(const struct call *call, int column)
{
    return strtoll(call->db->pg->getvalue(call->result, 0, column), NULL, 10);
}

/* The server ends the transaction of a daemon that has hung for 10 s: others would wait for it. */
static vor_status put_once(struct call *call, struct vor_error *err)
{
    uint8_t *buffer = malloc(VOR_BLOB_PIECE);
    vor_status status = VOR_OK;
    size_t have = 0;

    if (buffer == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "a part of a file");
    VOR_THEN(status, ask(call, NULL, 0, err, "BEGIN"));
    VOR_THEN(status,
             ask(call, NULL, 0, err, "SET LOCAL idle_in_transaction_session_timeout = 10000"));
    VOR_THEN(status,
             ask(call, NULL, 0, err,
                 "INSERT INTO voronoid_file (size) VALUES (%" PRIu64 ") RETURNING object::text",
                 call->size));
    if (status == VOR_OK)
        call->object = number_at(call, 0);
    for (uint64_t at = 0; status == VOR_OK && at < call->size; at += have) {
        have = call->size - at < VOR_BLOB_PIECE ? (size_t)(call->size - at) : VOR_BLOB_PIECE;
        status = vor_piece_read(call->fd, at, buffer, have, err);
        VOR_THEN(status, ask(call, buffer, have, err,
                             "INSERT INTO voronoid_piece VALUES (%" PRId64 ", %" PRIu64
                             ", encode(sha256($1), 'hex'), $1)",
                             call->object, at / VOR_BLOB_PIECE));
    }
    VOR_THEN(status,
             ask(call, NULL, 0, err, "DELETE FROM voronoid_file WHERE key = '%s'", call->key));
    VOR_THEN(status, ask(call, NULL, 0, err,
                         "UPDATE voronoid_file SET key = '%s', modified = " NOW_MS
                         " WHERE object = %" PRId64,
                         call->key, call->object));
    VOR_THEN(status, ask(call, NULL, 0, err, "COMMIT"));
    free(buffer);
    return status;
}

static vor_status put(struct vor_objects *objects, const char *key,
                      const struct vor_object_bytes *bytes, struct vor_error *err)
{
    struct call call = {.db = of(objects),
                        .verb = "put",
                        .key = key,
                        .fd = bytes->fd,
                        .size = bytes->size,
                        .patience = bytes->patience};
    return finish(&call, put_once, err);
}

static vor_status remove_once(struct call *call, struct vor_error *err)
{
    return ask(call, NULL, 0, err, "DELETE FROM voronoid_file WHERE key = '%s'", call->key);
}

static vor_status remove_one(struct vor_objects *objects, const char *key, struct vor_error *err)
{
    struct call call = {.db = of(objects), .verb = "delete", .key = key};
    return finish(&call, remove_once, err);
}

/* --- reading ---------------------------------------------------------------------------------- */

static vor_status get_piece(struct call *call, uint64_t at, struct vor_error *err)
{
    const struct vor_pg *pg = call->db->pg;
    vor_status status =
        ask(call, NULL, 0, err,
            "SELECT data FROM voronoid_piece WHERE object = %" PRId64 " AND number = %" PRIu64,
            call->object, at / VOR_BLOB_PIECE);

    if (status != VOR_OK)
        return status;
    if (pg->ntuples(call->result) == 0) {
        (void)vor_fail(err, VOR_E_IO, "%s: a file was replaced while it was read", what);
        err->got = EAGAIN;
        return VOR_E_IO;
    }
    call->is_unwanted = !call->reader->take(call->reader->ctx, at, pg->getvalue(call->result, 0, 0),
                                            (size_t)pg->getlength(call->result, 0, 0));
    return call->is_unwanted ? vor_fail(err, VOR_E_IO, "%s: no more is wanted", what) : VOR_OK;
}

static vor_status get_once(struct call *call, struct vor_error *err)
{
    vor_status status =
        ask(call, NULL, 0, err,
            "SELECT object::text, size::text FROM voronoid_file WHERE key = '%s'", call->key);

    if (status != VOR_OK)
        return status;
    call->found = call->db->pg->ntuples(call->result) > 0;
    if (!call->found)
        return VOR_OK;
    call->object = number_at(call, 0);
    call->size = (uint64_t)number_at(call, 1);
    for (uint64_t at = call->reader != NULL ? call->reader->from : call->size;
         status == VOR_OK && at < call->size && at < call->reader->to; at += VOR_BLOB_PIECE)
        status = get_piece(call, at, err);
    return status;
}

static vor_status get(struct vor_objects *objects, const char *key,
                      const struct vor_object_reader *reader, uint64_t *size, int *found,
                      struct vor_error *err)
{
    struct call call = {
        .db = of(objects), .verb = reader != NULL ? "get" : "head", .key = key, .reader = reader};
    vor_status status = finish(&call, get_once, err);

    *found = call.found;
    *size = status == VOR_OK && call.found ? call.size : 0;
    return status;
}

/* A page of keys behind call->key that begin with call->to; '~' is behind all that they have. */
static vor_status list_once(struct call *call, struct vor_error *err)
{
    return ask(call, NULL, 0, err,
               "SELECT key FROM voronoid_file WHERE key > '%s'"
               " AND key < '%s~' ORDER BY key LIMIT %d",
               call->key, call->to, PAGE);
}

static vor_status list(struct vor_objects *objects, const char *begin,
                       void (*each)(void *ctx, const char *key), void *ctx, struct vor_error *err)
{
    char last[VOR_OBJECT_KEY_MAX + 1];
    struct call call = {.db = of(objects), .verb = "list", .key = last, .to = begin};
    const struct vor_pg *pg = call.db->pg;
    vor_status status = VOR_OK;
    int rows = PAGE;

    (void)snprintf(last, sizeof last, "%s", begin);
    while (status == VOR_OK && rows == PAGE) {
        status = perform(&call, list_once, err);
        rows = status == VOR_OK ? pg->ntuples(call.result) : 0;
        for (int i = 0; i < rows; i++) {
            const char *key = pg->getvalue(call.result, i, 0);

            (void)snprintf(last, sizeof last, "%s", key);
            each(ctx, key + strlen(begin));
        }
    }
    clear(&call);
    return status;
}

static vor_status probe_once(struct call *call, struct vor_error *err)
{
    return ask(call, NULL, 0, err, "SELECT 1 FROM voronoid_file LIMIT 1");
}

static vor_status probe(struct vor_objects *objects, struct vor_error *err)
{
    struct call call = {.db = of(objects), .verb = "probe", .is_probe = 1};
    return finish(&call, probe_once, err);
}

/* --- opening ---------------------------------------------------------------------------------- */

/* Of many daemons that begin at once, one makes the tables. The bytes are not compressed: most of
 * them cannot be, and compression takes longer than all the rest. */
static vor_status prepare(struct call *call, struct vor_error *err)
{
    enum { VERSION = 1 };
    vor_status status = ask(
        call, NULL, 0, err, "%s",
        "DO $$ BEGIN PERFORM pg_advisory_xact_lock(1987015281, hashtext(current_schema()));"
        " IF to_regclass('voronoid_file_schema') IS NULL THEN"
        " CREATE TABLE voronoid_file_schema AS SELECT 1::bigint AS version;"
        " CREATE TABLE voronoid_file (object bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,"
        "  key text COLLATE \"C\" UNIQUE CHECK (key ~ '^[A-Za-z0-9._/-]{1,128}$'),"
        "  size bigint NOT NULL, modified bigint NOT NULL DEFAULT 0);"
        " CREATE TABLE voronoid_piece (object bigint REFERENCES voronoid_file ON DELETE CASCADE,"
        "  number bigint, sha256 text NOT NULL, data bytea NOT NULL, PRIMARY KEY (object, number));"
        " ALTER TABLE voronoid_piece ALTER data SET STORAGE EXTERNAL;"
        " END IF; END $$");
    VOR_THEN(status, ask(call, NULL, 0, err, "SELECT version::text FROM voronoid_file_schema"));
    if (status == VOR_OK && number_at(call, 0) != VERSION)
        return vor_fail(err, VOR_E_IO,
                        "%s has schema %" PRId64 ", this version reads %d: start the version that "
                        "wrote it, or choose another schema or database",
                        what, number_at(call, 0), VERSION);
    return status;
}

static void close_database(struct vor_objects *objects)
{
    struct database *db = of(objects);

    for (int i = 0; i < db->idles; i++)
        db->pg->finish(db->idle[i]);
    vor_objects_destroy(&db->base);
    free(db->where);
    free(db);
}

static vor_status open_database(struct vor_objects **out, const char *place, struct vor_error *err)
{
    struct database *db = calloc(1, sizeof *db);
    struct call call = {.db = db, .verb = "probe", .is_probe = 1};
    vor_status status;

    if (db == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%s", what);
    vor_objects_init(&db->base, &vor_postgres_objects);
    db->where = vor_pg_where(place);
    status = db->where != NULL ? vor_pg_load(&db->pg, err) : vor_fail(err, VOR_E_NOMEM, "%s", what);
    VOR_THEN(status, finish(&call, prepare, err));
    if (status != VOR_OK) {
        close_database(&db->base);
        return status;
    }
    *out = &db->base;
    return VOR_OK;
}

const struct vor_objects_kind vor_postgres_objects = {
    .scheme = "postgres",
    .open = open_database,
    .close = close_database,
    .put = put,
    .get = get,
    .remove = remove_one,
    .list = list,
    .probe = probe,
};
