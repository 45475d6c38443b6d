#include "core/output/output.h"

#include "core/input/noise.h"
#include "core/output/compare.h"
#include "core/output/order.h"
#include "core/output/sides.h"
#include "core/output/snap.h"
#include "core/output/transfer.h"
#include "core/seeds/aspects.h"
#include "core/seeds/uniformity.h"

#include <string.h>

static vor_status transfer(struct vor_cloud *out, struct vor_report *report,
                           const struct vor_placed *placed, double spacing, struct vor_error *err)
{
    struct vor_seeds *seeds = placed->seeds;
    struct vor_sides sides = {.carried = NULL};
    struct vor_transfer_how how = {spacing, placed->spec, &sides};
    struct vor_sides_of of = {placed->in, seeds->whole, placed->spec, seeds->n, seeds->area};
    vor_status status =
        seeds->normal == NULL ? vor_sides_find(&sides, &of, &seeds->run, err) : VOR_OK;

    VOR_THEN(status, vor_transfer(out, placed->in, seeds, &how, err));
    if (placed->told->oriented) {
        sides.orientation.components = 1;
        sides.orientation.one_sided = placed->told->one_sided;
    }
    vor_sides_report(report, &sides);
    if (placed->spec->value[VOR_PARAM_NORMALS] == VOR_NORMALS_DROP)
        report->orientation = VOR_ORIENTED_NOT_ASKED; /* there are none that could face anywhere */
    vor_sides_free(&sides, seeds->run.memory);
    return status;
}

/* Makes the cloud, in the order that the request says. */
static vor_status hand_out(struct vor_cloud *out, struct vor_report *report,
                           const struct vor_placed *placed, const struct vor_uniformity *even,
                           struct vor_error *err)
{
    struct vor_seeds *seeds = placed->seeds;
    struct vor_memory *memory = seeds->run.memory;
    uint32_t *order = NULL;
    vor_status status = VOR_OK;

