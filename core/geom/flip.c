#include "core/geom/flip.h"

#include "core/base/queue.h"
#include "core/base/union.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024 }; /* points of one task */

/* What the edges between two regions say of their signs: above 0 that they agree. */
struct bond {
    uint32_t a, b;
    float vote, all; /* all: regardless of what each says */
};

/* A region: the sum of its bonds, as its sign is now. */
struct region {
    double vote, all;
    size_t first, bonds; /* in `of` */
    unsigned char turned;
};

struct flip {
    struct vor_span *span;
    const struct vor_graph *graph;
    const unsigned char *edge;
    const struct vor_flip_how *how;
    unsigned char *between; /* n: 1 where a point belongs to no region by itself */
    uint32_t *at;           /* n: way to the first point of its region; then the region */
    struct region *region;
    size_t regions;
    struct bond *bond;
    size_t bonds;
    size_t *of;                    /* 2 bonds: those of each region */
    struct vor_queue_entry *wrong; /* regions: those that face the wrong way */
    size_t turned;                 /* turns */
};

static double vote_of(const struct flip *flip, size_t i, unsigned a)
{
    size_t at = i * flip->graph->most + a;

    return vor_span_vote(flip->edge[at],
                         flip->span->odd[i] ^ flip->span->odd[flip->graph->list[at]]);
}

static void doubt_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct flip *flip = ctx;

    for (size_t i = begin; i < end; i++) {
        double against = 0, all = 0;

        for (unsigned a = 0; a < flip->graph->count[i]; a++) {
            double vote = vote_of(flip, i, a);

            against += vote < 0 ? -vote : 0;
            all += fabs(vote);
        }
        flip->between[i] = against > flip->how->doubt * all;
    }
}

/* Makes regions of the points that are not between them. */
static void join_sure(struct flip *flip)
{
    const struct vor_graph *graph = flip->graph;

    for (size_t i = 0; i < graph->n; i++)
        flip->at[i] = (uint32_t)i;
    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; a < graph->count[i] / VOR_FLIP_REACH && !flip->between[i]; a++) {
            uint32_t j = graph->list[i * graph->most + a];

            if (!flip->between[j] && vote_of(flip, i, a) > 0)
                vor_union_join(flip->at, (uint32_t)i, j);
        }
}

/* Finds the region beside point i that it agrees with most; i where there is none. */
static uint32_t best_beside(const struct flip *flip, size_t i)
{
    const struct vor_graph *graph = flip->graph;
    const uint32_t *list = &graph->list[i * graph->most];
    double best = 0;
    uint32_t found = (uint32_t)i;

    for (unsigned a = 0; a < graph->count[i]; a++) {
        double sum = 0;

        if (flip->between[list[a]])
            continue;
        for (unsigned b = 0; b < graph->count[i]; b++)
            if (!flip->between[list[b]] &&
                vor_union_root(flip->at, list[b]) == vor_union_root(flip->at, list[a]))
                sum += vote_of(flip, i, b);
        if (sum > best) {
            best = sum;
            found = vor_union_root(flip->at, list[a]);
        }
    }
    return found;
}

/* Lets the points between regions join those beside them, ring by ring. */
static vor_status join_beside(struct flip *flip, const struct vor_run *run, struct vor_error *err)
{
    size_t n = flip->graph->n, joined;
    vor_status status;

    do {
        joined = 0;
        status = vor_run_answered(vor_run_poll(run), err);
        for (size_t i = 0; i < n && status == VOR_OK; i++) {
            uint32_t root = flip->between[i] ? best_beside(flip, i) : (uint32_t)i;

            if (root == i)
                continue;
            vor_union_join(flip->at, (uint32_t)i, root);
            flip->between[i] = 0;
            joined++;
        }
    } while (joined > 0);
    return status;
}

static int by_regions(const void *x, const void *y)
{
    const struct bond *p = x, *q = y;

    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    if (p->b != q->b)
        return p->b < q->b ? -1 : 1;
    return (p->vote > q->vote) - (p->vote < q->vote);
}

/* Numbers the regions in the order of their first points. */
static void number_regions(struct flip *flip)
{
    size_t n = flip->graph->n;

    for (size_t i = 0; i < n; i++)
        flip->at[i] = vor_union_root(flip->at, (uint32_t)i);
    for (size_t i = 0; i < n; i++)
        flip->at[i] = flip->at[i] == i ? (uint32_t)flip->regions++ : flip->at[flip->at[i]];
}

/* Lists the edges between regions, or counts them. */
static size_t list_bonds(struct bond *out, const struct flip *flip)
{
    const struct vor_graph *graph = flip->graph;
    size_t count = 0;

    for (size_t i = 0; i < graph->n; i++)
        for (unsigned k = 0; k < graph->count[i]; k++) {
            uint32_t a = flip->at[i], b = flip->at[graph->list[i * graph->most + k]];
            float vote;

            if (a == b)
                continue;
            vote = (float)vote_of(flip, i, k);
            if (out != NULL)
                out[count] = (struct bond){a < b ? a : b, a < b ? b : a, vote, fabsf(vote)};
            count++;
        }
    return count;
}

/* Makes one bond of the edges between the same two regions. */
static void gather(struct flip *flip)
{
    size_t kept = 0;

    qsort(flip->bond, flip->bonds, sizeof *flip->bond, by_regions);
    for (size_t e = 0; e < flip->bonds; e++) {
        const struct bond *bond = &flip->bond[e];
        struct bond *last = kept > 0 ? &flip->bond[kept - 1] : NULL;

        if (last != NULL && last->a == bond->a && last->b == bond->b) {
            last->vote += bond->vote;
            last->all += bond->all;
        } else {
            flip->bond[kept++] = *bond;
        }
    }
    flip->bonds = kept;
}

