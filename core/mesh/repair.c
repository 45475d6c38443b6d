#include "core/mesh/repair.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"
#include "core/mesh/relax.h"

#include <stdlib.h>
#include <string.h>

/* Points of a patch. Three rings around a point of a lattice, and itself, are 37. */
enum { PATCH_SIZE = 64 };

/* Rings of points that move. At 2 / 3, fandisk to 10,000 and armadillo to 30,000: points without
 * six triangles 1,031 / 1,022 and 2,441 / 2,470, CPU of a repair 0.12 / 0.44 and 0.32 / 0.94 s. */
enum { RINGS = 2 };

/* Most triangles of a point after an operation. */
enum { DEGREE_MOST = VOR_AROUND_MOST / 2 };

/* What is tried. */
enum operation { FLIPS, COLLAPSE, SPLIT };

/* Faults of a lone pair of points with five and seven triangles, which its patch cannot lose. */
enum { PAIR = 1 + 1 };

/* What operations do not change around a point. */
struct ground {
    unsigned char wants[PATCH_SIZE];    /* triangles that each point should have */
    unsigned char moves[PATCH_SIZE];    /* of enum vor_relax_motion */
    uint32_t id[PATCH_SIZE];            /* VOR_COMPLEX_GONE: the point that a split brings */
    uint32_t triangle[2 * PATCH_SIZE];  /* numbers of the triangles in the complex */
    struct vor_frame frame[PATCH_SIZE]; /* the normals face as the triangles do */
    struct vor_surface surface[PATCH_SIZE];
};

/* Triangles around a point. Row a of `third` has at b the third corner, counted from 1, of the
 * triangle that runs from a to b; 0: there is none. */
struct patch {
    struct ground *on;
    unsigned n, inner;                /* the first `inner` are the point and a ring */
    unsigned count;                   /* triangles that are listed */
    unsigned faults;                  /* of count_faults */
    double strain, along;             /* of measure */
    unsigned char degree[PATCH_SIZE]; /* of all triangles of the point, 0 after a collapse */
    float xyz[3 * PATCH_SIZE];
    unsigned char third[PATCH_SIZE][PATCH_SIZE];
    unsigned char corner[2 * PATCH_SIZE][3]; /* the triangles, listed */
};

/* A collapse or a split that pays. */
struct candidate {
    double gain;
    uint32_t center;
    unsigned end[2]; /* of an edge, as they are numbered in the patch */
};

struct repair {
    struct vor_complex *complex;
    struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    size_t fixed;
    const struct vor_recall *how;
    unsigned char *place; /* n: place in the patch, from 1 on; 0 else */
    unsigned char *moved; /* n: a patch with the point was replaced */
    unsigned char *seen;  /* n: the point was near the middle of a patch */
    struct patch *of[2];  /* as they are, and on trial: two of each, for a pair */
    struct patch *trial[2];
    struct candidate *found[2]; /* collapses, splits */
    size_t count[2], room;
    vor_status status; /* of what ran on the pool's thread */
    struct vor_error *err;
};

static void set_triangle(struct patch *patch, unsigned a, unsigned b, unsigned c)
{
    patch->third[a][b] = (unsigned char)(c + 1);
    patch->third[b][c] = (unsigned char)(a + 1);
    patch->third[c][a] = (unsigned char)(b + 1);
}

static void clear_triangle(struct patch *patch, unsigned a, unsigned b, unsigned c)
{
    patch->third[a][b] = patch->third[b][c] = patch->third[c][a] = 0;
}

static int is_joined(const struct patch *patch, unsigned a, unsigned b)
{
    return patch->third[a][b] != 0 || patch->third[b][a] != 0;
}

static int off2(const struct patch *patch, unsigned a, int more)
{
    int off = patch->degree[a] + more - patch->on->wants[a];

    return off * off;
}

/* Counts triangles too many or too few, squared. */
static void count_faults(struct patch *patch)
{
    patch->faults = 0;
    for (unsigned a = 0; a < patch->n; a++)
        patch->faults += patch->degree[a] > 0 ? (unsigned)off2(patch, a, 0) : 0;
}

