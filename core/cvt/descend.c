#include "core/cvt/descend.h"

#include "core/base/stat.h"
#include "core/cvt/frozen.h"
#include "core/opt/lbfgs.h"
#include "core/seeds/stage.h"

struct descend {
    struct vor_seeds *seeds;
    const struct vor_spec *spec;
    struct vor_stage stage;
    unsigned power, last_power; /* of the last iteration, and of the last stage */
    struct vor_frozen frozen;
    struct vor_lbfgs lbfgs;
    double *y; /* n x 2 */
    unsigned char *held;
};

static vor_status alloc_descend(struct descend *descend, struct vor_error *err)
{
    struct vor_memory *memory = descend->seeds->run.memory;
    size_t n = descend->seeds->n;
    vor_status status;

    descend->y = vor_calloc(memory, n, 2 * sizeof *descend->y);
    descend->held = vor_calloc(memory, n, 1);
    if (descend->y == NULL || descend->held == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_frozen_init(&descend->frozen, descend->seeds,
                             descend->spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP, err);
    return status == VOR_OK ? vor_lbfgs_init(&descend->lbfgs, 2 * n, memory, err) : status;
}

static void note(struct descend *descend, const struct vor_frozen_sums *sums)
{
    struct vor_stage *stage = &descend->stage;
    struct vor_outcome *told = stage->told;
    double spacing = descend->frozen.planes.spacing, unit = descend->seeds->domain->unit;
    double side = spacing * unit;

    stage->moved = sums->moved / spacing;
    stage->unfinished = descend->power < descend->last_power;
    stage->record.energy = sums->energy * side * side * side * side;
    stage->record.max_move = sums->moved * unit;
    stage->record.held = told->held = sums->held;
    told->fallback_plane = sums->plane;
    told->fallback_left = sums->left;
    told->area = told->area_even = sums->area * spacing * spacing;
}

/* Puts the seeds onto the surface where they are, before the first iteration. A stop leaves some of
 * them where they started, and ends the stage at its first step. */
static vor_status put_down(struct descend *descend, struct vor_error *err)
{
    struct vor_stage *stage = &descend->stage;
    struct vor_frozen_sums sums;
    vor_status status =
        vor_frozen_set(&descend->frozen, descend->power, descend->y, stage->run, err);

    VOR_THEN(status, vor_frozen_take(&descend->frozen, descend->y, descend->held, &sums, err));
    if (status != VOR_OK)
        return status == VOR_E_STOPPED ? VOR_OK : status;
    note(descend, &sums);
    stage->record.energy = stage->record.max_move = 0;
    stage->unfinished = 1;
    return VOR_OK;
}

/* One iteration of all seeds. Stops that say that it is good enough do not count while p is still
 * lower. */
static vor_status step(struct vor_stage *stage, struct vor_error *err)
{
    struct descend *descend = stage->of;
    struct vor_frozen *frozen = &descend->frozen;
    struct vor_lbfgs_function function = {frozen, vor_frozen_at, vor_frozen_shorten, frozen->bend};
    struct vor_outcome *told = stage->told;
    struct vor_lbfgs_told inner;
    struct vor_frozen_sums sums;
    unsigned share, powers = 1;
    vor_status status;

    for (unsigned power = 2; power < descend->last_power; power *= 2)
        powers++;
    /* Doubled after each share of the iterations, until it is the last one. With shares of 0.1 /
     * 0.25 / 0.4 before it and patches of 1.2 (PATCH in planes.c, with the inputs), psi4 of the
     * tube 0.86 / 0.85 / 0.81, of the fillets 0.92 / 0.94 / 0.92; delta of the tube from the last
     * power alone 0.11, so 0.09. */
    share = stage->record.of / powers;
    descend->power = share > 0 ? 2 : descend->last_power;
    for (uint32_t done = stage->record.step; done >= share && descend->power < descend->last_power;
         done -= share)
        descend->power *= 2;
    if (descend->power > descend->last_power)
        descend->power = descend->last_power;
    status = vor_frozen_set(frozen, descend->power, descend->y, stage->run, err);
    VOR_THEN(status,
             vor_lbfgs_run(&descend->lbfgs, descend->y, &function, VOR_LBFGS_STEPS, &inner, err));
    VOR_THEN(status, vor_frozen_take(frozen, descend->y, descend->held, &sums, err));
    if (status != VOR_OK)
        return status;
    told->inner_steps += inner.steps;
    told->evaluations += inner.evaluations;
    if (inner.before > 0)
        told->worst_descent = fmax(told->worst_descent, inner.after / inner.before);
    vor_sort_doubles(frozen->value, descend->seeds->n);
    told->aspect = frozen->value[descend->seeds->n / 2];
    note(descend, &sums);
    return VOR_OK;
}

vor_status vor_descend_run(struct vor_seeds *seeds, struct vor_outcome *told,
                           const struct vor_spec *spec, const struct vor_run *run,
                           struct vor_error *err)
{
    struct descend descend = {.seeds = seeds, .spec = spec, .power = 2, .last_power = 2};
    vor_status status;
    struct vor_memory *memory = descend.seeds->run.memory;

    descend.stage = (struct vor_stage){
        .spec = spec,
        .run = run,
        .told = told,
        .record = {.stage = VOR_RUN_STAGE_ITERATE, .of = vor_spec_iterations(spec)},
        .of = &descend,
        .step = step,
        .measure = vor_stage_measure,
        .measure_every = 1,
        .share = 1,
        .unfinished = 1,
        .keep_last = 1,
        .saves = 1};
    if (spec->value[VOR_PARAM_METRIC] == VOR_METRIC_LP)
        descend.last_power = (unsigned)spec->value[VOR_PARAM_P];
    status = alloc_descend(&descend, err);
    descend.stage.part[0] = (struct vor_part){descend.held, seeds->n};
    descend.stage.part[1] =
        (struct vor_part){descend.frozen.planes.crosses.kept, 3 * seeds->n * sizeof(float)};
    VOR_THEN(status, put_down(&descend, err));
    VOR_THEN(status, vor_stage_of_seeds(&descend.stage, seeds, err));
    VOR_THEN(status, vor_stage_run(&descend.stage, err));
    for (size_t i = 0; status == VOR_OK && i < seeds->n; i++)
        told->held_ever += (descend.held[i] & VOR_FROZEN_HELD_EVER) != 0;
    VOR_FREE_ALL(memory, descend.held, descend.y);
    vor_stage_free(&descend.stage);
    vor_lbfgs_free(&descend.lbfgs);
    vor_frozen_free(&descend.frozen);
    return status;
}
