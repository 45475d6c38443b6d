#include "server/store/postgres_database.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/postgres_library.h"
#include "server/store/postgres_hints.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STATEMENT_SIZE = 4096, NUMBER_SIZE = 32 };

/* In which a statement is to be answered; a change of the tables; and one that asks for nothing.
 * Who has waited for `doubt_seconds` asks that, by the connection that has the lock. */
static const double statement_seconds = 30, schema_seconds = 3600, ping_seconds = 4;
static const double doubt_seconds = 2;

/* Once a server does not answer, only one connection tries again for so long: longer than a look of
 * the worker takes, so that no thread of HTTP does where there is one. */
static const double away_seconds = 8;

struct connection {
    PGconn *handle; /* NULL before it is needed */
};

struct vor_postgres {
    struct vor_sql base;
    const struct vor_pg *pg;
    char *where;
    pthread_mutex_t writing; /* recursive: a transaction has several statements */
    pthread_mutex_t locking;
    _Atomic double away_until; /* 0 while the server answers */
    struct connection writer, lock, reader[VOR_SQL_READERS];
    int in_transaction; /* of the writer */
    int is_shared;
    int is_locked;                    /* the lock was got on the connection that it has */
    char holder[NUMBER_SIZE * 2];     /* or on one before it: that one's process at the server */
    struct vor_postgres_hints *hints; /* NULL for none; under `writing`, as the next */
    int is_news;                      /* the transaction has changed what others look at */
    int is_apart;                     /* it changes nothing of that kind */
};

/* What a row is read from: the answer to a statement. */
struct answer {
    struct vor_postgres *db;
    PGresult *result;
    int row;
    unsigned char *bytes; /* of the last column of bytes */
};

static const char what[] = "the job database";

/* Makes a connection, or anew where it broke. One thread at a time, as all that follow. While the
 * server does not answer, one thread of all tries again. */
static vor_status connect_to(struct vor_postgres *db, struct connection *connection,
                             struct vor_error *err)
{
    double until = atomic_load(&db->away_until), began = vor_clock_seconds();
    struct vor_error why;

    if (until == 0 && connection->handle != NULL && db->pg->status(connection->handle) == VOR_PG_OK)
        return VOR_OK;
    if (until != 0 && connection != &db->lock &&
        (began < until ||
         !atomic_compare_exchange_strong(&db->away_until, &until, began + away_seconds)))
        return vor_fail_errno(err, ETIMEDOUT, what);
    db->pg->finish(connection->handle);
    connection->handle = vor_pg_connect(db->where, what, &why);
    if (connection->handle != NULL || vor_clock_seconds() - began > doubt_seconds)
        atomic_store(&db->away_until,
                     connection->handle != NULL ? 0 : vor_clock_seconds() + away_seconds);
    if (connection->handle != NULL)
        return VOR_OK;
    if (err != NULL)
        *err = why;
    return why.status;
}

/* Who waits for an answer. */
struct waiting {
    struct vor_postgres *db;
    double since;
};

static vor_status send(struct answer *out, struct connection *connection,
                       const struct vor_pg_question *question, struct vor_error *err);

static vor_status run_for(struct vor_postgres *db, struct connection *connection, const char *sql,
                          double seconds, struct vor_error *err)
{
    const struct vor_pg_question question = {.sql = sql, .seconds = seconds};
    struct answer answer = {.db = db};
    vor_status status = send(&answer, connection, &question, err);

    db->pg->clear(answer.result);
    return status;
}

/* A slow statement is waited for as long as the server answers others. */
static int is_wanted(void *ctx)
{
    struct waiting *waiting = ctx;
    struct vor_postgres *db = waiting->db;

    if (vor_clock_seconds() - waiting->since > doubt_seconds &&
        pthread_mutex_trylock(&db->locking) == 0) {
        if (db->lock.handle != NULL && db->pg->status(db->lock.handle) == VOR_PG_OK)
            (void)run_for(db, &db->lock, "SELECT 1", ping_seconds, NULL);
        waiting->since = vor_clock_seconds();
        pthread_mutex_unlock(&db->locking);
    }
    return atomic_load(&db->away_until) == 0;
}

