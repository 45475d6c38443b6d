#include "core/baselines/baselines.h"

#include "core/base/rng.h"
#include "core/baselines/farthest.h"
#include "core/baselines/voxels.h"
#include "core/output/compare.h"
#include "core/output/last_record.h"
#include "core/seeds/uniformity.h"

#include <string.h>

/* Streams of random numbers, of these baselines' own. */
enum { STREAM_RANDOM = 31, STREAM_FIRST = 32 };

/* The points of a baseline, while it is made. */
struct points {
    const struct vor_baselines_of *of;
    const struct vor_run *run; /* silent: it tells no records */
    size_t wanted;             /* at most the points of the domain */
    float *xyz;                /* room for as many, and for those of a voxel grid */
    size_t made;
};

static uint64_t seed_of(const struct points *points)
{
    return (uint64_t)points->of->spec->value[VOR_PARAM_SEED];
}

/* The method itself, without the stops of the request. A clustering that the caller stopped is
 * none. */
static vor_status make_kmeans(struct points *points, struct vor_error *err)
{
    struct vor_domain even = *points->of->domain;
    struct vor_spec spec = *points->of->spec;
    struct vor_outcome told = {.stages = 0};
    struct vor_seeds seeds;
    vor_status status;

    memset(&even.field, 0, sizeof even.field);
    spec.value[VOR_PARAM_ITERATIONS] = VOR_UNSET;
    spec.value[VOR_PARAM_DELTA] = VOR_UNSET;
    spec.value[VOR_PARAM_SECONDS] = VOR_UNSET;
    status = points->of->kmeans->run(&seeds, &told, &even, points->wanted, &spec, points->run, err);
    if (status != VOR_OK)
        return status;
    points->made = seeds.n;
    memcpy(points->xyz, seeds.xyz, 3 * seeds.n * sizeof *seeds.xyz);
    vor_seeds_free(&seeds);
    if (told.stopped == VOR_STOPPED_CALLER)
        return vor_fail(err, VOR_E_STOPPED, "stopped by the caller");
    return VOR_OK;
}

/* A subset of the input: each point is taken with the probability that leaves as many as are still
 * wanted (Knuth, "The art of computer programming" 3.4.2, algorithm S). */
static vor_status make_random(struct points *points, struct vor_error *err)
{
    const struct vor_domain *domain = points->of->domain;

    (void)err;
    for (size_t i = 0; points->made < points->wanted; i++)
        if (vor_rng_below(seed_of(points), STREAM_RANDOM, i, domain->n - i) <
            points->wanted - points->made)
            memcpy(&points->xyz[3 * points->made++], &domain->xyz[3 * i], 3 * sizeof *points->xyz);
    return VOR_OK;
}

static vor_status make_voxel(struct points *points, struct vor_error *err)
{
    const struct vor_domain *domain = points->of->domain;

    return vor_voxel_points(points->xyz, &points->made, domain->xyz, domain->n, points->wanted,
                            points->run, err);
}

static vor_status make_farthest(struct points *points, struct vor_error *err)
{
    const struct vor_domain *domain = points->of->domain;
    size_t first = (size_t)vor_rng_below(seed_of(points), STREAM_FIRST, 0, domain->n);

    points->made = points->wanted;
    return vor_farthest_points(points->xyz, domain->xyz, domain->n, points->wanted, first,
                               points->run, err);
}

/* Measures seeds as a result is. */
static vor_status measure_seeds(struct vor_baseline *out, struct vor_seeds *seeds,
                                struct vor_error *err)
{
    struct vor_uniformity even = {0}, apart;
    struct vor_compare_apart far = {0};
    struct vor_cells cells = {0};
    double unit = seeds->domain->unit;
    float *nearest = vor_malloc(seeds->run.memory, seeds->n, sizeof *nearest);
    vor_status status;

    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    status = vor_seeds_uniformity_now(&even, nearest, seeds, err);
    VOR_THEN(status, vor_seeds_cells(&cells, seeds, err));
    VOR_THEN(status, vor_compare_ref_to_out(&far, NULL, seeds, err));
    if (status == VOR_OK) {
        vor_uniformity_from(&apart, nearest, seeds->n);
        out->points = seeds->n;
        out->delta = even.delta;
        out->sigma = even.sigma * unit;
        out->epsilon = even.epsilon;
        out->spacing = apart.mean * unit;
        out->six_share = cells.six;
        out->ref_to_out =
            (struct vor_apart){far.mean * unit, far.rms * unit, far.max * unit, far.points};
    }
    vor_free(seeds->run.memory, nearest);
    return status;
}

