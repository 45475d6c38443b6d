/* Questions about many jobs and changes of them at once: what time, quotas and a crash do to them.
 */
#include "server/store/sql_verbs.h"

#include "server/store/store.h"

/* Jobs that a statement changes at most, where there may be any number: a server is given 30 s for
 * one, and others wait meanwhile. */
enum { PORTION = 500 };

static int take_evicted(void *ctx, struct vor_sql_row *row)
{
    struct vor_evictions *evictions = ctx;
    struct vor_evicted *one = &evictions->job[evictions->count++];

    vor_sql_copy(row, one->id.text, sizeof one->id.text);
    vor_sql_copy(row, one->process, sizeof one->process);
    one->attempt = (uint32_t)vor_sql_number(row);
    return 1;
}

#define TIME "CASE ?1 WHEN 0 THEN clock_ms() ELSE ?1 END"
#define EXPIRE "UPDATE job SET expired = 1, idem_key = NULL, kept = 0, held = 0"

/* ?1 is the limit, ?2 how many at most. Jobs give up what they keep in the order in which they
 * ended, while what those before them keep is less than what is too much. Only the first ?2 are
 * added up: with all of them a submit took longer the more jobs there were. */
#define ENDED(column, which)                                                                       \
    " WHERE seq IN (SELECT seq FROM (SELECT seq, " column ", sum(" column                          \
    ") OVER (ORDER BY finished, seq) - " column " AS earlier FROM (SELECT seq, finished, " column  \
    " FROM job WHERE " column " > 0 AND finished > 0 ORDER BY finished, seq LIMIT ?2) AS oldest)"  \
    " AS ended WHERE earlier < (SELECT sum(" column ") FROM ledger) - ?1" which                    \
    ") RETURNING id, process_id, attempt"

static const struct {
    const char *total; /* nothing is too much while this is not above the limit; NULL: ask anyway */
    const char *sql;
} evictions_by[] = {
    [VOR_EVICT_EXPIRED] = {NULL, EXPIRE " WHERE seq IN (SELECT seq FROM job WHERE expires > 0"
                                        " AND expires <= " TIME
                                        " AND expired = 0 ORDER BY expires LIMIT ?2)"
                                        " RETURNING id, process_id, attempt"},
    [VOR_EVICT_UPLOADS] = {"SELECT sum(kept) FROM ledger",
                           "UPDATE job SET kept = 0" ENDED("kept", "")},
    [VOR_EVICT_RESULTS] = {"SELECT sum(held) FROM ledger", /* the last to end keeps its own */
                           EXPIRE ENDED("held", " AND earlier + held < (SELECT sum(held) FROM"
                                                " ledger)")},
};

static vor_status evict(struct vor_store *store, enum vor_evict why, int64_t limit,
                        struct vor_evictions *evictions, struct vor_error *err)
{
    int64_t total = INT64_MAX;
    vor_status status = VOR_OK;
    int forgotten = why == VOR_EVICT_EXPIRED ? PORTION : 0;

    evictions->count = 0;
    if (evictions_by[why].total != NULL)
        status =
            vor_sql_query(store, vor_sql_take_number, &total, err, evictions_by[why].total, "");
    if (status != VOR_OK || total <= limit)
        return status;
    status = vor_sql_change_each(store, take_evicted, evictions, err, evictions_by[why].sql, "ii",
                                 limit, (int64_t)evictions->max);
    if (status != VOR_OK)
        evictions->count = 0;
    while (status == VOR_OK && forgotten == PORTION)
        status = vor_sql_change(store, &forgotten, err,
                                "DELETE FROM job WHERE seq IN (SELECT seq FROM job WHERE"
                                " expires > 0 AND expires <= " TIME " AND expired = 1"
                                " AND expires + (expires - finished) <= " TIME
                                " ORDER BY expires LIMIT ?2)",
                                "ii", limit, (int64_t)PORTION);
    return status;
}

vor_status vor_store_evict(struct vor_store *store, enum vor_evict why, int64_t limit,
                           struct vor_evictions *evictions, struct vor_error *err)
{
    vor_status status;

    do
        status = evict(store, why, limit, evictions, err);
    while (vor_store_made_room(store, status, err));
    return status;
}

vor_status vor_store_forget_uploads(struct vor_store *store, const struct vor_uuid *id,
                                    struct vor_error *err)
{
    return vor_sql_change(store, NULL, err, "UPDATE job SET kept = 0 WHERE id = ? AND kept > 0",
                          "t", id->text);
}

