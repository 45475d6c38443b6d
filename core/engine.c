#include "core/engine.h"

#include "core/cvt/start.h"
#include "core/geom/patch.h"
#include "core/input/lattice.h"
#include "core/input/neighbors.h"
#include "core/input/outliers.h"
#include "core/input/sheets.h"
#include "core/method.h"
#include "core/metrics/distance.h"
#include "core/metrics/distortion.h"
#include "core/metrics/uniformity.h"
#include "core/output/compare.h"
#include "core/output/order.h"
#include "core/output/transfer.h"
#include "core/seeds/attach.h"
#include "core/seeds/repel.h"
#include "core/seeds/uniformity.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Where the input has at least twice THINNED points a seed, and twice THINNED_LEAST in all, the
 * seeds are iterated on as many of them: more of them tell no more of a cell. Where a fit takes
 * more than THINNED_FOR points there are as many times more, so that it reaches as far. */
enum { THINNED = 5, THINNED_FOR = 20, THINNED_LEAST = 20000 };

/* One run from the inside. */
struct engine {
    const struct vor_cloud *in;
    struct vor_run run, no_stop_run; /* no_stop: for what a stop must not cut short */
    struct vor_no_stop no_stop;
    struct vor_spec spec;           /* resolved */
    struct vor_domain domain, thin; /* thin: empty where all of the domain is iterated on */
    struct vor_neighbors neighbors;
    struct vor_seeds seeds;
    struct vor_cvt_result result;
    struct vor_report report;
    double start;
    size_t n;
    double area; /* that spacing was turned into points with, normalised */
};

/* Number of points from points, ratio or spacing. */
static vor_status resolve_target(struct engine *engine, struct vor_error *err)
{
    double n = vor_spec_target(&engine->spec, engine->in->n);
    vor_status status;

    if (vor_spec_given(&engine->spec, VOR_PARAM_SPACING)) {
        double spacing = engine->spec.value[VOR_PARAM_SPACING] / engine->domain.unit;

        status = vor_seeds_area(&engine->area, &engine->domain, &engine->neighbors, &engine->spec,
                                &engine->no_stop_run, err);
        if (status != VOR_OK)
            return status;
        n = rint(engine->area / (VOR_HEXAGON_HEIGHT * spacing * spacing));
    }
    status = vor_spec_check_target(&engine->spec, n, engine->in->n, err);
    if (status != VOR_OK)
        return status;
    engine->n = (size_t)n;
    engine->report.parameters = engine->spec;
    engine->report.parameters.value[VOR_PARAM_POINTS] = n;
    return VOR_OK;
}

static vor_status drop_outliers(struct engine *engine, struct vor_error *err)
{
    size_t dropped = 0;
    vor_status status;

    if (engine->spec.value[VOR_PARAM_OUTLIERS] != VOR_OUTLIERS_DROP)
        return VOR_OK;
    status = vor_outliers_drop(&engine->domain, &dropped, &engine->no_stop_run, err);
    engine->report.outliers = dropped;
    return status;
}

/* Where the input was rounded to a lattice that matters, its points go to where they may have been.
 */
static vor_status leave_lattice(struct engine *engine, struct vor_error *err)
{
    struct vor_lattice lattice;
    size_t moved = 0;
    vor_status status = vor_lattice_find(&lattice, &engine->domain, &engine->no_stop_run, err);

    if (status == VOR_OK && lattice.matters)
        status = vor_lattice_smooth(&engine->domain, &moved, &lattice, &engine->no_stop_run, err);
    for (int c = 0; status == VOR_OK && c < 3; c++)
        engine->report.lattice[c] = lattice.cell[c] * engine->domain.unit;
    engine->report.off_lattice = moved;
    return status;
}

