/* What SQLite reads for a question, counted in pages of its cache: a row with a report and a trace
 * fills many, an index with many rows few. */
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <limits.h>
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>

enum { ROWS = 400, TRACE = 20000, REPORT = 3000, CONNECTIONS = 5 };

/* The writer and the readers of the store. */
static sqlite3 *connection[CONNECTIONS];
static int connections;
static int full_steps; /* rows that statements walked over for want of an index */
static int vm_steps;   /* instructions of SQLite's machine */

static int add_steps(unsigned event, void *ctx, void *statement, void *nanoseconds)
{
    (void)event, (void)ctx, (void)nanoseconds;
    full_steps += sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_FULLSCAN_STEP, 0);
    vm_steps += sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_VM_STEP, 1);
    return 0;
}

static int note(sqlite3 *db, const char **message, const struct sqlite3_api_routines *api)
{
    (void)message, (void)api;
    ck_assert_int_lt(connections, CONNECTIONS);
    connection[connections++] = db;
    return sqlite3_trace_v2(db, SQLITE_TRACE_PROFILE, add_steps, NULL);
}

/* Pages that the store has asked its caches for since the last time. */
static int pages(void)
{
    int sum = 0;

    for (int i = 0; i < connections; i++) {
        int hit = 0, missed = 0, highest;

        (void)sqlite3_db_status(connection[i], SQLITE_DBSTATUS_CACHE_HIT, &hit, &highest, 1);
        (void)sqlite3_db_status(connection[i], SQLITE_DBSTATUS_CACHE_MISS, &missed, &highest, 1);
        sum += hit + missed;
    }
    return sum;
}

static struct vor_store *open_store(const char *dir)
{
    union {
        int (*in)(sqlite3 *, const char **, const struct sqlite3_api_routines *);
        void (*out)(void);
    } entry = {.in = note};

    connections = 0;
    ck_assert_int_eq(sqlite3_auto_extension(entry.out), SQLITE_OK);
    return vt_dir_store_of(vor_store_driver_at(0), dir);
}

/* Inserts, claims and ends a job with a report and a trace. */
static struct vor_job_view fill(struct vor_store *store, const char *tenant, const char *name)
{
    static char report[REPORT + 1];
    static uint8_t trace[TRACE];
    const struct vor_store_ending ending = {report, {2, trace, TRACE}};
    const struct vor_event_piece piece = {1, trace, TRACE / 100};
    struct vor_job_view row = vt_row(10);
    int changed;

    memset(report, 'r', REPORT);
    (void)snprintf(row.key.principal, sizeof row.key.principal, "%s", tenant);
    (void)snprintf(row.key.text, sizeof row.key.text, "%s", row.id.text);
    (void)snprintf(row.name, sizeof row.name, "%s", name);
    row.kept = row.output[0].bytes = 1000;
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    row.attempt = vt_claim(store, &row.id);
    vt_assert_ok(
        vor_store_append_events(store, &row, VT_LEASE(row.attempt), &piece, &changed, &vt_err));
    row.status = VOR_JOB_SUCCESSFUL;
    row.finished = row.created + 1;
    row.expires = row.created + 1000000000;
    vt_assert_ok(vor_store_finish(store, &row, VT_LEASE(row.attempt), &ending, &changed, &vt_err));
    ck_assert(changed);
    return row;
}

static struct vor_store *open_filled(const char *dir)
{
    struct vor_store *store = open_store(dir);

    for (int i = 0; i < ROWS; i++)
        (void)fill(store, "alice", i % 2 ? "nightly" : "");
    (void)pages();
    full_steps = 0;
    return store;
}

static int count_row(void *ctx, VOR_UNUSED const struct vor_job_view *row)
{
    ++*(int *)ctx;
    return 1;
}

static int list(struct vor_store *store, const struct vor_job_filter *filter)
{
    int count = 0;

    vt_assert_ok(vor_store_list(store, filter, count_row, &count, &vt_err));
    return count;
}

