#include "core/engine.h"

#include "core/align/align.h"
#include "core/baselines/baselines.h"
#include "core/cvt/cvt.h"
#include "core/input/followed.h"
#include "core/input/input.h"
#include "core/input/islands.h"
#include "core/input/motion.h"
#include "core/input/restore.h"
#include "core/input/sampled.h"
#include "core/input/splats.h"
#include "core/kmeans/kmeans.h"
#include "core/lop/lop.h"
#include "core/metrics/inspect.h"
#include "core/metrics/measure.h"
#include "core/output/convert.h"
#include "core/output/filtered.h"
#include "core/output/last_record.h"
#include "core/output/notes.h"
#include "core/output/output.h"
#include "core/output/transfer.h"
#include "core/output/triangles.h"
#include "core/remesh/remesh.h"
#include "core/seeds/area.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/fixed.h"
#include "core/seeds/target.h"

#include <assert.h>
#include <string.h>

/* The methods, in the order of the words of parameter `method`. */
static const struct vor_method methods[VOR_METHODS] = {
    {"cvt", vor_cvt_run}, {"kmeans", vor_kmeans_run},    {"wlop", vor_wlop_run},
    {"ear", vor_ear_run}, {"isotropic", vor_remesh_run}, {"insert", vor_cvt_run},
};

/* A run of a process that spreads points. */
struct engine {
    const struct vor_cloud *given, *previous; /* previous: or NULL */
    const struct vor_cloud *in;               /* what is resampled: given, or sampled */
    struct vor_cloud sampled;                 /* points of its faces, if the request says so */
    struct vor_spec spec;
    struct vor_run run, whole; /* whole: for parts that a stop must not interrupt */
    struct vor_checkpoints checkpoints;
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_outcome told;
    struct vor_report report;
    int meshes;           /* the process joins the result by triangles */
    struct vor_mesh mesh; /* they */
    uint32_t *order;      /* and which seed each point of the result is */
    struct vor_target target;
};

static vor_status prepare(struct engine *engine, struct vor_error *err)
{
    vor_status status = vor_splats_check(engine->given, &engine->spec, err);

    VOR_THEN(status,
             vor_input_sampled(&engine->in, &engine->sampled, engine->given, &engine->spec, err));
    VOR_THEN(status,
             vor_input_prepare(&engine->domain, engine->in, &engine->spec, &engine->whole, err));
    if (status != VOR_OK)
        return status;
    engine->report.seconds_index = vor_run_seconds(&engine->run);
    status = vor_target_resolve(&engine->target, &engine->domain, engine->given->n, &engine->spec,
                                &engine->whole, err);
    engine->report.seconds_init = vor_run_seconds(&engine->run) - engine->report.seconds_index;
    return status;
}

static vor_status place(struct engine *engine, struct vor_error *err)
{
    struct vor_domain *domain = &engine->domain;
    unsigned method = (unsigned)engine->spec.value[VOR_PARAM_METHOD];
    int all = method == VOR_METHOD_INSERT; /* of the input are in the result */
    size_t n = engine->target.n, share = (all ? vor_islands_beside : vor_islands_share)(domain, n);
    size_t rest = n - (all ? engine->given->n : share);
    vor_status status = vor_domain_continue(domain, engine->in, engine->previous, err);

    if (!vor_spec_given(&engine->spec, VOR_PARAM_COHERENCE) ||
        engine->spec.value[VOR_PARAM_COHERENCE] > 0)
        VOR_THEN(status, vor_motion_follow(domain, &engine->whole, err));
    if (status == VOR_OK && rest > 0)
        status = vor_followed_make(domain, engine->in, rest, &engine->spec, &engine->whole, err);
    if (status == VOR_OK && (rest > 0 || all))
        status = methods[method].run(&engine->seeds, &engine->told, domain, rest, &engine->spec,
                                     &engine->run, err);
    engine->report.seconds_init += engine->told.seconds_start;
    engine->report.on_islands = share;
    VOR_THEN(status,
             vor_seeds_add_islands(&engine->seeds, &engine->report.delta_beside, domain, share,
                                   vor_seeds_policy_of(&engine->spec), &engine->run, err));
    return status;
}

/* Makes the result of the points that a method placed, or if it placed none of the input's. */
static vor_status make_output(struct engine *engine, struct vor_cloud *out, struct vor_error *err)
{
    struct vor_placed placed = {engine->in, &engine->seeds, &engine->told, &engine->spec, NULL};
    struct vor_filtered filtered = {engine->in, &engine->domain, &engine->spec};
    vor_status status = VOR_OK;

    if (engine->seeds.n == 0)
        return vor_output_filtered(out, &engine->report, &filtered, &engine->whole, err);
    if (engine->meshes)
        status = vor_triangles_of_seeds(&engine->mesh, &engine->order, &engine->report,
                                        &engine->seeds, &engine->told, &engine->spec, err);
    placed.order = engine->order;
    return status == VOR_OK ? vor_output_make(out, &engine->report, &placed, err) : status;
}

