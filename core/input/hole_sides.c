#include "core/input/hole_sides.h"

#include "core/base/linalg.h"
#include "core/input/loops.h"

#include <string.h>

/* Share of the way from one side's normal to the other's that the normal jumps at a crease. */
#define JUMP 0.75

struct groups {
    const struct vor_band *band;
    const struct vor_domain *domain;
    unsigned count;
    double mean[VOR_HOLE_SIDES][3]; /* unit vectors */
};

/* The normal of a point of the band, towards the side from which its plane is seen. */
static void normal_of(double out[3], const struct groups *groups, size_t i)
{
    double down;

    vor_to_doubles(out, groups->domain->graph.normal + 3 * (size_t)groups->band->point[i]);
    down = vor_dot(out, groups->band->up) < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++)
        out[c] *= down;
}

/* The group whose mean is nearest to a normal, and how near. */
static unsigned nearest(const struct groups *groups, const double normal[3], double *distance2)
{
    unsigned best = 0;

    *distance2 = vor_distance2(normal, groups->mean[0]);
    for (unsigned g = 1; g < groups->count; g++) {
        double other = vor_distance2(normal, groups->mean[g]);

        if (other < *distance2) {
            *distance2 = other;
            best = g;
        }
    }
    return best;
}

/* Adds a group at the normal of the loop that is farthest from the others. */
static void add_group(struct groups *groups)
{
    double most = -1, normal[3] = {0}, distance2;
    size_t at = 0;

    for (size_t i = 0; i < groups->band->rim; i++) {
        normal_of(normal, groups, i);
        nearest(groups, normal, &distance2);
        if (distance2 > most) {
            most = distance2;
            at = i;
        }
    }
    normal_of(groups->mean[groups->count++], groups, at);
}

static void make_means(struct groups *groups)
{
    double sum[VOR_HOLE_SIDES][3] = {{0}}, normal[3] = {0}, distance2;

    for (size_t i = 0; i < groups->band->rim; i++) {
        unsigned g;

        normal_of(normal, groups, i);
        g = nearest(groups, normal, &distance2);
        for (int c = 0; c < 3; c++)
            sum[g][c] += normal[c];
    }
    for (unsigned g = 0; g < groups->count; g++) {
        double length = sqrt(vor_dot(sum[g], sum[g]));

        for (int c = 0; c < 3 && length > 0; c++)
            groups->mean[g][c] = sum[g][c] / length;
    }
}

/* Whether the normal jumps between point i of the loop, the last one of its group, and the next,
 * from the point before them to the one after: fits next to a crease may have mixed both sides. */
static int jumps(const struct groups *groups, size_t i, unsigned from, unsigned to)
{
    size_t rim = groups->band->rim;
    double before[3] = {0}, after[3] = {0},
           whole = vor_distance2(groups->mean[from], groups->mean[to]);

    normal_of(before, groups, (i + rim - 1) % rim);
    normal_of(after, groups, (i + 2) % rim);
    return whole >= VOR_LOOPS_CREASE * VOR_LOOPS_CREASE &&
           vor_distance2(before, after) >= JUMP * JUMP * whole;
}

/* Whether each group has one piece of the loop, and creases part them. */
static int are_sides(const struct groups *groups)
{
    size_t rim = groups->band->rim;
    unsigned changes = 0, last;
    double normal[3] = {0}, distance2;

    normal_of(normal, groups, rim - 1);
    last = nearest(groups, normal, &distance2);
    for (size_t i = 0; i < rim; i++) {
        unsigned g;

        normal_of(normal, groups, i);
        g = nearest(groups, normal, &distance2);
        if (g != last && !jumps(groups, (i + rim - 1) % rim, last, g))
            return 0;
        changes += g != last;
        last = g;
    }
    return changes == groups->count;
}

unsigned vor_hole_sides_find(unsigned char *side, const struct vor_band *band,
                             const struct vor_domain *domain)
{
    struct groups groups = {.band = band, .domain = domain};
    double normal[3] = {0}, distance2;

    memset(side, 0, band->count);
    if (band->unrolled || !vor_graph_has_normals(&domain->graph))
        return 1;
    for (unsigned k = VOR_HOLE_SIDES; k > 1; k--) {
        memcpy(groups.mean[0], band->up, sizeof band->up);
        groups.count = 1;
        add_group(&groups);
        memcpy(groups.mean[0], groups.mean[1], sizeof band->up);
        groups.count = 1;
        while (groups.count < k)
            add_group(&groups);
        make_means(&groups);
        if (!are_sides(&groups))
            continue;
        for (size_t i = 0; i < band->count; i++) {
            normal_of(normal, &groups, i);
            side[i] = (unsigned char)nearest(&groups, normal, &distance2);
        }
        return k;
    }
    return 1;
}
