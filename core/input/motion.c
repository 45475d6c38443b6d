#include "core/input/motion.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/base/stat.h"
#include "core/geom/surface.h"
#include "core/input/neighbors.h"
#include "core/input/sheets.h"

#include <math.h>
#include <string.h>

enum {
    UNKNOWNS = 6,          /* three of a turn, three of a shift */
    AROUND = UNKNOWNS + 1, /* parts that are looked at, the last of which has no say: those around
                              one in a hexagonal lattice */
    BLOCK = 16             /* points of one task */
};

/* A point of the earlier result and the surface near it. */
struct contact {
    float x[3], normal[3], way; /* along the normal to the surface; infinite: there is none */
    float weight;
};

/* It turns by the quaternion (1, half) about the middle of its contacts, and shifts. */
struct part {
    double middle[3], half[3], shift[3];
};

/* Sums over the contacts of a part, by weight. `a` and `b` are the equations for its motion: turns
 * are in lengths at the radius. */
struct sums {
    double weight, weight2, x[3], x2, radius;
    double a[UNKNOWNS][UNKNOWNS], b[UNKNOWNS], way2;
};

/* Parts that say how a place moves; shares sum up to 1. */
struct around {
    unsigned count;
    uint32_t part[AROUND];
    double share[AROUND];
};

struct motion {
    const struct vor_domain *domain;
    struct vor_previous *previous;
    uint32_t *order; /* m: earlier points that may be near the surface, in Morton's order */
    size_t m, n;
    struct contact *contact; /* n, of points in equal steps along that order */
    float *way;              /* n: room to sort */
    double error;            /* mean square of ways, by weight */
    size_t parts;
    float *place;        /* parts x 3: contacts in equal steps */
    struct vor_knn *knn; /* over place */
    struct part *part;
    struct sums *sums;
    int moves; /* a part does */
};

/* Whether a point may be near the domain, which lies within 1 of the middle. */
static int is_near(const float x[3])
{
    return x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < 4;
}

/* One of `count` at equal steps of n. */
static size_t one_of(size_t i, size_t count, size_t n)
{
    return (size_t)((2 * (uint64_t)i + 1) * n / (2 * (uint64_t)count));
}

static void meet_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct motion *motion = ctx;
    const struct vor_domain *domain = motion->domain;
    struct contact *contact = &motion->contact[i];
    const float *from = &motion->previous->xyz[3 * motion->order[one_of(i, motion->n, motion->m)]];
    unsigned k = vor_domain_most(domain, vor_neighbors_at(&domain->known.neighbors, from));
    struct vor_surface surface;
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX], near[3 * VOR_NEIGHBORS_MAX];
    double x[3], foot[3], local[3], normal[3], way = 0;

    memcpy(contact->x, from, sizeof contact->x);
    contact->way = INFINITY;
    contact->weight = 0;
    vor_knn_search(domain->knn, from, 1, k, index, distance2);
    vor_gather(near, domain->xyz, index, k);
    vor_to_doubles(x, from);
    (void)vor_sheets_fit(&surface, near, domain, x, k, NULL);
    if (surface.kind == VOR_SURFACE_NONE)
        return;
    memcpy(foot, x, sizeof foot);
    vor_surface_put(&surface, foot);
    vor_surface_to_local(&surface, foot, local);
    vor_surface_normal(&surface, local, normal);
    for (int c = 0; c < 3; c++)
        way += normal[c] * (foot[c] - x[c]);
    vor_to_floats(contact->normal, normal);
    contact->way = (float)way;
}

/* Finds the contacts. One that is far off counts less (Geman and McClure 1987): the surface may be
 * gone there. */
static vor_status meet(struct motion *motion, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = vor_run_rows(run, motion->n, BLOCK, meet_row, motion, err);
    double sum = 0, weights = 0, usual = 0;
    size_t known = 0;

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < motion->n; i++)
        if (!isinf(motion->contact[i].way))
            motion->way[known++] = fabsf(motion->contact[i].way);
    vor_sort_floats(motion->way, known);
    if (known > 0)
        usual = VOR_SURE * (double)motion->way[known / 2];
    for (size_t i = 0; i < motion->n && usual > 0; i++) {
        struct contact *contact = &motion->contact[i];
        double way = (double)contact->way, less = 1 / (1 + way * way / (usual * usual));

        if (isinf(way))
            continue;
        contact->weight = (float)(less * less);
        sum += less * less * way * way;
        weights += less * less;
    }
    motion->error = weights > 0 ? sum / weights : 0;
    return VOR_OK;
}

