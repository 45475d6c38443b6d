#include "core/input/settle.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/boundary.h"
#include "core/geom/metric.h"
#include "core/geom/surface.h"
#include "core/input/noise.h"

#include <math.h>
#include <string.h>

/* Figures are rms distances to the true surface over that of the input, of a gear with teeth six
 * deviations wide and noise of 1 spacing, four sheets 3.6 spacings apart with noise of 1.6, and
 * where there is a third, a gear with fewer points: 0.448, 0.267, 0.542 as it was. */
enum {
    BLOCK = 64, /* points of one task */
    /* Neighbours of a fit. At 150 / 256: 0.461, 0.295 / 0.448, 0.267. */
    MOST = VOR_NEIGHBORS_MAX / 2,
    /* Representatives within the reach of the usual fit, at most. At 50 / 100 / 200: 0.483, 0.266
     * / 0.448, 0.267 / 0.445, 0.271. */
    ENOUGH = 100,
    /* Points that a fit reaches at least; its weights leave half of them. At 20 / 40 / 60: four
     * sheets with noise of 0.8 spacings 0.511 / 0.471 / 0.443, walls 2.9 spacings apart with noise
     * of 0.5 0.642 / 0.613 / 0.699. */
    LEAST = 2 * VOR_NEIGHBORS_FEWEST,
    /* Passes; and in each, steps to a plane and to a quadric. Two passes: 0.469. */
    STEPS = 3,
    CANDIDATES = 12, /* nearest points whose planes are tried. At 8: 0.451, 0.270, 0.541. */
    TERMS = 6        /* of a quadric */
};

/* Deviations that a fit reaches, and that a point may move. */
#define REACH VOR_NOISE_REACH
/* Deviations from a quadric or a plane beyond which points do not count; after the first pass, half
 * as many from a quadric. At 2 / 2.5 of a quadric, as REACH: 0.55 / 0.52; at 1.5 / 2.5 of a plane:
 * 0.448, 0.267, 0.542 / 0.448, 0.268, 0.530. */
#define SLAB (REACH / 2)

/* One pass over the representatives. */
struct pass {
    const struct vor_noise *noise;
    const struct vor_halves *halves; /* among which neighbours are searched */
    unsigned shift;             /* one point in 1 << shift of the domain is in level 0 of them */
    const float *from, *origin; /* where points are, and were before the first pass */
    const float *before;        /* normals of the pass before; NULL in the first */
    float *xyz, *normal;        /* where points go */
};

/* The points around one, and where it has come to. */
struct hood {
    unsigned k;
    uint32_t index[MOST];
    float near[3 * MOST];
    double noise;
    double from[3], x[3];
    double axis[3][3]; /* the last is the normal of a plane through x */
};

/* How many points of the domain around a place lie as near as those that a fit reaches; where more
 * than the reach counts coincide, as many as there may be. */
static double wanted_at(const struct vor_noise *noise, size_t place)
{
    double wide = (REACH + 1) * noise->deviation[place] / noise->reach[place];

    return fmin(VOR_LADDER_LAST * wide * wide, UINT32_MAX);
}

/* Finds the points around one, among so few that as many as can be reach far enough. */
static void search(struct hood *hood, const struct pass *pass, size_t place)
{
    double wanted = wanted_at(pass->noise, place) / (double)(1U << pass->shift);
    unsigned level = 0, last = pass->halves->levels - 1;
    float from[3], distance2[MOST];

    for (; wanted > MOST && level < last; level++)
        wanted /= 2;
    for (int c = 0; c < 3; c++)
        from[c] = (float)hood->from[c];
    hood->k = (unsigned)fmax(LEAST, fmin(MOST, wanted));
    vor_knn_search(pass->halves->level[level].knn, from, 1, hood->k, hood->index, distance2);
    vor_gather(hood->near, pass->halves->level[level].xyz, hood->index, hood->k);
}

static void offset(double d[3], const struct hood *hood, unsigned j, const double x[3])
{
    for (int c = 0; c < 3; c++)
        d[c] = (double)hood->near[3 * j + (unsigned)c] - x[c];
}

