#include "server/store/row_text.h"

#include <stdio.h>
#include <string.h>

/* Members that inputs and outputs have alike. */
static void put_artefact(struct vor_text *text, unsigned format, uint64_t points, uint64_t bytes)
{
    vor_json_put_u64(text, "format", format);
    vor_json_put_u64(text, "points", points);
    vor_json_put_u64(text, "bytes", bytes);
}

static void write_outputs(struct vor_text *text, const struct vor_job_view *row)
{
    const struct vor_artefact_info *outputs = row->spec.process->outputs;
    int any = 0;

    for (unsigned i = 0; outputs[i].name != NULL; i++) {
        const struct vor_job_output *output = &row->output[i];

        if (vor_output_in_row(&outputs[i]) || (i == 0 && !output->has_origin))
            continue;
        if (!any)
            vor_json_begin_object(text);
        any = 1;
        vor_json_put_object(text, outputs[i].name);
        if (i > 0) {
            put_artefact(text, output->format, output->points, output->bytes);
            vor_json_put_string(text, "sha256", output->sha256);
        }
        if (output->has_origin) {
            vor_json_put_array(text, "origin");
            for (int c = 0; c < 3; c++)
                vor_json_double(text, output->origin[c]);
            vor_json_end_array(text);
        }
        vor_json_end_object(text);
    }
    if (any)
        vor_json_end_object(text);
}

enum { TEXTS = 5 };

static void texts_of(struct vor_row_text *row, struct vor_text *out[TEXTS])
{
    out[0] = &row->request;
    out[1] = &row->metrics;
    out[2] = &row->problem;
    out[3] = &row->inputs;
    out[4] = &row->outputs;
}

vor_status vor_row_write(struct vor_row_text *out, const struct vor_job_view *row,
                         struct vor_error *err)
{
    struct vor_text *texts[TEXTS];
    vor_status status = VOR_OK;

    texts_of(out, texts);
    for (int i = 0; i < TEXTS; i++)
        vor_text_init(texts[i], 0);
    vor_json_spec(&out->request, &row->spec);
    if (row->has_record)
        vor_json_record(&out->metrics, &row->record);
    if (row->problem.status != VOR_OK) {
        const struct vor_error *problem = &row->problem;

        vor_json_begin_object(&out->problem);
        vor_json_put_string(&out->problem, "status", vor_status_slug(problem->status));
        vor_json_put_string(&out->problem, "parameter", problem->parameter);
        vor_json_put_string(&out->problem, "message", problem->message);
        vor_json_put_i64(&out->problem, "byteOffset", problem->byte_offset);
        vor_json_put_u64(&out->problem, "limit", problem->limit);
        vor_json_put_u64(&out->problem, "got", problem->got);
        vor_json_end_object(&out->problem);
    }
    if (row->inputs >> 1 != 0) {
        vor_json_begin_object(&out->inputs);
        for (unsigned i = 1; row->spec.process->inputs[i].name != NULL; i++) {
            const struct vor_job_input *input = &row->input[i];

            if ((row->inputs >> i & 1) == 0)
                continue;
            vor_json_put_object(&out->inputs, row->spec.process->inputs[i].name);
            put_artefact(&out->inputs, input->format, input->points, input->bytes);
            vor_json_put_string(&out->inputs, "sha256", input->sha256);
            vor_json_put_double(&out->inputs, "seconds", input->seconds);
            vor_json_end_object(&out->inputs);
        }
        vor_json_end_object(&out->inputs);
    }
    if (row->status == VOR_JOB_SUCCESSFUL)
        write_outputs(&out->outputs, row);
    for (int i = 0; i < TEXTS && status == VOR_OK; i++)
        status = vor_text_status(texts[i], err);
    return status;
}

void vor_row_text_free(struct vor_row_text *text)
{
    struct vor_text *texts[TEXTS];

    texts_of(text, texts);
    for (int i = 0; i < TEXTS; i++)
        vor_text_free(texts[i]);
}

/* NULL when there is no text, or none that can be read. */
static struct vor_json *parse(const char *text)
{
    struct vor_json *json = NULL;

    if (text == NULL || vor_json_parse(&json, text, strlen(text), NULL) != VOR_OK)
        return NULL;
    return json;
}