/* Has a statement answered on a connection that is there. */
static vor_status send(struct answer *out, struct connection *connection,
                       const struct vor_pg_question *question, struct vor_error *err)
{
    struct vor_postgres *db = out->db;
    struct waiting waiting = {db, vor_clock_seconds()};
    struct vor_pg_question with = *question;
    struct vor_error why = {.status = VOR_OK};
    vor_status status;

    with.what = what;
    with.is_wanted = connection != &db->lock ? is_wanted : NULL;
    with.ctx = &waiting;
    status = vor_pg_ask(&out->result, connection->handle, &with, &why);
    if (connection == &db->lock && status != VOR_OK && why.got == ETIMEDOUT)
        atomic_store(&db->away_until, vor_clock_seconds() + away_seconds);
    if (status != VOR_OK && err != NULL)
        *err = why;
    return status;
}

static vor_status run(struct vor_postgres *db, struct connection *connection, const char *sql,
                      struct vor_error *err)
{
    return run_for(db, connection, sql, connection == &db->lock ? ping_seconds : statement_seconds,
                   err);
}

/* Writes a statement in PostgreSQL's words: ?1 is $1, a ? without a number the next one, clock_ms()
 * the time of the server, and INDEXED BY with its name goes. */
static int translate(char *out, size_t size, const char *sql)
{
    static const char hint[] = "INDEXED BY ", clock[] = "clock_ms()";
    static const char now[] = "(extract(epoch FROM clock_timestamp()) * 1000)::bigint";
    size_t at = 0;
    int next = 1;

    while (*sql != '\0' && at + sizeof now + NUMBER_SIZE < size) {
        if (strncmp(sql, hint, sizeof hint - 1) == 0) {
            sql += sizeof hint - 1;
            sql += strcspn(sql, " )");
        } else if (strncmp(sql, clock, sizeof clock - 1) == 0) {
            sql += sizeof clock - 1;
            at += (size_t)snprintf(out + at, size - at, "%s", now);
        } else if (*sql != '?') {
            out[at++] = *sql++;
        } else if (sql[1] >= '0' && sql[1] <= '9') {
            out[at++] = '$';
            sql++;
        } else {
            at += (size_t)snprintf(out + at, size - at, "$%d", next++);
            sql++;
        }
    }
    out[at] = '\0';
    return *sql == '\0';
}

/* Values as libpq takes them. */
struct parameters {
    unsigned type[VOR_SQL_VALUES_MAX];
    const char *value[VOR_SQL_VALUES_MAX];
    int length[VOR_SQL_VALUES_MAX], format[VOR_SQL_VALUES_MAX];
    char number[VOR_SQL_VALUES_MAX][NUMBER_SIZE];
};

static void write_parameters(struct parameters *out, const struct vor_sql_values *values)
{
    memset(out, 0, sizeof *out);
    for (unsigned at = 0; at < values->count; at++) {
        const struct vor_sql_value *value = &values->value[at];

        out->value[at] = out->number[at];
        if (value->type == 'i') {
            out->type[at] = VOR_PG_INT8;
            (void)snprintf(out->number[at], NUMBER_SIZE, "%" PRId64, value->number);
        } else if (value->type == 'r') {
            out->type[at] = VOR_PG_FLOAT8;
            (void)snprintf(out->number[at], NUMBER_SIZE, "%.17g", value->real);
        } else {
            out->type[at] = value->type == 't' ? VOR_PG_TEXT : VOR_PG_BYTEA;
            out->format[at] = value->type == 'b';
            out->value[at] = value->bytes;
            out->length[at] = (int)value->size;
        }
    }
}

/* Runs a statement on a connection that is there. */
static vor_status ask(struct answer *out, struct vor_postgres *db, struct connection *connection,
                      const char *sql, const struct vor_sql_values *values, struct vor_error *err)
{
    char text[STATEMENT_SIZE];
    struct parameters with;
    const struct vor_pg_question question = {
        .sql = text,
        .count = (int)values->count,
        .type = with.type,
        .value = with.value,
        .length = with.length,
        .format = with.format,
        .seconds = connection == &db->lock ? ping_seconds : statement_seconds};

    *out = (struct answer){.db = db};
    if (!translate(text, sizeof text, sql))
        return vor_fail(err, VOR_E_IO, "the job store: a statement is too long");
    write_parameters(&with, values);
    return send(out, connection, &question, err);
}

