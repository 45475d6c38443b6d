#include "core/lop/fillets.h"

#include "core/base/linalg.h"
#include "core/geom/fillet.h"
#include "core/lop/edges.h"
#include "core/lop/weights.h"

#include <math.h>
#include <string.h>

/* Figures below: fandisk30k_noisy to 40,000 by 10,000 samples, rms elsewhere than near edges over
 * the input's, and the same of a box with one sharp edge and three fillets of 2, 4 and 8 % of its
 * diagonal, 30,000 points with noise of 0.5 %. Without fillets .383, .801; at GAIN 1 and all
 * neighbours in planes (lop/normals.c) .224, .280, with fewer radii tried (geom/fillet.c) and no
 * bound on points of third sides. */
enum { BLOCK = 64 }; /* points of a task */

/* Neighbours that a fillet is fitted to, over those of a fit: its sides show beside it. At 1.75 /
 * 3.5 / 5: .291, .277 / .236, .278 / .248, .280. */
#define WIDE 3.5
/* Part of the list's reach from the edge within which a point is said to be at it. At 0.25 / 0.5 /
 * 1: .223, .278 / .236, .278 / .242, .296; at 0.25 a fillet wider than the list is not covered.
 * A fillet is fitted only if the points this near to the edge lie below both planes, on the mean by
 * more than a standard error. At 0 / 1 / 2 standard errors .236, .277 / .236, .278 / .227, .298. */
#define CENTRAL 0.5
/* Gain of a fillet over an edge, in variances of the noise, in the mean of the points at the edge
 * around; most that one of them counts for. At true edges 99 in 100 points have a gain below 1, at
 * fillets as wide as the fits half of them 10 to 60. At 0.5 / 1 / 2: .229, .261 / .236, .278 /
 * .283, .275. */
#define GAIN 0.5
#define GAIN_MOST 20.0

/* Slots of points that have none: those far from edges, and those where the surface is no rounder
 * than an edge. */
#define NO_SIDES UINT32_MAX
#define NO_FILLET (UINT32_MAX - 1)

/* A fillet of points that are taken inside out where it is hollow. */
struct signed_fillet {
    struct vor_fillet of;
    double sign;
};

struct fillets {
    const struct vor_lop_samples *data;
    struct vor_lop_samples *next;
    const struct vor_domain *domain;
    const struct vor_lop_lists *lists;
    uint32_t *slot;  /* n: of a point's fillet; NO_SIDES, NO_FILLET */
    uint32_t *point; /* of each fillet */
    struct signed_fillet *fillet;
    size_t count;
};

/* The two sides around a point. */
struct sides {
    double place[2][3], normal[2][3]; /* outwards */
    double along[3];
    double sign; /* of their normals: -1 where the edge is hollow */
};

static const float *normal_of(const struct fillets *fillets, size_t i)
{
    return &fillets->data->normal[3 * i];
}

/* The nearest point of another side, or -1. */
static int64_t other_side(const struct fillets *fillets, size_t i)
{
    const uint32_t *list = &fillets->lists->list[i * fillets->lists->most];

    for (unsigned j = 0; j < fillets->lists->count[i]; j++) {
        double cosine = vor_dotf(normal_of(fillets, i), normal_of(fillets, list[j]));

        if (cosine < VOR_LOP_EDGE_COSINE && cosine > -VOR_SAME_WAY)
            return list[j];
    }
    return -1;
}

