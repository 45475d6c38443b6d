/* A store of commit fbe0eef, whose jobs had one input and one output: it opens with every job as it
 * was, and what waited in it is run. Schema and rows are those that this build wrote. */
#include "server/base/log.h"
#include "server/work/worker.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_serve.h"

#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char schema[] =
    "CREATE TABLE job ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, process_id TEXT NOT NULL,"
    " status TEXT NOT NULL"
    "  CHECK (status IN ('accepted','running','successful','failed','dismissed')),"
    " progress INTEGER NOT NULL DEFAULT 0, message TEXT NOT NULL DEFAULT '',"
    " request TEXT NOT NULL, metrics TEXT, problem TEXT, report TEXT, trace BLOB,"
    " input_format INTEGER NOT NULL, input_points INTEGER NOT NULL, input_bytes INTEGER NOT NULL,"
    " input_sha256 TEXT NOT NULL, input_seconds REAL NOT NULL,"
    " output_format INTEGER NOT NULL DEFAULT 0, output_points INTEGER NOT NULL DEFAULT 0,"
    " output_bytes INTEGER NOT NULL DEFAULT 0, output_sha256 TEXT NOT NULL DEFAULT '',"
    " attempt INTEGER NOT NULL DEFAULT 0, crashes INTEGER NOT NULL DEFAULT 0,"
    " created INTEGER NOT NULL, started INTEGER NOT NULL DEFAULT 0, updated INTEGER NOT NULL,"
    " finished INTEGER NOT NULL DEFAULT 0, expires INTEGER NOT NULL DEFAULT 0,"
    " expired INTEGER NOT NULL DEFAULT 0);"
    "CREATE INDEX job_status ON job (status, seq) WHERE expired = 0;"
    "CREATE INDEX job_expires ON job (expires) WHERE expires > 0;";

