/* The bus: every reader sees the same numbers, whenever it comes and however slow it is. */
#include "core/spec.h"
#include "server/jobs/bus.h"
#include "tests/support/vt.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static struct vor_event event_of(enum vor_event_kind kind, uint32_t i)
{
    struct vor_event event = {.kind = kind,
                              .status =
                                  kind == VOR_EVENT_END ? VOR_JOB_SUCCESSFUL : VOR_JOB_RUNNING,
                              .stage = VOR_STAGE_OPTIMIZE,
                              .progress = 10,
                              .time_ms = 1700000000000 + i};

    if (kind == VOR_EVENT_PROGRESS)
        event.record = (struct vor_record){.iteration = i, .step = i};
    return event;
}

static void publish(struct vor_bus *bus, enum vor_event_kind kind, uint32_t i)
{
    struct vor_event event = event_of(kind, i);

    ck_assert_int_eq(vor_bus_publish(bus, &event), VOR_OK);
}

/* status, then `iterations` progress events, then perhaps the end. */
static struct vor_bus *filled(uint32_t attempt, uint32_t iterations, int ended)
{
    struct vor_bus *bus = vor_bus_create(attempt);

    publish(bus, VOR_EVENT_STATUS, 0);
    for (uint32_t i = 1; i <= iterations; i++)
        publish(bus, VOR_EVENT_PROGRESS, i);
    if (ended)
        publish(bus, VOR_EVENT_END, iterations + 1);
    return bus;
}

START_TEST(events_are_numbered_from_one_without_gaps)
{
    struct vor_bus *bus = filled(3, 40, 1);
    struct vor_position position = {0, 0};
    struct vor_event events[64];
    size_t count = vor_bus_read(bus, &position, VOR_READ_EVERY, events, 64);

    ck_assert_uint_eq(count, 42);
    for (uint32_t i = 0; i < count; i++) {
        ck_assert_uint_eq(events[i].attempt, 3);
        ck_assert_uint_eq(events[i].number, i + 1);
    }
    ck_assert_uint_eq(events[7].record.iteration, 7);
    ck_assert_uint_eq(position.attempt, 3);
    ck_assert_uint_eq(position.number, 42);
    ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_EVERY, events, 64), 0);
    vor_bus_release(bus);
}
END_TEST

START_TEST(a_reader_who_comes_back_gets_what_it_missed)
{
    struct vor_bus *bus = filled(1, 300, 0);
    struct vor_position position;
    struct vor_event event;

    ck_assert(vor_position_parse(&position, "1.100"));
    for (uint32_t number = 101; number <= 301; number++) {
        ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_EVERY, &event, 1), 1);
        ck_assert_uint_eq(event.number, number);
    }
    ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_EVERY, &event, 1), 0);
    vor_bus_release(bus);
}
END_TEST

START_TEST(a_position_of_another_attempt_starts_from_the_first_event)
{
    struct vor_bus *bus = filled(2, 5, 0);
    static const struct vor_position elsewhere[] = {{1, 3}, {3, 1}, {2, 7}, {0, 0}, {2, 4000000}};

    for (size_t i = 0; i < sizeof elsewhere / sizeof elsewhere[0]; i++) {
        struct vor_position position = elsewhere[i];
        struct vor_event event;

        ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_EVERY, &event, 1), 1);
        ck_assert_uint_eq(event.number, 1);
        ck_assert_uint_eq(position.attempt, 2);
    }
    vor_bus_release(bus);
}
END_TEST

START_TEST(a_slow_reader_gets_the_latest_progress_and_every_change_of_state)
{
    struct vor_bus *bus = filled(1, 1000, 0);
    struct vor_position position = {0, 0};
    struct vor_event events[8];

    publish(bus, VOR_EVENT_STATUS, 2000);
    publish(bus, VOR_EVENT_PROGRESS, 1001);
    publish(bus, VOR_EVENT_PROGRESS, 1002);
    publish(bus, VOR_EVENT_END, 3000);
    ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_LATEST, events, 8), 5);
    ck_assert_int_eq(events[0].kind, VOR_EVENT_STATUS);
    ck_assert_uint_eq(events[1].record.iteration, 1000);
    ck_assert_int_eq(events[2].kind, VOR_EVENT_STATUS);
    ck_assert_uint_eq(events[3].record.iteration, 1002);
    ck_assert_int_eq(events[4].kind, VOR_EVENT_END);
    ck_assert_uint_eq(events[4].number, 1005);
    vor_bus_release(bus);
}
END_TEST

START_TEST(a_reader_with_little_room_loses_nothing)
{
    struct vor_bus *bus = filled(1, 20, 1);
    struct vor_position position = {0, 0};
    struct vor_event events[3];
    uint32_t expected = 1;
    size_t count;

    while ((count = vor_bus_read(bus, &position, VOR_READ_EVERY, events, 3)) > 0)
        for (size_t i = 0; i < count; i++)
            ck_assert_uint_eq(events[i].number, expected++);
    ck_assert_uint_eq(expected, 23);
    vor_bus_release(bus);
}
END_TEST

START_TEST(nothing_follows_the_end)
{
    struct vor_bus *bus = filled(1, 2, 1);
    struct vor_position end = {0, 0}, position = {0, 0};
    struct vor_event events[8];

    publish(bus, VOR_EVENT_PROGRESS, 3);
    publish(bus, VOR_EVENT_END, 4);
    ck_assert(vor_bus_ended(bus, &end));
    ck_assert_uint_eq(end.number, 4);
    ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_EVERY, events, 8), 4);
    vor_bus_release(bus);
    bus = filled(1, 2, 0);
    ck_assert(!vor_bus_ended(bus, NULL));
    vor_bus_release(bus);
}
END_TEST

