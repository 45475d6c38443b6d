#include "core/remesh/remesh.h"

#include "core/base/linalg.h"
#include "core/input/thin.h"
#include "core/mesh/describe.h"
#include "core/mesh/flip.h"
#include "core/mesh/join.h"
#include "core/mesh/quality.h"
#include "core/mesh/relax.h"
#include "core/seeds/attach.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/coarse.h"
#include "core/seeds/repel.h"
#include "core/seeds/stage.h"

#include <stdlib.h>
#include <string.h>

/* Edges longer than this times l are split, those shorter than that are collapsed. Botsch and
 * Kobbelt 2004, Sec. 4. */
#define SPLIT (4.0 / 3)
#define COLLAPSE (4.0 / 5)

enum { POLL_EVERY = 256 }; /* edges */

/* An edge: its length over the spacing wanted there, its ends. */
struct edge {
    float length;
    uint32_t end[2];
};

struct remesh {
    struct vor_seeds *seeds;
    struct vor_sheet sheet;
    struct vor_complex complex;
    struct vor_stage stage;
    struct vor_recall how;
    float *before;             /* n x 3: where the points were before a step */
    unsigned char *moved;      /* n: a collapse or a split put the point elsewhere */
    unsigned char *surrounded; /* n: by triangles */
    struct edge *edge;
    size_t edges;
    double l;
    int opened;        /* triangles over a hole were taken away */
    vor_status status; /* of what ran on the pool's thread */
    struct vor_error *err;
};

static double length_of(const struct remesh *remesh, const float *x, uint32_t i, uint32_t j)
{
    const struct vor_seeds *seeds = remesh->seeds;

    return 2 * sqrt(vor_distance2f(x, &seeds->xyz[3 * (size_t)j])) /
           (vor_wanted_at(&seeds->wanted, i) + vor_wanted_at(&seeds->wanted, j));
}

static double edge_length(const struct remesh *remesh, const uint32_t end[2])
{
    return length_of(remesh, &remesh->seeds->xyz[3 * (size_t)end[0]], end[0], end[1]);
}

/* Lists the edges, each once. */
static void list_edges(struct remesh *remesh)
{
    const struct vor_complex *complex = &remesh->complex;

    remesh->edges = 0;
    for (uint32_t t = 0; t < complex->count; t++)
        for (size_t c = 0; c < 3 && complex->triangle[3 * (size_t)t] != VOR_COMPLEX_GONE; c++) {
            const uint32_t *corner = &complex->triangle[3 * (size_t)t];
            struct edge edge = {0, {corner[c], corner[(c + 1) % 3]}};
            uint32_t beyond = vor_complex_across(complex, t, edge.end[0], edge.end[1]);

            if (beyond < t)
                continue;
            edge.length = (float)edge_length(remesh, edge.end);
            remesh->edge[remesh->edges++] = edge;
        }
}

/* Shorter edges first; of equally long ones, that of the smaller points. */
static int shorter_first(const void *a, const void *b)
{
    const struct edge *x = a, *y = b;

    if (x->length < y->length || x->length > y->length)
        return x->length < y->length ? -1 : 1;
    for (int e = 0; e < 2; e++)
        if (x->end[e] != y->end[e])
            return x->end[e] < y->end[e] ? -1 : 1;
    return 0;
}

/* Sorts the edges, and finds the length l of which as many are too short as are too long. */
static void balance(struct remesh *remesh)
{
    const struct edge *edge = remesh->edge;
    size_t n = remesh->edges, k = 0;

    qsort(remesh->edge, n, sizeof *remesh->edge, shorter_first);
    while (k < n / 2 && COLLAPSE * (double)edge[n - 1 - k].length > SPLIT * (double)edge[k].length)
        k++;
    remesh->l = (double)edge[k].length / COLLAPSE;
}

/* Whether the triangles at point i but those of point j stay as they face if point i moves to x,
 * and their edges there are not too long. */
static int holds(const struct remesh *remesh, uint32_t i, uint32_t j, const float x[3])
{
    const struct vor_complex *complex = &remesh->complex;
    const float *xyz = remesh->seeds->xyz;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        static const uint32_t corner[3] = {0, 1, 2};
        uint32_t other[2];
        float at[9];
        double before[3], after[3];

        vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + t], i, other);
        if (other[0] == j || other[1] == j)
            continue;
        memcpy(at, &xyz[3 * (size_t)i], 3 * sizeof *at);
        for (size_t e = 0; e < 2; e++) {
            memcpy(&at[3 * (e + 1)], &xyz[3 * (size_t)other[e]], 3 * sizeof *at);
            if (length_of(remesh, x, i, other[e]) > SPLIT * remesh->l)
                return 0;
        }
        vor_triangle_normal(before, at, corner);
        memcpy(at, x, 3 * sizeof *at);
        vor_triangle_normal(after, at, corner);
        if (!(vor_dot(before, after) >
              VOR_SAME_WAY * sqrt(vor_dot(before, before) * vor_dot(after, after))))
            return 0;
    }
    return 1;
}