/* The mean of the points whose normals are like one. Returns whether these are enough. */
static int mean_side(double place[3], double normal[3], const struct fillets *fillets,
                     const float like[3], const uint32_t *index, unsigned k)
{
    unsigned count = 0;
    double length;

    memset(place, 0, 3 * sizeof *place);
    memset(normal, 0, 3 * sizeof *normal);
    for (unsigned j = 0; j < k; j++) {
        const float *n = normal_of(fillets, index[j]);

        if (vor_dotf(n, like) <= VOR_LOP_EDGE_COSINE)
            continue;
        count++;
        for (size_t c = 0; c < 3; c++) {
            place[c] += (double)fillets->data->xyz[3 * (size_t)index[j] + c];
            normal[c] += (double)n[c];
        }
    }
    length = sqrt(vor_dot(normal, normal));
    for (int c = 0; c < 3 && count >= VOR_LOP_FEWEST; c++) {
        place[c] /= count;
        normal[c] /= length;
    }
    return count >= VOR_LOP_FEWEST;
}

/* Finds both sides among points. Returns whether there are two. */
static int find_sides(struct sides *out, const struct fillets *fillets, const float *like[2],
                      const uint32_t *index, unsigned k)
{
    double apart[3], length;

    memset(out, 0, sizeof *out);
    for (int l = 0; l < 2; l++)
        if (!mean_side(out->place[l], out->normal[l], fillets, like[l], index, k))
            return 0;
    if (vor_dot(out->normal[0], out->normal[1]) >= VOR_LOP_EDGE_COSINE)
        return 0;
    for (int c = 0; c < 3; c++)
        apart[c] = out->place[0][c] - out->place[1][c];
    out->sign = vor_dot(apart, out->normal[1]) > vor_dot(apart, out->normal[0]) ? -1 : 1;
    for (int c = 0; c < 3; c++) {
        out->normal[0][c] *= out->sign;
        out->normal[1][c] *= out->sign;
    }
    vor_cross(out->along, out->normal[0], out->normal[1]);
    length = sqrt(vor_dot(out->along, out->along));
    for (int c = 0; c < 3; c++)
        out->along[c] /= length;
    return 1;
}

/* Whether a normal is that of a point between both sides, or of one. */
static int belongs(const struct sides *sides, const float n[3])
{
    double along = 0, up = 0;

    for (int c = 0; c < 3; c++) {
        along += (double)n[c] * sides->along[c];
        up += (double)n[c] * (sides->normal[0][c] + sides->normal[1][c]);
    }
    /* A normal that points along the edge is of a third side. */
    return fabs(along) <= VOR_SAME_WAY && up * sides->sign > 0;
}

/* Heights of x over both sides. */
static void over(double out[2], const struct sides *sides, const float x[3])
{
    for (int l = 0; l < 2; l++) {
        out[l] = 0;
        for (int c = 0; c < 3; c++)
            out[l] += sides->normal[l][c] * ((double)x[c] - sides->place[l][c]);
    }
}

/* How far a place is across from the edge, by its heights over both sides. */
static double across(const struct sides *sides, const double h[2])
{
    double cosine = vor_dot(sides->normal[0], sides->normal[1]);

    return (h[0] - h[1]) / sqrt(2 * (1 - cosine));
}

/* Whether the points at the edge lie below both planes. */
static int lies_below(const struct fillets *fillets, const struct sides *sides,
                      const uint32_t *index, unsigned k, double reach)
{
    double sum = 0, noise2 = 0, count = 0;

    for (unsigned j = 0; j < k; j++) {
        const float *x = &fillets->domain->xyz[3 * (size_t)index[j]];
        const float *y = &fillets->data->xyz[3 * (size_t)index[j]],
                    *n = normal_of(fillets, index[j]);
        const float off[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
        double h[2];

        noise2 += vor_dotf(off, n) * vor_dotf(off, n) / k;
        over(h, sides, x);
        if (!belongs(sides, n) || fabs(across(sides, h)) > CENTRAL * reach)
            continue;
        sum += h[h[1] > h[0]];
        count++;
    }
    return sum < 0 && sum * sum > noise2 * count;
}

/* Finds the points at edges, and of these the ones that may be at fillets. */
static void screen_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct fillets *fillets = ctx;

    for (size_t i = begin; i < end; i++) {
        const uint32_t *list = &fillets->lists->list[i * fillets->lists->most];
        unsigned k = fillets->lists->count[i];
        const float *x = &fillets->domain->xyz[3 * i], *like[2];
        int64_t other = other_side(fillets, i);
        struct sides sides;
        double reach, h[2];

        fillets->slot[i] = NO_SIDES;
        if (other < 0)
            continue;
        like[0] = normal_of(fillets, i);
        like[1] = normal_of(fillets, (size_t)other);
        if (!find_sides(&sides, fillets, like, list, k))
            continue;
        reach = sqrt(vor_distance2f(x, &fillets->domain->xyz[3 * (size_t)list[k - 1]]));
        over(h, &sides, x);
        if (fabs(across(&sides, h)) > CENTRAL * reach)
            continue;
        fillets->slot[i] = lies_below(fillets, &sides, list, k, reach) ? 0 : NO_FILLET;
    }
}

