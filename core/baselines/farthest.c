#include "core/baselines/farthest.h"

#include "core/base/linalg.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

enum {
    LEAF = 32,   /* points of a leaf */
    CHUNK = 1024 /* points that are chosen between two looks at the caller's answer */
};

/* Of a point that was chosen: it is never the farthest. */
#define CHOSEN (-1.0F)

/* The points of a leaf, or those of both children. Nodes 2 i and 2 i + 1 are the children of node
 * i, node 1 is the root. */
struct node {
    float low[3], high[3];
    float most;  /* largest distance, squared, to the points chosen; CHOSEN where there are none */
    uint32_t at; /* whose that is */
};

struct farthest {
    const float *xyz;
    size_t n, leaves;  /* leaves: a power of two */
    float *distance2;  /* n: to the nearest point chosen */
    struct node *node; /* 2 leaves */
    uint32_t *visited; /* 2 leaves: nodes that the new point may change, children after parents */
    float *out;
    size_t chosen, count;
};

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Finds the farthest point of a leaf again. */
static void renew_leaf(struct farthest *farthest, size_t leaf)
{
    struct node *node = &farthest->node[farthest->leaves + leaf];
    size_t end = smaller((leaf + 1) * LEAF, farthest->n);

    node->most = CHOSEN;
    node->at = 0;
    for (size_t i = leaf * LEAF; i < end; i++)
        if (farthest->distance2[i] > node->most) {
            node->most = farthest->distance2[i];
            node->at = (uint32_t)i;
        }
}

static void renew_inner(struct farthest *farthest, size_t i)
{
    const struct node *left = &farthest->node[2 * i], *right = &farthest->node[2 * i + 1];
    const struct node *more = right->most > left->most ? right : left;

    farthest->node[i].most = more->most;
    farthest->node[i].at = more->at;
}

static void make_tree(struct farthest *farthest)
{
    for (size_t i = 0; i < farthest->n; i++)
        farthest->distance2[i] = INFINITY;
    for (size_t leaf = 0; leaf < farthest->leaves; leaf++) {
        /* A leaf without points has a box that is far from everything. */
        struct node *node = &farthest->node[farthest->leaves + leaf];
        size_t end = smaller((leaf + 1) * LEAF, farthest->n);

        for (int c = 0; c < 3; c++) {
            node->low[c] = INFINITY;
            node->high[c] = -INFINITY;
        }
        for (size_t i = leaf * LEAF; i < end; i++)
            for (size_t c = 0; c < 3; c++) {
                float x = farthest->xyz[3 * i + c];

                node->low[c] = x < node->low[c] ? x : node->low[c];
                node->high[c] = x > node->high[c] ? x : node->high[c];
            }
        renew_leaf(farthest, leaf);
    }
    for (size_t i = farthest->leaves - 1; i >= 1; i--) {
        const struct node *left = &farthest->node[2 * i], *right = &farthest->node[2 * i + 1];
        struct node *node = &farthest->node[i];

        for (int c = 0; c < 3; c++) {
            node->low[c] = left->low[c] < right->low[c] ? left->low[c] : right->low[c];
            node->high[c] = left->high[c] > right->high[c] ? left->high[c] : right->high[c];
        }
        renew_inner(farthest, i);
    }
}

/* Squared distance of x to the box of a node. As each step of it rounds alike, it is at most that
 * to a point inside as vor_distance2f has it. */
static double distance2_to(const struct node *node, const float *x)
{
    double sum = 0;

    for (int c = 0; c < 3; c++) {
        double d = (double)x[c] < (double)node->low[c]    ? (double)node->low[c] - (double)x[c]
                   : (double)x[c] > (double)node->high[c] ? (double)x[c] - (double)node->high[c]
                                                          : 0;

        sum += d * d;
    }
    return sum;
}

/* Takes a new point into account in a leaf. */
static void shorten_leaf(struct farthest *farthest, size_t leaf, const float *x)
{
    size_t end = smaller((leaf + 1) * LEAF, farthest->n);

    for (size_t i = leaf * LEAF; i < end; i++) {
        float distance2 = (float)vor_distance2f(&farthest->xyz[3 * i], x);

        if (distance2 < farthest->distance2[i])
            farthest->distance2[i] = distance2;
    }
    renew_leaf(farthest, leaf);
}

static void choose(struct farthest *farthest, size_t i)
{
    const float *x = &farthest->xyz[3 * i];
    size_t count = 0;

    memcpy(&farthest->out[3 * farthest->chosen++], x, 3 * sizeof *x);
    farthest->distance2[i] = CHOSEN;
    farthest->visited[count++] = 1;
    for (size_t at = 0; at < count; at++) {
        uint32_t here = farthest->visited[at];
        const struct node *node = &farthest->node[here];

        if (distance2_to(node, x) > (double)node->most)
            farthest->visited[at] = 0;
        else if (here >= farthest->leaves)
            shorten_leaf(farthest, here - farthest->leaves, x);
        else
            for (uint32_t child = 0; child < 2; child++)
                farthest->visited[count++] = 2 * here + child;
    }
    while (count-- > 0)
        if (farthest->visited[count] > 0 && farthest->visited[count] < farthest->leaves)
            renew_inner(farthest, farthest->visited[count]);
}

static void choose_chunk(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct farthest *farthest = ctx;
    size_t until = smaller(farthest->chosen + CHUNK, farthest->count);

    while (farthest->chosen < until)
        choose(farthest, farthest->node[1].at);
}

vor_status vor_farthest_points(float *out, const float *xyz, size_t n, size_t count, size_t first,
                               const struct vor_run *run, struct vor_error *err)
{
    struct farthest farthest = {.xyz = xyz, .n = n, .out = out, .count = count, .leaves = 1};
    vor_status status = VOR_OK;

    while (farthest.leaves * LEAF < n)
        farthest.leaves *= 2;
    farthest.distance2 = vor_malloc(run->memory, n, sizeof *farthest.distance2);
    farthest.node = vor_malloc(run->memory, 2 * farthest.leaves, sizeof *farthest.node);
    farthest.visited = vor_malloc(run->memory, 2 * farthest.leaves, sizeof *farthest.visited);
    if (farthest.distance2 == NULL || farthest.node == NULL || farthest.visited == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    } else if (count > 0) {
        make_tree(&farthest);
        choose(&farthest, first);
    }
    while (status == VOR_OK && farthest.chosen < count)
        status = vor_run_rows(run, 1, 1, choose_chunk, &farthest, err);
    VOR_FREE_ALL(run->memory, farthest.visited, farthest.node, farthest.distance2);
    return status;
}
