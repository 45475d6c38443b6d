/* A live job: progress only grows, states only move forward, the last word is the last. */
#include "server/base/machine.h"
#include "server/jobs/eta.h"
#include "server/jobs/job.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <pthread.h>
#include <string.h>

/* A record of the iterations and one of the polish, of a run that allows so many of each. */
static struct vor_record record_of(uint32_t iteration, double seconds, uint32_t of, uint32_t ahead)
{
    return (struct vor_record){.iteration = iteration,
                               .delta = 0.2,
                               .seconds = seconds,
                               .stage = VOR_RUN_STAGE_ITERATE,
                               .step = iteration,
                               .of = of,
                               .ahead = ahead};
}

static struct vor_record polished(uint32_t iteration, uint32_t polish, double seconds, uint32_t of)
{
    return (struct vor_record){.iteration = iteration,
                               .polish = polish,
                               .delta = 0.1,
                               .seconds = seconds,
                               .stage = VOR_RUN_STAGE_POLISH,
                               .step = polish,
                               .of = of};
}

/* A job that runs; name may be NULL, else it and value are a wish. */
static struct vor_job *running_job(const char *name, double value)
{
    struct vor_job_view row = vt_row(10);
    struct vor_job *job;

    if (name != NULL)
        vt_assert_ok(vor_spec_set_number(&row.spec, name, value, &vt_err));
    job = vor_job_create(&row);
    vor_job_begin(job, 1000);
    return job;
}

/* What the pace of a run of these records says of the time left, for such a job. */
static double left_after(const struct vor_record *records, size_t count)
{
    struct vor_job_view row = vt_row(10);
    struct vor_eta pace = {
        .work = vor_eta_work_of(&row.spec, row.input[0].points, vor_machine_cores())};

    for (size_t i = 0; i < count; i++)
        vor_eta_add(&pace, &records[i]);
    return vor_eta_left(&pace, &row.spec);
}

static size_t read_events(struct vor_job *job, struct vor_position *position,
                          struct vor_event *events, size_t max)
{
    struct vor_event_batch batch = {.position = *position, .events = events, .max = max};

    ck_assert(vor_job_read(job, &batch));
    *position = batch.position;
    return batch.count;
}

static void end_as(struct vor_job *job, enum vor_job_status status)
{
    struct vor_job_view row;

    ck_assert(vor_job_freeze(job));
    vor_job_view(job, &row);
    row.status = status;
    strcpy(row.message, "over");
    vor_job_end(job, &row);
    vor_job_thaw(job);
}

VT_TEST(progress_follows_the_iterations_and_never_falls)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_job_view view;
    int last = 0;

    for (uint32_t i = 0; i <= 50; i++) {
        struct vor_record record = record_of(i, i, 50, 0);

        vor_job_progress(job, &record, 1000);
        vor_job_view(job, &view);
        ck_assert_int_ge(view.progress, last);
        ck_assert_int_eq(view.progress, 10 + 80 * (int)i / 50);
        last = view.progress;
    }
    vor_job_stage(job, VOR_STAGE_ENCODE, 1000);
    vor_job_view(job, &view);
    ck_assert_int_eq(view.progress, 95);
    ck_assert_str_eq(view.message, "Encoding the result");
    vor_job_release(job);
}

/* Who follows the events is told the same estimate as who asks for the job. */
VT_TEST(an_event_has_the_estimate_of_its_moment)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_record records[3] = {record_of(0, 2, 50, 100), record_of(10, 7, 50, 100),
                                    polished(10, 20, 8, 100)};
    const double wanted[3] = {left_after(records, 1), left_after(records, 2),
                              left_after(records, 3)};
    struct vor_position position = {0, 0};
    struct vor_event events[8];
    size_t count, seen = 0;

    for (int i = 0; i < 3; i++)
        vor_job_progress(job, &records[i], 1000);
    count = read_events(job, &position, events, 8);
    for (size_t i = 0; i < count; i++) {
        if (events[i].kind != VOR_EVENT_PROGRESS)
            continue;
        ck_assert_double_eq_tol(events[i].eta_seconds, wanted[seen], 1e-9);
        seen++;
    }
    ck_assert_uint_eq(seen, 3);
    vor_job_release(job);
}

