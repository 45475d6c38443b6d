/* The driver and the engine of SQLite: each connection prepares a statement once. The only door to
 * the library. */
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/store/sql_verbs.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { STATEMENTS = 48 };

/* A statement that was prepared once, and the text that it was made of. */
struct prepared {
    const char *sql;
    sqlite3_stmt *statement;
};

struct connection {
    sqlite3 *handle;
    struct prepared prepared[STATEMENTS];
    unsigned prepared_count;
};

struct sqlite {
    struct vor_sql base;
    int lock; /* the file beside the database that says whose it is; -1 for none */
    /* Since an fsync failed or the file proved damaged: what is on the disk is not known any more
     * and every change is refused. A want of memory is no such failure. */
    atomic_int broken;
    struct connection writer, reader[VOR_SQL_READERS];
    int is_lazy; /* the writer's transaction need not be durable */
};

enum { BUSY_MS = 5000 };

/* One thread at a time, as all that use a connection: the reason is the connection's last one. */
static vor_status fail(struct sqlite *db, struct connection *connection, int code,
                       struct vor_error *err)
{
    int kind = code & 0xff, number = 0;

    if (kind == SQLITE_FULL)
        number = ENOSPC;
    else if (kind == SQLITE_IOERR || kind == SQLITE_CANTOPEN)
        number = sqlite3_system_errno(connection->handle);
    if ((kind == SQLITE_IOERR && code != SQLITE_IOERR_NOMEM && number != ENOSPC &&
         number != EDQUOT) ||
        kind == SQLITE_CORRUPT)
        atomic_store(&db->broken, 1);
    (void)vor_fail(err, VOR_E_IO, "the job database reports: %s",
                   sqlite3_errmsg(connection->handle));
    if (err != NULL)
        err->got = (uint64_t)number;
    return VOR_E_IO;
}

static vor_status run(struct sqlite *db, struct connection *connection, const char *sql,
                      struct vor_error *err)
{
    int code = sqlite3_exec(connection->handle, sql, NULL, NULL, NULL);

    return code == SQLITE_OK ? VOR_OK : fail(db, connection, code, err);
}

/* The function clock_ms() of statements. */
static void clock_ms(sqlite3_context *context, VOR_UNUSED int count,
                     VOR_UNUSED sqlite3_value **values)
{
    sqlite3_result_int64(context, vor_clock_wall_ms());
}

static vor_status connect(struct sqlite *db, struct connection *connection, const char *path,
                          const char *pragmas, struct vor_error *err)
{
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    int code = sqlite3_open_v2(path, &connection->handle, flags, NULL);

    if (code != SQLITE_OK)
        return fail(db, connection, code, err);
    (void)sqlite3_extended_result_codes(connection->handle, 1);
    (void)sqlite3_busy_timeout(connection->handle, BUSY_MS);
    (void)sqlite3_create_function(connection->handle, "clock_ms", 0, SQLITE_UTF8, NULL, clock_ms,
                                  NULL, NULL);
    return run(db, connection, pragmas, err);
}

static void disconnect(struct connection *connection)
{
    for (unsigned i = 0; i < connection->prepared_count; i++)
        (void)sqlite3_finalize(connection->prepared[i].statement);
    (void)sqlite3_close(connection->handle);
}

/* The statement of a text, which is a literal: the address tells them apart. */
static int prepare(sqlite3_stmt **out, struct connection *connection, const char *sql)
{
    struct prepared *prepared = connection->prepared;
    unsigned i = 0;
    int code;

    while (i < connection->prepared_count && prepared[i].sql != sql)
        i++;
    if (i < connection->prepared_count) {
        *out = prepared[i].statement;
        return SQLITE_OK;
    }
    assert(i < STATEMENTS);
    code = sqlite3_prepare_v3(connection->handle, sql, -1, SQLITE_PREPARE_PERSISTENT, out, NULL);
    if (code == SQLITE_OK)
        prepared[connection->prepared_count++] = (struct prepared){sql, *out};
    return code;
}

/* Binds the parameters of a statement and takes its first step; finish has to follow. */
static int start(sqlite3_stmt **out, struct connection *connection, const char *sql,
                 const struct vor_sql_values *values)
{
    int code = prepare(out, connection, sql);

    for (int at = 0; at < (int)values->count && code == SQLITE_OK; at++) {
        const struct vor_sql_value *value = &values->value[at];

        if (value->type == 't')
            code = sqlite3_bind_text(*out, at + 1, value->bytes, -1, SQLITE_STATIC);
        else if (value->type == 'i')
            code = sqlite3_bind_int64(*out, at + 1, value->number);
        else if (value->type == 'r')
            code = sqlite3_bind_double(*out, at + 1, value->real);
        else
            code = sqlite3_bind_blob64(*out, at + 1, value->bytes, value->size, SQLITE_STATIC);
    }
    return code == SQLITE_OK ? sqlite3_step(*out) : code;
}

