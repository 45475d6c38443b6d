#include "core/cvt/descend.h"

#include "core/base/stat.h"
#include "core/cvt/frozen.h"
#include "core/opt/keep_best.h"
#include "core/opt/lbfgs.h"
#include "core/seeds/tell.h"
#include "core/seeds/uniformity.h"

#include <string.h>

/* Steps while planes stand still (Chen 2018, Sec. 4.3.3). */
enum { INNER = 5 };

/* Share of the iterations at each power below the last one. With patches of 1.2 (PATCH in planes.c,
 * with the inputs), at 0.1 / 0.25 / 0.4: psi4 of the tube 0.86 / 0.85 / 0.81, of the fillets 0.92 /
 * 0.94 / 0.92; its delta from the last power alone 0.11, so 0.09. */
#define STAGE 0.25

/* The iteration. */
struct descend {
    struct vor_seeds *seeds;
    const struct vor_spec *spec;
    const struct vor_run *run; /* a stop ends it */
    struct vor_outcome *told;
    uint32_t iterations, limit; /* done, and at most */
    unsigned power, last_power; /* of the last iteration, and of the last stage */
    struct vor_frozen frozen;
    struct vor_lbfgs lbfgs;
    struct vor_frozen_sums sums; /* of the last iteration */
    struct vor_keep_best last;   /* the last whole iterate */
    double *y;                   /* n x 2 */
    float *nearest;              /* scratch: distance of each seed to its nearest neighbour */
    unsigned char *held;
    double last_seconds; /* since the run began, at the last record */
};

static void free_descend(struct descend *descend)
{
    struct vor_memory *memory = descend->seeds->run.memory;

    vor_free(memory, descend->held);
    vor_free(memory, descend->nearest);
    vor_free(memory, descend->y);
    vor_keep_best_free(&descend->last);
    vor_lbfgs_free(&descend->lbfgs);
    vor_frozen_free(&descend->frozen);
}

