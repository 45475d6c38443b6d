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
    char quoted[SHOWN_SIZE];
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
                                  vor_quote(quoted, sizeof quoted, value, strlen(value)),
                                  VOR_JOB_NAME_CHARACTERS);
        memcpy(out->name, value, strlen(value) + 1);
        return VOR_OK;
    }
    if (strncmp(value, scheme, length) == 0 &&
        vor_uuid_parse(strcmp(name, "input") == 0 ? &out->input : &out->previous, value + length,
                       strlen(value) - length))
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, name, "%s is \"%s\", want job:ID, with the ID of a job",
                          name, vor_quote(quoted, sizeof quoted, value, strlen(value)));
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
    char quoted[SHOWN_SIZE];
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
                              vor_quote(quoted, sizeof quoted, value, strlen(value)),
                              sizeof out->key.text - 1);
    memcpy(out->key.text, at, length);
    out->key.text[length] = '\0';
    return VOR_OK;
}

static bool refuse(struct vor_request *request, const char *slug, const char *why,
                   const char *option, const struct vor_uuid *id)
{
    vor_problem_say(request, slug, "%s is job:%s: %s", option, id->text, why);
    return false;
}

/* The job that an option names; false after a problem has been replied. */
static bool find_job(struct vor_request *request, struct vor_job_view *view, const char *option,
                     const struct vor_uuid *id)
{
    enum vor_job_outcome outcome;
    struct vor_error err;

    outcome = vor_worker_get(request->app->worker, id, vor_auth_tenant(request), view, &err);
    if (outcome == VOR_UNKNOWN)
        return refuse(request, "no-such-job", "there is no such job", option, id);
    if (outcome != VOR_DONE) {
        vor_outcome_reply(request, outcome, &err, id);
        return false;
    }
    if (view->expired)
        return refuse(request, "job-expired", "this job has expired", option, id);
    return true;
}

/* A job's file that is to be an input of this one. */
struct other {
    struct vor_job_view view;
    struct vor_blob_source source; /* its id is "" where there is none */
    struct vor_upload upload;
};

/* The main input of a job; false after a problem has been replied. */
static bool find_input(struct vor_request *request, const struct vor_uuid *id, struct other *out)
{
    if (!find_job(request, &out->view, "input", id))
        return false;
    out->source.id = *id;
    (void)vor_blob_of_upload(out->view.spec.process->inputs[0].name, out->source.name);
    memcpy(out->source.sha256, out->view.input[0].sha256, sizeof out->source.sha256);
    return true;
}

/* The result of a job, a cloud; likewise. */
static bool find_result(struct vor_request *request, const struct vor_uuid *id, struct other *out)
{
    const struct vor_artefact_info *output;

    if (!find_job(request, &out->view, "previous", id))
        return false;
    output = &out->view.spec.process->outputs[0];
    if (output->kind != VOR_ARTEFACT_CLOUD)
        return refuse(request, "no-such-output", "the result of this job is not a cloud",
                      "previous", id);
    if (out->view.status != VOR_JOB_SUCCESSFUL) {
        vor_result_missing(request, &out->view);
        return false;
    }
    out->source.id = *id;
    (void)vor_blob_of_output(output->name, out->view.attempt, out->source.name);
    memcpy(out->source.sha256, out->view.output[0].sha256, sizeof out->source.sha256);
    return true;
}

static bool is_here(struct vor_request *request, const struct other *other, enum vor_next *next)
{
    struct vor_here here = {.may_flow = false};

    return other->source.id.text[0] == '\0' ||
           vor_blob_is_here(request, &other->source.id, other->source.name, &here, next);
}

/* Adds the bytes, where any are asked for; false after a problem has been replied. */
static bool reopen(struct vor_request *request, struct other *other, struct vor_uploads *uploads,
                   int *found)
{
    struct vor_error err;

    *found = other->source.id.text[0] == '\0';
    if (*found)
        return true;
    if (vor_blob_reopen(request->app->blobs, &other->source, &other->upload.bytes, found, &err) !=
        VOR_OK) {
        vor_problem_error(request, &err, other->source.id.text);
        return false;
    }
    if (*found)
        vor_uploads_add(uploads, &other->upload);
    return true;
}

bool vor_submit_options_open(struct vor_request *request, const struct vor_submit_options *options,
                             const struct vor_process_info *process, struct vor_uploads *uploads,
                             enum vor_next *next)
{
    struct other input = {.upload = {.name = process->inputs[0].name}};
    struct other previous = {.upload = {.name = "previous"}};
    int found;

    *next = VOR_NEXT_REPLY;
    if ((options->input.text[0] != '\0' && !find_input(request, &options->input, &input)) ||
        (options->previous.text[0] != '\0' && !find_result(request, &options->previous, &previous)))
        return false;
    if (uploads == NULL)
        return true;
    if (!is_here(request, &input, next) || !is_here(request, &previous, next))
        return false;
    if (!reopen(request, &input, uploads, &found))
        return false;
    if (!found)
        return refuse(request, "input-not-kept", "the input of this job is no longer stored",
                      "input", &options->input);
    if (!reopen(request, &previous, uploads, &found))
        return false;
    if (!found)
        vor_result_missing(request, &previous.view);
    return found;
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

static vor_status print(struct vor_submit_options *options, const struct vor_spec *spec,
                        const struct vor_submit_inputs *inputs, struct vor_error *err)
{
    struct vor_digest *digest = vor_digest_create();
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
    if (status == VOR_OK && digest == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "the digest of a request");
    if (status == VOR_OK) {
        vor_digest_update(digest, text.data, text.size);
        vor_digest_hex(digest, options->key.fingerprint);
    }
    vor_digest_destroy(digest);
    vor_text_free(&text);
    return status;
}

enum vor_job_outcome vor_submit_options_find(struct vor_submit_options *options,
                                             const struct vor_app *app, const struct vor_spec *spec,
                                             const struct vor_submit_inputs *inputs,
                                             struct vor_job_view *out, struct vor_error *err)
{
    if (print(options, spec, inputs, err) != VOR_OK)
        return VOR_FAILED;
    return vor_worker_find_key(app->worker, &options->key, out, err);
}