/* Fits one to the points around point i. */
static void fit(struct signed_fillet *out, const struct fillets *fillets, size_t i)
{
    const struct vor_domain *domain = fillets->domain;
    const float *x = &domain->xyz[3 * i], *like[2];
    unsigned k = (unsigned)fmin(fmin(WIDE * fillets->lists->count[i], VOR_NEIGHBORS_MAX),
                                (double)domain->n),
             used = 0;
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX], near[3 * VOR_NEIGHBORS_MAX];
    struct sides sides;
    double reach2 = 0;

    memset(out, 0, sizeof *out);
    if (vor_graph_is(&domain->graph) && domain->graph.own[i]) /* no other sheet's points */
        k = vor_graph_around(&domain->graph, (uint32_t)i, index, k);
    else
        vor_knn_search(domain->knn, x, 1, k, index, distance2);
    for (unsigned j = 0; j < k; j++)
        reach2 = fmax(reach2, vor_distance2f(x, &domain->xyz[3 * (size_t)index[j]]));
    like[0] = normal_of(fillets, i);
    like[1] = normal_of(fillets, (size_t)other_side(fillets, i));
    if (!find_sides(&sides, fillets, like, index, k))
        return;
    for (unsigned j = 0; j < k; j++)
        if (belongs(&sides, normal_of(fillets, index[j])))
            memcpy(&near[3 * used++], &domain->xyz[3 * (size_t)index[j]], 3 * sizeof *near);
    if (used >= VOR_FILLET_MIN)
        vor_fillet_fit(&out->of, near, used, sides.place, sides.normal, sqrt(reach2 / WIDE));
    out->sign = sides.sign;
}

static void fit_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct fillets *fillets = ctx;

    for (size_t f = begin; f < end; f++)
        fit(&fillets->fillet[f], fillets, fillets->point[f]);
}

/* What the fillets around a point say: sums of weights, of those times gains, of these where the
 * point is near the surface, and where it is near its round part; and of these weights times places
 * and normals. */
struct said {
    double weight, gain, fitted, round;
    double xyz[3], normal[3];
};

/* Adds what the fillet of point j says of point i. */
static void listen(struct said *said, const struct fillets *fillets, size_t i, size_t j,
                   double weight)
{
    const struct vor_fillet *fillet;
    double sign;
    const float *x = &fillets->domain->xyz[3 * i];
    const double at[3] = {(double)x[0], (double)x[1], (double)x[2]};
    double height, normal[3];
    int round;

    said->weight += weight;
    if (fillets->slot[j] == NO_FILLET)
        return;
    fillet = &fillets->fillet[fillets->slot[j]].of;
    sign = fillets->fillet[fillets->slot[j]].sign;
    if (!(fillet->gain > 0))
        return;
    said->gain += weight * fmin(fillet->gain, GAIN_MOST);
    round = vor_fillet_at(fillet, at, &height, normal);
    weight *= fmin(fillet->gain, GAIN_MOST);
    said->fitted += weight;
    said->round += weight * round;
    for (int c = 0; c < 3; c++) {
        said->xyz[c] += weight * (at[c] - height * normal[c]);
        said->normal[c] += weight * sign * normal[c];
    }
}

