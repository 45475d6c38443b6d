/** Events of jobs as text: frames of server-sent events, or lines of NDJSON. */
#ifndef VOR_SERVER_API_HANDLERS_EVENT_TEXT_H
#define VOR_SERVER_API_HANDLERS_EVENT_TEXT_H

#include "server/api/app.h"

/** Whose events are written, and for whom; all borrowed. */
struct vor_teller {
    struct vor_request *request;
    const struct vor_followed *followed;
    bool is_lines; /**< NDJSON */
};

/** Appends one event of the job; false when memory is out. */
int vor_event_tell(const struct vor_teller *teller, const struct vor_event *event, const char *id,
                   struct vor_text *out);

/** Appends an event that says that the points of the job have moved, and where they are told: at
 * most `points` of them. It has no id: nobody comes back to it. False when memory is out. */
int vor_event_tell_preview(const struct vor_teller *teller, const struct vor_preview_info *info,
                           size_t points, struct vor_text *out);

/** Appends one event of that name, whose data is a JSON text; false when memory is out.
 *
 *  @param[in] id  NULL for an event that cannot be come back to: the last id stays */
int vor_event_frame(const struct vor_teller *teller, const char *name, const char *id,
                    const struct vor_text *data, struct vor_text *out);

/** Counts events that a slow reader was not told: of those from one position to the next `sent`
 * were read. */
void vor_events_count_dropped(struct vor_position from, struct vor_position to, size_t sent);

/** Says that there is nothing more to tell. */
enum vor_next vor_events_reply_nothing(struct vor_request *request);

/** Says that there are too many streams: an EventSource never comes back after an error status, but
 *  it does after the end of a stream. */
void vor_events_reply_crowded(struct vor_request *request);

#endif
