#include "core/align/match.h"

#include "core/base/rng.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    QUERIES = 1500, /* pairs of the cloud that are laid on the reference */
    TRIED = 200,    /* pairs of the reference for each */
    GLANCE = 40,    /* samples that say which of these are looked at again */
    ANGLES = 8,     /* bins of a cosine */
    LENGTHS = 24,   /* bins of a length, as wide as the few are apart */
    BINS = LENGTHS * ANGLES * ANGLES * ANGLES,
    CELLS_MAX = 1 << 22, /* of a grid */
    BLOCK = 8,           /* queries of a task */
    BOTH = 2             /* sides */
};

/* Chooses cells around the samples: two for each reach, but not too many. Returns how many. */
static size_t choose_cells(struct vor_align_grid *grid)
{
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    size_t cells = SIZE_MAX;

    for (int c = 0; c < 3; c++)
        grid->low[c] = INFINITY;
    for (size_t i = 0; i < 3 * grid->samples->n; i++) {
        double x = (double)grid->samples->xyz[i];

        grid->low[i % 3] = fmin(grid->low[i % 3], x - grid->reach);
        high[i % 3] = fmax(high[i % 3], x + grid->reach);
    }
    grid->edge = grid->reach / 4;
    while (cells > CELLS_MAX) {
        grid->edge *= 2;
        cells = 1;
        for (int c = 0; c < 3; c++) {
            grid->wide[c] = (size_t)((high[c] - grid->low[c]) / grid->edge) + 1;
            cells *= grid->wide[c];
        }
    }
    return cells;
}

/* Offers sample i to the cells within reach of it. */
static void offer(struct vor_align_grid *grid, float *near2, uint32_t i)
{
    const float *x = &grid->samples->xyz[3 * (size_t)i];
    size_t first[3], last[3], at[3];

    for (int c = 0; c < 3; c++) {
        double from = ((double)x[c] - grid->low[c] - grid->reach) / grid->edge;
        double to = ((double)x[c] - grid->low[c] + grid->reach) / grid->edge;

        first[c] = (size_t)fmax(from, 0);
        last[c] = (size_t)fmin(to, (double)(grid->wide[c] - 1));
    }
    for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
        for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
            for (at[2] = first[2]; at[2] <= last[2]; at[2]++) {
                size_t cell = (at[0] * grid->wide[1] + at[1]) * grid->wide[2] + at[2];
                double d2 = 0;

                for (int c = 0; c < 3; c++) {
                    double d = grid->low[c] + ((double)at[c] + 0.5) * grid->edge - (double)x[c];

                    d2 += d * d;
                }
                if ((float)d2 < near2[cell]) {
                    near2[cell] = (float)d2;
                    grid->nearest[cell] = i;
                }
            }
}

vor_status vor_align_grid_make(struct vor_align_grid *out, const struct vor_align_samples *samples,
                               double reach, struct vor_error *err)
{
    struct vor_align_grid grid = {.memory = samples->memory, .samples = samples, .reach = reach};
    size_t cells = choose_cells(&grid);
    float *near2 = vor_malloc(grid.memory, cells, sizeof *near2);

    grid.nearest = vor_malloc(grid.memory, cells, sizeof *grid.nearest);
    if (grid.nearest == NULL || near2 == NULL) {
        VOR_FREE_ALL(grid.memory, grid.nearest, near2);
        return vor_fail(err, VOR_E_NOMEM, "%zu cells", cells);
    }
    for (size_t i = 0; i < cells; i++) {
        grid.nearest[i] = UINT32_MAX;
        near2[i] = (float)(reach * reach);
    }
    for (size_t i = 0; i < samples->n; i++)
        offer(&grid, near2, (uint32_t)i);
    vor_free(grid.memory, near2);
    *out = grid;
    return VOR_OK;
}

void vor_align_grid_free(struct vor_align_grid *grid)
{
    if (grid->memory != NULL)
        vor_free(grid->memory, grid->nearest);
    grid->nearest = NULL;
}

/* The few of a cloud in double precision, where they are looked at most. */
struct few {
    size_t n;
    double (*x)[3], (*normal)[3];
};

struct pair {
    uint16_t a, b;
};

struct match {
    const struct vor_align_samples *cloud;
    const struct vor_align_grid *grid;
    struct few of[2]; /* cloud, reference */
    double step;      /* of lengths */
    uint32_t *first;  /* BINS + 1 */
    struct pair *pair;
    unsigned sides;                    /* of the normals that are tried */
    struct vor_align_candidate *found; /* the best of each query and side */
};

