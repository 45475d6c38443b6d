#include "core/mesh/join.h"

#include "core/mesh/carve.h"
#include "core/mesh/close.h"
#include "core/mesh/crowded.h"
#include "core/mesh/front.h"

struct joining {
    struct vor_complex *complex;
    struct vor_balls balls;
    struct vor_overs overs;
    const struct vor_run *run;
    size_t closed; /* triangles that closed loops */
};

static vor_status close_loops(void *ctx, struct vor_error *err)
{
    struct joining *joining = ctx;
    size_t closed = 0;
    vor_status status = vor_close(joining->complex, &closed, &joining->balls, joining->run, err);

    vor_complex_prune(joining->complex);
    joining->closed += closed;
    return status;
}

static vor_status carve(void *ctx, struct vor_error *err)
{
    struct joining *joining = ctx;

    return vor_carve(joining->complex, &joining->closed, &joining->balls, joining->run, err);
}

static vor_status advance(void *ctx, struct vor_error *err)
{
    struct joining *joining = ctx;
    vor_status status = vor_front_advance(joining->complex, &joining->overs, joining->run, err);

    vor_complex_prune(joining->complex);
    return status;
}

vor_status vor_join(struct vor_complex *complex, struct vor_sheet *sheet, int times,
                    uint64_t *filled, struct vor_error *err)
{
    const struct vor_run *run = &sheet->seeds->run;
    struct joining joining = {.complex = complex, .run = run};
    vor_status status = vor_balls_make(&joining.balls, sheet, run, err);

    joining.overs.balls = &joining.balls;
    for (int front = 0; front < times && status == VOR_OK; front++) {
        status = vor_run_call(run, advance, &joining, err);
        /* Pruning points of several fans opens some again. */
        for (size_t before = 0; complex->count > before && status == VOR_OK;) {
            before = complex->count;
            status = vor_run_call(run, close_loops, &joining, err);
        }
    }
    VOR_THEN(status, vor_run_call(run, carve, &joining, err));
    VOR_THEN(status, vor_crowded_find(sheet, complex, &joining.balls, run, err));
    vor_overs_free(&joining.overs);
    vor_balls_free(&joining.balls);
    *filled += joining.closed;
    return status;
}
