#include "core/input/sheet_walk.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"
#include "core/input/carried.h"

#include <math.h>

/* Figures as in input/adjacency.c. */

/* Sine of an edge over the surface between its normals. The wide one leaves round thin parts whole,
 * the narrow one, which is tried where that does not help, parts surfaces that cross. With 0.5
 * alone: cow 0.064, 4.01, arma2 0.124, 3.7; with 0.35 alone: cow 0.063, 4.18, arma2 0.117, 3.4;
 * with both: cow 0.062, 4.08, arma2 0.118, 3.5. */
const double vor_sheet_arcs[VOR_SHEET_ARCS] = {0.5, 0.35};
/* A list must lower the variance about the surface VOR_FINER times. At 2.9 / 2 / 1.4: cow
 * 0.066, 4.07 / 0.063, 4.18 / 0.063, 4.24, room 0.0470 / 0.0459 / 0.0456. */

/* Least spacing on the list over that of all points. Two sheets are denser together than one; the
 * steps that depth is rounded to are not, and the lists of one step are denser. At 0 / 0.9: cow
 * 0.063 / 0.063, triangles across of a gear with thin walls 0.0040 / 0.0014; with one round and a
 * cosine of 0.8, at 0.9 / 1.05: cow 0.074 / 0.076. */
#define SPARSER 0.9
/* Of those of the nearest that a walk left out, at least OVER lie over the list, not beside it,
 * and half lie FAR times its rms off it. */
#define OVER 0.3
#define FAR 4.0
/* Mean of the directions to the list's points, seen from a point over the list: 0 in its middle,
 * 0.64 at its straight end, 1 far outside. */
#define INSIDE 0.5
unsigned vor_sheet_walk_take(const struct vor_walk *walk, unsigned k, uint32_t *index)
{
    unsigned taken = 0;

    for (unsigned j = 0; j < walk->most && taken < k; j++)
        if (walk->reached[j])
            index[taken++] = walk->index[j];
    return taken;
}

void vor_sheet_walk_gather(struct vor_walk *walk, const struct vor_domain *domain, uint32_t i)
{
    walk->most = vor_domain_most(domain, VOR_WALK_MOST);
    walk->is_signed = 0;
    vor_knn_search(domain->knn, vor_domain_point(domain, i), 1, walk->most, walk->index,
                   walk->distance2);
    for (unsigned j = 0; j < walk->most; j++)
        for (int c = 0; c < 3; c++)
            walk->x[c][j] = vor_domain_point(domain, walk->index[j])[c];
}

int vor_sheet_walk_begin(struct vor_surface *plain, const struct vor_domain *domain, uint32_t i,
                         struct vor_knn_last *last)
{
    unsigned k = vor_domain_most(domain, VOR_ADJACENT);
    uint32_t index[VOR_ADJACENT];
    float distance2[VOR_ADJACENT];

    vor_knn_search_next(domain->knn, last, vor_domain_point(domain, i), k, index, distance2);
    return vor_surface_fit_to(plain, domain->xyz, index, k) && vor_layers_possible(plain);
}

unsigned vor_sheet_walk_go(struct vor_walk *walk, struct vor_surface *own,
                           const struct vor_surface *plain, const struct vor_domain *domain,
                           uint32_t *index)
{
    for (unsigned a = 0; a < VOR_SHEET_ARCS; a++) {
        unsigned n;

        walk->arc = vor_sheet_arcs[a];
        walk->enough = vor_domain_most(domain, VOR_ADJACENT);
        vor_walk_go(walk);
        n = vor_sheet_walk_take(walk, walk->enough, index);
        if (n == walk->enough && index[n - 1] == walk->index[n - 1])
            continue; /* all of the nearest, whose surface is `plain` */
        if (n >= VOR_ADJACENT_FEWEST && vor_surface_fit_to(own, domain->xyz, index, n) &&
            own->spacing >= SPARSER * plain->spacing && VOR_FINER * own->off2 < plain->off2)
            return n;
    }
    return 0;
}

/* Whether x, in the frame of the list's surface, lies over the n points of the list and not beside
 * them. */
static int lies_over(const struct vor_surface *own, const struct vor_domain *domain,
                     const uint32_t *index, unsigned n, const double x[3])
{
    double su = 0, sv = 0;

    for (unsigned j = 0; j < n; j++) {
        const float *p = vor_domain_point(domain, index[j]);
        double at[3] = {(double)p[0], (double)p[1], (double)p[2]}, local[3], u, v, l2;

        vor_surface_to_local(own, at, local);
        u = local[0] - x[0];
        v = local[1] - x[1];
        l2 = u * u + v * v;
        if (l2 > 0) {
            su += u / sqrt(l2);
            sv += v / sqrt(l2);
        }
    }
    return su * su + sv * sv < INSIDE * INSIDE * n * n;
}

/* Whether a point lies far off the list; where it lies in the frame of the list's surface. */
static int lies_far(const struct vor_surface *own, const float *p, double local[3])
{
    double off;

    vor_surface_to_local(own, (double[3]){(double)p[0], (double)p[1], (double)p[2]}, local);
    off = local[2] - vor_surface_height(own, local[0], local[1], NULL);
    return off * off > FAR * FAR * own->off2;
}

int vor_sheet_walk_left_over(const struct vor_walk *walk, const struct vor_surface *own,
                             const struct vor_domain *domain, const uint32_t *index, unsigned n)
{
    unsigned out = 0, far = 0, over = 0;

    for (unsigned j = 0; j < vor_domain_most(domain, VOR_ADJACENT); j++) {
        double local[3];

        if (walk->reached[j])
            continue;
        out++;
        far += (unsigned)lies_far(own, vor_domain_point(domain, walk->index[j]), local);
        over += (unsigned)lies_over(own, domain, index, n, local);
    }
    return out > 0 && 2 * far >= out && over >= OVER * out;
}

unsigned vor_sheet_walk_carried(struct vor_walk *walk, struct vor_surface *own,
                                const struct vor_surface *plain, const struct vor_domain *domain,
                                uint32_t *index)
{
    const struct vor_attribute *carried = domain->known.carried;
    double local[3];
    unsigned n, other = 0;

    for (unsigned j = 0; j < walk->most; j++) {
        double normal[3];

        if (carried == NULL || !vor_carried_normal(carried, domain->source[walk->index[j]], normal))
            return 0;
        for (int c = 0; c < 3; c++)
            walk->normal[c][j] = (float)(normal[c] / sqrt(vor_dot(normal, normal)));
    }
    walk->is_signed = 1;
    n = vor_sheet_walk_go(walk, own, plain, domain, index);
    walk->is_signed = 0;
    for (unsigned j = 1; j < vor_domain_most(domain, VOR_ADJACENT) && n > 0; j++) {
        float(*m)[VOR_WALK_MOST] = walk->normal;

        if (m[0][j] * m[0][0] + m[1][j] * m[1][0] + m[2][j] * m[2][0] >= 0)
            continue;
        other++;
        if (!lies_far(own, vor_domain_point(domain, walk->index[j]), local))
            n = 0;
    }
    return other > 0 ? n : 0;
}
