#include "core/lop/bends.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"
#include "core/input/lists.h"
#include "core/input/neighbors.h"
#include "core/input/noisy.h"

#include <string.h>

/* Squares to fitted surfaces over those to the sides of seeming edges, below which a region bends.
 * Noise of 0.3 spacings, two seeds of families of shapes: regions of tori, balls, limbs, bowls and
 * turned pieces 0.18 to 1.11, of wedges, blocks, folds and gears 1.35 to 3.4. */
#define BENDS 1.2

struct bends {
    struct vor_lop_samples *data;
    const struct vor_domain *domain;
    const struct vor_lop_bends_how *how;
    uint32_t *left; /* of a region: points on edges */
};

/* Where the surface fitted around point i sees it, and the square of how far that is. Not where
 * fits take the fewest points, which follow a wedge as well: with noise of 0.1 spacings and 90
 * degrees they lie as near as its sides. */
static int fit_around(struct vor_surface *surface, double put[3], double *off2,
                      const struct vor_domain *domain, size_t i)
{
    const float *x = &domain->xyz[3 * i];
    const double at[3] = {(double)x[0], (double)x[1], (double)x[2]};
    unsigned k = vor_neighbors_at(&domain->known.neighbors, x);
    float near[3 * VOR_NEIGHBORS_MAX];
    double off[3];

    if (k <= VOR_NEIGHBORS_FEWEST)
        return 0;
    (void)vor_lists_fit_at(surface, near, domain, at, k);
    if (surface->kind == VOR_SURFACE_NONE)
        return 0;
    memcpy(put, at, sizeof at);
    vor_surface_put(surface, put);
    for (int c = 0; c < 3; c++)
        off[c] = put[c] - at[c];
    *off2 = vor_dot(off, off);
    return 1;
}

static void take_fit(const struct bends *bends, size_t i)
{
    float *xyz = &bends->data->xyz[3 * i], *normal = &bends->data->normal[3 * i];
    struct vor_surface surface;
    double put[3], local[3], fitted[3], side = 0, off2;

    if (!fit_around(&surface, put, &off2, bends->domain, i))
        return;
    vor_surface_to_local(&surface, put, local);
    vor_surface_normal(&surface, local, fitted);
    for (int c = 0; c < 3; c++)
        side += fitted[c] * (double)normal[c];
    for (int c = 0; c < 3; c++) {
        xyz[c] = (float)put[c];
        normal[c] = (float)(side < 0 ? -fitted[c] : fitted[c]);
    }
}

static void region_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct bends *bends = ctx;
    double fitted = 0, sides = 0, put[3], off2;
    struct vor_surface surface;
    uint32_t flagged = 0;

    for (size_t i = begin; i < end; i++) {
        flagged += bends->how->flag[i];
        if (!bends->how->flag[i] || !fit_around(&surface, put, &off2, bends->domain, i))
            continue;
        fitted += off2;
        sides += vor_distance2f(&bends->domain->xyz[3 * i], &bends->data->xyz[3 * i]);
    }
    bends->left[begin / VOR_NOISY_REGION] = fitted < BENDS * sides ? 0 : flagged;
    for (size_t i = begin; i < end && bends->how->put && fitted < BENDS * sides; i++)
        take_fit(bends, i);
}

vor_status vor_lop_bends(size_t *on_edges, struct vor_lop_samples *data,
                         const struct vor_domain *domain, const struct vor_lop_bends_how *how,
                         const struct vor_run *run, struct vor_error *err)
{
    size_t regions = vor_blocks_of(domain->n, VOR_NOISY_REGION);
    struct bends bends = {data, domain, how, vor_malloc(run->memory, regions, sizeof *bends.left)};
    vor_status status;

    if (bends.left == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, VOR_NOISY_REGION, region_block, &bends, err);
    *on_edges = 0;
    for (size_t r = 0; r < regions && status == VOR_OK; r++)
        *on_edges += bends.left[r];
    vor_free(run->memory, bends.left);
    return status;
}