/* Whether an edge may be collapsed; then moves its ends so that the first stays, and tells where it
 * goes: to the middle, or where one end is at a loop, to that. */
static int collapses(const struct remesh *remesh, struct edge *edge, float x[3])
{
    uint32_t *end = edge->end;
    const float *xyz = remesh->seeds->xyz;

    if (!(edge_length(remesh, end) < COLLAPSE * remesh->l) ||
        !vor_complex_collapses(&remesh->complex, end[0], end[1]))
        return 0;
    if (remesh->surrounded[end[0]] < remesh->surrounded[end[1]]) {
        memcpy(x, &xyz[3 * (size_t)end[0]], 3 * sizeof *x);
    } else if (remesh->surrounded[end[1]] < remesh->surrounded[end[0]]) {
        uint32_t first = end[0];

        memcpy(x, &xyz[3 * (size_t)end[1]], 3 * sizeof *x);
        end[0] = end[1];
        end[1] = first;
    } else {
        for (size_t c = 0; c < 3; c++)
            x[c] = (xyz[3 * (size_t)end[0] + c] + xyz[3 * (size_t)end[1] + c]) / 2;
    }
    return holds(remesh, end[0], end[1], x) && holds(remesh, end[1], end[0], x);
}

/* Whether an edge may be split beside the collapse of another. */
static int splits(const struct remesh *remesh, const struct edge *edge, const struct edge *beside)
{
    const struct vor_complex *complex = &remesh->complex;
    uint32_t third[2];
    unsigned have = vor_complex_edge(complex, edge->end[0], edge->end[1], third);

    for (int e = 0; e < 2; e++)
        if (edge->end[e] == beside->end[0] || edge->end[e] == beside->end[1])
            return 0;
    for (unsigned k = 0; k < have; k++)
        if (third[k] == beside->end[0] || third[k] == beside->end[1] ||
            complex->degree[third[k]] == VOR_AROUND_MOST)
            return 0;
    return have > 0 && edge_length(remesh, edge->end) > SPLIT * remesh->l;
}

/* Puts point i onto the surface at the middle of an edge, unless that is outside the input or in a
 * hole. Returns whether it is there now. */
static int comes_to(struct remesh *remesh, struct vor_scratch *scratch, uint32_t i,
                    const struct edge *edge)
{
    struct vor_seeds *seeds = remesh->seeds;
    struct vor_border border;
    float *at = &seeds->xyz[3 * (size_t)i], before[3];
    double x[3];

    memcpy(before, at, sizeof before);
    for (size_t c = 0; c < 3; c++)
        at[c] =
            (seeds->xyz[3 * (size_t)edge->end[0] + c] + seeds->xyz[3 * (size_t)edge->end[1] + c]) /
            2;
    vor_seeds_position(seeds, i, x);
    if (vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE || !seeds->policy.keep_border)
        return 1;
    vor_surface_put(&scratch->here.surface, x);
    vor_seeds_border(seeds, scratch, &scratch->here, &border, x);
    if (!vor_boundary_outside(&border, VOR_OUTSIDE_IN_RESULT, x) &&
        !(remesh->how.keep_holes && vor_seeds_hold(seeds, scratch, i, x)))
        return 1;
    memcpy(at, before, sizeof before);
    return 0;
}

/* Takes away the triangles of an edge over a hole. */
static void open_at(struct remesh *remesh, const struct edge *edge)
{
    struct vor_complex *complex = &remesh->complex;

    for (unsigned t = complex->degree[edge->end[0]]; t-- > 0;) {
        uint32_t other[2], at = complex->around[(size_t)edge->end[0] * VOR_AROUND_MOST + t];

        vor_complex_others(complex, at, edge->end[0], other);
        if (other[0] == edge->end[1] || other[1] == edge->end[1])
            vor_complex_remove(complex, at);
    }
    remesh->opened = 1;
}

/* Collapses short edges, each with a long one that is split: the point that goes comes back there.
 */
