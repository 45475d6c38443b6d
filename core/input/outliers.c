#include "core/input/outliers.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/surface.h"
#include "core/input/neighbors.h"
#include "core/input/remote.h"
#include "core/input/sheets.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Figures are of igea, 12,000 points of white noise and 60 in its box at random, denoised to 3,000:
 * rms distance to the true surface in 1e-4 of its diagonal (spread 0.1), and points dropped. Some
 * of the 60 lie near the surface. */
enum {
    /* Nearest points that a point points to. At 10 / 20 / 40: rms 5.9 / 5.4 / 5.8, dropped 554 / 41
     * / 35. */
    NEIGHBORS = VOR_NEIGHBORS_FEWEST,
    /* A point that fewer others point to is an outlier. At 3 / 6 / 12: rms 5.2 / 5.4 / 5.1, dropped
     * 40 / 41 / 130; a point at a border has about 10. */
    POINTED = 6,
    /* Most searches. Here the first finds all; two outliers side by side need another. */
    LOOKS = 3,
    BLOCK = 256,          /* points of one task */
    ROW_BLOCK = 4096,     /* the same of what is quick */
    WIDTH = NEIGHBORS + 1 /* of a list of the nearest, the point itself the first of them */
};

/* Times the residual of a fit: a point farther off the surface of the points around it lies on none
 * of theirs. The figures of the closer look are recall and precision on bunny, outliers as Lv 2022
 * has them (one point in twenty, 3 to 6 mean distances to the nearest six off), and points taken
 * from an igea of white noise and from bunny with noise of 0.66 such distances. At 3 / 6 / 12:
 * 0.995, 0.994, 7 and 2,098 / 0.994, 0.997, 0 and 79 / 0.991, 0.999, 0 and 59. */
#define FAR 6.0
/* Spacings that it is off at least: exact inputs have no residual. At 0.25 / 0.5 / 1: 0.996, 0.997,
 * 3 and 79 / 0.994, 0.997, 0 and 79 / 0.984, 1, 0 and 79. */
#define APART 0.5

/* Times the median distance to the 20th neighbour: points with a longer one may be scattered.
 * The figures are of the torus of outliers.h with one outlier in ten and noise of a third of a
 * spacing, rms in 1e-3, and of points dropped from kitti and from autzen, whose trees are thick. At
 * 1.5 / 3 / 6: 2.1, 710 and 11,633 / 2.1, 318 and 349 / 93, 287 and 308; without: 582, 285, 306. */
#define SPARSE 3.0

/* One search of all points. */
struct look {
    const struct vor_domain *domain;
    int closer;                /* surfaces are fitted */
    double sparse2;            /* square of the reach from which a point may be scattered */
    _Atomic uint32_t *pointed; /* how many points have this one among their nearest */
    unsigned char *is_out;     /* 1 for each outlier */
};

/* Sets sparse2 from the median reach of a sample of points at equal steps along the order. */
static void find_sparse(struct look *look)
{
    size_t n = look->domain->n < VOR_DOMAIN_SAMPLED ? look->domain->n : VOR_DOMAIN_SAMPLED;
    float reach2[VOR_DOMAIN_SAMPLED] = {0}; /* clang-analyzer cannot see that n >= 1 */

    for (size_t i = 0; i < n; i++) {
        size_t at = (size_t)((uint64_t)i * look->domain->n / n);
        uint32_t index[WIDTH];
        float distance2[WIDTH];

        vor_knn_search(look->domain->knn, &look->domain->xyz[3 * at], 1, WIDTH, index, distance2);
        reach2[i] = distance2[NEIGHBORS];
    }
    vor_sort_floats(reach2, n);
    look->sparse2 = SPARSE * SPARSE * (double)reach2[n / 2];
}