static vor_status finish(struct engine *engine, struct vor_cloud *out, struct vor_error *err)
{
    struct vor_report *report = &engine->report;
    struct vor_baselines_of beside = {&engine->domain, engine->seeds.n, &methods[VOR_METHOD_KMEANS],
                                      &engine->told, &engine->spec};
    vor_status status = make_output(engine, out, err);
    struct vor_triangles_of joined = {engine->in,     out,           &engine->domain,
                                      &engine->seeds, engine->order, &engine->spec};

    if (status == VOR_OK && engine->previous == NULL &&
        vor_spec_given(&engine->spec, VOR_PARAM_COHERENCE))
        status = vor_transfer_number(out, err);
    if (status == VOR_OK && engine->previous != NULL)
        vor_transfer_keep_common(out, engine->previous);
    VOR_THEN(status, vor_output_notes(out, report, engine->given, err));
    if (status == VOR_OK && engine->meshes)
        status = vor_triangles_finish(&engine->mesh, report, &joined, &engine->whole, err);
    VOR_THEN(status, vor_last_record_tell(&engine->told, report, &engine->run, err));
    VOR_THEN(status, vor_baselines_tell(report, &beside, &engine->run, err));
    if (status != VOR_OK) {
        vor_cloud_free(out);
        return status;
    }
    report->points_in = engine->given->n;
    report->samples = engine->sampled.n;
    if (report->on_islands == 0)
        report->delta_beside = report->delta;
    report->parameters = engine->spec;
    vor_warn_unused(report, &engine->spec);
    if (engine->seeds.n > 0)
        report->parameters.value[VOR_PARAM_POINTS] = (double)out->n;
    report->parameters.value[VOR_PARAM_OUTLIERS] = vor_spec_outliers(&report->parameters);
    report->parameters.value[VOR_PARAM_NEIGHBORS] = engine->domain.known.neighbors.usual;
    if (engine->target.area > 0)
        report->area = engine->target.area * engine->domain.unit * engine->domain.unit;
    report->memory_peak_bytes = atomic_load(&engine->run.memory->peak);
    return VOR_OK;
}

/* Spreads points, and the process mesh joins them by triangles. */
static vor_status run_spread(struct vor_artefacts *out, const struct vor_artefacts *in,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_report *report = vor_artefacts_put_document(out, "report", &vor_report_members, err);
    struct engine engine = {.given = vor_artefacts_cloud(in, "cloud"),
                            .previous = vor_artefacts_cloud(in, "previous"),
                            .spec = *spec,
                            .run = *run,
                            .whole = vor_run_unstoppable(run),
                            .meshes = spec->process == vor_process_find("mesh")};
    struct vor_cloud cloud;
    vor_status status;

    if (report == NULL)
        return VOR_E_NOMEM;
    vor_cloud_init(&cloud, run->memory);
    vor_cloud_init(&engine.sampled, run->memory);
    vor_mesh_init(&engine.mesh, run->memory);
    vor_checkpoints_begin(&engine.checkpoints, &engine.run, spec, engine.given, engine.previous);
    status = prepare(&engine, err);
    if (status == VOR_OK && engine.target.n > 0)
        status = place(&engine, err);
    VOR_THEN(status, finish(&engine, &cloud, err));
    if (status == VOR_OK) {
        *report = engine.report;
        vor_artefacts_put_mesh(out, "cloud", &cloud, &engine.mesh);
    }
    vor_free(run->memory, engine.order);
    vor_mesh_free(&engine.mesh);
    vor_seeds_free(&engine.seeds);
    vor_domain_free(&engine.domain);
    vor_cloud_free(&engine.sampled);
    return status;
}

/* The processes that hand out the points of the input: restored, registered or as they are. */
static vor_status run_points(struct vor_artefacts *out, const struct vor_artefacts *in,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_report *report = vor_artefacts_put_document(out, "report", &vor_report_members, err);
    const struct vor_run whole = vor_run_unstoppable(run);
    struct vor_cloud cloud;
    struct vor_mesh mesh;
    vor_status status;

    if (report == NULL)
        return VOR_E_NOMEM;
    vor_cloud_init(&cloud, run->memory);
    vor_mesh_init(&mesh, run->memory);
    status = vor_convert_cloud(&cloud, &mesh, report, vor_artefacts_cloud(in, "cloud"), spec,
                               &whole, err);
    if (status == VOR_OK && spec->process == vor_process_find("restore"))
        status = vor_restore_cloud(&cloud, report, spec, &whole, err);
    if (status == VOR_OK && spec->process == vor_process_find("register"))
        status =
            vor_align_cloud(&cloud, report, vor_artefacts_cloud(in, "reference"), spec, run, err);
    report->seconds_index = vor_run_seconds(run);
    report->memory_peak_bytes = atomic_load(&run->memory->peak);
    if (status == VOR_OK)
        vor_artefacts_put_mesh(out, "cloud", &cloud, &mesh);
    vor_mesh_free(&mesh);
    vor_cloud_free(&cloud);
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
    status = vor_area_of_surface(&told->area, &domain, (uint64_t)spec->value[VOR_PARAM_SEED],
                                 &whole, err);
    told->area *= domain.unit * domain.unit;
    VOR_THEN(status, vor_inspect_domain(told, &domain, spec, &whole, err));
    vor_domain_free(&domain);
    return status;
}

/* Which function runs a process; a row for each of core/spec/tables.h. */
static const struct vor_process processes[] = {
    {"resample", run_spread},      {"denoise", run_spread},  {"upsample", run_spread},
    {"simplify", run_spread},      {"measure", run_measure}, {"inspect", run_inspect},
    {"convert", run_points},       {"mesh", run_spread},     {"restore", run_points},
    {"register", run_points},
#define PROCESS_ROW(id, run) {id, run},
    VOR_EXTRA_RUNNERS(PROCESS_ROW)
#undef PROCESS_ROW
};

vor_status vor_engine_run(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    const struct vor_process *process = NULL;

    for (size_t i = 0; i < sizeof processes / sizeof processes[0]; i++)
        if (strcmp(processes[i].id, spec->process->id) == 0)
            process = &processes[i];
    assert(process != NULL);
    return vor_process_run(process, out, in, spec, run, err);
}
