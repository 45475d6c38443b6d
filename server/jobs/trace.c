#include "server/jobs/trace.h"

#include <stdlib.h>
#include <string.h>

/* A piece, little endian: the magic, attempt, count of events and bytes of a record (4 bytes each);
 * then for every event kind, status, stage and progress (a byte each) and time (8); a progress
 * event goes on with the estimate (8) and its record. A record has the members of its table in
 * their order, so a build that knows more of them reads those that are there, and one that knows
 * fewer skips the rest. A piece with another magic is refused. */
enum { MAGIC_SIZE = 4, HEADER_SIZE = 16, EVENT_SIZE = 12, ETA_SIZE = 8 };

static const char magic[MAGIC_SIZE] = {'V', 'T', 'R', '3'};

static uint8_t *put(uint8_t *at, uint64_t value, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++)
        *at++ = (uint8_t)(value >> (8 * i));
    return at;
}

static const uint8_t *get(const uint8_t *at, uint64_t *value, size_t bytes)
{
    *value = 0;
    for (size_t i = 0; i < bytes; i++)
        *value |= (uint64_t)*at++ << (8 * i);
    return at;
}

static uint8_t *put_real(uint8_t *at, double value)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof bits);
    return put(at, bits, 8);
}

static const uint8_t *get_real(const uint8_t *at, double *value)
{
    uint64_t bits;

    at = get(at, &bits, 8);
    memcpy(value, &bits, sizeof bits);
    return at;
}

/* Bytes that a member of a record takes; numbers and words are all it has. */
static size_t packed_size(const struct vor_member *row)
{
    return row->kind == VOR_MEMBER_U32 || row->kind == VOR_MEMBER_WORD ? 4 : 8;
}

static size_t record_size(void)
{
    size_t size = 0;

    for (unsigned i = 0; i < vor_record_members.count; i++)
        size += packed_size(&vor_record_members.rows[i]);
    return size;
}

static uint8_t *put_record(uint8_t *at, const struct vor_record *record)
{
    for (unsigned i = 0; i < vor_record_members.count; i++) {
        const struct vor_member *row = &vor_record_members.rows[i];
        const void *member = vor_member_at(row, record);

        if (row->kind == VOR_MEMBER_REAL)
            at = put_real(at, *(const double *)member);
        else if (row->kind == VOR_MEMBER_U64)
            at = put(at, *(const uint64_t *)member, 8);
        else
            at = put(at, *(const uint32_t *)member, 4);
    }
    return at;
}

/* Reads the members that `size` bytes hold; false when one of them is a word that there is not. */
static int get_record(struct vor_record *out, const uint8_t *at, size_t size)
{
    vor_record_unknown_best(out); /* until it is read */
    for (unsigned i = 0; i < vor_record_members.count; i++) {
        const struct vor_member *row = &vor_record_members.rows[i];
        void *member = (unsigned char *)out + row->offset;
        uint64_t value;

        if (size < packed_size(row))
            return 1;
        size -= packed_size(row);
        if (row->kind == VOR_MEMBER_REAL) {
            at = get_real(at, member);
            continue;
        }
        at = get(at, &value, packed_size(row));
        if (row->kind == VOR_MEMBER_WORD && value >= row->word_count)
            return 0;
        if (row->kind == VOR_MEMBER_U64)
            *(uint64_t *)member = value;
        else
            *(uint32_t *)member = (uint32_t)value;
    }
    return 1;
}

static uint8_t *put_event(uint8_t *at, const struct vor_event *event)
{
    at = put(at, (uint64_t)event->kind, 1);
    at = put(at, (uint64_t)event->status, 1);
    at = put(at, (uint64_t)event->stage, 1);
    at = put(at, (uint64_t)event->progress, 1);
    at = put(at, (uint64_t)event->time_ms, 8);
    if (event->kind != VOR_EVENT_PROGRESS)
        return at;
    return put_record(put_real(at, event->eta_seconds), &event->record);
}

/* The bytes of a piece that are still to be read. */
struct trace {
    const uint8_t *at, *end;
    uint64_t record; /* bytes of a record */
};

