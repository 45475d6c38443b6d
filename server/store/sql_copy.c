/* All jobs of one database into another, for a move. */
#include "server/store/sql_verbs.h"

#include <assert.h>

/* A table with rows of one job: what is read and written of it, but seq, and the types of these
 * columns (vor_sql_change). */
static const struct part {
    const char *select, *insert, *types;
} parts[] = {
    {"SELECT " VOR_SQL_TEXT " FROM job_text WHERE seq = ?",
     "INSERT INTO job_text (seq, " VOR_SQL_TEXT
     ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
     "iiiiirttttttt"},
    {"SELECT " VOR_SQL_END " FROM job_end WHERE seq = ?",
     "INSERT INTO job_end (seq, " VOR_SQL_END ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
     "iiiiitttttt"},
    {"SELECT progress, updated, metrics FROM job_run WHERE seq = ?",
     "INSERT INTO job_run (seq, progress, updated, metrics) VALUES (?, ?, ?, ?)", "iit"},
    {"SELECT attempt, last, data FROM event WHERE seq = ?", "INSERT INTO event VALUES (?, ?, ?, ?)",
     "iib"},
};

/* One job on its way. */
struct copying {
    struct vor_sql *into;
    const struct part *part;
    int64_t from_seq, into_seq; /* 0 when there is none any more */
    vor_status status;          /* of the first change that failed */
    struct vor_error *err;
};

static void take_values(struct vor_sql_values *values, const char *types, struct vor_sql_row *row)
{
    for (; *types != '\0'; types++) {
        struct vor_sql_value *value = &values->value[values->count++];

        *value = (struct vor_sql_value){.type = *types};
        if (*types == 't')
            value->bytes = vor_sql_text(row);
        else if (*types == 'b')
            value->bytes = vor_sql_bytes(row, &value->size);
        else if (*types == 'r')
            value->real = vor_sql_real(row);
        else
            value->number = vor_sql_number(row);
    }
    assert(values->count <= VOR_SQL_VALUES_MAX);
}

static int copy_job(void *ctx, struct vor_sql_row *row)
{
    struct copying *copying = ctx;
    struct vor_sql_changing changing = {.each = vor_sql_take_number, .ctx = &copying->into_seq};
    struct vor_sql_values values = {.count = 0};

    copying->from_seq = vor_sql_number(row);
    take_values(&values, "iiiiiiiiiiiiiittttttt", row);
    copying->status = copying->into->engine->change(
        copying->into, &changing, copying->err,
        "INSERT INTO job (" VOR_SQL_JOB ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?,"
        " ?, ?, ?, ?, ?) RETURNING seq",
        &values);
    return 0;
}

static int copy_part(void *ctx, struct vor_sql_row *row)
{
    struct copying *copying = ctx;
    struct vor_sql_changing changing = {.each = NULL};
    struct vor_sql_values values = {.count = 1,
                                    .value = {{.type = 'i', .number = copying->into_seq}}};

    take_values(&values, copying->part->types, row);
    copying->status = copying->into->engine->change(copying->into, &changing, copying->err,
                                                    copying->part->insert, &values);
    return copying->status == VOR_OK;
}

/* What its principal had as the turn of a job that has started. */
static int copy_turn(void *ctx, struct vor_sql_row *row)
{
    struct copying *copying = ctx;
    const char *principal = vor_sql_text(row);

    copying->status = vor_sql_change(&copying->into->base, NULL, copying->err,
                                     "UPDATE ledger SET turn = max(turn, ?2) WHERE principal = ?1",
                                     "ti", principal, vor_sql_number(row));
    return copying->status == VOR_OK;
}

/* The next job, with what stands beside it: all of it, or nothing. */
static vor_status copy_next(struct vor_store *from, struct copying *copying, struct vor_error *err)
{
    vor_status status = vor_sql_begin(&copying->into->base, VOR_SQL_DURABLE, err);
    int64_t after = copying->from_seq;

    if (status != VOR_OK)
        return status;
    copying->from_seq = 0;
    status = vor_sql_query(
        from, copy_job, copying, err,
        "SELECT seq, " VOR_SQL_JOB " FROM job WHERE seq > ? ORDER BY seq LIMIT 1", "i", after);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0] && status == VOR_OK &&
                       copying->status == VOR_OK && copying->from_seq != 0;
         i++) {
        copying->part = &parts[i];
        status =
            vor_sql_query(from, copy_part, copying, err, parts[i].select, "i", copying->from_seq);
    }
    return vor_sql_end(&copying->into->base, status == VOR_OK ? copying->status : status, err);
}

static int take_id(void *ctx, struct vor_sql_row *row)
{
    vor_sql_copy(row, ((struct vor_uuid *)ctx)->text, sizeof((struct vor_uuid *)ctx)->text);
    return 0;
}

static vor_status count(struct vor_store *store, int64_t *number, struct vor_error *err)
{
    return vor_sql_query(store, vor_sql_take_number, number, err, "SELECT count(*) FROM job", "");
}

/* Jobs are copied in the order of acceptance, so that those which are there are the first ones. */
static vor_status find_rest(struct vor_store *from, struct vor_store *into, int64_t *after,
                            int64_t *were_there, struct vor_error *err)
{
    struct vor_uuid newest = {.text = ""};
    int64_t first = 0;
    vor_status status = count(into, were_there, err);

    *after = 0;
    if (status != VOR_OK || *were_there == 0)
        return status;
    status = vor_sql_query(into, take_id, &newest, err,
                           "SELECT id FROM job ORDER BY seq DESC LIMIT 1", "");
    VOR_THEN(status, vor_sql_query(from, vor_sql_take_number, after, err,
                                   "SELECT seq FROM job WHERE id = ?", "t", newest.text));
    VOR_THEN(status, vor_sql_query(from, vor_sql_take_number, &first, err,
                                   "SELECT count(*) FROM job WHERE seq <= ?", "i", *after));
    if (status == VOR_OK && first != *were_there)
        return vor_fail(err, VOR_E_IO,
                        "the database has %lld jobs that this move did not write: choose an empty "
                        "schema or database",
                        (long long)*were_there);
    return status;
}

vor_status vor_store_copy(struct vor_store *into, struct vor_store *from,
                          struct vor_store_copied *out, struct vor_error *err)
{
    struct copying copying = {.into = (struct vor_sql *)into, .err = err};
    int64_t there = 0, wanted = 0;
    vor_status status = find_rest(from, into, &copying.from_seq, &there, err);

    out->were_there = (uint64_t)there;
    VOR_THEN(status, count(from, &wanted, err));
    for (int64_t left = wanted - there; left > 0 && status == VOR_OK; left--)
        status = copy_next(from, &copying, err);
    VOR_THEN(status, vor_sql_query(from, copy_turn, &copying, err,
                                   "SELECT principal, turn FROM ledger", ""));
    VOR_THEN(status, copying.status);
    VOR_THEN(status, count(into, &there, err));
    out->jobs = (uint64_t)there;
    if (status == VOR_OK && there != wanted)
        return vor_fail(err, VOR_E_IO, "%lld of %lld jobs are in the database", (long long)there,
                        (long long)wanted);
    return status;
}
