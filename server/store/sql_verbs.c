/* Verbs about one job. */
#include "server/store/sql_verbs.h"

#include "server/base/metrics.h"
#include "server/store/row_text.h"
#include "server/store/store.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

/* --- changes ---------------------------------------------------------------------------------- */

static int take_ledger(void *ctx, struct vor_sql_row *row)
{
    struct vor_ledger *ledger = ctx;

    ledger->jobs = (uint64_t)vor_sql_number(row);
    ledger->bytes = (uint64_t)vor_sql_number(row);
    return 1;
}

/* In the row of a principal, the one that is left of several; and of what a job that waits has. */
#define NEWEST " ORDER BY version DESC LIMIT 1"
#define WAITS "status = 'accepted' AND turn >= (SELECT head FROM queue)"

#define SELECT_LEDGER "SELECT jobs, kept + held FROM ledger WHERE principal = ?" NEWEST

static vor_status insert_row(struct vor_store *store, struct vor_job_view *row,
                             const struct vor_row_text *text, struct vor_error *err)
{
    const struct vor_job_input *input = &row->input[0];
    char traceparent[VOR_TRACEPARENT_SIZE];
    int64_t seq = 0;
    vor_status status = vor_sql_change_each(
        store, vor_sql_take_number, &seq, err,
        "INSERT INTO job (id, process_id, status, created, updated, name, principal, idem_key, "
        "kept,"
        " decoded, turn) VALUES (?1, ?2, 'accepted', ?3, ?3, ?4, ?5, ?6, ?7, ?8,"
        " max(coalesce((SELECT served FROM queue), 0),"
        " (SELECT coalesce(min(turn), 0) - 1 FROM job WHERE " WAITS "),"
        " (SELECT coalesce(max(turn), -1) + 1 FROM job WHERE " WAITS " AND principal = ?5),"
        " coalesce((SELECT turn + 1 FROM ledger WHERE principal = ?5" NEWEST "), 0)))"
        " RETURNING seq",
        "ttitttii", row->id.text, row->process, row->created, row->name, row->key.principal,
        row->key.text[0] != '\0' ? row->key.text : NULL, (int64_t)row->kept, (int64_t)row->decoded);

    VOR_THEN(status,
             vor_sql_change(store, NULL, err,
                            "INSERT INTO job_text (" VOR_SQL_TEXT
                            ", seq) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                            "iiiiirttttttti", (int64_t)input->format, (int64_t)input->points,
                            (int64_t)input->bytes, (int64_t)row->memory, row->build.release,
                            input->seconds, input->sha256, row->key.fingerprint,
                            vor_span_text(&row->span, traceparent), row->build.engine, row->message,
                            text->request.data, text->inputs.data, seq));
    if (status == VOR_OK)
        row->seq = seq;
    return status;
}

vor_status vor_store_insert(struct vor_store *store, struct vor_job_view *row,
                            struct vor_ledger *ledger, struct vor_error *err)
{
    struct vor_row_text text;
    vor_status status = vor_row_write(&text, row, err);

    VOR_THEN(status, vor_sql_begin(store, VOR_SQL_DURABLE, err));
    if (status != VOR_OK)
        goto done;
    if (ledger != NULL) {
        ledger->jobs = ledger->bytes = 0;
        status = vor_sql_change_each(store, take_ledger, ledger, err, SELECT_LEDGER, "t",
                                     row->key.principal);
        ledger->is_over = !vor_ledger_fits(ledger, row->kept);
    }
    if (status == VOR_OK && (ledger == NULL || !ledger->is_over))
        status = insert_row(store, row, &text, err);
    status = vor_sql_end(store, status, err);
done:
    vor_row_text_free(&text);
    return status;
}

/* A piece whose answer was lost may be there: it comes again, perhaps with what was before it. */
static vor_status add_events(struct vor_store *store, int64_t seq, uint32_t attempt,
                             const struct vor_event_piece *piece, struct vor_error *err)
{
    if (piece->size == 0)
        return VOR_OK;
    return vor_sql_change(store, NULL, err,
                          "INSERT INTO event VALUES (?, ?, ?, ?)"
                          " ON CONFLICT (seq, attempt, last) DO UPDATE SET data = excluded.data",
                          "iiib", seq, (int64_t)attempt, (int64_t)piece->last, piece->data,
                          piece->size);
}

