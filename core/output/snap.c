#include "core/output/snap.h"

#include "core/base/rng.h"
#include "core/input/lattice.h"

#include <math.h>
#include <string.h>

enum {
    STRAY = 200, /* one point in so many may be off the levels, as of a lattice that is found */
    POLL_EVERY = 256, /* seeds without a cell between two looks at whether to go on */
    FAR = 4,          /* cells along an axis, from a seed's own to the one that it gets, at most */
    LEVELS_MAX = 1 << 30
};

#define NONE UINT32_MAX

struct snap {
    struct vor_seeds *seeds;
    const struct vor_levels *levels;
    int64_t *cell;   /* 3 of each seed */
    uint32_t *owner; /* hash table of the seeds that have a cell; NONE: free */
    size_t slots;    /* a power of two, at least twice the seeds */
};

static double level(const struct vor_levels *levels, int c, int64_t i)
{
    return levels->first[c] + levels->cell[c] * (double)i;
}

/* The level nearest to x; clamped to those that there are. */
static int64_t find_level(const struct vor_levels *levels, int c, double x)
{
    double i = rint((x - levels->first[c]) / levels->cell[c]);

    return (int64_t)fmax(0, fmin(i, (double)levels->last[c]));
}

/* Whether nearly all points are on the levels. */
static int are_on(const struct vor_levels *levels, const struct vor_cloud *in)
{
    size_t stray = 0;

    for (size_t i = 0; i < in->n; i++) {
        int is_off = 0;

        for (int c = 0; c < 3; c++) {
            double x = (double)in->xyz[3 * i + (size_t)c];

            is_off |= fabs(x - level(levels, c, find_level(levels, c, x))) >
                      VOR_ON_LEVEL * levels->cell[c];
        }
        stray += (size_t)is_off;
    }
    return stray * STRAY <= in->n;
}

vor_status vor_levels_find(struct vor_levels *out, const struct vor_cloud *in,
                           const struct vor_domain *domain, struct vor_error *err)
{
    const double *cell = domain->known.lattice.cell;
    double other = fmax(fmax(cell[0], cell[1]), cell[2]) * domain->unit;
    int is_found = other > 0;

    for (int c = 0; c < 3 && is_found; c++) {
        double least = INFINITY, most = -INFINITY, count;

        for (size_t i = 0; i < in->n; i++) {
            double x = (double)in->xyz[3 * i + (size_t)c];

            least = x < least ? x : least;
            most = x > most ? x : most;
        }
        out->first[c] = least;
        out->cell[c] = cell[c] > 0 ? cell[c] * domain->unit : other;
        count = rint((most - least) / out->cell[c]);
        is_found = count < LEVELS_MAX;
        out->last[c] = is_found ? (int64_t)count : 0;
        if (out->last[c] > 0)
            out->cell[c] = (most - least) / count;
    }
    if (is_found && are_on(out, in))
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "lattice",
                          "lattice is keep, but the coordinates of the input are on no grid");
}

/* The slot of a cell in the table: that of the seed that has it, or a free one. */
static size_t find_slot(const struct snap *snap, const int64_t cell[3])
{
    uint64_t hash = vor_rng_bits((uint64_t)cell[0], (uint64_t)cell[1], (uint64_t)cell[2]);
    size_t slot = (size_t)hash & (snap->slots - 1);

    while (snap->owner[slot] != NONE &&
           memcmp(&snap->cell[3 * (size_t)snap->owner[slot]], cell, 3 * sizeof *cell) != 0)
        slot = (slot + 1) & (snap->slots - 1);
    return slot;
}

/* Where a seed is, in relative coordinates. */
static void find_place(const struct snap *snap, size_t i, double x[3])
{
    const struct vor_domain *domain = snap->seeds->whole;

    for (int c = 0; c < 3; c++)
        x[c] = (double)snap->seeds->xyz[3 * i + (size_t)c] * domain->unit + domain->shift[c];
}

/* The square of the way from x to the middle of a cell. */
static double way2(const struct snap *snap, const double x[3], const int64_t cell[3])
{
    double sum = 0;

    for (int c = 0; c < 3; c++) {
        double way = level(snap->levels, c, cell[c]) - x[c];

        sum += way * way;
    }
    return sum;
}

/* Whether the surface that was last fitted around seed i, which is at x, passes through a cell of
 * the lattice: as its tangent plane does. */
static int is_passed(const struct snap *snap, size_t i, const double x[3], const int64_t cell[3])
{
    const struct vor_surface *surface = &snap->seeds->last_fit[i].surface;
    double across = 0, reach = 0;

    for (int c = 0; c < 3; c++) {
        if (cell[c] < 0 || cell[c] > snap->levels->last[c])
            return 0;
        across += surface->axis[2][c] * (level(snap->levels, c, cell[c]) - x[c]);
        reach += fabs(surface->axis[2][c]) * snap->levels->cell[c] / 2;
    }
    return snap->seeds->last_fit[i].k == 0 || surface->kind == VOR_SURFACE_NONE ||
           fabs(across) <= reach;
}