/* A job of 60 points that became 12, as it stood there but for the time when it expires. */
#define DONE "01a205a0-7083-7a3b-be48-6a0d96645902"
static const char done[] =
    "INSERT INTO job VALUES (1,'01a205a0-7083-7a3b-be48-6a0d96645902','resample','succe"
    "ssful',100,'12 points after 2 iterations and 10 polish steps, delta 0.0119','{\"poi"
    "nts\":12,\"method\":\"cvt\",\"patch\":\"quadric\",\"iterations\":2,\"neighbors\":\"auto\","
    "\"polish"
    "\":10,\"boundary\":\"keep\",\"outliers\":\"keep\",\"seed\":1,\"order\":\"spatial\",\"format\":"
    "\"ply\""
    ",\"quantization\":\"auto\",\"compression\":7,\"attributes\":\"nearest\",\"normals\":"
    "\"nearest\"}"
    "','{\"iteration\":2,\"polish\":10,\"delta\":0.011918892912570147,\"sigma\":0.0099770029385"
    "88463,\"epsilon\":0.9999289775628658,\"energy\":2.130676471305712,\"max_move\":0.0263709"
    "0425936386,\"held\":0,\"seconds\":0.023444535999260552}',NULL,'{\"points\":{\"in\":60,\"out"
    "\":12},\"delta\":0.011918892912570147,\"sigma\":0.009977002938588463,\"epsilon\":0.999928"
    "9775628658,\"iterations\":2,\"polish_steps\":10,\"stopped\":\"iterations\",\"seconds\":{\"rea"
    "d\":7.987899971340084e-05,\"index\":0.019853344999319233,\"init\":0.0010001820000979933"
    ",\"iterate\":0.0014076260004003416,\"polish\":0.0012465370000427356,\"write\":0.01217787"
    "1999483614},\"memory_peak_bytes\":430224,\"outliers\":0,\"lattice\":{\"x\":0,\"y\":0,\"z\":0,"
    "\""
    "moved\":0},\"in_to_out\":{\"mean\":0.3773638114177854,\"rms\":0.4060085870534375,\"max\":0."
    "6323059209482036,\"points\":60},\"out_to_in\":{\"mean\":0.2091558900909489,\"rms\":0.23448"
    "95734020291,\"max\":0.3889647747907835,\"points\":12},\"boundary_points\":0,\"neighbors_h"
    "istogram\":[{\"neighbors\":12,\"points\":4},{\"neighbors\":20,\"points\":8}],\"held\":0,\"held"
    "_ever\":0,\"fallbacks\":{\"plane\":0,\"left\":0},\"area\":11.80385012291357,\"spacing\":1.005"
    "0309697786968,\"min_over_mean\":0.9867846835214446,\"max_over_mean\":1.029285221973015"
    ",\"six_share\":0,\"bisectors_per_cell\":5.011904761904762,\"triangles_per_cell\":20.7142"
    "85714285715,\"queries\":47,\"list_rebuilds\":1,\"parameters\":{\"points\":12,\"method\":\"cvt"
    "\",\"patch\":\"quadric\",\"iterations\":2,\"neighbors\":20,\"polish\":10,\"boundary\":"
    "\"keep\",\"o"
    "utliers\":\"keep\",\"seed\":1,\"order\":\"spatial\",\"format\":\"ply\",\"quantization\":"
    "\"auto\",\"c"
    "ompression\":7,\"attributes\":\"nearest\",\"normals\":\"nearest\"}}',x'56545232010000000800"
    "0000010000008970a005a2010000010101009570a005a20100000101020aaa70a005a2010000020102"
    "0aaa70a005a201000000000000000000000000000000000000eb759d0362c6c53f565555d53b75bd3f"
    "546cfdb1f98bef3f000000000000000000000000000000000000045c3775953f02010210ac70a005a2"
    "01000001000000000000000000000000000000fa9d9823c90ab53f1bc7719cf7a4ad3fcf04fb5a77e4"
    "ef3f10238a719905034041b33d0b33eed33f000088ca38a6963f02010217ac70a005a2010000020000"
    "0000000000000000000000000043b2dcf17d9aa73f0200000005e9a13f2d52460c4ff7ef3ff0ea141b"
    "a00b014095b753a40dc2cd3f0000bca179cb963f0201025aad70a005a2010000020000000a00000000"
    "00000000000000e1b31cbaee68883facaaaaaad26e843f37911e0e6bffef3ff0ea141ba00b0140878d"
    "706df9009b3f00008c2dd801983f0101035fad70a005a2010000',0,60,1805,'717073f3259393c94"
    "ee2f58efbb3accc392cfbe6805020667f006452d349f2d4',7.987899971340084e-05,0,12,288,'3"
    "3b7b8bb82722ff729172fda9a439d45074cd671afcc1fb51c3fda9df738b7d0',1,0,1795390730377"
    ",1795390730386,1795390730426,1795390730426,9999999999999,0);";

/* One that failed. */
#define FAILED "01a205a0-70d8-7dee-9f3d-8f7140d2dbc5"
static const char failed[] =
    "INSERT INTO job VALUES (2,'01a205a0-70d8-7dee-9f3d-8f7140d2dbc5','resample','faile"
    "d',0,'spacing is 100 and asks for 0 points, want 1 to 960: resample gives up to 16"
    " for each of the input''s 60','{\"spacing\":100,\"method\":\"cvt\",\"patch\":\"quadric\",\"it"
    "erations\":2,\"neighbors\":\"auto\",\"polish\":10,\"boundary\":\"keep\",\"outliers\":\"keep\","
    "\"se"
    "ed\":1,\"order\":\"spatial\",\"format\":\"ply\",\"quantization\":\"auto\",\"compression\":7,"
    "\"attr"
    "ibutes\":\"nearest\",\"normals\":\"nearest\"}',NULL,'{\"status\":\"target-out-of-range\",\"par"
    "ameter\":\"spacing\",\"message\":\"spacing is 100 and asks for 0 points, want 1 to 960: "
    "resample gives up to 16 for each of the input''s 60\",\"byteOffset\":-1,\"limit\":0,\"go"
    "t\":0}',NULL,x'56545232010000000200000001000000e270a005a201000001010100f170a005a201"
    "0000',0,60,1805,'717073f3259393c94ee2f58efbb3accc392cfbe6805020667f006452d349f2d4'"
    ",0.00010824099990713876,0,0,0,'',1,0,1795390730466,1795390730474,1795390730489,179"
    "5390730489,9999999999999,0);";