    if (placed->spec->value[VOR_PARAM_ORDER] == VOR_ORDER_PROGRESSIVE) {
        order = vor_malloc(memory, seeds->n, sizeof *order);
        if (order == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
        status = vor_order_progressive(order, seeds->xyz, seeds->n, even->mean, &seeds->run, err);
    }
    VOR_THEN(status, transfer(out, report, placed, even->mean * seeds->domain->unit, err));
    if (status == VOR_OK && order != NULL) {
        status = vor_cloud_reorder(out, order, err);
        if (status != VOR_OK)
            vor_cloud_free(out);
    }
    for (size_t i = 0; i < seeds->n && placed->order != NULL; i++)
        placed->order[i] = order != NULL ? order[i] : (uint32_t)i;
    vor_free(memory, order);
    return status;
}

static struct vor_apart in_unit(const struct vor_compare_apart *apart, double unit)
{
    return (struct vor_apart){apart->mean * unit, apart->rms * unit, apart->max * unit,
                              apart->points};
}

void vor_output_report_uniformity(struct vor_report *report, const struct vor_uniformity *even,
                                  double unit)
{
    report->delta = even->delta;
    report->sigma = even->sigma * unit;
    report->epsilon = even->epsilon;
    report->spacing_mean = even->mean * unit;
    report->min_over_mean = even->mean > 0 ? even->min / even->mean : 0;
    report->max_over_mean = even->mean > 0 ? even->max / even->mean : 0;
}

void vor_output_report_input(struct vor_report *report, const struct vor_domain *domain)
{
    const struct vor_conditioning *known = &domain->known;

    report->has_holes = known->holes.asked;
    report->holes_loops = known->holes.loops;
    report->holes_filled = known->holes.filled;
    report->holes_not_closed = known->holes.not_closed;
    report->holes_points = known->holes.points;
    report->holes_count = known->holes.told_count;
    memcpy(report->holes, known->holes.told, sizeof report->holes);
    report->outliers = known->outliers;
    report->parts = known->parts;
    report->islands = known->islands;
    report->in_islands = known->in_islands;
    for (int c = 0; c < 3; c++)
        report->lattice[c] = known->lattice.cell[c] * domain->unit;
    report->off_lattice = known->off_lattice;
    if (known->pitch[1] > 0)
        vor_warn(report->warnings, &report->warnings_count, VOR_WARNING_PITCHES,
                 known->pitch[1] * domain->unit, known->pitch[0] * domain->unit);
    if (known->hidden > 0)
        vor_warn(report->warnings, &report->warnings_count, VOR_WARNING_NOISE,
                 VOR_NOISE_PLACES - known->hidden, VOR_NOISE_PLACES - VOR_NOISE_HIDDEN);
}

static void report_stage(struct vor_report *report, const struct vor_outcome *told, unsigned stage)
{
    if (told->stages >> stage & 1)
        vor_report_stage(report, (enum vor_run_stage)stage, told->steps[stage],
                         told->seconds[stage]);
}

static void report_method(struct vor_report *report, const struct vor_placed *placed)
{
    const struct vor_outcome *told = placed->told;
    const struct vor_seeds *seeds = placed->seeds;
    double unit = seeds->domain->unit, area = told->area > 0 ? told->area : seeds->area;

    report->stopped = told->stopped;
    report->iterations = told->steps[VOR_RUN_STAGE_ITERATE] + told->steps[VOR_RUN_STAGE_PROJECT];
    report->polish_steps = told->steps[VOR_RUN_STAGE_POLISH];
    for (unsigned stage = 0; stage < VOR_RUN_STAGE_COUNT; stage++) {
        if (stage == VOR_RUN_STAGE_POLISH)
            continue;
        report_stage(report, told, stage);
        report->seconds_iterate += told->seconds[stage];
    }
    report_stage(report, told, VOR_RUN_STAGE_POLISH);
    report->seconds_polish += told->seconds[VOR_RUN_STAGE_POLISH];
    for (unsigned i = 0; i < told->warnings_count; i++)
        vor_warn(report->warnings, &report->warnings_count, told->warnings[i].says,
                 told->warnings[i].value, told->warnings[i].limit);
    report->held = told->held;
    report->held_ever = told->held_ever;
    report->fallback_plane = told->fallback_plane;
    report->fallback_left = told->fallback_left;
    report->area = area * unit * unit;
    report->has_descent = told->evaluations > 0;
    report->descent_steps = told->inner_steps;
    report->descent_evaluations = told->evaluations;
    report->descent_worst = told->worst_descent;
    report->descent_aspect = told->aspect;
}

static vor_status report_metric(struct vor_report *report, struct vor_seeds *seeds,
                                struct vor_error *err)
{
    const struct vor_tensors *tensors = &seeds->whole->tensors;
    struct vor_aspects aspects;
    vor_status status;