START_TEST(the_events_are_bounded_and_the_end_always_fits)
{
    struct vor_bus *bus = filled(1, VOR_EVENTS_MAX + 100, 1);
    struct vor_position end = {0, 0};

    ck_assert(vor_bus_ended(bus, &end));
    ck_assert_uint_eq(end.number, VOR_EVENTS_MAX);
    vor_bus_release(bus);
}
END_TEST

/* The longest request, with a record for every iteration and every step, and the state around it.
 */
START_TEST(the_longest_request_loses_no_event)
{
    double most = vor_parameter_info(VOR_PARAM_ITERATIONS)->max + 1 +
                  vor_parameter_info(VOR_PARAM_POLISH)->max;

    ck_assert_double_le(most + 8, VOR_EVENTS_MAX);
}
END_TEST

START_TEST(only_attempt_dot_number_is_a_position)
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
END_TEST

struct counter {
    atomic_int wakes, ends;
};

static void count_wake(void *ctx, enum vor_event_kind kind)
{
    struct counter *counter = ctx;

    atomic_fetch_add(&counter->wakes, 1);
    atomic_fetch_add(&counter->ends, kind == VOR_EVENT_END);
}

START_TEST(subscribers_are_woken_once_an_event_until_they_leave)
{
    struct vor_bus *bus = vor_bus_create(1);
    struct counter stays = {0}, leaves = {0};
    struct vor_subscriber a = {.wake = count_wake, .ctx = &stays};
    struct vor_subscriber b = {.wake = count_wake, .ctx = &leaves};

    vor_bus_subscribe(bus, &a);
    vor_bus_subscribe(bus, &b);
    publish(bus, VOR_EVENT_STATUS, 0);
    publish(bus, VOR_EVENT_PROGRESS, 1);
    vor_bus_unsubscribe(bus, &b);
    vor_bus_unsubscribe(bus, &b);
    publish(bus, VOR_EVENT_END, 2);
    publish(bus, VOR_EVENT_PROGRESS, 3); /* ignored: nobody is woken */
    ck_assert_int_eq(atomic_load(&stays.wakes), 3);
    ck_assert_int_eq(atomic_load(&stays.ends), 1);
    ck_assert_int_eq(atomic_load(&leaves.wakes), 2);
    vor_bus_unsubscribe(bus, &a);
    vor_bus_release(bus);
}
END_TEST

/* A reader that sleeps until woken, as the HTTP layer does. */
struct sleeper {
    struct vor_bus *bus;
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

    vor_bus_subscribe(sleeper->bus, &sleeper->subscriber);
    while (kind != VOR_EVENT_END) {
        struct vor_event event;

        pthread_mutex_lock(&sleeper->mutex);
        while (vor_bus_read(sleeper->bus, &position, VOR_READ_LATEST, &event, 1) == 0) {
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
    vor_bus_unsubscribe(sleeper->bus, &sleeper->subscriber);
    return NULL;
}

START_TEST(readers_in_threads_miss_no_wake_and_no_end)
{
    enum { READERS = 6, ITERATIONS = 2000 };
    struct sleeper sleepers[READERS];
    pthread_t threads[READERS];
    struct vor_bus *bus = vor_bus_create(1);

    memset(sleepers, 0, sizeof sleepers);
    for (int i = 0; i < READERS; i++) {
        sleepers[i].bus = bus;
        sleepers[i].in_order = 1;
        sleepers[i].subscriber = (struct vor_subscriber){.wake = wake_sleeper, .ctx = &sleepers[i]};
        pthread_mutex_init(&sleepers[i].mutex, NULL);
        pthread_cond_init(&sleepers[i].cond, NULL);
        ck_assert_int_eq(pthread_create(&threads[i], NULL, read_all, &sleepers[i]), 0);
    }
    for (uint32_t i = 1; i <= ITERATIONS; i++)
        publish(bus, VOR_EVENT_PROGRESS, i);
    publish(bus, VOR_EVENT_END, ITERATIONS + 1);
    for (int i = 0; i < READERS; i++) {
        pthread_join(threads[i], NULL);
        ck_assert(sleepers[i].in_order);
        ck_assert_uint_eq(sleepers[i].last, ITERATIONS + 1);
    }
    vor_bus_release(bus);
}
END_TEST

START_TEST(statuses_are_found_by_their_words)
{
    for (int i = 0; i < VOR_JOB_STATUSES; i++)
        ck_assert_int_eq(vor_job_status_find(vor_job_status_word((enum vor_job_status)i)), i);
    ck_assert_int_eq(vor_job_status_find("done"), VOR_JOB_STATUSES);
    ck_assert_str_eq(vor_stage_word(VOR_STAGE_OPTIMIZE), "optimize");
    ck_assert_str_eq(vor_event_word(VOR_EVENT_REPLACED), "replaced");
}
END_TEST

void vt_suite(Suite *suite)
{
    vt_add(suite, events_are_numbered_from_one_without_gaps);
    vt_add(suite, a_reader_who_comes_back_gets_what_it_missed);
    vt_add(suite, a_position_of_another_attempt_starts_from_the_first_event);
    vt_add(suite, a_slow_reader_gets_the_latest_progress_and_every_change_of_state);
    vt_add(suite, a_reader_with_little_room_loses_nothing);
    vt_add(suite, nothing_follows_the_end);
    vt_add(suite, the_events_are_bounded_and_the_end_always_fits);
    vt_add(suite, the_longest_request_loses_no_event);
    vt_add(suite, only_attempt_dot_number_is_a_position);
    vt_add(suite, subscribers_are_woken_once_an_event_until_they_leave);
    vt_add(suite, readers_in_threads_miss_no_wake_and_no_end);
    vt_add(suite, statuses_are_found_by_their_words);
}