/* One that waits, or runs when its daemon dies: id, status, attempts. */
static const char under_way[] =
    "INSERT INTO job (id, process_id, status, request, input_format, input_points, input_bytes,"
    " input_sha256, input_seconds, attempt, created, updated) VALUES ('%s', 'resample', '%s',"
    " '{\"points\":50,\"iterations\":2,\"polish\":0,\"format\":\"ply\"}', 0, 300, 4000, 'ab', 0.5,"
    " %d, 1795390730377, 1795390730377);";

struct old {
    const char *dir;
    sqlite3 *db;
};

static void run(struct old *old, const char *sql)
{
    char *error = NULL;

    ck_assert_msg(sqlite3_exec(old->db, sql, NULL, NULL, &error) == SQLITE_OK, "%s", error);
}

static struct old begin(void)
{
    struct old old = {.dir = vt_dir_make()};
    char path[512];

    (void)snprintf(path, sizeof path, "%s/jobs.sqlite", old.dir);
    ck_assert_int_eq(sqlite3_open(path, &old.db), SQLITE_OK);
    run(&old, "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;");
    run(&old, schema);
    run(&old, "PRAGMA user_version=1;");
    return old;
}

/* Writes a file among the blobs. */
static void keep(const struct old *old, const char *file, const char *bytes)
{
    char path[512];
    FILE *out;

    vor_blobs_close(vt_dir_blobs(old->dir)); /* makes the directory */
    (void)snprintf(path, sizeof path, "%s/blobs/keep/%s", old->dir, file);
    out = fopen(path, "w");
    ck_assert_ptr_nonnull(out);
    fputs(bytes, out);
    fclose(out);
}

static void end(struct old *old)
{
    ck_assert_int_eq(sqlite3_close(old->db), SQLITE_OK);
}

/* A number that a query gives, from outside. */
static int number(const char *dir, const char *sql)
{
    sqlite3_stmt *statement = NULL;
    sqlite3 *db = NULL;
    char path[512];
    int value;

    (void)snprintf(path, sizeof path, "%s/jobs.sqlite", dir);
    ck_assert_int_eq(sqlite3_open(path, &db), SQLITE_OK);
    ck_assert_int_eq(sqlite3_prepare_v2(db, sql, -1, &statement, NULL), SQLITE_OK);
    ck_assert_int_eq(sqlite3_step(statement), SQLITE_ROW);
    value = sqlite3_column_int(statement, 0);
    sqlite3_finalize(statement);
    sqlite3_close(db);
    return value;
}

static struct vor_uuid id_of(const char *text)
{
    struct vor_uuid id;

    ck_assert(vor_uuid_parse(&id, text, strlen(text)));
    return id;
}

/* An input as that build kept it; its job's row is added in the status that is given. */
static struct vor_uuid leave(struct old *old, const char *status, int attempt)
{
    struct vor_blobs *blobs = vt_dir_blobs(old->dir);
    struct vor_admitted admitted = {.count = 0};
    struct vor_cloud cloud;
    char sql[1024];

    vt_cloud_sphere(&cloud, 1, 300);
    vt_admit(&admitted, blobs, "cloud", &cloud);
    (void)snprintf(sql, sizeof sql, "%s/blobs/keep/%s.input", old->dir, admitted.id.text);
    ck_assert_int_eq(access(sql, R_OK), 0);
    (void)snprintf(sql, sizeof sql, under_way, admitted.id.text, status, attempt);
    run(old, sql);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
    return admitted.id;
}

