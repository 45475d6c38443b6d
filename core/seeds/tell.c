#include "core/seeds/tell.h"

#include <string.h>

enum vor_answer vor_points_tell(const struct vor_domain *domain, const float *xyz, size_t n,
                                const struct vor_run *run, const struct vor_record *record)
{
    const struct vor_watch *watch = run->watch;
    struct vor_moving moving = {.xyz = xyz, .n = n, .unit = domain->unit};

    if (watch == NULL || watch->progress == NULL)
        return VOR_CONTINUE;
    memcpy(moving.shift, domain->shift, sizeof moving.shift);
    if (watch->points != NULL)
        watch->points(watch->ctx, &moving, record);
    return watch->progress(watch->ctx, record);
}

enum vor_answer vor_seeds_tell(const struct vor_seeds *seeds, const struct vor_run *run,
                               const struct vor_record *record)
{
    return vor_points_tell(seeds->domain, seeds->xyz, seeds->n, run, record);
}
