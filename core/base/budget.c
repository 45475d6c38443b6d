#include "core/base/budget.h"

#include <math.h>

/* Shares of the time allowed, and seconds, that a run may take beyond it before it does the fastest
 * way what it cannot leave out: placing first points, and keeping the last ones to the input. With
 * 1 s, 500 neighbors and one thread, 16,000 points on 1,000, and 20,000 on as many, take 1.1 / 1.5
 * / 2.1 s of CPU at shares of 0 / 0.5 / 1; they need 1.5 to 3 s for good first points. The seconds
 * are for requests of less than one, whose first points would be poor. */
#define LATE_SHARE 0.5
#define LATE_SECONDS 0.5

static enum vor_answer ask(void *ctx)
{
    struct vor_budget *budget = ctx;
    enum vor_answer answer = budget->inner->poll(budget->inner->ctx);

    if (answer != VOR_CONTINUE || !(budget->inner->clock(budget->inner->ctx) > budget->until))
        return answer;
    atomic_store(&budget->ended, 1);
    return VOR_STOP;
}

/* The loops ask for the time themselves after each step. */
static enum vor_answer tell(void *ctx, const struct vor_record *record)
{
    const struct vor_budget *budget = ctx;

    return budget->inner->progress(budget->inner->ctx, record);
}

static void show(void *ctx, const struct vor_moving *points, const struct vor_record *record)
{
    const struct vor_budget *budget = ctx;

    budget->inner->points(budget->inner->ctx, points, record);
}

static double read_clock(void *ctx)
{
    const struct vor_budget *budget = ctx;

    return budget->inner->clock(budget->inner->ctx);
}

void vor_budget_begin(struct vor_budget *budget, struct vor_run *run, double seconds)
{
    const struct vor_watch *inner = run->watch;

    if (inner == NULL || inner->clock == NULL || inner->poll == NULL)
        return;
    budget->inner = inner;
    budget->until = run->began + seconds;
    budget->watch = (struct vor_watch){.ctx = budget,
                                       .progress = inner->progress != NULL ? tell : NULL,
                                       .poll = ask,
                                       .points = inner->points != NULL ? show : NULL,
                                       .clock = read_clock};
    run->watch = &budget->watch;
    run->late = budget->until + fmax(LATE_SHARE * seconds, LATE_SECONDS);
}