/* Finds the parts around x. Shares go to 0 where the next part is as near. */
static void look_around(struct around *out, const struct motion *motion, const float x[3])
{
    float distance2[AROUND];
    double sum = 0;

    out->count = motion->parts < AROUND ? (unsigned)motion->parts : AROUND;
    vor_knn_search(motion->knn, x, 1, out->count, out->part, distance2);
    for (unsigned j = 0; j < out->count; j++) {
        double inside = 1;

        if (motion->parts > AROUND)
            inside -= (double)distance2[j] / (double)distance2[AROUND - 1];
        out->share[j] = inside * inside;
        sum += out->share[j];
    }
    for (unsigned j = 0; j < out->count; j++)
        out->share[j] = sum > 0 ? out->share[j] / sum : 1.0 / out->count;
}

static void add_place(struct sums *to, const struct contact *contact, double weight)
{
    double x[3];

    vor_to_doubles(x, contact->x);
    to->weight += weight;
    to->weight2 += weight * weight;
    to->x2 += weight * vor_dot(x, x);
    for (int c = 0; c < 3; c++)
        to->x[c] += weight * x[c];
}

static void find_middle(struct part *part, struct sums *sums)
{
    for (int c = 0; c < 3 && sums->weight > 0; c++)
        part->middle[c] = sums->x[c] / sums->weight;
    sums->radius = sqrt(fmax(sums->x2 / sums->weight - vor_dot(part->middle, part->middle), 0));
}

static void add_contact(struct sums *to, const struct part *part, const struct contact *contact,
                        double weight)
{
    double d[3], normal[3], by[UNKNOWNS], way = (double)contact->way;

    vor_to_doubles(normal, contact->normal);
    for (int c = 0; c < 3; c++)
        d[c] = ((double)contact->x[c] - part->middle[c]) / to->radius;
    vor_cross(by, d, normal);
    memcpy(&by[3], normal, sizeof normal);
    for (int r = 0; r < UNKNOWNS; r++) {
        to->b[r] += weight * by[r] * way;
        for (int c = 0; c <= r; c++)
            to->a[r][c] += weight * by[r] * by[c];
    }
    to->way2 += weight * way * way;
}

/* Solves for the motion of a part, which one contact in each direction says is none. Only what is
 * more than noise explains is taken: of ways of nothing else the unknowns take up as much as that
 * many contacts have, and hardly ever more than VOR_SURE^2 times that. Returns whether it moves. */
static int solve(struct part *part, struct sums *sums)
{
    double contacts = sums->weight * sums->weight / sums->weight2, by[UNKNOWNS];
    double gain = 0, chance, share;

    if (!(sums->radius > 0) || !(contacts > UNKNOWNS))
        return 0;
    memcpy(by, sums->b, sizeof by);
    for (int r = 0; r < UNKNOWNS; r++)
        sums->a[r][r] += sums->weight / contacts;
    if (!(vor_solve_spd(&sums->a[0][0], by, UNKNOWNS, VOR_ROUNDED2) > 0))
        return 0;
    for (int r = 0; r < UNKNOWNS; r++)
        gain += by[r] * sums->b[r];
    chance = UNKNOWNS * fmax(sums->way2 - gain, 0) / (contacts - UNKNOWNS);
    share = 1 - VOR_SURE * VOR_SURE * chance / gain;
    if (!(share > 0))
        return 0;
    for (int c = 0; c < 3; c++) {
        part->half[c] = share * by[c] / (2 * sums->radius);
        part->shift[c] = share * by[3 + c];
    }
    return 1;
}

/* Solves for the motion of each part: where it is, and then how it moves. */
static void solve_all(struct motion *motion)
{
    memset(motion->sums, 0, motion->parts * sizeof *motion->sums);
    memset(motion->part, 0, motion->parts * sizeof *motion->part);
    motion->moves = 0;
    for (int solves = 0; solves <= 1; solves++) {
        for (size_t i = 0; i < motion->n; i++) {
            const struct contact *contact = &motion->contact[i];
            struct around around = {.count = 0};

            if (contact->weight > 0)
                look_around(&around, motion, contact->x);
            for (unsigned j = 0; j < around.count; j++) {
                double weight = around.share[j] * (double)contact->weight;
                uint32_t at = around.part[j];

                if (solves)
                    add_contact(&motion->sums[at], &motion->part[at], contact, weight);
                else
                    add_place(&motion->sums[at], contact, weight);
            }
        }
        for (size_t j = 0; j < motion->parts; j++)
            if (solves)
                motion->moves |= solve(&motion->part[j], &motion->sums[j]);
            else
                find_middle(&motion->part[j], &motion->sums[j]);
    }
}