static vor_status measure(struct vor_baseline *out, const struct points *points,
                          struct vor_error *err)
{
    struct vor_seeds seeds;
    vor_status status = vor_seeds_init(&seeds, points->of->domain, points->made,
                                       vor_seeds_policy_of(points->of->spec), points->run, err);

    if (status != VOR_OK)
        return status;
    memcpy(seeds.xyz, points->xyz, 3 * seeds.n * sizeof *seeds.xyz);
    status = measure_seeds(out, &seeds, err);
    vor_seeds_free(&seeds);
    return status;
}

/* One row for each baseline: what makes it, and where the report has it. */
struct maker {
    vor_status (*make)(struct points *points, struct vor_error *err);
    size_t at;
};

static const struct maker makers[] = {
    {make_kmeans, offsetof(struct vor_report, kmeans)},
    {make_random, offsetof(struct vor_report, random)},
    {make_voxel, offsetof(struct vor_report, voxel)},
    {make_farthest, offsetof(struct vor_report, farthest)},
};

enum { MAKERS = sizeof makers / sizeof makers[0] };

/* Makes the points of a baseline and measures them. */
static vor_status tell_one(struct vor_report *report, const struct maker *maker,
                           const struct points *wanted, struct vor_error *err)
{
    struct vor_baseline *out = (struct vor_baseline *)(void *)((char *)report + maker->at);
    struct vor_memory *memory = wanted->run->memory;
    struct points points = *wanted;
    vor_status status;

    points.xyz = vor_malloc(memory, 2 * points.wanted + VOR_VOXELS_SLACK, 3 * sizeof *points.xyz);
    if (points.xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", points.wanted);
    status = maker->make(&points, err);
    VOR_THEN(status, measure(out, &points, err));
    vor_free(memory, points.xyz);
    return status;
}

/* Tells the watch that so many baselines are done: the record of the result, in this stage. */
static vor_status tell_step(const struct vor_report *report, const struct vor_baselines_of *of,
                            uint32_t done, const struct vor_run *run, struct vor_error *err)
{
    struct vor_record record = vor_last_record(of->told, report);

    record.stage = VOR_RUN_STAGE_BASELINES;
    record.step = done;
    record.of = MAKERS;
    record.ahead = 0;
    record.seconds = vor_run_seconds(run);
    return vor_run_answered(vor_run_tell(run, &record), err);
}

static vor_status tell_all(struct vor_report *report, const struct vor_baselines_of *of,
                           const struct points *points, const struct vor_run *run,
                           struct vor_error *err)
{
    double before = vor_run_clock(run);
    vor_status status = tell_step(report, of, 0, run, err);

    for (uint32_t i = 0; i < MAKERS && status == VOR_OK; i++) {
        status = tell_one(report, &makers[i], points, err);
        VOR_THEN(status, tell_step(report, of, i + 1, run, err));
    }
    if (status == VOR_OK)
        vor_report_stage(report, VOR_RUN_STAGE_BASELINES, MAKERS, vor_run_clock(run) - before);
    return status;
}

vor_status vor_baselines_tell(struct vor_report *report, const struct vor_baselines_of *of,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_watch watch = {.ctx = NULL};
    struct vor_run silent = *run;
    struct points points = {.of = of, .run = &silent, .wanted = of->n};
    vor_status status;

    silent.checkpoints = NULL;
    if (of->spec->value[VOR_PARAM_BASELINES] == 0 || of->n == 0)
        return VOR_OK;
    if (run->watch != NULL) {
        watch = *run->watch;
        watch.progress = NULL;
        silent.watch = &watch;
    }
    if (points.wanted > of->domain->n)
        points.wanted = of->domain->n;
    status = tell_all(report, of, &points, run, err);
    report->has_baselines = status == VOR_OK;
    return status == VOR_E_STOPPED ? VOR_OK : status;
}
