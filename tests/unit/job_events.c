/* Events: in pieces every one comes back, and bytes that are none are refused; every reader of a
 * job sees the same numbers, whenever it comes and however slow it is. */
#include "server/jobs/job.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static struct vor_event event_of(enum vor_event_kind kind, uint32_t i)
{
    struct vor_event event = {.kind = kind,
                              .attempt = 4,
                              .status =
                                  kind == VOR_EVENT_END ? VOR_JOB_SUCCESSFUL : VOR_JOB_RUNNING,
                              .stage = VOR_STAGE_OPTIMIZE,
                              .progress = 10,
                              .time_ms = 1700000000000 + i};

    if (kind != VOR_EVENT_PROGRESS)
        return event;
    event.eta_seconds = i * 0.5 - 1;
    event.record = (struct vor_record){.iteration = i,
                                       .polish = i * 7u,
                                       .delta = vt_unit(7, i),
                                       .sigma = vt_unit(8, i),
                                       .epsilon = 1 - vt_unit(9, i),
                                       .energy = vt_unit(10, i) * 1e-9,
                                       .max_move = vt_unit(11, i),
                                       .held = i * UINT64_C(3000000000),
                                       .seconds = i * 0.125,
                                       .stage = (enum vor_run_stage)(i % VOR_RUN_STAGE_COUNT),
                                       .step = i * 5u,
                                       .of = 4000000000u + i,
                                       .ahead = i + 1,
                                       .best_iteration = i / 2,
                                       .best_polish = i * 3u,
                                       .best_delta = vt_unit(12, i),
                                       .best_sigma = vt_unit(13, i),
                                       .best_epsilon = 1 - vt_unit(14, i)};
    return event;
}

/* A piece of a status, then `records` progress events, numbers of which the last is `last`. */
static struct vor_event_piece packed(struct vor_text *text, uint32_t records, uint32_t last)
{
    vor_text_init(text, 0);
    for (uint32_t i = 0; i <= records; i++) {
        struct vor_event event = event_of(i == 0 ? VOR_EVENT_STATUS : VOR_EVENT_PROGRESS, i);

        vt_assert_ok(vor_events_pack(text, &event));
    }
    return (struct vor_event_piece){last, (const uint8_t *)text->data, text->size};
}

static void assert_same(const struct vor_event *a, const struct vor_event *b)
{
    ck_assert_int_eq(a->kind, b->kind);
    ck_assert_uint_eq(a->attempt, b->attempt);
    ck_assert_uint_eq(a->number, b->number);
    ck_assert_int_eq(a->status, b->status);
    ck_assert_int_eq(a->stage, b->stage);
    ck_assert_int_eq(a->progress, b->progress);
    ck_assert_int_eq(a->time_ms, b->time_ms);
    ck_assert_double_eq(a->eta_seconds, b->eta_seconds);
    ck_assert_mem_eq(&a->record, &b->record, sizeof a->record);
}

static int unpack(struct vor_event *out, size_t max, const uint8_t *bytes, size_t size)
{
    const struct vor_event_piece piece = {.last = 5, .data = bytes, .size = size};
    struct vor_event_batch batch = {.position = {4, 0}, .events = out, .max = max};

    return vor_events_unpack(&batch, &piece);
}

/* From any event on, and with little room. */
VT_TEST_LOOP(events_come_back_as_they_were, 20)
{
    uint32_t records = (uint32_t)_i * 11, first = 7;
    struct vor_event_batch batch = {.position = {4, first - 1 + records * (uint32_t)(_i % 3) / 3}};
    struct vor_event events[3];
    struct vor_text text;
    struct vor_event_piece piece = packed(&text, records, first + records);
    int found;

    batch.events = events;
    batch.max = sizeof events / sizeof events[0];
    do {
        uint32_t number = batch.position.number;

        batch.count = 0;
        found = vor_events_unpack(&batch, &piece);
        ck_assert_int_ge(found, 0);
        for (size_t i = 0; i < batch.count; i++) {
            uint32_t at = ++number - first;
            struct vor_event wanted = event_of(at == 0 ? VOR_EVENT_STATUS : VOR_EVENT_PROGRESS, at);

            wanted.number = number;
            assert_same(&events[i], &wanted);
        }
    } while (found == 0);
    ck_assert_uint_eq(batch.position.number, first + records);
    vor_text_free(&text);
}

