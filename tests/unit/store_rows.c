/* The store: a row comes back as it went in, changes happen once, and a kill loses nothing. */
#include "server/base/clock.h"
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* --- helpers ---------------------------------------------------------------------------------- */

static struct vor_job_view insert(struct vor_store *store, unsigned points)
{
    struct vor_job_view row = vt_row(points);

    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    return row;
}

static int finish(struct vor_store *store, struct vor_job_view row, enum vor_job_status status,
                  uint32_t attempt)
{
    int changed;

    row.status = status;
    row.finished = vor_clock_wall_ms();
    row.expires = row.finished + 1000;
    vt_assert_ok(vor_store_finish(store, &row, attempt > 0 ? VT_LEASE(attempt) : NULL, NULL,
                                  &changed, &vt_err));
    return changed;
}

static int release(struct vor_store *store, const struct vor_uuid *id, uint32_t attempt)
{
    struct vor_hand_back back = {.lease = *VT_LEASE(attempt), .now_ms = 1};

    vt_assert_ok(vor_store_hand_back(store, id, &back, &vt_err));
    return back.changed;
}

static int remove_row(struct vor_store *store, const struct vor_uuid *id)
{
    int changed;

    vt_assert_ok(vor_store_remove(store, id, &changed, &vt_err));
    return changed;
}

VT_TEST(a_row_comes_back_as_it_was_inserted)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = vt_row(4321), back;

    row.input[0] = (struct vor_job_input){
        .format = 1, .points = 812344, .bytes = UINT64_C(1) << 40, .seconds = 0.1};
    memset(row.input[0].sha256, 'a', 64);
    vt_assert_ok(vor_spec_set(&row.spec, "neighbors", "auto", &vt_err));
    vt_assert_ok(vor_spec_set(&row.spec, "boundary", "free", &vt_err));
    vt_assert_ok(vor_spec_set(&row.spec, "delta", "0.07", &vt_err));
    vt_assert_ok(vor_spec_set(&row.spec, "format", "drc", &vt_err));
    vt_assert_ok(vor_spec_set(&row.spec, "seed", "9007199254740991", &vt_err));
    ck_assert(vor_span_parse(&row.span, "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"));
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    ck_assert_int_eq(row.seq, 1);
    vor_store_close(store);

    store = vt_dir_store(dir);
    back = vt_stored(store, &row.id);
    ck_assert_int_eq(back.status, VOR_JOB_ACCEPTED);
    ck_assert_int_eq(back.stage, VOR_STAGE_QUEUED);
    ck_assert_int_eq(back.seq, 1);
    ck_assert_str_eq(back.process, "resample");
    ck_assert_str_eq(back.span.trace, row.span.trace);
    ck_assert_str_eq(back.span.id, row.span.id);
    ck_assert_str_eq(back.span.flags, row.span.flags);
    ck_assert_mem_eq(&back.spec, &row.spec, sizeof row.spec);
    ck_assert_uint_eq(back.input[0].format, 1);
    ck_assert_uint_eq(back.input[0].points, 812344);
    ck_assert_uint_eq(back.input[0].bytes, UINT64_C(1) << 40);
    ck_assert_double_eq(back.input[0].seconds, 0.1);
    ck_assert_str_eq(back.input[0].sha256, row.input[0].sha256);
    ck_assert_uint_eq(back.attempt, 1);
    ck_assert_int_eq(back.created, row.created);
    ck_assert_int_eq(back.started, 0);
    ck_assert_int_eq(back.has_record, 0);
    ck_assert_int_eq(back.problem.status, VOR_OK);
    vor_store_close(store);
}

