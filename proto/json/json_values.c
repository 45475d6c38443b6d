/* The values the product speaks, each written by one function: everything that shows a record, a
 * report or a request shows it in the same shape. */
#include "proto/json/json_values.h"
#include "proto/json/json_write.h"
#include "proto/quote.h"

#include <stdio.h>
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

void vor_json_record_members(struct vor_text *text, const struct vor_record *record)
{
    vor_json_put_u64(text, "iteration", record->iteration);
    vor_json_put_u64(text, "polish", record->polish);
    vor_json_put_double(text, "delta", record->delta);
    vor_json_put_double(text, "sigma", record->sigma);
    vor_json_put_double(text, "epsilon", record->epsilon);
    vor_json_put_double(text, "energy", record->energy);
    vor_json_put_double(text, "max_move", record->max_move);
    vor_json_put_u64(text, "held", record->held);
    vor_json_put_double(text, "seconds", record->seconds);
}

void vor_json_record(struct vor_text *text, const struct vor_record *record)
{
    vor_json_begin_object(text);
    vor_json_record_members(text, record);
    vor_json_end_object(text);
}

static double number_of(const struct vor_json *object, const char *name)
{
    double number = 0;

    (void)vor_json_get_number(vor_json_get(object, name), &number);
    return number;
}

/* A whole number of 0 .. max; everything else is 0. */
static uint64_t count_of(const struct vor_json *object, const char *name, double max)
{
    double number = number_of(object, name);

    return number >= 0 && number <= max ? (uint64_t)number : 0;
}

int vor_json_record_read(struct vor_record *out, const struct vor_json *object)
{
    double iteration;

    if (!vor_json_get_number(vor_json_get(object, "iteration"), &iteration))
        return 0;
    out->iteration = (uint32_t)count_of(object, "iteration", UINT32_MAX);
    out->polish = (uint32_t)count_of(object, "polish", UINT32_MAX);
    out->delta = number_of(object, "delta");
    out->sigma = number_of(object, "sigma");
    out->epsilon = number_of(object, "epsilon");
    out->energy = number_of(object, "energy");
    out->max_move = number_of(object, "max_move");
    out->held = count_of(object, "held", 9007199254740991.0);
    out->seconds = number_of(object, "seconds");
    return 1;
}

static void put_seconds(struct vor_text *text, const struct vor_report *report)
{
    vor_json_key(text, "seconds");
    vor_json_begin_object(text);
    vor_json_put_double(text, "read", report->seconds_read);
    vor_json_put_double(text, "index", report->seconds_index);
    vor_json_put_double(text, "init", report->seconds_init);
    vor_json_put_double(text, "iterate", report->seconds_iterate);
    vor_json_put_double(text, "polish", report->seconds_polish);
    vor_json_put_double(text, "write", report->seconds_write);
    vor_json_end_object(text);
}

static void put_lattice(struct vor_text *text, const struct vor_report *report)
{
    vor_json_key(text, "lattice");
    vor_json_begin_object(text);
    vor_json_put_double(text, "x", report->lattice[0]);
    vor_json_put_double(text, "y", report->lattice[1]);
    vor_json_put_double(text, "z", report->lattice[2]);
    vor_json_put_u64(text, "moved", report->off_lattice);
    vor_json_end_object(text);
}

static void put_apart(struct vor_text *text, const char *key, const struct vor_apart *apart)
{
    vor_json_key(text, key);
    vor_json_begin_object(text);
    vor_json_put_double(text, "mean", apart->mean);
    vor_json_put_double(text, "rms", apart->rms);
    vor_json_put_double(text, "max", apart->max);
    vor_json_put_u64(text, "points", apart->points);
    vor_json_end_object(text);
}

/* The result beside the input. */
static void put_account(struct vor_text *text, const struct vor_report *report)
{
    put_apart(text, "in_to_out", &report->in_to_out);
    put_apart(text, "out_to_in", &report->out_to_in);
    vor_json_put_u64(text, "boundary_points", report->boundary_points);
    vor_json_key(text, "neighbors_histogram");
    vor_json_begin_array(text);
    for (unsigned i = 0; i < report->fitted_count; i++) {
        vor_json_begin_object(text);
        vor_json_put_u64(text, "neighbors", report->fitted[i].neighbors);
        vor_json_put_u64(text, "points", report->fitted[i].points);
        vor_json_end_object(text);
    }
    vor_json_end_array(text);
}

static void put_counters(struct vor_text *text, const struct vor_report *report)
{
    vor_json_put_double(text, "min_over_mean", report->min_over_mean);
    vor_json_put_double(text, "max_over_mean", report->max_over_mean);
    vor_json_put_double(text, "six_share", report->six_share);
    vor_json_put_double(text, "bisectors_per_cell", report->bisectors_per_cell);
    vor_json_put_double(text, "triangles_per_cell", report->triangles_per_cell);
    vor_json_put_u64(text, "queries", report->queries);
    vor_json_put_u64(text, "list_rebuilds", report->list_rebuilds);
}

