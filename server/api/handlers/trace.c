/* The records of a job as a table. A thread of the worker reads and writes them: there may be
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

/* Writes the records of a job; *position becomes that of the event read last. */
static void write_trace(struct vor_bus *bus, bool is_table, struct vor_position *position,
                        struct vor_text *text)
{
    struct vor_event events[BATCH];
    size_t count;

    while ((count = vor_bus_read(bus, position, VOR_READ_EVERY, events, BATCH)) > 0) {
        for (size_t i = 0; i < count; i++) {
            if (events[i].kind != VOR_EVENT_PROGRESS)
                continue;
            if (is_table)
                vor_csv_line(text, &vor_record_members, &events[i].record);
            else
                vor_json_record(text, &events[i].record);
        }
    }
}

static void write_bus(struct trace *trace, struct vor_bus *bus)
{
    struct vor_position position = {0, 0};
    struct vor_text *text = &trace->text;
    char last[32];

    if (trace->is_table) {
        vor_csv_head(text, &vor_record_members);
        write_trace(bus, true, &position, text);
        return;
    }
    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", trace->id.text);
    vor_json_put_u64(text, "attempt", vor_bus_attempt(bus));
    vor_json_key(text, "records");
    vor_json_begin_array(text);
    write_trace(bus, false, &position, text);
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
    struct vor_bus *bus = NULL;

    trace->outcome = vor_worker_events(trace->app->worker, &trace->id, &bus, &trace->error);
    if (trace->outcome == VOR_DONE)
        write_bus(trace, bus);
    vor_bus_release(bus);
    vor_deferred_complete(&trace->deferred);
}

static enum vor_next begin(struct vor_app *app, struct vor_request *request)
{
    enum vor_job_outcome outcome;
    struct trace *trace;
    struct vor_uuid id;

    if (!vor_job_of_path(app, request, &id))
        return VOR_NEXT_REPLY;
    trace = calloc(1, sizeof *trace);
    if (trace == NULL)
        return vor_problem_no_memory(app, request);
    trace->app = app;
    trace->id = id;
    trace->is_table = vor_accepts(request, "text/csv");
    trace->task = (struct vor_task){.run = read_trace, .weight = WEIGHT};
    vor_text_init(&trace->text, 0);
    vor_deferred_begin(&trace->deferred, request, free_trace);
    outcome = vor_read_begin(app, request, &trace->deferred, &trace->task, &trace->error);
    return outcome == VOR_DONE ? VOR_NEXT_WAIT
                               : vor_outcome_reply(app, request, outcome, &trace->error, NULL);
}

enum vor_next vor_handle_trace(void *ctx, struct vor_request *request, enum vor_step step)
{
    struct trace *trace = vor_request_state(request);

    if (step == VOR_STEP_HEAD)
        return begin(ctx, request);
    if (!vor_deferred_is_done(&trace->deferred))
        return vor_problem_or_wait(ctx, request);
    if (trace->outcome != VOR_DONE)
        return vor_outcome_reply(ctx, request, trace->outcome, &trace->error, &trace->id);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_app_reply(ctx, request, 200, trace->is_table ? "text/csv" : "application/json",
                         &trace->text);
}
