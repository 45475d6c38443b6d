#include "server/api/handlers/submission.h"

#include "core/base/quote.h"
#include "proto/multipart.h"
#include "server/api/problem.h"
#include "server/base/disk.h"
#include "server/base/metrics.h"

#include <stdlib.h>
#include <string.h>

enum {
    TEXT_MAX = 4096,      /* bytes of a text field */
    PATIENCE = 256 << 10, /* bytes read of a form that is refused already */
    SHOWN_SIZE = 32       /* of a name in a message */
};

/* What curl's documentation, and so everybody's first try, calls the file. */
static const char main_alias[] = "file";

struct vor_submit_form {
    struct vor_request *request;
    struct vor_submit_head *head;
    struct vor_uploads *uploads;
    struct vor_multipart scanner;
    struct vor_error error;  /* of a form that is refused; else its status is VOR_OK */
    uint64_t wasted;         /* bytes since then */
    struct vor_upload *file; /* the part at hand is this one; NULL: a text */
    bool is_unnamed;
    char name[VOR_MULTIPART_NAME_MAX + 1];
    char text[TEXT_MAX + 1];
    size_t size;                     /* of the text */
    bool given[VOR_PARAMETER_COUNT]; /* by a field of this form */
};

static vor_status refuse_twice(const char *name, struct vor_error *err)
{
    return vor_fail_param(err, VOR_E_PARAM, name, "%s is given more than once", name);
}

/* --- parts ------------------------------------------------------------------------------------ */

static vor_status begin_file(struct vor_submit_form *form, const struct vor_artefact_info *input,
                             const struct vor_multipart_part *part, struct vor_error *err)
{
    struct vor_uploads *uploads = form->uploads;
    int coding = vor_submit_coding(part->coding);
    vor_status status;

    for (unsigned i = 0; i < uploads->count; i++)
        if (uploads->item[i].name == input->name)
            return refuse_twice(input->name, err);
    if (coding < 0)
        return vor_fail(err, VOR_E_UNSUPPORTED,
                        "the Content-Encoding of %s is %s, want gzip or none", input->name,
                        VOR_QUOTED(SHOWN_SIZE, part->coding, strlen(part->coding)));
    status = vor_uploads_begin(uploads, input->name, coding > 0, form->request->app->blobs, err);
    if (status == VOR_OK)
        form->file = &uploads->item[uploads->count - 1];
    form->is_unnamed = part->is_unnamed;
    return status;
}

static vor_status begin_text(struct vor_submit_form *form, const struct vor_multipart_part *part,
                             struct vor_error *err)
{
    enum vor_parameter parameter = vor_parameter_find(part->name);

    const struct vor_submit_options *options = &form->head->options;
    bool is_option = vor_submit_options_has(form->head->spec.process, part->name), was_given;

    if (!is_option && (parameter == VOR_PARAMETER_COUNT ||
                       !vor_process_takes(form->head->spec.process, parameter))) {
        const struct vor_artefact_info *inputs = form->head->spec.process->inputs;
        char files[(SHOWN_SIZE + 2) * VOR_INPUTS_MAX];
        struct vor_error which;
        size_t at = 0;

        /* The files that the process takes stand behind the parameters. */
        (void)vor_spec_refuse(&form->head->spec, part->name, "a file", &which);
        for (unsigned i = 1; inputs[i].name != NULL && at < sizeof files; i++)
            at += (size_t)snprintf(files + at, sizeof files - at, ", %s", inputs[i].name);
        if (at == 0)
            files[0] = '\0';
        return vor_fail_param(
            err, VOR_E_PARAM, VOR_QUOTED(SHOWN_SIZE, part->name, strlen(part->name)),
            "%s; its files are %s (or %s)%s", which.message, inputs[0].name, main_alias, files);
    }
    if (part->is_file || part->coding[0] != '\0')
        return vor_fail_param(err, VOR_E_PARAM, part->name, "%s is %s, want a text", part->name,
                              part->is_file ? "a file" : "encoded");
    if (vor_request_query(form->request, part->name) != NULL)
        return vor_fail_param(err, VOR_E_PARAM, part->name,
                              "%s is given in the query and in the form, want it in only one "
                              "of these places",
                              part->name);
    if (is_option)
        was_given = (strcmp(part->name, "name") == 0    ? options->name
                     : strcmp(part->name, "input") == 0 ? options->input.text
                                                        : options->previous.text)[0] != '\0';
    else
        was_given = form->given[parameter];
    if (was_given)
        return refuse_twice(part->name, err);
    if (!is_option)
        form->given[parameter] = true;
    memcpy(form->name, part->name, strlen(part->name) + 1);
    return VOR_OK;
}

static vor_status on_part(void *ctx, const struct vor_multipart_part *part, struct vor_error *err)
{
    struct vor_submit_form *form = ctx;
    const struct vor_artefact_info *inputs = form->head->spec.process->inputs;
    const struct vor_artefact_info *input = vor_artefact_find(inputs, part->name);

    if (input == NULL && strcmp(part->name, main_alias) == 0)
        input = &inputs[0];
    form->file = NULL;
    form->size = 0;
    if (input != NULL && !part->is_file &&
        vor_submit_options_has(form->head->spec.process, part->name))
        input = NULL; /* it names a job */
    return input != NULL ? begin_file(form, input, part, err) : begin_text(form, part, err);
}