/* Asks the input how many neighbours it wants, where the request does not say. */
static vor_status resolve_neighbors(struct engine *engine, struct vor_error *err)
{
    double *value = &engine->spec.value[VOR_PARAM_NEIGHBORS];
    vor_status status;

    if (*value != VOR_UNSET) {
        vor_neighbors_fix(&engine->neighbors, (unsigned)*value);
        return VOR_OK;
    }
    status = vor_neighbors_choose(&engine->neighbors, &engine->domain, &engine->no_stop_run, err);
    *value = engine->neighbors.usual;
    return status;
}

/* Puts the seeds onto a thinner domain where that is dense enough. */
static vor_status thin_domain(struct engine *engine, struct vor_error *err)
{
    double more = fmax(1, (double)engine->neighbors.most / THINNED_FOR);
    double wanted = fmax(THINNED * more * (double)engine->n, THINNED_LEAST);
    vor_status status;

    if ((double)engine->domain.n < 2 * wanted || !(engine->seeds.area > 0))
        return VOR_OK;
    status = vor_domain_thin(&engine->thin, &engine->domain, sqrt(engine->seeds.area / wanted),
                             &engine->no_stop_run, err);
    if (status == VOR_OK && engine->thin.n >= engine->seeds.input_lists.wide)
        vor_seeds_onto(&engine->seeds, &engine->thin);
    return status;
}

static vor_status prepare(struct engine *engine, struct vor_error *err)
{
    double before = engine->start, now;
    vor_status status;

    status = vor_domain_init(&engine->domain, engine->in, &engine->no_stop_run, err);
    if (status == VOR_OK)
        status = drop_outliers(engine, err);
    if (status == VOR_OK)
        status = leave_lattice(engine, err);
    if (status == VOR_OK)
        status = vor_sheets_find(&engine->domain, &engine->no_stop_run, err);
    if (status != VOR_OK)
        return status;
    now = vor_run_clock(&engine->run);
    engine->report.seconds_index = now - before;
    before = now;
    status = resolve_neighbors(engine, err);
    if (status == VOR_OK)
        status = resolve_target(engine, err);
    if (status == VOR_OK)
        status = vor_start_seeds(&engine->seeds, &engine->domain, engine->n, &engine->neighbors,
                                 &engine->spec, &engine->no_stop_run, err);
    if (status == VOR_OK)
        status = thin_domain(engine, err);
    engine->report.seconds_init = vor_run_clock(&engine->run) - before;
    return status;
}

static vor_status optimise(struct engine *engine, struct vor_error *err)
{
    const struct vor_method *method = vor_method((unsigned)engine->spec.value[VOR_PARAM_METHOD]);
    double before = vor_run_clock(&engine->run), now;
    vor_status status;

    engine->seeds.run = &engine->run;
    status = method->run(&engine->seeds, &engine->result, &engine->spec, engine->start, err);
    now = vor_run_clock(&engine->run);
    engine->report.seconds_iterate = now - before;
    engine->seeds.run = &engine->no_stop_run;
    if (status == VOR_OK)
        status = vor_attach(&engine->seeds, err);
    engine->seeds.run = &engine->run;
    if (status == VOR_OK)
        status = vor_repel(&engine->seeds, &engine->result, &engine->spec, engine->start, err);
    engine->seeds.run = &engine->no_stop_run;
    if (status == VOR_OK)
        status = vor_attach_to_whole(&engine->seeds, err);
    if (status == VOR_OK && engine->result.polish_steps > 0)
        status = vor_attach_last(&engine->seeds, err);
    engine->report.seconds_polish = vor_run_clock(&engine->run) - now;
    return status;
}

