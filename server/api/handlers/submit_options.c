#include "server/api/handlers/submission.h"

#include "core/base/quote.h"
#include "core/base/utf8.h"
#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <stdio.h>
#include <string.h>

enum { SHOWN_SIZE = 64 /* of what a caller wrote, in a message */ };

vor_status vor_submit_options_take(struct vor_submit_options *out,
                                   const struct vor_process_info *process, const char *name,
                                   const char *value, int *taken, struct vor_error *err)
{
    static const char scheme[] = "job:";
    size_t length = sizeof scheme - 1;
    long count;

    *taken = vor_submit_options_has(process, name);
    if (!*taken)
        return VOR_OK;
    if (strcmp(name, "name") == 0) {
        count = vor_utf8_count(value);
        if (count < 1 || count > VOR_JOB_NAME_CHARACTERS)
            return vor_fail_param(err, VOR_E_PARAM, name,
                                  "name is \"%s\", want 1 to %d characters of UTF-8 without "
                                  "control characters",
                                  VOR_QUOTED(SHOWN_SIZE, value, strlen(value)),
                                  VOR_JOB_NAME_CHARACTERS);
        memcpy(out->name, value, strlen(value) + 1);
        return VOR_OK;
    }
    if (strncmp(value, scheme, length) == 0 &&
        vor_uuid_parse(strcmp(name, "input") == 0 ? &out->input : &out->previous, value + length,
                       strlen(value) - length))
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, name, "%s is \"%s\", want job:ID, with the ID of a job",
                          name, VOR_QUOTED(SHOWN_SIZE, value, strlen(value)));
}

bool vor_submit_options_has(const struct vor_process_info *process, const char *name)
{
    return strcmp(name, "name") == 0 || strcmp(name, "input") == 0 ||
           (strcmp(name, "previous") == 0 && vor_artefact_find(process->inputs, name) != NULL);
}

vor_status vor_submit_options_read_key(struct vor_submit_options *out,
                                       const struct vor_request *request, struct vor_error *err)
{
    unsigned index = 0;
    const char *value = vor_request_header_next(request, "Idempotency-Key", &index);
    const char *at = value;
    size_t length = 0;
    int is_quoted;

    (void)snprintf(out->key.principal, sizeof out->key.principal, "%s", request->principal.name);
    if (value == NULL)
        return VOR_OK;
    is_quoted = *at == '"';
    at += is_quoted;
    while (at[length] > ' ' && at[length] < 0x7F && strchr("\",\\", at[length]) == NULL)
        length++;
    if (length < 1 || length >= sizeof out->key.text ||
        strcmp(at + length, is_quoted ? "\"" : "") != 0 ||
        vor_request_header_next(request, "Idempotency-Key", &index) != NULL)
        return vor_fail_param(err, VOR_E_PARAM, "Idempotency-Key",
                              "Idempotency-Key is %s, want 1 to %zu visible ASCII characters "
                              "except quote, comma and backslash, with or without quotes",
                              VOR_QUOTED(SHOWN_SIZE, value, strlen(value)),
                              sizeof out->key.text - 1);
    memcpy(out->key.text, at, length);
    out->key.text[length] = '\0';
    return VOR_OK;
}

static bool refuse(struct vor_request *request, const char *slug, const char *why,
                   const char *option, const struct vor_uuid *id)
{
    return vor_problem_say(request, slug, "%s is job:%s: %s", option, id->text, why);
}

/* A job's file that is to be an input of this one: its main input as it came, or its result. */
struct other {
    const char *option;        /* "input", "previous" */
    const struct vor_uuid *id; /* "" where there is none */
    struct vor_job_view view;
    struct vor_blob_source source;
    struct vor_upload upload;
};

/* Finds the job that an option names, if it does, and its file; false after a problem has been
 * replied. */