static vor_status take_few(struct few *out, const struct vor_align_samples *samples,
                           struct vor_error *err)
{
    out->n = samples->few;
    out->x = vor_malloc(samples->memory, out->n, sizeof *out->x);
    out->normal = vor_malloc(samples->memory, out->n, sizeof *out->normal);
    if (out->x == NULL || out->normal == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu samples", out->n);
    for (size_t i = 0; i < out->n; i++) {
        vor_to_doubles(out->x[i], &samples->xyz[3 * (size_t)samples->chosen[i]]);
        vor_to_doubles(out->normal[i], &samples->normal[3 * (size_t)samples->chosen[i]]);
    }
    return VOR_OK;
}

/* Sets the unit vector from one point to the other. Returns the distance. */
static double direct(double out[3], const double a[3], const double b[3])
{
    double length;

    for (int c = 0; c < 3; c++)
        out[c] = b[c] - a[c];
    length = sqrt(vor_dot(out, out));
    for (int c = 0; c < 3; c++)
        out[c] /= length;
    return length;
}

static unsigned angle_bin(double cosine)
{
    double bin = (cosine + 1) * (ANGLES / 2.0);

    return bin < ANGLES - 1 ? (unsigned)fmax(bin, 0) : ANGLES - 1;
}

/* The bin of a pair by its length and angles; BINS where it is too long, or has no direction. */
static unsigned bin_of(const struct match *match, const struct few *few, struct pair pair, int flip)
{
    const double *n = few->normal[pair.a], *m = few->normal[pair.b];
    double along[3], length = direct(along, few->x[pair.a], few->x[pair.b]);
    double sign = flip ? -1 : 1;

    if (!(length > 0 && length < LENGTHS * match->step))
        return BINS;
    return (((unsigned)(length / match->step) * ANGLES + angle_bin(sign * vor_dot(n, along))) *
                ANGLES +
            angle_bin(sign * vor_dot(m, along))) *
               ANGLES +
           angle_bin(vor_dot(n, m));
}

/* Sorts the pairs of the reference by bins. */
static vor_status sort_pairs(struct match *match, struct vor_memory *memory, struct vor_error *err)
{
    const struct few *few = &match->of[1];
    size_t pairs = few->n * few->n, sum = 0;
    uint32_t *bin = vor_malloc(memory, pairs, sizeof *bin);

    assert(few->x != NULL && few->normal != NULL);
    match->first = vor_calloc(memory, BINS + 2, sizeof *match->first);
    match->pair = vor_malloc(memory, pairs, sizeof *match->pair);
    if (bin == NULL || match->first == NULL || match->pair == NULL) {
        vor_free(memory, bin);
        return vor_fail(err, VOR_E_NOMEM, "%zu pairs", pairs);
    }
    for (size_t i = 0; i < pairs; i++) {
        struct pair pair = {(uint16_t)(i / few->n), (uint16_t)(i % few->n)};

        bin[i] = pair.a == pair.b ? BINS : bin_of(match, few, pair, 0);
        match->first[bin[i]]++;
    }
    for (size_t b = 0; b <= BINS; b++) {
        sum += match->first[b];
        match->first[b] = (uint32_t)sum;
    }
    for (size_t i = pairs; i-- > 0;)
        match->pair[--match->first[bin[i]]] =
            (struct pair){(uint16_t)(i / few->n), (uint16_t)(i % few->n)};
    vor_free(memory, bin);
    return VOR_OK;
}

/* Axes of a pair: along it, and towards the mean of its normals. Returns whether there are any. */
static int axes_of(double out[3][3], const struct few *few, struct pair pair)
{
    double length;

    (void)direct(out[0], few->x[pair.a], few->x[pair.b]);
    for (int c = 0; c < 3; c++)
        out[1][c] = few->normal[pair.a][c] + few->normal[pair.b][c];
    vor_remove_along(out[1], out[0], 0);
    length = sqrt(vor_dot(out[1], out[1]));
    if (!(length > VOR_ROUNDED))
        return 0;
    for (int c = 0; c < 3; c++)
        out[1][c] /= length;
    vor_cross(out[2], out[0], out[1]);
    return 1;
}

/* The pose that lays a pair of the cloud with these axes on one of the reference. */
static int lay(struct vor_pose *out, const struct match *match, struct pair from,
               const double axes[3][3], struct pair onto)
{
    const struct few *cloud = &match->of[0], *reference = &match->of[1];
    double other[3][3], middle[3], moved[3];

    if (!axes_of(other, reference, onto))
        return 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            out->turn[r][c] =
                other[0][r] * axes[0][c] + other[1][r] * axes[1][c] + other[2][r] * axes[2][c];
    for (int c = 0; c < 3; c++)
        middle[c] = (cloud->x[from.a][c] + cloud->x[from.b][c]) / 2;
    vor_pose_turn(out, middle, moved);
    out->scale = 1;
    for (int c = 0; c < 3; c++)
        out->shift[c] = (reference->x[onto.a][c] + reference->x[onto.b][c]) / 2 - moved[c];
    return 1;
}

/* How much of the few from..end - 1 lies on the reference: their mean of 1 - (distance / reach)^2,
 * 0 where normals differ. */
static double score(const struct match *match, const struct vor_pose *pose, int flip, size_t from,
                    size_t end)
{
    const struct few *few = &match->of[0];
    const struct vor_align_samples *reference = match->grid->samples;
    double sum = 0, sign = flip ? -1 : 1, reach2 = match->grid->reach * match->grid->reach;

    for (size_t i = from; i < end; i++) {
        double x[3], normal[3], n[3], off;
        uint32_t at;

        vor_pose_move(pose, few->x[i], x);
        at = vor_align_grid_at(match->grid, x);
        if (at == UINT32_MAX)
            continue;
        vor_pose_turn(pose, few->normal[i], normal);
        vor_to_doubles(n, &reference->normal[3 * (size_t)at]);
        if (!(sign * vor_dot(n, normal) > VOR_ALIGN_ALIKE))
            continue;
        off = 0;
        for (int c = 0; c < 3; c++)
            off += n[c] * (x[c] - (double)reference->xyz[3 * (size_t)at + (size_t)c]);
        sum += fmax(0, 1 - off * off / reach2);
    }
    return sum;
}

/* Lays one pair of the cloud on those of the reference that are alike, and keeps the best pose. */
static void try_query(struct vor_align_candidate *best, const struct match *match, size_t query,
                      int flip)
{
    const struct few *few = &match->of[0];
    size_t glance = few->n < GLANCE ? few->n : GLANCE;
    struct pair from = {(uint16_t)vor_rng_below(1, 0, query, few->n),
                        (uint16_t)vor_rng_below(1, 1, query, few->n)};
    double axes[3][3];
    size_t bin, begin, many, tried;

    best->score = -1;
    best->flip = flip;
    best->query = (uint32_t)query;
    if (from.a == from.b || (bin = bin_of(match, few, from, flip)) == BINS ||
        !axes_of(axes, few, from))
        return;
    if (flip)
        for (int c = 0; c < 3; c++) {
            axes[1][c] = -axes[1][c];
            axes[2][c] = -axes[2][c];
        }
    begin = match->first[bin];
    many = match->first[bin + 1] - begin;
    tried = many < TRIED ? many : TRIED;
    for (size_t i = 0; i < tried; i++) {
        struct vor_pose pose;
        struct pair onto = match->pair[begin + i * many / tried];
        double found;

        if (!lay(&pose, match, from, (const double(*)[3])axes, onto))
            continue;
        found = score(match, &pose, flip, 0, glance);
        if (found > best->score) {
            best->score = found;
            best->pose = pose;
        }
    }
    if (best->score >= 0)
        best->score = score(match, &best->pose, flip, 0, few->n) / (double)few->n;
}

static void try_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct match *match = ctx;