static void list_triangles(struct patch *patch)
{
    patch->count = 0;
    for (unsigned a = 0; a < patch->n; a++)
        for (unsigned b = a + 1; b < patch->n; b++) {
            unsigned c = patch->third[a][b];

            if (c <= a + 1)
                continue;
            patch->corner[patch->count][0] = (unsigned char)a;
            patch->corner[patch->count][1] = (unsigned char)b;
            patch->corner[patch->count++][2] = (unsigned char)(c - 1);
        }
}

/* Sums up the squares of how far the listed triangles' strains are above 1, and finds the least
 * cosine of the normal of one and that of a corner that is on no crease. */
static void measure(struct patch *patch)
{
    patch->strain = 0;
    patch->along = 1;
    for (unsigned t = 0; t < patch->count; t++) {
        const unsigned char *of = patch->corner[t];
        const uint32_t corner[3] = {of[0], of[1], of[2]};
        double strain = vor_triangle_strain(patch->xyz, corner), normal[3], length, up;

        patch->strain += (strain - 1) * (strain - 1);
        vor_triangle_normal(normal, patch->xyz, corner);
        length = sqrt(vor_dot(normal, normal));
        for (int c = 0; c < 3; c++) {
            up = length > 0 ? vor_dot(normal, patch->on->frame[of[c]].axis[2]) / length : -1;
            patch->along =
                patch->on->moves[of[c]] == VOR_RELAX_ALONG ? patch->along : fmin(patch->along, up);
        }
    }
}

/* Adds a point to the patch. Returns whether there was room. */
static int take(struct repair *repair, struct patch *patch, uint32_t i)
{
    size_t row = 3 * (size_t)i;

    if (repair->place[i] > 0)
        return 1;
    if (patch->n + 1 >= PATCH_SIZE) /* one is for a split */
        return 0;
    patch->on->id[patch->n] = i;
    patch->degree[patch->n] = repair->complex->degree[i];
    patch->on->wants[patch->n] = vor_complex_surrounds(repair->complex, i) ? 6 : 3;
    patch->on->moves[patch->n] = 0;
    memcpy(&patch->xyz[3 * (size_t)patch->n], &repair->seeds->xyz[row], 3 * sizeof(float));
    vor_frame_of(&patch->on->frame[patch->n], &repair->sheet->normal[row]);
    repair->place[i] = (unsigned char)++patch->n;
    return 1;
}

/* Adds the triangles of a point. Returns whether they face alike and all is a manifold. */
static int take_triangles(struct repair *repair, struct patch *patch, uint32_t i)
{
    const struct vor_complex *complex = repair->complex;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];
        const uint32_t *corner = &complex->triangle[3 * (size_t)at];
        unsigned c[3];

        for (int e = 0; e < 3; e++) {
            if (!take(repair, patch, corner[e]))
                return 0;
            c[e] = repair->place[corner[e]] - 1u;
        }
        if (patch->third[c[0]][c[1]] == c[2] + 1) /* it is there */
            continue;
        if (patch->third[c[0]][c[1]] != 0 || patch->third[c[1]][c[2]] != 0 ||
            patch->third[c[2]][c[0]] != 0 || patch->count == 2 * PATCH_SIZE)
            return 0;
        set_triangle(patch, c[0], c[1], c[2]);
        patch->on->triangle[patch->count++] = at;
    }
    return 1;
}

/* Turns the normals as the triangles face. */
static void turn_normals(struct patch *patch)
{
    double up[PATCH_SIZE] = {0};

    for (unsigned t = 0; t < patch->count; t++) {
        const unsigned char *of = patch->corner[t];
        const uint32_t corner[3] = {of[0], of[1], of[2]};
        double normal[3];

        vor_triangle_normal(normal, patch->xyz, corner);
        for (int c = 0; c < 3; c++)
            up[of[c]] += vor_dot(normal, patch->on->frame[of[c]].axis[2]);
    }
    for (unsigned a = 0; a < patch->n; a++)
        for (int c = 0; c < 3 && up[a] < 0; c++)
            patch->on->frame[a].axis[2][c] = -patch->on->frame[a].axis[2][c];
}

