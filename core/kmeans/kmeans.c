#include "core/kmeans/kmeans.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/knn/knn.h"
#include "core/seeds/attach.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/stage.h"

#include <math.h>
#include <string.h>

/* Input points of one task: as many as a search takes at a time. */
enum { BLOCK = 256 };

/* Stream of random numbers, of this method's own. */
enum { STREAM_SUBSET = 1 };

/* Sum of the input points that were assigned to a seed. */
struct mean {
    double sum[3];
    size_t count;
};

struct kmeans {
    struct vor_seeds *seeds;
    uint32_t *nearest;   /* of each input point: number of its seed */
    struct mean *mean;   /* n */
    struct vor_knn *knn; /* of the seeds, while points are assigned */
};

static void assign_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct kmeans *kmeans = ctx;
    float distance2[BLOCK];

    vor_knn_search(kmeans->knn, &kmeans->seeds->domain->xyz[3 * begin], end - begin, 1,
                   &kmeans->nearest[begin], distance2);
}

/* Assigns each input point to the nearest seed. */
static vor_status assign(struct kmeans *kmeans, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_seeds *seeds = kmeans->seeds;
    size_t points = seeds->domain->n;
    vor_status status = vor_knn_build(&kmeans->knn, seeds->xyz, seeds->n, seeds->run.memory, err);

    if (status != VOR_OK)
        return status;
    status = vor_run_for(run, points, BLOCK, assign_block, kmeans, err);
    vor_knn_free(kmeans->knn);
    kmeans->knn = NULL;
    kmeans->seeds->scratch[0].queries += points;
    return status;
}

/* Moves each seed to the mean of its points, summed in their order; one without points stays.
 * Returns the longest move. */
static double move_to_means(struct kmeans *kmeans)
{
    struct vor_seeds *seeds = kmeans->seeds;
    const struct vor_domain *domain = seeds->domain;
    double longest2 = 0;

    memset(kmeans->mean, 0, seeds->n * sizeof *kmeans->mean);
    for (size_t i = 0; i < domain->n; i++) {
        struct mean *mean = &kmeans->mean[kmeans->nearest[i]];

        mean->count++;
        for (size_t c = 0; c < 3; c++)
            mean->sum[c] += (double)domain->xyz[3 * i + c];
    }
    for (size_t i = 0; i < seeds->n; i++) {
        const struct mean *mean = &kmeans->mean[i];
        float *x = &seeds->xyz[3 * i], before[3];

        memcpy(before, x, sizeof before);
        for (size_t c = 0; c < 3 && mean->count > 0; c++)
            x[c] = (float)(mean->sum[c] / (double)mean->count);
        longest2 = fmax(longest2, vor_distance2f(before, x));
    }
    return sqrt(longest2);
}

static vor_status step(struct vor_stage *stage, struct vor_error *err)
{
    struct kmeans *kmeans = stage->of;
    vor_status status = assign(kmeans, stage->run, err);

    if (status == VOR_OK)
        stage->record.max_move = move_to_means(kmeans) * stage->domain->unit;
    return status;
}

static void put_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct vor_seeds *seeds = ctx;
    double x[3];

    for (size_t i = begin; i < end; i++) {
        if (vor_seeds_fit(seeds, &seeds->scratch[worker], i) == VOR_SURFACE_NONE)
            continue;
        vor_seeds_position(seeds, i, x);
        vor_surface_put(&seeds->scratch[worker].here.surface, x);
        vor_to_floats(&seeds->xyz[3 * i], x);
    }
}

