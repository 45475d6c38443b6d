/* Who may open a store and what is none; and a disk that fails beneath an open one. */
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

VT_TEST(a_second_daemon_is_refused_with_the_holder_s_name)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = NULL, *second = NULL;
    char where[512], byte;
    int ready[2];
    long holder;
    pid_t child;

    (void)snprintf(where, sizeof where, "sqlite:%s/jobs.sqlite", dir);
    ck_assert_int_eq(pipe(ready), 0);
    child = fork();
    if (child == 0) {
        (void)vt_dir_store(dir);
        (void)!write(ready[1], "x", 1);
        for (;;)
            pause();
    }
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    vt_assert_fails(VOR_E_IO, vor_store_open(&second, where, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, child);
    ck_assert_ptr_null(second);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    vt_assert_ok(vor_store_open(&store, where, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    vor_store_close(store);
}

VT_TEST(what_is_no_store_is_refused)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = NULL;
    char where[512];
    FILE *file;
    long holder;

    (void)snprintf(where, sizeof where, "sqlite:%s/jobs.sqlite", dir);
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, where + 7, 0, &holder, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "store");
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, "sqlite:", 0, &holder, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, "sqlite:/dev/null/x", 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    file = fopen(where + 7, "w");
    for (int i = 0; i < 200; i++)
        fputs("this is a text, not a database\n", file);
    fclose(file);
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, where, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    ck_assert_ptr_null(store);
}

/* The version of a SQLite file's schema is the big-endian number at byte 60. */
VT_TEST_LOOP(a_store_of_another_version_is_refused_and_left_alone, 2)
{
    static const int versions[] = {12, 15};
    char wanted[80];
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    char where[512];
    FILE *file;
    long holder;

    vor_store_close(store); /* the last close moves everything from the WAL into the file */
    store = NULL;
    (void)snprintf(where, sizeof where, "sqlite:%s/jobs.sqlite", dir);
    file = fopen(where + 7, "r+");
    ck_assert_int_eq(fseek(file, 63, SEEK_SET), 0);
    ck_assert_int_eq(fgetc(file), 14);
    ck_assert_int_eq(fseek(file, 63, SEEK_SET), 0);
    ck_assert_int_eq(fputc(versions[_i], file), versions[_i]);
    fclose(file);
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, where, 0, &holder, &vt_err));
    (void)snprintf(wanted, sizeof wanted,
                   "schema %d, but this version reads only 6, 13 and 14: ", versions[_i]);
    ck_assert_ptr_nonnull(strstr(vt_err.message, wanted));
    ck_assert_ptr_null(store);
}

/* What steps 1 to 6 of the schema made, with a job that ended, one that waits, one that expired,
 * and numbers of acceptance given up to 9. */
static const char store_of_version_6[] =
    "CREATE TABLE job (seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE,"
    " process_id TEXT NOT NULL, status TEXT NOT NULL, progress INTEGER NOT NULL DEFAULT 0,"
    " message TEXT NOT NULL DEFAULT '', request TEXT NOT NULL, metrics TEXT, problem TEXT,"
    " report TEXT, trace BLOB, input_format INTEGER NOT NULL, input_points INTEGER NOT NULL,"
    " input_bytes INTEGER NOT NULL, input_sha256 TEXT NOT NULL, input_seconds REAL NOT NULL,"
    " output_format INTEGER NOT NULL DEFAULT 0, output_points INTEGER NOT NULL DEFAULT 0,"
    " output_bytes INTEGER NOT NULL DEFAULT 0, output_sha256 TEXT NOT NULL DEFAULT '',"
    " attempt INTEGER NOT NULL DEFAULT 0, crashes INTEGER NOT NULL DEFAULT 0,"
    " created INTEGER NOT NULL, started INTEGER NOT NULL DEFAULT 0, updated INTEGER NOT NULL,"
    " finished INTEGER NOT NULL DEFAULT 0, expires INTEGER NOT NULL DEFAULT 0,"
    " expired INTEGER NOT NULL DEFAULT 0, inputs TEXT, outputs TEXT, name TEXT NOT NULL DEFAULT '',"
    " principal TEXT NOT NULL DEFAULT '', idem_key TEXT, fingerprint TEXT NOT NULL DEFAULT '',"
    " kept INTEGER NOT NULL DEFAULT 0, alone INTEGER NOT NULL DEFAULT 0,"
    " kills INTEGER NOT NULL DEFAULT 0, traceparent TEXT NOT NULL DEFAULT '',"
    " held INTEGER NOT NULL DEFAULT 0);"
    "CREATE INDEX job_status ON job (status, seq) WHERE expired = 0;"
    "CREATE INDEX job_held ON job (finished, seq, held) WHERE held > 0;"
    "INSERT INTO job (seq, id, process_id, status, request, report, trace, input_format,"
    " input_points, input_bytes, input_sha256, input_seconds, created, updated, finished, expires,"
    " expired, principal, idem_key, kept, held) VALUES"
    " (3, '01908d7e-0000-7000-8000-000000000003', 'resample', 'successful', '{}', '{\"a\":1}',"
    "  x'5654523301000000AC0100001000000007', 0, 1, 2, 'a', 0, 5, 6, 7, 99, 0, 'alice', 'k', 100,"
    "  10),"
    " (4, '01908d7e-0000-7000-8000-000000000004', 'resample', 'accepted', '{}', NULL, NULL, 0, 1,"
    "  2, 'a', 0, 5, 6, 0, 0, 0, 'alice', NULL, 1000, 0),"
    " (5, '01908d7e-0000-7000-8000-000000000005', 'resample', 'failed', '{}', NULL, NULL, 0, 1, 2,"
    "  'a', 0, 5, 6, 7, 99, 1, 'alice', NULL, 0, 0);"
    "UPDATE sqlite_sequence SET seq = 9; PRAGMA user_version = 6;";