vor_status vor_store_append_events(struct vor_store *store, const struct vor_job_view *row,
                                   const struct vor_lease *lease,
                                   const struct vor_event_piece *piece, int *changed,
                                   struct vor_error *err)
{
    struct vor_row_text text;
    int64_t seq = 0;
    vor_status status = vor_row_write(&text, row, err);

    *changed = 0;
    VOR_THEN(status, vor_sql_begin(store, VOR_SQL_LAZY, err));
    if (status == VOR_OK) {
        status = vor_sql_change_each(
            store, vor_sql_take_number, &seq, err,
            "INSERT INTO job_run (seq, progress, updated, metrics)"
            " SELECT seq, ?4, ?5, ?6 FROM job"
            " WHERE id = ?1 AND attempt = ?2 AND owner = ?3 AND status = 'running'"
            " ON CONFLICT (seq) DO UPDATE SET progress = max(job_run.progress, excluded.progress),"
            " updated = excluded.updated, metrics = excluded.metrics RETURNING seq",
            "titiit", row->id.text, (int64_t)lease->attempt, lease->owner, (int64_t)row->progress,
            row->updated, text.metrics.data);
        if (status == VOR_OK && seq != 0)
            status = add_events(store, seq, lease->attempt, piece, err);
        status = vor_sql_end(store, status, err);
    }
    *changed = status == VOR_OK && seq != 0;
    vor_row_text_free(&text);
    return status;
}

vor_status vor_store_stop(struct vor_store *store, const struct vor_uuid *id, int *changed,
                          struct vor_error *err)
{
    return vor_sql_change(store, changed, err,
                          "UPDATE job SET stop = attempt WHERE id = ? AND status = 'running'", "t",
                          id->text);
}

static int take_crashes(void *ctx, struct vor_sql_row *row)
{
    struct vor_hand_back *run = ctx;

    run->changed = 1;
    run->crashes = (unsigned)vor_sql_number(row);
    run->is_over = vor_sql_number(row) != 0;
    return 1;
}

vor_status vor_store_hand_back(struct vor_store *store, const struct vor_uuid *id,
                               struct vor_hand_back *run, struct vor_error *err)
{
    vor_status status;

    run->changed = run->is_over = 0;
    run->crashes = 0;
    do
        status = vor_sql_change_each(
            store, take_crashes, run, err,
            "UPDATE job SET alone = max(alone, ?4), crashes = crashes + ?5, updated = ?3,"
            " status = CASE WHEN ?5 > 0 AND ?6 > 0 AND crashes + ?5 >= ?6 THEN 'running'"
            " ELSE 'accepted' END"
            " WHERE id = ?1 AND attempt = ?2 AND owner = ?7 AND status = 'running'"
            " RETURNING crashes, status = 'running'",
            "tiiiiit", id->text, (int64_t)run->lease.attempt, run->now_ms,
            (int64_t)(run->is_crash != 0), (int64_t)(run->is_crash && run->was_alone),
            (int64_t)run->most, run->lease.owner);
    while (vor_store_made_room(store, status, err));
    return status;
}

/* Bytes of the outputs that are blobs. */
static uint64_t held_bytes(const struct vor_job_view *row)
{
    const struct vor_artefact_info *outputs = row->spec.process->outputs;
    uint64_t bytes = 0;

    for (unsigned i = 0; row->status == VOR_JOB_SUCCESSFUL && outputs[i].name != NULL; i++)
        bytes += vor_output_in_row(&outputs[i]) ? 0 : row->output[i].bytes;
    return bytes;
}