/* Moves x along the normal to the plane of the points within r. */
static void to_plane(struct hood *hood, double r)
{
    double total = 0, mean[3] = {0}, m[6] = {0}, values[3], vectors[3][3], off;

    for (unsigned j = 0; j < hood->k; j++) {
        double d[3], w;

        offset(d, hood, j, hood->x);
        w = vor_power(fmax(0, 1 - vor_dot(d, d) / (r * r)), 3);
        total += w;
        for (int a = 0, i = 0; a < 3; a++) {
            mean[a] += w * d[a];
            for (int b = a; b < 3; b++, i++)
                m[i] += w * d[a] * d[b];
        }
    }
    if (!(total > 0))
        return;
    for (int a = 0, i = 0; a < 3; a++)
        for (int b = a; b < 3; b++, i++)
            m[i] = m[i] / total - mean[a] * mean[b] / (total * total);
    vor_eigen3(values, vectors, m);
    memcpy(hood->axis[0], vectors[1], sizeof vectors[1]);
    memcpy(hood->axis[1], vectors[2], sizeof vectors[2]);
    memcpy(hood->axis[2], vectors[0], sizeof vectors[0]);
    off = vor_dot(mean, hood->axis[2]) / total;
    for (int c = 0; c < 3; c++)
        hood->x[c] += off * hood->axis[2][c];
}

/* Weighted sums over points: of products of two terms, and of heights times terms. */
struct sums {
    double a[TERMS * TERMS], c[TERMS];
};

/* Sums over the points near the quadric c over the plane through x: coefficients of 1, u, v, uu,
 * uv, vv, where u and v are over r. */
static void sum(struct sums *out, const double c[TERMS], const struct hood *hood, double r,
                double slab)
{
    memset(out, 0, sizeof *out);
    for (unsigned j = 0; j < hood->k; j++) {
        double d[3], f[TERMS] = {1}, flat, near, height, off, w;

        offset(d, hood, j, hood->x);
        f[1] = vor_dot(hood->axis[0], d) / r;
        f[2] = vor_dot(hood->axis[1], d) / r;
        flat = 1 - f[1] * f[1] - f[2] * f[2];
        if (!(flat > 0))
            continue;
        f[3] = f[1] * f[1];
        f[4] = f[1] * f[2];
        f[5] = f[2] * f[2];
        off = height = vor_dot(hood->axis[2], d);
        for (int p = 0; p < TERMS; p++)
            off -= c[p] * f[p];
        near = 1 - off * off / (slab * slab);
        if (!(near > 0))
            continue;
        w = flat * flat * near * near;
        for (int p = 0; p < TERMS; p++) {
            out->c[p] += w * f[p] * height;
            for (int q = 0; q <= p; q++)
                out->a[p * TERMS + q] += w * f[p] * f[q];
        }
    }
}

/* Moves x onto the quadric of the points within r along the plane and near the quadric itself, and
 * turns the normal to its own. */
static void to_quadric(struct hood *hood, double r, double slab)
{
    double height[TERMS] = {0}, u, v, length;

    for (int i = 0; i < STEPS; i++) {
        struct sums sums;

        sum(&sums, height, hood, r, slab);
        if (!(vor_solve_spd(sums.a, sums.c, TERMS, VOR_NEGLIGIBLE) > 0))
            break;
        memcpy(height, sums.c, sizeof height);
    }
    u = height[1] / r;
    v = height[2] / r;
    length = sqrt(1 + u * u + v * v);
    for (int c = 0; c < 3; c++) {
        hood->x[c] += height[0] * hood->axis[2][c];
        hood->axis[2][c] =
            (hood->axis[2][c] - u * hood->axis[0][c] - v * hood->axis[1][c]) / length;
    }
}

/* How many points within r along a plane lie near it, by weight. */
static double support(const struct hood *hood, const double x[3], const double normal[3], double r)
{
    double slab = SLAB * hood->noise, total = 0;

    for (unsigned j = 0; j < hood->k; j++) {
        double d[3], z, flat, near;

        offset(d, hood, j, x);
        z = vor_dot(d, normal);
        flat = 1 - (vor_dot(d, d) - z * z) / (r * r);
        near = 1 - z * z / (slab * slab);
        if (flat > 0 && near > 0)
            total += flat * flat * near * near;
    }
    return total;
}

static double distance2_of(const double x[3], const float origin[3])
{
    double sum = 0;

    for (int c = 0; c < 3; c++)
        sum += (x[c] - (double)origin[c]) * (x[c] - (double)origin[c]);
    return sum;
}

