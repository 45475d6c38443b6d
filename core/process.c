#include "core/process.h"

#include "core/base/budget.h"
#include "core/report.h"

#include <assert.h>
#include <string.h>

void vor_artefacts_init(struct vor_artefacts *set, struct vor_memory *memory)
{
    memset(set, 0, sizeof *set);
    set->memory = memory;
}

void vor_artefacts_free(struct vor_artefacts *set)
{
    for (unsigned i = 0; i < set->count; i++) {
        if (set->item[i].kind == VOR_ARTEFACT_CLOUD) {
            vor_mesh_free(&set->item[i].mesh);
            vor_cloud_free(&set->item[i].cloud);
        } else {
            vor_free(set->memory, set->item[i].values);
        }
    }
    set->count = 0;
}

static struct vor_artefact *add(struct vor_artefacts *set, const char *name,
                                enum vor_artefact_kind kind)
{
    struct vor_artefact *item;

    assert(set->count < VOR_ARTEFACTS_MAX && vor_artefacts_find(set, name) == NULL);
    item = &set->item[set->count++];
    memset(item, 0, sizeof *item);
    item->name = name;
    item->kind = kind;
    return item;
}

void vor_artefacts_put_cloud(struct vor_artefacts *set, const char *name, struct vor_cloud *cloud)
{
    add(set, name, VOR_ARTEFACT_CLOUD)->cloud = *cloud;
    vor_cloud_init(cloud, cloud->memory);
}

void vor_artefacts_put_mesh(struct vor_artefacts *set, const char *name, struct vor_cloud *cloud,
                            struct vor_mesh *mesh)
{
    vor_artefacts_put_cloud(set, name, cloud);
    set->item[set->count - 1].mesh = *mesh;
    vor_mesh_init(mesh, mesh->memory);
}

void *vor_artefacts_put_document(struct vor_artefacts *set, const char *name,
                                 const struct vor_members *members, struct vor_error *err)
{
    void *values = vor_calloc(set->memory, 1, members->size);
    struct vor_artefact *item;

    if (values == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "the %s", name);
        return NULL;
    }
    item = add(set, name, VOR_ARTEFACT_DOCUMENT);
    item->values = values;
    item->document = (struct vor_document){name, members, values};
    return values;
}

const struct vor_artefact *vor_artefacts_find(const struct vor_artefacts *set, const char *name)
{
    for (unsigned i = 0; i < set->count; i++)
        if (strcmp(set->item[i].name, name) == 0)
            return &set->item[i];
    return NULL;
}

const struct vor_cloud *vor_artefacts_cloud(const struct vor_artefacts *set, const char *name)
{
    const struct vor_artefact *item = vor_artefacts_find(set, name);

    return item != NULL && item->kind == VOR_ARTEFACT_CLOUD ? &item->cloud : NULL;
}

const struct vor_mesh *vor_artefacts_mesh(const struct vor_artefacts *set, const char *name)
{
    const struct vor_artefact *item = vor_artefacts_find(set, name);

    return item != NULL && item->kind == VOR_ARTEFACT_CLOUD ? &item->mesh : NULL;
}

void *vor_artefacts_values(struct vor_artefacts *set, const char *name,
                           const struct vor_members *members)
{
    const struct vor_artefact *item = vor_artefacts_find(set, name);

    return item != NULL && item->document.members == members ? item->values : NULL;
}

vor_status vor_process_run(const struct vor_process *process, struct vor_artefacts *out,
                           const struct vor_artefacts *in, const struct vor_spec *spec,
                           const struct vor_run *run, struct vor_error *err)
{
    struct vor_run begun = *run;
    struct vor_no_stop no_stop;
    struct vor_budget budget = {.ended = 0};
    const struct vor_cloud *cloud;
    vor_status status;

    begun.began = vor_run_clock(run);
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        vor_budget_begin(&budget, &begun, spec->value[VOR_PARAM_SECONDS]);
    begun.no_stop = vor_no_stop_watch(&no_stop, begun.watch);
    status = process->run(out, in, spec, &begun, err);
    /* A run whose time was over in the middle of a step ended as one that is stopped. */
    if (status == VOR_OK && vor_budget_ended(&budget)) {
        struct vor_report *report = vor_artefacts_values(out, "report", &vor_report_members);

        if (report != NULL && report->stopped == VOR_STOPPED_CALLER)
            report->stopped = VOR_STOPPED_SECONDS;
    }
    cloud = vor_artefacts_cloud(in, spec->process->inputs[0].name);
    if (status == VOR_E_NOMEM) /* which array did not fit means nothing to who sent the request */
        return vor_fail(err, VOR_E_NOMEM, "%s of %zu points", spec->process->id,
                        cloud != NULL ? cloud->n : 0);
    for (const struct vor_artefact_info *o = spec->process->outputs; o->name != NULL; o++)
        assert(status != VOR_OK || vor_artefacts_find(out, o->name) != NULL);
    return status;
}
