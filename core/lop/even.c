#include "core/lop/even.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"
#include "core/lop/edges.h"
#include "core/seeds/repel.h"
#include "core/seeds/stage.h"

#include <string.h>

enum {
    /* Points of one task. */
    BLOCK = 256,
    /* Steps from one list of neighbours to the next; then points are put back onto the surface. At
     * 4 / 8: fandisk30k_noise2 to 120,000, delta 0.0586 / 0.0584, near edges both 5.47e-4; an
     * armadillo with noise to 22,000, delta 0.201 / 0.162, 10.6 / 9.6 CPU s. */
    LIST_EVERY = 8
};

/* Spacings that neighbours are listed from, and that the force extends to. */
#define LIST_REACH 2.0
#define FORCE_REACH 1.7
/* Mean distance to the nearest point over that to the six nearest, where points were inserted. */
#define NEAREST_OF_SIX 0.87
/* Length of the mean of the unit vectors to the neighbours, above which a point is at the border.
 * It is 0.64 where they fill half of the plane. */
#define BORDER 0.4

struct even {
    struct vor_lop_samples *samples;
    const struct vor_lop_latent *latent;
    const struct vor_run *run;
    struct vor_stage stage;
    struct vor_lop_tree tree;  /* of the points as of the last lists */
    struct vor_lop_edge *edge; /* n: as of the last lists */
    unsigned char *on;         /* n: on an edge */
    unsigned char *listed;     /* n: neighbours */
    uint32_t *list;            /* n x VOR_SEEDS_LISTED */
    float *spacing;            /* n */
    float *next, *step;        /* n x 3 */
    float *nearest;            /* n: distance to the nearest neighbour */
    struct vor_repel_pace pace;
    const struct vor_lop_even_how *how;
};

static vor_status alloc_even(struct even *even, struct vor_error *err)
{
    struct vor_memory *memory = even->samples->memory;
    size_t n = even->samples->n;

    return VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(even->edge, n, 1), VOR_ZEROED(even->on, n, 1),
                        VOR_ARRAY(even->listed, n, 1), VOR_ARRAY(even->list, n, VOR_SEEDS_LISTED),
                        VOR_ARRAY(even->spacing, n, 1), VOR_ARRAY(even->next, n, 3),
                        VOR_ZEROED(even->step, n, 3), VOR_ARRAY(even->nearest, n, 1));
}

/* Distances of the points to their nearest, and the spacing of each place. */
struct apart {
    struct even *even;
    struct vor_knn *knn;
};

static void apart_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct apart *apart = ctx;
    struct even *even = apart->even;
    size_t n = even->samples->n;
    unsigned k = n > VOR_PATCH_HEXAGON ? VOR_PATCH_HEXAGON + 1 : (unsigned)n;

    for (size_t i = begin; i < end; i++) {
        uint32_t index[VOR_PATCH_HEXAGON + 1];
        float distance2[VOR_PATCH_HEXAGON + 1];
        double sum = 0;

        vor_knn_search(apart->knn, &even->samples->xyz[3 * i], 1, k, index, distance2);
        for (unsigned j = 1; j < k; j++)
            sum += sqrt((double)distance2[j]);
        even->nearest[i] = k > 1 ? sqrtf(distance2[1]) : 0;
        even->spacing[i] = (float)(NEAREST_OF_SIX * sum / (k > 1 ? k - 1 : 1));
    }
}

/* Writes how even the points are into the record, and gives all one spacing. */
static void note(struct even *even)
{
    struct vor_uniformity u;

    vor_uniformity_from(&u, even->nearest, even->samples->n);
    vor_stage_note(&even->stage, &u);
    for (size_t i = 0; i < even->samples->n && !even->how->local; i++)
        even->spacing[i] = (float)u.mean;
}

/* Measures the spacing of the points as they are. */
static vor_status measure(struct even *even, const struct vor_run *run, struct vor_error *err)
{
    struct vor_lop_samples *samples = even->samples;
    struct apart apart = {.even = even};
    vor_status status = vor_knn_build(&apart.knn, samples->xyz, samples->n, samples->memory, err);

    VOR_THEN(status, vor_run_for(run, samples->n, BLOCK, apart_block, &apart, err));
    vor_knn_free(apart.knn);
    if (status == VOR_OK)
        note(even);
    return status;
}

