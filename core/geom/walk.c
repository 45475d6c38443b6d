#include "core/geom/walk.h"

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
#define PI 3.14159265358979

/* The length of the edge between two points of a walk; infinite if it leaves the surface. */
static double edge(const struct vor_walk *walk, unsigned a, unsigned b, double reach2)
{
    const float *m = walk->normal[a], *n = walk->normal[b];
    double d[3], l2 = 0, cosine = 0, across = 0, middle2 = 0, sign;

    for (int c = 0; c < 3; c++) {
        d[c] = (double)walk->x[b][c] - (double)walk->x[a][c];
        l2 += d[c] * d[c];
    }
    if (l2 > reach2)
        return INFINITY;
    for (int c = 0; c < 3; c++)
        cosine += (double)m[c] * (double)n[c];
    if (fabs(cosine) < COSINE)
        return INFINITY;
    sign = cosine < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++) {
        double middle = (double)m[c] + sign * (double)n[c];

        across += middle * d[c];
        middle2 += middle * middle;
    }
    return across * across <= walk->arc * walk->arc * middle2 * l2 ? sqrt(l2) : INFINITY;
}

/* Settles one point, and tells its neighbours the way through it. */
static void step(struct vor_walk *walk, unsigned from, double reach2)
{
    walk->done[from] = 1;
    walk->reached[from] = walk->far[from] <= STRETCH * sqrt((double)walk->distance2[from]) + 1e-12;
    for (unsigned j = 0; j < walk->most; j++)
        if (!walk->done[j])
            walk->far[j] = fmin(walk->far[j], walk->far[from] + edge(walk, from, j, reach2));
}

void vor_walk_go(struct vor_walk *walk)
{
    double reach2 = REACH * REACH * PI * (double)walk->distance2[walk->most - 1] / walk->most;

    memset(walk->done, 0, sizeof walk->done);
    memset(walk->reached, 0, sizeof walk->reached);
    for (unsigned j = 0; j < walk->most; j++)
        walk->far[j] = j == 0 ? 0 : INFINITY;
    for (;;) {
        unsigned next = walk->most;
        double nearest = INFINITY;

        for (unsigned j = 0; j < walk->most; j++)
            if (!walk->done[j] && walk->far[j] < nearest) {
                nearest = walk->far[j];
                next = j;
            }
        if (next == walk->most)
            return;
        step(walk, next, reach2);
    }
}