/* A stage is told by its own word, and its limit only where it has one. */
VT_TEST(the_message_names_the_step_of_the_stage)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_record record = {.stage = VOR_RUN_STAGE_POLISH, .step = 3, .of = 7};
    struct vor_job_view view;

    vor_job_progress(job, &record, 1000);
    vor_job_view(job, &view);
    ck_assert_str_eq(view.message, "Polish step 3 of at most 7");
    record.of = 0;
    vor_job_progress(job, &record, 1000);
    vor_job_view(job, &view);
    ck_assert_str_eq(view.message, "Polish step 3");
    vor_job_release(job);
}

VT_TEST(a_job_that_is_over_does_not_change)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_record record = record_of(7, 1, 12, 0);
    struct vor_position position = {0, 0};
    struct vor_job_view view;
    struct vor_event events[8];

    end_as(job, VOR_JOB_DISMISSED);
    vor_job_progress(job, &record, 2000);
    vor_job_stage(job, VOR_STAGE_ENCODE, 2000);
    vor_job_begin(job, 2000);
    ck_assert(!vor_job_freeze(job));
    vor_job_view(job, &view);
    ck_assert_int_eq(view.status, VOR_JOB_DISMISSED);
    ck_assert_int_eq(view.has_record, 0);
    ck_assert_str_eq(view.message, "over");
    ck_assert_uint_eq(read_events(job, &position, events, 8), 3);
    ck_assert_int_eq(events[2].kind, VOR_EVENT_END);
    ck_assert_int_eq(events[2].status, VOR_JOB_DISMISSED);
    vor_job_release(job);
}

/* A stop that comes while the input is prepared waits for the end of that, and says so; in the
 * iterations it takes effect at once, and is no news. */
VT_TEST(a_stop_is_told_while_the_input_is_prepared)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_record record = record_of(1, 1, 12, 0);
    struct vor_position position = {0, 0};
    struct vor_event events[8];
    struct vor_job_view view;

    vor_job_view(job, &view);
    ck_assert_str_eq(view.message, "Preparing the input");
    ck_assert_uint_eq(read_events(job, &position, events, 8), 2);
    vor_job_ask(job, VOR_STOP);
    vor_job_tell_stop(job, 2000);
    vor_job_view(job, &view);
    ck_assert_str_eq(view.message, "Preparing the input before it stops");
    ck_assert_uint_eq(read_events(job, &position, events, 8), 1);
    ck_assert_int_eq(events[0].kind, VOR_EVENT_STATUS);
    vor_job_progress(job, &record, 3000);
    (void)read_events(job, &position, events, 8);
    vor_job_tell_stop(job, 4000);
    ck_assert_uint_eq(read_events(job, &position, events, 8), 0);
    vor_job_view(job, &view);
    ck_assert_str_eq(view.message, "Iteration 1 of at most 12");
    vor_job_release(job);
}

VT_TEST(a_second_attempt_begins_with_replaced)
{
    struct vor_job_view row = vt_row(10);
    struct vor_position position = {0, 0};
    struct vor_event events[4];
    struct vor_job *job;

    row.attempt = 2;
    job = vor_job_create(&row);
    ck_assert_uint_eq(read_events(job, &position, events, 4), 2);
    ck_assert_int_eq(events[0].kind, VOR_EVENT_REPLACED);
    ck_assert_uint_eq(events[0].attempt, 2);
    ck_assert_int_eq(events[1].kind, VOR_EVENT_STATUS);
    vor_job_release(job);
}

static struct vor_event next_event(struct vor_job *job, struct vor_position *position)
{
    struct vor_event event = {.number = 0};

    ck_assert_uint_eq(read_events(job, position, &event, 1), 1);
    return event;
}

