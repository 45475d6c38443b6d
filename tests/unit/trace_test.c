/* Events in pieces: every one comes back, and bytes that are none are refused. */
#include "server/jobs/trace.h"
#include "tests/support/vt.h"

#include <math.h>
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

static void publish(struct vor_bus *bus, enum vor_event_kind kind, uint32_t i)
{
    struct vor_event event = event_of(kind, i);

    ck_assert_int_eq(vor_bus_publish(bus, &event), VOR_OK);
}

/* status, then `records` progress events, then perhaps the end. */
static struct vor_bus *filled(uint32_t attempt, uint32_t records, int ended)
{
    struct vor_bus *bus = vor_bus_create(attempt);

    publish(bus, VOR_EVENT_STATUS, 0);
    for (uint32_t i = 1; i <= records; i++)
        publish(bus, VOR_EVENT_PROGRESS, i);
    if (ended)
        publish(bus, VOR_EVENT_END, records + 1);
    return bus;
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

static vor_status unpack(struct vor_bus **out, const uint8_t *bytes, size_t size)
{
    const struct vor_event_piece piece = {.data = bytes, .size = size};
    struct vor_bus *bus = vor_bus_create(1);
    vor_status status = vor_trace_unpack(bus, &piece, &vt_err);

    if (status == VOR_OK)
        *out = bus;
    else
        vor_bus_release(bus);
    return status;
}

/* In two pieces, the second of which may be empty. */
START_TEST(events_come_back_as_they_were)
{
    struct vor_bus *bus = filled(4, (uint32_t)_i * 11, 0), *back = vor_bus_create(4);
    struct vor_position a = {0, 0}, b = {0, 0};
    struct vor_event first, second;
    struct vor_event_piece pieces[2];
    uint8_t *bytes[2];

    vt_assert_ok(vor_trace_pack(bus, 0, &pieces[0], &bytes[0], &vt_err));
    ck_assert_uint_eq(pieces[0].last, (unsigned)_i * 11 + 1);
    for (int i = 0; i < _i % 3; i++)
        publish(bus, i == 1 ? VOR_EVENT_END : VOR_EVENT_PROGRESS, 99);
    vt_assert_ok(vor_trace_pack(bus, pieces[0].last, &pieces[1], &bytes[1], &vt_err));
    ck_assert_uint_eq(pieces[1].last, pieces[0].last + (unsigned)_i % 3);
    ck_assert_int_eq(pieces[1].size > 0, _i % 3 > 0);
    for (int i = 0; i < 2; i++) {
        if (pieces[i].size > 0)
            vt_assert_ok(vor_trace_unpack(back, &pieces[i], &vt_err));
        free(bytes[i]);
    }
    while (vor_bus_read(bus, &a, VOR_READ_EVERY, &first, 1) == 1) {
        ck_assert_uint_eq(vor_bus_read(back, &b, VOR_READ_EVERY, &second, 1), 1);
        assert_same(&first, &second);
    }
    ck_assert_uint_eq(vor_bus_read(back, &b, VOR_READ_EVERY, &second, 1), 0);
    ck_assert_int_eq(vor_bus_ended(back, NULL), _i % 3 == 2);
    vor_bus_release(bus);
    vor_bus_release(back);
}
END_TEST

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
    static const size_t sizes[] = {4, 4, 8, 8, 8, 8, 8, 8, 8, 4, 4, 4, 4, 4, 4, 8, 8, 8};
    size_t record = more;

