#include "proto/codec.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { LINKS_MAX = 6 + VOR_OUTPUTS_MAX };

/* Everything a statusInfo borrows. */
struct info_room {
    struct vor_status_info info;
    struct vor_link links[LINKS_MAX];
    char urls[LINKS_MAX][VOR_URL_MAX];
    char times[4][VOR_CLOCK_TEXT_SIZE];
    struct vor_input_info inputs[VOR_INPUTS_MAX];
    char input_formats[VOR_INPUTS_MAX][16], target_format[16];
    struct vor_problem_room problem;
    struct vor_problem_doc exception;
};

const char *vor_output_media_type(const struct vor_job_view *view, unsigned index)
{
    const struct vor_format *format = vor_format(view->output[index].format);

    if (view->spec.process->outputs[index].kind != VOR_ARTEFACT_CLOUD)
        return "application/json";
    return format != NULL ? format->media_type : NULL;
}

static const char *lower_label(unsigned format, char out[16])
{
    const struct vor_format *row = vor_format(format);
    size_t i = 0;

    for (; row != NULL && row->label[i] != '\0' && i < 15; i++)
        out[i] = (char)tolower((unsigned char)row->label[i]);
    out[i] = '\0';
    return out;
}

static void add_link(struct info_room *room, const char *rel, const char *type, const char *title,
                     int64_t length)
{
    room->links[room->info.link_count] =
        (struct vor_link){rel, type, title, room->urls[room->info.link_count], length};
    room->info.link_count++;
}

static void add_links(struct vor_request *request, const struct vor_job_view *view,
                      struct info_room *room)
{
    static const char json[] = "application/json";
    char(*urls)[VOR_URL_MAX] = room->urls;
    bool over = vor_job_status_over(view->status);

    vor_app_job_url(request, &view->id, "", urls[room->info.link_count]);
    add_link(room, "self", json, NULL, -1);
    if (!over) {
        vor_app_job_url(request, &view->id, "", urls[room->info.link_count]);
        add_link(room, "monitor", json, NULL, -1);
        vor_app_job_url(request, &view->id, "/events", urls[room->info.link_count]);
        add_link(room, "monitor", "text/event-stream", NULL, -1);
        vor_app_job_url(request, &view->id, "", urls[room->info.link_count]);
        add_link(room, "cancel", NULL, "DELETE to dismiss", -1);
    }
    if (view->status == VOR_JOB_SUCCESSFUL && !view->expired) {
        const struct vor_artefact_info *outputs = view->spec.process->outputs;

        vor_app_job_url(request, &view->id, "/results", urls[room->info.link_count]);
        add_link(room, "http://www.opengis.net/def/rel/ogc/1.0/results", "application/json", NULL,
                 -1);
        for (unsigned i = 0; outputs[i].name != NULL; i++) {
            vor_app_result_url(request, &view->id, outputs[i].name, urls[room->info.link_count]);
            add_link(room, "item", vor_output_media_type(view, i), outputs[i].name,
                     (int64_t)view->output[i].bytes);
        }
    }
    if (view->kept > 0 && !view->expired) {
        const struct vor_format *format = vor_format(view->input[0].format);

        vor_app_job_url(request, &view->id, "/input", room->urls[room->info.link_count]);
        add_link(room, "input", format != NULL ? format->media_type : NULL, NULL,
                 (int64_t)view->input[0].bytes);
    }
    vor_app_url(request, "/v1/jobs", urls[room->info.link_count]);
    add_link(room, "up", json, NULL, -1);
}

static uint64_t target_points(const struct vor_job_view *view)
{
    double target = vor_spec_target(&view->spec, view->input[0].points);

    if (view->status == VOR_JOB_SUCCESSFUL)
        return view->output[0].points;
    return target > 0 ? (uint64_t)target : 0;
}

static const char *time_text(int64_t wall_ms, char out[VOR_CLOCK_TEXT_SIZE])
{
    return wall_ms > 0 ? vor_clock_text(wall_ms, out) : NULL;
}

void vor_job_write(struct vor_request *request, const struct vor_job_view *view,
                   struct vor_text *text)
{
    struct info_room room = {.info = VOR_STATUS_INFO_INIT};
    struct vor_status_info *info = &room.info;
    const struct vor_artefact_info *inputs;

    info->job_id = view->id.text;
    info->process_id = view->process;
    info->name = view->name;
    info->status = vor_job_status_word(view->status);
    info->message = view->message[0] != '\0' ? view->message : NULL;
    info->progress = view->progress;
    info->created = time_text(view->created, room.times[0]);
    info->started = time_text(view->started, room.times[1]);
    info->updated = time_text(view->updated, room.times[2]);
    info->finished = time_text(view->finished, room.times[3]);
    info->attempt = view->attempt;
    info->stage = vor_job_status_over(view->status) ? NULL : vor_stage_word(view->stage);
    info->queue_position = view->queue_position;
    info->eta = view->eta_seconds;
    inputs = view->spec.process->inputs;
    for (unsigned i = 0; inputs[i].name != NULL; i++) {
        const struct vor_job_input *input = &view->input[i];

        if ((view->inputs >> i & 1) == 0)
            continue;
        room.inputs[info->input_count++] = (struct vor_input_info){
            .name = inputs[i].name,
            .format = lower_label(input->format, room.input_formats[i]),
            .points = input->points,
            .bytes = input->bytes,
            .sha256 = input->sha256,
        };
    }
    info->inputs = room.inputs;
    info->parameters = view->request_lost ? NULL : &view->spec;
    info->target_points = target_points(view);
    if (vor_spec_given(&view->spec, VOR_PARAM_FORMAT))
        info->target_format =
            lower_label((unsigned)view->spec.value[VOR_PARAM_FORMAT], room.target_format);
    if (view->status == VOR_JOB_SUCCESSFUL && view->output[0].has_origin)
        info->origin = view->output[0].origin;
    info->metrics = view->has_record ? &view->record : NULL;
    if (view->status == VOR_JOB_FAILED) {
        vor_problem_describe(request, view, &room.problem, &room.exception);
        info->exception = &room.exception;
    }
    add_links(request, view, &room);
    info->links = room.links;
    vor_json_status_info(text, info);
}