/* Bytes that are built up little endian. */
struct bytes {
    uint8_t data[1024];
    size_t size;
};

static void add(struct bytes *bytes, uint64_t value, size_t width)
{
    ck_assert_uint_le(bytes->size + width, sizeof bytes->data);
    for (size_t i = 0; i < width; i++)
        bytes->data[bytes->size++] = (uint8_t)(value >> (8 * i));
}

static void add_real(struct bytes *bytes, double value)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof bits);
    add(bytes, bits, 8);
}

static void add_header(struct bytes *bytes, char version, uint32_t attempt, uint32_t count)
{
    const char magic[4] = {'V', 'T', 'R', version};

    bytes->size = 0;
    for (size_t i = 0; i < sizeof magic; i++)
        add(bytes, (uint8_t)magic[i], 1);
    add(bytes, attempt, 4);
    add(bytes, count, 4);
}

static void add_event(struct bytes *bytes, enum vor_event_kind kind, enum vor_job_status status,
                      int progress, int64_t time_ms)
{
    add(bytes, (uint64_t)kind, 1);
    add(bytes, (uint64_t)status, 1);
    add(bytes, VOR_STAGE_OPTIMIZE, 1);
    add(bytes, (uint64_t)progress, 1);
    add(bytes, (uint64_t)time_ms, 8);
}

/* A trace with one progress event whose record has the first `members` members, then `more` bytes.
 */
static void add_trace_of(struct bytes *bytes, size_t members, size_t more)
{
    static const size_t sizes[] = {4, 4, 8, 8, 8, 8, 8, 8, 8, 4, 4, 4, 4, 4, 4, 8, 8, 8, 8, 8, 8};
    size_t record = more;

    ck_assert_uint_eq(sizeof sizes / sizeof sizes[0], vor_record_members.count);
    for (size_t i = 0; i < members; i++)
        record += sizes[i];
    add_header(bytes, '3', 4, 2);
    add(bytes, record, 4);
    add_event(bytes, VOR_EVENT_PROGRESS, VOR_JOB_RUNNING, 10, 5);
    add_real(bytes, 1.5);
    for (size_t i = 0; i < members; i++)
        add(bytes, 1, sizes[i]);
    for (size_t i = 0; i < more; i++)
        add(bytes, 0, 1);
    add_event(bytes, VOR_EVENT_END, VOR_JOB_FAILED, 10, 6);
}

/* Members are added at the end of the record: a build that has fewer or more of them reads those
 * that both have. */
VT_TEST(records_with_other_members_are_read)
{
    for (size_t members = 1; members <= vor_record_members.count; members++) {
        size_t more = members == vor_record_members.count ? 12 : 0;
        struct vor_event events[3];
        struct bytes bytes;

        add_trace_of(&bytes, members, more);
        ck_assert_int_eq(unpack(events, 3, bytes.data, bytes.size), 1);
        ck_assert_double_eq(events[0].eta_seconds, 1.5);
        ck_assert_uint_eq(events[0].record.iteration, 1);
        ck_assert_uint_eq(events[0].record.held, members >= 8);
        ck_assert_int_eq(events[0].record.stage,
                         members >= 10 ? VOR_RUN_STAGE_POLISH : VOR_RUN_STAGE_ITERATE);
        ck_assert_uint_eq(events[0].record.ahead, members >= 13);
        ck_assert_int_eq(isnan(events[0].record.best_delta) != 0, members < 16);
        ck_assert_int_eq(events[1].status, VOR_JOB_FAILED);
    }
}

VT_TEST(a_stage_that_there_is_not_is_refused)
{
    struct vor_event events[3];
    struct bytes bytes;
    size_t stage;

    add_trace_of(&bytes, vor_record_members.count, 0);
    stage = bytes.size - 12 - 72;
    ck_assert_uint_eq(bytes.data[stage], VOR_RUN_STAGE_POLISH);
    bytes.data[stage] = VOR_RUN_STAGE_COUNT;
    ck_assert_int_eq(unpack(events, 3, bytes.data, bytes.size), -1);
}

/* Every beginning of a piece is refused, whether its events are wanted or passed over; each is a
 * block of its own, so that reading past it is seen. */