VT_TEST_LOOP(a_request_comes_back_with_its_process_and_what_that_allows, 4)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    struct vor_job_view row = vt_row(50), back;

    vor_spec_preset(&row.spec, process);
    vt_assert_ok(vor_spec_set(&row.spec, "ratio", "1", &vt_err));
    vt_assert_ok(vor_spec_set(&row.spec, "outliers", _i % 2 ? "keep" : "drop", &vt_err));
    (void)snprintf(row.process, sizeof row.process, "%s", process->id);
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    back = vt_stored(store, &row.id);
    ck_assert_str_eq(back.process, process->id);
    ck_assert_mem_eq(&back.spec, &row.spec, sizeof row.spec);
    vor_store_close(store);
}

VT_TEST(inputs_beside_the_main_one_come_back)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = vt_row(10), back;

    vor_spec_preset(&row.spec, vor_process_find("measure"));
    strcpy(row.process, "measure");
    row.inputs = 3;
    row.input[1] = (struct vor_job_input){
        .format = 1, .points = 17, .bytes = UINT64_C(1) << 40, .seconds = 0.1};
    memset(row.input[1].sha256, 'b', 64);
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    back = vt_stored(store, &row.id);
    ck_assert_uint_eq(back.inputs, 3);
    for (unsigned i = 0; i < VOR_INPUTS_MAX; i++) {
        ck_assert_uint_eq(back.input[i].format, row.input[i].format);
        ck_assert_uint_eq(back.input[i].points, row.input[i].points);
        ck_assert_uint_eq(back.input[i].bytes, row.input[i].bytes);
        ck_assert_str_eq(back.input[i].sha256, row.input[i].sha256);
        ck_assert_double_eq(back.input[i].seconds, row.input[i].seconds);
    }
    ck_assert(finish(store, row, VOR_JOB_SUCCESSFUL, 0));
    ck_assert_uint_eq(vt_stored(store, &row.id).inputs, 3);
    vor_store_close(store);
}

VT_TEST(a_successful_end_comes_back_with_report_events_and_record)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = insert(store, 10), back;
    struct vor_store_ending ending = {"{\"delta\":0.07}", {7, (const uint8_t *)"\0e", 2}};
    char *report, events[16] = "";
    int changed;

    row.status = VOR_JOB_SUCCESSFUL;
    row.attempt = vt_claim(store, &row.id);
    row.progress = 100;
    row.has_record = 1;
    row.record = (struct vor_record){.iteration = 42,
                                     .polish = 30,
                                     .delta = 0.07,
                                     .sigma = 1e-300,
                                     .epsilon = 0.999,
                                     .energy = 1e300,
                                     .max_move = 0.1 + 0.2,
                                     .held = 7,
                                     .seconds = 3.5,
                                     .stage = VOR_RUN_STAGE_POLISH,
                                     .step = 30,
                                     .of = 100,
                                     .ahead = 7,
                                     .best_iteration = 41,
                                     .best_polish = 20,
                                     .best_delta = 0.06,
                                     .best_sigma = 1e-301,
                                     .best_epsilon = 0.9995};
    row.output[0] = (struct vor_job_output){.format = 1, .points = 10, .bytes = 99};
    strcpy(row.output[0].sha256, "beef");
    strcpy(row.message, "10 points");
    row.finished = 7000;
    row.expires = 8000;
    vt_assert_ok(vor_store_finish(store, &row, VT_LEASE(1), &ending, &changed, &vt_err));
    ck_assert_int_eq(changed, 1);
    back = vt_stored(store, &row.id);
    ck_assert_int_eq(back.status, VOR_JOB_SUCCESSFUL);
    ck_assert_int_eq(back.progress, 100);
    ck_assert_int_eq(back.stage, VOR_STAGE_ENCODE);
    ck_assert_mem_eq(&back.record, &row.record, sizeof row.record);
    ck_assert_uint_eq(back.output[0].format, 1);
    ck_assert_uint_eq(back.output[0].points, 10);
    ck_assert_uint_eq(back.output[0].bytes, 99);
    ck_assert_str_eq(back.output[0].sha256, "beef");
    ck_assert_uint_eq(back.output[1].bytes, strlen(ending.report)); /* of resample: the report */
    ck_assert_str_eq(back.message, "10 points");
    ck_assert_int_eq(back.finished, 7000);
    ck_assert_int_eq(back.expires, 8000);
    vt_assert_ok(vor_store_report(store, &row.id, &report, &vt_err));
    ck_assert_str_eq(report, ending.report);
    vt_events(store, &row.id, 1, 0, events);
    ck_assert_str_eq(events, "7:0e ");
    free(report);
    vor_store_close(store);
}