/* Adds up the bonds of each region, and lists them. */
static void add_up(struct flip *flip)
{
    size_t first = 0;

    for (size_t e = 0; e < flip->bonds; e++)
        for (int end = 0; end < 2; end++) {
            struct region *of = &flip->region[end ? flip->bond[e].b : flip->bond[e].a];

            of->vote += (double)flip->bond[e].vote;
            of->all += (double)flip->bond[e].all;
            of->bonds++;
        }
    for (size_t r = 0; r < flip->regions; r++) {
        flip->region[r].first = first;
        first += flip->region[r].bonds;
        flip->region[r].bonds = 0;
    }
    for (size_t e = 0; e < flip->bonds; e++)
        for (int end = 0; end < 2; end++) {
            struct region *of = &flip->region[end ? flip->bond[e].b : flip->bond[e].a];

            flip->of[of->first + of->bonds++] = e;
        }
}

static int faces_wrong(const struct flip *flip, const struct region *region)
{
    return region->vote < -flip->how->margin * region->all;
}

static void turn(struct flip *flip, uint32_t r)
{
    struct region *region = &flip->region[r];

    for (size_t k = region->first; k < region->first + region->bonds; k++) {
        const struct bond *bond = &flip->bond[flip->of[k]];
        struct region *other = &flip->region[bond->a == r ? bond->b : bond->a];
        double vote = (double)bond->vote;

        other->vote -= 2 * (region->turned == other->turned ? vote : -vote);
    }
    region->vote = -region->vote;
    flip->turned++;
    region->turned ^= 1;
}

static int by_gain(const void *x, const void *y)
{
    const struct vor_queue_entry *a = x, *b = y;

    return vor_queue_before(*a, *b) ? -1 : vor_queue_before(*b, *a);
}

/* Turns the regions that face the wrong way, those first whose turn gains most, until none does. */
static void turn_regions(struct flip *flip)
{
    size_t count;

    do {
        count = 0;
        for (uint32_t r = 0; r < flip->regions; r++)
            if (faces_wrong(flip, &flip->region[r]))
                flip->wrong[count++] = (struct vor_queue_entry){(float)-flip->region[r].vote, r};
        qsort(flip->wrong, count, sizeof *flip->wrong, by_gain);
        for (size_t k = 0; k < count; k++)
            if (faces_wrong(flip, &flip->region[flip->wrong[k].point]))
                turn(flip, flip->wrong[k].point);
    } while (count > 0);
}

static vor_status find_and_turn(struct flip *flip, const struct vor_run *run, struct vor_error *err)
{
    struct vor_memory *memory = run->memory;
    size_t n = flip->graph->n;
    vor_status status = vor_run_for(run, n, BLOCK, doubt_block, flip, err);

    if (status != VOR_OK)
        return status;
    join_sure(flip);
    status = join_beside(flip, run, err);
    if (status != VOR_OK)
        return status;
    number_regions(flip);
    flip->bonds = list_bonds(NULL, flip);
    if (flip->bonds == 0)
        return VOR_OK;
    flip->bond = vor_malloc(memory, flip->bonds, sizeof *flip->bond);
    if (flip->bond == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    (void)list_bonds(flip->bond, flip);
    gather(flip);
    status = VOR_MAKE_ALL(memory, err, n, VOR_ZEROED(flip->region, flip->regions, 1),
                          VOR_ARRAY(flip->of, 2 * flip->bonds, 1),
                          VOR_ARRAY(flip->wrong, flip->regions, 1));
    if (status != VOR_OK)
        return status;
    add_up(flip);
    turn_regions(flip);
    return VOR_OK;
}

/* Applies the turns, but where a component is clean, or would no longer be well closed. */
static vor_status apply(const struct flip *flip, const struct vor_winding_points *points,
                        const struct vor_run *run, struct vor_error *err)
{
    struct vor_span *span = flip->span;
    struct vor_winding_found *was = vor_malloc(run->memory, span->components, 2 * sizeof *was);
    struct vor_winding_found *now = was == NULL ? NULL : &was[span->components];
    vor_status status;

    if (was == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", span->components);
    status = vor_winding_find(was, span, points, run, err);
    for (size_t i = 0; i < span->n; i++)
        span->odd[i] ^= flip->region[flip->at[i]].turned;
    VOR_THEN(status, vor_winding_find(now, span, points, run, err));
    for (size_t i = 0; i < span->n && status == VOR_OK; i++) {
        size_t c = span->component[i];

        if (fabs(was[c].mean) >= flip->how->closed && was[c].apart < flip->how->apart &&
            (was[c].apart < flip->how->clean || now[c].apart >= flip->how->apart))
            span->odd[i] ^= flip->region[flip->at[i]].turned;
    }
    vor_free(run->memory, was);
    return status;
}

vor_status vor_flip_regions(struct vor_span *span, const struct vor_graph *graph,
                            const unsigned char *edge, const struct vor_winding_points *points,
                            const struct vor_flip_how *how, const struct vor_run *run,
                            struct vor_error *err)
{
    struct vor_memory *memory = run->memory;
    struct flip flip = {.span = span, .graph = graph, .edge = edge, .how = how};
    vor_status status;

    status = VOR_MAKE_ALL(memory, err, span->n, VOR_ARRAY(flip.between, span->n, 1),
                          VOR_ARRAY(flip.at, span->n, 1));
    VOR_THEN(status, find_and_turn(&flip, run, err));
    if (status == VOR_OK && flip.turned > 0)
        status = apply(&flip, points, run, err);
    VOR_FREE_ALL(memory, flip.wrong, flip.of, flip.region, flip.bond, flip.at, flip.between);
    return status;
}
