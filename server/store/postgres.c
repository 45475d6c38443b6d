/* The driver and the engine of PostgreSQL. A connection that broke is made anew by the next
 * statement; what was under way on it fails. Works through pgbouncer in transaction mode: nothing
 * is prepared, and nothing is set for longer than a transaction. */
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/postgres_library.h"
#include "server/store/postgres_hints.h"
#include "server/store/sql_verbs.h"

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

struct postgres {
    struct vor_sql base;
    const struct vor_pg *pg;
    char *where;
    /* Other daemons may have the tables as well: the lock excludes only those that want them for
     * themselves, and the changes of all daemons are made one after the other. */
    int may_share;
    pthread_mutex_t locking;
    _Atomic double away_until; /* 0 while the server answers */
    struct connection writer, lock, reader[VOR_SQL_READERS];
    int in_transaction;               /* of the writer */
    int is_locked;                    /* the lock was got on the connection that it has */
    char holder[NUMBER_SIZE * 2];     /* or on one before it: that one's process at the server */
    struct vor_postgres_hints *hints; /* NULL for none; under `writing`, as the next */
    int is_news;                      /* the transaction has changed what others look at */
    int is_apart;                     /* it changes nothing of that kind */
};

/* What a row is read from: the answer to a statement. */
struct answer {
    struct postgres *db;
    PGresult *result;
    int row;
    unsigned char *bytes; /* of the last column of bytes */
};

static const char what[] = "the job database";

/* Makes a connection, or anew where it broke. One thread at a time, as all that follow. While the
 * server does not answer, one thread of all tries again. */
static vor_status connect_to(struct postgres *db, struct connection *connection,
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
    struct postgres *db;
    double since;
};

static vor_status send(struct answer *out, struct connection *connection,
                       const struct vor_pg_question *question, struct vor_error *err);

static vor_status run_for(struct postgres *db, struct connection *connection, const char *sql,
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
    struct postgres *db = waiting->db;

    if (vor_clock_seconds() - waiting->since > doubt_seconds &&
        pthread_mutex_trylock(&db->locking) == 0) {
        if (db->lock.handle != NULL && db->pg->status(db->lock.handle) == VOR_PG_OK)
            (void)run_for(db, &db->lock, "SELECT 1", ping_seconds, NULL);
        waiting->since = vor_clock_seconds();
        pthread_mutex_unlock(&db->locking);
    }
    return atomic_load(&db->away_until) == 0;
}