/* Asks the fillets around point i. */
static void ask(struct said *said, const struct fillets *fillets, size_t i)
{
    const uint32_t *list = &fillets->lists->list[i * fillets->lists->most];
    const float *xyz = fillets->domain->xyz;
    unsigned k = fillets->lists->count[i];
    double far2 = vor_distance2f(&xyz[3 * i], &xyz[3 * (size_t)list[k - 1]]);

    memset(said, 0, sizeof *said);
    for (unsigned j = 0; j < k && far2 > 0; j++) {
        double d2 = vor_distance2f(&xyz[3 * i], &xyz[3 * (size_t)list[j]]);

        if (fillets->slot[list[j]] != NO_SIDES)
            listen(said, fillets, i, list[j], vor_lop_near(d2, 1 / far2));
    }
}

static void put_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct fillets *fillets = ctx;

    for (size_t i = begin; i < end; i++) {
        float *y = &fillets->next->xyz[3 * i], *n = &fillets->next->normal[3 * i];
        struct said said;
        double length;

        memcpy(y, &fillets->data->xyz[3 * i], 3 * sizeof *y);
        memcpy(n, normal_of(fillets, i), 3 * sizeof *n);
        ask(&said, fillets, i);
        length = sqrt(vor_dot(said.normal, said.normal));
        if (!(said.gain > GAIN * said.weight) || !(said.round > said.fitted / 2) ||
            !(length > said.fitted / 2))
            continue;
        for (int c = 0; c < 3; c++) {
            y[c] = (float)(said.xyz[c] / said.fitted);
            n[c] = (float)(said.normal[c] / length);
        }
    }
}

/* Lists the points that may be at fillets. */
static vor_status list(struct fillets *fillets, struct vor_memory *memory, struct vor_error *err)
{
    size_t n = fillets->domain->n;

    for (size_t i = 0; i < n; i++)
        fillets->count += fillets->slot[i] == 0;
    fillets->point = vor_malloc(memory, fillets->count, sizeof *fillets->point);
    fillets->fillet = vor_malloc(memory, fillets->count, sizeof *fillets->fillet);
    if (fillets->point == NULL || fillets->fillet == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu fillets", fillets->count);
    fillets->count = 0;
    for (size_t i = 0; i < n; i++)
        if (fillets->slot[i] == 0) {
            fillets->slot[i] = (uint32_t)fillets->count;
            fillets->point[fillets->count++] = (uint32_t)i;
        }
    return VOR_OK;
}

vor_status vor_lop_fillets(struct vor_lop_samples *data, struct vor_lop_samples *room,
                           const struct vor_domain *domain, const struct vor_lop_lists *lists,
                           const struct vor_run *run, struct vor_error *err)
{
    struct fillets fillets = {.data = data, .next = room, .domain = domain, .lists = lists};
    struct vor_memory *memory = run->memory;
    vor_status status = VOR_OK;

    fillets.slot = vor_malloc(memory, domain->n, sizeof *fillets.slot);
    if (fillets.slot == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    VOR_THEN(status, vor_run_for(run, domain->n, BLOCK, screen_block, &fillets, err));
    VOR_THEN(status, list(&fillets, memory, err));
    VOR_THEN(status, vor_run_for(run, fillets.count, BLOCK, fit_block, &fillets, err));
    VOR_THEN(status, vor_run_for(run, domain->n, BLOCK, put_block, &fillets, err));
    if (status == VOR_OK) {
        float *xyz = data->xyz, *normal = data->normal;

        data->xyz = room->xyz;
        data->normal = room->normal;
        room->xyz = xyz;
        room->normal = normal;
    }
    VOR_FREE_ALL(memory, fillets.fillet, fillets.point, fillets.slot);
    return status;
}