static void assert_no_beginning_is_read(const uint8_t *bytes, size_t size)
{
    struct vor_event events[5];

    for (size_t cut = 1; cut < size; cut++) {
        uint8_t *part = malloc(cut);
        const struct vor_event_piece piece = {.last = 4, .data = part, .size = cut};
        struct vor_event_batch behind = {.position = {4, 4}};

        memcpy(part, bytes, cut);
        ck_assert_int_eq(unpack(events, 5, part, cut), -1);
        ck_assert_int_eq(vor_events_unpack(&behind, &piece), -1);
        free(part);
    }
}

/* Kind, status, stage and progress of the first event, the version, and the bytes of a record:
 * none, and too many. */
VT_TEST(a_damaged_piece_is_refused)
{
    static const struct {
        size_t at;
        uint8_t byte;
    } damages[] = {{16, 101}, {17, 101},  {18, 101},  {19, 101},  {3, '2'},  {3, '4'},
                   {12, 0},   {13, 0xff}, {14, 0xff}, {15, 0xff}, {8, 0xff}, {11, 0xff}};
    struct vor_event events[5];
    struct vor_text text;
    struct vor_event_piece piece = packed(&text, 3, 4);
    uint8_t *bytes = (uint8_t *)text.data;

    assert_no_beginning_is_read(bytes, piece.size);
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++) {
        uint8_t kept = bytes[damages[i].at];

        bytes[damages[i].at] = damages[i].byte;
        ck_assert_int_eq(unpack(events, 5, bytes, piece.size), -1);
        bytes[damages[i].at] = kept;
    }
    ck_assert_int_eq(unpack(events, 5, bytes, piece.size), 1);
    vor_text_free(&text);
}

/* --- of a live job ---------------------------------------------------------------------------- */

static void progress(struct vor_job *job, uint32_t i)
{
    struct vor_record record = {.iteration = i, .step = i};

    vor_job_progress(job, &record, 1000);
}

static void end_job(struct vor_job *job)
{
    struct vor_job_view row;

    ck_assert(vor_job_freeze(job));
    vor_job_view(job, &row);
    row.status = VOR_JOB_SUCCESSFUL;
    vor_job_end(job, &row);
    vor_job_thaw(job);
}

/* What a job has had stored is read there, and nowhere else. */
static void store(struct vor_job *job)
{
    ck_assert(vor_job_freeze(job));
    vor_job_stored(job);
    vor_job_thaw(job);
}

/* Events 1 to 3 say that it waits, runs and iterates; then come those of the iterations. */
static struct vor_job *iterated(uint32_t attempt, uint32_t iterations)
{
    struct vor_job_view row = vt_row(10);
    struct vor_job *job;

    row.attempt = attempt;
    job = vor_job_create(&row);
    vor_job_begin(job, 1000);
    for (uint32_t i = 1; i <= iterations; i++)
        progress(job, i);
    return job;
}

static size_t read_some(struct vor_job *job, struct vor_position *position, enum vor_read how,
                        struct vor_event *events, size_t max)
{
    struct vor_event_batch batch = {
        .position = *position, .how = how, .events = events, .max = max};

    ck_assert(vor_job_read(job, &batch));
    *position = batch.position;
    return batch.count;
}

VT_TEST(events_are_numbered_from_one_without_gaps)
{
    struct vor_job *job = iterated(1, 40);
    struct vor_position position = {0, 0};
    uint32_t expected = 1;
    struct vor_event events[5];
    size_t count;

    end_job(job);
    while ((count = read_some(job, &position, VOR_READ_EVERY, events, 5)) > 0)
        for (size_t i = 0; i < count; i++) {
            ck_assert_uint_eq(events[i].attempt, 1);
            ck_assert_uint_eq(events[i].number, expected++);
            if (events[i].kind == VOR_EVENT_PROGRESS)
                ck_assert_uint_eq(events[i].record.iteration, events[i].number - 3);
        }
    ck_assert_uint_eq(expected, 45);
    ck_assert_uint_eq(position.number, 44);
    vor_job_release(job);
}

VT_TEST(a_position_of_another_attempt_starts_from_the_first_event)
{
    struct vor_job *job = iterated(2, 2); /* 6 events: REPLACED is the first */
    static const struct vor_position elsewhere[] = {{1, 3}, {3, 1}, {2, 7}, {0, 0}, {2, 4000000}};

    for (size_t i = 0; i < sizeof elsewhere / sizeof elsewhere[0]; i++) {
        struct vor_position position = elsewhere[i];
        struct vor_event event;

        ck_assert_uint_eq(read_some(job, &position, VOR_READ_EVERY, &event, 1), 1);
        ck_assert_uint_eq(event.number, 1);
        ck_assert_uint_eq(position.attempt, 2);
    }
    vor_job_release(job);
}