VT_TEST(a_failure_comes_back_with_its_problem)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = insert(store, 10), back;
    char *report;

    for (int status = 1; status < VOR_STATUS_COUNT; status++) {
        row = insert(store, 10);
        (void)vor_fail_param(&row.problem, (vor_status)status, "points", "a \"quoted\" %s",
                             "\x01 reason");
        row.problem.byte_offset = 77;
        row.problem.limit = 1000;
        row.problem.got = 2000;
        ck_assert(finish(store, row, VOR_JOB_FAILED, 0));
        back = vt_stored(store, &row.id);
        ck_assert_mem_eq(&back.problem, &row.problem, sizeof row.problem);
    }
    vt_assert_ok(vor_store_report(store, &row.id, &report, &vt_err));
    ck_assert_ptr_null(report);
    vor_store_close(store);
}

VT_TEST(only_the_running_attempt_may_end_append_or_release)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = insert(store, 10);

    ck_assert(!finish(store, row, VOR_JOB_SUCCESSFUL, 1)); /* still waits */
    ck_assert_uint_eq(vt_claim(store, &row.id), 1);
    ck_assert(release(store, &row.id, 1));
    ck_assert_uint_eq(vt_stored(store, &row.id).attempt, 2); /* the next one */
    ck_assert_uint_eq(vt_claim(store, &row.id), 2);
    ck_assert(!release(store, &row.id, 1));
    ck_assert(!finish(store, row, VOR_JOB_SUCCESSFUL, 1));
    ck_assert(!vt_append(store, row, 50, VT_LEASE(1), 1));
    ck_assert_int_eq(vt_stored(store, &row.id).progress, 0);
    ck_assert(vt_append(store, row, 50, VT_LEASE(2), 1));
    ck_assert_int_eq(vt_stored(store, &row.id).progress, 50);
    for (int again = 0; again < 2; again++) /* the answer to the first was lost */
        ck_assert(vt_append(store, row, 20, VT_LEASE(2), 2));
    ck_assert_int_eq(vt_stored(store, &row.id).progress, 50); /* never falls */
    row.attempt = 2;
    ck_assert(finish(store, row, VOR_JOB_SUCCESSFUL, 2));
    vor_store_close(store);
}

/* --- lists ------------------------------------------------------------------------------------ */

struct seen {
    int64_t seqs[64];
    size_t count, stop_after;
};

static int see(void *ctx, const struct vor_job_view *row)
{
    struct seen *seen = ctx;

    seen->seqs[seen->count++] = row->seq;
    return seen->count != seen->stop_after;
}

static struct seen list(struct vor_store *store, struct vor_job_filter filter, size_t stop_after)
{
    struct seen seen = {.stop_after = stop_after};

    vt_assert_ok(vor_store_list(store, &filter, see, &seen, &vt_err));
    return seen;
}

/* Rows of that status. */
static size_t count(struct vor_store *store, enum vor_job_status status)
{
    return list(store, (struct vor_job_filter){.limit = 64, .statuses = 1u << status}, 0).count;
}

