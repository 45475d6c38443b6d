#include "core/input/lattice.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/surface.h"
#include "core/input/neighbors.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Figures are of igea, 12,000 points of white noise in an octree of 5, 6, 7 and 8 bits (cells
 * of 1.0 to 0.5 spacings), to 1,500 or 3,000 points: rms distance to the true surface in 1e-4 of
 * its diagonal, whose spread is 1 %. What only decides whether a lattice is found moves none of
 * them: cells are either clear in the values or absent. */

enum {
    /* Fewer different values show no cell. 3 and 12 change nothing. */
    FEW = 6,
    /* One point in so many may be off the lattice, by whatever, and of the sample: a codec leaves
     * stray points. 100 and 800 change nothing. */
    STRAY = VOR_DOMAIN_FEW,
    /* Points whose spacing is taken: its mean is then within 3 %, by the 0.52 that white noise has.
     */
    PLACES = VOR_NEIGHBORS_PLACES,
    REGIONS_POLLED = 64, /* for the different lattices of parts */
    /* Points of a region of the order of the input: of a codec's many coincide. Of 12 clouds of two
     * grids that overlap, with regions of 1 / 4 blocks 6 / 12 are named. */
    SOURCE_BLOCK = 4 * VOR_LATTICE_BLOCK,
    BLOCK = 4096, /* points of one task */
};

/* Cells over spacing, below which the lattice does not matter, on any axis that has many levels.
 * With smoothing and without, at 5 to 9 bits (1.0 to 0.27 spacings): 23.7 and 26.5, 13.5
 * and 14.1, 8.8 and 9.1, 6.6 and 6.6, 5.9 and 5.5. */
#define SMALL 0.4
/* What a few roundings to float32 do to a number of 1: two steps of its last bit. */
#define FLOAT32 0x1p-22
/* Of a cell: how far a point may move. Half a cell is all that rounding did to it; a little less,
 * because the bound is rounded too. At 0.25 / 0.5 / 1: 24.3 / 23.7 / 23.6 and 14.1 / 13.5 / 13.6.
 */
#define INSIDE (0.5 - VOR_ROUNDED)

/* Times the variance that cells explain: residuals vary. At 0.7 / 1.4 / 2.8: 26.8 / 23.7 / 24.4
 * and 14.2 / 13.5 / 13.6. */
#define EXCUSED 1.4

/* The lattice along one axis. */
struct found {
    double cell, offset; /* cell 0: none */
    double limit;        /* how far a value may be off its level */
    int few;             /* too few levels to find a cell */
};

/* A sample of one axis. */
struct axis {
    size_t n, levels;
    double value[VOR_DOMAIN_SAMPLED]; /* ascending */
    double level[VOR_DOMAIN_SAMPLED]; /* the different ones of them */
    double gap[VOR_DOMAIN_SAMPLED];   /* between levels, ascending */
    double rounding;                  /* values nearer than twice this are one level */
};

static void find_levels(struct axis *axis, double rounding)
{
    axis->rounding = rounding;
    axis->levels = 0;
    for (size_t i = 0; i < axis->n; i++)
        if (i == 0 || axis->value[i] - axis->level[axis->levels - 1] > 2 * rounding)
            axis->level[axis->levels++] = axis->value[i];
    for (size_t i = 0; i + 1 < axis->levels; i++)
        axis->gap[i] = axis->level[i + 1] - axis->level[i];
    if (axis->levels > 1)
        vor_sort_doubles(axis->gap, axis->levels - 1);
}

/* Fits cell and offset to the levels within `width` of `where`. Returns false when these are on no
 * lattice. */
static int refine(const struct axis *axis, double *cell, double *offset, double where, double width)
{
    double n = 0, lost = 0, i1 = 0, i2 = 0, r1 = 0, ir = 0, det;
    size_t first = 0, end = axis->levels;

    while (first < end) {
        size_t middle = (first + end) / 2;

        if (where - axis->level[middle] > width)
            first = middle + 1;
        else
            end = middle;
    }
    for (size_t l = first; l < axis->levels && axis->level[l] - where <= width; l++) {
        double x = axis->level[l] - *offset, i, r;

        i = rint(x / *cell);
        r = x - i * *cell;
        if (fabs(r) > *cell / 4) { /* nearer to the middle between two levels */
            lost++;
            continue;
        }
        n++;
        i1 += i;
        i2 += i * i;
        r1 += r;
        ir += i * r;
    }
    if (lost > 2 + n) /* the offset is not exact yet */
        return 0;
    det = n * i2 - i1 * i1;
    if (det > 0) {
        *offset += (i2 * r1 - i1 * ir) / det;
        *cell += (n * ir - i1 * r1) / det;
    }
    return *cell > 0;
}