/* A request for a process that is not known any more cannot be read either. */
static void read_request(struct vor_job_view *row, const struct vor_json *request)
{
    const struct vor_process_info *process = vor_process_find(row->process);

    row->request_lost = 1;
    if (process == NULL) {
        vor_spec_init(&row->spec);
        return;
    }
    vor_spec_preset(&row->spec, process);
    if (request != NULL && vor_json_spec_read(&row->spec, request, NULL) == VOR_OK)
        row->request_lost = 0;
    else
        vor_spec_preset(&row->spec, process);
}

static double number(const struct vor_json *object, const char *name, double fallback)
{
    double value = fallback;

    (void)vor_json_get_number(vor_json_get(object, name), &value);
    return value;
}

static void copy(char *out, size_t size, const struct vor_json *object, const char *name)
{
    const char *text = vor_json_get_string(vor_json_get(object, name));

    (void)snprintf(out, size, "%s", text != NULL ? text : "");
}

static void read_problem(struct vor_error *out, const struct vor_json *problem)
{
    const char *slug;
    memset(out, 0, sizeof *out);
    out->byte_offset = -1;
    if (problem == NULL)
        return;
    slug = vor_json_get_string(vor_json_get(problem, "status"));
    out->status = VOR_E_INTERNAL;
    for (int i = 1; slug != NULL && i < VOR_STATUS_COUNT; i++)
        if (strcmp(vor_status_slug((vor_status)i), slug) == 0)
            out->status = (vor_status)i;
    copy(out->parameter, sizeof out->parameter, problem, "parameter");
    copy(out->message, sizeof out->message, problem, "message");
    out->byte_offset = (int64_t)number(problem, "byteOffset", -1);
    out->limit = (uint64_t)number(problem, "limit", 0);
    out->got = (uint64_t)number(problem, "got", 0);
}

static void read_inputs(struct vor_job_view *row, const struct vor_json *inputs)
{
    const struct vor_artefact_info *infos = row->spec.process->inputs;

    row->inputs = 1;
    for (unsigned i = 1; infos[i].name != NULL; i++) {
        const struct vor_json *json = vor_json_get(inputs, infos[i].name);
        struct vor_job_input *input = &row->input[i];

        if (json == NULL)
            continue;
        row->inputs |= 1u << i;
        input->format = (unsigned)number(json, "format", 0);
        input->points = (uint64_t)number(json, "points", 0);
        input->bytes = (uint64_t)number(json, "bytes", 0);
        copy(input->sha256, sizeof input->sha256, json, "sha256");
        input->seconds = number(json, "seconds", 0);
    }
}

static void read_outputs(struct vor_job_view *row, const struct vor_json *outputs)
{
    const struct vor_json *at;
    double origin[3];
    int found;
    const struct vor_artefact_info *infos = row->spec.process->outputs;

    for (unsigned i = 0; infos[i].name != NULL; i++) {
        const struct vor_json *json = vor_json_get(outputs, infos[i].name);
        struct vor_job_output *output = &row->output[i];

        at = vor_json_first(vor_json_get(json, "origin"));
        for (found = 0; found < 3 && at != NULL && vor_json_get_number(at, &origin[found]); found++)
            at = vor_json_next(at);
        if (found == 3) {
            output->has_origin = 1;
            memcpy(output->origin, origin, sizeof origin);
        }
        if (i == 0)
            continue;
        output->format = (unsigned)number(json, "format", 0);
        output->points = (uint64_t)number(json, "points", 0);
        output->bytes = (uint64_t)number(json, "bytes", 0);
        copy(output->sha256, sizeof output->sha256, json, "sha256");
    }
}

void vor_row_read(struct vor_job_view *row, const struct vor_row_columns *columns)
{
    struct vor_json *json = parse(columns->request);

    read_request(row, json);
    vor_json_free(json);
    json = parse(columns->metrics);
    row->has_record = json != NULL && vor_json_record_read(&row->record, json);
    vor_json_free(json);
    json = parse(columns->problem);
    read_problem(&row->problem, json);
    vor_json_free(json);
    json = parse(columns->inputs);
    read_inputs(row, json);
    vor_json_free(json);
    json = parse(columns->outputs);
    read_outputs(row, json);
    vor_json_free(json);
}