static vor_status trade(struct remesh *remesh, struct vor_scratch *scratch)
{
    float *xyz = remesh->seeds->xyz, x[3];
    size_t left = remesh->edges;
    vor_status status = VOR_OK;

    for (size_t e = 0;
         e < left && status == VOR_OK && (double)remesh->edge[e].length < COLLAPSE * remesh->l;
         e++) {
        struct edge from = remesh->edge[e];
        const struct edge *to = NULL;
        uint32_t i, third[2];

        status = e % POLL_EVERY == 0
                     ? vor_run_answered(vor_run_poll(&remesh->seeds->run), remesh->err)
                     : VOR_OK;
        if (status != VOR_OK || !collapses(remesh, &from, x))
            continue;
        i = from.end[1];
        while (to == NULL && left > e + 1 &&
               (double)remesh->edge[left - 1].length > SPLIT * remesh->l) {
            const struct edge *edge = &remesh->edge[--left];

            if (!splits(remesh, edge, &from))
                continue;
            if (comes_to(remesh, scratch, i, edge))
                to = edge;
            else
                open_at(remesh, edge);
        }
        if (to == NULL)
            break;
        memcpy(&xyz[3 * (size_t)from.end[0]], x, sizeof x);
        remesh->surrounded[i] =
            vor_complex_edge(&remesh->complex, to->end[0], to->end[1], third) == 2;
        remesh->moved[i] = remesh->moved[from.end[0]] = 1;
        status =
            vor_complex_split(&remesh->complex, to->end[0], to->end[1], i,
                              vor_complex_collapse(&remesh->complex, from.end[0], i), remesh->err);
    }
    return status;
}

static void trade_on_one(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end, unsigned worker)
{
    struct remesh *remesh = ctx;

    list_edges(remesh);
    balance(remesh);
    remesh->opened = 0;
    remesh->status = trade(remesh, &remesh->seeds->scratch[worker]);
}

static void flip_on_one(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end,
                        VOR_UNUSED unsigned worker)
{
    struct remesh *remesh = ctx;

    if (remesh->opened) /* leaves each point one fan */
        vor_complex_prune(&remesh->complex);
    for (size_t i = 0; remesh->opened && i < remesh->complex.n; i++)
        remesh->surrounded[i] = (unsigned char)vor_complex_surrounds(&remesh->complex, (uint32_t)i);
    (void)vor_flip(&remesh->complex, &remesh->sheet, remesh->surrounded);
}

/* Runs a part that needs one thread on the pool. */
static vor_status on_one(struct remesh *remesh, vor_task task)
{
    vor_status status = vor_run_for(&remesh->seeds->run, 1, 1, task, remesh, remesh->err);

    return status == VOR_OK ? remesh->status : status;
}