/* What is known at the end. */
static vor_status add_end(struct vor_store *store, int64_t seq, const struct vor_job_view *row,
                          const char *report, struct vor_error *err)
{
    const struct vor_job_output *output = &row->output[0];
    struct vor_row_text text;
    vor_status status = vor_row_write(&text, row, err);

    VOR_THEN(status, vor_sql_change(store, NULL, err,
                                    "INSERT INTO job_end (" VOR_SQL_END
                                    ", seq) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                                    "iiiiitttttti", (int64_t)row->progress, (int64_t)output->format,
                                    (int64_t)output->points, (int64_t)output->bytes,
                                    (int64_t)(report != NULL ? strlen(report) : 0), output->sha256,
                                    row->message, text.metrics.data, text.problem.data,
                                    text.outputs.data, report, seq));
    vor_row_text_free(&text);
    return status;
}

vor_status vor_store_finish(struct vor_store *store, const struct vor_job_view *row,
                            const struct vor_lease *lease, const struct vor_store_ending *ending,
                            int *changed, struct vor_error *err)
{
    static const struct vor_store_ending nothing;
    int64_t seq;
    vor_status status;

    assert(vor_job_status_over(row->status));
    ending = ending != NULL ? ending : &nothing;
    do {
        seq = 0;
        status = vor_sql_begin(store, VOR_SQL_DURABLE, err);
        if (status != VOR_OK)
            continue;
        status = vor_sql_change_each(
            store, vor_sql_take_number, &seq, err,
            "UPDATE job SET status = ?3, updated = ?4, finished = ?4, expires = ?5, attempt = ?6,"
            " kept = min(kept, ?7), held = ?8"
            " WHERE id = ?1 AND CASE ?2 WHEN 0 THEN status IN ('accepted', 'running')"
            " ELSE status = 'running' AND attempt = ?2 AND owner = ?9 END RETURNING seq",
            "titiiiiit", row->id.text, (int64_t)(lease != NULL ? lease->attempt : 0),
            vor_job_status_word(row->status), row->finished, row->expires, (int64_t)row->attempt,
            (int64_t)row->kept, (int64_t)held_bytes(row), lease != NULL ? lease->owner : NULL);
        if (status == VOR_OK && seq != 0)
            status = add_events(store, seq, row->attempt, &ending->events, err);
        if (status == VOR_OK && seq != 0)
            status = add_end(store, seq, row, ending->report, err);
        status = vor_sql_end(store, status, err);
    } while (vor_store_made_room(store, status, err));
    *changed = status == VOR_OK && seq != 0;
    if (status == VOR_OK && *changed)
        vor_metric_add(VOR_METRIC_JOBS_ENDED, 1,
                       VOR_LABELS(row->process, vor_job_status_word(row->status)));
    return status;
}

vor_status vor_store_remove(struct vor_store *store, const struct vor_uuid *id, int *changed,
                            struct vor_error *err)
{
    vor_status status;

    do
        status =
            vor_sql_change(store, changed, err,
                           "DELETE FROM job WHERE id = ? AND status NOT IN ('accepted', 'running')",
                           "t", id->text);
    while (vor_store_made_room(store, status, err));
    return status;
}

/* --- reading ---------------------------------------------------------------------------------- */

#define ROW_COLUMNS                                                                                \
    "id, job.seq, process_id, status, coalesce(job_end.progress, job_run.progress, 0),"            \
    " coalesce(job_end.message, job_text.message), request,"                                       \
    " coalesce(job_end.metrics, job_run.metrics), problem, inputs, outputs,"                       \
    " input_format, input_points, input_bytes, input_sha256, input_seconds,"                       \
    " output_format, output_points, output_bytes, output_sha256,"                                  \
    " CASE expired WHEN 0 THEN report_bytes ELSE 0 END,"                                           \
    " attempt, created, started, max(job.updated, coalesce(job_run.updated, 0)), finished,"        \
    " expires, expired,"                                                                           \
    " name, traceparent, principal, idem_key, fingerprint, kept, alone, memory, decoded,"          \
    " engine, release"

/* The row of a job with all that is known of it. */
#define ROWS                                                                                       \
    " FROM job LEFT JOIN job_text ON job_text.seq = job.seq"                                       \
    " LEFT JOIN job_end ON job_end.seq = job.seq LEFT JOIN job_run ON job_run.seq = job.seq"

/* How many leave before a row that waits: in rounds of 256 turns, in turns, in its own turn; -1 for
 * others. */