/* Fills the patch around point i. Returns whether there is one. */
static int gather(struct repair *repair, struct patch *patch, uint32_t i, unsigned worker)
{
    struct vor_seeds *seeds = repair->seeds;
    unsigned begin = 0, end;
    int whole;

    patch->n = patch->count = patch->inner = 0;
    memset(patch->third, 0, sizeof patch->third);
    whole = take(repair, patch, i);
    for (unsigned ring = 0; ring <= RINGS && whole; ring++, begin = end) {
        end = patch->n;
        if (ring < RINGS)
            patch->inner = end;
        for (unsigned k = begin; k < end && whole; k++) {
            uint32_t j = patch->on->id[k];
            int is_free = vor_relax_is_free(repair->complex, repair->sheet, j);

            if (patch->on->wants[k] != 6 || j + repair->fixed >= seeds->n ||
                vor_seeds_recall(seeds, &seeds->scratch[worker], j, repair->how) ==
                    VOR_SURFACE_NONE)
                continue;
            patch->on->moves[k] = is_free ? VOR_RELAX_FREE : VOR_RELAX_ALONG;
            if (!is_free)
                vor_relax_axes(patch->on->frame[k].axis, repair->complex, seeds->xyz, j);
            patch->on->surface[k] = seeds->scratch[worker].onto;
            whole = take_triangles(repair, patch, j);
        }
    }
    for (unsigned k = 0; k < patch->n; k++)
        repair->place[patch->on->id[k]] = 0;
    if (!whole || patch->count == 0)
        return 0;
    count_faults(patch);
    list_triangles(patch);
    turn_normals(patch);
    measure(patch);
    return 1;
}

/* Flips the edge from a to b if that brings points nearer to six triangles, and marks those that
 * have more or fewer then. Returns whether it did. */
static int flip(struct patch *patch, unsigned char *changed, unsigned a, unsigned b)
{
    unsigned c = patch->third[a][b] - 1u, d = patch->third[b][a] - 1u;

    if (patch->third[a][b] == 0 || patch->third[b][a] == 0 || c == d ||
        !(patch->on->moves[c] || patch->on->moves[d]) || is_joined(patch, c, d) ||
        patch->degree[a] <= 3 || patch->degree[b] <= 3 || patch->degree[c] >= DEGREE_MOST ||
        patch->degree[d] >= DEGREE_MOST ||
        off2(patch, a, -1) + off2(patch, b, -1) + off2(patch, c, 1) + off2(patch, d, 1) >=
            off2(patch, a, 0) + off2(patch, b, 0) + off2(patch, c, 0) + off2(patch, d, 0))
        return 0;
    patch->third[a][b] = patch->third[b][a] = 0;
    set_triangle(patch, a, d, c);
    set_triangle(patch, d, b, c);
    patch->degree[a]--;
    patch->degree[b]--;
    patch->degree[c]++;
    patch->degree[d]++;
    changed[a] = changed[b] = changed[c] = changed[d] = 1;
    return 1;
}

/* Shrinks the edge from a to b to its middle, or to a where a alone is on a crease. Returns whether
 * that may be. */
static int collapse(struct patch *patch, unsigned a, unsigned b)
{
    unsigned c = patch->third[a][b] - 1u, d = patch->third[b][a] - 1u, common = 0;

    if (patch->third[a][b] == 0 || patch->third[b][a] == 0 || !patch->on->moves[a] ||
        !patch->on->moves[b] || patch->degree[c] <= 3 || patch->degree[d] <= 3 ||
        patch->degree[a] + patch->degree[b] - 4 > DEGREE_MOST)
        return 0;
    for (unsigned x = 0; x < patch->n; x++)
        common += is_joined(patch, a, x) && is_joined(patch, b, x);
    if (common != 2)
        return 0;
    clear_triangle(patch, a, b, c);
    clear_triangle(patch, b, a, d);
    for (unsigned x = 0; x < patch->n; x++)
        if (patch->third[b][x] != 0) {
            unsigned y = patch->third[b][x] - 1u;

            clear_triangle(patch, b, x, y);
            set_triangle(patch, a, x, y);
        }
    patch->degree[a] = (unsigned char)(patch->degree[a] + patch->degree[b] - 4);
    patch->degree[b] = 0;
    patch->degree[c]--;
    patch->degree[d]--;
    for (size_t e = 0; e < 3 && patch->on->moves[a] == patch->on->moves[b]; e++)
        patch->xyz[3 * (size_t)a + e] =
            (patch->xyz[3 * (size_t)a + e] + patch->xyz[3 * (size_t)b + e]) / 2;
    return 1;
}