VT_TEST(a_slow_reader_gets_the_latest_progress_and_every_change_of_state)
{
    struct vor_job *job = iterated(1, 1000);
    struct vor_position position = {0, 0};
    struct vor_event events[8];

    vor_job_stage(job, VOR_STAGE_ENCODE, 1000);
    progress(job, 1001); /* enters the stage before once more */
    progress(job, 1002);
    end_job(job);
    ck_assert_uint_eq(read_some(job, &position, VOR_READ_LATEST, events, 8), 8);
    for (int i = 0; i < 8; i++)
        ck_assert_int_eq(events[i].kind == VOR_EVENT_PROGRESS, i == 3 || i == 6);
    ck_assert_uint_eq(events[3].record.iteration, 1000);
    ck_assert_uint_eq(events[6].record.iteration, 1002);
    ck_assert_int_eq(events[7].kind, VOR_EVENT_END);
    ck_assert_uint_eq(events[7].number, 1008);
    vor_job_release(job);
}

VT_TEST(events_that_the_store_has_are_not_kept)
{
    struct vor_job *job = iterated(1, 20);
    struct vor_position position = {1, 23};
    struct vor_event_batch behind = {.position = {1, 22}};
    struct vor_event event;

    store(job);
    ck_assert(!vor_job_read(job, &behind));
    ck_assert_uint_eq(read_some(job, &position, VOR_READ_EVERY, &event, 1), 0);
    progress(job, 21);
    ck_assert(!vor_job_read(job, &behind));
    ck_assert_uint_eq(read_some(job, &position, VOR_READ_EVERY, &event, 1), 1);
    ck_assert_uint_eq(event.number, 24);
    ck_assert(vor_job_freeze(job));
    ck_assert_uint_eq(vor_job_piece(job).last, 24);
    vor_job_thaw(job);
    ck_assert(vor_job_restart(job, 0, 1000)); /* of the next attempt it has none */
    ck_assert_uint_eq(read_some(job, &position, VOR_READ_EVERY, &event, 1), 1);
    ck_assert_uint_eq(event.number, 1);
    vor_job_release(job);
}

VT_TEST(the_events_are_bounded_and_the_end_always_fits)
{
    struct vor_job *job = iterated(1, VOR_EVENTS_MAX + 100);
    struct vor_position position = {1, VOR_EVENTS_MAX - 1};
    struct vor_event event;

    end_job(job);
    ck_assert_uint_eq(read_some(job, &position, VOR_READ_EVERY, &event, 1), 1);
    ck_assert_int_eq(event.kind, VOR_EVENT_END);
    ck_assert_uint_eq(event.number, VOR_EVENTS_MAX);
    vor_job_release(job);
}

/* The longest request, with a record for every iteration and every step, and the state around it.
 */
VT_TEST(the_longest_request_loses_no_event)
{
    double most = vor_parameter_info(VOR_PARAM_ITERATIONS)->max + 1 +
                  vor_parameter_info(VOR_PARAM_POLISH)->max;

    ck_assert_double_le(most + 8, VOR_EVENTS_MAX);
}

VT_TEST(only_attempt_dot_number_is_a_position)
{
    static const char *const bad[] = {
        "",     "1",    "1.",   ".1",   "1.2.3", "a.1",          "1.b",           " 1.2",
        "1.2 ", "-1.2", "1.-2", "1..2", "+1.+2", "4294967296.1", "1.99999999999", "0x1.2"};
    struct vor_position position = {7, 8};

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        ck_assert_msg(!vor_position_parse(&position, bad[i]), "\"%s\"", bad[i]);
    ck_assert_uint_eq(position.attempt, 7);
    ck_assert(vor_position_parse(&position, "4294967295.0"));
    ck_assert_uint_eq(position.attempt, 4294967295u);
    ck_assert_uint_eq(position.number, 0);
}

struct counter {
    atomic_int wakes, ends;
};

static void count_wake(void *ctx, enum vor_event_kind kind)
{
    struct counter *counter = ctx;

    atomic_fetch_add(&counter->wakes, 1);
    atomic_fetch_add(&counter->ends, kind == VOR_EVENT_END);
}