VT_TEST(a_list_is_newest_first_filtered_and_continued_by_its_cursor)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view rows[10];
    struct seen seen;

    for (int i = 0; i < 10; i++)
        rows[i] = insert(store, 10);
    for (int i = 0; i < 6; i++)
        (void)vt_claim(store, &rows[i].id);
    for (int i = 0; i < 5; i++)
        ck_assert(i == 2 || release(store, &rows[i].id, 1));
    ck_assert(finish(store, rows[5], VOR_JOB_FAILED, 1));

    seen = list(store, (struct vor_job_filter){.limit = 3}, 0);
    ck_assert_uint_eq(seen.count, 3);
    ck_assert_int_eq(seen.seqs[0], 10);
    ck_assert_int_eq(seen.seqs[2], 8);
    seen = list(store, (struct vor_job_filter){.limit = 3, .before_seq = 8}, 0);
    ck_assert_int_eq(seen.seqs[0], 7);
    seen = list(store, (struct vor_job_filter){.limit = 64}, 4);
    ck_assert_uint_eq(seen.count, 4);
    seen = list(store,
                (struct vor_job_filter){.limit = 64,
                                        .statuses = 1u << VOR_JOB_RUNNING | 1u << VOR_JOB_FAILED},
                0);
    ck_assert_uint_eq(seen.count, 2);
    ck_assert_int_eq(seen.seqs[0], 6);
    ck_assert_int_eq(seen.seqs[1], 3);
    seen = list(store, (struct vor_job_filter){.limit = 64, .process = "resample"}, 0);
    ck_assert_uint_eq(seen.count, 10);
    seen = list(store, (struct vor_job_filter){.limit = 64, .process = "' OR 1=1 --"}, 0);
    ck_assert_uint_eq(seen.count, 0);
    vor_store_close(store);
}

/* --- time ------------------------------------------------------------------------------------- */

VT_TEST(results_expire_then_are_forgotten)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view rows[3], back;
    struct vor_store_ending ending = {"{}", {1, (const uint8_t *)"e", 1}};
    struct vor_evicted expired[2];
    struct vor_evictions evictions = {.job = expired, .max = 2};
    char *report, events[16];
    int changed, found;

    for (int i = 2; i >= 0; i--) {
        rows[i] = insert(store, 10);
        rows[i].status = VOR_JOB_SUCCESSFUL;
        rows[i].finished = 1000;
        rows[i].expires = 2000 + i;
        vt_assert_ok(vor_store_finish(store, &rows[i], NULL, &ending, &changed, &vt_err));
    }
    (void)insert(store, 10); /* waits: never expires */
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 1999, &evictions, &vt_err));
    ck_assert_uint_eq(evictions.count, 0);
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 2002, &evictions, &vt_err));
    ck_assert_uint_eq(evictions.count, 2);
    for (int i = 0; i < 2; i++) /* the first two, in any order */
        ck_assert(strcmp(expired[0].id.text, rows[i].id.text) == 0 ||
                  strcmp(expired[1].id.text, rows[i].id.text) == 0);
    ck_assert_str_eq(expired[0].process, "resample");
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 2002, &evictions, &vt_err));
    ck_assert_uint_eq(evictions.count, 1);
    back = vt_stored(store, &rows[0].id);
    ck_assert(back.expired);
    vt_assert_ok(vor_store_report(store, &rows[0].id, &report, &vt_err));
    ck_assert_ptr_null(report);
    vt_events(store, &rows[0].id, 1, 0, events);
    ck_assert_str_eq(events, "");
    ck_assert_uint_eq(list(store, (struct vor_job_filter){.limit = 9}, 0).count, 1);
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 3000, &evictions, &vt_err));
    vt_assert_ok(vor_store_get(store, &rows[0].id, NULL, &back, &found, &vt_err));
    ck_assert(!found);
    back = vt_stored(store, &rows[1].id); /* its second life is two milliseconds longer */
    vor_store_close(store);
}