#define SUM_OF_ROUNDS " coalesce((SELECT sum(jobs) FROM round WHERE number "
#define POSITION                                                                                   \
    ", CASE status WHEN 'accepted' THEN" SUM_OF_ROUNDS                                             \
    "BETWEEN -(job.turn >> 8) AND -1 - ((SELECT head FROM queue) >> 8)), 0) +" SUM_OF_ROUNDS       \
    ">= job.turn >> 8 << 8 AND number < job.turn), 0) +"                                           \
    " (SELECT count(*) FROM job AS other INDEXED BY job_ready WHERE other.status = 'accepted'"     \
    " AND other.turn = job.turn AND other.seq < job.seq) ELSE -1 END"

/* The columns of the main input and the main output. */
static void read_main(struct vor_job_view *out, struct vor_sql_row *from)
{
    struct vor_job_input *input = &out->input[0];
    struct vor_job_output *output = &out->output[0];

    input->format = (unsigned)vor_sql_number(from);
    input->points = (uint64_t)vor_sql_number(from);
    input->bytes = (uint64_t)vor_sql_number(from);
    vor_sql_copy(from, input->sha256, sizeof input->sha256);
    input->seconds = vor_sql_real(from);
    output->format = (unsigned)vor_sql_number(from);
    output->points = (uint64_t)vor_sql_number(from);
    output->bytes = (uint64_t)vor_sql_number(from);
    vor_sql_copy(from, output->sha256, sizeof output->sha256);
}

static void read_row(struct vor_job_view *out, struct vor_sql_row *row)
{
    uint64_t length;
    struct vor_row_columns columns;
    const char *span;

    *out = (struct vor_job_view){.eta_seconds = -1};
    vor_sql_copy(row, out->id.text, sizeof out->id.text);
    out->seq = vor_sql_number(row);
    vor_sql_copy(row, out->process, sizeof out->process);
    out->status = vor_job_status_find(vor_sql_text(row));
    out->progress = (int)vor_sql_number(row);
    vor_sql_copy(row, out->message, sizeof out->message);
    columns.request = vor_sql_text(row);
    columns.metrics = vor_sql_text(row);
    columns.problem = vor_sql_text(row);
    columns.inputs = vor_sql_text(row);
    columns.outputs = vor_sql_text(row);
    vor_row_read(out, &columns);
    read_main(out, row);
    length = (uint64_t)vor_sql_number(row); /* of the output that is kept in the row */
    for (unsigned i = 0; out->spec.process->outputs[i].name != NULL; i++)
        if (vor_output_in_row(&out->spec.process->outputs[i]))
            out->output[i].bytes = length;
    out->attempt = (uint32_t)vor_sql_number(row);
    if (out->status == VOR_JOB_ACCEPTED || out->attempt == 0)
        out->attempt++;
    out->created = vor_sql_number(row);
    out->started = vor_sql_number(row);
    out->updated = vor_sql_number(row);
    out->finished = vor_sql_number(row);
    out->expires = vor_sql_number(row);
    out->expired = (int)vor_sql_number(row);
    vor_sql_copy(row, out->name, sizeof out->name);
    span = vor_sql_text(row);
    if (span != NULL)
        (void)vor_span_parse(&out->span, span);
    vor_sql_copy(row, out->key.principal, sizeof out->key.principal);
    vor_sql_copy(row, out->key.text, sizeof out->key.text);
    vor_sql_copy(row, out->key.fingerprint, sizeof out->key.fingerprint);
    out->kept = (uint64_t)vor_sql_number(row);
    out->alone = (int)vor_sql_number(row);
    out->memory = (uint64_t)vor_sql_number(row);
    out->decoded = (uint64_t)vor_sql_number(row);
    vor_sql_copy(row, out->build.engine, sizeof out->build.engine);
    out->build.release = vor_sql_number(row);
    out->queue_position = (long)vor_sql_number(row);
    /* How far the job got, as far as its row tells. */
    if (out->status == VOR_JOB_ACCEPTED || out->started == 0)
        out->stage = VOR_STAGE_QUEUED;
    else if (out->status == VOR_JOB_SUCCESSFUL)
        out->stage = VOR_STAGE_ENCODE;
    else
        out->stage = out->has_record ? VOR_STAGE_OPTIMIZE : VOR_STAGE_PREPARE;
}

