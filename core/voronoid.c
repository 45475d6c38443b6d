#include "core/voronoid.h"

#include "core/engine.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define VALUES "value"

/* struct vor_threads is struct vor_pool, under a name that the library's header may have. */

/* A call from its beginning to its end. */
struct call {
    const struct vor_call *asked; /* never NULL */
    struct vor_memory memory;
    struct vor_pool *own; /* where the caller has none */
    struct vor_watch watch;
    struct vor_spec spec;
    struct vor_artefacts in, out;
    struct vor_error err;
};

static const struct vor_call nothing_asked;

static void tell(struct vor_failure *failure, vor_status status, const struct vor_error *err)
{
    if (failure == NULL)
        return;
    memset(failure, 0, sizeof *failure);
    if (status == VOR_OK)
        return;
    snprintf(failure->name, sizeof failure->name, "%s", vor_status_slug(status));
    snprintf(failure->parameter, sizeof failure->parameter, "%s", err->parameter);
    snprintf(failure->message, sizeof failure->message, "%s", err->message);
}

static enum vor_answer on_progress(void *ctx, const struct vor_record *record)
{
    const struct vor_call *asked = ctx;
    const struct vor_state state = {record->iteration + record->polish, record->delta};

    switch (asked->progress(asked->ctx, &state)) {
    case VOR_GO_ON:
        return VOR_CONTINUE;
    case VOR_TAKE_BEST:
        return VOR_STOP;
    default:
        return VOR_CANCEL;
    }
}

static void begin(struct call *call, const struct vor_call *asked)
{
    memset(call, 0, sizeof *call);
    call->asked = asked != NULL ? asked : &nothing_asked;
    vor_memory_init(&call->memory, call->asked->memory > 0 ? call->asked->memory : SIZE_MAX);
    vor_artefacts_init(&call->in, &call->memory);
    vor_artefacts_init(&call->out, &call->memory);
    call->watch.ctx = (void *)(uintptr_t)call->asked;
    call->watch.progress = call->asked->progress != NULL ? on_progress : NULL;
}

static int end(struct call *call, vor_status status, struct vor_failure *failure)
{
    vor_artefacts_free(&call->in);
    vor_artefacts_free(&call->out);
    vor_pool_destroy(call->own);
    tell(failure, status, &call->err);
    return status == VOR_OK ? 0 : -1;
}

/* Reads the request; `points` of the result, 0 where the process has no such number. */
static vor_status ask(struct call *call, const char *process, size_t points)
{
    const char *const *at = call->asked->parameters;
    vor_status status = VOR_OK;

    vor_spec_preset(&call->spec, vor_process_find(process));
    for (; status == VOR_OK && at != NULL && at[0] != NULL; at += 2)
        status = at[1] != NULL
                     ? vor_spec_set(&call->spec, at[0], at[1], &call->err)
                     : vor_fail_param(&call->err, VOR_E_PARAM, at[0], "%s has no value", at[0]);
    if (status == VOR_OK && points > 0)
        status = vor_spec_set_number(&call->spec, "points", (double)points, &call->err);
    VOR_THEN(status, vor_spec_complete(&call->spec, &call->err));
    return status == VOR_OK ? vor_spec_check_inputs(&call->spec, 1, &call->err) : status;
}

/* Copies the caller's points, with their values unless components is 0. */
static vor_status take(struct call *call, const struct vor_points *points, unsigned components)
{
    struct vor_attribute *attribute;
    struct vor_cloud cloud;
    vor_status status;

    vor_cloud_init(&cloud, &call->memory);
    status = vor_cloud_resize(&cloud, points->n, &call->err);
    if (status == VOR_OK) {
        memcpy(cloud.xyz, points->xyz, 3 * points->n * sizeof *points->xyz);
        status = vor_cloud_check(&cloud, &call->err);
    }
    if (status == VOR_OK && components > 0)
        status = vor_cloud_add_attribute(&cloud, VALUES, VOR_GENERIC, VOR_FLOAT32, components,
                                         &attribute, &call->err);
    if (status != VOR_OK) {
        vor_cloud_free(&cloud);
        return status;
    }
    if (components > 0)
        memcpy(attribute->data, points->values, points->n * components * sizeof *points->values);
    vor_artefacts_put_cloud(&call->in, "cloud", &cloud);
    return VOR_OK;
}

static vor_status run_engine(struct call *call)
{
    struct vor_run run = {.memory = &call->memory, .watch = &call->watch};
    vor_status status = VOR_OK;

    if (call->asked->threads == NULL)
        status = vor_pool_create(&call->own, 1, &call->err);
    run.pool = call->asked->threads != NULL ? (struct vor_pool *)call->asked->threads : call->own;
    return status == VOR_OK ? vor_engine_run(&call->out, &call->in, &call->spec, &run, &call->err)
                            : status;
}

/* Copies the result into the caller's arrays, which are as long. */
static vor_status give(struct call *call, struct vor_points *out, unsigned components)
{
    const struct vor_cloud *cloud = vor_artefacts_cloud(&call->out, "cloud");
    const struct vor_attribute *values = vor_cloud_find_name(cloud, VALUES);

    if (cloud->n != out->n || (components > 0 && values == NULL))
        return vor_fail(&call->err, VOR_E_INTERNAL, "the result has %zu points, want %zu", cloud->n,
                        out->n);
    memcpy(out->xyz, cloud->xyz, 3 * out->n * sizeof *out->xyz);
    if (components > 0)
        memcpy(out->values, values->data, out->n * components * sizeof *out->values);
    return VOR_OK;
}

static int spread(const char *process, struct vor_points *out, const struct vor_points *in,
                  const struct vor_call *asked, struct vor_failure *failure)
{
    unsigned components = out->components;
    struct call call;
    vor_status status;

    begin(&call, asked);
    if (components != 0 && components != in->components)
        status = vor_fail(&call.err, VOR_E_PARAM,
                          "the result has %u components, want %u as in "
                          "the input",
                          components, in->components);
    else if (out->n == 0)
        status = vor_fail_param(&call.err, VOR_E_TARGET, "points", "points is 0");
    else
        status = ask(&call, process, out->n);
    VOR_THEN(status, vor_spec_check_target(&call.spec, (double)out->n, in->n, &call.err));
    VOR_THEN(status, take(&call, in, components));
    VOR_THEN(status, run_engine(&call));
    VOR_THEN(status, give(&call, out, components));
    return end(&call, status, failure);
}

struct vor_threads *vor_threads_start(unsigned threads, struct vor_failure *failure)
{
    struct vor_pool *pool = NULL;
    struct vor_error err;
    vor_status status = vor_pool_create(&pool, threads, &err);

    tell(failure, status, &err);
    return (struct vor_threads *)pool;
}

void vor_threads_end(struct vor_threads *threads)
{
    vor_pool_destroy((struct vor_pool *)threads);
}

int vor_restore(struct vor_points *points, const struct vor_call *asked,
                struct vor_failure *failure)
{
    struct call call;
    vor_status status;

    begin(&call, asked);
    status = ask(&call, "restore", 0);
    VOR_THEN(status, take(&call, points, 0));
    VOR_THEN(status, run_engine(&call));
    VOR_THEN(status, give(&call, points, 0));
    return end(&call, status, failure);
}

int vor_resample(struct vor_points *out, const struct vor_points *in, const struct vor_call *asked,
                 struct vor_failure *failure)
{
    return spread("resample", out, in, asked, failure);
}

int vor_upsample(struct vor_points *out, const struct vor_points *in, const struct vor_call *asked,
                 struct vor_failure *failure)
{
    return spread("upsample", out, in, asked, failure);
}