/* Whether a point and its nearest are few and fill space, as no surface does. */
static int is_scattered(const struct look *look, const uint32_t *index, double reach2)
{
    struct vor_surface surface;

    if (!(reach2 > look->sparse2))
        return 0;
    (void)vor_surface_fit_to(&surface, look->domain->xyz, index, WIDTH);
    return surface.kind != VOR_SURFACE_NONE &&
           surface.off2 > VOR_SURFACE_THICK * VOR_SURFACE_THICK * reach2;
}

/* Whether point i lies off the surface of the listed points, without itself. */
static int is_off(const struct vor_domain *domain, size_t i, const uint32_t index[WIDTH])
{
    float near[3 * WIDTH];
    const float *from = &domain->xyz[3 * i];
    double x[3] = {(double)from[0], (double)from[1], (double)from[2]}, local[3], foot[3], off2 = 0;
    struct vor_surface surface;
    unsigned k = 0;

    for (unsigned j = 0; j < WIDTH && k < NEIGHBORS; j++)
        if (index[j] != i)
            memcpy(&near[3 * k++], &domain->xyz[3 * (size_t)index[j]], 3 * sizeof *near);
    vor_surface_fit(&surface, near, k);
    if (surface.kind != VOR_SURFACE_QUADRIC)
        return 0;
    vor_surface_to_local(&surface, x, local);
    memcpy(foot, local, sizeof foot);
    vor_surface_project(&surface, foot);
    for (int c = 0; c < 3; c++)
        off2 += (local[c] - foot[c]) * (local[c] - foot[c]);
    return off2 > FAR * FAR * surface.off2 * NEIGHBORS / (NEIGHBORS - VOR_QUADRIC_TERMS) &&
           off2 > APART * APART * surface.spacing * surface.spacing;
}

/* Whether point i lies off the surface around itself, or around the point nearest to it. Lists are
 * those of the points from `begin` on, before `end`; guess is how far, squared, their last may be.
 */
static int is_off_either(const struct vor_domain *domain, size_t i, const uint32_t *lists,
                         size_t begin, size_t end, float guess)
{
    const uint32_t *own = &lists[(i - begin) * WIDTH], *around = own;
    size_t nearest = own[0] != i ? own[0] : own[1];
    uint32_t other[WIDTH];
    float distance2[WIDTH];

    if (is_off(domain, i, own))
        return 1;
    if (nearest >= begin && nearest < end) {
        around = &lists[(nearest - begin) * WIDTH];
    } else {
        vor_knn_search_near(
            domain->knn, &(struct vor_knn_near){&domain->xyz[3 * nearest], 1, WIDTH, NULL, guess},
            other, distance2);
        around = other;
    }
    return is_off(domain, i, around);
}

static void point_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct look *look = ctx;
    uint32_t index[BLOCK * WIDTH];
    float distance2[BLOCK * WIDTH];
    struct vor_knn_near near = {.k = WIDTH};

    for (size_t i = begin; i < end; i += near.count) { /* which lie near each other */
        near.queries = &look->domain->xyz[3 * i];
        near.count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        vor_knn_search_near(look->domain->knn, &near, &index[(i - begin) * WIDTH],
                            &distance2[(i - begin) * WIDTH]);
    }
    for (size_t i = begin; i < end; i++) {
        const uint32_t *nearest = &index[(i - begin) * WIDTH];

        for (size_t j = 0; j < WIDTH; j++)
            if (nearest[j] != i)
                atomic_fetch_add_explicit(&look->pointed[nearest[j]], 1, memory_order_relaxed);
        look->is_out[i] =
            (unsigned char)(is_scattered(look, nearest,
                                         (double)distance2[(i - begin) * WIDTH + NEIGHBORS]) ||
                            (look->closer &&
                             is_off_either(look->domain, i, index, begin, end, near.guess)));
    }
}

static void judge_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct look *look = ctx;

    look->is_out[i] |= atomic_load_explicit(&look->pointed[i], memory_order_relaxed) < POINTED;
}