static void expect_report(struct vt_daemon *daemon, const struct vor_uuid *id)
{
    char *report;

    vt_assert_ok(vor_worker_report(daemon->worker, id, &report, &vt_err));
    ck_assert_ptr_nonnull(report);
    ck_assert_ptr_nonnull(strstr(done, report)); /* to the letter: it holds no quote of SQL's */
    ck_assert_uint_eq(strlen(report), vt_daemon_get(daemon, id).output[1].bytes);
    free(report);
}

static void expect_trace(struct vt_daemon *daemon, const struct vor_uuid *id)
{
    static const unsigned polished[] = {0, 0, 0, 10};
    struct vor_position position = {0, 0};
    struct vor_event event;
    struct vor_bus *bus;
    unsigned records = 0;
    double seconds = 0;

    ck_assert_int_eq(vor_worker_events(daemon->worker, id, &bus, &vt_err), VOR_DONE);
    while (vor_bus_read(bus, &position, VOR_READ_EVERY, &event, 1) == 1) {
        if (event.kind != VOR_EVENT_PROGRESS)
            continue;
        ck_assert_uint_lt(records, 4);
        ck_assert_uint_eq(event.record.polish, polished[records]);
        records++;
        seconds = event.record.seconds;
    }
    ck_assert_uint_eq(records, 4);
    ck_assert_double_eq(seconds, 0.023444535999260552);
    ck_assert_int_eq(event.kind, VOR_EVENT_END);
    vor_bus_release(bus);
}

START_TEST(every_job_is_there_with_report_trace_and_result)
{
    struct vor_uuid id = id_of(DONE), other = id_of(FAILED);
    struct old old = begin();
    struct vt_daemon daemon;
    struct vor_job_view view;
    uint8_t *bytes;
    size_t size;

    run(&old, done);
    run(&old, failed);
    keep(&old, DONE ".cloud", "the cloud");
    end(&old);
    vt_daemon_start(&daemon, old.dir, NULL);
    view = vt_daemon_get(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_SUCCESSFUL);
    ck_assert_str_eq(view.message,
                     "12 points after 2 iterations and 10 polish steps, delta 0.0119");
    ck_assert_uint_eq(view.inputs, 1);
    ck_assert_uint_eq(view.input[0].points, 60);
    ck_assert_uint_eq(view.output[0].points, 12);
    ck_assert_uint_eq(view.output[0].bytes, 288);
    ck_assert_int_eq(strncmp(view.output[0].sha256, "33b7b8bb", 8), 0);
    ck_assert(!view.request_lost);
    ck_assert_str_eq(view.name, "");
    ck_assert_str_eq(view.key.text, "");
    ck_assert_uint_eq(view.kept, 0);
    ck_assert_uint_eq(view.record.iteration, 2);
    expect_report(&daemon, &id);
    expect_trace(&daemon, &id);
    bytes = vt_daemon_result(&daemon, &id, &size);
    ck_assert_str_eq((char *)bytes, "the cloud");
    view = vt_daemon_get(&daemon, &other);
    ck_assert_int_eq(view.problem.status, VOR_E_TARGET);
    ck_assert_str_eq(view.problem.parameter, "spacing");
    free(bytes);
    vt_daemon_stop(&daemon);
    ck_assert_int_eq(number(old.dir, "PRAGMA user_version"), 6);
    ck_assert_int_eq(number(old.dir, "SELECT held FROM job WHERE seq = 1"), 288);
    ck_assert_int_eq(number(old.dir, "SELECT count(*) FROM job WHERE inputs IS NULL"), 2);
    vt_dir_remove(old.dir);
}
END_TEST

