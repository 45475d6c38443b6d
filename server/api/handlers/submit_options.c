#include "server/api/handlers/submission.h"

#include "core/base/quote.h"
#include "core/base/utf8.h"
#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <stdio.h>
#include <string.h>

enum { SHOWN_SIZE = 64 /* of what a caller wrote, in a message */ };

static vor_status take_name(struct vor_submit_options *out, const char *value,
                            struct vor_error *err)
{
    long count = vor_utf8_count(value);
    char quoted[SHOWN_SIZE];

    if (count < 1 || count > VOR_JOB_NAME_CHARACTERS)
        return vor_fail_param(err, VOR_E_PARAM, "name",
                              "name is \"%s\", want 1 to %d characters of UTF-8 without control "
                              "characters",
                              vor_quote(quoted, sizeof quoted, value, strlen(value)),
                              VOR_JOB_NAME_CHARACTERS);
    memcpy(out->name, value, strlen(value) + 1);
    return VOR_OK;
}

vor_status vor_submit_options_take(struct vor_submit_options *out, const char *name,
                                   const char *value, int *taken, struct vor_error *err)
{
    *taken = 1;
    if (strcmp(name, "name") == 0)
        return take_name(out, value, err);
    if (strcmp(name, "input") == 0) {
        static const char scheme[] = "job:";
        size_t length = sizeof scheme - 1;
        char quoted[SHOWN_SIZE];

        if (strncmp(value, scheme, length) == 0 &&
            vor_uuid_parse(&out->input, value + length, strlen(value) - length))
            return VOR_OK;
        return vor_fail_param(err, VOR_E_PARAM, "input",
                              "input is \"%s\", want job:ID, with the ID of a job",
                              vor_quote(quoted, sizeof quoted, value, strlen(value)));
    }
    *taken = 0;
    return VOR_OK;
}

bool vor_submit_options_has(const char *name)
{
    return strcmp(name, "name") == 0 || strcmp(name, "input") == 0;
}

static int is_key_character(char c)
{
    return c > ' ' && c < 0x7F && strchr("\",\\", c) == NULL;
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

    (void)snprintf(out->key.principal, sizeof out->key.principal, "%s",
                   vor_request_principal(request)->name);
    if (value == NULL)
        return VOR_OK;
    is_quoted = *at == '"';
    at += is_quoted;
    while (is_key_character(at[length]))
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

static struct vor_blob_writer *refuse(struct vor_app *app, struct vor_request *request,
                                      const char *slug, const char *why, const struct vor_uuid *id)
{
    vor_problem_say(app, request, slug, "input is job:%s: %s", id->text, why);
    return NULL;
}

static struct vor_blob_writer *open_upload(struct vor_app *app, struct vor_request *request,
                                           const struct vor_job_view *view)
{
    struct vor_blob_source source = {.id = view->id};
    struct vor_blob_writer *upload = NULL;
    struct vor_error err;
    int found = 0;

    (void)vor_blob_of_upload(view->spec.process->inputs[0].name, source.name);
    memcpy(source.sha256, view->input[0].sha256, sizeof source.sha256);
    if (vor_blob_reopen(app->blobs, &source, &upload, &found, &err) != VOR_OK)
        vor_problem_error(app, request, &err, view->id.text);
    else if (!found)
        refuse(app, request, "input-not-kept", "the input of this job is no longer stored",
               &view->id);
    return upload;
}

struct vor_blob_writer *vor_submit_options_open(struct vor_app *app, struct vor_request *request,
                                                const struct vor_submit_options *options)
{
    const struct vor_uuid *id = &options->input;
    struct vor_job_view view;
    enum vor_job_outcome outcome;
    struct vor_error err;

    outcome = vor_worker_get(app->worker, id, vor_auth_tenant(request), &view, &err);
    if (outcome == VOR_UNKNOWN)
        return refuse(app, request, "no-such-job", "there is no such job", id);
    if (outcome != VOR_DONE) {
        vor_outcome_reply(app, request, outcome, &err, id);
        return NULL;
    }
    if (view.expired)
        return refuse(app, request, "job-expired", "this job has expired", id);
    return open_upload(app, request, &view);
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

/* "cloud SHA-256", a line an input, in the order of the process's. */
static void list_inputs(struct vor_text *text, const struct vor_artefact_info *info,
                        const struct vor_submit_inputs *inputs)
{
    for (; info->name != NULL; info++)
        for (unsigned i = 0; i < inputs->count; i++)
            if (strcmp(inputs->item[i].name, info->name) == 0)
                vor_text_printf(text, "%s %s\n", info->name, inputs->item[i].sha256);
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
    list_inputs(&text, spec->process->inputs, inputs);
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
