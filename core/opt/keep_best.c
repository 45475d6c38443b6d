#include "core/opt/keep_best.h"

#include <math.h>
#include <string.h>

vor_status vor_keep_best_init(struct vor_keep_best *out, size_t n, struct vor_memory *memory,
                              struct vor_error *err)
{
    *out = (struct vor_keep_best){.memory = memory, .n = n, .at = {.delta = INFINITY}};
    out->xyz = vor_malloc(memory, n, 3 * sizeof *out->xyz);
    if (out->xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the most even of %zu points", n);
    return VOR_OK;
}

void vor_keep_best_free(struct vor_keep_best *best)
{
    if (best->memory == NULL)
        return;
    vor_free(best->memory, best->xyz);
    memset(best, 0, sizeof *best);
}

void vor_keep_best_offer(struct vor_keep_best *best, const float *xyz, const struct vor_record *at)
{
    if (at->delta < best->at.delta)
        vor_keep_best_restart(best, xyz, at);
}

void vor_keep_best_restart(struct vor_keep_best *best, const float *xyz,
                           const struct vor_record *at)
{
    best->at = *at;
    memcpy(best->xyz, xyz, 3 * best->n * sizeof *xyz);
}

struct vor_record vor_keep_best_recall(const struct vor_keep_best *best, float *xyz)
{
    memcpy(xyz, best->xyz, 3 * best->n * sizeof *xyz);
    return best->at;
}

void vor_keep_best_tell(const struct vor_keep_best *best, struct vor_record *record)
{
    record->best_iteration = best->at.iteration;
    record->best_polish = best->at.polish;
    record->best_delta = best->at.delta;
    record->best_sigma = best->at.sigma;
    record->best_epsilon = best->at.epsilon;
}

int vor_stop_even_enough(const struct vor_spec *spec, double delta)
{
    return vor_spec_given(spec, VOR_PARAM_DELTA) && delta <= spec->value[VOR_PARAM_DELTA];
}

int vor_stop_still(const struct vor_spec *spec, double move)
{
    return vor_spec_given(spec, VOR_PARAM_MOVE_STOP) && move <= spec->value[VOR_PARAM_MOVE_STOP];
}

int vor_stop_out_of_time(const struct vor_spec *spec, double share, double seconds, double took)
{
    return vor_spec_given(spec, VOR_PARAM_SECONDS) &&
           seconds + took > share * spec->value[VOR_PARAM_SECONDS];
}
