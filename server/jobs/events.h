/** The events of one job, in order, for any number of readers at any speed.
 *
 *  The store has them, in pieces. A live job has those of its last seconds, which the store has not
 *  yet (job.h), at most VOR_EVENTS_MAX. A reader is nothing but a position, so a slow one costs no
 *  memory. Events are numbered 1, 2, ... within an attempt; "attempt.number" is the id of SSE. */
#ifndef VOR_SERVER_JOBS_EVENTS_H
#define VOR_SERVER_JOBS_EVENTS_H

#include "core/report.h"
#include "proto/text.h"
#include "server/store/driver.h"

#include <stddef.h>
#include <stdint.h>

/** Kinds of events: identifier, name in SSE. */
#define VOR_EVENT_TABLE(X)                                                                         \
    X(REPLACED, "replaced") /* first event of an attempt after the first: readers start anew */    \
    X(STATUS, "status")     /* status or stage changed */                                          \
    X(PROGRESS, "progress") /* a step of the run is done: record holds it */                       \
    X(END, "end")           /* the last event: status is final; the row says it, no piece does */

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

/** How a reader that is behind catches up. */
enum vor_read {
    VOR_READ_EVERY, /**< every event: replay after Last-Event-ID, trace */
    VOR_READ_LATEST /**< of the progress events that wait in a row only the last: live, slow reader
                     */
};

/** The next events of an attempt, as a reader takes them: what follows its position, as far as
 *  there is room. The caller sets all but count, which begins at 0. */
struct vor_event_batch {
    struct vor_position position; /**< of the event read last */
    enum vor_read how;
    struct vor_event *events; /**< borrowed */
    size_t max, count;
};

/** Puts a position that is of another attempt, or behind the last event there is, before the first.
 */
void vor_event_batch_begin(struct vor_event_batch *batch, uint32_t attempt, uint32_t last);

/** Adds an event. Of progress that waits in a row, the latest takes the place of the one before
 *  where that is enough. False when there is no room. */
int vor_event_batch_add(struct vor_event_batch *batch, const struct vor_event *event);

/** Appends an event to a piece; its attempt and number matter only to the first of a piece.
 *
 *  @retval VOR_E_NOMEM the piece is as before */
VOR_NODISCARD vor_status vor_events_pack(struct vor_text *piece, const struct vor_event *event);

/** Reads events of a piece into a batch, whose position says where it begins. Cost: that of what is
 *  read, and a step for each event before it.
 *
 *  @retval 1   the batch has all of them
 *  @retval 0   there was no room for more
 *  @retval -1  what follows is no event, or one of a build with stages that this one does not have
 */
int vor_events_unpack(struct vor_event_batch *batch, const struct vor_event_piece *piece);

#endif
