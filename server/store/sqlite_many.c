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
        "UPDATE job SET expired = 1, report = NULL, trace = NULL, idem_key = NULL, kept = 0"
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

vor_status vor_sqlite_recover(struct vor_sqlite *db, unsigned crashes_max, int64_t now_ms,
                              int64_t expires_ms, struct vor_recovered *recovered,
                              struct vor_error *err)
{
    struct vor_job_view row = {.problem = {.status = VOR_OK}};
    struct vor_row_text text;
    int failed = 0, requeued = 0;
    vor_status status;

    (void)vor_fail(&row.problem, VOR_E_INTERNAL,
                   "the daemon ended %u times while it worked on this job", crashes_max);
    status = vor_row_write(&text, &row, err);
    if (status == VOR_OK)
        status =
            vor_sqlite_change(db, &failed, err,
                              "UPDATE job SET status = 'failed', problem = ?2, message = ?3,"
                              " updated = ?4, finished = ?4, expires = ?5, crashes = crashes + 1"
                              " WHERE status = 'running' AND crashes + 1 >= ?1",
                              "ittii", (int64_t)crashes_max, text.problem.data, row.problem.message,
                              now_ms, expires_ms);
    if (status == VOR_OK)
        status = vor_sqlite_change(
            db, &requeued, err,
            "UPDATE job SET status = 'accepted', crashes = crashes + 1, updated = ?"
            " WHERE status = 'running'",
            "i", now_ms);
    recovered->failed = (uint64_t)failed;
    recovered->requeued = (uint64_t)requeued;
    vor_row_text_free(&text);
    return status;
}