/* More of them than a statement changes at once. */
VT_TEST(many_results_expire_later_and_are_forgotten)
{
    enum { JOBS = 502 };
    struct vor_store *store = vt_dir_store(vt_dir_make());
    static struct vor_evicted expired[JOBS + 1];
    struct vor_evictions evictions = {.job = expired, .max = JOBS + 1};
    struct vor_job_view row, back;
    int changed, found;

    for (int i = 0; i < JOBS; i++) {
        row = insert(store, 10);
        row.status = VOR_JOB_FAILED;
        row.finished = 1000;
        row.expires = 2000;
        vt_assert_ok(vor_store_finish(store, &row, NULL, NULL, &changed, &vt_err));
    }
    vt_assert_ok(vor_store_shift(store, 500, &vt_err));
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 2499, &evictions, &vt_err));
    ck_assert_uint_eq(evictions.count, 0);
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 2500, &evictions, &vt_err));
    ck_assert_uint_eq(evictions.count, JOBS);
    vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, 4000, &evictions, &vt_err));
    vt_assert_ok(vor_store_get(store, &row.id, NULL, &back, &found, &vt_err));
    ck_assert(!found);
    vor_store_close(store);
}

/* The process of one run, and not the daemon. */
VT_TEST(a_run_that_crashed_is_put_back_to_run_alone_and_counted_if_it_was)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view runs = insert(store, 10);
    struct vor_hand_back crashed = {.lease = *VT_LEASE(1), .now_ms = 77, .is_crash = 1};

    vt_assert_ok(vor_store_hand_back(store, &runs.id, &crashed, &vt_err));
    ck_assert(!crashed.changed); /* it does not run */
    for (uint32_t attempt = 1; attempt <= 3; attempt++) {
        ck_assert_uint_eq(vt_claim(store, &runs.id), attempt);
        crashed =
            (struct vor_hand_back){.lease = *VT_LEASE(attempt + 1), .now_ms = 77, .is_crash = 1};
        vt_assert_ok(vor_store_hand_back(store, &runs.id, &crashed, &vt_err));
        ck_assert(!crashed.changed); /* another attempt */
        crashed.lease.attempt = attempt;
        crashed.was_alone = attempt > 1;
        vt_assert_ok(vor_store_hand_back(store, &runs.id, &crashed, &vt_err));
        ck_assert(crashed.changed);
        ck_assert_uint_eq(crashed.crashes, attempt - 1);
        ck_assert_int_eq(vt_stored(store, &runs.id).status, VOR_JOB_ACCEPTED);
        ck_assert(vt_stored(store, &runs.id).alone);
        ck_assert_int_eq(vt_stored(store, &runs.id).updated, 77);
    }
    ck_assert_uint_eq(vt_claim(store, &runs.id), 4);
    crashed.lease.attempt = 4;
    crashed.most = 3; /* nobody claims it before its caller has finished it */
    vt_assert_ok(vor_store_hand_back(store, &runs.id, &crashed, &vt_err));
    ck_assert(crashed.changed && crashed.is_over);
    ck_assert_uint_eq(crashed.crashes, 3);
    ck_assert_int_eq(vt_stored(store, &runs.id).status, VOR_JOB_RUNNING);
    vor_store_close(store);
}

/* --- kills ------------------------------------------------------------------------------------ */

enum kill_point { AFTER_INSERT, AFTER_CLAIM, AFTER_FINISH, AFTER_REMOVE, KILL_POINTS };

struct killed {
    const char *dir;
    enum kill_point point;
    struct vor_job_view row;
};

static void act_until_killed(void *ctx)
{
    struct killed *killed = ctx;
    struct vor_store *store = vt_dir_store(killed->dir);

    vt_assert_ok(vor_store_insert(store, &killed->row, NULL, &vt_err));
    if (killed->point >= AFTER_CLAIM)
        (void)vt_claim(store, &killed->row.id);
    if (killed->point >= AFTER_FINISH)
        (void)finish(store, killed->row, VOR_JOB_SUCCESSFUL, 1);
    if (killed->point >= AFTER_REMOVE)
        (void)remove_row(store, &killed->row.id);
    raise(SIGKILL);
}