/* Adds `count` points of the domain to those aside. */
static vor_status put_aside(struct vor_outliers *aside, size_t count, const struct look *look,
                            struct vor_error *err)
{
    const struct vor_domain *domain = look->domain;
    struct vor_outliers all = {.memory = domain->memory};

    all.xyz = vor_malloc(all.memory, aside->n + count, 3 * sizeof *all.xyz);
    all.source = vor_malloc(all.memory, aside->n + count, sizeof *all.source);
    if (all.xyz == NULL || all.source == NULL) {
        vor_outliers_free(&all);
        return vor_fail(err, VOR_E_NOMEM, "%zu outliers", aside->n + count);
    }
    if (aside->n > 0) {
        memcpy(all.xyz, aside->xyz, 3 * aside->n * sizeof *all.xyz);
        memcpy(all.source, aside->source, aside->n * sizeof *all.source);
    }
    all.n = aside->n;
    for (size_t i = 0; i < domain->n; i++) {
        if (!look->is_out[i])
            continue;
        memcpy(&all.xyz[3 * all.n], &domain->xyz[3 * i], 3 * sizeof *all.xyz);
        all.source[all.n++] = domain->source[i];
    }
    vor_outliers_free(aside);
    *aside = all;
    return VOR_OK;
}

/* Finds the outliers of one look. */
static vor_status search(struct look *look, const struct vor_run *run, struct vor_error *err)
{
    size_t n = look->domain->n;
    vor_status status;

    look->pointed = vor_calloc(run->memory, n, sizeof *look->pointed);
    look->is_out = vor_malloc(run->memory, n, sizeof *look->is_out);
    if (look->pointed == NULL || look->is_out == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    find_sparse(look);
    status = vor_run_for(run, n, BLOCK, point_block, look, err);
    VOR_THEN(status, vor_run_rows(run, n, ROW_BLOCK, judge_row, look, err));
    return status;
}

/* Looks once; *taken is the number of points it took out. */
static vor_status take(struct vor_domain *domain, size_t *taken, struct vor_outliers *aside,
                       int closer, const struct vor_run *run, struct vor_error *err)
{
    struct look look = {.domain = domain, .closer = closer};
    vor_status status;

    *taken = 0;
    if (domain->n < VOR_DOMAIN_FEW)
        return VOR_OK;
    status = search(&look, run, err);
    if (status == VOR_OK)
        for (size_t i = 0; i < domain->n; i++)
            *taken += look.is_out[i];
    if (*taken > domain->n / VOR_REMOTE_FEW)
        *taken = 0;
    if (*taken > 0)
        status = put_aside(aside, *taken, &look, err);
    if (*taken > 0 && status == VOR_OK) {
        size_t kept = 0;

        for (size_t i = 0; i < domain->n; i++) {
            if (look.is_out[i])
                continue;
            memmove(&domain->xyz[3 * kept], &domain->xyz[3 * i], 3 * sizeof *domain->xyz);
            domain->source[kept++] = domain->source[i];
        }
        domain->n = kept;
    }
    VOR_FREE_ALL(run->memory, look.is_out, look.pointed);
    if (*taken == 0 || status != VOR_OK)
        return status;
    vor_knn_free(domain->knn);
    domain->knn = NULL;
    return vor_domain_index(domain, run, err); /* what strays had in sparse is gone, too */
}

/* Looks until a look finds none, LOOKS times at most. */
static vor_status take_all(struct vor_domain *domain, struct vor_outliers *aside, int closer,
                           const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;
    size_t taken = 1;

    for (int look = 0; look < LOOKS && status == VOR_OK && taken > 0; look++)
        status = take(domain, &taken, aside, closer, run, err);
    return status;
}

/* A cloud without its remote points. */
struct rest {
    const struct vor_cloud *in;
    struct vor_remote remote;
    struct vor_cloud near; /* of the others, the positions alone */
    uint32_t *kept;        /* their numbers in the cloud */
};

static vor_status make_of_rest(struct vor_domain *domain, struct vor_outliers *aside,
                               struct rest *rest, const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    rest->near.n = 0;
    for (size_t i = 0; i < rest->in->n; i++)
        if (vor_remote_is(&rest->remote, rest->in, i)) {
            aside->source[aside->n++] = (uint32_t)i;
        } else {
            memcpy(&rest->near.xyz[3 * rest->near.n], &rest->in->xyz[3 * i],
                   3 * sizeof *rest->in->xyz);
            rest->kept[rest->near.n++] = (uint32_t)i;
        }
    status = vor_domain_init(domain, &rest->near, run, err);
    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < domain->n; i++)
        domain->source[i] = rest->kept[domain->source[i]];
    for (size_t i = 0; i < aside->n; i++)
        vor_domain_normalise(domain, &rest->in->xyz[3 * (size_t)aside->source[i]],
                             &aside->xyz[3 * i]);
    return VOR_OK;
}

