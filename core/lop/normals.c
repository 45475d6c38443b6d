#include "core/lop/normals.h"

#include "core/base/linalg.h"
#include "core/geom/plane.h"
#include "core/input/neighbors.h"
#include "core/lop/beside.h"
#include "core/lop/fillets.h"
#include "core/lop/weights.h"

#include <math.h>
#include <string.h>

/* Points of a task. */
enum { BLOCK = 128 };

/* Most neighbours that count for a point. */
enum { MOST = VOR_LADDER_LAST };
/* Fewest neighbours, and those whose normals a point chooses among when it starts anew; planes have
 * as many as a fit takes. With half as many, fandisk30k_noisy to
 * 10,000: rms over the input's 0.38 for 0.29, median of normals near edges 8.7 degrees for 4.7;
 * wedges of 90 degrees, noise 1 %, 2.5 for 1.3. */
enum { LEAST = VOR_LOP_AREA_OF };

/* Share of the neighbours that planes are fitted to, and that a point chooses its plane from: the
 * nearest. Smoothing sees all of them. At 0.7 (of all three) / 0.85 / 1: p99 near edges of
 * fandisk30k_noise2 to 120,000 at rho 0 1.98e-3 / 1.94e-3 / 2.15e-3, of fandisk30k_noisy to 40,000
 * rms near edges over the input's .409 / .383 / .365. */
#define PLANES_SHARE 0.85

/* Distances of a neighbour's plane at which it no longer counts, in rms of the heights over a
 * plane. At 3 / 6 / 10: rms of fandisk30k_noisy 0.52 / 0.43 / 0.38 (planes of half as many points),
 * median of a wedge's normals alike. */
#define OFF 10.0

/* Heights over a plane that say nothing against it, in rms of those of its own points. At 1.5 / 2 /
 * 2.5: as above 0.30 / 0.29 / 0.28, wedges of 90 degrees 2.5 / 2.6 / 2.9 degrees. */
#define TRUSTED 2.0

/* Share of the neighbourhood's reach that planes may be off by curvature alone. */
#define BENT 0.02

struct normals {
    const struct vor_domain *domain;
    const struct vor_lop_normals_how *how;
    struct vor_plane *plane; /* n: through the points nearest to each */
    float *off;              /* n: rms height of a point's neighbours over its plane */
    unsigned most;           /* neighbours of a list */
    uint32_t *list;          /* n x most: those that count for each point */
    uint16_t *count;         /* n: how many they are */
    struct vor_lop_samples now, next;
    double scale; /* of vor_lop_alike */
};

/* Input points around point i of the domain, on its sheet where the domain has lists. */
static unsigned look_around(const struct vor_domain *domain, size_t i, unsigned k, uint32_t *index,
                            struct vor_knn_last *last)
{
    float distance2[MOST];

    if (vor_graph_is(&domain->graph) && domain->graph.own[i])
        return vor_graph_around(&domain->graph, (uint32_t)i, index, k);
    if (k > domain->n)
        k = (unsigned)domain->n;
    vor_knn_search_next(domain->knn, last, &domain->xyz[3 * i], k, index, distance2);
    return k;
}

/* Neighbours that count for point i. */
static unsigned counting(const struct normals *normals, size_t i)
{
    const struct vor_domain *domain = normals->domain;
    unsigned k = vor_neighbors_at(&domain->known.neighbors, &domain->xyz[3 * i]);

    k = k < LEAST ? LEAST : k;
    return k < normals->most ? k : normals->most;
}

/* The area around point i: the list that a search made begins with the nearest. */
static float area_of(const struct normals *normals, size_t i)
{
    const struct vor_domain *domain = normals->domain;
    unsigned k = domain->n < VOR_LOP_AREA_OF ? (unsigned)domain->n : VOR_LOP_AREA_OF;
    const float *x = &domain->xyz[3 * i], *y;
    uint32_t index[VOR_LOP_AREA_OF];
    float distance2[VOR_LOP_AREA_OF], d[3];

    if (vor_graph_is(&domain->graph) && domain->graph.own[i]) {
        vor_knn_search(domain->knn, x, 1, k, index, distance2);
        return distance2[k - 1];
    }
    y = &domain->xyz[3 * (size_t)normals->list[i * normals->most + k - 1]];
    for (int c = 0; c < 3; c++)
        d[c] = y[c] - x[c];
    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

/* Neighbours of k that planes are made of. */
static unsigned for_planes(unsigned k)
{
    unsigned few = (unsigned)(PLANES_SHARE * k);

    return few < LEAST ? (k < LEAST ? k : LEAST) : few;
}

/* Lists the neighbours, and puts a plane through them. */
static void plane_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct normals *normals = ctx;
    const struct vor_domain *domain = normals->domain;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        uint32_t *list = &normals->list[i * normals->most];
        unsigned k = look_around(domain, i, counting(normals, i), list, &last);

        normals->count[i] = (uint16_t)k;
        normals->now.area[i] = area_of(normals, i);
        vor_plane_fit(&normals->plane[i], domain->xyz, list, for_planes(k));
    }
}

