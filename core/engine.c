#include "core/engine.h"

#include "core/cvt/cvt.h"
#include "core/geom/patch.h"
#include "core/input/density.h"
#include "core/input/input.h"
#include "core/input/islands.h"
#include "core/input/sampled.h"
#include "core/kmeans/kmeans.h"
#include "core/metrics/inspect.h"
#include "core/metrics/measure.h"
#include "core/output/convert.h"
#include "core/output/filtered.h"
#include "core/output/last_record.h"
#include "core/output/notes.h"
#include "core/output/output.h"
#include "core/seeds/area.h"
#include "core/seeds/fixed.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* The methods, in the order of the words of parameter `method`. */
static const struct vor_method methods[VOR_METHODS] = {{"cvt", vor_cvt_run},
                                                       {"kmeans", vor_kmeans_run},
#define METHOD_ROW(word, run) {word, run},
                                                       VOR_EXTRA_METHODS(METHOD_ROW)
#undef METHOD_ROW
};

static const struct vor_method *method_of(const struct vor_spec *spec)
{
    unsigned index = (unsigned)spec->value[VOR_PARAM_METHOD];

    assert(index < VOR_METHODS);
    return &methods[index];
}

/* A run of a process that spreads points. */
struct engine {
    const struct vor_cloud *given, *in; /* in: what is resampled, given or sampled */
    struct vor_cloud sampled;           /* points of its faces, if the request says so */
    struct vor_spec spec;
    struct vor_run run, whole; /* whole: for parts that a stop must not interrupt */
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_outcome told;
    struct vor_report report;
    double area; /* that spacing was turned into points with, normalised; else 0 */
};

/* Computes how many points the request asks for; leaves *n 0 where filters decide. */
static vor_status resolve_target(struct engine *engine, size_t *n, struct vor_error *err)
{
    const struct vor_spec *spec = &engine->spec;
    double target = vor_spec_target(spec, engine->given->n);
    vor_status status;

    if (vor_spec_only_filters(spec))
        return VOR_OK;
    if (vor_spec_given(spec, VOR_PARAM_SPACING)) {
        double spacing = spec->value[VOR_PARAM_SPACING] / engine->domain.unit;

        status = vor_area_of_surface(&engine->area, &engine->domain,
                                     (uint64_t)spec->value[VOR_PARAM_SEED], &engine->whole, err);
        if (status != VOR_OK)
            return status;
        target = rint(engine->area / (VOR_HEXAGON_HEIGHT * spacing * spacing));
        if (target <= (double)VOR_POINTS_MAX)
            target += (double)vor_islands_beside(&engine->domain, (size_t)target);
    }
    status = vor_spec_check_target(spec, target, engine->given->n, err);
    if (status == VOR_OK)
        *n = (size_t)target;
    return status;
}

static vor_status prepare(struct engine *engine, size_t *n, struct vor_error *err)
{
    vor_status status =
        vor_input_sampled(&engine->in, &engine->sampled, engine->given, &engine->spec, err);

    if (status == VOR_OK)
        status = vor_input_prepare(&engine->domain, engine->in, &engine->spec, &engine->whole, err);
    if (status != VOR_OK)
        return status;
    engine->report.seconds_index = vor_run_seconds(&engine->run);
    status = resolve_target(engine, n, err);
    engine->report.seconds_init = vor_run_seconds(&engine->run) - engine->report.seconds_index;
    return status;
}

/* Notes how long the stages took: what is no polish counts as iterations. */
static void report_stages(struct vor_report *report, const struct vor_outcome *told)
{
    for (int stage = 0; stage < VOR_RUN_STAGE_COUNT; stage++)
        *(stage == VOR_RUN_STAGE_POLISH ? &report->seconds_polish : &report->seconds_iterate) +=
            told->seconds[stage];
}

static vor_status place(struct engine *engine, size_t n, struct vor_error *err)
{
    const struct vor_method *method = method_of(&engine->spec);
    size_t share = vor_islands_share(&engine->domain, n);
    vor_status status = VOR_OK;

    if (share < n)
        status = vor_density_make(&engine->domain, engine->in, n - share, &engine->spec,
                                  &engine->whole, err);
    if (status == VOR_OK && share < n)
        status = method->run(&engine->seeds, &engine->told, &engine->domain, n - share,
                             &engine->spec, &engine->run, err);
    engine->report.seconds_init += engine->told.seconds_start;
    report_stages(&engine->report, &engine->told);
    engine->report.on_islands = share;
    if (status != VOR_OK)
        return status;
    return vor_seeds_add_islands(&engine->seeds, &engine->report.delta_beside, &engine->domain,
                                 share, vor_seeds_policy_of(&engine->spec), &engine->run, err);
}

/* Makes the result of the points that a method placed, or if it placed none of the input's. */
static vor_status make_output(struct engine *engine, struct vor_cloud *out, struct vor_error *err)
{
    struct vor_placed placed = {engine->in, &engine->seeds, &engine->told, &engine->spec};
    struct vor_filtered filtered = {engine->in, &engine->domain, &engine->spec};

    if (engine->seeds.n > 0)
        return vor_output_make(out, &engine->report, &placed, err);
    return vor_output_filtered(out, &engine->report, &filtered, &engine->whole, err);
}

