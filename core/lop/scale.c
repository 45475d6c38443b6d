#include "core/lop/scale.h"

#include "core/input/coarsen.h"
#include "core/input/neighbors.h"
#include "core/input/thin.h"

#include <math.h>

/* Share of the input's points on edges below which it counts as having none, and is evened out as
 * by other methods: igea, bunny and a sphere have at most 0.13 % (input/edges.h), fandisk 10 %.
 * Igea of 30,000 points to 10,000, evened out with edges: delta 0.084, rms 9.5e-4. */
#define EDGES_SHARE 0.005

int vor_lop_is_smooth(size_t flagged, size_t n)
{
    return (double)flagged < EDGES_SHARE * (double)n;
}

vor_status vor_lop_has_edges(int *smooth, struct vor_edges *edges, const struct vor_domain *domain,
                             double area, const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain all = *domain, few = {.n = 0};
    struct vor_edges found = {.n = 0};
    vor_status status;

    all.known.seek_sheets = 0; /* edges are found without lists */
    all.known.lists = VOR_LISTS_NONE;
    status = vor_domain_thin(&few, &all, sqrt(area / VOR_THIN_LEAST), run, err);
    if (status == VOR_OK && few.n > 0)
        vor_neighbors_fewer(&few.known.neighbors, (double)few.n / (double)all.n);
    if (status == VOR_OK)
        status = vor_edges_find(&found, few.n > 0 ? &few : domain, run, err);
    if (status == VOR_OK)
        *smooth = vor_lop_is_smooth(found.flagged, found.n);
    if (status == VOR_OK && few.n == 0 && !*smooth)
        *edges = found;
    else
        vor_edges_free(&found);
    vor_domain_free(&few);
    return status;
}

vor_status vor_lop_find_scale(struct vor_domain *out, const struct vor_domain *in, double area,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain now = {.n = 0}, fewer;
    struct vor_edges edges = {.n = 0};
    const struct vor_domain *from = in;
    int smooth = 1;
    vor_status status = VOR_OK;

    while (status == VOR_OK && smooth && !from->known.sheets && /* noise may hide edges from fits */
           from->known.neighbors.usual > VOR_NEIGHBORS_FEWEST) {
        fewer = (struct vor_domain){.n = 0};
        status = vor_domain_halve(&fewer, from, run, err);
        if (status != VOR_OK || fewer.n == 0)
            break;
        vor_domain_free(&now);
        now = fewer;
        from = &now;
        status = vor_lop_has_edges(&smooth, &edges, from, area, run, err);
        vor_edges_free(&edges);
    }
    if (status == VOR_OK && !smooth)
        *out = now;
    else
        vor_domain_free(&now);
    return status;
}
