#include "core/seeds/tell.h"

#include <string.h>

enum vor_answer vor_seeds_tell(const struct vor_seeds *seeds, const struct vor_run *run,
                               const struct vor_record *record)
{
    const struct vor_watch *watch = run->watch;
    struct vor_moving moving = {.xyz = seeds->xyz, .n = seeds->n, .unit = seeds->domain->unit};

    if (watch == NULL || watch->progress == NULL)
        return VOR_CONTINUE;
    memcpy(moving.shift, seeds->domain->shift, sizeof moving.shift);
    if (watch->points != NULL)
        watch->points(watch->ctx, &moving, record);
    return watch->progress(watch->ctx, record);
}