/* Puts a point on the middle of the edge from a to b. Returns whether that may be. */
static int split(struct patch *patch, unsigned a, unsigned b)
{
    unsigned c = patch->third[a][b] - 1u, d = patch->third[b][a] - 1u, m = patch->n;

    if (patch->third[a][b] == 0 || patch->third[b][a] == 0 || !patch->on->moves[a] ||
        patch->degree[c] >= DEGREE_MOST || patch->degree[d] >= DEGREE_MOST)
        return 0;
    patch->n++;
    patch->third[a][b] = patch->third[b][a] = 0;
    set_triangle(patch, a, m, c);
    set_triangle(patch, m, b, c);
    set_triangle(patch, b, m, d);
    set_triangle(patch, m, a, d);
    patch->degree[m] = 4;
    patch->degree[c]++;
    patch->degree[d]++;
    patch->on->wants[m] = 6;
    patch->on->moves[m] = patch->on->moves[a];
    patch->on->id[m] = VOR_COMPLEX_GONE;
    patch->on->frame[m] = patch->on->frame[a];
    patch->on->surface[m] = patch->on->surface[a];
    for (size_t e = 0; e < 3; e++)
        patch->xyz[3 * (size_t)m + e] =
            (patch->xyz[3 * (size_t)a + e] + patch->xyz[3 * (size_t)b + e]) / 2;
    return 1;
}

/* Moves the points of a patch, whose triangles are listed. */
static void relax(struct patch *patch, unsigned steps)
{
    for (unsigned step = 0; step < steps; step++) {
        struct vor_relax_pull pull[PATCH_SIZE];

        memset(pull, 0, patch->n * sizeof *pull);
        for (unsigned t = 0; t < patch->count; t++)
            for (int c = 0; c < 3; c++) {
                unsigned a = patch->corner[t][c];

                if (patch->on->moves[a])
                    vor_relax_add(&pull[a], &patch->on->frame[a], &patch->xyz[3 * (size_t)a],
                                  &patch->xyz[3 * (size_t)patch->corner[t][(c + 1) % 3]],
                                  &patch->xyz[3 * (size_t)patch->corner[t][(c + 2) % 3]]);
            }
        for (unsigned a = 0; a < patch->n; a++) {
            double x[3], by[2];

            if (!patch->on->moves[a] || patch->degree[a] == 0)
                continue;
            if (patch->on->moves[a] == VOR_RELAX_ALONG)
                vor_relax_hold(&pull[a]);
            vor_relax_step(by, &pull[a]);
            for (int c = 0; c < 3; c++)
                x[c] = (double)patch->xyz[3 * (size_t)a + (size_t)c] +
                       by[0] * patch->on->frame[a].axis[0][c] +
                       by[1] * patch->on->frame[a].axis[1][c];
            vor_surface_put(&patch->on->surface[a], x);
            vor_to_floats(&patch->xyz[3 * (size_t)a], x);
        }
    }
}

/* Flips edges of triangles at points that have not as many as in `before`, and at those that flips
 * change; where `before` is the patch itself, at all points. */
static void flip_around(struct patch *patch, const struct patch *before)
{
    unsigned char changed[PATCH_SIZE];
    int again = 1;

    for (unsigned a = 0; a < patch->n; a++)
        changed[a] = patch == before || patch->degree[a] != before->degree[a];
    for (unsigned round = 0; round < DEGREE_MOST && again; round++) {
        again = 0;
        for (unsigned a = 0; a < patch->n; a++) {
            int look = changed[a];

            changed[a] = 0;
            for (unsigned b = 0; b < patch->n && look; b++) {
                unsigned c = patch->third[a][b];

                if (c > 0)
                    again |= flip(patch, changed, a, b) || flip(patch, changed, b, c - 1);
            }
        }
    }
}

/* Makes *trial what the operation at the edge from a to b makes of the patch. Returns whether it
 * has at most so many faults, and better triangles. The worst may be worse, as vor_worst_improve
 * comes at last: where not, fandisk keeps, seeds 2 and 5, 607 and 624 cells without six sides
 * instead of 591 and 584. */
