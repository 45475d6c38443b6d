#include "core/geom/flat.h"

#include <math.h>

void vor_flat_begin(struct vor_flat *cell, const double (*corner)[2], unsigned sides, double radius)
{
    cell->count = sides;
    cell->far2 = radius * radius;
    for (unsigned e = 0; e < sides; e++) {
        cell->x[e] = radius * corner[e][0];
        cell->y[e] = radius * corner[e][1];
        cell->id[e] = VOR_FLAT_SIDE + e;
    }
}

static void put(struct vor_flat *cell, double x, double y, uint32_t id)
{
    cell->x[cell->count] = x;
    cell->y[cell->count] = y;
    cell->id[cell->count++] = id;
    cell->far2 = fmax(cell->far2, x * x + y * y);
}

void vor_flat_clip(struct vor_flat *cell, const double d[2], double limit, uint32_t id)
{
    struct vor_flat from;
    double side[VOR_POLYGON_MAX] = {
        0}; /* clang-analyzer cannot see that the loop sets those used */
    unsigned outside = 0;

    for (unsigned e = 0; e < cell->count; e++) {
        if (cell->id[e] == id)
            return;
        side[e] = cell->x[e] * d[0] + cell->y[e] * d[1] - limit;
        outside += side[e] > 0;
    }
    if (outside == 0 || cell->count + 2 > VOR_POLYGON_MAX)
        return;
    from = *cell;
    cell->count = 0;
    cell->far2 = 0;
    for (unsigned e = 0; e < from.count; e++) {
        unsigned f = e + 1 < from.count ? e + 1 : 0;
        double t = side[e] / (side[e] - side[f]);

        if (side[e] <= 0)
            put(cell, from.x[e], from.y[e], from.id[e]);
        if ((side[e] <= 0) != (side[f] <= 0)) /* leaving: the new edge begins; entering: the old */
            put(cell, from.x[e] + t * (from.x[f] - from.x[e]),
                from.y[e] + t * (from.y[f] - from.y[e]), side[e] <= 0 ? id : from.id[e]);
    }
}
