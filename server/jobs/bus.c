#include "server/jobs/bus.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct vor_bus {
    atomic_uint references;
    pthread_mutex_t mutex; /* attempt, events, count, capacity */
    uint32_t attempt;
    struct vor_event *events;
    size_t count, capacity;
    pthread_mutex_t waking; /* subscribers; held while they are woken */
    struct vor_subscriber *subscribers;
};

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

struct vor_bus *vor_bus_create(uint32_t attempt)
{
    struct vor_bus *bus = calloc(1, sizeof *bus);

    if (bus == NULL)
        return NULL;
    atomic_init(&bus->references, 1);
    bus->attempt = attempt;
    pthread_mutex_init(&bus->mutex, NULL);
    pthread_mutex_init(&bus->waking, NULL);
    return bus;
}

struct vor_bus *vor_bus_retain(struct vor_bus *bus)
{
    if (bus != NULL)
        atomic_fetch_add(&bus->references, 1);
    return bus;
}

void vor_bus_release(struct vor_bus *bus)
{
    if (bus == NULL || atomic_fetch_sub(&bus->references, 1) != 1)
        return;
    pthread_mutex_destroy(&bus->waking);
    pthread_mutex_destroy(&bus->mutex);
    free(bus->events);
    free(bus);
}

uint32_t vor_bus_attempt(struct vor_bus *bus)
{
    uint32_t attempt;

    pthread_mutex_lock(&bus->mutex);
    attempt = bus->attempt;
    pthread_mutex_unlock(&bus->mutex);
    return attempt;
}

/* The functions below that say "locked" are called with bus->mutex held. */

static int ended_locked(const struct vor_bus *bus)
{
    return bus->count > 0 && bus->events[bus->count - 1].kind == VOR_EVENT_END;
}

void vor_bus_restart(struct vor_bus *bus, uint32_t attempt)
{
    pthread_mutex_lock(&bus->mutex);
    if (!ended_locked(bus)) {
        bus->attempt = attempt;
        bus->count = 0;
    }
    pthread_mutex_unlock(&bus->mutex);
}

static int grow_locked(struct vor_bus *bus)
{
    size_t capacity = bus->capacity > 0 ? 2 * bus->capacity : 32;
    struct vor_event *events = realloc(bus->events, capacity * sizeof *events);

    if (events == NULL)
        return 0;
    bus->events = events;
    bus->capacity = capacity;
    return 1;
}

static int takes_locked(const struct vor_bus *bus, enum vor_event_kind kind)
{
    if (ended_locked(bus))
        return 0;
    return kind == VOR_EVENT_END ? bus->count < VOR_EVENTS_MAX : bus->count < VOR_EVENTS_MAX - 1;
}

static void wake_all(struct vor_bus *bus, enum vor_event_kind kind)
{
    pthread_mutex_lock(&bus->waking);
    for (struct vor_subscriber *s = bus->subscribers; s != NULL; s = s->next)
        s->wake(s->ctx, kind);
    pthread_mutex_unlock(&bus->waking);
}

vor_status vor_bus_publish(struct vor_bus *bus, const struct vor_event *event)
{
    int taken = 0, fits = 1;

    pthread_mutex_lock(&bus->mutex);
    if (takes_locked(bus, event->kind)) {
        fits = bus->count < bus->capacity || grow_locked(bus);
        taken = fits;
    }
    if (taken) {
        struct vor_event *last = &bus->events[bus->count++];

        *last = *event;
        last->attempt = bus->attempt;
        last->number = (uint32_t)bus->count;
    }
    pthread_mutex_unlock(&bus->mutex);
    if (taken)
        wake_all(bus, event->kind);
    return fits ? VOR_OK : VOR_E_NOMEM;
}

void vor_bus_nudge(struct vor_bus *bus)
{
    wake_all(bus, VOR_EVENT_PROGRESS);
}

/* Whether a reader of the latest progress may skip an event, because the next one says more. */
static int superseded_locked(const struct vor_bus *bus, size_t i)
{
    return i + 1 < bus->count && bus->events[i].kind == VOR_EVENT_PROGRESS &&
           bus->events[i + 1].kind == VOR_EVENT_PROGRESS;
}

size_t vor_bus_read(struct vor_bus *bus, struct vor_position *position, enum vor_read how,
                    struct vor_event *out, size_t max)
{
    size_t copied = 0, at;

    pthread_mutex_lock(&bus->mutex);
    at = position->attempt == bus->attempt && position->number <= bus->count ? position->number : 0;
    for (; at < bus->count && copied < max; at++)
        if (how == VOR_READ_EVERY || !superseded_locked(bus, at))
            out[copied++] = bus->events[at];
    if (copied > 0)
        *position = (struct vor_position){bus->attempt, (uint32_t)at};
    pthread_mutex_unlock(&bus->mutex);
    return copied;
}

int vor_bus_ended(struct vor_bus *bus, struct vor_position *end)
{
    int ended;

    pthread_mutex_lock(&bus->mutex);
    ended = ended_locked(bus);
    if (ended && end != NULL)
        *end = (struct vor_position){bus->attempt, (uint32_t)bus->count};
    pthread_mutex_unlock(&bus->mutex);
    return ended;
}

struct vor_position vor_bus_newest(struct vor_bus *bus)
{
    struct vor_position newest;

    pthread_mutex_lock(&bus->mutex);
    newest = (struct vor_position){bus->attempt, (uint32_t)bus->count};
    pthread_mutex_unlock(&bus->mutex);
    return newest;
}

void vor_bus_subscribe(struct vor_bus *bus, struct vor_subscriber *subscriber)
{
    pthread_mutex_lock(&bus->waking);
    subscriber->next = bus->subscribers;
    bus->subscribers = subscriber;
    pthread_mutex_unlock(&bus->waking);
}

void vor_bus_unsubscribe(struct vor_bus *bus, struct vor_subscriber *subscriber)
{
    struct vor_subscriber **at = &bus->subscribers;

    pthread_mutex_lock(&bus->waking);
    while (*at != NULL && *at != subscriber)
        at = &(*at)->next;
    if (*at != NULL)
        *at = subscriber->next;
    pthread_mutex_unlock(&bus->waking);
}
