/* The life of jobs, with the real engine: every accepted one ends once, with a reason, and leaves
 * only what its end promises. */
#include "proto/codec.h"
#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/work/active_jobs.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static struct vor_uuid submit(struct vt_daemon *daemon, size_t n, struct vor_spec spec)
{
    return vt_daemon_submit_sphere(daemon, n, &spec);
}

static void dismiss(struct vt_daemon *daemon, const struct vor_uuid *id)
{
    struct vor_job_view view;

    ck_assert_int_eq(
        vor_job_service_dismiss(daemon->service, id, "dismissed by the test", &view, &vt_err),
        VOR_DONE);
    ck_assert_int_eq(view.status, VOR_JOB_DISMISSED);
    ck_assert_str_eq(view.id.text, id->text);
}

VT_TEST(a_job_ends_with_exactly_the_points_asked_for)
{
    struct vt_daemon daemon;
    struct vor_cloud result;
    struct vor_job_view view;
    struct vor_json *report = NULL;
    struct vor_uuid id;
    uint8_t *bytes;
    double number;
    size_t size;
    char *json;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    id = submit(&daemon, 2000, vt_request(300, 5));
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_msg(view.status == VOR_JOB_SUCCESSFUL, "%s", view.message);
    ck_assert_int_eq(view.progress, 100);
    ck_assert_uint_eq(view.output[0].points, 300);
    ck_assert_uint_eq(view.record.iteration, 5);
    ck_assert_int_ge(view.started, view.created);
    ck_assert_int_ge(view.finished, view.started);
    ck_assert_int_eq(view.expires, view.finished + 3600 * 1000);
    bytes = vt_daemon_result(&daemon, &id, &size);
    ck_assert_uint_eq(size, view.output[0].bytes);
    vor_cloud_init(&result, &vt_memory);
    vt_assert_ok(vor_codec_read(&result, NULL, bytes, size, &(struct vor_limits)VOR_LIMITS_DEFAULT,
                                &vt_err));
    ck_assert_uint_eq(result.n, 300);
    vt_assert_ok(vor_store_report(daemon.store, &id, &json, &vt_err));
    vt_assert_ok(vor_json_parse(&report, json, strlen(json), &vt_err));
    ck_assert(vor_json_get_number(vor_json_get(report, "iterations"), &number));
    ck_assert_double_eq(number, 5);
    ck_assert(vor_json_get_number(vor_json_get(report, "polish_steps"), &number));
    ck_assert_double_eq(number, 0);
    ck_assert(vor_json_get_number(vor_json_get(vor_json_get(report, "seconds"), "write"), &number));
    ck_assert_double_gt(number, 0);
    ck_assert(vor_json_get_number(vor_json_get(vor_json_get(report, "seconds"), "read"), &number));
    ck_assert_double_eq(number, view.input[0].seconds);
    vt_daemon_wait_idle(&daemon);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 1); /* the result; the input is gone */
    vor_json_free(report);
    free(json);
    free(bytes);
    vor_cloud_free(&result);
    vt_daemon_stop(&daemon);
}

/* From the first event on that the live job still has. */
VT_TEST_LOOP(the_events_of_a_job_are_the_same_live_and_from_the_store, 2)
{
    enum { EVENTS = 128 };
    struct vor_event live[EVENTS], stored[EVENTS];
    struct vor_event_batch batch = {.position = {1, 0}, .events = live, .max = EVENTS};
    struct vor_followed followed;
    struct vt_daemon daemon;
    struct vor_uuid id;
    struct vor_spec spec = vt_request(100, 12);
    uint32_t records[2] = {0}; /* of iterations, of the polish */
    size_t count, first;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    vt_assert_ok(vor_spec_set_number(&spec, "polish", _i * 40, &vt_err));
    id = submit(&daemon, 1000, spec);
    ck_assert_int_eq(vor_job_service_follow(daemon.service, &id, NULL, &followed, &vt_err),
                     VOR_DONE);
    (void)vt_daemon_wait_over(&daemon, &id);
    vt_daemon_wait_idle(&daemon);
    while (followed.job != NULL && !vor_job_read(followed.job, &batch))
        batch.position.number++;
    count = vt_daemon_events(&daemon, &id, stored, EVENTS);
    first = count - batch.count;
    for (size_t i = 0; i < batch.count; i++)
        ck_assert_mem_eq(&live[i], &stored[first + i], sizeof live[i]);
    for (size_t i = 0; i < count; i++)
        if (stored[i].kind == VOR_EVENT_PROGRESS)
            records[stored[i].record.polish > 0]++;
    ck_assert_int_eq(stored[count - 1].kind, VOR_EVENT_END);
    ck_assert_int_eq(stored[count - 1].status, VOR_JOB_SUCCESSFUL);
    ck_assert_uint_eq(records[0], 13); /* with iteration 0 */
    ck_assert_int_eq(records[1] > 0, _i > 0);
    vor_job_release(followed.job);
    vt_daemon_stop(&daemon);
}