/* Its failure is that of the last step. What was bound is gone when the caller returns. */
static void finish(sqlite3_stmt *statement)
{
    if (statement == NULL)
        return;
    (void)sqlite3_reset(statement);
    (void)sqlite3_clear_bindings(statement);
}

static int64_t number_of(void *of, int column)
{
    return sqlite3_column_int64(of, column);
}

static double real_of(void *of, int column)
{
    return sqlite3_column_double(of, column);
}

static const char *text_of(void *of, int column)
{
    return (const char *)sqlite3_column_text(of, column);
}

static const void *bytes_of(void *of, int column, size_t *size)
{
    const void *bytes = sqlite3_column_blob(of, column);

    *size = (size_t)sqlite3_column_bytes(of, column);
    return bytes;
}

static vor_status refuse(struct vor_error *err)
{
    return vor_fail(err, VOR_E_IO, "the job store cannot be used because its disk failed");
}

static vor_status change(struct vor_sql *sql_db, struct vor_sql_changing *changing,
                         struct vor_error *err, const char *sql,
                         const struct vor_sql_values *values)
{
    struct sqlite *db = (struct sqlite *)sql_db;
    struct vor_sql_row row = {.engine = sql_db->engine};
    sqlite3_stmt *statement = NULL;
    vor_status status = VOR_OK;
    int code;

    if (atomic_load(&db->broken))
        return refuse(err);
    pthread_mutex_lock(&db->base.writing);
    code = start(&statement, &db->writer, sql, values);
    row.of = statement;
    for (; code == SQLITE_ROW; code = sqlite3_step(statement)) {
        row.column = 0;
        if (changing->each != NULL)
            changing->each(changing->ctx, &row);
    }
    if (code == SQLITE_DONE)
        changing->rows = sqlite3_changes(db->writer.handle);
    else
        status = fail(db, &db->writer, code, err);
    finish(statement);
    pthread_mutex_unlock(&db->base.writing);
    return status;
}

static void release_writer(struct sqlite *db)
{
    if (db->is_lazy)
        (void)sqlite3_exec(db->writer.handle, "PRAGMA synchronous=FULL", NULL, NULL, NULL);
    db->is_lazy = 0;
    pthread_mutex_unlock(&db->base.writing);
}

static vor_status begin(struct vor_sql *sql_db, enum vor_sql_how how, struct vor_error *err)
{
    struct sqlite *db = (struct sqlite *)sql_db;
    vor_status status;

    pthread_mutex_lock(&db->base.writing);
    db->is_lazy = how != VOR_SQL_DURABLE;
    status =
        atomic_load(&db->broken)
            ? refuse(err)
            : run(db, &db->writer,
                  db->is_lazy ? "PRAGMA synchronous=NORMAL; BEGIN IMMEDIATE" : "BEGIN IMMEDIATE",
                  err);
    if (status != VOR_OK)
        release_writer(db);
    return status;
}

static vor_status end(struct vor_sql *sql_db, vor_status status, struct vor_error *err)
{
    struct sqlite *db = (struct sqlite *)sql_db;

    VOR_THEN(status, run(db, &db->writer, "COMMIT", err));
    if (status != VOR_OK && !sqlite3_get_autocommit(db->writer.handle))
        (void)sqlite3_exec(db->writer.handle, "ROLLBACK", NULL, NULL, NULL);
    release_writer(db);
    return status;
}

static vor_status run_script(struct vor_sql *sql_db, const char *sql, struct vor_error *err)
{
    struct sqlite *db = (struct sqlite *)sql_db;
    vor_status status;

    pthread_mutex_lock(&db->base.writing);
    status = run(db, &db->writer, sql, err);
    if (!sqlite3_get_autocommit(db->writer.handle))
        (void)sqlite3_exec(db->writer.handle, "ROLLBACK", NULL, NULL, NULL);
    pthread_mutex_unlock(&db->base.writing);
    return status;
}

static vor_status query(struct vor_sql *sql_db, unsigned index,
                        int (*each)(void *ctx, struct vor_sql_row *row), void *ctx,
                        struct vor_error *err, const char *sql, const struct vor_sql_values *values)
{
    struct sqlite *db = (struct sqlite *)sql_db;
    struct vor_sql_row row = {.engine = sql_db->engine};
    struct connection *reader = &db->reader[index];
    sqlite3_stmt *statement = NULL;
    vor_status status = VOR_OK;
    int code = start(&statement, reader, sql, values);