/* What version 14 has changed, taken back. */
static const char back_to_version_13[] =
    "CREATE TABLE wide AS SELECT *, 0 AS progress, NULL AS metrics FROM job JOIN job_text USING"
    " (seq) LEFT JOIN (SELECT seq, problem, report_bytes, output_format, output_points,"
    " output_bytes, output_sha256, outputs FROM job_end) USING (seq);"
    "CREATE TABLE job_blob AS SELECT seq, report FROM job_end; DROP TABLE job; DROP TABLE job_text;"
    "DROP TABLE job_end; DROP TABLE job_run; ALTER TABLE wide RENAME TO job;"
    "INSERT INTO sqlite_sequence VALUES ('job', 9); PRAGMA user_version = 13;";

static void run_sql(const char *path, const char *sql)
{
    sqlite3 *file;

    ck_assert_int_eq(sqlite3_open(path, &file), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(file, sql, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(file);
}

static int take_piece(void *ctx, const struct vor_event_piece *piece)
{
    *(struct vor_event_piece *)ctx = *piece; /* but for the bytes, which go */
    return 1;
}

VT_TEST(a_store_of_version_6_or_13_is_taken_with_its_jobs)
{
    const char *dir = vt_dir_make();
    struct vor_uuid id = {"01908d7e-0000-7000-8000-000000000003"};
    struct vor_job_view row, next = vt_row(10);
    struct vor_claim claim = {.owner = id.text, .now_ms = 1, .memory = UINT64_MAX / 4};
    struct vor_ledger ledger;
    struct vor_store *store;
    struct vor_event_piece piece;
    const struct vor_event_query query = {1, 427, take_piece, &piece};
    char path[512], *report;
    int found;

    (void)snprintf(path, sizeof path, "%s/jobs.sqlite", dir);
    for (int opening = 0; opening < 2; opening++) {
        run_sql(path, opening == 0 ? store_of_version_6 : back_to_version_13);
        store = vt_dir_store(dir);
        row = vt_stored(store, &id);
        ck_assert(row.seq == 3 && row.status == VOR_JOB_SUCCESSFUL && row.expires == 99);
        ck_assert_str_eq(row.key.text, "k");
        vt_assert_ok(vor_store_report(store, &id, &report, &vt_err));
        ck_assert_str_eq(report, "{\"a\":1}");
        free(report);
        piece.size = 0;
        vt_assert_ok(vor_store_events(store, &id, &query, &vt_err));
        ck_assert(piece.size == 17 && piece.last == 428);
        vt_assert_ok(vor_store_ledger(store, "alice", &ledger, &vt_err));
        ck_assert(ledger.jobs == 1 && ledger.bytes == 1110);
        if (opening == 1)
            vt_assert_ok(vor_store_insert(store, &next, NULL, &vt_err));
        /* What a job of before needs is not known: it runs with nothing beside it. */
        vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
        ck_assert_int_eq(found, opening);
        claim.memory = UINT64_MAX;
        vor_store_close(store);
    }
    ck_assert_int_eq(row.seq, 4);
    ck_assert_int_eq(next.seq, 10);
}

/* A disk that refuses a write (here: a limit on the size of files) puts the store out of order:
 * what it acknowledged stays readable, nothing new is taken. */
VT_TEST(a_store_whose_disk_failed_takes_no_more_and_says_so)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = vt_row(10), more = vt_row(10);
    struct rlimit limit;
    int is_lost;

    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = 4096;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    vt_assert_fails(VOR_E_IO, vor_store_insert(store, &more, NULL, &vt_err));
    limit.rlim_cur = limit.rlim_max;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    vt_assert_fails(VOR_E_IO, vor_store_insert(store, &more, NULL, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_store_check(store, &is_lost, &vt_err));
    ck_assert(is_lost);
    row = vt_stored(store, &row.id);
    vor_store_close(store);
    store = vt_dir_store(dir); /* only a restart helps, and it does */
    vt_assert_ok(vor_store_check(store, &is_lost, &vt_err));
    vt_assert_ok(vor_store_insert(store, &more, NULL, &vt_err));
    vor_store_close(store);
}