/* Readers who were in the middle find themselves before the first event of the next attempt. */
VT_TEST_LOOP(a_job_that_begins_anew_waits_again_and_forgets_its_events, 2)
{
    struct vor_job *job = running_job("iterations", 10);
    struct vor_position position = {1, 2};
    struct vor_record record = record_of(3, 1, 10, 0);
    struct vor_job_view view;
    struct vor_event event;

    vor_job_progress(job, &record, 1001);
    ck_assert(vor_job_restart(job, _i, 1002));
    vor_job_view(job, &view);
    ck_assert_int_eq(view.status, VOR_JOB_ACCEPTED);
    ck_assert_int_eq(view.stage, VOR_STAGE_QUEUED);
    ck_assert_uint_eq(view.attempt, 2);
    ck_assert_int_eq(view.alone, _i);
    event = next_event(job, &position);
    ck_assert_int_eq(event.kind, VOR_EVENT_REPLACED);
    ck_assert_int_eq(event.stage, VOR_STAGE_OPTIMIZE);
    ck_assert_uint_eq(event.attempt, 2);
    ck_assert_uint_eq(event.number, 1);
    event = next_event(job, &position);
    ck_assert_int_eq(event.kind, VOR_EVENT_STATUS);
    ck_assert_int_eq(event.status, VOR_JOB_ACCEPTED);
    vor_job_begin(job, 1003);
    event = next_event(job, &position);
    ck_assert_int_eq(event.status, VOR_JOB_RUNNING);
    ck_assert_uint_eq(event.number, 3);
    ck_assert_uint_eq(event.attempt, 2);
    vor_job_release(job);
}

VT_TEST(a_job_that_is_over_does_not_begin_anew)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_position position = {1, 2};

    end_as(job, VOR_JOB_DISMISSED);
    ck_assert(!vor_job_restart(job, 1, 1002));
    ck_assert_int_eq(next_event(job, &position).kind, VOR_EVENT_END);
    ck_assert_uint_eq(position.attempt, 1);
    vor_job_release(job);
}

VT_TEST(what_was_asked_only_grows)
{
    struct vor_job *job = running_job(NULL, 0);

    ck_assert_int_eq(vor_job_asked(job), VOR_CONTINUE);
    vor_job_ask(job, VOR_STOP);
    ck_assert_int_eq(vor_job_asked(job), VOR_STOP);
    vor_job_ask(job, VOR_CANCEL);
    vor_job_ask(job, VOR_STOP);
    ck_assert_int_eq(vor_job_asked(job), VOR_CANCEL);
    vor_job_release(job);
}

static void *iterate(void *arg)
{
    for (uint32_t i = 0; i < 5000; i++) {
        struct vor_record record = record_of(i, i, 5000, 0);

        vor_job_progress(arg, &record, 1000);
    }
    return NULL;
}

/* What is packed while a job is frozen is all that its readers will ever see, but the end. */
VT_TEST(nothing_is_published_between_freezing_and_the_end)
{
    struct vor_job *job = running_job(NULL, 0);
    struct vor_position position = {1, 0};
    struct vor_event events[64];
    struct vor_job_view row;
    uint32_t last;
    pthread_t thread;

    ck_assert_int_eq(pthread_create(&thread, NULL, iterate, job), 0);
    do
        vor_job_view(job, &row);
    while (!row.has_record);
    ck_assert(vor_job_freeze(job));
    last = vor_job_piece(job).last;
    sched_yield();
    vor_job_view(job, &row);
    row.status = VOR_JOB_FAILED;
    vor_job_end(job, &row);
    vor_job_thaw(job);
    pthread_join(thread, NULL);
    while (read_events(job, &position, events, 64) > 0)
        continue;
    ck_assert_uint_eq(position.number, last + 1);
    vor_job_release(job);
}

/* A wall clock that is set back while a job waits or runs. */
VT_TEST(no_time_of_a_job_is_before_one_that_came_earlier)
{
    struct vor_job_view row = vt_row(10), view;
    struct vor_record record = {.iteration = 1};
    struct vor_job *job;

    row.created = row.updated = 1000;
    row.started = 0;
    job = vor_job_create(&row);
    vor_job_begin(job, 400);
    vor_job_view(job, &view);
    ck_assert_int_eq(view.started, 1000);
    ck_assert_int_eq(view.updated, 1000);
    vor_job_progress(job, &record, 1700);
    vor_job_stage(job, VOR_STAGE_ENCODE, 300);
    vor_job_view(job, &view);
    ck_assert_int_eq(view.updated, 1700);
    ck_assert_int_eq(vor_job_now(&view, 200), 1700);
    ck_assert_int_eq(vor_job_now(&view, 2000), 2000);
    vor_job_release(job);
}