/* How badly a plane stands for the surface at x: its flatness, and how far it passes beyond TRUSTED
 * times what its own points are off, squared over r2. */
static double cost_of(const struct vor_plane *plane, const float x[3], double r2)
{
    double height = 0, beyond;

    for (unsigned c = 0; c < 3; c++)
        height += ((double)x[c] - (double)plane->middle[c]) * (double)plane->normal[c];
    beyond = fmax(fabs(height) - TRUSTED * sqrt((double)plane->flatness * r2), 0);
    return (double)plane->flatness + beyond * beyond / r2;
}

/* Whether the plane of point j, on the side that the surface faces there, faces away from point i:
 * it is that of a wall's other face, which may pass nearer. Not known where sides were found on
 * fewer points. */
static int faces_away(const struct normals *normals, size_t i, size_t j)
{
    const struct vor_orientation *sides = normals->how->orientation;
    const float *n = normals->plane[j].normal;

    return sides->thin.n == 0 &&
           vor_dotf(n, &sides->normal[3 * i]) * vor_dotf(n, &sides->normal[3 * j]) < 0;
}

/* Takes for each point the best of the planes around it. */
static void choose_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct normals *normals = ctx;
    const struct vor_domain *domain = normals->domain;

    for (size_t i = begin; i < end; i++) {
        const float *x = &domain->xyz[3 * i];
        const uint32_t *index = &normals->list[i * normals->most];
        unsigned k = for_planes(normals->count[i]);
        double r2 = 0, best = INFINITY; /* r2: mean square of the distances */
        uint32_t taken = (uint32_t)i;

        for (unsigned j = 0; j < k; j++)
            r2 += vor_distance2f(x, &domain->xyz[3 * (size_t)index[j]]);
        r2 /= k;

        for (unsigned j = 0; j < k; j++) {
            double cost = cost_of(&normals->plane[index[j]], x, r2);

            if (cost < best && !faces_away(normals, i, index[j])) {
                best = cost;
                taken = index[j];
            }
        }
        memcpy(&normals->now.normal[3 * i], normals->plane[taken].normal, 3 * sizeof *x);
        memcpy(normals->now.xyz + 3 * i, x, 3 * sizeof *x);
        normals->off[i] = (float)sqrt((double)normals->plane[taken].flatness * r2);
    }
}

static void sign_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct normals *normals = ctx;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        float *normal = normals->now.normal + 3 * i;
        double n[3], toward[3];

        vor_to_doubles(n, normal);
        if (vor_orientation_side(normals->how->orientation, normals->domain,
                                 &normals->domain->xyz[3 * i], n, toward, &last) < 0)
            for (unsigned c = 0; c < 3; c++)
                normal[c] = -normal[c];
    }
}

/* What a point sees of its neighbours. */
struct seen {
    unsigned k;
    const uint32_t *index;
    double weight[MOST]; /* by distance, and how near their planes pass by */
    float normal[3][MOST];
};

static const float *normal_now(const struct normals *normals, size_t i)
{
    return normals->now.normal + 3 * i;
}