START_TEST(its_results_are_downloaded)
{
    static const struct {
        const char *path, *type, *holds;
    } cases[] = {
        {"/results/cloud", "Content-Type: application/ply", "\r\n\r\nthe cloud"},
        {"/results/cloud", "ETag: \"51c1d66e5b5d052e71457ea002b13b57", "filename=\"" DONE ".ply\""},
        {"/results/report", "Content-Type: application/json", "\r\n\r\n{\"points\":{\"in\":60,"},
        {"/results", "Content-Type: application/json",
         "/results/cloud\",\"type\":\"application/ply"},
        {"", "Content-Type: application/json", "\"title\":\"cloud\""},
        {"/trace", "Content-Type: application/json", "\"polish\":10"},
    };
    struct old old = begin();
    struct vt_serve serve;
    char line[256];
    const char *text;

    run(&old, done);
    run(&old, "UPDATE job SET output_sha256 ="
              " '51c1d66e5b5d052e71457ea002b13b57af45e639e35092b4874e0591b30f05d4'");
    keep(&old, DONE ".cloud", "the cloud");
    end(&old);
    vt_serve_start(&serve, old.dir);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        (void)snprintf(line, sizeof line, "GET /v1/jobs/" DONE "%s", cases[i].path);
        ck_assert_int_eq(vt_serve_call(&serve, line, "", &text), 200);
        ck_assert_msg(strstr(text, cases[i].type) != NULL, "%s: %s", cases[i].path, text);
        ck_assert_msg(strstr(text, cases[i].holds) != NULL, "%s: %s", cases[i].path, text);
    }
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
    vt_dir_remove(old.dir);
}
END_TEST

START_TEST(what_waited_or_ran_is_run_to_its_end)
{
    struct old old = begin();
    struct vor_uuid waits = leave(&old, "accepted", 0), runs = leave(&old, "running", 1);
    struct vt_daemon daemon;
    struct vor_job_view view;
    size_t size;

    end(&old);
    vt_daemon_start(&daemon, old.dir, NULL);
    view = vt_daemon_wait_over(&daemon, &waits);
    ck_assert_msg(view.status == VOR_JOB_SUCCESSFUL, "%s", view.message);
    ck_assert_uint_eq(view.output[0].points, 50);
    view = vt_daemon_wait_over(&daemon, &runs);
    ck_assert_msg(view.status == VOR_JOB_SUCCESSFUL, "%s", view.message);
    ck_assert_uint_eq(view.attempt, 2);
    free(vt_daemon_result(&daemon, &runs, &size));
    ck_assert_uint_eq(size, view.output[0].bytes);
    vt_daemon_stop(&daemon);
    ck_assert_int_eq(vt_dir_count(old.dir, "blobs/keep"), 2);
    vt_dir_remove(old.dir);
}
END_TEST

START_TEST(its_jobs_are_removed_and_expire_with_their_bytes)
{
    struct vor_uuid id = id_of(DONE);
    struct timespec pause = {.tv_nsec = 1000000};
    struct old old = begin();
    struct vt_daemon daemon;

    run(&old, done);
    if (_i == 1) /* not forgotten; of a daemon that ran until now */
        run(&old, "UPDATE job SET expires = 2, finished = -9000000000000000,"
                  " updated = CAST(strftime('%s', 'now') AS INTEGER) * 1000;");
    keep(&old, DONE ".cloud", "the cloud");
    end(&old);
    vt_daemon_start(&daemon, old.dir, NULL);
    if (_i == 0)
        ck_assert_int_eq(vor_worker_dismiss(daemon.worker, &id, "", NULL, &vt_err), VOR_DONE);
    while (vt_dir_count(old.dir, "blobs/keep") > 0) /* expiry is the sweeper's work */
        nanosleep(&pause, NULL);
    vt_daemon_stop(&daemon);
    vt_dir_remove(old.dir);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("store_old");

    vor_log_open(2, VOR_LOG_ERROR);
    vt_add(suite, every_job_is_there_with_report_trace_and_result);
    vt_add(suite, its_results_are_downloaded);
    vt_add(suite, what_waited_or_ran_is_run_to_its_end);
    vt_add_loop(suite, its_jobs_are_removed_and_expire_with_their_bytes, 2);
    return vt_run(suite);
}
