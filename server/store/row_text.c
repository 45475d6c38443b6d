#include "server/store/row_text.h"

#include <stdio.h>
#include <string.h>

static void write_problem(struct vor_text *text, const struct vor_error *problem)
{
    vor_json_begin_object(text);
    vor_json_put_string(text, "status", vor_status_slug(problem->status));
    vor_json_put_string(text, "parameter", problem->parameter);
    vor_json_put_string(text, "message", problem->message);
    vor_json_put_i64(text, "byteOffset", problem->byte_offset);
    vor_json_put_u64(text, "limit", problem->limit);
    vor_json_put_u64(text, "got", problem->got);
    vor_json_end_object(text);
}

vor_status vor_row_write(struct vor_row_text *out, const struct vor_job_view *row,
                         struct vor_error *err)
{
    vor_status status;

    vor_text_init(&out->request, 0);
    vor_text_init(&out->metrics, 0);
    vor_text_init(&out->problem, 0);
    vor_json_spec(&out->request, &row->spec);
    if (row->has_record)
        vor_json_record(&out->metrics, &row->record);
    if (row->problem.status != VOR_OK)
        write_problem(&out->problem, &row->problem);
    status = vor_text_status(&out->request, err);
    if (status == VOR_OK)
        status = vor_text_status(&out->metrics, err);
    return status == VOR_OK ? vor_text_status(&out->problem, err) : status;
}

void vor_row_text_free(struct vor_row_text *text)
{
    vor_text_free(&text->request);
    vor_text_free(&text->metrics);
    vor_text_free(&text->problem);
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
static void read_request(struct vor_spec *spec, const char *id, const struct vor_json *request)
{
    const struct vor_process_info *process = vor_process_find(id);
    char pointer[VOR_JSON_POINTER_MAX];

    if (process == NULL) {
        vor_spec_init(spec);
        return;
    }
    vor_spec_preset(spec, process);
    if (request != NULL && vor_json_spec_read(spec, request, pointer, NULL) != VOR_OK)
        vor_spec_preset(spec, process);
}

static vor_status find_status(const char *slug)
{
    for (int i = 1; slug != NULL && i < VOR_STATUS_COUNT; i++)
        if (strcmp(vor_status_slug((vor_status)i), slug) == 0)
            return (vor_status)i;
    return VOR_E_INTERNAL;
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
    memset(out, 0, sizeof *out);
    out->byte_offset = -1;
    if (problem == NULL)
        return;
    out->status = find_status(vor_json_get_string(vor_json_get(problem, "status")));
    copy(out->parameter, sizeof out->parameter, problem, "parameter");
    copy(out->message, sizeof out->message, problem, "message");
    out->byte_offset = (int64_t)number(problem, "byteOffset", -1);
    out->limit = (uint64_t)number(problem, "limit", 0);
    out->got = (uint64_t)number(problem, "got", 0);
}

void vor_row_read(struct vor_job_view *row, const char *request, const char *metrics,
                  const char *problem)
{
    struct vor_json *json = parse(request);

    read_request(&row->spec, row->process, json);
    vor_json_free(json);
    json = parse(metrics);
    row->has_record = json != NULL && vor_json_record_read(&row->record, json);
    vor_json_free(json);
    json = parse(problem);
    read_problem(&row->problem, json);
    vor_json_free(json);
}