/* Moves the started seeds. */
static vor_status cluster(struct vor_seeds *seeds, struct vor_outcome *told,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct kmeans kmeans = {.seeds = seeds};
    double before = vor_run_clock(run);
    int keep_holes;
    struct vor_stage stage = {.spec = spec,
                              .run = run,
                              .told = told,
                              .record = {.stage = VOR_RUN_STAGE_ITERATE,
                                         .of = vor_spec_given(spec, VOR_PARAM_ITERATIONS)
                                                   ? (uint32_t)spec->value[VOR_PARAM_ITERATIONS]
                                                   : VOR_KMEANS_ITERATIONS},
                              .of = &kmeans,
                              .step = step,
                              .measure = vor_stage_measure,
                              .measure_every = 1,
                              .share = 1,
                              .saves = 1};
    vor_status status = VOR_OK;

    status = VOR_MAKE_ALL(memory, err, seeds->n, VOR_ARRAY(kmeans.nearest, seeds->domain->n, 1),
                          VOR_ARRAY(kmeans.mean, seeds->n, 1));
    VOR_THEN(status, vor_stage_of_seeds(&stage, seeds, err));
    VOR_THEN(status, vor_stage_run(&stage, err));
    VOR_THEN(status, vor_run_for(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, put_block, seeds, err));
    for (size_t i = 0; status == VOR_OK && i < seeds->n; i++) {
        enum vor_surface_kind kind = seeds->last_fit[i].surface.kind;

        told->fallback_left += kind == VOR_SURFACE_NONE;
        told->fallback_plane += kind == VOR_SURFACE_PLANE && !seeds->policy.planes;
    }
    VOR_THEN(status, vor_attach(seeds, &keep_holes, err));
    told->seconds[VOR_RUN_STAGE_ITERATE] = vor_run_clock(run) - before;
    VOR_FREE_ALL(memory, kmeans.mean, kmeans.nearest);
    vor_stage_free(&stage);
    return status;
}

vor_status vor_kmeans_run(struct vor_seeds *out, struct vor_outcome *told,
                          const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                          const struct vor_run *run, struct vor_error *err)
{
    struct vor_seeds seeds;
    double before = vor_run_clock(run);
    vor_status status;
    size_t taken = 0;

    if (vor_field_is(&domain->field))
        return vor_fail_param(
            err, VOR_E_DENSITY, "density",
            "method=kmeans does not support a density: use density=uniform or method=cvt");
    if (vor_tensors_are(&domain->tensors))
        return vor_fail_param(
            err, VOR_E_METRIC, "metric",
            "method=kmeans does not support a metric: use metric=isotropic or method=cvt");
    if (spec->value[VOR_PARAM_BOUNDARY] == VOR_BOUNDARY_SITES)
        return vor_fail_param(err, VOR_E_PARAM, "boundary",
                              "method=kmeans does not support boundary=sites: use keep, free "
                              "or fill, or method=cvt");
    if (spec->value[VOR_PARAM_EDGES] == VOR_EDGES_SITES)
        return vor_fail_param(
            err, VOR_E_PARAM, "edges",
            "method=kmeans does not support edges=sites: use edges=ignore or method=cvt");
    if (n > domain->n)
        return vor_fail_param(err, VOR_E_TARGET, "points",
                              "%zu points are requested, want 1 to %zu: method=kmeans cannot "
                              "give more points than the input has distinct positions",
                              n, domain->n);
    if (vor_checkpoint_is(run)) {
        status = vor_checkpoint_seeds(&seeds, told, domain, run, err);
        taken = n;
    } else {
        status = vor_seeds_init(&seeds, domain, n, vor_seeds_policy_of(spec), run, err);
    }
    if (status != VOR_OK)
        return status;
    /* A random subset: each point is taken with the probability that leaves as many as are still
     * wanted (Knuth, "The art of computer programming" 3.4.2, algorithm S). */
    for (size_t i = 0; taken < seeds.n; i++)
        if (vor_rng_below((uint64_t)spec->value[VOR_PARAM_SEED], STREAM_SUBSET, i,
                          seeds.domain->n - i) < seeds.n - taken)
            memcpy(&seeds.xyz[3 * taken++], &seeds.domain->xyz[3 * i], 3 * sizeof *seeds.xyz);
    told->seconds_start = vor_run_clock(run) - before;
    status = cluster(&seeds, told, spec, run, err);
    if (status == VOR_OK)
        *out = seeds;
    else
        vor_seeds_free(&seeds);
    return status;
}