static struct vor_lop_point point_at(const struct even *even, size_t i)
{
    struct vor_lop_point point;

    memcpy(point.xyz, &even->samples->xyz[3 * i], sizeof point.xyz);
    memcpy(point.normal, &even->samples->normal[3 * i], sizeof point.normal);
    return point;
}

/* Puts point i back onto the surface, or onto its edge. */
static void put_back(struct even *even, size_t i)
{
    struct vor_lop_point end[2] = {point_at(even, i), point_at(even, i)}, point = end[0];
    struct vor_lop_edge *edge = &even->edge[i];
    double cosine;

    if (even->on[i]) {
        memcpy(end[1].normal, edge->other, sizeof end[1].normal);
        if (!vor_lop_latent_edge(point.xyz, edge->along, &cosine, even->latent, end[0].xyz, end))
            return;
    } else {
        vor_lop_latent_side(&point, even->latent, end[0].xyz, &end[0]);
    }
    if (vor_distance2f(point.xyz, end[0].xyz) > (double)even->spacing[i] * (double)even->spacing[i])
        return; /* a fit that throws a point as far as that is none */
    memcpy(&even->samples->xyz[3 * i], point.xyz, sizeof point.xyz);
    memcpy(&even->samples->normal[3 * i], point.normal, sizeof point.normal);
}

static void put_back_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    for (size_t i = begin; i < end && !vor_run_is_late(((struct even *)ctx)->run); i++)
        put_back(ctx, i);
}

/* Lists the nearest of those gathered around point i. */
static void list_nearest(struct even *even, size_t i, const struct vor_lop_gathered *near)
{
    uint32_t *list = &even->list[VOR_SEEDS_LISTED * i];
    float distance2[VOR_SEEDS_LISTED] = {0}; /* gcc's analyzer cannot see that `count` are set */
    unsigned count = 0;

    for (unsigned k = 0; k < near->count; k++) {
        unsigned at;

        if (near->index[k] == i ||
            (count == VOR_SEEDS_LISTED && near->distance2[k] >= distance2[VOR_SEEDS_LISTED - 1]))
            continue;
        at = count < VOR_SEEDS_LISTED ? count++ : VOR_SEEDS_LISTED - 1;
        for (; at > 0 && distance2[at - 1] > near->distance2[k]; at--) {
            distance2[at] = distance2[at - 1];
            list[at] = list[at - 1];
        }
        distance2[at] = near->distance2[k];
        list[at] = near->index[k];
    }
    even->listed[i] = (unsigned char)count;
}

/* Puts a point that lies past its edge as far to this side of it. Noise throws samples there, and
 * others are inserted beside them. */
static void bring_back(struct even *even, size_t i)
{
    const struct vor_lop_edge *edge = &even->edge[i];
    float *x = &even->samples->xyz[3 * i];

    for (int c = 0; c < 3 && edge->distance < INFINITY && edge->past; c++)
        x[c] = 2 * edge->foot[c] - x[c];
}

static void list_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct even *even = ctx;
    struct vor_lop_gathered near;

    for (size_t i = begin; i < end; i++) {
        vor_lop_tree_gather(&near, &even->tree, &even->samples->xyz[3 * i],
                            LIST_REACH * (double)even->spacing[i]);
        list_nearest(even, i, &near);
        if (even->on[i])
            continue;
        vor_lop_edge_find(&even->edge[i], even->samples, i, (double)even->spacing[i], &even->tree,
                          even->latent);
        bring_back(even, i);
    }
}

/* Finds the neighbours and the edges of the points as they are, and puts points onto edges. */
static vor_status list_all(struct even *even, struct vor_error *err)
{
    struct vor_lop_samples *samples = even->samples;
    vor_status status;

    vor_lop_tree_free(&even->tree);
    status = vor_lop_tree_build(&even->tree, samples, even->run, err);
    VOR_THEN(status, vor_run_for(even->run, samples->n, BLOCK, list_block, even, err));
    VOR_THEN(status, vor_lop_edge_put(samples, even->edge, even->on, even->spacing, err));
    return status;
}