/* The cloud that is handed back, in the order asked for. */
static vor_status hand_back(struct engine *engine, struct vor_cloud *out,
                            const struct vor_uniformity *even, struct vor_error *err)
{
    const struct vor_seeds *seeds = &engine->seeds;
    double spacing = even->mean * engine->domain.unit;
    uint32_t *order = NULL;
    vor_status status = VOR_OK;

    if (engine->spec.value[VOR_PARAM_ORDER] == VOR_ORDER_PROGRESSIVE) {
        order = vor_malloc(engine->run.memory, engine->n, sizeof *order);
        if (order == NULL)
            return vor_fail(err, VOR_E_NOMEM, "order of %zu points", engine->n);
        status = vor_order_progressive(order, seeds->xyz, seeds->n, even->mean, seeds->run, err);
    }
    if (status == VOR_OK)
        status = vor_transfer(out, engine->in, &engine->seeds, spacing, &engine->spec, err);
    if (status == VOR_OK && order != NULL) {
        status = vor_cloud_reorder(out, order, err);
        if (status != VOR_OK)
            vor_cloud_free(out);
    }
    vor_free(engine->run.memory, order);
    return status;
}

static struct vor_apart in_unit(const struct vor_compare_apart *apart, double unit)
{
    return (struct vor_apart){apart->mean * unit, apart->rms * unit, apart->max * unit,
                              apart->points};
}

/* How many neighbours the surfaces were fitted to. */
static void count_fitted(struct vor_report *report, const struct vor_comparison *account)
{
    for (unsigned k = 0; k <= VOR_NEIGHBORS_MAX; k++)
        if (account->fitted[k] > 0) {
            assert(report->fitted_count < VOR_FITTED_MAX);
            report->fitted[report->fitted_count++] = (struct vor_fitted){k, account->fitted[k]};
        }
}

/* How far the result is from the input, and what lies at its border. */
static vor_status account_for(struct engine *engine, const struct vor_uniformity *even,
                              struct vor_error *err)
{
    struct vor_report *report = &engine->report;
    double unit = engine->domain.unit;
    struct vor_comparison account;
    vor_status status = vor_compare(&account, &engine->seeds, even->mean, err);

    if (status != VOR_OK)
        return status;
    report->in_to_out = in_unit(&account.in_to_out, unit);
    report->out_to_in = in_unit(&account.out_to_in, unit);
    report->boundary_points = account.border;
    count_fitted(report, &account);
    return VOR_OK;
}

/* The uniformity of what is handed back, and its numbers in the report. */
static vor_status finish(struct engine *engine, struct vor_cloud *out, struct vor_error *err)
{
    struct vor_report *report = &engine->report;
    double unit = engine->domain.unit;
    struct vor_uniformity even;
    struct vor_counts counts;
    float *nearest = vor_malloc(engine->run.memory, engine->n, sizeof *nearest);
    vor_status status;

    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "distances of %zu points", engine->n);
    status = vor_seeds_index(&engine->seeds, err);
    if (status == VOR_OK)
        status = vor_seeds_uniformity(&even, nearest, &engine->seeds, engine->seeds.xyz, err);
    if (status == VOR_OK)
        status = vor_seeds_six_share(&report->six_share, &engine->seeds, err);
    counts = vor_seeds_counts(&engine->seeds);
    if (status == VOR_OK)
        status = account_for(engine, &even, err);
    if (status == VOR_OK)
        status = hand_back(engine, out, &even, err);
    vor_free(engine->run.memory, nearest);
    if (status != VOR_OK)
        return status;
    report->points_in = engine->in->n;
    report->points_out = engine->n;
    report->delta = even.delta;
    report->sigma = even.sigma * unit;
    report->epsilon = even.epsilon;
    report->spacing_mean = even.mean * unit;
    report->iterations = engine->result.iterations;
    report->polish_steps = engine->result.polish_steps;
    vor_report_stage(report, VOR_RUN_STAGE_ITERATE, report->iterations, report->seconds_iterate);
    if (report->polish_steps > 0)
        vor_report_stage(report, VOR_RUN_STAGE_POLISH, report->polish_steps,
                         report->seconds_polish);
    report->stopped = engine->result.stopped;
    report->held = engine->result.held;
    report->held_ever = engine->result.held_ever;
    report->fallback_plane = engine->result.fallback_plane;
    report->fallback_left = engine->result.fallback_left;
    report->area =
        engine->result.iterations > 0 ? engine->result.area : engine->seeds.area * unit * unit;
    if (vor_spec_given(&engine->spec, VOR_PARAM_SPACING))
        report->area = engine->area * unit * unit;
    report->min_over_mean = even.mean > 0 ? even.min / even.mean : 0;
    report->max_over_mean = even.mean > 0 ? even.max / even.mean : 0;
    report->queries = counts.queries;
    report->list_rebuilds = engine->seeds.point_lists.indexed;
    if (counts.cells > 0) {
        report->bisectors_per_cell = (double)counts.bisectors / (double)counts.cells;
        report->triangles_per_cell = (double)counts.triangles / (double)counts.cells;
    }
    report->memory_peak_bytes = atomic_load(&engine->run.memory->peak);
    return VOR_OK;
}

