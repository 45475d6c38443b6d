#include "core/lop/insert.h"

#include "core/base/linalg.h"
#include "core/base/queue.h"
#include "core/geom/patch.h"
#include "core/knn/knn.h"
#include "core/lop/between.h"
#include "core/lop/even.h"
#include "core/lop/latent.h"
#include "core/lop/power.h"
#include "core/seeds/stage.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    /* Samples of one task. */
    BLOCK = 256,
    /* Looks at pairs from one look at the watch to the next: about a millisecond. */
    POLL_EVERY = 256,
    /* Records that an insertion tells of. */
    RECORDS = 40
};

/* Priority of a pair whose base no side holds. */
#define LAST FLT_MIN

/* The pairs of a point: priorities as of the last look, 0 for none. */
struct pairs {
    float key[VOR_LOP_PAIRS];
    uint32_t partner[VOR_LOP_PAIRS];
};

struct insertion {
    struct vor_lop_samples *samples;
    const struct vor_lop_insert_how *how;
    const struct vor_run *run;
    struct vor_lop_tree tree;
    struct vor_lop_latent latent;
    struct pairs *pairs;          /* n */
    float *reach;                 /* n: how far away partners may be */
    struct vor_queue_entry *heap; /* n */
    struct vor_knn *knn;          /* of the samples, while they have no reach */
    size_t begun;                 /* samples at first */
    size_t looks;                 /* at pairs */
};

static const float *place(const struct insertion *insertion, uint32_t i)
{
    return &insertion->samples->xyz[3 * (size_t)i];
}

static const float *normal(const struct insertion *insertion, uint32_t i)
{
    return &insertion->samples->normal[3 * (size_t)i];
}

static struct vor_lop_base base_of(const struct insertion *insertion, uint32_t i, uint32_t j)
{
    const float *a = place(insertion, i), *b = place(insertion, j);
    struct vor_lop_base base = {.radius2 = vor_distance2f(a, b) / 4,
                                .end = {normal(insertion, i), normal(insertion, j)}};

    for (int c = 0; c < 3; c++)
        base.xyz[c] = (float)(((double)a[c] + (double)b[c]) / 2);
    return base;
}

/* The priority of a pair by the clearance of its base. */
static float priority(const struct insertion *insertion, const struct vor_lop_base *base,
                      double clearance2)
{
    double turned = 2 - fmax(vor_dotf(base->end[0], base->end[1]), 0), least = 0;

    for (int c = 0; c < 3; c++)
        least = fmax(least, VOR_ROUNDED * fabs((double)base->xyz[c]));
    if (!(clearance2 > least * least))
        return 0;
    return (float)(vor_lop_power(turned, insertion->how->rho) * sqrt(clearance2));
}

/* The place of the pair that comes first, among those of one point. */
static unsigned first_of(const struct pairs *pairs)
{
    unsigned best = 0;

    for (unsigned i = 1; i < VOR_LOP_PAIRS; i++)
        if (pairs->key[i] > pairs->key[best] ||
            (pairs->key[i] >= pairs->key[best] && pairs->partner[i] < pairs->partner[best]))
            best = i;
    return best;
}

/* Keeps a pair if it is among the best. */
static void offer(struct pairs *pairs, float key, uint32_t partner)
{
    unsigned worst = 0;

    for (unsigned i = 1; i < VOR_LOP_PAIRS; i++)
        if (pairs->key[i] < pairs->key[worst] ||
            (pairs->key[i] <= pairs->key[worst] && pairs->partner[i] > pairs->partner[worst]))
            worst = i;
    if (key > pairs->key[worst] || (key >= pairs->key[worst] && partner < pairs->partner[worst])) {
        pairs->key[worst] = key;
        pairs->partner[worst] = partner;
    }
}

/* Whether points i and j lie on two sheets, one over the other. */
static int stacked(const struct insertion *insertion, uint32_t i, uint32_t j, double distance2)
{
    const float *n = normal(insertion, i), *m = normal(insertion, j);
    double along = 0, length2 = 2 + 2 * vor_dotf(n, m);

    for (int c = 0; c < 3; c++)
        along += ((double)n[c] + (double)m[c]) *
                 ((double)place(insertion, i)[c] - (double)place(insertion, j)[c]);
    return along * along > VOR_LOP_STACKED * VOR_LOP_STACKED * distance2 * length2;
}