static void see(struct seen *seen, const struct normals *normals, size_t i)
{
    const float *x = normals->now.xyz + 3 * i;
    double reach2 = 0, off;

    seen->k = normals->count[i];
    seen->index = &normals->list[i * normals->most];
    for (unsigned j = 0; j < seen->k; j++)
        reach2 = fmax(reach2, vor_distance2f(&normals->domain->xyz[3 * i],
                                             &normals->domain->xyz[3 * (size_t)seen->index[j]]));
    off = OFF * (double)normals->off[i] + BENT * sqrt(reach2);
    for (unsigned j = 0; j < seen->k; j++) {
        const float *y = normals->now.xyz + 3 * (size_t)seen->index[j];
        const float *n = normal_now(normals, seen->index[j]);
        const float away[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
        double height = vor_dotf(away, n);

        for (int c = 0; c < 3; c++)
            seen->normal[c][j] = n[c];
        seen->weight[j] = reach2 > 0 && off > 0 ? vor_lop_near(vor_dotf(away, away), 1 / reach2) *
                                                      vor_lop_near(height * height, 1 / (off * off))
                                                : 1;
    }
}

/* Weights of what is seen, times how much each normal is like one. */
VOR_CLONES static void agree(double *restrict weight, const struct seen *seen, const float n[3],
                             double scale)
{
    double n0 = (double)n[0], n1 = (double)n[1], n2 = (double)n[2];

    for (unsigned j = 0; j < seen->k; j++) {
        double cosine = n0 * (double)seen->normal[0][j] + n1 * (double)seen->normal[1][j] +
                        n2 * (double)seen->normal[2][j];

        weight[j] = seen->weight[j] * vor_lop_alike(cosine, scale);
    }
}

/* The normal that most of what is seen agrees with, of point i or one of those nearest to it. */
static const float *most_agreed(const struct normals *normals, const struct seen *seen)
{
    const float *found = normal_now(normals, seen->index[0]);
    double weight[MOST], best = -1;

    memset(weight, 0, seen->k * sizeof *weight); /* gcc's analyzer cannot see what fills it */
    for (unsigned c = 0; c < seen->k && c < LEAST; c++) {
        const float *n = normal_now(normals, seen->index[c]);
        double sum = 0;

        agree(weight, seen, n, normals->scale);
        for (unsigned j = 0; j < seen->k; j++)
            sum += weight[j];
        if (sum > best) {
            best = sum;
            found = n;
        }
    }
    return found;
}

/* The weighted mean of the normals that agree with `about`; Eq. 2. */
static void smooth(float out[3], const struct normals *normals, const struct seen *seen,
                   const float about[3])
{
    double weight[MOST], sum[3] = {0}, length;

    memset(weight, 0, seen->k * sizeof *weight); /* gcc's analyzer cannot see what fills it */
    agree(weight, seen, about, normals->scale);
    for (unsigned j = 0; j < seen->k; j++)
        for (unsigned c = 0; c < 3; c++)
            sum[c] += weight[j] * (double)seen->normal[c][j];
    length = sqrt(vor_dot(sum, sum));
    for (unsigned c = 0; c < 3; c++)
        out[c] = length > 0 ? (float)(sum[c] / length) : about[c];
}

static void normal_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct normals *normals = ctx;
    struct seen seen;

    for (size_t i = begin; i < end; i++) {
        see(&seen, normals, i);
        smooth(&normals->next.normal[3 * i], normals, &seen, most_agreed(normals, &seen));
    }
}

/* Moves each point along its normal to where those of its side see it. */
static void move_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct normals *normals = ctx;
    struct seen seen;

    for (size_t i = begin; i < end; i++) {
        const float *x = normals->now.xyz + 3 * i, *n = normal_now(normals, i);
        double sum = 0, weights = 0;

        see(&seen, normals, i);
        for (unsigned j = 0; j < seen.k; j++) {
            const float *y = normals->now.xyz + 3 * (size_t)seen.index[j];
            const float *m = normal_now(normals, seen.index[j]);
            const float there[3] = {y[0] - x[0], y[1] - x[1], y[2] - x[2]};
            double cosine = vor_dotf(n, m);
            double w = seen.weight[j] * vor_lop_alike(cosine, normals->scale);

            if (w > 0)
                sum += w * (vor_dotf(there, n) + vor_dotf(there, m)) / (1 + cosine);
            weights += w;
        }
        for (unsigned c = 0; c < 3; c++)
            normals->next.xyz[3 * i + c] =
                x[c] + (float)(weights > 0 ? sum / weights * (double)n[c] : 0);
    }
}

static void swap(float **a, float **b)
{
    float *c = *a;

    *a = *b;
    *b = c;
}