vor_status vor_outliers_remote(struct vor_outliers *out, struct vor_domain *domain,
                               const struct vor_cloud *in, const struct vor_run *run,
                               struct vor_error *err)
{
    struct vor_outliers aside = {.memory = run->memory};
    struct rest rest = {.in = in, .near = *in};
    vor_status status = VOR_E_NOMEM;

    vor_remote_find(&rest.remote, in);
    if (rest.remote.count == 0)
        return VOR_E_DEGENERATE;
    rest.kept = vor_malloc(run->memory, in->n, sizeof *rest.kept);
    rest.near.xyz = vor_malloc(run->memory, in->n, 3 * sizeof *rest.near.xyz);
    aside.xyz = vor_malloc(run->memory, rest.remote.count, 3 * sizeof *aside.xyz);
    aside.source = vor_malloc(run->memory, rest.remote.count, sizeof *aside.source);
    if (rest.kept == NULL || rest.near.xyz == NULL || aside.xyz == NULL || aside.source == NULL)
        (void)vor_fail(err, status, "%zu points without distant outliers", in->n);
    else
        status = make_of_rest(domain, &aside, &rest, run, err);
    VOR_FREE_ALL(run->memory, rest.near.xyz, rest.kept);
    if (status == VOR_OK)
        *out = aside;
    else
        vor_outliers_free(&aside);
    return status;
}

vor_status vor_outliers_take(struct vor_outliers *out, struct vor_domain *domain, int closer,
                             const struct vor_run *run, struct vor_error *err)
{
    vor_status status = take_all(domain, out, 0, run, err);

    return status == VOR_OK && closer ? take_all(domain, out, 1, run, err) : status;
}

vor_status vor_outliers_drop(struct vor_domain *domain, size_t *dropped, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_outliers aside = {.memory = domain->memory};
    vor_status status = vor_outliers_take(&aside, domain, 0, run, err);

    *dropped = aside.n;
    vor_outliers_free(&aside);
    return status;
}

void vor_outliers_free(struct vor_outliers *outliers)
{
    VOR_FREE_ALL(outliers->memory, outliers->source, outliers->xyz);
    outliers->source = NULL;
    outliers->xyz = NULL;
    outliers->n = 0;
}

/* Outliers on their way back. */
struct pull {
    const struct vor_domain *domain;
    const struct vor_outliers *outliers;
    float *foot;    /* n x 3: where each goes */
    uint64_t *goes; /* n: the point of the domain nearest to it, times 2^32, plus its own number */
};

/* Moves x onto a surface, at most a spacing along it away from the origin, the point of the domain
 * nearest to x: beyond the border of the input there is no surface. */
static void put_near(const struct vor_surface *surface, double x[3])
{
    double local[3] = {0, 0, 0}, off;

    if (surface->kind != VOR_SURFACE_NONE) {
        vor_surface_to_local(surface, x, local);
        vor_surface_project(surface, local);
        off = sqrt(local[0] * local[0] + local[1] * local[1]);
        for (int c = 0; c < 2 && off > surface->spacing; c++)
            local[c] *= surface->spacing / off;
        local[2] = vor_surface_height(surface, local[0], local[1], NULL);
    }
    vor_surface_to_world(surface, local, x);
}