/* Whether point i has a pair with point j, which it reaches. Of two samples the later has it,
 * unless only the earlier one reaches so far. */
static int has_pair(const struct insertion *insertion, uint32_t i, uint32_t j, double distance2)
{
    double other = (double)insertion->reach[j];

    if (i == j || vor_dotf(normal(insertion, i), normal(insertion, j)) < -VOR_SAME_WAY)
        return 0;
    if (stacked(insertion, i, j, distance2))
        return 0;
    if (i >= insertion->begun)
        return 1;
    if (other * other < VOR_LOP_REACH_PART * VOR_LOP_REACH_PART * distance2)
        return 0;
    return j < i || distance2 > other * other;
}

/* Finds the pairs of point i within its reach. */
static void find_pairs(const struct insertion *insertion, uint32_t i)
{
    struct pairs *pairs = &insertion->pairs[i];
    struct vor_lop_gathered near;

    for (unsigned k = 0; k < VOR_LOP_PAIRS; k++) {
        pairs->key[k] = 0;
        pairs->partner[k] = UINT32_MAX;
    }
    vor_lop_tree_gather(&near, &insertion->tree, place(insertion, i), (double)insertion->reach[i]);
    for (unsigned k = 0; k < near.count; k++) {
        uint32_t j = near.index[k];
        struct vor_lop_base base;

        if (!has_pair(insertion, i, j, (double)near.distance2[k]))
            continue;
        base = base_of(insertion, i, j);
        offer(pairs,
              priority(insertion, &base, vor_lop_gathered_clearance2(&near, &base, base.radius2)),
              j);
    }
}

static void find_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    for (size_t i = begin; i < end; i++)
        find_pairs(ctx, (uint32_t)i);
}

/* How far away partners of the samples may be, by the spacing around each. */
static void reach_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct insertion *insertion = ctx;
    size_t n = insertion->begun;
    unsigned k = n > VOR_PATCH_HEXAGON ? VOR_PATCH_HEXAGON + 1 : (unsigned)n;

    for (size_t i = begin; i < end; i++) {
        uint32_t index[VOR_PATCH_HEXAGON + 1];
        float distance2[VOR_PATCH_HEXAGON + 1];
        double sum = 0;

        vor_knn_search(insertion->knn, place(insertion, (uint32_t)i), 1, k, index, distance2);
        for (unsigned j = 1; j < k; j++)
            sum += sqrt((double)distance2[j]);
        insertion->reach[i] =
            (float)((insertion->how->fill ? VOR_LOP_REACH_FILL : VOR_LOP_PARTNERS) *
                    fmax(sum / (k - 1), insertion->how->spacing));
    }
}

static vor_status find_reach(struct insertion *insertion, struct vor_error *err)
{
    struct vor_lop_samples *samples = insertion->samples;
    vor_status status =
        vor_knn_build(&insertion->knn, samples->xyz, insertion->begun, samples->memory, err);

    VOR_THEN(status,
             vor_run_for(insertion->run, insertion->begun, BLOCK, reach_block, insertion, err));
    vor_knn_free(insertion->knn);
    insertion->knn = NULL;
    return status;
}

/* Queues the pairs of point i. */
static void queue(struct insertion *insertion, uint32_t i)
{
    const struct pairs *pairs = &insertion->pairs[i];
    struct vor_queue_entry entry = {pairs->key[first_of(pairs)], i};

    vor_queue_push(insertion->heap, i, entry);
}

/* Indexes the samples and queues their pairs. */

/* Gives pair `at` of the first point of the queue a smaller priority. */
static void lower(struct insertion *insertion, unsigned at, float key)
{
    struct pairs *pairs = &insertion->pairs[insertion->heap[0].point];

    pairs->key[at] = key;
    vor_queue_lower(insertion->heap, insertion->samples->n, pairs->key[first_of(pairs)]);
}

/* Finds the pair with the largest priority: that at place *at of the first point of the queue.
 *
 * @return the square of its clearance; 0 if no pair has any */