    row.of = statement;
    for (; code == SQLITE_ROW; code = sqlite3_step(statement)) {
        row.column = 0;
        if (!each(ctx, &row))
            break;
    }
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        status = fail(db, reader, code, err);
    finish(statement);
    return status;
}

static const struct vor_sql_engine engine = {
    .name = "sqlite",
    .number = number_of,
    .real = real_of,
    .text = text_of,
    .bytes = bytes_of,
    .begin = begin,
    .end = end,
    .change = change,
    .run = run_script,
    .query = query,
};

/* A log that one long reader has let grow is cut back to this, in bytes. */
#define PRAGMAS_OF_WRITER                                                                          \
    "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA journal_size_limit=16777216;"        \
    "PRAGMA temp_store=MEMORY;"

static vor_status open_file(struct sqlite *db, const char *path, long *holder,
                            struct vor_error *err)
{
    const char *slash = strrchr(path, '/');
    char name[4096];
    vor_status status = VOR_OK;

    if ((size_t)snprintf(name, sizeof name, "%s.lock", path) >= sizeof name)
        return vor_fail_errno(err, ENAMETOOLONG, "the job store");
    if (slash != NULL && slash != path) {
        char *folder = strndup(path, (size_t)(slash - path));

        status = folder != NULL ? vor_storage_directory(folder, err)
                                : vor_fail(err, VOR_E_NOMEM, "the path of the job store");
        free(folder);
    }
    VOR_THEN(status, vor_storage_lock(&db->lock, name, 0, holder, err));
    if (status != VOR_OK)
        return status;
    status = connect(db, &db->writer, path, PRAGMAS_OF_WRITER, err);
    for (int i = 0; i < VOR_SQL_READERS && status == VOR_OK; i++)
        status = connect(db, &db->reader[i], path, "PRAGMA query_only=ON;", err);
    return status == VOR_OK ? vor_sqlite_prepare_schema(&db->base.base, err) : status;
}

static void close_store(struct vor_store *store)
{
    struct sqlite *db = (struct sqlite *)store;

    for (int i = 0; i < VOR_SQL_READERS; i++)
        disconnect(&db->reader[i]);
    disconnect(&db->writer);
    vor_reserve_close(store->reserve); /* which may need the room that the closing has made */
    vor_sql_destroy(&db->base);
    if (db->lock >= 0)
        close(db->lock);
    free(db);
}

static vor_status open_store(struct vor_store **out, const char *place, VOR_UNUSED int may_share,
                             long *holder, struct vor_error *err)
{
    struct sqlite *db = calloc(1, sizeof *db);
    vor_status status;

    if (db == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the job store");
    db->lock = -1;
    vor_sql_init(&db->base, &engine);
    status = open_file(db, place, holder, err);
    if (status == VOR_OK)
        *out = &db->base.base;
    else
        close_store(&db->base.base);
    return status;
}

static vor_status check(struct vor_store *store, int *is_lost, struct vor_error *err)
{
    int64_t rows;
    vor_status status = atomic_load(&((struct sqlite *)store)->broken)
                            ? refuse(err)
                            : vor_sql_query(store, vor_sql_take_number, &rows, err,
                                            "SELECT seq FROM job LIMIT 1", "");

    *is_lost = status != VOR_OK;
    return status;
}

/* Pages without rows, 64 at a time: those at the end of the file are moved into others. The log
 * goes into the file before, so that it has room for that and for what follows though the disk has
 * none; and after, which makes the file shorter. */
static vor_status give_back(struct vor_store *store, int64_t *left, struct vor_error *err)
{
    struct sqlite *db = (struct sqlite *)store;
    vor_status status = atomic_load(&db->broken) ? refuse(err) : VOR_OK;

    if (status != VOR_OK)
        return status;
    pthread_mutex_lock(&db->base.writing);
    (void)run(db, &db->writer, "PRAGMA wal_checkpoint", NULL);
    status = run(db, &db->writer, "PRAGMA incremental_vacuum(64); PRAGMA wal_checkpoint", err);
    pthread_mutex_unlock(&db->base.writing);
    return status == VOR_OK
               ? vor_sql_query(store, vor_sql_take_number, left, err, "PRAGMA freelist_count", "")
               : status;
}

const struct vor_store_driver vor_store_sqlite = {
    .scheme = "sqlite",
    .place = "PATH",
    .is_file = 1,
    .open = open_store,
    .close = close_store,
    .check = check,
    .give_back = give_back,
};
