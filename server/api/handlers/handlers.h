/** What the handlers of the route table share. */
#ifndef VOR_SERVER_API_HANDLERS_H
#define VOR_SERVER_API_HANDLERS_H

#include "server/api/route_table.h"
#include "server/blob/driver.h"
#include "server/work/conversion.h"
#include "server/work/thread_pool.h"

#include <stdbool.h>

/** What every page and each of its files is sent with: who may load what, and that it is asked for
 *  again each time. */
void vor_page_headers(struct vor_request *request);

/** The process that a request to start a job names, of those that HTTP offers: /v1/PROCESS, or
 *  /v1/processes/PROCESS/execution or .../frames.
 *
 *  @return NULL after a no-such-process problem has been replied */
const struct vor_process_info *vor_process_of_submit(struct vor_request *request);

/** Reads the {jobID} of the path. A job of another key is none.
 *
 *  @return true, or false after a problem (no-such-job, store) has been replied */
bool vor_job_of_path(struct vor_request *request, struct vor_uuid *out);

/** The job of the path, as it is now.
 *
 *  @return true, or false after a problem (no-such-job, store) has been replied */
bool vor_job_look_up(struct vor_request *request, struct vor_job_view *out);

/** Replies to an outcome that is not VOR_DONE: no-such-job, queue-full, draining, or err. */
enum vor_next vor_outcome_reply(struct vor_request *request, enum vor_job_outcome outcome,
                                const struct vor_error *err, const struct vor_uuid *id);

/** jobs.c: has task->run, of task->weight, read the store for a request that waits. It is given
 *  deferred, which it completes.
 *
 *  @retval VOR_DONE the request is to wait
 *  @retval others   as vor_job_service_read_soon; run will not be called */
struct vor_deferred;
enum vor_job_outcome vor_read_begin(struct vor_request *request, struct vor_deferred *deferred,
                                    struct vor_task *task, struct vor_error *err);

/** jobs_filter.c: which jobs a list is asked for.
 *
 *  @return true, or false after an invalid-query-parameter-value problem has been replied */
struct vor_job_filter;
bool vor_job_filter_read(struct vor_request *request, struct vor_job_filter *out);

/** The media type of output `index` of a successful job; NULL when this version does not know its
 *  format. */
const char *vor_output_media_type(const struct vor_job_view *view, unsigned index);

/** Appends the statusInfo of a job to a document. */
void vor_job_write(struct vor_request *request, const struct vor_job_view *view,
                   struct vor_text *text);

/** Replies why a job has no result to give: not ready, expired, dismissed, or its own problem. */
enum vor_next vor_result_missing(struct vor_request *request, const struct vor_job_view *view);

/** here.c: this request as one who waits for an answer of another thread; with any other answer,
 * its ctx is to be dropped (vor_waker_drop). */
struct vor_asker vor_asker_of(struct vor_request *request);

/** here.c: whether a blob can be read without waiting for another machine, or there is none
 *  (here->exists). Else *next is what the handler returns; once woken, it is called again and asks
 *  again. */
struct vor_flow;
struct vor_here {
    struct vor_blob_part part; /**< set by the caller: bytes that may be on their way; to 0: none */
    bool exists;
    struct vor_flow *flow; /**< then; the caller ends it with vor_flow_drop */
};
bool vor_blob_is_here(struct vor_request *request, const struct vor_uuid *id, const char *name,
                      struct vor_here *here, enum vor_next *next);

/** Replies 200 with the whole main output of a successful job (a synchronous call).
 *
 *  @param[in] is_new  the job has just ended, so that its bytes need no look; else the request may
 *                     have to wait for that, and this is to be called again when it is woken */
enum vor_next vor_result_whole(struct vor_request *request, const struct vor_job_view *view,
                               bool is_new);

/** Replies with the events of a job, from the first one that matters now. The request's state is
 *  released first; the stream becomes its state. */
enum vor_next vor_events_reply(struct vor_request *request, const struct vor_uuid *id);

/* The preferences of a request (RFC 7240). */

struct vor_preferences {
    bool is_async;       /**< respond-async */
    bool is_early;       /**< respond-early, which is ours: before the body is in */
    double wait_seconds; /**< wait=N, 0 .. 86400 (more counts as that); -1 for none */
};

/** Reads every Prefer header; preferences that we do not know, or cannot read, do not matter. */
void vor_prefer_read(const struct vor_request *request, struct vor_preferences *out);

/* A result in another format than the job's: waits while it is made. */

/** Looks for output `index` of a successful job in that format, and has it made if it was not. HEAD
 *  has nothing made.
 *
 *  @param[out] out  its fd is -1 unless the bytes are there
 *
 *  @retval VOR_NEXT_REPLY  the bytes are there; or, if fd is -1, a reply has been made
 *  @retval VOR_NEXT_WAIT   the request waits; the handler is to call this again at the next step */
enum vor_next vor_converted_get(struct vor_request *request, const struct vor_job_view *view,
                                unsigned index, unsigned format, struct vor_converted *out);

/* What a request for a result asks for besides its path. */

/** The query of a request for a result. */
struct vor_result_query {
    bool has_format;
    unsigned format; /**< index of vor_format */
    bool stays;      /**< link=false: the bytes come from here, wherever they lie */
};

/** Reads the query of a request for a result.
 *
 *  @param[in] takes_format  it may have the parameter format; one for one result may have link
 *                           and a ticket, and no other
 *
 *  @return true, or false after an invalid-query-parameter-value problem has been replied */
bool vor_result_query_read(struct vor_request *request, bool takes_format,
                           struct vor_result_query *out);

/** Checks that the caller takes what will be sent.
 *
 *  @return true, or false after a not-acceptable problem has been replied */
bool vor_result_accepts(struct vor_request *request, const char *media_type);

#endif