/* The reads of single jobs. */
static atomic_int rows, traces;
vor_status __real_vor_store_get(struct vor_store *store, const struct vor_uuid *id,
                                const char *tenant, struct vor_job_view *out, int *found,
                                struct vor_error *err);
vor_status __wrap_vor_store_get(struct vor_store *store, const struct vor_uuid *id,
                                const char *tenant, struct vor_job_view *out, int *found,
                                struct vor_error *err);
vor_status __real_vor_store_events(struct vor_store *store, const struct vor_uuid *id,
                                   const struct vor_event_query *query, struct vor_error *err);
vor_status __wrap_vor_store_events(struct vor_store *store, const struct vor_uuid *id,
                                   const struct vor_event_query *query, struct vor_error *err);

vor_status __wrap_vor_store_get(struct vor_store *store, const struct vor_uuid *id,
                                const char *tenant, struct vor_job_view *out, int *found,
                                struct vor_error *err)
{
    atomic_fetch_add(&rows, 1);
    return __real_vor_store_get(store, id, tenant, out, found, err);
}

vor_status __wrap_vor_store_events(struct vor_store *store, const struct vor_uuid *id,
                                   const struct vor_event_query *query, struct vor_error *err)
{
    atomic_fetch_add(&traces, 1);
    return __real_vor_store_events(store, id, query, err);
}

/* Regression: a stream asked the store for the row at each of its events. */
VT_TEST(who_follows_a_job_asks_the_store_once_however_many_its_events)
{
    struct vor_event events[128];
    struct vor_event_batch batch = {.events = events, .max = sizeof events / sizeof events[0]};
    struct vor_followed followed, live;
    struct vor_job_view view, stored;
    struct vt_daemon daemon;
    struct vor_uuid id;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    id = submit(&daemon, 300, vt_request(100, 50));
    ck_assert_int_eq(vor_job_service_follow(daemon.service, &id, NULL, &live, &vt_err), VOR_DONE);
    do /* its place in the queue is the store's */
        vor_job_service_followed(daemon.service, &live, &view);
    while (view.status == VOR_JOB_ACCEPTED);
    atomic_store(&rows, 0);
    while (!vor_job_is_over(live.job))
        vor_job_service_followed(daemon.service, &live, &view);
    vt_daemon_wait_idle(&daemon);
    ck_assert_int_eq(atomic_load(&rows), 0);
    ck_assert_int_eq(vor_job_service_follow(daemon.service, &id, NULL, &followed, &vt_err),
                     VOR_DONE);
    ck_assert_ptr_null(followed.job);
    vt_assert_ok(vor_job_service_stored_events(daemon.service, &followed.row, &batch, &vt_err));
    ck_assert_uint_gt(batch.count, 50);
    vor_job_service_followed(daemon.service, &followed, &stored);
    ck_assert_int_eq(atomic_load(&rows), 1);
    ck_assert_int_eq(atomic_load(&traces), 1);
    vor_job_service_followed(daemon.service, &live, &view); /* over, and still in hand */
    ck_assert_int_eq(view.status, VOR_JOB_SUCCESSFUL);
    ck_assert_int_eq(stored.status, VOR_JOB_SUCCESSFUL);
    ck_assert_str_eq(view.message, stored.message);
    ck_assert_int_eq(view.finished, stored.finished);
    ck_assert_mem_eq(&view.spec, &stored.spec, sizeof view.spec);
    ck_assert_mem_eq(&live.row.spec, &stored.spec, sizeof view.spec);
    vor_job_release(live.job);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_running_job_is_dismissed_at_once_and_its_cores_are_free)
{
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_uuid id;

    vt_daemon_start(&daemon, vt_dir_make(), &(struct vt_daemon_options){.jobs = 1});
    id = submit(&daemon, 5000, vt_request(20000, 10000));
    (void)vt_daemon_wait_iteration(&daemon, &id, 0);
    alarm(120); /* kills a test whose job goes on: it would take a multiple of that */
    dismiss(&daemon, &id);
    view = vt_daemon_get(&daemon, &id); /* with the answer, not after the engine */
    ck_assert_int_eq(view.status, VOR_JOB_DISMISSED);
    ck_assert_str_eq(view.message, "dismissed by the test");
    ck_assert_int_lt(view.progress, 100);
    vt_daemon_wait_idle(&daemon);
    alarm(0);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
    id = submit(&daemon, 5000, vt_request(50, 1)); /* the runner goes on */
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &id).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
}