struct taken {
    struct vor_job_view *row;
    int found;
};

static int take_row(void *ctx, struct vor_sql_row *row)
{
    struct taken *taken = ctx;

    read_row(taken->row, row);
    taken->found = 1;
    return 0;
}

vor_status vor_store_get(struct vor_store *store, const struct vor_uuid *id, const char *tenant,
                         struct vor_job_view *out, int *found, struct vor_error *err)
{
    struct taken taken = {.row = out};
    vor_status status = vor_sql_query(store, take_row, &taken, err,
                                      "SELECT " ROW_COLUMNS POSITION ROWS " WHERE id = ?1"
                                      " AND (?2 IS NULL OR principal = ?2)",
                                      "tt", id->text, tenant);

    *found = taken.found;
    return status;
}

struct brief {
    struct vor_job_brief *job;
    int found;
};

static int take_brief(void *ctx, struct vor_sql_row *row)
{
    struct brief *brief = ctx;

    brief->found = 1;
    brief->job->status = vor_job_status_find(vor_sql_text(row));
    vor_sql_copy(row, brief->job->process, sizeof brief->job->process);
    brief->job->kept = (uint64_t)vor_sql_number(row);
    brief->job->expired = (int)vor_sql_number(row);
    brief->job->attempt = (uint32_t)vor_sql_number(row);
    return 0;
}

vor_status vor_store_brief(struct vor_store *store, const struct vor_uuid *id,
                           struct vor_job_brief *out, int *found, struct vor_error *err)
{
    struct brief brief = {.job = out};
    vor_status status = vor_sql_query(
        store, take_brief, &brief, err,
        "SELECT status, process_id, kept, expired, attempt FROM job WHERE id = ?", "t", id->text);

    *found = brief.found;
    return status;
}

vor_status vor_store_find_key(struct vor_store *store, const struct vor_job_key *key,
                              struct vor_job_view *out, int *found, struct vor_error *err)
{
    struct taken taken = {.row = out};
    vor_status status =
        vor_sql_query(store, take_row, &taken, err,
                      "SELECT " ROW_COLUMNS POSITION ROWS " WHERE principal = ? AND idem_key = ?",
                      "tt", key->principal, key->text);

    *found = taken.found;
    return status;
}

struct report {
    char *text;
    int failed;
};

static int take_report(void *ctx, struct vor_sql_row *row)
{
    struct report *report = ctx;

    const char *text = vor_sql_text(row);

    report->text = text != NULL ? strdup(text) : NULL;
    report->failed = report->text == NULL;
    return 0;
}

vor_status vor_store_report(struct vor_store *store, const struct vor_uuid *id, char **report,
                            struct vor_error *err)
{
    struct report read = {.text = NULL};
    vor_status status = vor_sql_query(store, take_report, &read, err,
                                      "SELECT report FROM job_end WHERE report IS NOT NULL"
                                      " AND seq = (SELECT seq FROM job WHERE id = ?)",
                                      "t", id->text);

    *report = read.text;
    return read.failed ? vor_fail(err, VOR_E_NOMEM, "the report of a job") : status;
}

struct listing {
    int (*each)(void *ctx, const struct vor_job_view *row);
    void *ctx;
};

static int list_row(void *ctx, struct vor_sql_row *statement)
{
    struct listing *listing = ctx;
    struct vor_job_view row;

    read_row(&row, statement);
    return listing->each(listing->ctx, &row);
}

/* Milliseconds that a started job has run; ?9 is now. */
#define DURATION "CASE finished WHEN 0 THEN ?9 ELSE finished END - started"

