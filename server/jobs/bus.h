/** The events of one job, in order, for any number of readers at any speed.
 *
 *  A bus keeps every event of the current attempt (records and a few changes of state: at most
 *  VOR_EVENTS_MAX, 120 bytes each). A reader is nothing but a position, so a slow one costs no
 *  memory. Events are numbered 1, 2, ... within an attempt; "attempt.number" is the id of SSE. */
#ifndef VOR_SERVER_JOBS_BUS_H
#define VOR_SERVER_JOBS_BUS_H

#include "core/report.h"
#include "server/store/row.h"

#include <stddef.h>
#include <stdint.h>

/** Kinds of events: identifier, name in SSE. */
#define VOR_EVENT_TABLE(X)                                                                         \
    X(REPLACED, "replaced") /* first event of an attempt after the first: readers start anew */    \
    X(STATUS, "status")     /* status or stage changed */                                          \
    X(PROGRESS, "progress") /* a step of the run is done: record holds it */                       \
    X(END, "end")           /* the last event: status is final */

enum vor_event_kind {
#define VOR_EVENT_ENUM(name, word) VOR_EVENT_##name,
    VOR_EVENT_TABLE(VOR_EVENT_ENUM)
#undef VOR_EVENT_ENUM
        VOR_EVENT_KINDS
};

const char *vor_event_word(enum vor_event_kind kind);

/** Iterations and steps of the polish of a request, and the changes of state around them. */
#define VOR_EVENTS_MAX 20016

struct vor_event {
    enum vor_event_kind kind;
    uint32_t attempt, number; /**< both from 1 */
    enum vor_job_status status;
    enum vor_stage stage;     /**< REPLACED: the one that the attempt before ended in; QUEUED where
                                   the daemon ended */
    int progress;             /**< 0 .. 100 */
    int64_t time_ms;          /**< wall clock */
    double eta_seconds;       /**< PROGRESS: until the run is done; -1 when not known; else 0 */
    struct vor_record record; /**< PROGRESS; else zero */
};

/** A position: the event read last. {0, 0} is before the first. */
struct vor_position {
    uint32_t attempt, number;
};

/** Reads "attempt.number" (as in Last-Event-ID); false when text is anything else. */
int vor_position_parse(struct vor_position *out, const char *text);

struct vor_bus;

/** An empty bus for one attempt, with one reference; NULL when memory is out. */
struct vor_bus *vor_bus_create(uint32_t attempt);

/** bus may be NULL. */
struct vor_bus *vor_bus_retain(struct vor_bus *bus);
void vor_bus_release(struct vor_bus *bus);

uint32_t vor_bus_attempt(struct vor_bus *bus);

/** Begins another attempt: the events so far are gone, and those to come are numbered anew. Readers
 *  find themselves before the first of them. Nothing happens once END was published. */
void vor_bus_restart(struct vor_bus *bus, uint32_t attempt);

/** Appends an event, whose attempt and number the bus fills in, then wakes the subscribers. After
 *  END, and past VOR_EVENTS_MAX - 1 for all but END, events are ignored.
 *
 *  @retval VOR_E_NOMEM the event is lost */
vor_status vor_bus_publish(struct vor_bus *bus, const struct vor_event *event);

/** Wakes the subscribers as a progress does, without an event: something else has come for them. */
void vor_bus_nudge(struct vor_bus *bus);

/** How a reader that is behind catches up. */
enum vor_read {
    VOR_READ_EVERY, /**< every event: replay after Last-Event-ID, trace */
    VOR_READ_LATEST /**< of the progress events that wait in a row only the last: live, slow reader
                     */
};

/** Copies up to max events after *position and moves *position behind them. A position of an
 *  earlier attempt, or past the last event, starts with this attempt's first event.
 *
 *  @return the number of events; 0 when none waits. Does not block. */
size_t vor_bus_read(struct vor_bus *bus, struct vor_position *position, enum vor_read how,
                    struct vor_event *out, size_t max);

/** True when END was published, and where it is (NULL if not wanted). */
int vor_bus_ended(struct vor_bus *bus, struct vor_position *end);

/** Where the newest event is: a reader that starts there sees only what comes. */
struct vor_position vor_bus_newest(struct vor_bus *bus);

/** Asks for wake to be called after every publish, from the publisher's thread. wake must be quick,
 *  may read the bus, must not subscribe or unsubscribe. Keep the struct until unsubscribed; the
 *  caller fills in wake and ctx. */
struct vor_subscriber {
    void (*wake)(void *ctx, enum vor_event_kind kind);
    void *ctx;
    struct vor_subscriber *next; /**< the bus's own */
};

void vor_bus_subscribe(struct vor_bus *bus, struct vor_subscriber *subscriber);

/** When this returns, wake is not running and will not be called again: do not call it while
 *  holding a lock that wake takes. One that never subscribed is fine. */
void vor_bus_unsubscribe(struct vor_bus *bus, struct vor_subscriber *subscriber);

#endif