/* As where the server of the store goes down between the change and its answer. */
VT_TEST(a_claim_whose_answer_was_lost_is_taken_back)
{
    struct vt_daemon daemon;
    struct vor_job_view row;
    struct vor_uuid endless, id;
    struct vor_claim claim = {.memory = UINT64_MAX, .may_be_alone = 1, .build = vor_build_own()};
    int found = 0;

    vt_daemon_start(&daemon, vt_dir_make(), &(struct vt_daemon_options){.jobs = 1});
    endless = vt_daemon_submit_endless(&daemon);
    id = submit(&daemon, 500, vt_request(100, 2));
    claim.owner = daemon.service->owner.text;
    claim.now_ms = vor_clock_wall_ms();
    vt_assert_ok(vor_store_claim_next(daemon.store, &claim, &row, &found, &vt_err));
    ck_assert(found && strcmp(row.id.text, id.text) == 0);
    while (vt_daemon_get(&daemon, &id).status == VOR_JOB_RUNNING)
        vt_nap();
    dismiss(&daemon, &endless);
    row = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(row.status, VOR_JOB_SUCCESSFUL);
    ck_assert_uint_eq(row.attempt, 2);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_waiting_job_is_dismissed_without_running)
{
    struct vt_daemon daemon;
    struct vor_uuid runs, waits;
    struct vor_job_view view;
    struct vor_job_service_load load;

    vt_daemon_start(&daemon, vt_dir_make(), &(struct vt_daemon_options){.jobs = 1});
    runs = vt_daemon_submit_endless(&daemon);
    waits = submit(&daemon, 1000, vt_request(50, 1));
    view = vt_daemon_get(&daemon, &waits);
    ck_assert_int_eq(view.status, VOR_JOB_ACCEPTED);
    ck_assert_int_eq(view.queue_position, 0);
    ck_assert_int_eq(vor_job_service_stop(daemon.service, &waits, &vt_err), VOR_CONFLICT);
    dismiss(&daemon, &waits);
    vor_job_service_load(daemon.service, &load);
    ck_assert_uint_eq(load.waiting, 0); /* its place is free while the other one runs */
    dismiss(&daemon, &runs);
    vt_daemon_wait_idle(&daemon);
    view = vt_daemon_get(&daemon, &waits);
    ck_assert_int_eq(view.status, VOR_JOB_DISMISSED);
    ck_assert_int_eq(view.started, 0);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_job_dismissed_while_it_encodes_leaves_no_bytes)
{
    struct vt_daemon daemon;
    struct timespec pause = {.tv_nsec = 200000}; /* it encodes for many times that */
    struct vor_job_view view;
    struct vor_uuid id;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    for (int i = 0; i < VT_SOAK_LOOPS(1, 3); i++) {
        id = submit(&daemon, 10000, vt_request(100000, 0));
        for (view = vt_daemon_get(&daemon, &id);
             view.stage != VOR_STAGE_ENCODE && !vor_job_status_over(view.status);
             view = vt_daemon_get(&daemon, &id))
            nanosleep(&pause, NULL);
        ck_assert_msg(view.status != VOR_JOB_FAILED, "%s", view.message);
        dismiss(&daemon, &id); /* removed, should it have been quicker */
        vt_daemon_wait_idle(&daemon);
        ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
        ck_assert_int_eq(vt_dir_count(daemon.dir, "blobs/tmp"), 0);
    }
    vt_daemon_stop(&daemon);
}