static size_t is_off(const struct found *found, double x)
{
    x -= found->offset;
    return fabs(x - found->cell * rint(x / found->cell)) > found->limit;
}

/* Whether the sample is on a lattice of about that cell; *out is the fitted one. */
static int follow(struct found *out, const struct axis *axis, double cell)
{
    double where = axis->value[axis->n / 2], offset = where;
    double span = axis->level[axis->levels - 1] - axis->level[0], width = 4 * cell;
    size_t stray = 0;

    while (width < 2 * span) {
        if (!refine(axis, &cell, &offset, where, width))
            return 0;
        width *= 2;
    }
    if (cell * VOR_ON_LEVEL < axis->rounding)
        return 0;
    out->cell = cell;
    out->offset = offset;
    out->limit = 2 * axis->rounding + VOR_ON_LEVEL * cell;
    for (size_t i = 0; i < axis->n; i++)
        stray += is_off(out, axis->value[i]);
    return stray * STRAY <= axis->n;
}

/* First with levels rounded, because all float32 values are on the lattice of their last bits. */
static void find_cell(struct found *out, struct axis *axis, double largest)
{
    const double roundings[] = {FLOAT32 * largest, 0};

    for (int i = 0; i < 2 && out->cell == 0 && !out->few; i++) {
        find_levels(axis, roundings[i]);
        out->few = axis->levels < FEW && roundings[i] <= VOR_ROUNDED;
        if (axis->levels >= FEW) {
            struct found found = {0}; /* the largest cell that the sample is on is taken */

            for (int share = 2; share < STRAY; share *= 2) {
                double gap = axis->gap[vor_quantile_rank(1.0 / share, axis->levels)];

                if (gap > 1.5 * out->cell && follow(&found, axis, gap) && found.cell > out->cell)
                    *out = found;
            }
        }
    }
}

struct check {
    const struct vor_domain *domain;
    struct found found[3];
    atomic_size_t stray[3];
};

static void check_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct check *check = ctx;

    for (size_t c = 0; c < 3; c++) {
        size_t stray = 0;

        for (size_t i = begin; i < end && check->found[c].cell > 0; i++)
            stray += is_off(&check->found[c], (double)check->domain->xyz[3 * i + c]);
        atomic_fetch_add_explicit(&check->stray[c], stray, memory_order_relaxed);
    }
}

static double mean_spacing(const struct vor_domain *domain)
{
    size_t places = domain->n < PLACES ? domain->n : PLACES;
    double sum = 0;

    for (size_t place = 0; place < places; place++) {
        size_t at = (size_t)(((double)place + 0.5) / (double)places * (double)domain->n);
        uint32_t index[2];
        float distance2[2];

        vor_knn_search(domain->knn, &domain->xyz[3 * at], 1, 2, index, distance2);
        sum += sqrt((double)distance2[1]);
    }
    return sum / (double)places;
}

/* Compares the cells with the spacing: whether they matter, and which are real. */
static void judge(struct vor_lattice *out, const struct check *check, double largest)
{
    int cells = 0;

    out->spacing = mean_spacing(check->domain);
    out->matters = 1;
    for (int c = 0; c < 3; c++) {
        double cell = out->cell[c] = check->found[c].cell;

        cells += cell > 0;
        if (!check->found[c].few && !(cell > SMALL * out->spacing))
            out->matters = 0;
    }
    if (cells < 2)
        out->matters = 0;
    for (int c = 0; c < 3; c++)
        if (!out->matters && VOR_ON_LEVEL * out->cell[c] < FLOAT32 * largest)
            out->cell[c] = 0;
}

/* Checks the lattice of the sample against all points. */
static vor_status check_all(struct vor_lattice *out, struct check *check, double largest,
                            const struct vor_run *run, struct vor_error *err)
{
    vor_status status = vor_run_for(run, check->domain->n, BLOCK, check_block, check, err);

    if (status != VOR_OK)
        return status;
    for (int c = 0; c < 3; c++)
        if (atomic_load(&check->stray[c]) > check->domain->n / STRAY)
            check->found[c].cell = 0;
    judge(out, check, largest);
    return VOR_OK;
}

