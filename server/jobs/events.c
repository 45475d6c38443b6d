#include "server/jobs/events.h"

#include <assert.h>
#include <string.h>

static const char *const event_words[VOR_EVENT_KINDS] = {
#define EVENT_ROW(name, word) word,
    VOR_EVENT_TABLE(EVENT_ROW)
#undef EVENT_ROW
};

const char *vor_event_word(enum vor_event_kind kind)
{
    return event_words[kind];
}

/* Reads a decimal number that fits; returns what follows it, NULL when there is none. */
static const char *parse_u32(uint32_t *out, const char *text)
{
    uint64_t value = 0;
    int digits = 0;

    for (; *text >= '0' && *text <= '9' && digits < 10; text++, digits++)
        value = 10 * value + (uint64_t)(*text - '0');
    if (digits == 0 || value > UINT32_MAX)
        return NULL;
    *out = (uint32_t)value;
    return text;
}

int vor_position_parse(struct vor_position *out, const char *text)
{
    struct vor_position position;

    text = parse_u32(&position.attempt, text);
    if (text == NULL || *text != '.')
        return 0;
    text = parse_u32(&position.number, text + 1);
    if (text == NULL || *text != '\0')
        return 0;
    *out = position;
    return 1;
}

/* --- batches ---------------------------------------------------------------------------------- */

void vor_event_batch_begin(struct vor_event_batch *batch, uint32_t attempt, uint32_t last)
{
    if (batch->position.attempt != attempt || batch->position.number > last)
        batch->position = (struct vor_position){attempt, 0};
}

int vor_event_batch_add(struct vor_event_batch *batch, const struct vor_event *event)
{
    if (batch->count > 0 && batch->how == VOR_READ_LATEST && event->kind == VOR_EVENT_PROGRESS &&
        batch->events[batch->count - 1].kind == VOR_EVENT_PROGRESS)
        batch->count--;
    if (batch->count == batch->max)
        return 0;
    batch->events[batch->count++] = *event;
    batch->position.number = event->number;
    return 1;
}

/* --- pieces ----------------------------------------------------------------------------------- */

/* A piece, little endian: the magic, attempt, count of events and bytes of a record (4 bytes each);
 * then for every event kind, status, stage and progress (a byte each) and time (8); a progress
 * event goes on with the estimate (8) and its record. A record has the members of its table in
 * their order, so a build that knows more of them reads those that are there, and one that knows
 * fewer skips the rest. A piece with another magic is refused. */
enum { MAGIC_SIZE = 4, COUNT_AT = 8, HEADER_SIZE = 16, EVENT_SIZE = 12, ETA_SIZE = 8 };
enum { RECORD_MAX = 256 }; /* bytes */

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

/* The bytes of a piece that are still to be read. */
struct trace {
    const uint8_t *at, *end;
    uint64_t record; /* bytes of a record */
};

/* False when the bytes run out or are no event. */
static int get_event(struct vor_event *out, struct trace *trace)
{
    size_t left;
    uint64_t kind, status, stage, progress, time_ms;
    const uint8_t *at = trace->at;

    if (trace->end - at < EVENT_SIZE)
        return 0;
    at = get(get(get(get(at, &kind, 1), &status, 1), &stage, 1), &progress, 1);
    trace->at = get(at, &time_ms, 8);
    if (kind >= VOR_EVENT_KINDS || status >= VOR_JOB_STATUSES || stage >= VOR_STAGES ||
        progress > 100)
        return 0;
    out->kind = (enum vor_event_kind)kind;
    out->status = (enum vor_job_status)status;
    out->stage = (enum vor_stage)stage;
    out->progress = (int)progress;
    out->time_ms = (int64_t)time_ms;
    if (kind != VOR_EVENT_PROGRESS)
        return 1;
    /* The estimate and the record; false when the bytes run out or are none. */
    left = (size_t)(trace->end - trace->at);
    if (left < ETA_SIZE || left - ETA_SIZE < trace->record)
        return 0;
    trace->at = get_real(trace->at, &out->eta_seconds);
    if (!get_record(&out->record, trace->at, trace->record))
        return 0;
    trace->at += trace->record;
    return 1;
}

vor_status vor_events_pack(struct vor_text *piece, const struct vor_event *event)
{
    uint8_t bytes[HEADER_SIZE + EVENT_SIZE + ETA_SIZE + RECORD_MAX], *at = bytes;
    uint64_t count = 0;

    assert(record_size() <= RECORD_MAX);
    if (piece->size == 0) {
        memcpy(at, magic, sizeof magic);
        at = put(put(put(at + MAGIC_SIZE, event->attempt, 4), 0, 4), record_size(), 4);
    }
    at = put(at, (uint64_t)event->kind, 1);
    at = put(at, (uint64_t)event->status, 1);
    at = put(at, (uint64_t)event->stage, 1);
    at = put(at, (uint64_t)event->progress, 1);
    at = put(at, (uint64_t)event->time_ms, 8);
    if (event->kind == VOR_EVENT_PROGRESS)
        at = put_record(put_real(at, event->eta_seconds), &event->record);
    vor_text_append(piece, bytes, (size_t)(at - bytes));
    if (piece->failed) {
        piece->failed = 0;
        return VOR_E_NOMEM;
    }
    (void)get((const uint8_t *)piece->data + COUNT_AT, &count, 4);
    (void)put((uint8_t *)piece->data + COUNT_AT, count + 1, 4);
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
    return trace->record > 0 && *count <= piece->last;
}

int vor_events_unpack(struct vor_event_batch *batch, const struct vor_event_piece *piece)
{
    size_t size;
    struct trace trace;
    uint64_t count;

    if (piece->size == 0)
        return 1;
    if (!get_header(&trace, &count, piece))
        return -1;
    for (uint32_t number = piece->last - (uint32_t)count + 1; count > 0; count--, number++) {
        struct vor_event event = {.attempt = batch->position.attempt, .number = number};

        if (number <= batch->position.number) {
            size = EVENT_SIZE;
            if (trace.at < trace.end && trace.at[0] == VOR_EVENT_PROGRESS)
                size += ETA_SIZE + (size_t)trace.record;
            if ((size_t)(trace.end - trace.at) < size)
                return -1;
            trace.at += size; /* nobody wants it */
            continue;
        }
        if (!get_event(&event, &trace))
            return -1;
        if (!vor_event_batch_add(batch, &event))
            return 0;
    }
    return 1;
}