VT_TEST(a_job_the_engine_refuses_fails_with_the_engine_s_words)
{
    struct vt_daemon daemon;
    struct vor_job_view view;
    const struct vor_spec spec = vt_request(100, 5);
    struct vor_cloud line;
    struct vor_uuid id;
    char *json;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    vt_cloud_cube(&line, 1, 500);
    for (size_t i = 0; i < line.n; i++)
        line.xyz[3 * i + 1] = line.xyz[3 * i + 2] = 0;
    ck_assert_int_eq(vt_daemon_submit(&daemon, &line, &spec, &id), VOR_DONE);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_FAILED);
    ck_assert_int_eq(view.problem.status, VOR_E_DEGENERATE);
    ck_assert_str_ne(view.message, "");
    ck_assert_int_lt(view.progress, 100);
    vt_daemon_wait_idle(&daemon);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
    view = vt_daemon_get(&daemon, &id); /* now from its row */
    ck_assert_int_eq(view.problem.status, VOR_E_DEGENERATE);
    vt_assert_ok(vor_store_report(daemon.store, &id, &json, &vt_err));
    ck_assert_ptr_null(json);
    vor_cloud_free(&line);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_job_that_needs_too_much_memory_fails_and_the_next_one_runs)
{
    struct vt_daemon daemon;
    struct vor_uuid id, small;
    struct vor_job_view view;

    vt_daemon_start(&daemon, vt_dir_make(),
                    &(struct vt_daemon_options){.jobs = 1, .memory = 2u << 20});
    id = submit(&daemon, 60000, vt_request(60000, 2));
    small = submit(&daemon, 200, vt_request(50, 2));
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_FAILED);
    ck_assert_int_eq(view.problem.status, VOR_E_NOMEM);
    view = vt_daemon_wait_over(&daemon, &small);
    ck_assert_msg(view.status == VOR_JOB_SUCCESSFUL, "%s", view.message);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_full_queue_refuses_and_keeps_nothing)
{
    struct vt_daemon daemon;
    struct vor_uuid ids[3], refused;
    struct vor_job_service_load load;
    struct vor_cloud cloud;
    struct vor_spec spec = vt_request(300, 10000);

    vt_daemon_start(&daemon, vt_dir_make(), &(struct vt_daemon_options){.jobs = 1, .queue = 2});
    vt_cloud_sphere(&cloud, 1, 500);
    ids[0] = vt_daemon_submit_endless(&daemon);
    ck_assert_int_eq(vor_job_service_room(daemon.service, NULL, 0, NULL), VOR_DONE);
    ids[1] = submit(&daemon, 500, spec);
    ids[2] = submit(&daemon, 500, spec);
    ck_assert_int_eq(vor_job_service_room(daemon.service, NULL, 0, NULL), VOR_FULL);
    ck_assert_int_eq(vt_daemon_submit(&daemon, &cloud, &spec, &refused), VOR_FULL);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 3);
    ck_assert_int_eq(vor_job_service_get(daemon.service, &refused, NULL,
                                         &(struct vor_job_view){.seq = 0}, &vt_err),
                     VOR_UNKNOWN);
    vor_job_service_load(daemon.service, &load);
    ck_assert_uint_eq(load.running, 1);
    ck_assert_uint_eq(load.waiting, 2);
    ck_assert_int_eq(vt_daemon_get(&daemon, &ids[2]).queue_position, 1);
    for (int i = 0; i < 3; i++)
        dismiss(&daemon, &ids[i]);
    vor_cloud_free(&cloud);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_finished_job_is_removed_with_its_bytes)
{
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_followed followed;
    struct vor_uuid id;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    id = submit(&daemon, 200, vt_request(50, 1));
    (void)vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &id, "left", &vt_err), VOR_CONFLICT);
    ck_assert_int_eq(vt_daemon_get(&daemon, &id).status, VOR_JOB_SUCCESSFUL);
    dismiss(&daemon, &id);
    ck_assert_int_eq(vor_job_service_get(daemon.service, &id, NULL, &view, &vt_err), VOR_UNKNOWN);
    ck_assert_int_eq(vor_job_service_dismiss(daemon.service, &id, "", &view, &vt_err), VOR_UNKNOWN);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &id, "", &vt_err), VOR_UNKNOWN);
    ck_assert_int_eq(vor_job_service_stop(daemon.service, &id, &vt_err), VOR_UNKNOWN);
    ck_assert_int_eq(vor_job_service_follow(daemon.service, &id, NULL, &followed, &vt_err),
                     VOR_UNKNOWN);
    vt_daemon_wait_idle(&daemon);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
    vt_daemon_stop(&daemon);
}

/* A job whose result was kept for an hour, until so many minutes ago. */
static struct vor_uuid ended(struct vt_daemon *daemon, int minutes)
{
    const int64_t minute = 60000;
    struct vor_blob_writer *writer = vt_upload(daemon->blobs, "ply", 3);
    struct vor_job_view row = vt_row(50);
    int changed;

    vt_assert_ok(vor_blob_commit(writer, &row.id, "cloud", &vt_err));
    vt_assert_ok(vor_store_insert(daemon->store, &row, NULL, &vt_err));
    row.status = VOR_JOB_SUCCESSFUL;
    row.progress = 100;
    row.expires = vor_clock_wall_ms() - minutes * minute;
    row.finished = row.expires - 60 * minute;
    vt_assert_ok(vor_store_finish(daemon->store, &row, NULL, NULL, &changed, &vt_err));
    ck_assert(changed);
    return row.id;
}

