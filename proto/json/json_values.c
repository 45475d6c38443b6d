#include "proto/json/json.h"

#include <string.h>

static int is_given(const char *string)
{
    return string != NULL && string[0] != '\0';
}

static void put_if_given(struct vor_text *text, const char *key, const char *value)
{
    if (is_given(value))
        vor_json_put_string(text, key, value);
}

void vor_json_record(struct vor_text *text, const struct vor_record *record)
{
    vor_json_begin_object(text);
    vor_json_members(text, &vor_record_members, record);
    vor_json_end_object(text);
}

int vor_json_record_read(struct vor_record *out, const struct vor_json *object)
{
    double iteration;

    if (!vor_json_get_number(vor_json_get(object, "iteration"), &iteration))
        return 0;
    vor_json_members_read(out, &vor_record_members, object);
    if (vor_json_get(object, "best") == NULL)
        vor_record_unknown_best(out);
    return 1;
}

void vor_json_problem(struct vor_text *text, const struct vor_problem_doc *problem)
{
    vor_json_begin_object(text);
    put_if_given(text, "type", problem->type);
    put_if_given(text, "title", problem->title);
    vor_json_put_i64(text, "status", problem->status);
    put_if_given(text, "detail", problem->detail);
    put_if_given(text, "instance", problem->instance);
    vor_json_put_bool(text, "retryable", problem->retryable);
    put_if_given(text, "requestId", problem->request_id);
    put_if_given(text, "jobID", problem->job_id);
    if (problem->attempt > 0)
        vor_json_put_u64(text, "attempt", problem->attempt);
    if (problem->has_limit) {
        vor_json_put_u64(text, "limit", problem->limit);
        vor_json_put_u64(text, "got", problem->got);
    }
    if (problem->byte_offset >= 0)
        vor_json_put_i64(text, "byteOffset", problem->byte_offset);
    if (problem->queue_depth >= 0)
        vor_json_put_i64(text, "queueDepth", problem->queue_depth);
    if (problem->error_count > 0) {
        vor_json_key(text, "errors");
        vor_json_begin_array(text);
        for (size_t i = 0; i < problem->error_count; i++) {
            vor_json_begin_object(text);
            if (problem->errors[i].pointer != NULL)
                vor_json_put_string(text, "pointer", problem->errors[i].pointer);
            else
                vor_json_put_string(text, "parameter", problem->errors[i].parameter);
            if (problem->errors[i].detail != NULL)
                vor_json_put_string(text, "detail", problem->errors[i].detail);
            vor_json_end_object(text);
        }
        vor_json_end_array(text);
    }
    vor_json_end_object(text);
}

void vor_json_link(struct vor_text *text, const struct vor_link *link)
{
    vor_json_begin_object(text);
    put_if_given(text, "rel", link->rel);
    put_if_given(text, "type", link->type);
    put_if_given(text, "title", link->title);
    put_if_given(text, "href", link->href);
    if (link->length >= 0)
        vor_json_put_i64(text, "length", link->length);
    vor_json_end_object(text);
}

void vor_json_links(struct vor_text *text, const struct vor_link *links, size_t count)
{
    vor_json_begin_array(text);
    for (size_t i = 0; i < count; i++)
        vor_json_link(text, &links[i]);
    vor_json_end_array(text);
}

static void put_input(struct vor_text *text, const char *key, const struct vor_input_info *input)
{
    vor_json_key(text, key);
    vor_json_begin_object(text);
    vor_json_put_string(text, "format", input->format);
    vor_json_put_u64(text, "points", input->points);
    vor_json_put_u64(text, "bytes", input->bytes);
    put_if_given(text, "sha256", input->sha256);
    vor_json_end_object(text);
}

static void put_own_members(struct vor_text *text, const struct vor_status_info *info)
{
    vor_json_key(text, "voronoid");
    vor_json_begin_object(text);
    put_if_given(text, "name", info->name);
    vor_json_put_u64(text, "attempt", info->attempt);
    vor_json_put_string(text, "stage", info->stage);
    vor_json_key(text, "queuePosition");
    if (info->queue_position >= 0)
        vor_json_i64(text, info->queue_position);
    else
        vor_json_null(text);
    vor_json_key(text, "eta");
    if (info->eta >= 0)
        vor_json_double(text, info->eta);
    else
        vor_json_null(text);
    if (info->input_count > 0)
        put_input(text, "input", &info->inputs[0]);
    if (info->input_count > 1) {
        vor_json_key(text, "inputs");
        vor_json_begin_object(text);
        for (size_t i = 0; i < info->input_count; i++)
            put_input(text, info->inputs[i].name, &info->inputs[i]);
        vor_json_end_object(text);
    }
    if (info->parameters != NULL) {
        vor_json_key(text, "parameters");
        vor_json_spec_changed(text, info->parameters);
    }
    if (info->target_points > 0 || is_given(info->target_format)) {
        vor_json_key(text, "target");
        vor_json_begin_object(text);
        if (info->target_points > 0)
            vor_json_put_u64(text, "points", info->target_points);
        put_if_given(text, "format", info->target_format);
        vor_json_end_object(text);
    }
    if (info->origin != NULL) {
        vor_json_key(text, "origin");
        vor_json_begin_object(text);
        vor_json_put_double(text, "x", info->origin[0]);
        vor_json_put_double(text, "y", info->origin[1]);
        vor_json_put_double(text, "z", info->origin[2]);
        vor_json_end_object(text);
    }
    vor_json_key(text, "metrics");
    if (info->metrics != NULL)
        vor_json_record(text, info->metrics);
    else
        vor_json_null(text);
    vor_json_end_object(text);
}

void vor_json_status_info(struct vor_text *text, const struct vor_status_info *info)
{
    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", info->job_id);
    vor_json_put_string(text, "id", info->job_id);
    vor_json_put_string(text, "type", "process");
    vor_json_put_string(text, "processID", info->process_id);
    vor_json_put_string(text, "status", info->status);
    put_if_given(text, "message", info->message);
    if (info->progress >= 0)
        vor_json_put_i64(text, "progress", info->progress);
    put_if_given(text, "created", info->created);
    put_if_given(text, "started", info->started);
    put_if_given(text, "updated", info->updated);
    put_if_given(text, "finished", info->finished);
    put_own_members(text, info);
    if (info->exception != NULL) {
        vor_json_key(text, "exception");
        vor_json_problem(text, info->exception);
    }
    vor_json_key(text, "links");
    vor_json_links(text, info->links, info->link_count);
    vor_json_end_object(text);
}
