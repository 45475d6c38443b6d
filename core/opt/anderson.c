#include "core/opt/anderson.h"

#include "core/base/linalg.h"

#include <assert.h>
#include <string.h>

/* Floats of one task and of one partial sum. */
enum { BLOCK = 12288 };

struct push {
    struct vor_anderson *anderson;
    const float *y, *g;
};

vor_status vor_anderson_init(struct vor_anderson *out, size_t length, unsigned window,
                             struct vor_memory *memory, struct vor_error *err)
{
    size_t blocks = (length + BLOCK - 1) / BLOCK;
    int ok = 1;

    assert(window >= 1 && window <= VOR_ANDERSON_MAX);
    memset(out, 0, sizeof *out);
    out->memory = memory;
    out->length = length;
    out->window = window;
    for (unsigned i = 0; i <= window; i++) {
        out->image[i] = vor_malloc(memory, length, sizeof *out->image[i]);
        out->residual[i] = vor_malloc(memory, length, sizeof *out->residual[i]);
        ok &= out->image[i] != NULL && out->residual[i] != NULL;
    }
    out->partial = vor_malloc(memory, blocks, (window + 1) * sizeof *out->partial);
    if (ok && out->partial != NULL)
        return VOR_OK;
    vor_anderson_free(out);
    return vor_fail(err, VOR_E_NOMEM, "%zu numbers", length);
}

void vor_anderson_free(struct vor_anderson *anderson)
{
    for (unsigned i = 0; i <= VOR_ANDERSON_MAX; i++) {
        VOR_FREE_ALL(anderson->memory, anderson->image[i], anderson->residual[i]);
    }
    vor_free(anderson->memory, anderson->partial);
    memset(anderson, 0, sizeof *anderson);
}

/* Stores one block of the new pair, and its dot products with every residual stored. */
static void push_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct push *push = ctx;
    struct vor_anderson *anderson = push->anderson;
    float *image = anderson->image[anderson->newest];
    float *residual = anderson->residual[anderson->newest];
    double *sums = &anderson->partial[begin / BLOCK * (anderson->window + 1)];

    for (size_t i = begin; i < end; i++) {
        image[i] = push->g[i];
        residual[i] = push->g[i] - push->y[i];
    }
    for (unsigned j = 0; j < anderson->depth; j++) {
        const float *other = anderson->residual[j];
        double sum = 0;

        for (size_t i = begin; i < end; i++)
            sum += (double)residual[i] * (double)other[i];
        sums[j] = sum;
    }
}

/* Solves gram weights = 1 and scales the weights to a sum of 1; without a solution the last pair
 * has all the weight. */
static void solve(struct vor_anderson *anderson)
{
    double a[(VOR_ANDERSON_MAX + 1) * (VOR_ANDERSON_MAX + 1)], trace = 0, sum = 0;
    double *weight = anderson->weight;
    int n = (int)anderson->depth;

    for (int i = 0; i < n; i++)
        trace += anderson->gram[i][i];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++)
            a[i * n + j] = anderson->gram[i][j] + (i == j ? VOR_ROUNDED2 * trace : 0);
        weight[i] = 1;
    }
    if (trace > 0 && vor_solve_spd(a, weight, n, 0) > 0)
        for (int i = 0; i < n; i++)
            sum += weight[i];
    for (int i = 0; i < n; i++)
        weight[i] = sum > 0 ? weight[i] / sum : i == (int)anderson->newest;
}

vor_status vor_anderson_push(struct vor_anderson *anderson, const float *y, const float *g,
                             const struct vor_run *run, struct vor_error *err)
{
    struct push push = {anderson, y, g};
    size_t blocks = (anderson->length + BLOCK - 1) / BLOCK;
    vor_status status;

    if (anderson->depth <= anderson->window)
        anderson->newest = anderson->depth++;
    else
        anderson->newest = (anderson->newest + 1) % (anderson->window + 1);
    status = vor_run_for(run, anderson->length, BLOCK, push_block, &push, err);
    if (status != VOR_OK)
        return status;
    for (unsigned j = 0; j < anderson->depth; j++) {
        double sum = 0;

        for (size_t b = 0; b < blocks; b++)
            sum += anderson->partial[b * (anderson->window + 1) + j];
        anderson->gram[anderson->newest][j] = anderson->gram[j][anderson->newest] = sum;
    }
    solve(anderson);
    return VOR_OK;
}
