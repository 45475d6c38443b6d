#include "core/method.h"
#include "tests/support/toy/steps.h"

#include <string.h>

static vor_status copy_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    struct vor_seeds *seeds = ctx;
    const struct vor_domain *domain = seeds->domain;

    (void)err;
    for (size_t i = begin; i < end; i++) {
        size_t from = (size_t)((double)i * (double)domain->n / (double)seeds->n);

        memcpy(&seeds->xyz[3 * i], &domain->xyz[3 * from], 3 * sizeof *seeds->xyz);
    }
    return VOR_OK;
}

static vor_status prove_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    const struct vor_seeds *seeds = ctx;

    for (size_t i = begin; i < end; i++) {
        uint32_t index;
        float distance2;

        vor_knn_search(seeds->domain->knn, &seeds->xyz[3 * i], 1, 1, &index, &distance2);
        if (distance2 > 0)
            return vor_fail(err, VOR_E_INTERNAL, "copy %zu is no point of the input", i);
    }
    return VOR_OK;
}

/* Goes through one stage of the method and notes it. */
static vor_status place(struct vor_seeds *seeds, struct vor_outcome *told, struct toy_steps *steps,
                        toy_task task, struct vor_error *err)
{
    double began = vor_run_clock(steps->run);
    vor_status status = toy_go_through(steps, seeds->n, task, seeds, err);

    vor_outcome_stage(told, steps->record.stage, steps->record.step,
                      vor_run_clock(steps->run) - began);
    told->last = steps->record;
    if (status != VOR_E_STOPPED)
        return status;
    told->stopped = VOR_STOPPED_CALLER;
    return VOR_OK;
}

/* What a stop left out. */
static vor_status copy_rest(struct vor_seeds *seeds, const struct toy_steps *steps,
                            struct vor_error *err)
{
    return copy_part(seeds, toy_part(steps, seeds->n, steps->record.step), seeds->n, err);
}

static vor_status copy_and_prove(struct vor_seeds *seeds, struct vor_outcome *told,
                                 struct toy_steps *steps, struct vor_error *err)
{
    vor_status status = toy_enter(steps, VOR_RUN_STAGE_COPY, 1, err);

    told->stopped = VOR_STOPPED_COPIED;
    if (status == VOR_OK)
        status = place(seeds, told, steps, copy_part, err);
    if (status == VOR_E_STOPPED || told->stopped == VOR_STOPPED_CALLER) {
        told->stopped = VOR_STOPPED_CALLER;
        return copy_rest(seeds, steps, err);
    }
    if (status == VOR_OK)
        status = toy_enter(steps, VOR_RUN_STAGE_PROVE, 0, err);
    if (status == VOR_OK)
        return place(seeds, told, steps, prove_part, err);
    if (status != VOR_E_STOPPED)
        return status;
    told->stopped = VOR_STOPPED_CALLER;
    return VOR_OK;
}

vor_status vor_toy_run(struct vor_seeds *out, struct vor_outcome *told,
                       const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                       const struct vor_run *run, struct vor_error *err)
{
    struct toy_steps steps = toy_steps_of(spec, run);
    struct vor_seeds seeds;
    vor_status status;

    if (n > domain->n)
        return vor_fail_param(err, VOR_E_TARGET, "points",
                              "%zu points are asked for, want 1 to %zu: toy copies points of the "
                              "input, and only those at different places",
                              n, domain->n);
    status = vor_seeds_init(&seeds, domain, n, vor_seeds_policy_of(spec), run, err);
    if (status != VOR_OK)
        return status;
    status = copy_and_prove(&seeds, told, &steps, err);
    if (status != VOR_OK) {
        vor_seeds_free(&seeds);
        return status;
    }
    *out = seeds;
    return VOR_OK;
}