static void end_answer(struct answer *answer)
{
    answer->db->pg->freemem(answer->bytes);
    answer->db->pg->clear(answer->result);
}

static const char *text_of(void *of, int column)
{
    const struct answer *answer = of;
    const struct vor_pg *pg = answer->db->pg;

    return pg->getisnull(answer->result, answer->row, column)
               ? NULL
               : pg->getvalue(answer->result, answer->row, column);
}

/* True is 1. */
static int64_t number_of(void *of, int column)
{
    const char *text = text_of(of, column);

    if (text == NULL)
        return 0;
    return strcmp(text, "t") == 0 ? 1 : strtoll(text, NULL, 10);
}

static double real_of(void *of, int column)
{
    const char *text = text_of(of, column);

    return text != NULL ? strtod(text, NULL) : 0;
}

static const void *bytes_of(void *of, int column, size_t *size)
{
    struct answer *answer = of;
    const char *text = text_of(of, column);

    answer->db->pg->freemem(answer->bytes);
    answer->bytes = text != NULL ? answer->db->pg->unescapeBytea((const void *)text, size) : NULL;
    if (answer->bytes == NULL)
        *size = 0;
    return answer->bytes;
}

static struct vor_postgres *of_sql(struct vor_sql *db)
{
    return (struct vor_postgres *)db;
}

/* Changes of several daemons come one after the other, as those of one do: none of them fails for
 * another, and each sees the queue and the quotas as they are. The lock ends with the transaction,
 * also behind a pooler; the server ends that of a daemon which has hung for 10 s. Some 1 ms of a
 * server on the same network. */
#define BEGIN_IN_TURN                                                                              \
    "BEGIN; SET LOCAL idle_in_transaction_session_timeout = 10000;"                                \
    " SELECT pg_advisory_xact_lock(1987015280, hashtext(current_schema()))"

/* All are durable: the server may die and this process go on, which would then have what the store
 * has forgotten. */
static vor_status begin(struct vor_sql *sql_db, enum vor_sql_how how, struct vor_error *err)
{
    struct vor_postgres *db = of_sql(sql_db);
    const char *sql = db->is_shared && how != VOR_SQL_APART ? BEGIN_IN_TURN : "BEGIN";
    struct vor_error why = {.status = VOR_OK};
    vor_status status;

    pthread_mutex_lock(&db->writing);
    status = connect_to(db, &db->writer, &why);
    if (status == VOR_OK)
        status = run(db, &db->writer, sql, &why);
    if (status != VOR_OK && why.got != ETIMEDOUT && db->writer.handle != NULL &&
        db->pg->status(db->writer.handle) != VOR_PG_OK) { /* it has broken since the last one */
        status = connect_to(db, &db->writer, &why);
        if (status == VOR_OK)
            status = run(db, &db->writer, sql, &why);
    }
    if (status != VOR_OK) {
        pthread_mutex_unlock(&db->writing);
        if (err != NULL)
            *err = why;
        return status;
    }
    db->in_transaction = 1;
    db->is_apart = how == VOR_SQL_APART;
    db->is_news = 0;
    return VOR_OK;
}

/* Where the answer does not come, the server may have done it, or may yet: it does not notice that
 * nobody waits any more. */
static vor_status commit(struct vor_postgres *db, struct vor_error *err)
{
    vor_status status = run(db, &db->writer, "COMMIT", err);

    if (status == VOR_OK || db->pg->status(db->writer.handle) == VOR_PG_OK)
        return status;
    atomic_store(&db->base.is_unsure, 1);
    if (err != NULL)
        err->got = EINPROGRESS;
    return status;
}

static vor_status end(struct vor_sql *sql_db, vor_status status, struct vor_error *err)
{
    struct vor_postgres *db = of_sql(sql_db);

    if (status == VOR_OK)
        status = commit(db, err);
    else
        (void)run(db, &db->writer, "ROLLBACK", NULL);
    if (status == VOR_OK && db->is_news && db->hints != NULL)
        vor_postgres_hints_tell(db->hints);
    db->in_transaction = 0;
    pthread_mutex_unlock(&db->writing);
    return status;
}