vor_status vor_engine_run(struct vor_cloud *out, struct vor_report *report,
                          const struct vor_cloud *in, const struct vor_spec *spec,
                          const struct vor_run *run, struct vor_error *err)
{
    struct engine engine = {.in = in, .run = *run, .spec = *spec};
    vor_status status;

    engine.no_stop_run = *run;
    engine.no_stop_run.watch = vor_no_stop_watch(&engine.no_stop, run->watch);
    engine.start = vor_run_clock(run);
    status = prepare(&engine, err);
    if (status == VOR_OK)
        status = optimise(&engine, err);
    if (status == VOR_OK)
        status = finish(&engine, out, err);
    if (status == VOR_OK)
        *report = engine.report;
    vor_seeds_free(&engine.seeds);
    vor_domain_free(&engine.thin);
    vor_domain_free(&engine.domain);
    return status;
}

/* A frame that holds both clouds: middle of the first, power of two at least as large as both. */
struct frame {
    double middle[3], unit;
};

static void choose_frame(struct frame *frame, const struct vor_cloud *a, const struct vor_cloud *b)
{
    const struct vor_cloud *clouds[2] = {a, b != NULL ? b : a};
    double x[3], low[3], high[3], largest = 0;
    int exponent;

    vor_cloud_position(a, 0, low);
    memcpy(high, low, sizeof high);
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < clouds[k]->n; i++) {
            vor_cloud_position(clouds[k], i, x);
            for (int c = 0; c < 3; c++) {
                low[c] = fmin(low[c], x[c]);
                high[c] = fmax(high[c], x[c]);
            }
        }
    for (int c = 0; c < 3; c++) {
        frame->middle[c] = low[c] / 2 + high[c] / 2;
        largest = fmax(largest, high[c] / 2 - low[c] / 2);
    }
    (void)frexp(largest, &exponent);
    frame->unit = largest > 0 ? ldexp(1, exponent) : 1;
}

static float *into_frame(const struct vor_cloud *cloud, const struct frame *frame,
                         struct vor_memory *memory, struct vor_error *err)
{
    float *xyz = vor_malloc(memory, cloud->n, 3 * sizeof *xyz);
    double x[3];

    if (xyz == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "positions of %zu points", cloud->n);
        return NULL;
    }
    for (size_t i = 0; i < cloud->n; i++) {
        vor_cloud_position(cloud, i, x);
        for (size_t c = 0; c < 3; c++)
            xyz[3 * i + c] = (float)((x[c] - frame->middle[c]) / frame->unit);
    }
    return xyz;
}

static vor_status measure_even(struct vor_measure *out, const float *xyz, size_t n, double unit,
                               const struct vor_run *run, struct vor_error *err)
{
    float *nearest = vor_malloc(run->memory, n, sizeof *nearest);
    struct vor_uniformity even;
    struct vor_knn *knn = NULL;
    vor_status status;

    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "distances of %zu points", n);
    status = vor_knn_build(&knn, xyz, n, run->memory, err);
    if (status == VOR_OK)
        status = vor_nearest_distances(nearest, xyz, n, knn, run, err);
    if (status == VOR_OK) {
        vor_uniformity_from(&even, nearest, n);
        if (!(even.mean > 0))
            status = vor_fail(err, VOR_E_DEGENERATE, "%zu points, all in one place, want two", n);
    }
    if (status == VOR_OK)
        *out = (struct vor_measure){.n = n,
                                    .delta = even.delta,
                                    .sigma = even.sigma * unit,
                                    .epsilon = even.epsilon,
                                    .mean_nn = even.mean * unit,
                                    .min_over_mean = even.min / even.mean,
                                    .max_over_mean = even.max / even.mean,
                                    .coincident = even.coincident};
    vor_knn_free(knn);
    vor_free(run->memory, nearest);
    return status;
}

