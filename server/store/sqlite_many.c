#include "server/store/sqlite_many.h"

#include "server/store/row_text.h"

#include <stdio.h>

/* The jobs that a change returns. */
struct expiry {
    struct vor_expired *expired;
    size_t count;
};

static void copy_text(char *out, size_t size, struct vor_sqlite_row *from)
{
    const char *text = vor_sqlite_text(from);

    (void)snprintf(out, size, "%s", text != NULL ? text : "");
}

static void take_expired(void *ctx, struct vor_sqlite_row *row)
{
    struct expiry *expiry = ctx;
    struct vor_expired *one = &expiry->expired[expiry->count++];

    copy_text(one->id.text, sizeof one->id.text, row);
    copy_text(one->process, sizeof one->process, row);
}

vor_status vor_sqlite_expire(struct vor_sqlite *db, int64_t now_ms, struct vor_expired *expired,
                             size_t max, size_t *count, struct vor_error *err)
{
    struct expiry expiry = {.expired = expired};
    int forgotten;
    vor_status status = vor_sqlite_change_each(
        db, take_expired, &expiry, err,
        "UPDATE job SET expired = 1, report = NULL, trace = NULL, idem_key = NULL, kept = 0,"
        " held = 0"
        " WHERE seq IN"
        " (SELECT seq FROM job WHERE expires > 0 AND expires <= ? AND expired = 0"
        " ORDER BY expires LIMIT ?) RETURNING id, process_id",
        "ii", now_ms, (int64_t)max);

    if (status == VOR_OK)
        status = vor_sqlite_change(db, &forgotten, err,
                                   "DELETE FROM job WHERE expires > 0 AND expires <= ?1"
                                   " AND expired = 1 AND expires + (expires - finished) <= ?1",
                                   "i", now_ms);
    *count = status == VOR_OK ? expiry.count : 0;
    return status;
}

static int take_sum(void *ctx, struct vor_sqlite_row *row)
{
    *(uint64_t *)ctx = (uint64_t)vor_sqlite_number(row);
    return 1;
}

vor_status vor_sqlite_held(struct vor_sqlite *db, const char *tenant, uint64_t *bytes,
                           struct vor_error *err)
{
    *bytes = 0;
    return vor_sqlite_query(db, take_sum, bytes, err,
                            "SELECT coalesce(sum(kept + output_bytes), 0) FROM job"
                            " WHERE principal = ? AND expired = 0",
                            "t", tenant);
}

/* The jobs before one, in the order in which they ended, are given up before it: it follows while
 * what they keep together is less than what is too much. */
vor_status vor_sqlite_shed(struct vor_sqlite *db, uint64_t quota, struct vor_expired *shed,
                           size_t max, size_t *count, struct vor_error *err)
{
    struct expiry expiry = {.expired = shed};
    uint64_t kept = 0;
    vor_status status =
        vor_sqlite_query(db, take_sum, &kept, err, "SELECT sum(kept) FROM job WHERE kept > 0", "");

    *count = 0;
    if (status != VOR_OK || kept <= quota)
        return status;
    status = vor_sqlite_change_each(
        db, take_expired, &expiry, err,
        "UPDATE job SET kept = 0 WHERE seq IN"
        " (SELECT seq FROM (SELECT seq, sum(kept) OVER (ORDER BY finished, seq) - kept AS earlier"
        " FROM job WHERE kept > 0 AND finished > 0)"
        " WHERE earlier < (SELECT sum(kept) FROM job WHERE kept > 0) - ?1"
        " ORDER BY earlier LIMIT ?2) RETURNING id, process_id",
        "ii", (int64_t)quota, (int64_t)max);
    *count = status == VOR_OK ? expiry.count : 0;
    return status;
}

/* The other way round: those that ended last keep theirs as long as they fit together. */
vor_status vor_sqlite_crowd(struct vor_sqlite *db, uint64_t quota, struct vor_expired *crowded,
                            size_t max, size_t *count, struct vor_error *err)
{
    struct expiry expiry = {.expired = crowded};
    uint64_t held = 0;
    vor_status status =
        vor_sqlite_query(db, take_sum, &held, err, "SELECT sum(held) FROM job WHERE held > 0", "");

    *count = 0;
    if (status != VOR_OK || held <= quota)
        return status;
    status = vor_sqlite_change_each(
        db, take_expired, &expiry, err,
        "UPDATE job SET expired = 1, report = NULL, trace = NULL, idem_key = NULL, kept = 0,"
        " held = 0 WHERE seq IN"
        " (SELECT seq FROM (SELECT seq, held, sum(held) OVER (ORDER BY finished DESC, seq DESC)"
        " AS later FROM job WHERE held > 0)"
        " WHERE later > ?1 AND later > held ORDER BY later DESC LIMIT ?2) RETURNING id, process_id",
        "ii", (int64_t)quota, (int64_t)max);
    *count = status == VOR_OK ? expiry.count : 0;
    return status;
}

vor_status vor_sqlite_shift(struct vor_sqlite *db, int64_t by_ms, struct vor_error *err)
{
    int changed;

    return vor_sqlite_change(db, &changed, err,
                             "UPDATE job SET expires = max(1, expires + ?) WHERE expires > 0", "i",
                             by_ms);
}

static int take_newest(void *ctx, struct vor_sqlite_row *row)
{
    *(int64_t *)ctx = vor_sqlite_number(row);
    return 1;
}

/* By indexes: a row keeps this time behind its report and its trace, and a walk would read those of
 * every row. The newest is that of the last one to be accepted, of the last one to end, or of one
 * that ran. */
vor_status vor_sqlite_newest(struct vor_sqlite *db, int64_t *newest_ms, struct vor_error *err)
{
    *newest_ms = 0;
    return vor_sqlite_query(
        db, take_newest, newest_ms, err,
        "SELECT max(updated) FROM job WHERE seq IN (SELECT max(seq) FROM job"
        " UNION SELECT * FROM (SELECT seq FROM job WHERE expires > 0 ORDER BY expires DESC LIMIT 1)"
        " UNION SELECT seq FROM job WHERE status = 'running' AND expired = 0)",
        "");
}

vor_status vor_sqlite_recover(struct vor_sqlite *db, int64_t now_ms, uint64_t *requeued,
                              struct vor_error *err)
{
    int changed = 0;
    vor_status status =
        vor_sqlite_change(db, &changed, err,
                          "UPDATE job SET status = 'accepted', updated = ?1, alone = 1"
                          " WHERE status = 'running' AND expired = 0",
                          "i", now_ms);

    *requeued = (uint64_t)changed;
    return status;
}

static void take_crashes(void *ctx, struct vor_sqlite_row *row)
{
    struct vor_crashed_run *run = ctx;

    run->changed = 1;
    run->crashes = (unsigned)vor_sqlite_number(row);
}

vor_status vor_sqlite_crashed(struct vor_sqlite *db, const struct vor_uuid *id,
                              struct vor_crashed_run *run, struct vor_error *err)
{
    run->changed = 0;
    run->crashes = 0;
    return vor_sqlite_change_each(
        db, take_crashes, run, err,
        "UPDATE job SET status = 'accepted', alone = 1, crashes = crashes + ?4, updated = ?3"
        " WHERE id = ?1 AND attempt = ?2 AND status = 'running' RETURNING crashes",
        "tiii", id->text, (int64_t)run->attempt, run->now_ms, (int64_t)(run->was_alone != 0));
}