/* is_full: looks no further once an axis has no cell. */
static vor_status find(struct vor_lattice *out, const struct vor_domain *domain, int is_full,
                       const struct vor_run *run, struct vor_error *err)
{
    struct check check = {.domain = domain};
    struct axis *axis;
    double largest = 1;

    memset(out, 0, sizeof *out);
    if (domain->n < VOR_DOMAIN_FEW)
        return VOR_OK;
    axis = vor_malloc(run->memory, 1, sizeof *axis);
    if (axis == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the search for a lattice");
    for (int c = 0; c < 3; c++)
        largest = fmax(largest, 1 + fabs(domain->shift[c]) / domain->unit);
    for (size_t c = 0; c < 3 && (!is_full || c == 0 || check.found[c - 1].cell > 0); c++) {
        axis->n = domain->n < VOR_DOMAIN_SAMPLED ? domain->n : VOR_DOMAIN_SAMPLED;
        for (size_t i = 0; i < axis->n; i++) {
            size_t at = (size_t)(((double)i + 0.5) / (double)axis->n * (double)domain->n);

            axis->value[i] = (double)domain->xyz[3 * at + c];
        }
        vor_sort_doubles(axis->value, axis->n);
        find_cell(&check.found[c], axis, largest);
    }
    vor_free(run->memory, axis);
    if (!(check.found[0].cell + check.found[1].cell + check.found[2].cell > 0) ||
        (is_full && !(check.found[2].cell > 0)))
        return VOR_OK;
    return check_all(out, &check, largest, run, err);
}

vor_status vor_lattice_find(struct vor_lattice *out, const struct vor_domain *domain,
                            const struct vor_run *run, struct vor_error *err)
{
    return find(out, domain, 0, run, err);
}

int vor_lattice_is_full(const struct vor_lattice *lattice)
{
    return lattice->cell[0] > 0 && lattice->cell[1] > 0 && lattice->cell[2] > 0;
}

int vor_lattice_is_wide(const struct vor_lattice *lattice)
{
    double widest = fmax(fmax(lattice->cell[0], lattice->cell[1]), lattice->cell[2]);

    return vor_lattice_is_full(lattice) && widest > VOR_CELL_SMALL * lattice->spacing;
}

/* Whether a region is looked at, of pairs of which one begins at every `step`-th; and which one it
 * is of these. */
static int is_polled(size_t region, size_t step)
{
    return step < 2 || region % step < 2;
}

static size_t row_of(size_t region, size_t step)
{
    return step < 2 ? region : 2 * (region / step) + region % step;
}

/* Keeps the lattices of regions that one beside them has too. count: points of those looked at. */
static void keep_shared(struct vor_regions *regions, const size_t *count, size_t step)
{
    int before = 0;

    for (size_t i = 0; i < regions->n; i++) {
        double *cell = regions->cell[i];
        int after = i + 1 < regions->n;

        for (size_t c = 0; c < 3 && after; c++)
            after = fabs(regions->cell[i + 1][c] - cell[c]) <= VOR_ON_LEVEL * cell[c];
        if (!(cell[0] > 0) || !(before || after))
            memset(cell, 0, sizeof regions->cell[i]);
        else
            regions->eligible += count[row_of(i, step)];
        before = after;
    }
}

/* Compares the regions with the one of the narrowest cells. A lattice is another one only if it is
 * along each axis: walls that a depth camera saw have depths some cells apart. */
static void find_pitches(struct vor_regions *regions)
{
    const double *fine = NULL;
    double ratio = 1 + VOR_ON_LEVEL;

    for (size_t i = 0; i < regions->n; i++) {
        const double *cell = regions->cell[i];

        if (cell[0] > 0 &&
            (fine == NULL || cell[0] + cell[1] + cell[2] < fine[0] + fine[1] + fine[2]))
            fine = cell;
    }
    for (size_t i = 0; i < regions->n && fine != NULL; i++) {
        const double *cell = regions->cell[i];
        int at = 0;

        for (int c = 1; c < 3; c++)
            at = cell[c] * fine[at] < cell[at] * fine[c] ? c : at;
        if (cell[at] > ratio * fine[at]) {
            ratio = cell[at] / fine[at];
            regions->pitch[0] = fine[at];
            regions->pitch[1] = cell[at];
        }
    }
}

/* Lists the points of the regions that are looked at, `many` for each of them at most. */
static void list_members(uint32_t *member, size_t *count, const struct vor_regions *regions,
                         const struct vor_domain *domain, size_t step)
{
    for (size_t i = 0; i < domain->n; i++) {
        size_t region = vor_region_of(regions, domain, i), row = row_of(region, step);

        if (is_polled(region, step))
            member[row * regions->many + count[row]++] = (uint32_t)i;
    }
}

/* Finds the lattices of regions of the order that out->by_source says; last: the largest number of
 * a point there. */
static vor_status find_by(struct vor_regions *out, const struct vor_domain *domain, size_t last,
                          size_t step, const struct vor_run *run, struct vor_error *err)
{
    size_t *count, rows;
    uint32_t *member;
    vor_status status = VOR_OK;

    out->many = out->by_source ? SOURCE_BLOCK : VOR_LATTICE_BLOCK;
    out->n = last / out->many + 1;
    rows = row_of(out->n, step) + 2;
    out->cell = vor_calloc(run->memory, out->n, sizeof *out->cell);
    member = vor_malloc(run->memory, rows, out->many * sizeof *member);
    count = vor_calloc(run->memory, rows, sizeof *count);
    if (out->cell == NULL || member == NULL || count == NULL) {
        VOR_FREE_ALL(run->memory, count, member);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    }
    list_members(member, count, out, domain, step);
    for (size_t i = 0; status == VOR_OK && i < out->n; i++) {
        float xyz[3 * SOURCE_BLOCK];
        struct vor_domain piece = *domain; /* in the index of all */
        struct vor_lattice found = {0};
        size_t row = row_of(i, step);

        if (!is_polled(i, step))
            continue;
        piece.xyz = xyz;
        piece.n = count[row];
        vor_gather(xyz, domain->xyz, &member[row * out->many], (unsigned)count[row]);
        status = find(&found, &piece, 1, run, err);
        for (int c = 0; c < 3; c++)
            out->widest[c] = fmax(out->widest[c], found.cell[c]);
        if (vor_lattice_is_wide(&found))
            memcpy(out->cell[i], found.cell, sizeof found.cell);
    }
    keep_shared(out, count, step);
    find_pitches(out);
    VOR_FREE_ALL(run->memory, count, member);
    return status;
}

vor_status vor_lattice_find_regions(struct vor_regions *out, const struct vor_domain *domain,
                                    size_t step, const struct vor_run *run, struct vor_error *err)
{
    struct vor_regions other = {.by_source = 1};
    vor_status status = find_by(out, domain, domain->n - 1, step, run, err);
    size_t last = 0;

    if (status != VOR_OK || out->eligible >= domain->n || domain->n <= SOURCE_BLOCK)
        return status; /* or there is no second region */
    for (size_t i = 0; i < domain->n; i++)
        last = domain->source[i] > last ? domain->source[i] : last;
    status = find_by(&other, domain, last, step, run, err);
    if (status == VOR_OK && other.eligible > out->eligible &&
        !(out->pitch[1] > (1 + VOR_ON_LEVEL) * other.pitch[1])) {
        vor_free(run->memory, out->cell);
        *out = other;
        other.cell = NULL;
    }
    vor_free(run->memory, other.cell);
    return status;
}

vor_status vor_lattice_survey(double pitch[2], const struct vor_domain *domain,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_regions regions = {0};
    size_t step = 2 * vor_blocks_of(domain->n, VOR_LATTICE_BLOCK) / REGIONS_POLLED;
    vor_status status = vor_lattice_find_regions(&regions, domain, step, run, err);

    memcpy(pitch, regions.pitch, sizeof regions.pitch);
    vor_free(run->memory, regions.cell);
    return status;
}

struct smooth {
    const struct vor_domain *domain;
    const struct vor_lattice *lattice;
    float *xyz;
    unsigned k;
    atomic_size_t moved;
};

/* The neighbours of one point, nearest first, and a surface that weighs them. */
struct hood {
    const float *distance2;
    float near[3 * VOR_NEIGHBORS_MAX], weight[VOR_NEIGHBORS_MAX];
    struct vor_surface surface;
};

/* Fits to the k nearest with the weight (1 - d^2 / d_k^2)^3. Returns their weighted variance about
 * the surface. */
static double fit(struct hood *hood, unsigned k)
{
    double sum = 0, total = 0;

    for (unsigned j = 0; j < k; j++) {
        float inside = 1 - hood->distance2[j] / (1.001F * hood->distance2[k - 1]);

        hood->weight[j] = inside * inside * inside;
    }
    vor_surface_fit_weighted(&hood->surface, hood->near, hood->weight, k);
    for (unsigned j = 0; hood->surface.kind != VOR_SURFACE_NONE && j < k; j++) {
        double off = vor_surface_abovef(&hood->surface, &hood->near[3 * j]);

        sum += (double)hood->weight[j] * off * off;
        total += (double)hood->weight[j];
    }
    return total > 0 ? sum / total : INFINITY;
}

/* The variance that cells alone explain in such a fit. A plane that cuts a cell passes its middle
 * within half of the cell's width across the plane; spread uniformly, that is width^2 / 12, less
 * what the fit's six coefficients take. */
static double excused(const struct smooth *smooth, const struct vor_surface *surface, unsigned k)
{
    double width = 0;

    for (int c = 0; c < 3; c++)
        width += fabs(surface->axis[2][c]) * smooth->lattice->cell[c];
    return EXCUSED * width * width / 12 * (1 - 6.0 * VOR_NEIGHBORS_WEIGHTED / k);
}

/* The foot of a point on the widest surface around it whose residual cells explain. Returns false
 * when there is none. */
static int foot_of(const struct smooth *smooth, const uint32_t *index, const float *distance2,
                   double foot[3])
{
    struct hood hood;
    double local[3] = {0, 0, 0};
    unsigned k = smooth->k;

    hood.distance2 = distance2;
    vor_gather(hood.near, smooth->domain->xyz, index, smooth->k);
    while (k >= VOR_NEIGHBORS_FEWEST && fit(&hood, k) > excused(smooth, &hood.surface, k))
        k /= 2;
    if (k < VOR_NEIGHBORS_FEWEST || hood.surface.kind == VOR_SURFACE_NONE)
        return 0;
    vor_surface_project(&hood.surface, local);
    vor_surface_to_world(&hood.surface, local, foot);
    return 1;
}

/* Moves point i towards its foot, within its cell. Returns whether it moves. */
static int move(const struct smooth *smooth, size_t i, const double foot[3])
{
    const float *from = &smooth->domain->xyz[3 * i];
    float *to = &smooth->xyz[3 * i];

    for (int c = 0; c < 3; c++) {
        double x = (double)from[c], room = INSIDE * smooth->lattice->cell[c];
        float near = (float)fmax(-1, fmin(1, fmax(x - room, fmin(foot[c], x + room))));

        if (fabs((double)near - x) <= room)
            to[c] = near;
    }
    return to[0] != from[0] || to[1] != from[1] || to[2] != from[2];
}

static void smooth_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct smooth *smooth = ctx;
    const struct vor_domain *domain = smooth->domain;
    uint32_t index[VOR_KNN_NEAR_MAX * VOR_NEIGHBORS_MAX];
    float distance2[VOR_KNN_NEAR_MAX * VOR_NEIGHBORS_MAX];
    struct vor_knn_near near = {.k = smooth->k};
    size_t moved = 0;

    memcpy(&smooth->xyz[3 * begin], &domain->xyz[3 * begin], 3 * (end - begin) * sizeof(float));
    for (size_t i = begin; i < end; i += near.count) {
        near.queries = &domain->xyz[3 * i];
        near.count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        vor_knn_search_near(domain->knn, &near, index, distance2);
        for (size_t j = 0; j < near.count; j++) {
            double foot[3];

            if (foot_of(smooth, &index[j * near.k], &distance2[j * near.k], foot))
                moved += (size_t)move(smooth, i + j, foot);
        }
    }
    atomic_fetch_add_explicit(&smooth->moved, moved, memory_order_relaxed);
}

vor_status vor_lattice_smooth(struct vor_domain *domain, size_t *moved,
                              const struct vor_lattice *lattice, const struct vor_run *run,
                              struct vor_error *err)
{
    struct smooth smooth = {.domain = domain, .lattice = lattice};
    struct vor_neighbors neighbors;
    vor_status status = vor_neighbors_choose(&neighbors, domain, run, err);

    *moved = 0;
    if (status != VOR_OK)
        return status;
    smooth.k = VOR_NEIGHBORS_WEIGHTED * neighbors.usual < VOR_NEIGHBORS_MAX
                   ? VOR_NEIGHBORS_WEIGHTED * neighbors.usual
                   : VOR_NEIGHBORS_MAX;
    if (smooth.k > domain->n)
        smooth.k = (unsigned)domain->n;
    smooth.xyz = vor_malloc(run->memory, domain->n, 3 * sizeof *smooth.xyz);
    if (smooth.xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, VOR_LATTICE_BLOCK, smooth_block, &smooth, err);
    if (status != VOR_OK) {
        vor_free(run->memory, smooth.xyz);
        return status;
    }
    *moved = atomic_load(&smooth.moved);
    return vor_domain_move(domain, smooth.xyz, run, err);
}
