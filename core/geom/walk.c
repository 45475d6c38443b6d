#include "core/geom/walk.h"

#include "core/base/vector.h"

#include <math.h>
#include <string.h>

/* Figures as in input/adjacency.c. */

/* Most of the straight distance that the way to a neighbour may be long: Lv 2022 as corrected, a
 * bounded walk. */
#define STRETCH 1.5
/* Longest edge of a way, in spacings of the points walked among: the six nearest are within 1.5. */
#define REACH 2.2
/* Cosine of the normals at the ends of an edge: half of a right angle's turn. At 0.5 / 0.6 / 0.7:
 * cow 0.066 / 0.063 / 0.066, room 0.0466 / 0.0459 / 0.0488. */
#define COSINE 0.6

/* Whether the edge between two points of a walk, whose squared length is l2, stays on the surface.
 */
static int stays(const struct vor_walk *walk, unsigned a, unsigned b, double l2)
{
    double cosine = 0, across = 0, middle2 = 0, sign;

    for (int c = 0; c < 3; c++)
        cosine += (double)walk->normal[c][a] * (double)walk->normal[c][b];
    if ((walk->is_signed ? cosine : fabs(cosine)) < COSINE)
        return 0;
    sign = cosine < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++) {
        double middle = (double)walk->normal[c][a] + sign * (double)walk->normal[c][b];

        across += middle * ((double)walk->x[c][b] - (double)walk->x[c][a]);
        middle2 += middle * middle;
    }
    return across * across <= walk->arc * walk->arc * middle2 * l2;
}

VOR_CLONES void vor_walk_distances(const struct vor_walk *walk, unsigned of,
                                   double d2[VOR_WALK_MOST])
{
    double x = (double)walk->x[0][of], y = (double)walk->x[1][of], z = (double)walk->x[2][of];

    for (unsigned j = 0; j < walk->most; j++) {
        double u = (double)walk->x[0][j] - x, v = (double)walk->x[1][j] - y,
               w = (double)walk->x[2][j] - z;

        d2[j] = u * u + v * v + w * w;
    }
}

void vor_walk_go(struct vor_walk *walk)
{
    double reach2 = REACH * REACH * M_PI * (double)walk->distance2[walk->most - 1] / walk->most;
    double l2[VOR_WALK_MOST] = {0};
    unsigned open[VOR_WALK_MOST], left = walk->most; /* points that are not settled, in order */
    unsigned next = 0, sure = 0, found = 0;

    memset(walk->done, 0, sizeof walk->done);
    memset(walk->reached, 0, sizeof walk->reached);
    for (unsigned j = 0; j < walk->most; j++) {
        walk->far[j] = j == 0 ? 0 : INFINITY;
        walk->limit[j] = STRETCH * sqrt((double)walk->distance2[j]) + 1e-12;
        open[j] = j;
    }
    while (next < walk->most) {
        unsigned from = next, stay = 0;
        double least = INFINITY;

        /* Ways only get longer: what is known of the first `sure` points stays. */
        while (sure < walk->most && (walk->done[sure] || walk->far[from] > walk->limit[sure]))
            found += walk->reached[sure++];
        if (found >= walk->enough)
            return;
        vor_walk_distances(walk, from, l2);
        walk->done[from] = 1;
        walk->reached[from] = walk->far[from] <= walk->limit[from];
        next = walk->most;
        for (unsigned i = 0; i < left; i++) {
            unsigned j = open[i];

            if (j == from)
                continue;
            open[stay++] = j;
            if (l2[j] <= reach2) {
                double far = walk->far[from] + sqrt(l2[j]);

                if (far < walk->far[j] && stays(walk, from, j, l2[j]))
                    walk->far[j] = far;
            }
            if (walk->far[j] < least) {
                least = walk->far[j];
                next = j;
            }
        }
        left = stay;
    }
}
