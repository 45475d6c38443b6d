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

enum { LANES = 4 };
typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef uint64_t words __attribute__((vector_size(8 * LANES)));
_Static_assert(VOR_WALK_MOST % LANES == 0, "all points are in lanes");

VOR_CLONES uint64_t vor_walk_near(const struct vor_walk *walk, unsigned of, double within2,
                                  double d2[VOR_WALK_MOST])
{
    double x = (double)walk->x[0][of], y = (double)walk->x[1][of], z = (double)walk->x[2][of];
    words near = {0}, bit = {1, 2, 4, 8};

    for (unsigned j = 0; j < walk->most; j++) {
        double u = (double)walk->x[0][j] - x, v = (double)walk->x[1][j] - y,
               w = (double)walk->x[2][j] - z;

        d2[j] = u * u + v * v + w * w;
    }
    for (unsigned j = walk->most; j < VOR_WALK_MOST; j++)
        d2[j] = INFINITY;
    for (unsigned j = 0; j < VOR_WALK_MOST; j += LANES) {
        lanes some;

        memcpy(&some, &d2[j], sizeof some);
        near |= (words)(some <= within2) & bit;
        bit *= 1 << LANES; /* a shift makes -fanalyzer warn wrongly */
    }
    return (near[0] | near[1] | near[2] | near[3]) & ~(UINT64_C(1) << of);
}

/* A bit for each point that a way over `from` may be shorter to, by their squared distances from
 * there: without a root for each, and none less for rounding. */
VOR_CLONES static uint64_t may_shorten(const struct vor_walk *walk, unsigned from,
                                       const double d2[VOR_WALK_MOST])
{
    words may = {0}, bit = {1, 2, 4, 8};

    for (unsigned j = 0; j < VOR_WALK_MOST; j += LANES) {
        lanes way, some;

        memcpy(&way, &walk->far[j], sizeof way);
        memcpy(&some, &d2[j], sizeof some);
        way -= walk->far[from];
        may |= (words)((way > 0) & (some <= way * way * (1 + 1e-9))) & bit;
        bit *= 1 << LANES;
    }
    return may[0] | may[1] | may[2] | may[3];
}

/* The nearest of the points met so far, by their ways; `most` if there is none. */
static unsigned next_of(const struct vor_walk *walk, uint64_t met)
{
    double least = INFINITY;
    unsigned next = walk->most;

    for (; met > 0; met &= met - 1) {
        unsigned j = vor_walk_first(met);

        if (walk->far[j] < least) {
            least = walk->far[j];
            next = j;
        }
    }
    return next;
}

void vor_walk_go(struct vor_walk *walk)
{
    double reach2 = REACH * REACH * M_PI * (double)walk->distance2[walk->most - 1] / walk->most;
    double l2[VOR_WALK_MOST] = {0};
    uint64_t met = 1, done = 0; /* points that a way leads to, and those whose way is settled */
    uint64_t near;
    unsigned sure = 0, found = 0;

    memset(walk->reached, 0, sizeof walk->reached);
    for (unsigned j = 0; j < VOR_WALK_MOST; j++)
        walk->far[j] = j == 0 ? 0 : INFINITY;
    for (unsigned j = 0; j < walk->most; j++)
        walk->limit[j] = STRETCH * sqrt((double)walk->distance2[j]) + 1e-12;
    for (unsigned from = 0; from < walk->most; from = next_of(walk, met & ~done)) {
        /* Ways only get longer: what is known of the first `sure` points stays. */
        while (sure < walk->most && (done >> sure & 1 || walk->far[from] > walk->limit[sure]))
            found += walk->reached[sure++];
        if (found >= walk->enough)
            return;
        done |= UINT64_C(1) << from;
        walk->reached[from] = walk->far[from] <= walk->limit[from];
        near = vor_walk_near(walk, from, reach2, l2);
        for (near &= may_shorten(walk, from, l2); near > 0; near &= near - 1) {
            unsigned j = vor_walk_first(near);
            double far = walk->far[from] + sqrt(l2[j]);

            if (far < walk->far[j] && stays(walk, from, j, l2[j])) {
                walk->far[j] = far;
                met |= UINT64_C(1) << j;
            }
        }
    }
}
