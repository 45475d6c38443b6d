/* The records of a job as a table. */
#include "proto/csv.h"
#include "server/api/accept.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <stdio.h>

enum { BATCH = 32 };

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

enum vor_next vor_handle_trace(void *ctx, struct vor_request *request, enum vor_step step)
{
    struct vor_app *app = ctx;
    bool is_table = vor_accepts(request, "text/csv");
    struct vor_position position = {0, 0};
    struct vor_bus *bus = NULL;
    struct vor_error err;
    struct vor_text text;
    struct vor_uuid id;
    enum vor_job_outcome outcome;
    char last[32];

    (void)step;
    if (!vor_job_of_path(app, request, &id))
        return VOR_NEXT_REPLY;
    outcome = vor_worker_events(app->worker, &id, &bus, &err);
    if (outcome != VOR_DONE)
        return vor_outcome_reply(app, request, outcome, &err, &id);
    vor_text_init(&text, 0);
    if (is_table) {
        vor_csv_head(&text, &vor_record_members);
        write_trace(bus, true, &position, &text);
    } else {
        vor_json_begin_object(&text);
        vor_json_put_string(&text, "jobID", id.text);
        vor_json_put_u64(&text, "attempt", vor_bus_attempt(bus));
        vor_json_key(&text, "records");
        vor_json_begin_array(&text);
        write_trace(bus, false, &position, &text);
        vor_json_end_array(&text);
        (void)snprintf(last, sizeof last, "%u.%u", position.attempt, position.number);
        vor_json_put_string(&text, "lastEventId", last);
        vor_json_end_object(&text);
        vor_text_puts(&text, "\n");
    }
    vor_bus_release(bus);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_app_reply(app, request, 200, is_table ? "text/csv" : "application/json", &text);
}
