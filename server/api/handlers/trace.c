/* The records of a job as a table. A thread of the job service reads and writes them: there may be
 * 20,000.
 */
#include "proto/csv.h"
#include "server/api/accept.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/http/deferred.h"

#include <stdio.h>
#include <stdlib.h>

enum { BATCH = 32 };
static const uint64_t WEIGHT = 1000; /* beside the rows of a list */

struct trace {
    struct vor_deferred deferred; /* first */
    struct vor_app *app;
    struct vor_uuid id;
    bool is_table;
    struct vor_task task;
    enum vor_job_outcome outcome;
    struct vor_error error;
    struct vor_text text;
};

static void free_trace(struct vor_deferred *deferred)
{
    struct trace *trace = (struct trace *)deferred;

    vor_text_free(&trace->text);
    free(trace);
}

/* The next events of a job; false when there are none, or the store fails. */
static bool read_events(struct trace *trace, struct vor_followed *followed,
                        struct vor_event_batch *batch)
{
    batch->count = 0;
    if (followed->job != NULL && vor_job_read(followed->job, batch))
        return batch->count > 0;
    if (followed->job != NULL)
        vor_job_view(followed->job, &followed->row);
    if (vor_job_service_stored_events(trace->app->service, &followed->row, batch, &trace->error) !=
        VOR_OK)
        trace->outcome = VOR_FAILED;
    return trace->outcome == VOR_DONE && batch->count > 0;
}

/* Returns the position of the event read last. */
static struct vor_position write_records(struct trace *trace, struct vor_followed *followed)
{
    struct vor_event events[BATCH];
    struct vor_event_batch batch = {.how = VOR_READ_EVERY, .events = events, .max = BATCH};

    while (read_events(trace, followed, &batch))
        for (size_t i = 0; i < batch.count; i++) {
            if (events[i].kind != VOR_EVENT_PROGRESS)
                continue;
            if (trace->is_table)
                vor_csv_line(&trace->text, &vor_record_members, &events[i].record);
            else
                vor_json_record(&trace->text, &events[i].record);
        }
    return batch.position;
}

static void write_trace(struct trace *trace, struct vor_followed *followed)
{
    struct vor_text *text = &trace->text;
    struct vor_position position;
    char last[32];

    if (trace->is_table) {
        vor_csv_head(text, &vor_record_members);
        (void)write_records(trace, followed);
        return;
    }
    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", trace->id.text);
    vor_json_put_u64(text, "attempt", followed->row.attempt);
    vor_json_put_array(text, "records");
    position = write_records(trace, followed);
    vor_json_end_array(text);
    (void)snprintf(last, sizeof last, "%u.%u", position.attempt, position.number);
    vor_json_put_string(text, "lastEventId", last);
    vor_json_end_object(text);
    vor_text_puts(text, "\n");
}

/* On a thread that reads the store. */
static void read_trace(void *ctx)
{
    struct trace *trace = ctx;
    struct vor_followed followed;

    trace->outcome =
        vor_job_service_follow(trace->app->service, &trace->id, NULL, &followed, &trace->error);
    if (trace->outcome == VOR_DONE) {
        write_trace(trace, &followed);
        vor_job_release(followed.job);
    }
    vor_deferred_complete(&trace->deferred);
}

static enum vor_next begin(struct vor_request *request)
{
    enum vor_job_outcome outcome;
    struct trace *trace;
    struct vor_uuid id;

    if (!vor_job_of_path(request, &id))
        return VOR_NEXT_REPLY;
    trace = calloc(1, sizeof *trace);
    if (trace == NULL)
        return vor_problem_no_memory(request);
    trace->app = request->app;
    trace->id = id;
    trace->is_table = vor_accepts(request, "text/csv");
    trace->task = (struct vor_task){.run = read_trace, .weight = WEIGHT};
    vor_text_init(&trace->text, 0);
    vor_deferred_begin(&trace->deferred, request, free_trace);
    outcome = vor_read_begin(request, &trace->deferred, &trace->task, &trace->error);
    return outcome == VOR_DONE ? VOR_NEXT_WAIT
                               : vor_outcome_reply(request, outcome, &trace->error, NULL);
}

enum vor_next vor_handle_trace(struct vor_request *request, enum vor_step step)
{
    struct trace *trace = request->state;

    if (step == VOR_STEP_HEAD)
        return begin(request);
    if (!vor_deferred_is_done(&trace->deferred))
        return vor_problem_or_wait(request);
    if (trace->outcome != VOR_DONE)
        return vor_outcome_reply(request, trace->outcome, &trace->error, &trace->id);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_app_reply(request, 200, trace->is_table ? "text/csv" : "application/json",
                         &trace->text);
}