static vor_status step(struct vor_stage *stage, struct vor_error *err)
{
    struct remesh *remesh = stage->of;
    struct vor_seeds *seeds = remesh->seeds;
    struct vor_relax_how relax = {
        .steps = VOR_RELAX_STEPS, .aim = VOR_RELAX_MIDDLE, .keep_holes = remesh->how.keep_holes};
    size_t triangles = 0;
    double longest2 = 0;
    vor_status status;

    for (size_t i = 0; i < seeds->n; i++)
        triangles += remesh->complex.degree[i];
    if (triangles == 0)
        return VOR_OK;
    remesh->edge = vor_malloc(seeds->run.memory, triangles, sizeof *remesh->edge);
    if (remesh->edge == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    memset(remesh->moved, 0, seeds->n);
    memcpy(remesh->before, seeds->xyz, 3 * seeds->n * sizeof *seeds->xyz);
    remesh->status = VOR_OK;
    remesh->err = err;
    status = on_one(remesh, trade_on_one);
    vor_free(seeds->run.memory, remesh->edge);
    VOR_THEN(status, vor_sheet_put(&remesh->sheet, seeds, remesh->moved, &remesh->how, err));
    VOR_THEN(status, on_one(remesh, flip_on_one));
    /* At first triangles are far from equilateral, and turn over as edges push their corners. Delta
     * of bunny and igea to 5,000 where edges push after 1 / 3 iterations of 10: 0.0779 / 0.0728 and
     * 0.0721 / 0.0694. */
    if (stage->record.step >= stage->record.of / 3)
        relax.aim = VOR_RELAX_LENGTH;
    relax.length = remesh->l;
    VOR_THEN(status, vor_relax(&remesh->sheet, seeds, &remesh->complex, &relax, err));
    for (size_t i = 0; i < seeds->n; i++)
        if (!remesh->moved[i])
            longest2 = fmax(longest2, vor_distance2f(&seeds->xyz[3 * i], &remesh->before[3 * i]));
    stage->record.max_move = sqrt(longest2) * stage->domain->unit;
    vor_mesh_note(&stage->record, &remesh->complex, seeds->xyz);
    return status;
}

/* Joins the seeds by triangles. */
static vor_status join(struct remesh *remesh, struct vor_error *err)
{
    struct vor_seeds *seeds = remesh->seeds;
    struct vor_memory *memory = seeds->run.memory;
    uint64_t closed = 0;
    size_t joined = 0;
    vor_status status = vor_attach(seeds, &remesh->how.keep_holes, err);

    VOR_THEN(status, vor_seeds_index(seeds, &seeds->run, err));
    remesh->before = vor_malloc(memory, seeds->n, 3 * sizeof *remesh->before);
    remesh->moved = vor_malloc(memory, seeds->n, 1);
    remesh->surrounded = vor_malloc(memory, seeds->n, 1);
    if (status == VOR_OK &&
        (remesh->before == NULL || remesh->moved == NULL || remesh->surrounded == NULL))
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    VOR_THEN(status, vor_sheet_find(&remesh->sheet, seeds, &remesh->how, &seeds->run, err));
    VOR_THEN(status, vor_complex_init(&remesh->complex, seeds->n, memory, err));
    if (status == VOR_OK && seeds->n > VOR_AROUND_MOST) /* fewer have hardly an inside */
        status = vor_join(&remesh->complex, &remesh->sheet, 1, &closed, err);
    for (size_t i = 0; status == VOR_OK && i < seeds->n; i++) {
        remesh->surrounded[i] = (unsigned char)vor_complex_surrounds(&remesh->complex, (uint32_t)i);
        joined += remesh->complex.degree[i] > 0;
    }
    if (status == VOR_OK && seeds->n > VOR_AROUND_MOST && 2 * joined < seeds->n)
        status = vor_fail_param(err, VOR_E_DEGENERATE, "method",
                                "method=isotropic moves the corners of a triangulation, but "
                                "triangles join only %zu of %zu points: use method=cvt",
                                joined, seeds->n);
    return status;
}

static vor_status spread(struct vor_seeds *seeds, struct vor_outcome *told,
                         const struct vor_spec *spec, const struct vor_run *run,
                         struct vor_error *err)
{
    double before = vor_run_clock(run);
    int polishes = spec->value[VOR_PARAM_POLISH] > 0;
    struct remesh remesh = {.seeds = seeds,
                            .how = {.slack = VOR_SEEDS_SLACK},
                            .stage = {.spec = spec,
                                      .run = run,
                                      .told = told,
                                      .record = {.stage = VOR_RUN_STAGE_ITERATE,
                                                 .of = vor_spec_iterations(spec),
                                                 .ahead = vor_spec_polish(spec)},
                                      .of = &remesh,
                                      .step = step,
                                      .measure = vor_stage_measure,
                                      .measure_every = 1,
                                      .share = polishes ? VOR_STAGE_SHARE : 1,
                                      .unfinished = !vor_seeds_on_whole(seeds)}};
    vor_status status = join(&remesh, err);

    told->seconds_start += vor_run_clock(run) - before;
    VOR_THEN(status, vor_stage_of_seeds(&remesh.stage, seeds, err));
    vor_mesh_note(&remesh.stage.record, &remesh.complex, seeds->xyz);
    VOR_THEN(status, vor_stage_run(&remesh.stage, err));
    vor_stage_free(&remesh.stage);
    vor_complex_free(&remesh.complex);
    vor_sheet_free(&remesh.sheet);
    VOR_FREE_ALL(seeds->run.memory, remesh.surrounded, remesh.moved, remesh.before);
    return status;
}

vor_status vor_remesh_run(struct vor_seeds *out, struct vor_outcome *told,
                          const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                          const struct vor_run *run, struct vor_error *err)
{
    const struct vor_coarse_how how = {spread, spec, run};
    struct vor_domain thin = {.n = 0}; /* of a dense input: most of the work is done on it */
    struct vor_seeds seeds = {.n = 0};
    double before = vor_run_clock(run);
    struct vor_spec shorter;
    int is_spread = vor_checkpoint_is(run);
    vor_status status = is_spread ? vor_checkpoint_seeds(&seeds, told, domain, run, err)
                                  : vor_coarse_start(&seeds, domain, n, &how, err);

    VOR_THEN(status, vor_domain_thin_for(&thin, domain, n, seeds.area, &seeds.run, err));
    if (status == VOR_OK && thin.n >= seeds.input_lists.wide)
        status = vor_seeds_onto(&seeds, &thin, err);
    told->seconds_start = vor_run_clock(run) - before;
    shorter = vor_coarse_shorten(spec, &seeds);
    if (status == VOR_OK && !is_spread && !(seeds.coherence > 0 && seeds.track == NULL))
        status = spread(&seeds, told, &shorter, run, err);
    VOR_THEN(status, vor_polish(&seeds, told, &shorter, run, err));
    vor_domain_free(&thin);
    if (status == VOR_OK)
        *out = seeds;
    else
        vor_seeds_free(&seeds);
    return status;
}