/* What pushes point i, and the mean of the unit vectors to its neighbours. */
struct push {
    double force[3], mean[3];
    double nearest2;
};

static void push_from(struct push *push, const struct even *even, size_t i)
{
    const float *x = &even->samples->xyz[3 * i], *n = &even->samples->normal[3 * i];
    double h2 = (double)even->spacing[i] * (double)even->spacing[i], count = 0;
    double scale = even->pace.gain / (2 * even->pace.power);

    memset(push, 0, sizeof *push);
    push->nearest2 = LIST_REACH * LIST_REACH * h2; /* of a point alone: what is known of it */
    for (unsigned k = 0; k < even->listed[i]; k++) {
        size_t j = even->list[VOR_SEEDS_LISTED * i + k];
        const float *y = &even->samples->xyz[3 * j], *m = &even->samples->normal[3 * j];
        double d[3] = {(double)x[0] - (double)y[0], (double)x[1] - (double)y[1],
                       (double)x[2] - (double)y[2]};
        double d2 = vor_dot(d, d), length = sqrt(d2), weight;

        push->nearest2 = fmin(push->nearest2, d2);
        if ((double)n[0] * (double)m[0] + (double)n[1] * (double)m[1] +
                (double)n[2] * (double)m[2] <
            -VOR_SAME_WAY)
            continue;
        if (d2 > FORCE_REACH * FORCE_REACH * h2 || !(d2 > 0))
            continue;
        /* The force is bounded, and not what d is multiplied by: that fell to 0 between points that
         * are nearly one, and they stayed so. */
        weight = VOR_REPEL_FORCE_MAX * sqrt(h2 / d2);
        if (VOR_REPEL_FORCE_MAX * d2 > h2)
            weight = fmin(vor_power(h2 / d2, even->pace.power), weight);
        count++;
        for (int c = 0; c < 3; c++) {
            push->force[c] += scale * weight * d[c];
            push->mean[c] -= d[c] / length;
        }
    }
    for (int c = 0; c < 3 && count > 0; c++)
        push->mean[c] /= count;
}

/* Reduces v to what keeps point i on the surface, inside its border, or on its edge. */
static void keep(const struct even *even, size_t i, const struct push *push, double v[3])
{
    const float *normal = &even->samples->normal[3 * i], *along = even->edge[i].along;
    double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]}, out[3], length;
    double h = (double)even->spacing[i];

    if (even->on[i]) {
        double t[3] = {(double)along[0], (double)along[1], (double)along[2]};
        double moved = vor_dot(v, t);

        for (int c = 0; c < 3; c++)
            v[c] = moved * t[c];
        return;
    }
    vor_remove_along(v, n, 0);
    for (int c = 0; c < 3; c++)
        out[c] = -push->mean[c];
    vor_remove_along(out, n, 0);
    length = sqrt(vor_dot(out, out));
    if (length < BORDER || push->nearest2 < VOR_LOP_CLOSE * VOR_LOP_CLOSE * h * h)
        return;
    for (int c = 0; c < 3; c++)
        out[c] /= length;
    vor_remove_along(v, out, 1);
}

/* Whether point i passes the plane of the other side of its edge on the way to y. */
static int passes_edge(const struct even *even, size_t i, const float y[3])
{
    const struct vor_lop_edge *edge = &even->edge[i];
    const float *x = &even->samples->xyz[3 * i];
    double before = 0, after = 0;

    if (even->on[i] || !(edge->distance < INFINITY))
        return 0;
    for (int c = 0; c < 3; c++) {
        before += (double)edge->other[c] * ((double)x[c] - (double)edge->foot[c]);
        after += (double)edge->other[c] * ((double)y[c] - (double)edge->foot[c]);
    }
    return (before > 0 && after < 0) || (before < 0 && after > 0);
}