/* Has a statement answered on a connection that is there; seconds 0: in the usual time. */
static vor_status send(struct answer *out, struct connection *connection,
                       const struct vor_pg_question *question, struct vor_error *err)
{
    struct postgres *db = out->db;
    struct waiting waiting = {db, vor_clock_seconds()};
    struct vor_pg_question with = *question;
    struct vor_error why = {.status = VOR_OK};
    vor_status status;

    if (with.seconds == 0)
        with.seconds = connection == &db->lock ? ping_seconds : statement_seconds;
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

static vor_status run(struct postgres *db, struct connection *connection, const char *sql,
                      struct vor_error *err)
{
    return run_for(db, connection, sql, 0, err);
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

/* Runs a statement on a connection that is there. */
static vor_status ask(struct answer *out, struct postgres *db, struct connection *connection,
                      const char *sql, const struct vor_sql_values *values, struct vor_error *err)
{
    char text[STATEMENT_SIZE];
    struct parameters with;
    const struct vor_pg_question question = {.sql = text,
                                             .count = (int)values->count,
                                             .type = with.type,
                                             .value = with.value,
                                             .length = with.length,
                                             .format = with.format};

    *out = (struct answer){.db = db};
    if (!translate(text, sizeof text, sql))
        return vor_fail(err, VOR_E_IO, "the job store: a statement is too long");
    memset(&with, 0, sizeof with);
    for (unsigned at = 0; at < values->count; at++) {
        const struct vor_sql_value *value = &values->value[at];

        with.value[at] = with.number[at];
        if (value->type == 'i') {
            with.type[at] = VOR_PG_INT8;
            (void)snprintf(with.number[at], NUMBER_SIZE, "%" PRId64, value->number);
        } else if (value->type == 'r') {
            with.type[at] = VOR_PG_FLOAT8;
            (void)snprintf(with.number[at], NUMBER_SIZE, "%.17g", value->real);
        } else {
            with.type[at] = value->type == 't' ? VOR_PG_TEXT : VOR_PG_BYTEA;
            with.format[at] = value->type == 'b';
            with.value[at] = value->bytes;
            with.length[at] = (int)value->size;
        }
    }
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
    struct postgres *db = (struct postgres *)sql_db;
    const char *sql = db->may_share && how != VOR_SQL_APART ? BEGIN_IN_TURN : "BEGIN";
    struct vor_error why = {.status = VOR_OK};
    vor_status status;

    pthread_mutex_lock(&db->base.writing);
    for (int k = 0; k < 2; k++) { /* again where it has broken since the last one */
        status = connect_to(db, &db->writer, &why);
        VOR_THEN(status, run(db, &db->writer, sql, &why));
        if (status == VOR_OK || why.got == ETIMEDOUT || db->writer.handle == NULL ||
            db->pg->status(db->writer.handle) == VOR_PG_OK)
            break;
    }
    if (status != VOR_OK) {
        pthread_mutex_unlock(&db->base.writing);
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
static vor_status commit(struct postgres *db, struct vor_error *err)
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
    struct postgres *db = (struct postgres *)sql_db;

    if (status == VOR_OK)
        status = commit(db, err);
    else
        (void)run(db, &db->writer, "ROLLBACK", NULL);
    if (status == VOR_OK && db->is_news && db->hints != NULL)
        vor_postgres_hints_tell(db->hints);
    db->in_transaction = 0;
    pthread_mutex_unlock(&db->base.writing);
    return status;
}

static void give_rows(struct answer *answer, int (*each)(void *ctx, struct vor_sql_row *row),
                      void *ctx)
{
    struct vor_sql_row row = {.engine = answer->db->base.engine, .of = answer};
    int rows = answer->db->pg->ntuples(answer->result);

    for (; answer->row < rows && each != NULL && each(ctx, &row); answer->row++)
        row.column = 0;
}

static vor_status change(struct vor_sql *sql_db, struct vor_sql_changing *changing,
                         struct vor_error *err, const char *sql,
                         const struct vor_sql_values *values)
{
    struct postgres *db = (struct postgres *)sql_db;
    vor_status status = VOR_OK;
    int is_alone;

    pthread_mutex_lock(&db->base.writing);
    is_alone = !db->in_transaction;
    if (is_alone)
        status = begin(sql_db, VOR_SQL_DURABLE, err);
    if (status == VOR_OK) {
        struct answer answer;

        status = ask(&answer, db, &db->writer, sql, values, err);
        if (status == VOR_OK) {
            give_rows(&answer, changing->each, changing->ctx);
            changing->rows = atoi(db->pg->cmdTuples(answer.result));
            db->is_news |= changing->rows > 0 && !db->is_apart;
        }
        end_answer(&answer);
        if (is_alone)
            status = end(sql_db, status, err);
    }
    pthread_mutex_unlock(&db->base.writing);
    return status;
}

static vor_status query(struct vor_sql *sql_db, unsigned index,
                        int (*each)(void *ctx, struct vor_sql_row *row), void *ctx,
                        struct vor_error *err, const char *sql, const struct vor_sql_values *values)
{
    struct postgres *db = (struct postgres *)sql_db;
    struct connection *reader = &db->reader[index];
    struct answer answer = {.db = db};
    vor_status status = connect_to(db, reader, err);

    VOR_THEN(status, ask(&answer, db, reader, sql, values, err));
    if (status != VOR_OK && answer.result != NULL &&
        db->pg->status(reader->handle) != VOR_PG_OK) { /* it has broken since the last question */
        end_answer(&answer);
        answer.result = NULL;
        status = connect_to(db, reader, err);
        VOR_THEN(status, ask(&answer, db, reader, sql, values, err));
    }
    if (status == VOR_OK)
        give_rows(&answer, each, ctx);
    end_answer(&answer);
    return status;
}

static vor_status run_script(struct vor_sql *sql_db, const char *sql, struct vor_error *err)
{
    struct postgres *db = (struct postgres *)sql_db;
    vor_status status = begin(sql_db, VOR_SQL_DURABLE, err);

    return status == VOR_OK ? end(sql_db, run_for(db, &db->writer, sql, schema_seconds, err), err)
                            : status;
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
    .run = run_script,
    .query = query,
};

/* The first number is ours, the second stands for the schema: several may share a database. */
#define OURS "(1987015279, hashtext(current_schema()))"
#define OF_PROCESS "FROM pg_stat_activity WHERE"
#define LOCKED                                                                                     \
    " THEN (SELECT pid || ' ' || backend_start " OF_PROCESS " pid = pg_backend_pid()) END"
#define TRY_LOCK "SELECT CASE WHEN pg_try_advisory_lock" OURS LOCKED
#define TRY_LOCK_SHARED "SELECT CASE WHEN pg_try_advisory_lock_shared" OURS LOCKED
#define END_FORMER "SELECT pg_terminate_backend(pid) " OF_PROCESS " pid || ' ' || backend_start = ?"

/* Asks for the lock. Where another has it, that may be the process of a former connection, which
 * the server has not seen end: once it has, the lock is free. */
static vor_status take_lock(struct postgres *db, struct vor_error *err)
{
    static const struct vor_sql_values none;
    const struct vor_sql_values former = {
        1, {{.type = 't', .bytes = db->holder, .size = strlen(db->holder)}}};
    struct answer answer;
    vor_status status =
        ask(&answer, db, &db->lock, db->may_share ? TRY_LOCK_SHARED : TRY_LOCK, &none, err);
    const char *holder = status == VOR_OK ? text_of(&answer, 0) : NULL;

    db->is_locked = holder != NULL;
    if (db->is_locked)
        (void)snprintf(db->holder, sizeof db->holder, "%s", holder);
    end_answer(&answer);
    if (status != VOR_OK || db->is_locked || db->may_share)
        return status;
    status = ask(&answer, db, &db->lock, END_FORMER, &former, err);
    if (status == VOR_OK && db->pg->ntuples(answer.result) > 0)
        status = vor_fail_errno(err, ETIMEDOUT, what);
    end_answer(&answer);
    return status;
}

/* Takes the lock that says whose the tables are, on a connection of its own, or makes sure that it
 * is still there; held is 0 where another daemon has it. The server gives it up when that
 * connection ends, so not behind pgbouncer in transaction mode. */
static vor_status hold(struct postgres *db, int *held, struct vor_error *err)
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
        VOR_THEN(status, take_lock(db, err));
    }
    *held = db->is_locked;
    pthread_mutex_unlock(&db->locking);
    return status;
}

static vor_status fail_held(struct vor_error *err)
{
    return vor_fail(err, VOR_E_IO, "another daemon is already using the job store");
}

static vor_status listen_to(struct vor_store *store, const char *where, void (*heard)(void *ctx),
                            void *ctx, struct vor_error *err)
{
    struct postgres *db = (struct postgres *)store;
    struct vor_postgres_hints *hints = NULL, *former;
    vor_status status =
        where != NULL ? vor_postgres_hints_open(&hints, where, heard, ctx, err) : VOR_OK;

    pthread_mutex_lock(&db->base.writing);
    former = db->hints;
    db->hints = hints;
    pthread_mutex_unlock(&db->base.writing);
    vor_postgres_hints_close(former);
    return status;
}

static void close_store(struct vor_store *store)
{
    struct postgres *db = (struct postgres *)store;

    vor_postgres_hints_close(db->hints);
    for (int i = 0; i < VOR_SQL_READERS && db->pg != NULL; i++)
        db->pg->finish(db->reader[i].handle);
    if (db->pg != NULL) {
        db->pg->finish(db->writer.handle);
        db->pg->finish(db->lock.handle);
    }
    pthread_mutex_destroy(&db->locking);
    vor_sql_destroy(&db->base);
    free(db->where);
    free(db);
}

static int take_secret(void *ctx, struct vor_sql_row *row)
{
    vor_sql_copy(row, ctx, sizeof((struct vor_store *)0)->secret);
    return 1;
}

static vor_status open_store(struct vor_store **out, const char *place, int may_share, long *holder,
                             struct vor_error *err)
{
    struct postgres *db = calloc(1, sizeof *db);
    vor_status status;
    int held = 1;

    if (db == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the job store");
    vor_sql_init(&db->base, &engine);
    pthread_mutex_init(&db->locking, NULL);
    db->may_share = may_share;
    db->where = vor_pg_where(place);
    status =
        db->where != NULL ? vor_pg_load(&db->pg, err) : vor_fail(err, VOR_E_NOMEM, "the job store");
    VOR_THEN(status, connect_to(db, &db->writer, err));
    VOR_THEN(status, hold(db, &held, err));
    if (status == VOR_OK && !held) {
        *holder = -1;
        status = fail_held(err);
    }
    VOR_THEN(status, vor_postgres_prepare_schema(&db->base.base, err));
    VOR_THEN(status, vor_sql_query(&db->base.base, take_secret, db->base.base.secret, err,
                                   "SELECT secret FROM voronoid_schema", ""));
    if (status == VOR_OK)
        *out = &db->base.base;
    else
        close_store(&db->base.base);
    return status;
}

/* A server that is away may come back. One that was started anew has forgotten whose the tables
 * are: the first daemon that asks then has them. */
static vor_status check(struct vor_store *store, int *is_lost, struct vor_error *err)
{
    int64_t rows;
    int held = 0;
    vor_status status = hold((struct postgres *)store, &held, err);

    *is_lost = status == VOR_OK && !held;
    if (*is_lost)
        return fail_held(err);
    return status == VOR_OK ? vor_sql_query(store, vor_sql_take_number, &rows, err,
                                            "SELECT seq FROM job LIMIT 1", "")
                            : status;
}

const struct vor_store_driver vor_store_postgres = {
    .scheme = "postgres",
    .place = "URI",
    .open = open_store,
    .close = close_store,
    .check = check,
    .listen = listen_to,
};