VT_TEST(results_expire_and_say_so_for_as_long_as_they_were_kept)
{
    static const int minutes[3] = {-30, 30, 90}; /* kept, expired, forgotten */
    static const enum vor_job_outcome outcomes[3] = {VOR_DONE, VOR_DONE, VOR_UNKNOWN};
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_uuid ids[3];
    struct vor_event event;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    for (int i = 0; i < 3; i++)
        ids[i] = ended(&daemon, minutes[i]);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 3);
    vt_assert_ok(vor_job_service_sweep(daemon.service, &vt_err));
    ck_assert_int_eq(vt_daemon_kept(&daemon), 1);
    for (int i = 0; i < 3; i++) {
        view.expired = 0;
        ck_assert_int_eq(vor_job_service_get(daemon.service, &ids[i], NULL, &view, &vt_err),
                         outcomes[i]);
        ck_assert_int_eq(view.expired, i == 1);
    }
    ck_assert_uint_eq(vt_daemon_events(&daemon, &ids[1], &event, 1), 1);
    ck_assert_int_eq(event.kind, VOR_EVENT_END);
    vt_daemon_stop(&daemon);
}

struct counted {
    size_t count;
    const struct vor_uuid *running;
    unsigned iteration;
};

static int count_live(void *ctx, const struct vor_job_view *row)
{
    struct counted *counted = ctx;

    counted->count++;
    if (strcmp(row->id.text, counted->running->text) == 0)
        counted->iteration = row->record.iteration;
    return 1;
}

VT_TEST(a_list_shows_the_live_state_of_running_jobs)
{
    struct vor_job_filter filter = {.limit = 10};
    struct vt_daemon daemon;
    struct vor_uuid id;
    struct counted counted = {.running = &id};

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    id = vt_daemon_submit_endless(&daemon);
    (void)vt_daemon_wait_iteration(&daemon, &id, 4);
    vt_assert_ok(vor_job_service_list(daemon.service, &filter, count_live, &counted, &vt_err));
    ck_assert_uint_eq(counted.count, 1);
    ck_assert_uint_ge(counted.iteration, 4);
    dismiss(&daemon, &id);
    vt_daemon_stop(&daemon);
}

/* Property: a job dismissed, stopped or cancelled at a random instant ends once, its trace says the
 * same as its row, and no bytes are left but those of a success. */
VT_TEST_LOOP(a_job_interrupted_at_any_instant_ends_once, 6)
{
    enum { JOBS = 12 };
    struct vor_job_view views[JOBS];
    struct vor_uuid ids[JOBS];
    struct vt_daemon daemon;
    int results = 0;

    vt_daemon_start(&daemon, vt_dir_make(), &(struct vt_daemon_options){.jobs = 2});
    for (int i = 0; i < JOBS; i++) {
        struct timespec pause = {.tv_nsec = (long)(3e6 * vt_unit((uint64_t)_i, (uint64_t)i))};

        ids[i] = submit(&daemon, 400, vt_request(60, 1 + i % 6));
        nanosleep(&pause, NULL);
        if (i % 3 == 0)
            (void)!vor_job_service_stop(daemon.service, &ids[i], &vt_err);
        else
            (void)!vor_job_service_cancel(daemon.service, &ids[i], "by chance", &vt_err);
    }
    vt_daemon_wait_idle(&daemon);
    for (int i = 0; i < JOBS; i++) {
        struct vor_event events[64];
        const struct vor_event *end;

        views[i] = vt_daemon_get(&daemon, &ids[i]);
        end = &events[vt_daemon_events(&daemon, &ids[i], events, 64) - 1];
        ck_assert_int_eq(end->kind, VOR_EVENT_END);
        ck_assert_int_eq(end->status, views[i].status);
        ck_assert_msg(views[i].status == VOR_JOB_SUCCESSFUL || views[i].status == VOR_JOB_DISMISSED,
                      "job %d: %s", i, views[i].message);
        results += views[i].status == VOR_JOB_SUCCESSFUL;
    }
    ck_assert_int_eq(vt_daemon_kept(&daemon), results);
    ck_assert_int_eq(vt_dir_count(daemon.dir, "blobs/tmp"), 0);
    vt_daemon_stop(&daemon);
}

VT_LOG(VOR_LOG_ERROR)
