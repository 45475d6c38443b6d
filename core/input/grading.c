#include "core/input/grading.h"

#include "core/base/heap.h"
#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

/* Points between two looks at whether to go on: a millisecond. */
enum { POLL_EVERY = 4096 };

vor_status vor_grading_init(struct vor_grading *out, const struct vor_graph *graph,
                            const float *xyz, struct vor_error *err)
{
    struct vor_grading grading = {.memory = graph->memory, .xyz = xyz, .n = graph->n};

    grading.first = vor_calloc(grading.memory, grading.n + 1, sizeof *grading.first);
    grading.queue = vor_malloc(grading.memory, grading.n, 2 * sizeof *grading.queue);
    if (grading.first != NULL && grading.queue != NULL) {
        /* Counts the lists that each point is in in first[j + 1], and makes them the places where
         * those of each begin. */
        for (size_t i = 0; i < graph->n; i++)
            for (unsigned a = 0; a < graph->count[i]; a++)
                grading.first[graph->list[i * graph->most + a] + 1]++;
        for (size_t j = 0; j < graph->n; j++)
            grading.first[j + 1] += grading.first[j];
        grading.to = vor_malloc(grading.memory, grading.first[grading.n] + 1, sizeof *grading.to);
    }
    if (grading.to == NULL) {
        vor_grading_free(&grading);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", graph->n);
    }
    /* Writes whose lists they are; queue[j] is how many of point j are written. */
    memset(grading.queue, 0, graph->n * sizeof *grading.queue);
    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; a < graph->count[i]; a++) {
            uint32_t j = graph->list[i * graph->most + a];

            grading.to[grading.first[j] + grading.queue[j]++] = (uint32_t)i;
        }
    *out = grading;
    return VOR_OK;
}

void vor_grading_free(struct vor_grading *grading)
{
    VOR_FREE_ALL(grading->memory, grading->to, grading->queue, grading->first);
    memset(grading, 0, sizeof *grading);
}

/* Values being lowered. */
struct lower {
    const struct vor_grading *grading;
    float *value;
    double steepest;
    struct vor_heap heap; /* points that were lowered and have not lowered others since */
    size_t next;          /* point that lowers others first; n: each did */
};

/* Lowers the values that exceed that of point j by more than they may. */
static void lower_from(struct lower *lower, uint32_t j)
{
    const struct vor_grading *grading = lower->grading;
    const float *xyz = grading->xyz;
    float value = lower->value[j];

    for (size_t e = grading->first[j]; e < grading->first[j + 1]; e++) {
        uint32_t i = grading->to[e];
        float most;

        if (!(value < lower->value[i]))
            continue;
        most = (float)((double)value + lower->steepest * sqrt(vor_distance2f(&xyz[3 * (size_t)i],
                                                                             &xyz[3 * (size_t)j])));
        if (!(most < lower->value[i]))
            continue;
        lower->value[i] = most;
        vor_heap_move(&lower->heap, i);
    }
}

/* Every point once, then those that were lowered, the least value first: what a point has then is
 * not lowered any more. */
static void lower_some(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct lower *lower = ctx;

    for (int step = 0; step < POLL_EVERY; step++)
        if (lower->next < lower->grading->n)
            lower_from(lower, (uint32_t)lower->next++);
        else if (lower->heap.count > 0)
            lower_from(lower, vor_heap_take(&lower->heap));
}

vor_status vor_grading_apply(const struct vor_grading *grading, float *value, double steepest,
                             const struct vor_run *run, struct vor_error *err)
{
    size_t n = grading->n;
    struct lower lower = {
        .grading = grading,
        .value = value,
        .steepest = steepest,
        .heap = {.key = value, .item = grading->queue, .place = &grading->queue[n]}};
    vor_status status = VOR_OK;

    for (size_t i = 0; i < n; i++)
        lower.heap.place[i] = VOR_HEAP_WAITS;
    while (status == VOR_OK && (lower.next < n || lower.heap.count > 0))
        status = vor_run_rows(run, 1, 1, lower_some, &lower, err);
    return status;
}