static vor_status alloc_descend(struct descend *descend, struct vor_error *err)
{
    struct vor_memory *memory = descend->seeds->run.memory;
    size_t n = descend->seeds->n;
    vor_status status;

    descend->y = vor_calloc(memory, n, 2 * sizeof *descend->y);
    descend->nearest = vor_malloc(memory, n, sizeof *descend->nearest);
    descend->held = vor_calloc(memory, n, 1);
    if (descend->y == NULL || descend->nearest == NULL || descend->held == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the iteration of %zu points", n);
    status = vor_frozen_init(&descend->frozen, descend->seeds,
                             descend->spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP, err);
    if (status == VOR_OK)
        status = vor_lbfgs_init(&descend->lbfgs, 2 * n, INNER, memory, err);
    return status == VOR_OK ? vor_keep_best_init(&descend->last, n, memory, err) : status;
}

/* The power of the next iteration: doubled after each stage, until it is the last one. */
static unsigned next_power(const struct descend *descend)
{
    unsigned power = 2, stage = (unsigned)(STAGE * descend->limit);

    if (stage == 0)
        return descend->last_power;
    for (uint32_t done = descend->iterations; done >= stage && power < descend->last_power;
         done -= stage)
        power *= 2;
    return power < descend->last_power ? power : descend->last_power;
}

/* Puts the seeds onto the surface where they are, before the first iteration. A stop leaves some of
 * them where they started. */
static vor_status put_down(struct descend *descend, struct vor_error *err)
{
    vor_status status =
        vor_frozen_set(&descend->frozen, descend->power, descend->y, descend->run, err);

    return status == VOR_OK
               ? vor_frozen_take(&descend->frozen, descend->y, descend->held, &descend->sums, err)
               : status;
}

/* One iteration of all seeds. */
static vor_status iterate(struct descend *descend, struct vor_error *err)
{
    struct vor_frozen *frozen = &descend->frozen;
    struct vor_lbfgs_function function = {frozen, vor_frozen_at, vor_frozen_shorten, frozen->bend};
    struct vor_outcome *told = descend->told;
    struct vor_lbfgs_told inner;
    vor_status status;

    descend->power = next_power(descend);
    status = vor_frozen_set(frozen, descend->power, descend->y, descend->run, err);
    if (status == VOR_OK)
        status = vor_lbfgs_run(&descend->lbfgs, descend->y, &function, INNER, &inner, err);
    if (status == VOR_OK)
        status = vor_frozen_take(frozen, descend->y, descend->held, &descend->sums, err);
    if (status != VOR_OK)
        return status;
    told->inner_steps += inner.steps;
    told->evaluations += inner.evaluations;
    if (inner.before > 0)
        told->worst_descent = fmax(told->worst_descent, inner.after / inner.before);
    vor_sort_doubles(frozen->value, descend->seeds->n);
    told->aspect = frozen->value[descend->seeds->n / 2];
    descend->iterations++;
    return VOR_OK;
}

static struct vor_record record_of(const struct descend *descend, const struct vor_uniformity *even)
{
    double unit = descend->seeds->domain->unit, spacing = descend->frozen.planes.spacing * unit;

    return (struct vor_record){.stage = VOR_RUN_STAGE_ITERATE,
                               .step = descend->iterations,
                               .of = descend->limit,
                               .iteration = descend->iterations,
                               .delta = even->delta,
                               .sigma = even->sigma * unit,
                               .epsilon = even->epsilon,
                               .energy = descend->iterations > 0 ? descend->sums.energy * spacing *
                                                                       spacing * spacing * spacing
                                                                 : 0,
                               .max_move = descend->iterations > 0 ? descend->sums.moved * unit : 0,
                               .held = descend->sums.held,
                               .seconds = vor_run_seconds(descend->run)};
}

/* Measures the iterate, keeps it, and tells the watch. */
static vor_status record(struct descend *descend, enum vor_answer *answer, struct vor_error *err)
{
    struct vor_outcome *told = descend->told;
    double spacing = descend->frozen.planes.spacing;
    struct vor_uniformity even;
    struct vor_record record;
    vor_status status = vor_seeds_uniformity_now(&even, descend->nearest, descend->seeds, err);

    if (status != VOR_OK)
        return status;
    record = record_of(descend, &even);
    descend->last_seconds = record.seconds;
    vor_keep_best_restart(&descend->last, descend->seeds->xyz, &record);
    vor_keep_best_tell(&descend->last, &record);
    told->last = record;
    told->held = descend->sums.held;
    told->fallback_plane = descend->sums.plane;
    told->fallback_left = descend->sums.left;
    told->area = told->area_even = descend->sums.area * spacing * spacing;
    *answer = vor_seeds_tell(descend->seeds, descend->run, &record);
    return VOR_OK;
}

/* Whether a stop of the request is reached; the last iteration took `took` seconds. Those that say
 * that it is good enough do not count while p is still lower. */
static int finished(struct descend *descend, double took)
{
    const struct vor_record *at = &descend->told->last;
    struct vor_outcome *told = descend->told;
    double moved = descend->sums.moved / descend->frozen.planes.spacing;
    int last = descend->iterations > 0 && descend->power == descend->last_power;

    if (last && vor_stop_even_enough(descend->spec, at->delta))
        told->stopped = VOR_STOPPED_DELTA;
    else if (last && vor_stop_still(descend->spec, moved))
        told->stopped = VOR_STOPPED_MOVE;
    else if (descend->iterations >= descend->limit)
        told->stopped = VOR_STOPPED_ITERATIONS;
    else if (vor_stop_out_of_time(descend->spec, 1, descend->last_seconds, took))
        told->stopped = VOR_STOPPED_SECONDS;
    else
        return 0;
    return 1;
}

static vor_status loop(struct descend *descend, struct vor_error *err)
{
    enum vor_answer answer = VOR_CONTINUE;
    double took = 0, before;
    vor_status status = put_down(descend, err);
    int stopped = status == VOR_E_STOPPED;

    if (status == VOR_OK || stopped)
        status = record(descend, &answer, err);
    if (status == VOR_OK && stopped && answer == VOR_CONTINUE)
        answer = VOR_STOP;
    while (status == VOR_OK && answer == VOR_CONTINUE && !finished(descend, took)) {
        before = descend->last_seconds;
        status = iterate(descend, err);
        if (status == VOR_OK)
            status = record(descend, &answer, err);
        took = descend->last_seconds - before;
    }
    if (status == VOR_E_STOPPED)
        answer = VOR_STOP;
    else if (status != VOR_OK)
        return status;
    if (answer == VOR_CANCEL)
        return vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    if (answer == VOR_STOP)
        descend->told->stopped = VOR_STOPPED_CALLER;
    return VOR_OK;
}

vor_status vor_descend_run(struct vor_seeds *seeds, struct vor_outcome *told,
                           const struct vor_spec *spec, const struct vor_run *run,
                           struct vor_error *err)
{
    struct descend descend = {.seeds = seeds,
                              .spec = spec,
                              .run = run,
                              .told = told,
                              .limit = vor_spec_iterations(spec),
                              .power = 2,
                              .last_power = 2};
    double before = vor_run_clock(run);
    vor_status status;

    if (spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP)
        descend.last_power = (unsigned)spec->value[VOR_PARAM_P];
    status = alloc_descend(&descend, err);
    if (status == VOR_OK)
        status = loop(&descend, err);
    if (status == VOR_OK) {
        told->kept = vor_keep_best_recall(&descend.last, seeds->xyz);
        for (size_t i = 0; i < seeds->n; i++)
            told->held_ever += (descend.held[i] & VOR_FROZEN_HELD_EVER) != 0;
        vor_outcome_stage(told, VOR_RUN_STAGE_ITERATE, descend.iterations,
                          vor_run_clock(run) - before);
    }
    free_descend(&descend);
    return status;
}