vor_status vor_store_shift(struct vor_store *store, int64_t by_ms, struct vor_error *err)
{
    vor_status status;

    do {
        int64_t last = 0;

        status = vor_sql_begin(store, VOR_SQL_DURABLE, err);
        if (status != VOR_OK)
            continue;
        status = vor_sql_change_each(store, vor_sql_take_number, &last, err,
                                     "SELECT coalesce(max(seq), 0) FROM job", "");
        for (int64_t from = 0; status == VOR_OK && from < last; from += PORTION)
            status = vor_sql_change(store, NULL, err,
                                    "UPDATE job SET expires = max(1, expires + ?1)"
                                    " WHERE seq > ?2 AND seq <= ?3 AND expires > 0",
                                    "iii", by_ms, from, from + PORTION);
        status = vor_sql_end(store, status, err);
    } while (vor_store_made_room(store, status, err));
    return status;
}

/* By indexes. The newest is that of the last one to be accepted, of the last one to end, or of one
 * that ran. */
vor_status vor_store_newest(struct vor_store *store, int64_t *newest_ms, struct vor_error *err)
{
    *newest_ms = 0;
    return vor_sql_query(
        store, vor_sql_take_number, newest_ms, err,
        "SELECT max(updated) FROM (SELECT updated FROM job WHERE seq IN (SELECT max(seq) FROM job"
        " UNION SELECT * FROM (SELECT seq FROM job WHERE expires > 0 ORDER BY expires DESC LIMIT 1)"
        " AS last"
        " UNION SELECT seq FROM job WHERE status = 'running' AND expired = 0)"
        " UNION ALL SELECT updated FROM job_run) AS times",
        "");
}

struct keeping {
    int (*each)(void *ctx, const struct vor_keeping *job);
    void *ctx;
};

static int take_keeping(void *ctx, struct vor_sql_row *row)
{
    const struct keeping *keeping = ctx;
    struct vor_keeping job = {.seq = vor_sql_number(row)};

    vor_sql_copy(row, job.id.text, sizeof job.id.text);
    vor_sql_copy(row, job.process, sizeof job.process);
    job.kept = (uint64_t)vor_sql_number(row);
    return keeping->each(keeping->ctx, &job);
}

vor_status vor_store_keeping(struct vor_store *store, int64_t seq,
                             int (*each)(void *ctx, const struct vor_keeping *job), void *ctx,
                             struct vor_error *err)
{
    struct keeping keeping = {each, ctx};

    return vor_sql_query(store, take_keeping, &keeping, err,
                         "SELECT seq, id, process_id, kept FROM job WHERE kept > 0 AND seq < ?1"
                         " ORDER BY seq DESC LIMIT 1000",
                         "i", seq);
}

int vor_store_is_unsure(struct vor_store *store)
{
    return atomic_load(&((struct vor_sql *)store)->is_unsure);
}

static int take_piece(void *ctx, struct vor_sql_row *row)
{
    const struct vor_event_query *query = ctx;
    struct vor_event_piece piece = {.last = (uint32_t)vor_sql_number(row)};

    piece.data = vor_sql_bytes(row, &piece.size);
    return query->each(query->ctx, &piece);
}

vor_status vor_store_events(struct vor_store *store, const struct vor_uuid *id,
                            const struct vor_event_query *query, struct vor_error *err)
{
    struct vor_event_query asked = *query;

    return vor_sql_query(store, take_piece, &asked, err,
                         "SELECT last, data FROM event WHERE seq = (SELECT seq FROM job"
                         " WHERE id = ?) AND attempt = ? AND last > ? ORDER BY last",
                         "tii", id->text, (int64_t)query->attempt, (int64_t)query->after);
}

static int take_waiting(void *ctx, struct vor_sql_row *row)
{
    struct vor_waiting *waiting = ctx;

    waiting->jobs = (uint64_t)vor_sql_number(row);
    waiting->decoded = (uint64_t)vor_sql_number(row);
    waiting->oldest_ms = vor_sql_number(row);
    return 1;
}

vor_status vor_store_waiting(struct vor_store *store, struct vor_waiting *out,
                             struct vor_error *err)
{
    *out = (struct vor_waiting){.jobs = 0};
    return vor_sql_query(
        store, take_waiting, out, err,
        "SELECT coalesce(sum(jobs), 0), coalesce(sum(decoded), 0), coalesce((SELECT created FROM"
        " job INDEXED BY job_ready WHERE status = 'accepted' AND turn >= (SELECT head FROM queue)"
        " ORDER BY turn, seq LIMIT 1), 0)"
        " FROM round WHERE number <= -1 - ((SELECT head FROM queue) >> 8)",
        "");
}

static int take_leased(void *ctx, struct vor_sql_row *row)
{
    struct vor_renewal *renewal = ctx;

    if (renewal->count < renewal->max) {
        struct vor_leased *job = &renewal->job[renewal->count];

        vor_sql_copy(row, job->id.text, sizeof job->id.text);
        job->attempt = (uint32_t)vor_sql_number(row);
        job->stops = (int)vor_sql_number(row);
        job->is_looked = (int)vor_sql_number(row);
    }
    renewal->count++;
    return 1;
}

