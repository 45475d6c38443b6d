#include "core/mesh/join.h"

#include "core/mesh/carve.h"
#include "core/mesh/close.h"
#include "core/mesh/crowded.h"
#include "core/mesh/front.h"

/* Times that loops are closed after the front: pruning points of several fans opens some again. */
enum { ROUNDS = 3 };

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
        for (int round = 0; round < ROUNDS && status == VOR_OK; round++) {
            size_t before = complex->count;

            status = vor_run_call(run, close_loops, &joining, err);
            if (complex->count == before)
                break;
        }
    }
    VOR_THEN(status, vor_run_call(run, carve, &joining, err));
    VOR_THEN(status, vor_crowded_find(sheet, complex, &joining.balls, run, err));
    vor_overs_free(&joining.overs);
    vor_balls_free(&joining.balls);
    *filled += joining.closed;
    return status;
}