void vor_json_report(struct vor_text *text, const struct vor_report *report)
{
    vor_json_begin_object(text);
    vor_json_key(text, "points");
    vor_json_begin_object(text);
    vor_json_put_u64(text, "in", report->points_in);
    vor_json_put_u64(text, "out", report->points_out);
    vor_json_end_object(text);
    vor_json_put_double(text, "delta", report->delta);
    vor_json_put_double(text, "sigma", report->sigma);
    vor_json_put_double(text, "epsilon", report->epsilon);
    vor_json_put_u64(text, "iterations", report->iterations);
    vor_json_put_u64(text, "polish_steps", report->polish_steps);
    vor_json_put_string(text, "stopped", vor_stopped_word(report->stopped));
    put_seconds(text, report);
    vor_json_put_u64(text, "memory_peak_bytes", report->memory_peak_bytes);
    vor_json_put_u64(text, "outliers", report->outliers);
    put_lattice(text, report);
    put_account(text, report);
    vor_json_put_u64(text, "held", report->held);
    vor_json_put_u64(text, "held_ever", report->held_ever);
    vor_json_key(text, "fallbacks");
    vor_json_begin_object(text);
    vor_json_put_u64(text, "plane", report->fallback_plane);
    vor_json_put_u64(text, "left", report->fallback_left);
    vor_json_end_object(text);
    vor_json_put_double(text, "area", report->area);
    vor_json_put_double(text, "spacing", report->spacing_mean);
    put_counters(text, report);
    vor_json_key(text, "parameters");
    vor_json_spec(text, &report->parameters);
    vor_json_end_object(text);
}

static void put_reference(struct vor_text *text, const struct vor_measure *measure)
{
    vor_json_key(text, "input");
    vor_json_begin_object(text);
    vor_json_put_double(text, "far_over_knn6_mean", measure->far_over_knn6_mean);
    vor_json_put_double(text, "far_over_knn6_p999", measure->far_over_knn6_p999);
    vor_json_put_double(text, "out_to_ref_mean", measure->out_to_ref_mean);
    vor_json_put_double(text, "out_to_ref_rms", measure->out_to_ref_rms);
    vor_json_put_double(text, "out_to_ref_max", measure->out_to_ref_max);
    vor_json_put_double(text, "ref_to_out_mean", measure->ref_to_out_mean);
    vor_json_put_double(text, "ref_to_out_rms", measure->ref_to_out_rms);
    vor_json_put_double(text, "ref_to_out_max", measure->ref_to_out_max);
    vor_json_put_double(text, "hausdorff", measure->hausdorff);
    vor_json_put_double(text, "chamfer", measure->chamfer);
    vor_json_put_double(text, "d1_mse", measure->d1_mse);
    vor_json_put_double(text, "d1_psnr", measure->d1_psnr);
    vor_json_put_double(text, "d2_mse", measure->d2_mse);
    vor_json_put_double(text, "d2_psnr", measure->d2_psnr);
    vor_json_put_double(text, "peak", measure->peak);
    vor_json_end_object(text);
}

void vor_json_measure(struct vor_text *text, const struct vor_measure *measure)
{
    vor_json_begin_object(text);
    vor_json_put_u64(text, "n", measure->n);
    vor_json_put_double(text, "delta", measure->delta);
    vor_json_put_double(text, "sigma", measure->sigma);
    vor_json_put_double(text, "epsilon", measure->epsilon);
    vor_json_put_double(text, "mean_nn", measure->mean_nn);
    vor_json_put_double(text, "min_over_mean", measure->min_over_mean);
    vor_json_put_double(text, "max_over_mean", measure->max_over_mean);
    vor_json_put_u64(text, "coincident", measure->coincident);
    if (measure->has_reference)
        put_reference(text, measure);
    vor_json_end_object(text);
}

void vor_json_spec(struct vor_text *text, const struct vor_spec *spec)
{
    vor_json_begin_object(text);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;
        const struct vor_parameter_info *info = vor_parameter_info(parameter);
        char word[64];

        if (!vor_spec_given(spec, parameter))
            continue;
        if (info->kind == VOR_KIND_CHOICE || spec->value[i] == VOR_UNSET)
            vor_json_put_string(text, info->name,
                                vor_spec_text(spec, parameter, word, sizeof word));
        else
            vor_json_put_double(text, info->name, spec->value[i]);
    }
    vor_json_end_object(text);
}

/* "/name" with ~ and / escaped as RFC 6901 wants it. */
static void write_pointer(char pointer[VOR_JSON_POINTER_MAX], const char *name)
{
    size_t at = 0;

    pointer[at++] = '/';
    for (; *name != '\0' && at + 3 <= VOR_JSON_POINTER_MAX; name++) {
        if (*name == '~' || *name == '/') {
            pointer[at++] = '~';
            pointer[at++] = *name == '~' ? '0' : '1';
        } else {
            pointer[at++] = *name;
        }
    }
    pointer[at] = '\0';
}