vor_status vor_store_renew(struct vor_store *store, struct vor_renewal *renewal,
                           struct vor_error *err)
{
    vor_status status = vor_sql_begin(store, VOR_SQL_APART, err);

    renewal->count = 0;
    if (status == VOR_OK)
        status = vor_sql_end(store,
                             vor_sql_change(store, NULL, err,
                                            "INSERT INTO daemon (owner, lease, engine)"
                                            " VALUES (?1, clock_ms() + ?2, ?3) ON CONFLICT (owner)"
                                            " DO UPDATE SET lease = excluded.lease",
                                            "tit", renewal->owner, renewal->lease_ms,
                                            renewal->build.engine),
                             err);
    return status == VOR_OK
               ? vor_sql_query(
                     store, take_leased, renewal, err,
                     "SELECT id, attempt, stop = attempt, EXISTS (SELECT 1 FROM event WHERE"
                     " event.seq = job.seq AND event.attempt = 0 AND last > clock_ms())"
                     " FROM job WHERE status = 'running' AND expired = 0 AND owner = ?1",
                     "t", renewal->owner)
               : status;
}

/* Among the events of a job, those of attempt 0 are its preview and, where the number is a time,
 * until when somebody looks: they go with the events of former attempts, and with the job. */
#define PREVIEW(which)                                                                             \
    "DELETE FROM event WHERE seq = (SELECT seq FROM job WHERE id = ?1) AND attempt = 0"            \
    " AND last " which " 4294967295"

vor_status vor_store_look(struct vor_store *store, const struct vor_uuid *id, struct vor_error *err)
{
    vor_status status = vor_sql_begin(store, VOR_SQL_APART, err);

    if (status != VOR_OK)
        return status;
    status = vor_sql_change(store, NULL, err, PREVIEW(">"), "t", id->text);
    if (status == VOR_OK)
        status = vor_sql_change(store, NULL, err,
                                "INSERT INTO event SELECT seq, 0, clock_ms() + 10000, ?2 FROM job"
                                " WHERE id = ?1 AND status = 'running'",
                                "tb", id->text, "", (size_t)0);
    return vor_sql_end(store, status, err);
}

vor_status vor_store_show(struct vor_store *store, const struct vor_uuid *id,
                          const struct vor_lease *lease, const struct vor_event_piece *piece,
                          struct vor_error *err)
{
    vor_status status = vor_sql_begin(store, VOR_SQL_APART, err);

    if (status != VOR_OK)
        return status;
    status = vor_sql_change(store, NULL, err, PREVIEW("<="), "t", id->text);
    if (status == VOR_OK && piece->size > 0)
        status = vor_sql_change(store, NULL, err,
                                "INSERT INTO event SELECT seq, 0, ?4, ?5 FROM job WHERE id = ?1"
                                " AND attempt = ?2 AND owner = ?3 AND status = 'running'",
                                "titib", id->text, (int64_t)lease->attempt, lease->owner,
                                (int64_t)piece->last, piece->data, piece->size);
    return vor_sql_end(store, status, err);
}

vor_status vor_store_daemons(struct vor_store *store, int64_t *count, struct vor_error *err)
{
    return vor_sql_query(store, vor_sql_take_number, count, err,
                         "SELECT count(*) FROM daemon WHERE lease > clock_ms()", "");
}

vor_status vor_store_reap(struct vor_store *store, const char *owner, int is_alone, int64_t now_ms,
                          uint64_t *reaped, struct vor_error *err)
{
    int changed = 0;
    vor_status status;

    do {
        status = vor_sql_begin(store, VOR_SQL_DURABLE, err);
        if (status != VOR_OK)
            continue;
        status = vor_sql_change(store, &changed, err,
                                "UPDATE job SET status = 'accepted', updated = ?2, alone = 1"
                                " WHERE status = 'running' AND expired = 0 AND owner <> ?1"
                                " AND (?3 <> 0 OR owner NOT IN"
                                " (SELECT owner FROM daemon WHERE lease > clock_ms()))",
                                "tii", owner, now_ms, (int64_t)is_alone);
        if (status == VOR_OK) /* the row of an owner stays for an hour, should it come back */
            status = vor_sql_change(store, NULL, err,
                                    "DELETE FROM daemon WHERE owner <> ?1"
                                    " AND (?2 <> 0 OR lease < clock_ms() - 3600000)",
                                    "ti", owner, (int64_t)is_alone);
        status = vor_sql_end(store, status, err);
    } while (vor_store_made_room(store, status, err));
    *reaped = status == VOR_OK ? (uint64_t)changed : 0;
    return status;
}