VT_TEST(what_a_submit_and_a_run_ask_walks_over_no_rows)
{
    struct vor_store *store = open_filled(vt_dir_make());
    struct vor_job_view row = fill(store, "alice", "one"), back;
    struct vor_evicted one;
    struct vor_evictions evicted = {.job = &one, .max = 1};
    struct vor_ledger ledger;
    uint64_t requeued;
    int64_t newest;
    struct vor_waiting waiting;
    int found;

    ck_assert_int_le(pages(), 165); /* its rows, and the way down each index */
    vt_assert_ok(vor_store_find_key(store, &row.key, &back, &found, &vt_err));
    ck_assert(found);
    vt_assert_ok(vor_store_get(store, &row.id, "alice", &back, &found, &vt_err));
    ck_assert(found);
    vt_assert_ok(vor_store_waiting(store, &waiting, &vt_err));
    ck_assert_uint_eq(vt_claim(store, NULL), 0);
    vt_assert_ok(vor_store_newest(store, &newest, &vt_err));
    vt_assert_ok(vor_store_reap(store, "x", 1, row.created, &requeued, &vt_err));
    ck_assert_uint_eq(requeued, 0);
    ck_assert_int_le(pages(), 60);
    vt_assert_ok(vor_store_ledger(store, "alice", &ledger, &vt_err));
    ck_assert_uint_eq(ledger.bytes, (ROWS + 1) * (uint64_t)2000);
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_UPLOADS, INT64_MAX, &evicted, &vt_err));
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_RESULTS, INT64_MAX, &evicted, &vt_err));
    ck_assert_int_le(pages(), 10); /* however many jobs there are */
    ck_assert_int_eq(full_steps, 0);
    vm_steps = 0;
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_UPLOADS, ROWS * 1000, &evicted, &vt_err));
    ck_assert_uint_eq(evicted.count, 1);
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_RESULTS, ROWS * 1000, &evicted, &vt_err));
    ck_assert_uint_eq(evicted.count, 1);
    ck_assert_int_le(vm_steps, 3 * ROWS);
    vor_store_close(store);
}

/* Filters that no row passes, and where a walk over an index is allowed. */
VT_TEST(a_list_reads_the_rows_that_it_lists_alone)
{
    struct vor_store *store = open_filled(vt_dir_make());
    const struct vor_job_filter none[] = {{.limit = 100, .name = "nosuch"},
                                          {.limit = 100, .name = "nosuch", .tenant = "alice"},
                                          {.limit = 100, .tenant = "bob"},
                                          {.limit = 100, .name = "nightly", .tenant = "bob"},
                                          {.limit = 100, .name = "nightly", .process = "mesh"},
                                          {.limit = 100, .tenant = "alice", .process = "mesh"},
                                          {.limit = 100, .process = "mesh"},
                                          {.limit = 100, .statuses = 1u << VOR_JOB_FAILED},
                                          {.limit = 100, .created_from = INT64_MAX},
                                          {.limit = 100, .created_to = 1},
                                          {.limit = 100, .duration_min = INT64_MAX},
                                          {.limit = 100, .before_seq = 1}};

    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++) {
        ck_assert_int_eq(list(store, &none[i]), 0);
        ck_assert_msg(pages() <= ROWS / 10, "filter %zu", i);
    }
    vor_store_close(store);
}

/* By names, and in steps of 20 from the newest on: no step walks over the rows of those before, and
 * none reads a trace. */
VT_TEST_LOOP(a_list_in_steps_reads_each_row_once, 2)
{
    struct vor_store *store = open_filled(vt_dir_make());
    struct vor_job_filter filter = {.limit = 20, .name = _i ? "nightly" : NULL};
    int least = INT_MAX, most = 0, listed = 0;

    for (int64_t seq = ROWS + 1; seq > 20; seq -= _i ? 40 : 20) {
        int count;

        filter.before_seq = seq;
        listed += list(store, &filter);
        count = pages();
        least = count < least ? count : least;
        most = count > most ? count : most;
    }
    ck_assert_int_eq(listed, _i ? ROWS / 2 : ROWS);
    ck_assert_int_le(most, 20 * 6);
    ck_assert_int_le(most - least, 12);
    vor_store_close(store);
}

/* Every principal has a job in every round. */
VT_TEST(a_place_in_the_queue_takes_no_look_at_each_job_before_it)
{
    enum { TENANTS = 20 };
    struct vor_store *store = open_store(vt_dir_make());
    struct vor_job_view row, back;
    int found;

    for (int i = 0; i < ROWS; i++) {
        row = vt_row(10);
        (void)snprintf(row.key.principal, sizeof row.key.principal, "%d", i % TENANTS);
        vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    }
    vm_steps = 0;
    vt_assert_ok(vor_store_get(store, &row.id, NULL, &back, &found, &vt_err));
    ck_assert_int_eq(back.queue_position, ROWS - 1);
    ck_assert_int_le(vm_steps, 3 * ROWS);
    vor_store_close(store);
}
