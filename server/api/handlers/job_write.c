#include "proto/codec.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>

const char *vor_output_media_type(const struct vor_job_view *view, unsigned index)
{
    const struct vor_format *format = vor_format(view->output[index].format);

    if (view->spec.process->outputs[index].kind != VOR_ARTEFACT_CLOUD)
        return "application/json";
    return format != NULL ? format->media_type : NULL;
}

/* The name of a format in small letters. */
static void put_format(struct vor_text *text, unsigned format)
{
    const struct vor_format *row = vor_format(format);
    char label[16] = "";

    for (size_t i = 0; row != NULL && row->label[i] != '\0' && i + 1 < sizeof label; i++)
        label[i] = (char)tolower((unsigned char)row->label[i]);
    vor_json_put_string(text, "format", label);
}

static void put_time(struct vor_text *text, const char *key, int64_t wall_ms)
{
    char time[VOR_CLOCK_TEXT_SIZE];

    if (wall_ms > 0)
        vor_json_put_string(text, key, vor_clock_text(wall_ms, time));
}

static void put_input(struct vor_text *text, const char *key, const struct vor_job_input *input)
{
    vor_json_put_object(text, key);
    put_format(text, input->format);
    vor_json_put_u64(text, "points", input->points);
    vor_json_put_u64(text, "bytes", input->bytes);
    vor_json_put_given(text, "sha256", input->sha256);
    vor_json_end_object(text);
}

/* The first input stands alone; where there are more, all stand together as well. */
static void put_inputs(struct vor_text *text, const struct vor_job_view *view)
{
    const struct vor_artefact_info *inputs = view->spec.process->inputs;
    unsigned first = (unsigned)__builtin_ffs((int)view->inputs) - 1;

    if (view->inputs == 0)
        return;
    put_input(text, "input", &view->input[first]);
    if (view->inputs >> first == 1)
        return;
    vor_json_put_object(text, "inputs");
    for (unsigned i = 0; inputs[i].name != NULL; i++)
        if ((view->inputs >> i & 1) != 0)
            put_input(text, inputs[i].name, &view->input[i]);
    vor_json_end_object(text);
}

static void put_target(struct vor_text *text, const struct vor_job_view *view)
{
    bool has_format = vor_spec_given(&view->spec, VOR_PARAM_FORMAT);
    double target = vor_spec_target(&view->spec, view->input[0].points);
    uint64_t points = view->status == VOR_JOB_SUCCESSFUL ? view->output[0].points
                      : target > 0                       ? (uint64_t)target
                                                         : 0; /* until the area is known */

    if (points == 0 && !has_format)
        return;
    vor_json_put_object(text, "target");
    if (points > 0)
        vor_json_put_u64(text, "points", points);
    if (has_format)
        put_format(text, (unsigned)view->spec.value[VOR_PARAM_FORMAT]);
    vor_json_end_object(text);
}

/* What OGC's statusInfo does not have. */
static void put_own_members(struct vor_text *text, const struct vor_job_view *view)
{
    const double *origin = view->output[0].origin;

    vor_json_put_object(text, "voronoid");
    vor_json_put_given(text, "name", view->name);
    vor_json_put_u64(text, "attempt", view->attempt);
    vor_json_put_string(text, "stage",
                        vor_job_status_over(view->status) ? NULL : vor_stage_word(view->stage));
    vor_json_key(text, "queuePosition");
    if (view->queue_position >= 0)
        vor_json_i64(text, view->queue_position);
    else
        vor_json_null(text);
    vor_json_put_double(text, "eta", view->eta_seconds >= 0 ? view->eta_seconds : NAN);
    put_inputs(text, view);
    if (!view->request_lost) {
        vor_json_key(text, "parameters");
        vor_json_spec_changed(text, &view->spec);
    }
    put_target(text, view);
    if (view->status == VOR_JOB_SUCCESSFUL && view->output[0].has_origin) {
        vor_json_put_object(text, "origin");
        vor_json_put_double(text, "x", origin[0]);
        vor_json_put_double(text, "y", origin[1]);
        vor_json_put_double(text, "z", origin[2]);
        vor_json_end_object(text);
    }
    vor_json_key(text, "metrics");
    if (view->has_record)
        vor_json_record(text, &view->record);
    else
        vor_json_null(text);
    vor_json_end_object(text);
}

/* A link to what stands behind the job's own address. */
static void put_link(struct vor_request *request, const struct vor_job_view *view,
                     const char *suffix, struct vor_link link, struct vor_text *text)
{
    char url[VOR_URL_MAX];

    link.href = vor_app_job_url(request, &view->id, suffix, url);
    vor_json_link(text, &link);
}

static void put_links(struct vor_request *request, const struct vor_job_view *view,
                      struct vor_text *text)
{
    static const char json[] = "application/json";
    const struct vor_artefact_info *outputs = view->spec.process->outputs;
    struct vor_link up = {.rel = "up", .type = json, .length = -1};
    char url[VOR_URL_MAX], suffix[64];

    put_link(request, view, "", (struct vor_link){"self", json, NULL, NULL, -1}, text);
    if (!vor_job_status_over(view->status)) {
        put_link(request, view, "", (struct vor_link){"monitor", json, NULL, NULL, -1}, text);
        put_link(request, view, "/events",
                 (struct vor_link){"monitor", "text/event-stream", NULL, NULL, -1}, text);
        put_link(request, view, "",
                 (struct vor_link){"cancel", NULL, "DELETE to dismiss", NULL, -1}, text);
    }
    if (view->status == VOR_JOB_SUCCESSFUL && !view->expired) {
        put_link(request, view, "/results",
                 (struct vor_link){"http://www.opengis.net/def/rel/ogc/1.0/results", json, NULL,
                                   NULL, -1},
                 text);
        for (unsigned i = 0; outputs[i].name != NULL; i++) {
            (void)snprintf(suffix, sizeof suffix, "/results/%s", outputs[i].name);
            put_link(request, view, suffix,
                     (struct vor_link){"item", vor_output_media_type(view, i), outputs[i].name,
                                       NULL, (int64_t)view->output[i].bytes},
                     text);
        }
    }
    if (view->kept > 0 && !view->expired) {
        const struct vor_format *format = vor_format(view->input[0].format);

        put_link(request, view, "/input",
                 (struct vor_link){"input", format != NULL ? format->media_type : NULL, NULL, NULL,
                                   (int64_t)view->input[0].bytes},
                 text);
    }
    up.href = vor_app_url(request, "/v1/jobs", url);
    vor_json_link(text, &up);
}

void vor_job_write(struct vor_request *request, const struct vor_job_view *view,
                   struct vor_text *text)
{
    struct vor_problem problem;

    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", view->id.text);
    vor_json_put_string(text, "id", view->id.text);
    vor_json_put_string(text, "type", "process");
    vor_json_put_string(text, "processID", view->process);
    vor_json_put_string(text, "status", vor_job_status_word(view->status));
    vor_json_put_given(text, "message", view->message);
    vor_json_put_i64(text, "progress", view->progress);
    put_time(text, "created", view->created);
    put_time(text, "started", view->started);
    put_time(text, "updated", view->updated);
    put_time(text, "finished", view->finished);
    put_own_members(text, view);
    if (view->status == VOR_JOB_FAILED) {
        vor_problem_of_job(view, &problem);
        problem.is_of_job = true;
        vor_json_key(text, "exception");
        vor_problem_write(request, &problem, text);
    }
    vor_json_put_array(text, "links");
    put_links(request, view, text);
    vor_json_end_array(text);
    vor_json_end_object(text);
}