static void pull_point(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct pull *pull = ctx;
    const struct vor_domain *domain = pull->domain;
    const float *from = &pull->outliers->xyz[3 * i];
    float near[3 * VOR_NEIGHBORS_MAX], distance2[VOR_NEIGHBORS_MAX];
    uint32_t index[VOR_NEIGHBORS_MAX], nearest;
    double x[3] = {(double)from[0], (double)from[1], (double)from[2]};
    struct vor_surface surface;
    const float *root;
    unsigned k;

    vor_knn_search(domain->knn, from, 1, 1, &nearest, distance2);
    root = &domain->xyz[3 * (size_t)nearest];
    k = vor_neighbors_at(&domain->known.neighbors, root);
    k = k < domain->n ? k : (unsigned)domain->n;
    vor_knn_search(domain->knn, root, 1, k, index, distance2);
    vor_gather(near, domain->xyz, index, k);
    (void)vor_sheets_fit(&surface, near, domain,
                         (double[3]){(double)root[0], (double)root[1], (double)root[2]}, k, NULL);
    put_near(&surface, x);
    for (size_t c = 0; c < 3; c++)
        pull->foot[3 * i + c] = (float)fmax(-1, fmin(1, x[c]));
    pull->goes[i] = (uint64_t)nearest << 32 | i;
}

static int earlier(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

/* Fills the domain's new arrays: after each of its points the outliers that it was nearest to, so
 * that points near in space stay near in the order. */
static void merge(float *xyz, uint32_t *source, const struct pull *pull)
{
    const struct vor_domain *domain = pull->domain;
    size_t at = 0, next = 0;

    for (size_t i = 0; i < domain->n; i++) {
        memcpy(&xyz[3 * at], &domain->xyz[3 * i], 3 * sizeof *xyz);
        source[at++] = domain->source[i];
        for (; next < pull->outliers->n && pull->goes[next] >> 32 == i; next++) {
            size_t own = (size_t)(uint32_t)pull->goes[next];

            memcpy(&xyz[3 * at], &pull->foot[3 * own], 3 * sizeof *xyz);
            source[at++] = pull->outliers->source[own];
        }
    }
}

/* Puts the outliers, which have their places, into the domain. */
static vor_status insert(struct vor_domain *domain, const struct pull *pull,
                         const struct vor_run *run, struct vor_error *err)
{
    size_t n = domain->n + pull->outliers->n;
    float *xyz = vor_malloc(domain->memory, n, 3 * sizeof *xyz);
    uint32_t *source = vor_malloc(domain->memory, n, sizeof *source);

    if (xyz == NULL || source == NULL) {
        VOR_FREE_ALL(domain->memory, source, xyz);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    }
    qsort(pull->goes, pull->outliers->n, sizeof *pull->goes, earlier);
    merge(xyz, source, pull);
    vor_free(domain->memory, domain->source);
    domain->source = source;
    domain->n = n;
    return vor_domain_move(domain, xyz, run, err);
}

vor_status vor_outliers_pull(struct vor_domain *domain, const struct vor_outliers *outliers,
                             const struct vor_run *run, struct vor_error *err)
{
    struct pull pull = {.domain = domain, .outliers = outliers};
    vor_status status;

    if (outliers->n == 0)
        return VOR_OK;
    pull.foot = vor_malloc(run->memory, outliers->n, 3 * sizeof *pull.foot);
    pull.goes = vor_malloc(run->memory, outliers->n, sizeof *pull.goes);
    if (pull.foot == NULL || pull.goes == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu outliers", outliers->n);
    } else {
        status = vor_run_rows(run, outliers->n, BLOCK, pull_point, &pull, err);
        VOR_THEN(status, insert(domain, &pull, run, err));
    }
    VOR_FREE_ALL(run->memory, pull.goes, pull.foot);
    return status;
}