    if (!vor_stretched_are(&seeds->stretched))
        return VOR_OK;
    status = vor_seeds_aspects(&aspects, seeds, err);
    if (status != VOR_OK)
        return status;
    report->has_metric = 1;
    report->metric_median = tensors->median;
    report->metric_high = tensors->high;
    report->metric_cells = aspects.median;
    report->metric_off = aspects.off_median;
    report->metric_off_high = aspects.off_high;
    return VOR_OK;
}

/* Measures how even the points are: with a density or metric, delta, sigma and epsilon are of the
 * distances over the spacing wanted, in the metric; the other lengths of the distances themselves.
 */
static vor_status measure(struct vor_uniformity *even, struct vor_seeds *seeds,
                          struct vor_error *err)
{
    float *nearest = vor_malloc(seeds->run.memory, seeds->n, sizeof *nearest);
    int stretched = vor_stretched_are(&seeds->stretched);
    struct vor_uniformity apart;
    vor_status status;

    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    status = vor_seeds_uniformity_now(even, nearest, seeds, err);
    if (status == VOR_OK && stretched)
        status = vor_seeds_distances(nearest, seeds, err);
    if (status == VOR_OK && (stretched || seeds->wanted.value != NULL)) {
        vor_uniformity_from(&apart, nearest, seeds->n);
        even->mean = apart.mean;
        even->min = apart.min;
        even->max = apart.max;
    }
    vor_free(seeds->run.memory, nearest);
    return status;
}

/* Makes the cloud and the report, of seeds that stay where they are. */
static vor_status make(struct vor_cloud *out, struct vor_report *report,
                       const struct vor_placed *placed, struct vor_error *err)
{
    struct vor_seeds *seeds = placed->seeds;
    const struct vor_field *field = &seeds->whole->field;
    double unit = seeds->domain->unit;
    struct vor_uniformity even = {0}; /* clang-analyzer cannot see that VOR_E_NOMEM is not VOR_OK */
    struct vor_comparison found;
    struct vor_counts counts = {0};
    struct vor_cells cells;
    vor_status status = measure(&even, seeds, err);

    VOR_THEN(status, vor_seeds_cells(&cells, seeds, err));
    if (status == VOR_OK) {
        counts = vor_seeds_counts(seeds); /* without those of the comparison */
        status = vor_compare(&found, seeds, even.mean, placed->told->refined, err);
    }
    VOR_THEN(status, hand_out(out, report, placed, &even, err));
    VOR_THEN(status, report_metric(report, seeds, err));
    if (status != VOR_OK)
        return status;
    report->points_in = placed->in->n;
    report->points_out = out->n;
    vor_output_report_input(report, seeds->domain);
    if (vor_field_is(field)) {
        report->has_density = 1;
        report->density_span = field->span;
        report->density_least = field->least * field->even * unit;
        report->density_most = field->most * field->even * unit;
    }
    report_method(report, placed);
    vor_output_report_uniformity(report, &even, unit);
    report->six_share = cells.six;
    if (!vor_field_is(field) && !vor_stretched_are(&seeds->stretched)) {
        report->has_cells = 1;
        report->eta = cells.eta;
        report->gap = cells.gap;
        report->wide = cells.wide;
        report->open = cells.open;
    }
    report->ref_to_out = in_unit(&found.ref_to_out, unit);
    report->out_to_ref = in_unit(&found.out_to_ref, unit);
    report->has_mls_error = seeds->n >= VOR_MLS_ERROR_LEAST;
    if (report->has_mls_error) {
        report->mls_error_max = found.mls_error.max;
        report->mls_error_mean = found.mls_error.mean;
    }
    report->boundary_points = found.border;
    for (unsigned k = 0; k <= VOR_NEIGHBORS_MAX && report->fitted_count < VOR_FITTED_MAX; k++)
        if (found.fitted[k] > 0)
            report->fitted[report->fitted_count++] = (struct vor_fitted){k, found.fitted[k]};
    report->queries = counts.queries;
    if (counts.cells > 0) {
        report->bisectors_per_cell = (double)counts.bisectors / (double)counts.cells;
        report->triangles_per_cell = (double)counts.triangles / (double)counts.cells;
    }
    report->list_rebuilds = seeds->indexed_before + seeds->point_lists.indexed;
    return VOR_OK;
}

vor_status vor_output_make(struct vor_cloud *out, struct vor_report *report,
                           const struct vor_placed *placed, struct vor_error *err)
{
    int keeps = placed->spec->value[VOR_PARAM_LATTICE] == VOR_LATTICE_KEEP;
    struct vor_levels levels;
    vor_status status = VOR_OK;

    if (keeps)
        status = vor_levels_find(&levels, placed->in, placed->seeds->whole, err);
    if (keeps && status == VOR_OK)
        status = vor_snap_seeds(placed->seeds, &levels, err);
    VOR_THEN(status, make(out, report, placed, err));
    if (keeps && status == VOR_OK)
        vor_snap_cloud(out, &levels, placed->in);
    return status;
}