/* Takes the plane that the most points speak for: the one at hand, or that of one of the nearest
 * points. */
static void choose_plane(struct hood *hood, const struct pass *pass, const float *origin, double r)
{
    double best = support(hood, hood->x, hood->axis[2], r);
    double limit = REACH * hood->noise;

    for (unsigned j = 0; j < CANDIDATES && j < hood->k; j++) {
        const float *normal = &pass->before[3 * (size_t)hood->index[j]];
        double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]}, d[3], x[3], points;

        offset(d, hood, j, hood->from);
        for (int c = 0; c < 3; c++)
            x[c] = hood->from[c] + vor_dot(d, n) * n[c];
        if (!(vor_dot(n, n) > 0) || distance2_of(x, origin) > limit * limit)
            continue;
        points = support(hood, x, n, r);
        if (!(points > best))
            continue;
        best = points;
        memcpy(hood->x, x, sizeof x);
        memcpy(hood->axis[2], n, sizeof n);
        vor_metric_axes(hood->axis, hood->axis[2]);
    }
}

static void move_point(struct hood *hood, const struct pass *pass, const float *origin)
{
    double noise = hood->noise, r = REACH * noise, d[3] = {0, 0, 0};

    offset(d, hood, LEAST - 1, hood->from);
    r = fmax(r, sqrt(vor_dot(d, d)));
    for (int step = 0; step < STEPS; step++)
        to_plane(hood, r);
    if (pass->before != NULL)
        choose_plane(hood, pass, origin, r);
    to_quadric(hood, r, SLAB * noise / (pass->before != NULL ? 2 : 1));
    if (!(distance2_of(hood->x, origin) <= REACH * REACH * noise * noise))
        memcpy(hood->x, hood->from, sizeof hood->x);
}

static void move_row(void *ctx, size_t i, unsigned worker)
{
    const struct pass *pass = ctx;
    struct hood hood;

    (void)worker;
    size_t place = vor_noise_place(pass->noise, &pass->origin[3 * i]);

    for (size_t c = 0; c < 3; c++)
        hood.from[c] = hood.x[c] = (double)pass->from[3 * i + c];
    memset(hood.axis, 0, sizeof hood.axis);
    hood.noise = pass->noise->deviation[place];
    if (hood.noise > 0) {
        search(&hood, pass, place);
        move_point(&hood, pass, &pass->origin[3 * i]);
    }
    for (size_t c = 0; c < 3; c++) {
        pass->xyz[3 * i + c] = (float)fmax(-1, fmin(1, hood.x[c]));
        pass->normal[3 * i + c] = (float)hood.axis[2][c];
    }
}

/* How often a number is halved until it is at most the limit. */
static unsigned halvings(double number, double limit)
{
    unsigned count = 0;

    while (number > limit) {
        number /= 2;
        count++;
    }
    return count;
}

/* Adds the levels that fits around all places want, and says which has the representatives: the
 * fewest points of which the usual fit reaches half of ENOUGH. */
static vor_status choose_level(unsigned *out, struct vor_halves *halves,
                               const struct vor_noise *noise, const struct vor_run *run,
                               struct vor_error *err)
{
    double wanted[VOR_NOISE_PLACES] = {0};
    unsigned levels;
    size_t n = 0;
    vor_status status = VOR_OK;

    for (size_t place = 0; place < VOR_NOISE_PLACES; place++)
        if (noise->deviation[place] > 0)
            wanted[n++] = wanted_at(noise, place);
    vor_sort_doubles(wanted, n);
    *out = halvings(wanted[n / 2], ENOUGH);
    levels = halvings(wanted[n - 1], MOST);
    levels = levels > *out ? levels : *out;
    while (halves->levels <= levels && status == VOR_OK) {
        unsigned before = halves->levels;

        status = vor_halves_add(halves, VOR_NOISE_LEAST, run, err);
        if (halves->levels == before)
            break;
    }
    if (*out >= halves->levels)
        *out = halves->levels - 1;
    return status;
}

/* Moves representatives once. */
static vor_status move(struct vor_domain *some, struct pass *pass, const struct vor_run *run,
                       struct vor_error *err)
{
    vor_status status;

