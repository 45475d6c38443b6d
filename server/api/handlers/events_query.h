/** What a stream of events, or a poll for them, is asked for: which jobs, and from where on. */
#ifndef VOR_SERVER_API_HANDLERS_EVENTS_QUERY_H
#define VOR_SERVER_API_HANDLERS_EVENTS_QUERY_H

#include "server/api/app.h"

enum {
    VOR_EVENT_JOBS_MAX = 64, /**< jobs of one stream: ids of its events have 1.4 KB at most */
    VOR_POSITION_SIZE = 23   /**< "4294967295.4294967295," and a NUL */
};

/** The position of a job that is over, in ids of streams of many: it is not asked for again. */
#define VOR_POSITION_END "end"

struct vor_events_query {
    bool is_many;
    bool is_replay; /**< a last event id came: every event after it counts, not only the latest */
    size_t preview; /**< points of a preview at most; 0: none are asked for */
    double wait;    /**< seconds of a long poll (Prefer: wait=N), 0 .. 86400; -1: a stream */
    unsigned count;
    struct {
        struct vor_uuid id;
        struct vor_position position; /**< of the event read last, {0, 0} for none */
        bool is_over;                 /**< the end was read */
    } jobs[VOR_EVENT_JOBS_MAX];
};

/** Reads a number of points of a preview from the query, 1 to VOR_PREVIEW_POINTS_MAX; *out is not
 *  changed where the query has no such name.
 *
 *  @return true, or false after a problem has been replied */
bool vor_query_points(struct vor_request *request, const char *name, size_t *out);

/** Reads Prefer, preview and the last event id of a stream of one job, "ATTEMPT.NUMBER", if there
 * is one, from the header Last-Event-ID, else the query.
 *
 *  @return true, or false after a problem has been replied */
bool vor_events_query_one(struct vor_request *request, struct vor_events_query *out);

/** Reads Prefer and the query of a stream of many: preview; jobs, 1 to VOR_EVENT_JOBS_MAX different
 * ids with commas between; and the last event id: as many positions with commas between, of the
 * jobs in the same order, each "ATTEMPT.NUMBER" or "end".
 *
 *  @return true, or false after a problem has been replied */
bool vor_events_query_many(struct vor_request *request, struct vor_events_query *out);

#endif