/* Within a transaction. */
static vor_status change_in(struct vor_postgres *db, struct vor_sql_changing *changing,
                            struct vor_error *err, const char *sql,
                            const struct vor_sql_values *values)
{
    struct vor_sql_row row = {.engine = db->base.engine};
    struct answer answer;
    vor_status status = ask(&answer, db, &db->writer, sql, values, err);
    int rows = status == VOR_OK ? db->pg->ntuples(answer.result) : 0;

    row.of = &answer;
    for (; answer.row < rows && changing->each != NULL; answer.row++) {
        row.column = 0;
        changing->each(changing->ctx, &row);
    }
    if (status == VOR_OK)
        changing->rows = atoi(db->pg->cmdTuples(answer.result));
    db->is_news |= status == VOR_OK && changing->rows > 0 && !db->is_apart;
    end_answer(&answer);
    return status;
}

static vor_status change(struct vor_sql *sql_db, struct vor_sql_changing *changing,
                         struct vor_error *err, const char *sql,
                         const struct vor_sql_values *values)
{
    struct vor_postgres *db = of_sql(sql_db);
    vor_status status = VOR_OK;
    int is_alone;

    pthread_mutex_lock(&db->writing);
    is_alone = !db->in_transaction;
    if (is_alone)
        status = begin(sql_db, VOR_SQL_DURABLE, err);
    if (status == VOR_OK) {
        status = change_in(db, changing, err, sql, values);
        if (is_alone)
            status = end(sql_db, status, err);
    }
    pthread_mutex_unlock(&db->writing);
    return status;
}

static vor_status query(struct vor_sql *sql_db, unsigned index,
                        int (*each)(void *ctx, struct vor_sql_row *row), void *ctx,
                        struct vor_error *err, const char *sql, const struct vor_sql_values *values)
{
    struct vor_postgres *db = of_sql(sql_db);
    struct vor_sql_row row = {.engine = sql_db->engine};
    struct connection *reader = &db->reader[index];
    struct answer answer = {.db = db};
    vor_status status = connect_to(db, reader, err);
    int rows = 0;

    if (status == VOR_OK)
        status = ask(&answer, db, reader, sql, values, err);
    if (status != VOR_OK && answer.result != NULL &&
        db->pg->status(reader->handle) != VOR_PG_OK) { /* it has broken since the last question */
        end_answer(&answer);
        answer.result = NULL;
        status = connect_to(db, reader, err);
        if (status == VOR_OK)
            status = ask(&answer, db, reader, sql, values, err);
    }
    if (status == VOR_OK)
        rows = db->pg->ntuples(answer.result);
    row.of = &answer;
    for (; answer.row < rows; answer.row++) {
        row.column = 0;
        if (!each(ctx, &row))
            break;
    }
    end_answer(&answer);
    return status;
}

static const struct vor_sql_engine engine = {
    .name = "postgres",
    .number = number_of,
    .real = real_of,
    .text = text_of,
    .bytes = bytes_of,
    .begin = begin,
    .end = end,
    .change = change,
    .query = query,
};

struct vor_sql *vor_postgres_sql(struct vor_postgres *db)
{
    return &db->base;
}

vor_status vor_postgres_run(struct vor_postgres *db, const char *sql, struct vor_error *err)
{
    vor_status status = begin(&db->base, VOR_SQL_DURABLE, err);

    if (status != VOR_OK)
        return status;
    return end(&db->base, run_for(db, &db->writer, sql, schema_seconds, err), err);
}

/* The first number is ours, the second stands for the schema: several may share a database. */
#define OURS "(1987015279, hashtext(current_schema()))"
#define OF_PROCESS "FROM pg_stat_activity WHERE"
#define LOCKED                                                                                     \
    " THEN (SELECT pid || ' ' || backend_start " OF_PROCESS " pid = pg_backend_pid()) END"
#define TRY_LOCK "SELECT CASE WHEN pg_try_advisory_lock" OURS LOCKED
#define TRY_LOCK_SHARED "SELECT CASE WHEN pg_try_advisory_lock_shared" OURS LOCKED
#define END_FORMER "SELECT pg_terminate_backend(pid) " OF_PROCESS " pid || ' ' || backend_start = ?"

void vor_postgres_share(struct vor_postgres *db)
{
    db->is_shared = 1;
}

