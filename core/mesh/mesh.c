#include "core/mesh/mesh.h"

#include "core/mesh/carry.h"
#include "core/mesh/crossing.h"
#include "core/mesh/describe.h"
#include "core/mesh/exact.h"
#include "core/mesh/facing.h"
#include "core/mesh/flip.h"
#include "core/mesh/join.h"
#include "core/mesh/meeting.h"
#include "core/mesh/relax.h"
#include "core/mesh/repair.h"
#include "core/mesh/worst.h"
#include "core/seeds/attach.h"

#include <string.h>

/* Times that the front advances before points move, anew around loops that could not be closed, and
 * where edges are still open after they moved, which lie better then. Open edges of a screw and of
 * folds with as many input points without the latter / with it: 16 / 0, 1 / 0. */
static const int fronts[] = {2, 1};

struct making {
    struct vor_seeds *seeds;
    const struct vor_mesh_how *how;
    struct vor_report *report;
    struct vor_sheet sheet;
    struct vor_complex complex;
    struct vor_mesh *out;
};

static void flip(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct making *making = ctx;

    (void)vor_flip(&making->complex, &making->sheet, NULL);
}

/* Copies the triangles that are there, each from its first point on. */
static vor_status hand_out(struct making *making, struct vor_error *err)
{
    const struct vor_complex *complex = &making->complex;
    struct vor_mesh *out = making->out;
    uint32_t *to;

    out->memory = complex->memory;
    to = out->triangle = vor_malloc(out->memory, making->report->mesh_triangles, 3 * sizeof *to);
    if (to == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", complex->count);
    out->count = making->report->mesh_triangles;
    for (size_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * t];

        if (corner[0] == VOR_COMPLEX_GONE)
            continue;
        memcpy(to, corner, 3 * sizeof *to);
        to += 3;
    }
    return VOR_OK;
}

static vor_status finish(void *ctx, struct vor_error *err)
{
    struct making *making = ctx;
    struct vor_rims rims = {.count = 0};
    struct vor_facing facing = {0, 0};
    vor_status status = vor_facing_turn(&making->complex, &facing, making->seeds->xyz, err);

    VOR_THEN(status, vor_rims_find(&rims, &making->complex, &making->sheet, err));
    VOR_THEN(status,
             vor_mesh_describe(making->report, &making->complex, &rims, &making->sheet, err));
    VOR_THEN(status, hand_out(making, err));
    making->report->mesh_components = facing.components;
    making->report->mesh_one_sided = facing.one_sided;
    vor_rims_free(&rims);
    return status;
}

/* Whether the triangulation may be repaired: points that change places keep their sheet, density
 * and number. */
static int may_repair(const struct making *making)
{
    const struct vor_seeds *seeds = making->seeds;

    return making->how->repairs && making->sheet.graph == NULL && seeds->wanted.value == NULL &&
           seeds->track == NULL;
}

/* Draws in points that hang in the air: before a repair, all of them. In one, those where the mesh
 * is smooth lie over a gap of the sampling: of an armadillo's 100,000 points to 30,000, such ones
 * that were drawn in left triangles of 33 and 35 degrees. */