static void put_distances(struct vor_measure *measure, const struct vor_distances *distances)
{
    measure->has_reference = 1;
    measure->far_over_knn6_mean = distances->far_over_knn6_mean;
    measure->far_over_knn6_p999 = distances->far_over_knn6_p999;
    measure->out_to_ref_mean = distances->out_to_ref_mean;
    measure->out_to_ref_rms = distances->out_to_ref_rms;
    measure->out_to_ref_max = distances->out_to_ref_max;
    measure->ref_to_out_mean = distances->ref_to_out_mean;
    measure->ref_to_out_rms = distances->ref_to_out_rms;
    measure->ref_to_out_max = distances->ref_to_out_max;
    measure->hausdorff = distances->hausdorff;
    measure->chamfer = distances->chamfer;
}

static void put_distortion(struct vor_measure *measure, const struct vor_distortion *distortion,
                           double unit, double peak)
{
    measure->peak = peak > 0 ? peak : distortion->peak * unit;
    measure->d1_mse = distortion->d1_mse * unit * unit;
    measure->d2_mse = distortion->d2_mse * unit * unit;
    measure->d1_psnr = vor_distortion_psnr(distortion->d1_mse, measure->peak / unit);
    measure->d2_psnr = vor_distortion_psnr(distortion->d2_mse, measure->peak / unit);
}

/* Adds what there is to say of the distances between two clouds in a frame of that unit. */
static vor_status measure_against(struct vor_measure *measure,
                                  const struct vor_distortion_pair *pair, double unit, double peak,
                                  const struct vor_run *run, struct vor_error *err)
{
    struct vor_distances distances;
    struct vor_distortion distortion;
    vor_status status =
        vor_distances_measure(&distances, pair->xyz, pair->n, pair->reference, pair->m, run, err);

    if (status == VOR_OK)
        status = vor_distortion_measure(&distortion, pair, run, err);
    if (status != VOR_OK)
        return status;
    put_distances(measure, &distances);
    put_distortion(measure, &distortion, unit, peak);
    return VOR_OK;
}

vor_status vor_engine_measure(struct vor_measure *out, const struct vor_cloud *cloud,
                              const struct vor_cloud *reference, double peak,
                              const struct vor_run *run, struct vor_error *err)
{
    struct frame frame;
    struct vor_measure measure;
    float *xyz = NULL, *other = NULL;
    vor_status status;

    assert(peak == 0 || (peak >= VOR_PEAK_MIN && peak <= VOR_PEAK_MAX));
    choose_frame(&frame, cloud, reference);
    xyz = into_frame(cloud, &frame, run->memory, err);
    if (xyz == NULL)
        return VOR_E_NOMEM;
    status = measure_even(&measure, xyz, cloud->n, frame.unit, run, err);
    if (status == VOR_OK && reference != NULL) {
        other = into_frame(reference, &frame, run->memory, err);
        status = other != NULL ? VOR_OK : VOR_E_NOMEM;
    }
    if (status == VOR_OK && reference != NULL) {
        struct vor_distortion_pair pair = {xyz, other, cloud->n, reference->n,
                                           vor_cloud_find(reference, VOR_NORMAL)};

        status = measure_against(&measure, &pair, frame.unit, peak, run, err);
    }
    if (status == VOR_OK)
        *out = measure;
    vor_free(run->memory, other);
    vor_free(run->memory, xyz);
    return status;
}