    ck_assert_uint_eq(sizeof sizes / sizeof sizes[0], vor_record_members.count);
    for (size_t i = 0; i < members; i++)
        record += sizes[i];
    add_header(bytes, '3', 1, 2);
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
START_TEST(records_with_other_members_are_read)
{
    for (size_t members = 1; members <= vor_record_members.count; members++) {
        size_t more = members == vor_record_members.count ? 12 : 0;
        struct vor_position position = {0, 0};
        struct vor_event events[3];
        struct vor_bus *bus = NULL;
        struct bytes bytes;

        add_trace_of(&bytes, members, more);
        vt_assert_ok(unpack(&bus, bytes.data, bytes.size));
        ck_assert_uint_eq(vor_bus_read(bus, &position, VOR_READ_EVERY, events, 3), 2);
        ck_assert_double_eq(events[0].eta_seconds, 1.5);
        ck_assert_uint_eq(events[0].record.iteration, 1);
        ck_assert_uint_eq(events[0].record.held, members >= 8);
        ck_assert_int_eq(events[0].record.stage,
                         members >= 10 ? VOR_RUN_STAGE_POLISH : VOR_RUN_STAGE_ITERATE);
        ck_assert_uint_eq(events[0].record.ahead, members >= 13);
        ck_assert_int_eq(isnan(events[0].record.best_delta) != 0, members < 16);
        ck_assert_int_eq(events[1].status, VOR_JOB_FAILED);
        vor_bus_release(bus);
    }
}
END_TEST

START_TEST(a_stage_that_there_is_not_is_refused)
{
    struct vor_bus *bus = NULL;
    struct bytes bytes;
    size_t stage;

    add_trace_of(&bytes, vor_record_members.count, 0);
    stage = bytes.size - 12 - 48;
    ck_assert_uint_eq(bytes.data[stage], VOR_RUN_STAGE_POLISH);
    bytes.data[stage] = VOR_RUN_STAGE_COUNT;
    vt_assert_fails(VOR_E_FORMAT, unpack(&bus, bytes.data, bytes.size));
    ck_assert_ptr_null(bus);
}
END_TEST

/* Every beginning of a trace is refused; each is a block of its own, so that reading past it is
 * seen. */
static void assert_no_beginning_is_read(const uint8_t *bytes, size_t size)
{
    struct vor_bus *back = NULL;

    for (size_t cut = 0; cut < size; cut++) {
        uint8_t *part = malloc(cut + 1);

        memcpy(part, bytes, cut);
        vt_assert_fails(VOR_E_FORMAT, unpack(&back, part, cut));
        free(part);
    }
    ck_assert_ptr_null(back);
}

/* Kind, status, stage and progress of the first event, at `first`, and the count of events. */
static void assert_no_damage_is_read(uint8_t *bytes, size_t size, size_t first)
{
    struct vor_bus *back = NULL;

    for (size_t at = first; at < first + 4; at++) {
        uint8_t kept = bytes[at];

        bytes[at] = 101;
        vt_assert_fails(VOR_E_FORMAT, unpack(&back, bytes, size));
        bytes[at] = kept;
    }
    vt_assert_ok(unpack(&back, bytes, size));
    vor_bus_release(back);
    back = NULL;
    bytes[8] = 0xff; /* more events than there are bytes */
    bytes[11] = 0xff;
    vt_assert_fails(VOR_E_FORMAT, unpack(&back, bytes, size));
    ck_assert_ptr_null(back);
}

START_TEST(a_damaged_trace_is_refused)
{
    struct vor_bus *bus = filled(1, 3, 1), *back = NULL;
    struct vor_event_piece piece;
    uint8_t *bytes;
    size_t size;

    vt_assert_ok(vor_trace_pack(bus, 0, &piece, &bytes, &vt_err));
    size = piece.size;
    assert_no_beginning_is_read(bytes, size);
    for (char version = '0'; version <= '9'; version++) {
        bytes[3] = (uint8_t)version;
        if (version != '3')
            vt_assert_fails(VOR_E_FORMAT, unpack(&back, bytes, size));
    }
    bytes[3] = '3';
    for (size_t at = 12; at < 16; at++) { /* bytes of a record: none, and too many */
        uint8_t kept = bytes[at];

        bytes[at] = at == 12 ? 0 : 0xff;
        vt_assert_fails(VOR_E_FORMAT, unpack(&back, bytes, size));
        bytes[at] = kept;
    }
    assert_no_damage_is_read(bytes, size, 16);
    free(bytes);
    vor_bus_release(bus);
}
END_TEST

void vt_suite(Suite *suite)
{
    vt_add_loop(suite, events_come_back_as_they_were, 20);
    vt_add(suite, records_with_other_members_are_read);
    vt_add(suite, a_stage_that_there_is_not_is_refused);
    vt_add(suite, a_damaged_trace_is_refused);
}
