#include "core/mesh/join.h"

#include "core/mesh/close.h"
#include "core/mesh/crowded.h"
#include "core/mesh/front.h"

/* Times that loops are closed after the front: pruning points of several fans opens some again. */
enum { ROUNDS = 3 };

struct joining {
    struct vor_complex *complex;
    struct vor_balls balls;
    const struct vor_run *run;
    size_t closed;     /* triangles that closed loops */
    vor_status status; /* of what ran on the pool's thread */
    struct vor_error *err;
};

static void close_loops(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end,
                        VOR_UNUSED unsigned worker)
{
    struct joining *joining = ctx;
    size_t closed = 0;

    joining->status =
        vor_close(joining->complex, &closed, &joining->balls, joining->run, joining->err);
    vor_complex_prune(joining->complex);
    joining->closed += closed;
}

static void advance(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end,
                    VOR_UNUSED unsigned worker)
{
    struct joining *joining = ctx;

    joining->status =
        vor_front_advance(joining->complex, &joining->balls, joining->run, joining->err);
    vor_complex_prune(joining->complex);
}

/* Runs a part that needs one thread on the pool. */
static vor_status on_one(struct joining *joining, vor_task task)
{
    vor_status status = vor_run_for(joining->run, 1, 1, task, joining, joining->err);

    return status == VOR_OK ? joining->status : status;
}

vor_status vor_join(struct vor_complex *complex, struct vor_sheet *sheet, int times,
                    uint64_t *filled, struct vor_error *err)
{
    const struct vor_run *run = &sheet->seeds->run;
    struct joining joining = {.complex = complex, .run = run, .err = err};
    vor_status status = vor_balls_make(&joining.balls, sheet, run, err);

    for (int front = 0; front < times && status == VOR_OK; front++) {
        status = on_one(&joining, advance);
        for (int round = 0; round < ROUNDS && status == VOR_OK; round++) {
            size_t before = complex->count;

            status = on_one(&joining, close_loops);
            if (complex->count == before)
                break;
        }
    }
    if (status == VOR_OK)
        status = vor_crowded_find(sheet, complex, &joining.balls, run, err);
    vor_balls_free(&joining.balls);
    *filled += joining.closed;
    return status;
}