    pass->xyz = vor_malloc(run->memory, some->n, 3 * sizeof *pass->xyz);
    if (pass->xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", some->n);
    status = vor_run_rows(run, some->n, BLOCK, move_row, pass, err);
    if (status == VOR_OK)
        return vor_domain_move(some, pass->xyz, run, err);
    vor_free(run->memory, pass->xyz);
    return status;
}

/* Moves the representatives of a level. `some` becomes them, *normal their normals. */
static vor_status move_some(struct vor_domain *some, float *normal[2],
                            const struct vor_halves *halves, unsigned level,
                            const struct vor_noise *noise, const struct vor_run *run,
                            struct vor_error *err)
{
    const float *origin = halves->level[level].xyz;
    struct pass pass = {.noise = noise, .halves = halves, .from = origin, .origin = origin};
    struct vor_halves moved;
    vor_status status = VOR_OK;

    some->n = halves->level[level].n;
    for (int i = 0; i < 2; i++)
        normal[i] = vor_malloc(run->memory, some->n, 3 * sizeof *normal[i]);
    if (normal[0] == NULL || normal[1] == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", some->n);
    for (int i = 0; i < STEPS && status == VOR_OK; i++) {
        pass.before = i > 0 ? normal[(i + 1) % 2] : NULL;
        pass.normal = normal[i % 2];
        status = move(some, &pass, run, err);
        vor_halves_init(&moved, some);
        pass.halves = &moved;
        pass.shift = level;
        pass.from = some->xyz;
    }
    return status;
}

/* All points, and the representatives that they follow. */
struct rest {
    const struct vor_domain *domain, *some;
    const float *normal;
    const struct vor_noise *noise;
    struct pass pass; /* to search the representatives */
    float *beyond;    /* how far each of them is beyond the end of its surface */
    float *xyz;
};

/* How far x, on a surface with that normal, is beyond its straight end; the unit vector `inward`
 * leads back. The mean of the points around on the surface is r / 4 away at an end that noise of
 * r / REACH deviations blurs, and x / 2 more or less at a distance x from there, to a tenth of a
 * deviation up to three of them. Points without noise end VOR_EDGE_ROOM spacings before the surface
 * does, which those who spread points on it expect. */
static double beyond_end(double inward[3], const double x[3], const float normal[3],
                         const struct rest *rest, size_t place)
{
    double noise = rest->noise->deviation[place], slab = SLAB * noise, r = REACH * noise;
    double spacing = rest->noise->reach[place] * sqrt(M_PI / VOR_LADDER_LAST);
    double n[3], d[3] = {0, 0, 0}, total = 0, mean[3] = {0}, length;
    struct hood hood = {.from = {x[0], x[1], x[2]}};

    vor_to_doubles(n, normal);
    search(&hood, &rest->pass, place);
    offset(d, &hood, LEAST - 1, x);
    r = fmax(r, sqrt(vor_dot(d, d)));
    for (unsigned j = 0; j < hood.k; j++) {
        double z, flat, near, w;

        offset(d, &hood, j, x);
        z = vor_dot(d, n);
        flat = 1 - (vor_dot(d, d) - z * z) / (r * r);
        near = 1 - z * z / (slab * slab);
        if (!(flat > 0 && near > 0))
            continue;
        w = flat * flat * near * near;
        total += w;
        for (int c = 0; c < 3; c++)
            mean[c] += w * (d[c] - z * n[c]);
    }
    length = sqrt(vor_dot(mean, mean));
    for (int c = 0; c < 3; c++)
        inward[c] = length > 0 ? mean[c] / length : 0;
    return length > 0 ? 2 * length / total - r / 2 + VOR_EDGE_ROOM * spacing : 0;
}

static void end_row(void *ctx, size_t i, unsigned worker)
{
    const struct rest *rest = ctx;
    double x[3], inward[3];

    (void)worker;
    size_t place = vor_noise_place(rest->noise, &rest->some->xyz[3 * i]);

    vor_to_doubles(x, &rest->some->xyz[3 * i]);
    rest->beyond[i] = 0;
    if (rest->noise->deviation[place] > 0)
        rest->beyond[i] = (float)beyond_end(inward, x, &rest->normal[3 * i], rest, place);
}

/* Moves x onto the planes of the representatives around, which count the more the nearer they are
 * and the more they face as the nearest does; and where one of them is beyond the end of its
 * surface, back to that. */
static void follow_some(double x[3], const struct rest *rest, const float *from, size_t place)
{
    unsigned k = rest->some->n < CANDIDATES ? (unsigned)rest->some->n : CANDIDATES;
    double total = 0, move[3] = {0}, inward[3], beyond = 0;
    uint32_t index[CANDIDATES];
    float distance2[CANDIDATES];

    vor_knn_search(rest->some->knn, from, 1, k, index, distance2);
    for (unsigned j = 0; j < k; j++) {
        const float *to = &rest->some->xyz[3 * (size_t)index[j]];
        const float *n = &rest->normal[3 * (size_t)index[j]], *first = &rest->normal[3 * index[0]];
        double off = 0, alike = 0, near = 1 - (double)distance2[j] / (double)distance2[k - 1], w;

        for (int c = 0; c < 3; c++) {
            off += ((double)to[c] - x[c]) * (double)n[c];
            alike += (double)n[c] * (double)first[c];
        }
        w = near * near * alike * alike;
        total += w;
        beyond = fmax(beyond, (double)rest->beyond[index[j]]);
        for (int c = 0; c < 3; c++)
            move[c] += w * off * (double)n[c];
    }
    for (int c = 0; c < 3 && total > 0; c++)
        x[c] += move[c] / total;
    if (!(beyond > 0))
        return;
    beyond = fmax(0, beyond_end(inward, x, &rest->normal[3 * (size_t)index[0]], rest, place));
    for (int c = 0; c < 3; c++)
        x[c] += beyond * inward[c];
}

static void follow_row(void *ctx, size_t i, unsigned worker)
{
    const struct rest *rest = ctx;

    (void)worker;
    const float *from = &rest->domain->xyz[3 * i];
    size_t place = vor_noise_place(rest->noise, from);
    double limit = REACH * rest->noise->deviation[place];
    double x[3] = {(double)from[0], (double)from[1], (double)from[2]};

    if (limit > 0)
        follow_some(x, rest, from, place);
    if (!(distance2_of(x, from) <= limit * limit))
        for (int c = 0; c < 3; c++)
            x[c] = (double)from[c];
    for (size_t c = 0; c < 3; c++)
        rest->xyz[3 * i + c] = (float)fmax(-1, fmin(1, x[c]));
}

static vor_status follow(struct vor_domain *domain, const struct vor_domain *some,
                         const float *normal, const struct vor_noise *noise, unsigned level,
                         const struct vor_run *run, struct vor_error *err)
{
    struct vor_halves halves;
    struct rest rest = {.domain = domain,
                        .some = some,
                        .normal = normal,
                        .noise = noise,
                        .pass = {.noise = noise, .halves = &halves, .shift = level},
                        .beyond = vor_malloc(run->memory, some->n, sizeof *rest.beyond),
                        .xyz = vor_malloc(run->memory, domain->n, 3 * sizeof *rest.xyz)};
    vor_status status;

    vor_halves_init(&halves, some);
    if (rest.beyond == NULL || rest.xyz == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    else
        status = vor_run_rows(run, some->n, BLOCK, end_row, &rest, err);
    VOR_THEN(status, vor_run_rows(run, domain->n, BLOCK, follow_row, &rest, err));
    vor_free(run->memory, rest.beyond);
    if (status == VOR_OK)
        return vor_domain_move(domain, rest.xyz, run, err);
    vor_free(run->memory, rest.xyz);
    return status;
}

vor_status vor_settle(struct vor_domain *domain, int *moved, const struct vor_run *run,
                      struct vor_error *err)
{
    struct vor_domain some = {.memory = run->memory};
    struct vor_halves halves;
    struct vor_noise noise;
    float *normal[2] = {NULL, NULL};
    unsigned level;
    vor_status status;

    vor_halves_init(&halves, domain);
    status = vor_noise_find(&noise, &halves, &domain->known.neighbors, run, err);
    *moved = noise.wide;
    domain->known.hidden = noise.hidden;
    if (status == VOR_OK && noise.wide) {
        status = choose_level(&level, &halves, &noise, run, err);
        VOR_THEN(status, move_some(&some, normal, &halves, level, &noise, run, err));
        VOR_THEN(status, follow(domain, &some, normal[(STEPS - 1) % 2], &noise, level, run, err));
    }
    vor_halves_free(&halves);
    vor_free(run->memory, normal[0]);
    vor_free(run->memory, normal[1]);
    vor_domain_free(&some);
    return status;
}