static vor_status finish(struct engine *engine, struct vor_cloud *out, struct vor_error *err)
{
    struct vor_report *report = &engine->report;
    double unit = engine->domain.unit;
    vor_status status = make_output(engine, out, err);

    if (status == VOR_OK)
        status = vor_output_notes(out, report, engine->given, err);
    if (status == VOR_OK)
        status = vor_last_record_tell(&engine->told, report, &engine->run, err);
    if (status != VOR_OK) {
        vor_cloud_free(out);
        return status;
    }
    report->points_in = engine->given->n;
    report->samples = engine->sampled.n;
    if (report->on_islands == 0)
        report->delta_beside = report->delta;
    report->parameters = engine->spec;
    if (engine->seeds.n > 0)
        report->parameters.value[VOR_PARAM_POINTS] = (double)engine->seeds.n;
    report->parameters.value[VOR_PARAM_NEIGHBORS] = engine->domain.known.neighbors.usual;
    if (engine->area > 0)
        report->area = engine->area * unit * unit;
    report->memory_peak_bytes = atomic_load(&engine->run.memory->peak);
    return VOR_OK;
}

/* The processes that spread points: resample and its presets. */
static vor_status run_resample(struct vor_artefacts *out, const struct vor_artefacts *in,
                               const struct vor_spec *spec, const struct vor_run *run,
                               struct vor_error *err)
{
    struct vor_report *report = vor_artefacts_put_document(out, "report", &vor_report_members, err);
    struct engine engine = {.given = vor_artefacts_cloud(in, "cloud"),
                            .spec = *spec,
                            .run = *run,
                            .whole = vor_run_unstoppable(run)};
    struct vor_cloud cloud;
    vor_status status;
    size_t n = 0;

    if (report == NULL)
        return VOR_E_NOMEM;
    vor_cloud_init(&cloud, run->memory);
    vor_cloud_init(&engine.sampled, run->memory);
    status = prepare(&engine, &n, err);
    if (status == VOR_OK && n > 0)
        status = place(&engine, n, err);
    if (status == VOR_OK)
        status = finish(&engine, &cloud, err);
    if (status == VOR_OK) {
        *report = engine.report;
        vor_artefacts_put_cloud(out, "cloud", &cloud);
    }
    vor_seeds_free(&engine.seeds);
    vor_domain_free(&engine.domain);
    vor_cloud_free(&engine.sampled);
    return status;
}

static vor_status run_convert(struct vor_artefacts *out, const struct vor_artefacts *in,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    struct vor_report *report = vor_artefacts_put_document(out, "report", &vor_report_members, err);
    const struct vor_run whole = vor_run_unstoppable(run);
    struct vor_cloud cloud;
    vor_status status;

    if (report == NULL)
        return VOR_E_NOMEM;
    vor_cloud_init(&cloud, run->memory);
    status = vor_convert_cloud(&cloud, report, vor_artefacts_cloud(in, "cloud"), spec, &whole, err);
    report->seconds_index = vor_run_seconds(run);
    report->memory_peak_bytes = atomic_load(&run->memory->peak);
    if (status == VOR_OK)
        vor_artefacts_put_cloud(out, "cloud", &cloud);
    return status;
}

static vor_status run_measure(struct vor_artefacts *out, const struct vor_artefacts *in,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    struct vor_measure *measure =
        vor_artefacts_put_document(out, "measure", &vor_measure_members, err);
    double peak = spec->value[VOR_PARAM_PEAK];

    if (measure == NULL)
        return VOR_E_NOMEM;
    return vor_measure_clouds(measure, vor_artefacts_cloud(in, "cloud"),
                              vor_artefacts_cloud(in, "reference"), peak == VOR_UNSET ? 0 : peak,
                              run, err);
}

static vor_status inspect(struct vor_inspect *out, struct vor_domain *domain,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    double area = 0, unit = domain->unit;
    vor_status status =
        vor_area_of_surface(&area, domain, (uint64_t)spec->value[VOR_PARAM_SEED], run, err);

    out->area = area * unit * unit;
    return status == VOR_OK ? vor_inspect_domain(out, domain, spec, run, err) : status;
}

static vor_status run_inspect(struct vor_artefacts *out, const struct vor_artefacts *in,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    struct vor_inspect *told =
        vor_artefacts_put_document(out, "inspect", &vor_inspect_members, err);
    const struct vor_cloud *cloud = vor_artefacts_cloud(in, "cloud");
    const struct vor_run whole = vor_run_unstoppable(run);
    struct vor_domain domain;
    vor_status status;

    if (told == NULL)
        return VOR_E_NOMEM;
    status = vor_input_prepare(&domain, cloud, spec, &whole, err);
    if (status != VOR_OK)
        return status;
    vor_inspect_cloud(told, cloud);
    status = inspect(told, &domain, spec, &whole, err);
    vor_domain_free(&domain);
    return status;
}

/* Which function runs a process; a row for each of core/spec/tables.h. */
static const struct vor_process processes[] = {
    {"resample", run_resample},    {"denoise", run_resample}, {"upsample", run_resample},
    {"simplify", run_resample},    {"measure", run_measure},  {"inspect", run_inspect},
    {"convert", run_convert},
#define PROCESS_ROW(id, run) {id, run},
    VOR_EXTRA_RUNNERS(PROCESS_ROW)
#undef PROCESS_ROW
};

static const struct vor_process *process_of(const struct vor_spec *spec)
{
    for (size_t i = 0; i < sizeof processes / sizeof processes[0]; i++)
        if (strcmp(processes[i].id, spec->process->id) == 0)
            return &processes[i];
    return NULL;
}

vor_status vor_engine_run(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    const struct vor_process *process = process_of(spec);
    struct vor_run begun = *run;
    struct vor_no_stop no_stop;
    vor_status status;

    assert(process != NULL);
    begun.began = vor_run_clock(run);
    begun.no_stop = vor_no_stop_watch(&no_stop, run->watch);
    status = process->run(out, in, spec, &begun, err);
    for (const struct vor_artefact_info *o = spec->process->outputs; o->name != NULL; o++)
        assert(status != VOR_OK || vor_artefacts_find(out, o->name) != NULL);
    return status;
}
