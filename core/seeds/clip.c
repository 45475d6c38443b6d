#include "core/base/linalg.h"
#include "core/seeds/seeds.h"

/* Bend of a patch (second derivative times radius) from which on it has triangles. At 0.2 / 0.4 /
 * 0.8: triangles a cell on igea 3.7 / 2.4 / 1.6, on fandisk 5.0 / 4.7 / 4.3; rms and delta within
 * the spread of seeds. */
#define BEND_FLAT 0.4

/* Offset from seed i to seed j in the surface's axes, stretched with a metric; not zero even if
 * they coincide. */
static void offset_of(const struct vor_seeds *seeds, const struct vor_scratch *scratch, size_t i,
                      size_t j, double offset[3])
{
    const float *a = &seeds->xyz[3 * i], *b = &seeds->xyz[3 * j];
    double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                   (double)b[2] - (double)a[2]};

    for (int c = 0; c < 3; c++)
        offset[c] = vor_dot(scratch->here.surface.axis[c], d);
    if (vor_stretched_are(&seeds->stretched))
        vor_stretch_local(&scratch->stretch, offset);
    if (vor_dot(offset, offset) > 0)
        return;
    vor_seeds_part(i, j, VOR_ROUNDED * scratch->radius, offset); /* only the side matters */
    offset[2] = 0;
}

/* Clips by the bisector with seed j. Returns false when seed j is too far to cut anything. */
static int clip_by(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i, size_t j)
{
    double offset[3] = {0};

    offset_of(seeds, scratch, i, j, offset);
    if (vor_cell_secure(&scratch->cell, vor_dot(offset, offset)))
        return 0;
    vor_cell_clip(&scratch->cell, offset);
    return 1;
}

/* Searches farther and farther until the seeds known for certain secure the cell. A search does not
 * return them in strict order of their present distance, so each is tested by itself. */
static void clip_more(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i)
{
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    size_t width = 2 * (seeds->point_lists.listed + 1), done = 0;
    double sure = scratch->crowd.sure;

    /* The crowd holds only the jumpers nearer than crowd.sure. */
    if (!(sure > 0 && vor_cell_secure(&scratch->cell, sure * sure)))
        for (unsigned j = 0; j < seeds->view.jumpers; j++)
            if (seeds->view.jumper[j] != i)
                (void)clip_by(seeds, scratch, i, seeds->view.jumper[j]);
    while (!(sure > 0 && vor_cell_secure(&scratch->cell, sure * sure)) && done < seeds->n &&
           done < VOR_SEEDS_MORE_MAX) {
        width = width < VOR_SEEDS_MORE_MAX ? width : VOR_SEEDS_MORE_MAX;
        width = width < seeds->n ? width : seeds->n;
        sure = vor_point_lists_wide(&seeds->point_lists, &seeds->view, i, (unsigned)width, index,
                                    distance2);
        if (vor_stretched_are(&seeds->stretched))
            sure *= scratch->stretch.least;
        scratch->queries++;
        for (size_t j = done; j < width; j++)
            if (index[j] != i)
                (void)clip_by(seeds, scratch, i, index[j]);
        done = width;
        width *= 2;
    }
}

/* EDGE in geom/boundary.h: clips the cell where the input ends. */
static void end_at_border(const struct vor_seeds *seeds, struct vor_scratch *scratch)
{
    double longest = vor_stretched_are(&seeds->stretched) ? 1 / scratch->stretch.least : 1;
    double radius = longest * scratch->radius, side[2],
           room = vor_boundary_room(&scratch->here.surface, scratch->here.near, scratch->here.k,
                                    scratch->cell.seed, radius / seeds->policy.widen, side);

    if (room < radius)
        vor_cell_clip(&scratch->cell, (double[3]){2 * room * side[0], 2 * room * side[1], 0});
}

/* Makes the cell of seed i at once, unless it reaches out of the patch or what the crowd holds. */
static int wrap(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                const double local[3], const struct vor_disc *disc)
{
    const struct vor_crowd *crowd = &scratch->crowd;
    struct vor_cell_around around = {seeds->xyz, i, crowd->index, 0, disc != &seeds->flat};
    double inner = VOR_HEXAGON_HEIGHT * scratch->radius; /* nor does an octagon end nearer */

    if (!(crowd->sure >= 2 * inner))
        return 0;
    while (around.count < crowd->count &&
           (double)crowd->distance2[around.count] < 4 * inner * inner)
        around.count++;
    return vor_cell_wrap(&scratch->cell, &scratch->here.surface, local, inner, &around);
}

/* Begins the cell of seed i, on its stretched surface if there is a metric. Returns whether nothing
 * but the border may still cut it. */
static int begin_cell(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                      int flat)
{
    const struct vor_surface *surface = &scratch->here.surface;
    const struct vor_disc *disc = &seeds->flat;
    double x[3], local[3], sum = 0;
    int stretched = vor_stretched_are(&seeds->stretched);

    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(surface, x, local);
    if (stretched) {
        vor_stretch_init(&scratch->stretch, surface, seeds->stretched.near[i].tensor);
        vor_stretch_local(&scratch->stretch, local);
        vor_stretched_crowd(&scratch->crowd, seeds->xyz, i, surface, &scratch->stretch);
        surface = &scratch->stretch.surface;
    }
    /* The mean distance to the six nearest seeds (Xiao 2024, Sec. III-B step 2); with fewer seeds
     * 2, which spans the whole domain. */
    for (unsigned j = 0; j < 6 && scratch->crowd.count >= 6; j++)
        sum += sqrt((double)scratch->crowd.distance2[j]);
    scratch->radius = seeds->policy.widen * (scratch->crowd.count < 6 ? 2 : sum / 6);
    if (!flat &&
        (fabs(surface->c[3]) + fabs(surface->c[4]) + fabs(surface->c[5])) * scratch->radius >
            BEND_FLAT)
        disc = &seeds->disc;
    if (!stretched && wrap(seeds, scratch, i, local, disc))
        return 1;
    vor_cell_begin(&scratch->cell, disc, surface, local, scratch->radius);
    return 0;
}

void vor_seeds_clip(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i, int flat)
{
    const struct vor_crowd *crowd = &scratch->crowd;
    int stretched = vor_stretched_are(&seeds->stretched);
    int border = seeds->policy.keep_border && !scratch->interior;
    int wrapped = begin_cell(seeds, scratch, i, flat);
    unsigned j = 0;

    scratch->triangles += scratch->cell.count;
    if (border && !stretched)
        end_at_border(seeds, scratch);
    if (!wrapped) {
        do {
            if (!stretched)
                j += vor_cell_clip_by(&scratch->cell, scratch->here.surface.axis, seeds->xyz, i,
                                      &crowd->index[j], crowd->count - j);
        } while (j < crowd->count && clip_by(seeds, scratch, i, crowd->index[j++]));
        clip_more(seeds, scratch, i);
    }
    if (stretched)
        vor_stretch_undo(&scratch->cell, &scratch->stretch);
    if (border && stretched)
        end_at_border(seeds, scratch);
    scratch->cells++;
    scratch->bisectors += scratch->cell.bisectors;
}

enum vor_surface_kind vor_seeds_cell(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i)
{
    enum vor_surface_kind kind = vor_seeds_fit(seeds, scratch, i);

    if (kind == VOR_SURFACE_NONE)
        return VOR_SURFACE_NONE;
    vor_seeds_crowd(seeds, scratch, i);
    vor_seeds_clip(seeds, scratch, i, 0);
    return kind;
}
