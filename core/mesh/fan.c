#include "core/mesh/fan.h"

#include "core/base/linalg.h"
#include "core/geom/flat.h"
#include "core/geom/patch.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Radius of a patch over the mean distance to the six nearest on the sheet. Triangles have a
 * circumscribed circle of at most that: wider ones would bridge bays at a border, narrower ones
 * would leave holes where points are uneven. */
#define WIDEN 1.1

/* A cell being cut. */
struct cut {
    const struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    struct vor_fans *fans;
    struct vor_frame frame;
    struct vor_flat cell;
    uint32_t i;
    int stretched; /* there is a metric, and the cell is cut in that of its seed */
    struct vor_stretch stretch;
};

static void clip_by(struct cut *cut, uint32_t j)
{
    const float *a = &cut->seeds->xyz[3 * (size_t)cut->i], *b = &cut->seeds->xyz[3 * (size_t)j];
    double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                   (double)b[2] - (double)a[2]};
    double length2 = vor_dot(d, d);
    double local[3] = {vor_dot(cut->frame.axis[0], d), vor_dot(cut->frame.axis[1], d), 0};

    if (cut->stretched) {
        length2 -= vor_dot(local, local);
        vor_stretch_local(&cut->stretch, local);
        length2 += vor_dot(local, local);
    }
    if (length2 < 4 * cut->cell.far2 && vor_sheet_joins(cut->sheet, cut->i, j))
        vor_flat_clip(&cut->cell, local, length2 / 2, j);
}

/* Clips by those among more and more seeds around that were not asked yet. */
static void clip_more(struct cut *cut, struct vor_scratch *scratch)
{
    struct vor_seeds *seeds = cut->seeds;
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    unsigned width = 2 * (seeds->point_lists.listed + 1), most = VOR_SEEDS_MORE_MAX;
    double sure = scratch->crowd.sure;

    most = seeds->n < most ? (unsigned)seeds->n : most;
    for (unsigned done = 0; done < most && !(sure > 0 && sure * sure >= 4 * cut->cell.far2);
         width *= 2) {
        width = width < most ? width : most;
        sure = vor_point_lists_wide(&seeds->point_lists, &seeds->view, cut->i, width, index,
                                    distance2);
        if (cut->stretched)
            sure *= cut->stretch.least;
        scratch->queries++;
        for (unsigned j = done; j < width; j++)
            if (index[j] != cut->i)
                clip_by(cut, index[j]);
        for (unsigned j = 0; done == 0 && j < seeds->view.jumpers; j++)
            if (seeds->view.jumper[j] != cut->i)
                clip_by(cut, seeds->view.jumper[j]);
        done = width;
    }
}

/* Prepares to cut the cell in the metric of its seed, among the seeds nearest in it. */
static void stretch(struct cut *cut, struct vor_scratch *scratch)
{
    const struct vor_seeds *seeds = cut->seeds;
    struct vor_surface flat = {.kind = VOR_SURFACE_PLANE};

    cut->stretched = vor_stretched_are(&seeds->stretched);
    if (!cut->stretched)
        return;
    memcpy(flat.axis, cut->frame.axis, sizeof flat.axis);
    vor_stretch_init(&cut->stretch, &flat, seeds->stretched.near[cut->i].tensor);
    vor_stretched_crowd(&scratch->crowd, seeds->xyz, cut->i, &flat, &cut->stretch);
}

/* Mean distance to the six nearest on the sheet; 0 with fewer than three. */
static double reach(const struct cut *cut, const struct vor_crowd *crowd)
{
    double sum = 0;
    unsigned found = 0;

    for (unsigned j = 0; j < crowd->count && found < 6; j++)
        if (vor_sheet_joins(cut->sheet, cut->i, crowd->index[j])) {
            sum += sqrt((double)crowd->distance2[j]);
            found++;
        }
    return found >= 3 ? sum / found : 0;
}

static void hand_out(struct cut *cut)
{
    const struct vor_flat *cell = &cut->cell;
    struct vor_fans *fans = cut->fans;
    uint32_t *neighbor = &fans->neighbor[(size_t)cut->i * VOR_FAN_MOST];

    if (cell->count > VOR_FAN_MOST)
        return;
    fans->count[cut->i] = (unsigned char)cell->count;
    for (unsigned e = 0; e < cell->count; e++)
        neighbor[e] = cell->id[e] < VOR_FLAT_SIDE ? cell->id[e] : VOR_FAN_OPEN;
}

static void cut_cell(struct cut *cut, struct vor_scratch *scratch)
{
    const float *normal = &cut->sheet->normal[3 * (size_t)cut->i];
    const struct vor_crowd *crowd = &scratch->crowd;
    double radius;

    cut->fans->count[cut->i] = 0;
    if (!vor_sheet_has(cut->sheet, cut->i))
        return;
    vor_frame_of(&cut->frame, normal);
    vor_seeds_crowd(cut->seeds, scratch, cut->i);
    stretch(cut, scratch);
    radius = WIDEN * reach(cut, crowd);
    if (!(radius > 0))
        return;
    vor_flat_begin(&cut->cell, vor_patch_corner, VOR_PATCH_HEXAGON, radius);
    for (unsigned j = 0; j < crowd->count; j++)
        clip_by(cut, crowd->index[j]);
    clip_more(cut, scratch);
    hand_out(cut);
}

/* What workers share. */
struct cutting {
    const struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    struct vor_fans *fans;
};

static void cut_block(void *ctx, size_t begin_at, size_t end, unsigned worker)
{
    const struct cutting *cutting = ctx;
    struct cut cut = {.sheet = cutting->sheet, .seeds = cutting->seeds, .fans = cutting->fans};

    for (size_t i = begin_at; i < end; i++) {
        cut.i = (uint32_t)i;
        cut_cell(&cut, &cutting->seeds->scratch[worker]);
    }
}

vor_status vor_fans_make(struct vor_fans *out, const struct vor_sheet *sheet,
                         struct vor_seeds *seeds, const struct vor_run *run, struct vor_error *err)
{
    struct vor_fans fans = {.memory = seeds->run.memory, .n = seeds->n};
    struct cutting cutting = {sheet, seeds, &fans};
    vor_status status;

    fans.neighbor = vor_malloc(fans.memory, fans.n, VOR_FAN_MOST * sizeof *fans.neighbor);
    fans.count = vor_malloc(fans.memory, fans.n, 1);
    if (fans.neighbor == NULL || fans.count == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "cells of %zu points", fans.n);
    else
        status = vor_run_for(run, fans.n, VOR_SEEDS_BLOCK, cut_block, &cutting, err);
    if (status != VOR_OK) {
        vor_fans_free(&fans);
        return status;
    }
    *out = fans;
    return VOR_OK;
}

void vor_fans_free(struct vor_fans *fans)
{
    if (fans->memory == NULL)
        return;
    vor_free(fans->memory, fans->count);
    vor_free(fans->memory, fans->neighbor);
    memset(fans, 0, sizeof *fans);
}

int vor_fans_has(const struct vor_fans *fans, uint32_t i, uint32_t j, uint32_t k)
{
    const uint32_t *neighbor = &fans->neighbor[(size_t)i * VOR_FAN_MOST];
    unsigned count = fans->count[i];

    for (unsigned e = 0; e < count; e++) {
        uint32_t a = neighbor[e], b = neighbor[e + 1 < count ? e + 1 : 0];

        if ((a == j && b == k) || (a == k && b == j))
            return 1;
    }
    return 0;
}
