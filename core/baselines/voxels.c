#include "core/baselines/voxels.h"

#include "core/base/rng.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 4096, /* points of one task */
    GRIDS = 32,   /* that are tried: each halves the range, on a scale of factors */
    BITS = 21     /* of the number of a cell along an axis */
};

/* Edges of cells, least and most: the numbers along an axis of length 2 fit their bits, and one
 * cell holds the octant of a corner. */
#define EDGE_LEAST 0x1p-19
#define EDGE_MOST 2.0

/* No cell has this number. */
#define NONE UINT64_MAX

struct cell {
    uint64_t number; /* or NONE */
    uint32_t index;  /* in the order in which they are met */
    uint32_t points;
    double sum[3];
};

struct voxels {
    const float *xyz;
    size_t n, limit;   /* limit: most cells that are counted */
    size_t slots;      /* a power of two, at least twice the limit */
    double inverse;    /* 1 over the edge */
    uint64_t *number;  /* n: of each point's cell */
    struct cell *cell; /* slots */
};

static void number_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct voxels *voxels = ctx;
    uint64_t number = 0;

    for (size_t c = 0; c < 3; c++)
        number =
            number << BITS | (uint64_t)(((double)voxels->xyz[3 * i + c] + 1) * voxels->inverse);
    voxels->number[i] = number;
}

/* Sorts the points into cells of that edge. *cells is how many there are, or limit + 1 for more. */
static vor_status fill(struct voxels *voxels, size_t *cells, double edge, const struct vor_run *run,
                       struct vor_error *err)
{
    struct cell *cell = NULL;
    vor_status status;

    voxels->inverse = 1 / edge;
    status = vor_run_rows(run, voxels->n, BLOCK, number_row, voxels, err);
    if (status != VOR_OK)
        return status;
    for (size_t slot = 0; slot < voxels->slots; slot++)
        voxels->cell[slot] = (struct cell){.number = NONE};
    *cells = 0;
    for (size_t i = 0; i < voxels->n && *cells <= voxels->limit; i++) {
        uint64_t number = voxels->number[i];
        size_t slot = (size_t)vor_rng_mix(number) & (voxels->slots - 1);

        if (cell == NULL || cell->number != number) {
            while (voxels->cell[slot].number != number && voxels->cell[slot].number != NONE)
                slot = (slot + 1) & (voxels->slots - 1);
            cell = &voxels->cell[slot];
        }
        if (cell->number == NONE) {
            cell->number = number;
            cell->index = (uint32_t)(*cells)++;
        }
        cell->points++;
        for (size_t c = 0; c < 3; c++)
            cell->sum[c] += (double)voxels->xyz[3 * i + c];
    }
    return VOR_OK;
}

static size_t off(size_t a, size_t b)
{
    return a > b ? a - b : b - a;
}

/* Looks for the edge that makes about as many cells as are wanted. */
static vor_status search(struct voxels *voxels, double *edge, size_t count,
                         const struct vor_run *run, struct vor_error *err)
{
    double least = EDGE_LEAST, most = EDGE_MOST;
    size_t nearest = SIZE_MAX, cells = 0;

    *edge = EDGE_MOST;
    for (int grid = 0; grid < GRIDS && nearest > 0; grid++) {
        double tried = grid == 0 ? EDGE_MOST : sqrt(least * most);
        vor_status status = fill(voxels, &cells, tried, run, err);

        if (status != VOR_OK)
            return status;
        if (cells <= voxels->limit && off(cells, count) < nearest) {
            nearest = off(cells, count);
            *edge = tried;
        }
        if (cells > count)
            least = tried;
        else
            most = tried;
    }
    return VOR_OK;
}

static vor_status alloc_voxels(struct voxels *voxels, size_t count, struct vor_memory *memory,
                               struct vor_error *err)
{
    voxels->limit = 2 * count + VOR_VOXELS_SLACK;
    if (voxels->limit > voxels->n)
        voxels->limit = voxels->n;
    voxels->slots = 2;
    while (voxels->slots < 2 * (voxels->limit + 1))
        voxels->slots *= 2;
    return VOR_MAKE_ALL(memory, err, voxels->n, VOR_ARRAY(voxels->number, voxels->n, 1),
                        VOR_ARRAY(voxels->cell, voxels->slots, 1));
}

vor_status vor_voxel_points(float *out, size_t *made, const float *xyz, size_t n, size_t count,
                            const struct vor_run *run, struct vor_error *err)
{
    struct voxels voxels = {.xyz = xyz, .n = n};
    double edge = EDGE_MOST;
    vor_status status = alloc_voxels(&voxels, count, run->memory, err);

    VOR_THEN(status, search(&voxels, &edge, count, run, err));
    VOR_THEN(status, fill(&voxels, made, edge, run, err));
    if (status == VOR_OK) {
        for (size_t slot = 0; slot < voxels.slots; slot++) {
            const struct cell *cell = &voxels.cell[slot];

            for (size_t c = 0; c < 3 && cell->number != NONE; c++)
                out[3 * (size_t)cell->index + c] = (float)(cell->sum[c] / cell->points);
        }
    }
    VOR_FREE_ALL(run->memory, voxels.cell, voxels.number);
    return status;
}