/* Smooths normals and moves points, in turn. */
static vor_status work(struct normals *normals, const struct vor_run *run, struct vor_error *err)
{
    size_t n = normals->domain->n;
    uint32_t rounds = normals->how->rounds;
    vor_status status = VOR_OK;

    for (uint32_t r = 0; status == VOR_OK && r < (rounds > 0 ? rounds : 1); r++) {
        status = vor_run_for(run, n, BLOCK, normal_block, normals, err);
        swap(&normals->now.normal, &normals->next.normal);
        if (status != VOR_OK || rounds == 0)
            continue;
        status = vor_run_for(run, n, BLOCK, move_block, normals, err);
        swap(&normals->now.xyz, &normals->next.xyz);
    }
    return status;
}

/* Finds the sides of the surface, and takes planes and their sides by them. */
static vor_status choose(struct normals *normals, const struct vor_run *run, struct vor_error *err)
{
    struct vor_orient_how how = {
        .points = normals->how->points, .area = normals->how->area, .plain = normals->how->plain};
    size_t n = normals->domain->n;
    vor_status status = vor_orient(normals->how->orientation, normals->domain, &how, run, err);

    VOR_THEN(status, vor_run_for(run, n, BLOCK, choose_block, normals, err));
    return status == VOR_OK ? vor_run_for(run, n, BLOCK, sign_block, normals, err) : status;
}

/* Puts data that none of their side are around beside the others. */
static void land_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct normals *normals = ctx;
    const struct vor_lop_beside beside = {&normals->now, normals->domain, normals->how->sigma_n};
    struct vor_knn_last last = {.k = 0};

    memcpy(normals->next.xyz + 3 * begin, normals->now.xyz + 3 * begin,
           3 * (end - begin) * sizeof(float));
    memcpy(normals->next.normal + 3 * begin, normals->now.normal + 3 * begin,
           3 * (end - begin) * sizeof(float));
    for (size_t i = begin; i < end; i++)
        vor_lop_beside_land(&normals->next.xyz[3 * i], &normals->next.normal[3 * i], &beside, i,
                            &last);
}

static vor_status find(struct normals *normals, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_lop_lists lists = {normals->most, normals->list, normals->count};
    size_t n = normals->domain->n;
    vor_status status = vor_run_for(run, n, BLOCK, plane_block, normals, err);

    VOR_THEN(status, choose(normals, run, err));
    VOR_THEN(status, work(normals, run, err));
    if (status != VOR_OK || normals->how->rounds == 0 || !normals->how->edges)
        return status;
    status = vor_lop_fillets(&normals->now, &normals->next, normals->domain, &lists, run, err);
    VOR_THEN(status, vor_run_for(run, n, BLOCK, land_block, normals, err));
    swap(&normals->now.normal, &normals->next.normal);
    swap(&normals->now.xyz, &normals->next.xyz);
    return status;
}

static vor_status alloc_normals(struct normals *normals, struct vor_memory *memory,
                                struct vor_error *err)
{
    size_t n = normals->domain->n;
    vor_status status = vor_lop_samples_init(&normals->now, n, memory, err);

    VOR_THEN(status, vor_lop_samples_init(&normals->next, n, memory, err));
    if (status != VOR_OK)
        return status;
    return VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(normals->now.area, n, 1),
                        VOR_ARRAY(normals->plane, n, 1), VOR_ARRAY(normals->off, n, 1),
                        VOR_ARRAY(normals->count, n, 1),
                        VOR_ARRAY(normals->list, n, normals->most));
}

vor_status vor_lop_normals(struct vor_lop_samples *out, const struct vor_domain *domain,
                           const struct vor_lop_normals_how *how, const struct vor_run *run,
                           struct vor_error *err)
{
    struct normals normals = {.domain = domain, .how = how, .scale = vor_lop_scale(how->sigma_n)};
    unsigned most = domain->known.neighbors.most; /* neighbours that a list has room for */
    vor_status status;

    most = most < LEAST ? LEAST : most;
    most = most < MOST ? most : MOST;
    normals.most = most < domain->n ? most : (unsigned)domain->n;
    status = alloc_normals(&normals, run->memory, err);
    VOR_THEN(status, find(&normals, run, err));
    if (status == VOR_OK) {
        *out = normals.now;
        out->n = domain->n;
        normals.now = (struct vor_lop_samples){0};
    }
    VOR_FREE_ALL(run->memory, normals.list, normals.count, normals.off, normals.plane);
    vor_lop_samples_free(&normals.next);
    vor_lop_samples_free(&normals.now);
    return status;
}