static int attempt(struct patch *trial, const struct patch *patch, enum operation operation,
                   const unsigned end[2], unsigned most)
{
    int freer = patch->on->moves[end[0]] - patch->on->moves[end[1]];

    *trial = *patch;
    if ((operation == COLLAPSE && !collapse(trial, end[freer > 0], end[freer <= 0])) ||
        (operation == SPLIT && !split(trial, end[freer < 0], end[freer >= 0])))
        return 0;
    flip_around(trial, operation == FLIPS ? trial : patch);
    count_faults(trial);
    if (trial->faults > most)
        return 0;
    list_triangles(trial);
    relax(trial, VOR_RELAX_STEPS);
    measure(trial);
    if (trial->strain > patch->strain) /* more steps hardly help */
        return 0;
    relax(trial, 2 * VOR_RELAX_STEPS);
    measure(trial);
    return trial->strain < patch->strain && trial->along >= fmin(patch->along, VOR_SAME_WAY);
}

/* Replaces the patch by the one on trial. The point that a collapse took away is *spare, that which
 * a split brings becomes it. */
static vor_status replace(struct repair *repair, const struct patch *patch,
                          const struct patch *trial, uint32_t *spare)
{
    vor_status status = VOR_OK;

    for (unsigned t = 0; t < patch->count; t++)
        vor_complex_remove(repair->complex, patch->on->triangle[t]);
    for (unsigned t = 0; t < trial->count && status == VOR_OK; t++) {
        uint32_t corner[3];

        for (int c = 0; c < 3; c++) {
            corner[c] = trial->on->id[trial->corner[t][c]];
            corner[c] = corner[c] == VOR_COMPLEX_GONE ? *spare : corner[c];
        }
        status = vor_complex_add(repair->complex, corner, repair->err);
    }
    for (unsigned a = 0; a < trial->n; a++) {
        uint32_t i = trial->on->id[a] == VOR_COMPLEX_GONE ? *spare : trial->on->id[a];

        if (trial->degree[a] == 0)
            *spare = i;
        repair->moved[i] = 1;
        memcpy(&repair->seeds->xyz[3 * (size_t)i], &trial->xyz[3 * (size_t)a], 3 * sizeof(float));
    }
    return status;
}

/* Whether a collapse or a split at the edge from a to b may mend a fault. */
static int is_faulty(const struct patch *patch, unsigned a, unsigned b)
{
    unsigned corner[4] = {a, b, patch->third[a][b] - 1u, patch->third[b][a] - 1u};
    int faulty = 0;

    for (int c = 0; c < 4 && patch->third[a][b] != 0 && patch->third[b][a] != 0; c++)
        faulty |= patch->degree[corner[c]] != patch->on->wants[corner[c]];
    return faulty;
}

/* Flips the edges around point i if that pays, and finds the best collapse and split there. */
static vor_status look_at(struct repair *repair, uint32_t i, unsigned worker)
{
    struct patch *patch = repair->of[0], *trial = repair->trial[0];
    struct candidate best[2] = {{0, i, {0, 0}}, {0, i, {0, 0}}};
    unsigned most[2], end[2] = {0, 0};
    uint32_t none = VOR_COMPLEX_GONE;
    int is_there = gather(repair, patch, i, worker) && patch->faults > PAIR;

    for (unsigned k = 0; k < patch->inner && is_there; k++)
        repair->seen[patch->on->id[k]] = 1;
    if (is_there && attempt(trial, patch, FLIPS, end, patch->faults - 1)) {
        vor_status status = replace(repair, patch, trial, &none);

        if (status != VOR_OK)
            return status;
        is_there = gather(repair, patch, i, worker) && patch->faults > 0;
    }
    if (!is_there)
        return VOR_OK;
    most[0] = most[1] = patch->faults - 1;
    for (end[0] = 0; end[0] < patch->inner; end[0]++)
        for (end[1] = end[0] + 1; end[1] < patch->inner; end[1]++)
            for (int k = 0; k < 2 && is_faulty(patch, end[0], end[1]); k++)
                if (attempt(trial, patch, k == 0 ? COLLAPSE : SPLIT, end, most[k])) {
                    best[k].gain = patch->strain - trial->strain;
                    memcpy(best[k].end, end, sizeof end);
                    most[k] = trial->faults - (trial->faults > 0);
                }
    for (int k = 0; k < 2; k++)
        if (best[k].gain > 0 && repair->count[k] < repair->room)
            repair->found[k][repair->count[k]++] = best[k];
    return VOR_OK;
}

/* Most gain first; of as much, that of the smaller point. */
static int gains_more(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;

    if (x->gain < y->gain || x->gain > y->gain)
        return x->gain > y->gain ? -1 : 1;
    return x->center < y->center ? -1 : x->center > y->center;
}