VT_TEST(subscribers_are_woken_once_an_event_until_they_leave)
{
    struct vor_job *job = iterated(1, 0);
    struct counter stays = {0}, leaves = {0};
    struct vor_subscriber a = {.wake = count_wake, .ctx = &stays};
    struct vor_subscriber b = {.wake = count_wake, .ctx = &leaves};

    vor_job_subscribe(job, &a);
    vor_job_subscribe(job, &b);
    vor_job_stage(job, VOR_STAGE_OPTIMIZE, 1000);
    progress(job, 1);
    vor_job_unsubscribe(job, &b);
    vor_job_unsubscribe(job, &b);
    end_job(job);
    progress(job, 2); /* ignored: nobody is woken */
    ck_assert_int_eq(atomic_load(&stays.wakes), 3);
    ck_assert_int_eq(atomic_load(&stays.ends), 1);
    ck_assert_int_eq(atomic_load(&leaves.wakes), 2);
    vor_job_unsubscribe(job, &a);
    vor_job_release(job);
}

/* A reader that sleeps until woken, as the HTTP layer does. */
struct sleeper {
    struct vor_job *job;
    struct vor_subscriber subscriber;
    pthread_mutex_t mutex;
    pthread_cond_t cond;
    int woken;
    uint32_t last, seen;
    int in_order;
};

static void wake_sleeper(void *ctx, enum vor_event_kind kind)
{
    struct sleeper *sleeper = ctx;

    (void)kind;
    pthread_mutex_lock(&sleeper->mutex);
    sleeper->woken = 1;
    pthread_cond_signal(&sleeper->cond);
    pthread_mutex_unlock(&sleeper->mutex);
}

static void *read_all(void *arg)
{
    struct sleeper *sleeper = arg;
    struct vor_position position = {0, 0};
    enum vor_event_kind kind = VOR_EVENT_STATUS;

    vor_job_subscribe(sleeper->job, &sleeper->subscriber);
    while (kind != VOR_EVENT_END) {
        struct vor_event event;

        pthread_mutex_lock(&sleeper->mutex);
        while (read_some(sleeper->job, &position, VOR_READ_LATEST, &event, 1) == 0) {
            while (!sleeper->woken)
                pthread_cond_wait(&sleeper->cond, &sleeper->mutex);
            sleeper->woken = 0;
        }
        pthread_mutex_unlock(&sleeper->mutex);
        if (event.number <= sleeper->last)
            sleeper->in_order = 0;
        sleeper->last = event.number;
        sleeper->seen++;
        kind = event.kind;
    }
    vor_job_unsubscribe(sleeper->job, &sleeper->subscriber);
    return NULL;
}

VT_TEST(readers_in_threads_miss_no_wake_and_no_end)
{
    enum { READERS = 6, ITERATIONS = 2000 };
    struct sleeper sleepers[READERS];
    pthread_t threads[READERS];
    struct vor_job *job = iterated(1, 0);

    memset(sleepers, 0, sizeof sleepers);
    for (int i = 0; i < READERS; i++) {
        sleepers[i].job = job;
        sleepers[i].in_order = 1;
        sleepers[i].subscriber = (struct vor_subscriber){.wake = wake_sleeper, .ctx = &sleepers[i]};
        pthread_mutex_init(&sleepers[i].mutex, NULL);
        pthread_cond_init(&sleepers[i].cond, NULL);
        ck_assert_int_eq(pthread_create(&threads[i], NULL, read_all, &sleepers[i]), 0);
    }
    for (uint32_t i = 1; i <= ITERATIONS; i++)
        progress(job, i);
    end_job(job);
    for (int i = 0; i < READERS; i++) {
        pthread_join(threads[i], NULL);
        ck_assert(sleepers[i].in_order);
        ck_assert_uint_eq(sleepers[i].last, ITERATIONS + 4);
    }
    vor_job_release(job);
}

VT_TEST(statuses_are_found_by_their_words)
{
    for (int i = 0; i < VOR_JOB_STATUSES; i++)
        ck_assert_int_eq(vor_job_status_find(vor_job_status_word((enum vor_job_status)i)), i);
    ck_assert_int_eq(vor_job_status_find("done"), VOR_JOB_STATUSES);
    ck_assert_str_eq(vor_stage_word(VOR_STAGE_OPTIMIZE), "optimize");
    ck_assert_str_eq(vor_event_word(VOR_EVENT_REPLACED), "replaced");
}