/* Adds a share of the way of x with a part. */
static void add_way(double way[3], const struct part *part, const double x[3], double share)
{
    double d[3], once[3], twice[3], less = 2 / (1 + vor_dot(part->half, part->half));

    for (int c = 0; c < 3; c++)
        d[c] = x[c] - part->middle[c];
    vor_cross(once, part->half, d);
    vor_cross(twice, part->half, once);
    for (int c = 0; c < 3; c++)
        way[c] += share * (part->shift[c] + less * (once[c] + twice[c]));
}

static void carry_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct motion *motion = ctx;
    size_t at = motion->order[i];
    float *to = &motion->previous->xyz[3 * at];
    struct around around;
    double x[3], way[3] = {0};

    look_around(&around, motion, to);
    vor_to_doubles(x, to);
    for (unsigned j = 0; j < around.count; j++)
        add_way(way, &motion->part[around.part[j]], x, around.share[j]);
    for (int c = 0; c < 3; c++)
        to[c] = (float)(x[c] + way[c]);
    if (motion->parts > 1)
        motion->previous->bent[at] += (float)sqrt(vor_dot(way, way));
}

/* Moves the earlier points with so many parts. */
static vor_status step(struct motion *motion, const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    for (size_t j = 0; j < motion->parts; j++)
        memcpy(&motion->place[3 * j], motion->contact[one_of(j, motion->parts, motion->n)].x,
               3 * sizeof *motion->place);
    status = vor_knn_build(&motion->knn, motion->place, motion->parts, run->memory, err);
    if (status == VOR_OK)
        solve_all(motion);
    if (status == VOR_OK && motion->moves)
        status = vor_run_rows(run, motion->m, BLOCK, carry_row, motion, err);
    vor_knn_free(motion->knn);
    motion->knn = NULL;
    if (motion->moves)
        VOR_THEN(status, meet(motion, run, err));
    return status;
}

/* Moves the earlier points with one part, then with four times as many each, as long as a part has
 * contacts enough for a fit; with so many again while that halves the error. */
static vor_status follow(struct motion *motion, size_t most, const struct vor_run *run,
                         struct vor_error *err)
{
    vor_status status =
        vor_morton_order(motion->order, motion->previous->xyz, motion->previous->n, run, err);
    double before;

    for (size_t i = 0; status == VOR_OK && i < motion->previous->n; i++)
        if (is_near(&motion->previous->xyz[3 * (size_t)motion->order[i]]))
            motion->order[motion->m++] = motion->order[i];
    if (status != VOR_OK || motion->m < motion->n)
        return status;
    status = meet(motion, run, err);
    for (motion->parts = 1; status == VOR_OK && motion->parts <= most; motion->parts *= 4)
        do {
            before = motion->error;
            status = step(motion, run, err);
        } while (status == VOR_OK && motion->moves && motion->error < before / 2);
    return status;
}

vor_status vor_motion_follow(struct vor_domain *domain, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_previous *previous = &domain->previous;
    struct motion motion = {.domain = domain, .previous = previous};
    size_t most;
    vor_status status;

    motion.n = domain->n / domain->known.neighbors.usual;
    motion.n = motion.n < VOR_DOMAIN_SAMPLED ? motion.n : VOR_DOMAIN_SAMPLED;
    motion.n = motion.n < previous->n ? motion.n : previous->n;
    most = motion.n / VOR_NEIGHBORS_FEWEST;
    if (most == 0 || vor_run_is_late(run))
        return VOR_OK;
    status = VOR_MAKE_ALL(run->memory, err, previous->n, VOR_ARRAY(motion.order, previous->n, 1),
                          VOR_ARRAY(motion.contact, motion.n, 1),
                          VOR_ARRAY(motion.way, motion.n, 1), VOR_ARRAY(motion.place, most, 3),
                          VOR_ARRAY(motion.part, most, 1), VOR_ARRAY(motion.sums, most, 1));
    VOR_THEN(status, follow(&motion, most, run, err));
    VOR_FREE_ALL(run->memory, motion.sums, motion.part, motion.place, motion.way, motion.contact,
                 motion.order);
    return status;
}