/* Finds the next candidate that still holds, from *next on; none after a failure. */
static int holds(struct repair *repair, int k, size_t *next, unsigned worker)
{
    while (*next < repair->count[k]) {
        const struct candidate *found = &repair->found[k][(*next)++];

        repair->status = vor_run_answered(vor_run_poll(&repair->seeds->run), repair->err);
        if (repair->status != VOR_OK)
            return 0;
        if (gather(repair, repair->of[k], found->center, worker) && repair->of[k]->faults > 0 &&
            attempt(repair->trial[k], repair->of[k], k == 0 ? COLLAPSE : SPLIT, found->end,
                    repair->of[k]->faults - 1))
            return 1;
    }
    return 0;
}

static int overlap(const struct patch *a, const struct patch *b)
{
    for (unsigned i = 0; i < a->n; i++)
        for (unsigned j = 0; j < b->n; j++)
            if (a->on->id[i] == b->on->id[j])
                return 1;
    return 0;
}

/* Makes collapses and splits in pairs. */
static void trade(struct repair *repair, unsigned worker)
{
    size_t next[2] = {0, 0};

    for (int k = 0; k < 2; k++)
        qsort(repair->found[k], repair->count[k], sizeof *repair->found[k], gains_more);
    while (repair->status == VOR_OK && holds(repair, 0, &next[0], worker)) {
        uint32_t spare = VOR_COMPLEX_GONE;

        do {
            if (!holds(repair, 1, &next[1], worker))
                return;
        } while (overlap(repair->of[0], repair->of[1]));
        repair->status = replace(repair, repair->of[0], repair->trial[0], &spare);
        if (repair->status == VOR_OK)
            repair->status = replace(repair, repair->of[1], repair->trial[1], &spare);
    }
}

static void repair_on_one(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end,
                          unsigned worker)
{
    struct repair *repair = ctx;
    const struct vor_complex *complex = repair->complex;

    for (uint32_t i = 0; i < complex->n && repair->status == VOR_OK; i++)
        if (complex->degree[i] > 0 && complex->degree[i] != 6 && !repair->seen[i] &&
            vor_complex_surrounds(complex, i)) {
            repair->status = vor_run_answered(vor_run_poll(&repair->seeds->run), repair->err);
            if (repair->status == VOR_OK)
                repair->status = look_at(repair, i, worker);
        }
    if (repair->status == VOR_OK)
        trade(repair, worker);
}

vor_status vor_repair(struct vor_complex *complex, struct vor_sheet *sheet, struct vor_seeds *seeds,
                      size_t fixed, const struct vor_recall *how, struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct repair repair = {complex, sheet, seeds, fixed, how, .err = err};
    struct patch *patches = vor_malloc(memory, 4, sizeof *patches);
    struct ground *grounds = vor_malloc(memory, 2, sizeof *grounds);
    vor_status status = VOR_OK;

    for (size_t i = 0; i < complex->n; i++)
        repair.room += complex->degree[i] > 0 && complex->degree[i] != 6;
    repair.place = vor_calloc(memory, seeds->n, 1);
    repair.moved = vor_calloc(memory, seeds->n, 1);
    repair.seen = vor_calloc(memory, seeds->n, 1);
    for (int k = 0; k < 2; k++)
        repair.found[k] = vor_malloc(memory, repair.room + 1, sizeof *repair.found[k]);
    for (int k = 0; k < 2 && patches != NULL && grounds != NULL; k++) {
        repair.of[k] = patches + k;
        repair.trial[k] = patches + 2 + k;
        patches[k].on = grounds + k;
    }
    if (patches == NULL || grounds == NULL || repair.place == NULL || repair.moved == NULL ||
        repair.seen == NULL || repair.found[0] == NULL || repair.found[1] == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    if (status == VOR_OK)
        status = vor_run_for(&seeds->run, 1, 1, repair_on_one, &repair, err);
    if (status == VOR_OK)
        status = repair.status;
    if (status == VOR_OK)
        status = vor_sheet_put(sheet, seeds, repair.moved, how, err);
    VOR_FREE_ALL(memory, repair.found[1], repair.found[0], repair.seen, repair.moved, repair.place,
                 grounds, patches);
    return status;
}