/* Text is for choices and auto: a number in quotes is a mistake that is better named. Names and
 * words are quoted for the message; those that are right stay as they are. */
static vor_status set_member(struct vor_spec *spec, const struct vor_json *member,
                             struct vor_error *err)
{
    const char *word = vor_json_get_string(member);
    struct vor_parameter_info info;
    char name[32], quoted[64];
    double number;

    vor_quote(name, sizeof name, vor_json_name(member), strlen(vor_json_name(member)));
    if (vor_parameter_find(name) == VOR_PARAMETER_COUNT) /* refuses the name */
        return vor_spec_set(spec, name, "", err);
    info = vor_process_parameter(spec->process, vor_parameter_find(name));
    if (vor_json_get_number(member, &number))
        return vor_spec_set_number(spec, name, number, err);
    if (word != NULL && (info.kind == VOR_KIND_CHOICE ||
                         (info.kind == VOR_KIND_COUNT_OR_AUTO && strcmp(word, "auto") == 0)))
        return vor_spec_set(spec, name, vor_quote(quoted, sizeof quoted, word, strlen(word)), err);
    if (info.kind == VOR_KIND_CHOICE)
        return vor_fail_param(err, VOR_E_PARAM, name, "%s is %s, want one of the words %s", name,
                              vor_json_kind_word(member), info.choices);
    return vor_fail_param(err, VOR_E_PARAM, name, "%s is %s, want a number from %.16g to %.16g%s",
                          name, vor_json_kind_word(member), info.min, info.max,
                          info.kind == VOR_KIND_COUNT_OR_AUTO ? " or \"auto\"" : "");
}

vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                              char pointer[VOR_JSON_POINTER_MAX], struct vor_error *err)
{
    struct vor_spec next = *spec;

    pointer[0] = '\0';
    if (vor_json_kind(object) != VOR_JSON_OBJECT)
        return vor_fail(err, VOR_E_PARAM, "the parameters are %s, want an object",
                        vor_json_kind_word(object));
    for (const struct vor_json *m = vor_json_first(object); m != NULL; m = vor_json_next(m)) {
        vor_status status = set_member(&next, m, err);

        if (status != VOR_OK) {
            write_pointer(pointer, vor_json_name(m));
            return status;
        }
    }
    *spec = next;
    return VOR_OK;
}

static void put_errors(struct vor_text *text, const struct vor_problem_doc *problem)
{
    vor_json_key(text, "errors");
    vor_json_begin_array(text);
    for (size_t i = 0; i < problem->error_count; i++) {
        vor_json_begin_object(text);
        if (problem->errors[i].pointer != NULL)
            vor_json_put_string(text, "pointer", problem->errors[i].pointer);
        else
            vor_json_put_string(text, "parameter", problem->errors[i].parameter);
        vor_json_put_string(text, "detail", problem->errors[i].detail);
        vor_json_end_object(text);
    }
    vor_json_end_array(text);
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
    if (problem->error_count > 0)
        put_errors(text, problem);
    vor_json_end_object(text);
}

void vor_json_links(struct vor_text *text, const struct vor_link *links, size_t count)
{
    vor_json_begin_array(text);
    for (size_t i = 0; i < count; i++) {
        vor_json_begin_object(text);
        put_if_given(text, "rel", links[i].rel);
        put_if_given(text, "type", links[i].type);
        put_if_given(text, "title", links[i].title);
        put_if_given(text, "href", links[i].href);
        if (links[i].length >= 0)
            vor_json_put_i64(text, "length", links[i].length);
        vor_json_end_object(text);
    }
    vor_json_end_array(text);
}

static void put_input(struct vor_text *text, const struct vor_status_info *info)
{
    vor_json_key(text, "input");
    vor_json_begin_object(text);
    vor_json_put_string(text, "format", info->input_format);
    vor_json_put_u64(text, "points", info->input_points);
    vor_json_put_u64(text, "bytes", info->input_bytes);
    put_if_given(text, "sha256", info->input_sha256);
    vor_json_end_object(text);
}

static void put_target(struct vor_text *text, const struct vor_status_info *info)
{
    vor_json_key(text, "target");
    vor_json_begin_object(text);
    if (info->target_points > 0)
        vor_json_put_u64(text, "points", info->target_points);
    put_if_given(text, "format", info->target_format);
    vor_json_end_object(text);
}

static void put_own_members(struct vor_text *text, const struct vor_status_info *info)
{
    vor_json_key(text, "voronoid");
    vor_json_begin_object(text);
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
    if (info->input_format != NULL)
        put_input(text, info);
    if (info->target_points > 0 || is_given(info->target_format))
        put_target(text, info);
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
    if (info->exception_json != NULL) {
        vor_json_key(text, "exception");
        vor_json_raw(text, info->exception_json, strlen(info->exception_json));
    } else if (info->exception != NULL) {
        vor_json_key(text, "exception");
        vor_json_problem(text, info->exception);
    }
    vor_json_key(text, "links");
    vor_json_links(text, info->links, info->link_count);
    vor_json_end_object(text);
}