static vor_status attach_hanging(struct making *making, int repairs, struct vor_error *err)
{
    struct vor_seeds *seeds = making->seeds;
    unsigned char *smooth;
    vor_status status;

    if (!repairs)
        return vor_attach_hanging(seeds, NULL, err);
    smooth = vor_malloc(seeds->run.memory, seeds->n, 1);
    if (smooth == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    for (uint32_t i = 0; i < seeds->n; i++)
        smooth[i] = vor_complex_surrounds(&making->complex, i) &&
                    vor_relax_is_smooth(&making->complex, &making->sheet, i);
    status = vor_attach_hanging(seeds, smooth, err);
    vor_free(seeds->run.memory, smooth);
    return status;
}

/* Flips edges and moves the corners of the triangles from `since` on, at last onto the input where
 * sheets are near each other. May repair the triangulation before each flip; before that, one round
 * is enough, and the points move in as many steps after the first repair and twice as many after
 * the second. Two rounds before and twice as many steps after each repair, three by size / one
 * round and half the steps, two by size, mean quality and delta: fandisk to 10,000 .9720, .0653 /
 * .9711, .0642; torus .9756, .0359 / .9749, .0353. As few steps after both repairs, fandisk .9699,
 * .0616. After repairs, sizes of triangles that are not near creases count too: strain does not see
 * them, and leaves cells less even than no repair does. No repair / repair by strain alone, with
 * twice the steps, / this, eta, delta and mean quality: sphere to 5,072 .0047, .0401, .9725 /
 * .0061, .0510, .9762 / .0038, .0369, .9718. With a step less by size, igea to 20,000, three seeds,
 * .0066, .0395, .9776 instead of .0065, .0388, .9771. With no regard to creases the quality of
 * fandisk is .966. Without steps near them at last, seeds 2 and 5 .9695 and .9707 instead of .9703
 * and .9721. */
static vor_status improve(struct making *making, size_t since, int repairs, struct vor_error *err)
{
    const struct vor_recall recall = {.slack = VOR_SEEDS_SLACK, .refine = making->how->refine};
    struct vor_relax_how how = {.fixed = making->how->fixed,
                                .refine = making->how->refine,
                                .since = since,
                                .creases = (unsigned)repairs};
    int rounds = !repairs && may_repair(making) ? 1 : VOR_RELAX_ROUNDS;
    vor_status status = VOR_OK;

    for (int round = 0; round < rounds && status == VOR_OK; round++) {
        how.steps = (unsigned)(repairs ? 1 + round : 1) * VOR_RELAX_STEPS;
        if (repairs)
            status = vor_repair(&making->complex, &making->sheet, making->seeds, making->how->fixed,
                                &recall, err);
        VOR_THEN(status, vor_run_rows(&making->seeds->run, 1, 1, flip, making, err));
        VOR_THEN(status, vor_relax(&making->sheet, making->seeds, &making->complex, &how, err));
    }
    if (repairs) {
        how.creases = VOR_RELAX_ROUNDS * how.steps + VOR_RELAX_STEPS;
        how.aim = VOR_RELAX_SIZE;
        how.steps = VOR_RELAX_STEPS;
        how.after = VOR_RELAX_ROUNDS * VOR_RELAX_STEPS;
        VOR_THEN(status, vor_relax(&making->sheet, making->seeds, &making->complex, &how, err));
    }
    VOR_THEN(status, vor_attach_last(making->seeds, err));
    VOR_THEN(status, attach_hanging(making, repairs, err));
    if (repairs && status == VOR_OK)
        status = vor_worst_improve(&making->complex, &making->sheet, making->seeds,
                                   making->how->fixed, &recall, err);
    return status == VOR_OK ? vor_exact_put(&making->sheet, making->seeds, making->how->fixed, err)
                            : status;
}

static size_t count(const struct vor_complex *complex)
{
    size_t there = 0;

    for (size_t t = 0; t < complex->count; t++)
        there += complex->triangle[3 * t] != VOR_COMPLEX_GONE;
    return there;
}

/* Whether sheets may be nearer to each other than the spacing, on most of the input. */
static int may_meet(const struct making *making)
{
    const struct vor_conditioning *known = &making->seeds->domain->known;

    return making->sheet.graph != NULL && known->parted && known->sheets;
}

/* The same; what passes through others by it is undone, or left out, and is joined again. */
static vor_status better(struct making *making, size_t since, int repairs, struct vor_error *err)
{
    struct vor_seeds *seeds = making->seeds;
    struct vor_memory *memory = seeds->run.memory;
    float *before;
    size_t there;
    vor_status status;

    if (!may_meet(making))
        return improve(making, since, repairs, err);
    before = vor_malloc(memory, seeds->n, 3 * sizeof *before);
    if (before == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    memcpy(before, seeds->xyz, seeds->n * 3 * sizeof *before);
    status = improve(making, since, repairs, err);
    there = count(&making->complex);
    VOR_THEN(status, vor_crossing_drop(&making->complex, seeds, &making->sheet, before, err));
    making->report->mesh_left_out = there - count(&making->complex);
    vor_free(memory, before);
    return status;
}

/* Leaves out triangles where sheets meet, and then what passes through others, if it was not looked
 * for before: the wrong ones among the former would take right ones with them. */
static vor_status leave_out(struct making *making, struct vor_error *err)
{
    struct vor_complex *complex = &making->complex;
    struct vor_seeds *seeds = making->seeds;
    size_t before = count(complex);
    vor_status status;

    if (!may_meet(making))
        return VOR_OK;
    status = vor_meeting_drop(complex, &making->sheet, &seeds->run, err);
    if (!making->how->moves)
        VOR_THEN(status, vor_crossing_drop(complex, seeds, &making->sheet, NULL, err));
    making->report->mesh_left_out += before - count(complex);
    return status;
}

static int is_closed(const struct vor_complex *complex)
{
    for (size_t t = 0; t < complex->count; t++)
        for (int c = 0; c < 3 && complex->triangle[3 * t] != VOR_COMPLEX_GONE; c++)
            if (vor_complex_is_open(complex, t, c))
                return 0;
    return 1;
}

static vor_status make(struct making *making, struct vor_error *err)
{
    struct vor_seeds *seeds = making->seeds;
    const struct vor_run *run = &seeds->run;
    const struct vor_recall recall = {.slack = VOR_SEEDS_SLACK, .refine = making->how->refine};
    int moves = making->how->moves;
    vor_status status = moves ? vor_attach_hanging(seeds, NULL, err) : VOR_OK;

    VOR_THEN(status, vor_seeds_index(seeds, run, err));
    if (status == VOR_OK)
        status = vor_sheet_find(&making->sheet, seeds, moves ? &recall : NULL, run, err);
    VOR_THEN(status, vor_complex_init(&making->complex, seeds->n, run->memory, err));
    for (size_t k = 0; k < (moves ? sizeof fronts / sizeof *fronts : 1) && status == VOR_OK; k++) {
        size_t since = making->complex.count;

        if (since > 0 && is_closed(&making->complex))
            break;
        status = vor_join(&making->complex, &making->sheet, fronts[k], &making->report->mesh_filled,
                          err);
        if (status == VOR_OK && moves)
            status = better(making, since, 0, err);
    }
    if (status == VOR_OK && moves && may_repair(making))
        status = better(making, 0, 1, err);
    VOR_THEN(status, leave_out(making, err));
    return status == VOR_OK ? vor_run_call(run, finish, making, err) : status;
}

/* The same; normals that the method found stay where they were as the points move. */
static vor_status make_with_normals(struct making *making, struct vor_error *err)
{
    struct vor_seeds *seeds = making->seeds;
    struct vor_memory *memory = seeds->run.memory;
    float *before;
    vor_status status;

    if (!making->how->moves || seeds->normal == NULL)
        return make(making, err);
    before = vor_malloc(memory, seeds->n, 3 * sizeof *before);
    if (before == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    memcpy(before, seeds->xyz, 3 * seeds->n * sizeof *before);
    status = make(making, err);
    VOR_THEN(status, vor_carry_normals(seeds, &making->complex, before, err));
    vor_free(memory, before);
    if (status != VOR_OK)
        vor_mesh_free(making->out);
    return status;
}

vor_status vor_mesh_make(struct vor_mesh *out, struct vor_report *report, struct vor_seeds *seeds,
                         const struct vor_mesh_how *how, struct vor_error *err)
{
    struct making making = {.seeds = seeds, .how = how, .report = report, .out = out};
    vor_status status = VOR_OK;

    report->has_mesh = 1;
    report->mesh_manifold = VOR_YES;
    if (seeds->n >= 3)
        status = make_with_normals(&making, err);
    vor_complex_free(&making.complex);
    vor_sheet_free(&making.sheet);
    return status;
}

vor_status vor_mesh_reorder(struct vor_mesh *mesh, const uint32_t *order, size_t n,
                            struct vor_error *err)
{
    uint32_t *place = vor_malloc(mesh->memory, n, sizeof *place);

    if (place == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t k = 0; k < n; k++)
        place[order[k]] = (uint32_t)k;
    for (size_t c = 0; c < 3 * mesh->count; c++)
        mesh->triangle[c] = place[mesh->triangle[c]];
    vor_free(mesh->memory, place);
    return VOR_OK;
}