/* The rows of a list, found in an index alone. */
#define LIST(index, first)                                                                         \
    "SELECT " ROW_COLUMNS POSITION ROWS " WHERE job.seq IN (SELECT seq FROM job INDEXED BY " index \
    " WHERE expired = 0" first " AND (?1 = '' OR instr(?1, ',' || status || ',') > 0)"             \
    " AND (?2 IS NULL OR process_id = ?2) AND seq < ?3"                                            \
    " AND created >= ?5 AND (?6 = 0 OR created <= ?6)"                                             \
    " AND (?7 = 0 OR (started > 0 AND " DURATION " >= ?7))"                                        \
    " AND (?8 = 0 OR (started > 0 AND " DURATION " <= ?8))"                                        \
    " AND (?10 IS NULL OR name = ?10) AND (?11 IS NULL OR principal = ?11)"                        \
    " ORDER BY seq DESC LIMIT ?4) ORDER BY job.seq DESC"

vor_status vor_store_list(struct vor_store *store, const struct vor_job_filter *filter,
                          int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                          struct vor_error *err)
{
    struct listing listing = {.each = each, .ctx = ctx};
    char statuses[64] = "";
    size_t at = 0;

    for (int i = 0; i < VOR_JOB_STATUSES; i++) /* ",accepted,running," or, for all, "" */
        if (filter->statuses & (1u << i))
            at += (size_t)snprintf(statuses + at, sizeof statuses - at, "%s%s,", at == 0 ? "," : "",
                                   vor_job_status_word((enum vor_job_status)i));
    return vor_sql_query(store, list_row, &listing, err,
                         filter->name != NULL     ? LIST("job_named", " AND name = ?10")
                         : filter->tenant != NULL ? LIST("job_owned", " AND principal = ?11")
                                                  : LIST("job_listed", ""),
                         "ttiiiiiiitt", statuses, filter->process,
                         filter->before_seq > 0 ? filter->before_seq : INT64_MAX,
                         (int64_t)filter->limit, filter->created_from, filter->created_to,
                         filter->duration_min, filter->duration_max, filter->now, filter->name,
                         filter->tenant);
}

#define THIS " FROM job_text WHERE job_text.seq = job.seq"

vor_status vor_store_claim_next(struct vor_store *store, const struct vor_claim *claim,
                                struct vor_job_view *out, int *found, struct vor_error *err)
{
    int64_t memory = claim->memory > INT64_MAX ? INT64_MAX : (int64_t)claim->memory;
    struct taken taken = {.row = out};
    int64_t seq = 0;
    vor_status status = vor_sql_begin(store, VOR_SQL_LAZY, err);

    *found = 0;
    if (status != VOR_OK)
        return status;
    status = vor_sql_change_each(
        store, vor_sql_take_number, &seq, err,
        "UPDATE job SET status = 'running', attempt = attempt + 1, updated = max(updated, ?2),"
        " started = CASE started WHEN 0 THEN max(created, ?2) ELSE started END, owner = ?1"
        " WHERE seq = (SELECT seq FROM job INDEXED BY job_ready WHERE " WAITS
        " AND (SELECT release <= ?6 AND (engine = ?5 OR engine NOT IN"
        " (SELECT daemon.engine FROM daemon WHERE lease > clock_ms()))" THIS
        ") ORDER BY turn, seq LIMIT 1) AND (SELECT memory" THIS
        ") <= ?3 AND alone <= ?4 RETURNING seq",
        "tiiiti", claim->owner, claim->now_ms, memory, (int64_t)(claim->may_be_alone != 0),
        claim->build.engine, claim->build.release);
    if (status == VOR_OK && seq != 0)
        status =
            vor_sql_change_each(store, take_row, &taken, err,
                                "SELECT " ROW_COLUMNS ", -1" ROWS " WHERE job.seq = ?", "i", seq);
    if (status == VOR_OK && taken.found && out->attempt > 1) /* nobody reads the former one's */
        status =
            vor_sql_change(store, NULL, err, "DELETE FROM event WHERE seq = ?1 AND attempt < ?2",
                           "ii", seq, (int64_t)out->attempt);
    status = vor_sql_end(store, status, err);
    *found = status == VOR_OK && taken.found;
    return status;
}

vor_status vor_store_ledger(struct vor_store *store, const char *tenant, struct vor_ledger *ledger,
                            struct vor_error *err)
{
    ledger->jobs = ledger->bytes = 0;
    return vor_sql_query(store, take_ledger, ledger, err, SELECT_LEDGER, "t", tenant);
}