static void move_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct even *even = ctx;

    for (size_t i = begin; i < end; i++) {
        const float *x = &even->samples->xyz[3 * i];
        float *step = &even->step[3 * i], *y = &even->next[3 * i];
        double limit = VOR_REPEL_STEP_MAX * (double)even->spacing[i], v[3] = {0}, length, part;
        struct push push;

        push_from(&push, even, i);
        if (even->listed[i] > 0) /* else it is as far as it was measured */
            even->nearest[i] = (float)sqrt(push.nearest2);
        for (int c = 0; c < 3; c++)
            v[c] = push.force[c] + even->pace.momentum * (double)step[c];
        keep(even, i, &push, v);
        length = sqrt(vor_dot(v, v));
        part = length > limit ? limit / length : 1;
        for (int c = 0; c < 3; c++)
            y[c] = (float)((double)x[c] + part * v[c]);
        if (passes_edge(even, i, y))
            memcpy(y, x, 3 * sizeof *y);
        for (int c = 0; c < 3; c++)
            step[c] = y[c] - x[c];
    }
}

static vor_status step_once(struct vor_stage *stage, struct vor_error *err)
{
    struct even *even = stage->of;
    struct vor_lop_samples *samples = even->samples;
    unsigned done = stage->record.step, steps = stage->record.of;
    vor_status status = VOR_OK;

    even->pace = vor_repel_pace_at(VOR_REPEL_HARD, done, steps);
    if (done % LIST_EVERY == 0 && done > 0)
        status = vor_run_for(even->run, samples->n, BLOCK, put_back_block, even, err);
    if (status == VOR_OK && done % LIST_EVERY == 0)
        status = vor_lop_beside_put(samples, 0, even->how->beside, even->run, err);
    if (status == VOR_OK && done % LIST_EVERY == 0)
        status = list_all(even, err);
    VOR_THEN(status, vor_run_for(even->run, samples->n, BLOCK, move_block, even, err));
    if (status != VOR_OK)
        return status;
    memcpy(samples->xyz, even->next, 3 * samples->n * sizeof *samples->xyz);
    note(even);
    vor_stage_note_move(stage, even->step);
    return VOR_OK;
}

/* Moves the points, and puts them onto the surface in the end. */
static vor_status move_all(struct even *even, struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(even->run);
    vor_status status = measure(even, &whole, err);

    for (size_t i = 0; i < even->samples->n && status == VOR_OK; i++)
        even->edge[i].distance = INFINITY;
    VOR_THEN(status, vor_stage_run(&even->stage, err));
    if (even->stage.record.step == 0)
        return status;
    VOR_THEN(status, vor_run_for(&whole, even->samples->n, BLOCK, put_back_block, even, err));
    return status == VOR_OK ? measure(even, &whole, err) : status;
}

vor_status vor_lop_even(struct vor_lop_samples *samples, const struct vor_lop_latent *latent,
                        const struct vor_lop_even_how *how, const struct vor_domain *domain,
                        struct vor_outcome *told, const struct vor_run *run, struct vor_error *err)
{
    struct even even = {.samples = samples, .latent = latent, .run = run, .how = how};
    vor_status status;

    if (how->steps == 0 || told->stopped == VOR_STOPPED_CALLER)
        return VOR_OK;
    even.stage = (struct vor_stage){.spec = how->spec,
                                    .run = run,
                                    .told = told,
                                    .record = told->last,
                                    .domain = domain,
                                    .xyz = samples->xyz,
                                    .n = samples->n,
                                    .of = &even,
                                    .step = step_once,
                                    .share = 1,
                                    .follows = 1};
    even.stage.record.stage = VOR_RUN_STAGE_POLISH;
    even.stage.record.step = even.stage.record.ahead = 0;
    even.stage.record.of = how->steps;
    status = alloc_even(&even, err);
    VOR_THEN(status, move_all(&even, err));
    VOR_FREE_ALL(samples->memory, even.nearest, even.step, even.next, even.spacing, even.list,
                 even.listed, even.on, even.edge);
    vor_lop_tree_free(&even.tree);
    return status;
}