static double find_largest(struct insertion *insertion, unsigned *at)
{
    for (;;) {
        uint32_t i = insertion->heap[0].point;
        struct pairs *pairs = &insertion->pairs[i];
        struct vor_lop_base base;
        double clearance2;
        float key;

        *at = first_of(pairs);
        if (!(pairs->key[*at] > 0))
            return 0;
        base = base_of(insertion, i, pairs->partner[*at]);
        clearance2 = vor_lop_tree_clearance2(&insertion->tree, &base, base.radius2);
        key = priority(insertion, &base, clearance2);
        if (key >= pairs->key[*at])
            return clearance2;
        lower(insertion, *at, key);
    }
}

/* Whether points are put beside the data in the end; else all are polished later. */
static int lands(const struct vor_lop_insert_how *how)
{
    return how->rho > 0 || how->polish > 0;
}

/* Puts a base onto that of its ends' sides which is nearer. Where the point would hang in the air
 * there, as across a gap that the plane of one side passes: onto the other side, if these are at
 * right angles or more; data between others may have planes of neither. */
static int put(struct vor_lop_point *out, const struct insertion *insertion, const float base[3],
               const struct vor_lop_point end[2])
{
    const struct vor_lop_insert_how *how = insertion->how;
    int held = vor_lop_latent_put(out, &insertion->latent, base, end);
    int hangs = held && lands(how) && !how->fill &&
                vor_lop_beside_hangs(out->xyz, out->normal, &how->beside);

    for (int l = 0; l < 2 && hangs && vor_dotf(end[0].normal, end[1].normal) <= 0; l++) {
        const struct vor_lop_point same[2] = {end[l], end[l]};

        hangs = !vor_lop_latent_put(out, &insertion->latent, base, same) ||
                vor_lop_beside_hangs(out->xyz, out->normal, &how->beside);
    }
    return held && !hangs;
}

/* Inserts a point between the first point of the queue and its partner at a place, with the
 * clearance that their base had. Where the surface has no side the pair comes after all others. */
static vor_status insert_between(struct insertion *insertion, unsigned at, double clearance2,
                                 struct vor_error *err)
{
    struct vor_lop_samples *samples = insertion->samples;
    uint32_t i = insertion->heap[0].point, j = insertion->pairs[i].partner[at];
    int is_last = insertion->pairs[i].key[at] <= LAST;
    struct vor_lop_base base = base_of(insertion, i, j);
    struct vor_lop_point end[2], point;
    uint32_t k = (uint32_t)samples->n;
    double parents = ((double)insertion->reach[i] + (double)insertion->reach[j]) / 2;
    vor_status status;

    memcpy(end[0].xyz, place(insertion, i), sizeof end[0].xyz);
    memcpy(end[0].normal, normal(insertion, i), sizeof end[0].normal);
    memcpy(end[1].xyz, place(insertion, j), sizeof end[1].xyz);
    memcpy(end[1].normal, normal(insertion, j), sizeof end[1].normal);
    if (is_last) {
        (void)vor_lop_latent_put(&point, &insertion->latent, base.xyz, end);
    } else if (!put(&point, insertion, base.xyz, end)) {
        lower(insertion, at, LAST);
        return VOR_OK;
    }
    lower(insertion, at, 0);
    memcpy(&samples->xyz[3 * (size_t)k], point.xyz, sizeof point.xyz);
    memcpy(&samples->normal[3 * (size_t)k], point.normal, sizeof point.normal);
    status = vor_lop_tree_add(&insertion->tree, k, point.xyz, point.normal, err);
    if (status != VOR_OK)
        return status;
    insertion->reach[k] = (float)fmin(VOR_LOP_PARTNERS * sqrt(clearance2), parents);
    find_pairs(insertion, k);
    queue(insertion, k);
    samples->n++;
    return VOR_OK;
}

static vor_status insert_one(struct vor_stage *stage, struct vor_error *err)
{
    struct insertion *insertion = stage->of;
    vor_status status = VOR_OK;

    while (status == VOR_OK && insertion->samples->n == stage->n) {
        unsigned at;
        double clearance2 = find_largest(insertion, &at);

        if (insertion->looks++ % POLL_EVERY == POLL_EVERY - 1)
            status = vor_run_answered(vor_run_poll(stage->run), err);
        if (status == VOR_OK && !(clearance2 > 0))
            status = vor_fail(err, VOR_E_DEGENERATE,
                              "there is no gap for another point between the %zu existing "
                              "points",
                              insertion->samples->n);
        VOR_THEN(status, insert_between(insertion, at, clearance2, err));
    }
    stage->n = insertion->samples->n;
    return status;
}