/* Asks for the lock. Where another has it, that may be the process of a former connection, which
 * the server has not seen end: once it has, the lock is free. */
static vor_status take_lock(struct vor_postgres *db, struct vor_error *err)
{
    static const struct vor_sql_values none;
    const struct vor_sql_values former = {
        1, {{.type = 't', .bytes = db->holder, .size = strlen(db->holder)}}};
    struct answer answer;
    vor_status status =
        ask(&answer, db, &db->lock, db->is_shared ? TRY_LOCK_SHARED : TRY_LOCK, &none, err);
    const char *holder = status == VOR_OK ? text_of(&answer, 0) : NULL;

    db->is_locked = holder != NULL;
    if (db->is_locked)
        (void)snprintf(db->holder, sizeof db->holder, "%s", holder);
    end_answer(&answer);
    if (status != VOR_OK || db->is_locked || db->is_shared)
        return status;
    status = ask(&answer, db, &db->lock, END_FORMER, &former, err);
    if (status == VOR_OK && db->pg->ntuples(answer.result) > 0)
        status = vor_fail_errno(err, ETIMEDOUT, what);
    end_answer(&answer);
    return status;
}

vor_status vor_postgres_hold(struct vor_postgres *db, int *held, struct vor_error *err)
{
    vor_status status = VOR_OK;

    *held = 0;
    if (atomic_load(&db->away_until) == 0)
        pthread_mutex_lock(&db->locking);
    else if (pthread_mutex_trylock(&db->locking) != 0) /* another thread asks just now */
        return vor_fail_errno(err, ETIMEDOUT, what);
    if (db->is_locked) /* a question shows whether the connection is there */
        status = run(db, &db->lock, "SELECT 1", err);
    if (!db->is_locked || status != VOR_OK) {
        db->is_locked = 0;
        status = connect_to(db, &db->lock, err);
        if (status == VOR_OK)
            status = take_lock(db, err);
    }
    *held = db->is_locked;
    pthread_mutex_unlock(&db->locking);
    return status;
}

static void disconnect(struct vor_postgres *db, struct connection *connection)
{
    if (connection->handle != NULL)
        db->pg->finish(connection->handle);
}

vor_status vor_postgres_listen(struct vor_postgres *db, const char *where, void (*heard)(void *ctx),
                               void *ctx, struct vor_error *err)
{
    struct vor_postgres_hints *hints = NULL, *former;
    vor_status status =
        where != NULL ? vor_postgres_hints_open(&hints, where, heard, ctx, err) : VOR_OK;

    pthread_mutex_lock(&db->writing);
    former = db->hints;
    db->hints = hints;
    pthread_mutex_unlock(&db->writing);
    vor_postgres_hints_close(former);
    return status;
}

void vor_postgres_close(struct vor_postgres *db)
{
    if (db == NULL)
        return;
    vor_postgres_hints_close(db->hints);
    for (int i = 0; i < VOR_SQL_READERS; i++)
        disconnect(db, &db->reader[i]);
    disconnect(db, &db->writer);
    disconnect(db, &db->lock);
    pthread_mutex_destroy(&db->writing);
    pthread_mutex_destroy(&db->locking);
    vor_sql_destroy(&db->base);
    free(db->where);
    free(db);
}

vor_status vor_postgres_open(struct vor_postgres **out, const char *where, struct vor_error *err)
{
    struct vor_postgres *db = calloc(1, sizeof *db);
    pthread_mutexattr_t recursive;
    vor_status status;

    if (db == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the job store");
    vor_sql_init(&db->base, &engine);
    pthread_mutexattr_init(&recursive);
    pthread_mutexattr_settype(&recursive, PTHREAD_MUTEX_RECURSIVE);
    pthread_mutex_init(&db->writing, &recursive);
    pthread_mutexattr_destroy(&recursive);
    pthread_mutex_init(&db->locking, NULL);
    db->where = strdup(where);
    status =
        db->where != NULL ? vor_pg_load(&db->pg, err) : vor_fail(err, VOR_E_NOMEM, "the job store");
    if (status == VOR_OK)
        status = connect_to(db, &db->writer, err);
    if (status != VOR_OK) {
        vor_postgres_close(db);
        return status;
    }
    *out = db;
    return VOR_OK;
}
