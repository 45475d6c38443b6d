#include "core/method/settle.h"

#include "core/geom/boundary.h"

static void settle_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct vor_seeds *seeds = ctx;
    struct vor_bench *bench = &seeds->bench[worker];
    struct vor_border border;

    for (size_t i = begin; i < end; i++) {
        double x[3];

        vor_seeds_position(seeds, i, x);
        if (vor_seeds_fit_at(seeds, bench, &bench->there, x) == VOR_SURFACE_NONE)
            continue;
        vor_seeds_border(seeds, bench, &border, x);
        if (vor_boundary_restrict(&border, VOR_BORDER_SETTLED, x))
            for (size_t c = 0; c < 3; c++)
                seeds->xyz[3 * i + c] = (float)x[c];
    }
}

vor_status vor_settle(struct vor_seeds *seeds, struct vor_error *err)
{
    if (!seeds->keep_border)
        return VOR_OK;
    return vor_run_for(seeds->run, seeds->n, VOR_SEEDS_BLOCK, settle_block, seeds, err);
}