/* Makes room for n samples. */
static vor_status grow(struct vor_lop_samples *samples, size_t n, struct vor_error *err)
{
    float *more;

    if (n <= samples->room)
        return VOR_OK;
    more = vor_realloc(samples->memory, samples->xyz, n, 3 * sizeof *more);
    if (more != NULL) {
        samples->xyz = more;
        more = vor_realloc(samples->memory, samples->normal, n, 3 * sizeof *more);
    }
    if (more == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    samples->normal = more;
    samples->room = n;
    return VOR_OK;
}

static vor_status alloc_insertion(struct insertion *insertion, size_t n, struct vor_error *err)
{
    struct vor_memory *memory = insertion->samples->memory;

    return VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(insertion->pairs, n, 1),
                        VOR_ARRAY(insertion->reach, n, 1), VOR_ARRAY(insertion->heap, n, 1));
}

/* Inserts until there are n points, or the run is stopped. */
static vor_status insert_all(struct insertion *insertion, struct vor_stage *stage,
                             struct vor_error *err)
{
    const struct vor_run *run = insertion->run;
    size_t begun = insertion->begun;
    vor_status status = alloc_insertion(insertion, begun + stage->record.of, err);

    VOR_THEN(status, vor_lop_tree_build(&insertion->tree, insertion->samples, run, err));
    VOR_THEN(status, find_reach(insertion, err));
    VOR_THEN(status, vor_run_for(run, begun, BLOCK, find_block, insertion, err));
    for (size_t i = 0; i < begun && status == VOR_OK; i++)
        queue(insertion, (uint32_t)i);
    VOR_THEN(status, vor_stage_run(stage, err));
    VOR_FREE_ALL(insertion->samples->memory, insertion->heap, insertion->reach, insertion->pairs);
    vor_lop_tree_free(&insertion->tree);
    return status;
}

vor_status vor_lop_insert(struct vor_lop_samples *samples, size_t n,
                          const struct vor_lop_insert_how *how, const struct vor_domain *domain,
                          struct vor_outcome *told, const struct vor_run *run,
                          struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(run);
    struct insertion insertion = {.samples = samples, .how = how, .run = run, .begun = samples->n};
    const struct vor_lop_even_how even = {how->polish, how->rho > 0, &how->beside, how->spec};
    double before = vor_run_clock(run);
    vor_status status = grow(samples, n, err);
    struct vor_stage stage = {.spec = how->spec,
                              .run = run,
                              .told = told,
                              .record = told->last,
                              .domain = domain,
                              .xyz = samples->xyz,
                              .n = samples->n,
                              .of = &insertion,
                              .step = insert_one,
                              .tell_every = (unsigned)((n - samples->n) / RECORDS) + 1,
                              .follows = 1,
                              .unfinished = 1};

    stage.record.stage = VOR_RUN_STAGE_INSERT;
    stage.record.step = 0;
    stage.record.of = (uint32_t)(n - samples->n);
    stage.record.ahead = how->polish;
    if (status == VOR_OK && told->stopped != VOR_STOPPED_CALLER)
        status =
            vor_lop_latent_init(&insertion.latent, samples, how->sigma_n, how->sigma_p, run, err);
    if (status == VOR_OK && told->stopped != VOR_STOPPED_CALLER && n > samples->n)
        status = insert_all(&insertion, &stage, err);
    if (status == VOR_E_STOPPED) {
        told->stopped = VOR_STOPPED_CALLER;
        status = VOR_OK;
    }
    if (status == VOR_OK && n > samples->n) /* what a stop left missing */
        status =
            vor_lop_between(samples, n, (uint64_t)how->spec->value[VOR_PARAM_SEED], &whole, err);
    if (n > insertion.begun)
        told->seconds[VOR_RUN_STAGE_INSERT] = vor_run_clock(run) - before;
    VOR_THEN(status, vor_lop_even(samples, &insertion.latent, &even, domain, told, run, err));
    if (status == VOR_OK && lands(how))
        status = vor_lop_beside_put(samples, how->polish > 0 ? 0 : insertion.begun, &how->beside,
                                    &whole, err);
    vor_lop_latent_free(&insertion.latent);
    return status;
}
