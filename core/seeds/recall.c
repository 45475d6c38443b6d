#include "core/seeds/seeds.h"

#include "core/base/linalg.h"
#include "core/input/lists.h"
#include "core/seeds/attach.h"

/* Whether the points around the seed at hand are as irregular as those of white noise, where no
 * gap shows a hole (vor_seeds_hold). */
static int irregular(const struct vor_place *here)
{
    return vor_boundary_regularity(here->near, here->k, here->surface.spacing) < VOR_HOLE_REGULAR;
}

/* Whether the nearest points leave one side of seed i, at x, empty by chance: they are irregular,
 * and others of its list lie there. So it is around 4 % of the seeds in white noise, which each
 * step would take for seeds at a border. This and near_input, against neither, 6 seeds: CPU of
 * 30,000 points of white noise on igea to 10,000 1.21 / 1.00 s, of 200,000 on a sphere to 5,072
 * 0.68 / 0.61, delta 0.0161 / 0.0154 and 0.0151 both; 80,000 of half an armadillo to 8,000 1.26
 * / 1.21 s, delta 0.0197 both. */
static int chance_gap(const struct vor_seeds *seeds, const struct vor_scratch *scratch, size_t i,
                      const double x[3])
{
    const struct vor_input_lists *lists = &seeds->input_lists;
    const struct vor_place *here = &scratch->here;
    const struct vor_surface *surface = &here->surface;
    float near[3 * 2 * VOR_NEIGHBORS_FEWEST];
    double local[3], side[2];
    unsigned count = lists->has[i];

    if (here->k > VOR_NEIGHBORS_FEWEST || seeds->sheets ||
        seeds->last_fit[i].root != VOR_LISTS_NO_ROOT)
        return 0;
    vor_surface_to_local(surface, x, local);
    (void)vor_boundary_room(surface, here->near, here->k, local, surface->reach, side);
    vor_gather(near, seeds->domain->xyz, &lists->list[i * lists->wide], count);
    return vor_boundary_end(surface, local, side, near, count) >=
               VOR_EDGE_SURE_INSIDE * surface->reach &&
           irregular(here);
}

/* Whether an input point is near the seed, at x: as near as where holes are not kept, where the
 * input is too irregular to show any; and as near as seeds are in the end, or others would not make
 * room for those that are moved then. */
static int near_input(const struct vor_seeds *seeds, const struct vor_place *here,
                      const double x[3], int keep_holes)
{
    double spacing = vor_boundary_spacing(here->near, here->k, x);

    return vor_boundary_within(here->near, here->k, x, fmin(spacing, vor_attach_allowed(seeds))) &&
           (!keep_holes || vor_boundary_within(here->near, here->k, x, VOR_HOLE_INSIDE * spacing) ||
            irregular(here));
}

int vor_seeds_refine(const struct vor_seeds *seeds, const struct vor_scratch *scratch, size_t i,
                     struct vor_surface *surface)
{
    unsigned k = scratch->here.k;

    return !seeds->policy.planes && k >= VOR_REFINED_MIN && k <= VOR_REFINED_MAX &&
           vor_surface_refine(surface, scratch->here.near, k, &seeds->xyz[3 * i]);
}

enum vor_surface_kind vor_seeds_recall(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                       size_t i, const struct vor_recall *how)
{
    struct vor_last_fit *last = &seeds->last_fit[i];
    double x[3];

    if (vor_seeds_last(seeds, i, how) != NULL) {
        scratch->here.surface = scratch->onto = last->surface;
        scratch->interior = 1;
        return scratch->here.surface.kind;
    }
    if (vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE)
        return VOR_SURFACE_NONE;
    vor_seeds_position(seeds, i, x);
    last->inside = !seeds->policy.keep_border || vor_seeds_surrounded(scratch, x) ||
                   (how->keep_holes && chance_gap(seeds, scratch, i, x));
    last->interior = last->inside && (!seeds->policy.keep_border ||
                                      near_input(seeds, &scratch->here, x, how->keep_holes));
    scratch->onto = scratch->here.surface;
    if (how->refine)
        (void)vor_seeds_refine(seeds, scratch, i, &scratch->onto);
    if (last->inside) {
        last->surface = scratch->onto;
        last->refined = (unsigned char)how->refine;
    }
    if (last->interior) /* nobody asks for the wider fit */
        scratch->here.surface = scratch->onto;
    scratch->interior = last->interior;
    return scratch->here.surface.kind;
}