static vor_status on_data(void *ctx, const void *bytes, size_t size, struct vor_error *err)
{
    struct vor_submit_form *form = ctx;

    if (form->file != NULL) {
        vor_metric_add(VOR_METRIC_UPLOAD_BYTES, (double)size, NULL);
        return vor_blob_append(form->file->bytes, bytes, size, err);
    }
    if (size > TEXT_MAX - form->size)
        return vor_fail_param(err, VOR_E_PARAM, form->name, "%s has more than the allowed %d bytes",
                              form->name, TEXT_MAX);
    memcpy(form->text + form->size, bytes, size);
    form->size += size;
    return VOR_OK;
}

static vor_status on_end(void *ctx, struct vor_error *err)
{
    struct vor_submit_form *form = ctx;
    int taken;
    vor_status status;

    if (form->file == NULL) {
        form->text[form->size] = '\0';
        if (strlen(form->text) != form->size)
            return vor_fail_param(err, VOR_E_PARAM, form->name,
                                  "%s has a NUL byte, want a text without one", form->name);
        status = vor_submit_options_take(&form->head->options, form->head->spec.process, form->name,
                                         form->text, &taken, err);
        if (status != VOR_OK || taken)
            return status;
        return vor_spec_set(&form->head->spec, form->name, form->text, err);
    }
    /* A browser's field without a file: nothing was given. */
    if (form->is_unnamed && vor_blob_size(form->file->bytes) == 0)
        vor_uploads_drop_last(form->uploads);
    return VOR_OK;
}

/* --- the whole -------------------------------------------------------------------------------- */

struct vor_submit_form *vor_submit_form_begin(struct vor_request *request,
                                              struct vor_submit_head *head,
                                              struct vor_uploads *uploads)
{
    struct vor_submit_form *form = calloc(1, sizeof *form);
    const struct vor_multipart_events events = {form, on_part, on_data, on_end};
    struct vor_error err;

    if (form == NULL) {
        vor_problem_no_memory(request);
        return NULL;
    }
    form->request = request;
    form->head = head;
    form->uploads = uploads;
    if (vor_multipart_begin(&form->scanner, vor_request_header(request, "Content-Type"), &events,
                            &err) == VOR_OK)
        return form;
    vor_problem_error(request, &err, NULL);
    free(form);
    return NULL;
}

void vor_submit_form_free(struct vor_submit_form *form)
{
    free(form);
}

/* What a refused form's next bytes come to. A disk that refuses is told at once. */
static int refused(struct vor_submit_form *form, size_t size)
{
    if (form->error.status == VOR_E_IO)
        return vor_error_storage_full(&form->error) ? 507 : 503;
    form->wasted += size;
    if (form->wasted <= PATIENCE)
        return 0;
    vor_problem_error(form->request, &form->error, NULL);
    return -1;
}

int vor_submit_form_take(void *ctx, const void *bytes, size_t size)
{
    struct vor_submit_form *form = ctx;

    if (form->error.status != VOR_OK)
        return refused(form, size);
    if (vor_multipart_feed(&form->scanner, bytes, size, &form->error) != VOR_OK)
        return refused(form, 0);
    return 0;
}

/* Adds an input that is another job's, unless the form has it as well. */
static vor_status add_of_job(unsigned *inputs, const struct vor_process_info *process,
                             const char *option, const struct vor_uuid *job, struct vor_error *err)
{
    const struct vor_artefact_info *input = vor_artefact_find(process->inputs, option);
    unsigned bit;

    if (job->text[0] == '\0')
        return VOR_OK;
    if (input == NULL)
        input = process->inputs; /* the main one has another name */
    bit = 1u << (input - process->inputs);
    if ((*inputs & bit) != 0)
        return vor_fail_param(err, VOR_E_PARAM, option,
                              "%s is job:%s, but the form also has a file %s; send only one input",
                              option, job->text, input->name);
    *inputs |= bit;
    return VOR_OK;
}

bool vor_submit_form_end(struct vor_submit_form *form)
{
    const struct vor_submit_options *options = &form->head->options;
    const struct vor_spec *spec = &form->head->spec;
    struct vor_error *err = &form->error;
    vor_status status = err->status;
    unsigned inputs = 0;

    VOR_THEN(status, vor_multipart_finish(&form->scanner, err));
    for (unsigned i = 0; i < form->uploads->count; i++)
        for (unsigned k = 0; spec->process->inputs[k].name != NULL; k++)
            if (spec->process->inputs[k].name == form->uploads->item[i].name)
                inputs |= 1u << k;
    if (status == VOR_OK &&
        add_of_job(&inputs, spec->process, "input", &options->input, err) == VOR_OK &&
        add_of_job(&inputs, spec->process, "previous", &options->previous, err) == VOR_OK &&
        vor_spec_check_inputs(spec, inputs, err) == VOR_OK)
        return true;
    return vor_problem_error(form->request, err, NULL);
}
