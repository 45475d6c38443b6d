#include "core/engine.h"

#include "core/cvt/cvt.h"
#include "core/geom/patch.h"
#include "core/input/input.h"
#include "core/metrics/distance.h"
#include "core/metrics/distortion.h"
#include "core/metrics/uniformity.h"
#include "core/output/output.h"
#include "core/seeds/area.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* The methods, in the order of the words of parameter `method`. */
static const struct vor_method methods[] = {{"cvt", vor_cvt_run}};

static const struct vor_method *method_of(const struct vor_spec *spec)
{
    unsigned index = (unsigned)spec->value[VOR_PARAM_METHOD];

    assert(index < sizeof methods / sizeof methods[0]);
    return &methods[index];
}

/* One run from the inside. */
struct engine {
    const struct vor_cloud *in;
    struct vor_spec spec;
    struct vor_run run, whole; /* whole: for what a stop must not cut short */
    struct vor_no_stop no_stop;
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_outcome told;
    struct vor_report report;
    double area; /* that spacing was turned into points with, normalised; else 0 */
};

static void begin(struct engine *engine, const struct vor_run *run)
{
    engine->run = *run;
    engine->run.began = vor_run_clock(run);
    engine->run.no_stop = vor_no_stop_watch(&engine->no_stop, run->watch);
    engine->whole = vor_run_unstoppable(&engine->run);
}

/* How many points the request comes to. */
static vor_status resolve_target(struct engine *engine, size_t *n, struct vor_error *err)
{
    const struct vor_spec *spec = &engine->spec;
    double target = vor_spec_target(spec, engine->in->n);
    vor_status status;

    if (vor_spec_given(spec, VOR_PARAM_SPACING)) {
        double spacing = spec->value[VOR_PARAM_SPACING] / engine->domain.unit;

        status = vor_area_of_surface(&engine->area, &engine->domain,
                                     (uint64_t)spec->value[VOR_PARAM_SEED], &engine->whole, err);
        if (status != VOR_OK)
            return status;
        target = rint(engine->area / (VOR_HEXAGON_HEIGHT * spacing * spacing));
    }
    status = vor_spec_check_target(spec, target, engine->in->n, err);
    if (status == VOR_OK)
        *n = (size_t)target;
    return status;
}

static vor_status prepare(struct engine *engine, size_t *n, struct vor_error *err)
{
    vor_status status =
        vor_input_prepare(&engine->domain, engine->in, &engine->spec, &engine->whole, err);

    if (status != VOR_OK)
        return status;
    engine->report.seconds_index = vor_run_seconds(&engine->run);
    status = resolve_target(engine, n, err);
    engine->report.seconds_init = vor_run_seconds(&engine->run) - engine->report.seconds_index;
    return status;
}

static vor_status place(struct engine *engine, size_t n, struct vor_error *err)
{
    const struct vor_method *method = method_of(&engine->spec);
    vor_status status = method->run(&engine->seeds, &engine->told, &engine->domain, n,
                                    &engine->spec, &engine->run, err);

    engine->report.seconds_init += engine->told.seconds_start;
    engine->report.seconds_iterate = engine->told.seconds[VOR_RUN_STAGE_ITERATE];
    engine->report.seconds_polish = engine->told.seconds[VOR_RUN_STAGE_POLISH];
    return status;
}

static vor_status finish(struct engine *engine, struct vor_cloud *out, struct vor_error *err)
{
    struct vor_placed placed = {engine->in, &engine->seeds, &engine->told, &engine->spec};
    struct vor_report *report = &engine->report;
    double unit = engine->domain.unit;
    vor_status status = vor_output_make(out, report, &placed, err);

    if (status != VOR_OK)
        return status;
    report->parameters = engine->spec;
    report->parameters.value[VOR_PARAM_POINTS] = (double)engine->seeds.n;
    report->parameters.value[VOR_PARAM_NEIGHBORS] = engine->domain.known.neighbors.usual;
    if (engine->area > 0)
        report->area = engine->area * unit * unit;
    report->memory_peak_bytes = atomic_load(&engine->run.memory->peak);
    return VOR_OK;
}

vor_status vor_engine_run(struct vor_cloud *out, struct vor_report *report,
                          const struct vor_cloud *in, const struct vor_spec *spec,
                          const struct vor_run *run, struct vor_error *err)
{
    struct engine engine = {.in = in, .spec = *spec};
    vor_status status;
    size_t n = 0;

    begin(&engine, run);
    status = prepare(&engine, &n, err);
    if (status == VOR_OK)
        status = place(&engine, n, err);
    if (status == VOR_OK)
        status = finish(&engine, out, err);
    if (status == VOR_OK)
        *report = engine.report;
    vor_seeds_free(&engine.seeds);
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
