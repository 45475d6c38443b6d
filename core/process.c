#include "core/process.h"

#include "core/report.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
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

/* The time that a request allows a run: a watch that answers VOR_STOP once it is over, and else as
 * another one does. Then loops end as if the caller had stopped the run, and what cannot be left
 * out is done the fastest way. */
struct budget {
    const struct vor_watch *inner;
    double until;     /* by its clock */
    atomic_int ended; /* it answered VOR_STOP, and not the other one */
    struct vor_watch watch;
};

/* Shares of the time allowed, and seconds, that a run may take beyond it before it does the fastest
 * way what it cannot leave out: placing first points, and keeping the last ones to the input. With
 * 1 s, 500 neighbors and one thread, 16,000 points on 1,000, and 20,000 on as many, take 1.1 / 1.5
 * / 2.1 s of CPU at shares of 0 / 0.5 / 1; they need 1.5 to 3 s for good first points. The seconds
 * are for requests of less than one, whose first points would be poor. */
#define LATE_SHARE 0.5
#define LATE_SECONDS 0.5

static enum vor_answer ask(void *ctx)
{
    struct budget *budget = ctx;
    enum vor_answer answer = budget->inner->poll(budget->inner->ctx);

    if (answer != VOR_CONTINUE || !(budget->inner->clock(budget->inner->ctx) > budget->until))
        return answer;
    atomic_store(&budget->ended, 1);
    return VOR_STOP;
}

/* The loops ask for the time themselves after each step. */
static enum vor_answer tell(void *ctx, const struct vor_record *record)
{
    const struct budget *budget = ctx;

    return budget->inner->progress(budget->inner->ctx, record);
}

static void show(void *ctx, const struct vor_moving *points, const struct vor_record *record)
{
    const struct budget *budget = ctx;

    budget->inner->points(budget->inner->ctx, points, record);
}

static double read_clock(void *ctx)
{
    const struct budget *budget = ctx;

    return budget->inner->clock(budget->inner->ctx);
}

/* Makes run's watch one that ends after `seconds` from run->began, and sets run->late. Does nothing
 * where its watch has no clock or no poll, which says that threads of the pool may ask. Both
 * watches must outlive the run. */
static void begin_budget(struct budget *budget, struct vor_run *run, double seconds)
{
    const struct vor_watch *inner = run->watch;

    if (inner == NULL || inner->clock == NULL || inner->poll == NULL)
        return;
    budget->inner = inner;
    budget->until = run->began + seconds;
    budget->watch = (struct vor_watch){.ctx = budget,
                                       .progress = inner->progress != NULL ? tell : NULL,
                                       .poll = ask,
                                       .points = inner->points != NULL ? show : NULL,
                                       .clock = read_clock};
    run->watch = &budget->watch;
    run->late = budget->until + fmax(LATE_SHARE * seconds, LATE_SECONDS);
}

vor_status vor_process_run(const struct vor_process *process, struct vor_artefacts *out,
                           const struct vor_artefacts *in, const struct vor_spec *spec,
                           const struct vor_run *run, struct vor_error *err)
{
    struct vor_run begun = *run;
    struct vor_no_stop no_stop;
    struct budget budget = {.ended = 0};
    const struct vor_cloud *cloud;
    vor_status status;

    begun.began = vor_run_clock(run);
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        begin_budget(&budget, &begun, spec->value[VOR_PARAM_SECONDS]);
    begun.no_stop = vor_no_stop_watch(&no_stop, begun.watch);
    status = process->run(out, in, spec, &begun, err);
    /* A run whose time was over in the middle of a step ended as one that is stopped. */
    if (status == VOR_OK && atomic_load(&budget.ended)) {
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