/* The estimate and the record of a progress event; false when the bytes run out or are none. */
static int get_progress(struct vor_event *out, struct trace *trace)
{
    size_t left = (size_t)(trace->end - trace->at);

    if (left < ETA_SIZE || left - ETA_SIZE < trace->record)
        return 0;
    trace->at = get_real(trace->at, &out->eta_seconds);
    if (!get_record(&out->record, trace->at, trace->record))
        return 0;
    trace->at += trace->record;
    return 1;
}

/* False when the bytes run out or are no event. */
static int get_event(struct vor_event *out, struct trace *trace)
{
    uint64_t kind, status, stage, progress, time_ms;
    const uint8_t *at = trace->at;

    if (trace->end - at < EVENT_SIZE)
        return 0;
    at = get(get(get(get(at, &kind, 1), &status, 1), &stage, 1), &progress, 1);
    trace->at = get(at, &time_ms, 8);
    if (kind >= VOR_EVENT_KINDS || status >= VOR_JOB_STATUSES || stage >= VOR_STAGES ||
        progress > 100)
        return 0;
    *out = (struct vor_event){.kind = (enum vor_event_kind)kind,
                              .status = (enum vor_job_status)status,
                              .stage = (enum vor_stage)stage,
                              .progress = (int)progress,
                              .time_ms = (int64_t)time_ms};
    return kind != VOR_EVENT_PROGRESS || get_progress(out, trace);
}

vor_status vor_trace_pack(struct vor_bus *bus, uint32_t after, struct vor_event_piece *piece,
                          uint8_t **bytes, struct vor_error *err)
{
    struct vor_position newest = vor_bus_newest(bus), position = {newest.attempt, after};
    uint32_t count = newest.number - after;
    struct vor_event event;
    uint8_t *at;

    *piece = (struct vor_event_piece){.last = newest.number};
    *bytes = NULL;
    if (count == 0)
        return VOR_OK;
    *bytes = malloc(HEADER_SIZE + count * (EVENT_SIZE + ETA_SIZE + record_size()));
    if (*bytes == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%u events of a job", (unsigned)count);
    memcpy(*bytes, magic, sizeof magic);
    at = put(put(*bytes + sizeof magic, newest.attempt, 4), count, 4);
    at = put(at, record_size(), 4);
    while (position.number < newest.number &&
           vor_bus_read(bus, &position, VOR_READ_EVERY, &event, 1) == 1)
        at = put_event(at, &event);
    piece->data = *bytes;
    piece->size = (size_t)(at - *bytes);
    return VOR_OK;
}

/* Reads the header of a piece; false when it is none. */
static int get_header(struct trace *trace, uint64_t *count, const struct vor_event_piece *piece)
{
    uint64_t attempt;

    if (piece->size < HEADER_SIZE || memcmp(piece->data, magic, sizeof magic) != 0)
        return 0;
    (void)get(get(get(piece->data + MAGIC_SIZE, &attempt, 4), count, 4), &trace->record, 4);
    trace->at = piece->data + HEADER_SIZE;
    trace->end = piece->data + piece->size;
    return trace->record > 0;
}

vor_status vor_trace_unpack(struct vor_bus *bus, const struct vor_event_piece *piece,
                            struct vor_error *err)
{
    struct trace trace;
    uint64_t count;

    if (!get_header(&trace, &count, piece))
        return vor_fail(err, VOR_E_FORMAT, "the stored events of the job are damaged (%zu bytes)",
                        piece->size);
    for (uint64_t i = 0; i < count; i++) {
        struct vor_event event;

        if (!get_event(&event, &trace))
            return vor_fail(err, VOR_E_FORMAT,
                            "event %llu of the stored events of the job is damaged",
                            (unsigned long long)i + 1);
        if (vor_bus_publish(bus, &event) != VOR_OK)
            return vor_fail(err, VOR_E_NOMEM, "%llu events of a job", (unsigned long long)count);
    }
    return VOR_OK;
}
