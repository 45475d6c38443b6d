#include "server/store/sql.h"

#include "server/base/clock.h"
#include "server/base/metrics.h"

#include <assert.h>
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void vor_sql_init(struct vor_sql *db, const struct vor_sql_engine *engine)
{
    pthread_mutexattr_t recursive;

    db->engine = engine;
    pthread_mutexattr_init(&recursive);
    pthread_mutexattr_settype(&recursive, PTHREAD_MUTEX_RECURSIVE);
    pthread_mutex_init(&db->writing, &recursive);
    pthread_mutexattr_destroy(&recursive);
    for (unsigned i = 0; i < VOR_SQL_READERS; i++)
        pthread_mutex_init(&db->reader[i], NULL);
}

void vor_sql_destroy(struct vor_sql *db)
{
    for (unsigned i = 0; i < VOR_SQL_READERS; i++)
        pthread_mutex_destroy(&db->reader[i]);
    pthread_mutex_destroy(&db->writing);
}

int64_t vor_sql_number(struct vor_sql_row *row)
{
    return row->engine->number(row->of, row->column++);
}

double vor_sql_real(struct vor_sql_row *row)
{
    return row->engine->real(row->of, row->column++);
}

const char *vor_sql_text(struct vor_sql_row *row)
{
    return row->engine->text(row->of, row->column++);
}

const void *vor_sql_bytes(struct vor_sql_row *row, size_t *size)
{
    return row->engine->bytes(row->of, row->column++, size);
}

void vor_sql_copy(struct vor_sql_row *row, char *out, size_t size)
{
    const char *text = vor_sql_text(row);

    (void)snprintf(out, size, "%s", text != NULL ? text : "");
}

int vor_sql_take_number(void *ctx, struct vor_sql_row *row)
{
    *(int64_t *)ctx = vor_sql_number(row);
    return 1;
}

static struct vor_sql *of(struct vor_store *store)
{
    return (struct vor_sql *)store;
}

vor_status vor_sql_begin(struct vor_store *store, enum vor_sql_how how, struct vor_error *err)
{
    return of(store)->engine->begin(of(store), how, err);
}

vor_status vor_sql_end(struct vor_store *store, vor_status status, struct vor_error *err)
{
    return of(store)->engine->end(of(store), status, err);
}

vor_status vor_sql_run(struct vor_store *store, const char *sql, struct vor_error *err)
{
    return of(store)->engine->run(of(store), sql, err);
}

/* The first word of a statement, as it is called in /metrics: "UPDATE job ..." is an update. */
static void count(const struct vor_sql *db, const char *sql, double began, vor_status status)
{
    size_t length = strspn(sql, "ABCDEFGHIJKLMNOPQRSTUVWXYZ");
    char word[16] = "";

    for (size_t i = 0; i < length && i < sizeof word - 1; i++)
        word[i] = (char)tolower((unsigned char)sql[i]);
    vor_metric_observe(VOR_METRIC_STORE_SECONDS, vor_clock_seconds() - began,
                       VOR_LABELS(db->engine->name, word));
    vor_metric_add(VOR_METRIC_STORE_ERRORS, status != VOR_OK, NULL);
}

static void gather(struct vor_sql_values *out, const char *types, va_list *args)
{
    out->count = 0;
    for (; *types != '\0'; types++) {
        struct vor_sql_value *value = &out->value[out->count++];

        assert(out->count <= VOR_SQL_VALUES_MAX);
        *value = (struct vor_sql_value){.type = *types};
        if (*types == 'i') {
            value->number = va_arg(*args, int64_t);
        } else if (*types == 'r') {
            value->real = va_arg(*args, double);
        } else {
            value->bytes = va_arg(*args, const void *);
            value->size = *types == 'b' ? va_arg(*args, size_t) : 0;
        }
    }
}

static vor_status change(struct vor_sql *db, struct vor_sql_changing *changing,
                         struct vor_error *err, const char *sql,
                         const struct vor_sql_values *values)
{
    double began = vor_clock_seconds();
    vor_status status = db->engine->change(db, changing, err, sql, values);

    count(db, sql, began, status);
    return status;
}

vor_status vor_sql_change(struct vor_store *store, int *rows, struct vor_error *err,
                          const char *sql, const char *types, ...)
{
    struct vor_sql_changing plain = {.each = NULL};
    struct vor_sql_values values;
    vor_status status;
    va_list args;

    va_start(args, types);
    gather(&values, types, &args);
    va_end(args);
    status = change(of(store), &plain, err, sql, &values);
    if (rows != NULL)
        *rows = plain.rows;
    return status;
}

vor_status vor_sql_change_each(struct vor_store *store,
                               int (*each)(void *ctx, struct vor_sql_row *row), void *ctx,
                               struct vor_error *err, const char *sql, const char *types, ...)
{
    struct vor_sql_changing returning = {.each = each, .ctx = ctx};
    struct vor_sql_values values;
    va_list args;

    va_start(args, types);
    gather(&values, types, &args);
    va_end(args);
    return change(of(store), &returning, err, sql, &values);
}

vor_status vor_sql_query(struct vor_store *store, int (*each)(void *ctx, struct vor_sql_row *row),
                         void *ctx, struct vor_error *err, const char *sql, const char *types, ...)
{
    double began = vor_clock_seconds();
    struct vor_sql *db = of(store);
    struct vor_sql_values values;
    vor_status status;
    unsigned reader;
    va_list args;

    va_start(args, types);
    gather(&values, types, &args);
    va_end(args);
    for (reader = 0; reader < VOR_SQL_READERS; reader++)
        if (pthread_mutex_trylock(&db->reader[reader]) == 0)
            break;
    if (reader == VOR_SQL_READERS) {
        reader = atomic_fetch_add(&db->next_reader, 1) % VOR_SQL_READERS;
        pthread_mutex_lock(&db->reader[reader]);
    }
    status = db->engine->query(db, reader, each, ctx, err, sql, &values);
    pthread_mutex_unlock(&db->reader[reader]);
    count(db, sql, began, status);
    return status;
}