VT_TEST_LOOP(what_was_answered_before_a_kill_is_there_after_it, KILL_POINTS)
{
    struct killed killed = {.dir = vt_dir_make(), .point = (enum kill_point)_i, .row = vt_row(7)};
    const enum vor_job_status expected[] = {VOR_JOB_ACCEPTED, VOR_JOB_RUNNING, VOR_JOB_SUCCESSFUL};
    struct vor_store *store;
    struct vor_job_view row;
    int found, is_lost;

    vt_killed(act_until_killed, &killed);
    store = vt_dir_store(killed.dir);
    vt_assert_ok(vor_store_check(store, &is_lost, &vt_err));
    vt_assert_ok(vor_store_get(store, &killed.row.id, NULL, &row, &found, &vt_err));
    ck_assert_int_eq(found, killed.point != AFTER_REMOVE);
    if (found)
        ck_assert_int_eq(row.status, expected[killed.point]);
    vor_store_close(store);
}

/* Inserts for ever, telling after each one that it is done. */
static void insert_for_ever(struct vor_store *store, int fd)
{
    for (;;) {
        struct vor_job_view row = insert(store, 10);

        (void)!write(fd, row.id.text, sizeof row.id.text);
    }
}

/* Killed from outside, at any instant: every row that was acknowledged is there. */
VT_TEST_LOOP(no_acknowledged_row_is_lost_by_a_kill_at_any_instant, 8)
{
    const char *dir = vt_dir_make();
    struct vor_store *store;
    struct vor_job_view row;
    struct timespec pause = {.tv_nsec = 1000000 * (20 + (long)(60 * vt_unit(3, (uint64_t)_i)))};
    struct vor_uuid id;
    int ends[2], found, count = 0;
    pid_t child;

    ck_assert_int_eq(pipe(ends), 0);
    child = fork();
    if (child == 0)
        insert_for_ever(vt_dir_store(dir), ends[1]);
    close(ends[1]);
    ck_assert_int_eq(read(ends[0], id.text, sizeof id.text), sizeof id.text);
    nanosleep(&pause, NULL);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    store = vt_dir_store(dir);
    do {
        vt_assert_ok(vor_store_get(store, &id, NULL, &row, &found, &vt_err));
        ck_assert_msg(found, "row %s is lost", id.text);
        count++;
    } while (read(ends[0], id.text, sizeof id.text) == sizeof id.text);
    ck_assert_int_gt(count, 0);
    close(ends[0]);
    vor_store_close(store);
}

/* --- threads ---------------------------------------------------------------------------------- */

struct racer {
    struct vor_store *store;
    const struct vor_job_view *rows;
    enum vor_job_status status;
    int won;
};

enum { RACES = 60 };

static void *race(void *arg)
{
    struct racer *racer = arg;

    for (int i = 0; i < RACES; i++)
        racer->won += finish(racer->store, racer->rows[i], racer->status, 0);
    return NULL;
}

VT_TEST(of_two_threads_that_end_a_job_one_wins)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view rows[RACES];
    struct racer a = {store, rows, VOR_JOB_FAILED, 0}, b = {store, rows, VOR_JOB_DISMISSED, 0};
    pthread_t threads[2];

    for (int i = 0; i < RACES; i++)
        rows[i] = insert(store, 10);
    ck_assert_int_eq(pthread_create(&threads[0], NULL, race, &a), 0);
    ck_assert_int_eq(pthread_create(&threads[1], NULL, race, &b), 0);
    pthread_join(threads[0], NULL);
    pthread_join(threads[1], NULL);
    ck_assert_int_eq(a.won + b.won, RACES);
    ck_assert_uint_eq(count(store, VOR_JOB_FAILED), (size_t)a.won);
    ck_assert_uint_eq(count(store, VOR_JOB_DISMISSED), (size_t)b.won);
    vor_store_close(store);
}