/* Gives seed i the nearest free cell that the surface passes through, at most `far` from its own.
 * Returns false when there is none. */
static int move_to_free(struct snap *snap, size_t i, int far)
{
    int64_t *own = &snap->cell[3 * i], best[3] = {0, 0, 0}, cell[3];
    double least = INFINITY, x[3];

    find_place(snap, i, x);
    for (cell[0] = own[0] - far; cell[0] <= own[0] + far; cell[0]++)
        for (cell[1] = own[1] - far; cell[1] <= own[1] + far; cell[1]++)
            for (cell[2] = own[2] - far; cell[2] <= own[2] + far; cell[2]++) {
                double way = way2(snap, x, cell);

                if (!(way < least) || !is_passed(snap, i, x, cell) ||
                    snap->owner[find_slot(snap, cell)] != NONE)
                    continue;
                least = way;
                memcpy(best, cell, sizeof best);
            }
    if (!(least < INFINITY))
        return 0;
    memcpy(own, best, sizeof best);
    snap->owner[find_slot(snap, own)] = (uint32_t)i;
    return 1;
}

/* Gives each seed its own cell, or if a nearer one has that, notes it in `without`. Returns how
 * many those are. */
static size_t take_own(struct snap *snap, uint32_t *without)
{
    size_t n = snap->seeds->n, count = 0;

    for (size_t i = 0; i < n; i++) {
        int64_t *own = &snap->cell[3 * i];
        double x[3], y[3];
        size_t slot;

        find_place(snap, i, x);
        for (int c = 0; c < 3; c++)
            own[c] = find_level(snap->levels, c, x[c]);
        slot = find_slot(snap, own);
        if (snap->owner[slot] == NONE) {
            snap->owner[slot] = (uint32_t)i;
            continue;
        }
        find_place(snap, snap->owner[slot], y);
        if (way2(snap, x, own) < way2(snap, y, own)) {
            without[count++] = snap->owner[slot];
            snap->owner[slot] = (uint32_t)i;
        } else {
            without[count++] = (uint32_t)i;
        }
    }
    return count;
}

static vor_status give_cells(struct snap *snap, uint32_t *without, struct vor_error *err)
{
    size_t count = take_own(snap, without), left = 0;
    vor_status status = VOR_OK;

    for (size_t k = 0; k < count && status == VOR_OK; k++) {
        int far = 1;

        if (k % POLL_EVERY == 0)
            status = vor_run_answered(vor_run_poll(&snap->seeds->run), err);
        while (far <= FAR && !move_to_free(snap, without[k], far))
            far++;
        left += far > FAR;
    }
    if (status != VOR_OK || left == 0)
        return status;
    return vor_fail(err, VOR_E_TARGET,
                    "lattice is keep, but the surface passes through too few cells of the grid: "
                    "%zu of %zu points have no cell of their own",
                    left, snap->seeds->n);
}

vor_status vor_snap_seeds(struct vor_seeds *seeds, const struct vor_levels *levels,
                          struct vor_error *err)
{
    struct snap snap = {.seeds = seeds, .levels = levels, .slots = 2};
    struct vor_memory *memory = seeds->run.memory;
    uint32_t *without = vor_malloc(memory, seeds->n, sizeof *without);
    vor_status status;

    while (snap.slots < 2 * seeds->n)
        snap.slots *= 2;
    snap.cell = vor_calloc(memory, seeds->n, 3 * sizeof *snap.cell);
    snap.owner = vor_malloc(memory, snap.slots, sizeof *snap.owner);
    if (without == NULL || snap.cell == NULL || snap.owner == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
        goto done;
    }
    memset(snap.owner, 0xFF, snap.slots * sizeof *snap.owner);
    status = give_cells(&snap, without, err);
    if (status != VOR_OK)
        goto done;
    for (size_t i = 0; i < 3 * seeds->n; i++) {
        int c = (int)(i % 3);

        seeds->xyz[i] =
            (float)((level(levels, c, snap.cell[i]) - seeds->whole->shift[c]) / seeds->whole->unit);
    }
    status = vor_seeds_index(seeds, &seeds->run, err);
done:
    VOR_FREE_ALL(memory, snap.owner, snap.cell, without);
    return status;
}

void vor_snap_cloud(struct vor_cloud *out, const struct vor_levels *levels,
                    const struct vor_cloud *in)
{
    for (size_t i = 0; i < 3 * out->n; i++) {
        int c = (int)(i % 3);
        double shift = out->origin[c] - in->origin[c], x = (double)out->xyz[i] + shift;

        out->xyz[i] = (float)(level(levels, c, find_level(levels, c, x)) - shift);
    }
}