static bool find_other(struct vor_request *request, struct other *other)
{
    const struct vor_job_view *view = &other->view;
    const struct vor_artefact_info *output;
    enum vor_job_outcome outcome;
    struct vor_error err;

    if (other->id->text[0] == '\0')
        return true;
    outcome = vor_job_service_get(request->app->service, other->id, vor_auth_tenant(request),
                                  &other->view, &err);
    if (outcome == VOR_UNKNOWN)
        return refuse(request, "no-such-job", "there is no such job", other->option, other->id);
    if (outcome != VOR_DONE)
        return vor_outcome_reply(request, outcome, &err, other->id);
    if (view->expired)
        return refuse(request, "job-expired", "this job has expired", other->option, other->id);
    other->source.id = *other->id;
    if (strcmp(other->option, "input") == 0) {
        (void)vor_blob_of_upload(view->spec.process->inputs[0].name, other->source.name);
        memcpy(other->source.sha256, view->input[0].sha256, sizeof other->source.sha256);
        return true;
    }
    output = &view->spec.process->outputs[0];
    if (output->kind != VOR_ARTEFACT_CLOUD)
        return refuse(request, "no-such-output", "the result of this job is not a cloud",
                      other->option, other->id);
    if (view->status != VOR_JOB_SUCCESSFUL)
        return vor_result_missing(request, view);
    (void)vor_blob_of_output(output->name, view->attempt, other->source.name);
    memcpy(other->source.sha256, view->output[0].sha256, sizeof other->source.sha256);
    return true;
}

bool vor_submit_options_open(struct vor_request *request, const struct vor_submit_options *options,
                             const struct vor_process_info *process, struct vor_uploads *uploads,
                             enum vor_next *next)
{
    struct other others[] = {
        {.option = "input", .id = &options->input, .upload = {.name = process->inputs[0].name}},
        {.option = "previous", .id = &options->previous, .upload = {.name = "previous"}}};
    struct vor_here here = {.exists = false};
    struct vor_error err;
    int found;

    *next = VOR_NEXT_REPLY;
    if (!find_other(request, &others[0]) || !find_other(request, &others[1]))
        return false;
    for (int i = 0; i < 2 && uploads != NULL; i++)
        if (others[i].id->text[0] != '\0' &&
            !vor_blob_is_here(request, others[i].id, others[i].source.name, &here, next))
            return false;
    for (int i = 0; i < 2 && uploads != NULL; i++) {
        struct other *other = &others[i];

        if (other->id->text[0] == '\0')
            continue;
        if (vor_blob_reopen(request->app->blobs, &other->source, &other->upload.bytes, &found,
                            &err) != VOR_OK)
            return vor_problem_error(request, &err, other->id->text);
        if (!found && i == 0)
            return refuse(request, "input-not-kept", "the input of this job is no longer stored",
                          other->option, other->id);
        if (!found)
            return vor_result_missing(request, &other->view);
        vor_uploads_add(uploads, &other->upload);
    }
    return true;
}

void vor_submit_inputs_of_uploads(struct vor_submit_inputs *out, const struct vor_uploads *uploads)
{
    out->count = uploads->count;
    for (unsigned i = 0; i < uploads->count; i++) {
        out->item[i].name = uploads->item[i].name;
        vor_blob_sha256(uploads->item[i].bytes, out->item[i].sha256);
    }
}

void vor_submit_inputs_of_admitted(struct vor_submit_inputs *out,
                                   const struct vor_admitted *admitted)
{
    out->count = admitted->count;
    for (unsigned i = 0; i < admitted->count; i++) {
        out->item[i].name = admitted->item[i].name;
        memcpy(out->item[i].sha256, admitted->item[i].found.sha256, VOR_DIGEST_SIZE);
    }
}

enum vor_job_outcome vor_submit_options_find(struct vor_submit_options *options,
                                             const struct vor_app *app, const struct vor_spec *spec,
                                             const struct vor_submit_inputs *inputs,
                                             struct vor_job_view *out, struct vor_error *err)
{
    struct vor_text text;
    vor_status status;

    vor_text_init(&text, 0);
    vor_text_printf(&text, "%s\n", spec->process->id);
    vor_json_spec(&text, spec);
    vor_text_printf(&text, "\n%s\n", options->name);
    /* "cloud SHA-256", a line an input, in the order of the process's. */
    for (const struct vor_artefact_info *info = spec->process->inputs; info->name != NULL; info++)
        for (unsigned i = 0; i < inputs->count; i++)
            if (strcmp(inputs->item[i].name, info->name) == 0)
                vor_text_printf(&text, "%s %s\n", info->name, inputs->item[i].sha256);
    vor_text_puts(&text, "\n");
    status = vor_text_status(&text, err);
    if (status == VOR_OK)
        vor_digest_text(text.data, text.size, options->key.fingerprint);
    vor_text_free(&text);
    return status == VOR_OK ? vor_job_service_find_key(app->service, &options->key, out, err)
                            : VOR_FAILED;
}