    try_query(&match->found[i], match, i / match->sides, (int)(i % match->sides));
}

static int better_first(const void *a, const void *b)
{
    const struct vor_align_candidate *first = a, *second = b;

    if (first->score > second->score || first->score < second->score)
        return first->score > second->score ? -1 : 1;
    return first->query < second->query ? -1 : first->query > second->query;
}

static void keep_best(struct vor_align_candidate *out, unsigned *count, const struct match *match,
                      size_t n)
{
    const struct vor_align_candidate *found = match->found;

    qsort(match->found, n, sizeof *found, better_first);
    *count = 0;
    for (size_t i = 0; i < n && *count < VOR_ALIGN_CANDIDATES && found[i].score > 0; i++) {
        int known = 0;

        for (unsigned j = 0; j < *count; j++)
            known |= out[j].flip == found[i].flip &&
                     vor_poses_are_alike(&out[j].pose, &found[i].pose, match->step);
        if (!known)
            out[(*count)++] = found[i];
    }
}

vor_status vor_align_match(struct vor_align_candidate out[VOR_ALIGN_CANDIDATES], unsigned *count,
                           const struct vor_align_samples *cloud,
                           const struct vor_align_grid *reference, int both,
                           const struct vor_run *run, struct vor_error *err)
{
    struct match match = {.cloud = cloud,
                          .grid = reference,
                          .step = fmax(cloud->apart, reference->samples->apart),
                          .sides = both ? BOTH : 1};
    size_t n = (size_t)QUERIES * match.sides;
    vor_status status = take_few(&match.of[0], cloud, err);

    if (status == VOR_OK)
        status = take_few(&match.of[1], reference->samples, err);
    if (status == VOR_OK)
        status = sort_pairs(&match, run->memory, err);
    match.found = vor_calloc(run->memory, n, sizeof *match.found);
    if (status == VOR_OK && match.found == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu poses", n);
    if (status == VOR_OK)
        status = vor_run_rows(run, n, BLOCK, try_row, &match, err);
    if (status == VOR_OK)
        keep_best(out, count, &match, n);
    VOR_FREE_ALL(run->memory, match.of[0].x, match.of[0].normal, match.of[1].x, match.of[1].normal,
                 match.first, match.pair, match.found);
    return status;
}
