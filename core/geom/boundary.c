#include "core/geom/boundary.h"

#include "core/base/linalg.h"
#include "core/geom/fours.h"

#include <string.h>

/* Squared distance from x to the nearest of the points; *which is its index. */
VOR_CLONES static double nearest2(const float *near, unsigned k, const double x[3], unsigned *which)
{
    vor_fours best = INFINITY - (vor_fours){0};
    vor_fours_marks at = {0}, here = {0, 1, 2, 3};
    double least = INFINITY;

    for (unsigned i = 0; i < k; i += VOR_FOURS_LANES) {
        vor_fours d[3], d2;
        vor_fours_marks less;

        vor_fours_ways(d, near, k, i, x);
        vor_fours_squares(&d2, d);
        less = d2 < best;
        best = VOR_FOURS_CHOOSE(less, d2, best);
        at = (here & less) | (at & ~less);
        here += VOR_FOURS_LANES;
    }
    for (int j = 0; j < VOR_FOURS_LANES; j++)
        if (best[j] < least || (best[j] <= least && at[j] < *which && least < INFINITY)) {
            least = best[j];
            *which = (unsigned)at[j];
        }
    return least;
}

VOR_CLONES int vor_boundary_goes_on(const float *near, unsigned k, const double foot[3],
                                    const double way[3], double within)
{
    for (unsigned i = 0; i < k; i += VOR_FOURS_LANES) {
        vor_fours d[3], ahead, far;
        vor_fours_marks on;

        vor_fours_ways(d, near, k, i, foot);
        vor_fours_along(&ahead, way, d);
        vor_fours_squares(&far, d);
        for (int j = 0; j < VOR_FOURS_LANES; j++)
            far[j] = sqrt(far[j]);
        on = (ahead > 0) & (far <= within) & (ahead >= VOR_AHEAD_NARROW * far);
        if (vor_fours_any(&on))
            return 1;
    }
    return 0;
}

VOR_CLONES double vor_boundary_end(const struct vor_surface *frame, const double seed[3],
                                   const double side[2], const float *near, unsigned k)
{
    vor_fours farthest = -INFINITY - (vor_fours){0};
    double way[3], last = -INFINITY;

    for (int c = 0; c < 3; c++)
        way[c] = side[0] * frame->axis[0][c] + side[1] * frame->axis[1][c];
    for (unsigned i = 0; i < k; i += VOR_FOURS_LANES) {
        vor_fours d[3], ahead;

        vor_fours_ways(d, near, k, i, frame->origin);
        vor_fours_along(&ahead, way, d);
        farthest = VOR_FOURS_CHOOSE(ahead > farthest, ahead, farthest);
    }
    for (int j = 0; j < VOR_FOURS_LANES; j++)
        last = farthest[j] > last ? farthest[j] : last;
    return last - (side[0] * seed[0] + side[1] * seed[1]);
}

/* The neighbours that say where the input ends: the nearest ones. The others of a fit to many reach
 * around bends of the border. */
struct ends {
    unsigned k;
    const float *near;
    float own[3 * VOR_NEIGHBORS_FEWEST];
    double center[2], reach; /* as a surface has them */
};

/* Copies the VOR_NEIGHBORS_FEWEST of more neighbours that are nearest to x. */
static void copy_nearest(struct ends *out, const float *near, unsigned k, const double x[3])
{
    double distance2[VOR_NEIGHBORS_FEWEST];
    uint32_t index[VOR_NEIGHBORS_FEWEST] = {0}; /* gcc's analyzer cannot see that all are set */

    for (unsigned i = 0; i < k; i++) {
        double d[3] = {(double)near[3 * i] - x[0], (double)near[3 * i + 1] - x[1],
                       (double)near[3 * i + 2] - x[2]};
        double d2 = vor_dot(d, d);
        unsigned at = i < VOR_NEIGHBORS_FEWEST ? i : VOR_NEIGHBORS_FEWEST - 1;

        if (at < i && !(d2 < distance2[at]))
            continue;
        for (; at > 0 && d2 < distance2[at - 1]; at--) {
            distance2[at] = distance2[at - 1];
            index[at] = index[at - 1];
        }
        distance2[at] = d2;
        index[at] = i;
    }
    vor_gather(out->own, near, index, VOR_NEIGHBORS_FEWEST);
    out->near = out->own;
    out->k = VOR_NEIGHBORS_FEWEST;
}

/* Finds them around a seed. */
static void choose_ends(struct ends *out, const struct vor_surface *surface, const float *near,
                        unsigned k, const double seed[3])
{
    double at[VOR_NEIGHBORS_FEWEST][3], x[3], reach2 = 0;

    out->k = k;
    out->near = near;
    memcpy(out->center, surface->center, sizeof out->center);
    out->reach = surface->reach;
    if (k <= VOR_NEIGHBORS_FEWEST)
        return;
    vor_surface_to_world(surface, seed, x);
    copy_nearest(out, near, k, x);
    memset(out->center, 0, sizeof out->center);
    for (unsigned i = 0; i < out->k; i++) {
        for (unsigned c = 0; c < 3; c++)
            x[c] = (double)out->near[3 * i + c];
        vor_surface_to_local(surface, x, at[i]);
        out->center[0] += at[i][0] / out->k;
        out->center[1] += at[i][1] / out->k;
    }
    for (unsigned i = 0; i < out->k; i++) {
        double u = at[i][0] - out->center[0], v = at[i][1] - out->center[1];

        reach2 = fmax(reach2, u * u + v * v);
    }
    out->reach = sqrt(reach2);
}

/* vor_boundary_end towards the side that the neighbours leave empty, away from their mean. */
static double empty_side(const struct ends *ends, const struct vor_surface *surface,
                         const double seed[3], double side[2])
{
    double away[2] = {seed[0] - ends->center[0], seed[1] - ends->center[1]};
    double length = sqrt(away[0] * away[0] + away[1] * away[1]);

    if (!(length > 0))
        return INFINITY;
    side[0] = away[0] / length;
    side[1] = away[1] / length;
    return vor_boundary_end(surface, seed, side, ends->near, ends->k);
}

double vor_boundary_room(const struct vor_surface *surface, const float *near, unsigned k,
                         const double seed[3], double radius, double side[2])
{
    struct ends ends;
    double along, open;

    choose_ends(&ends, surface, near, k, seed);
    along = empty_side(&ends, surface, seed, side);
    open =
        (along / ends.reach - VOR_EDGE_SURE_BORDER) / (VOR_EDGE_SURE_INSIDE - VOR_EDGE_SURE_BORDER);
    if (open >= 1)
        return INFINITY;
    return fmax(along, 0) + VOR_EDGE_ROOM * surface->spacing + fmax(open, 0) * radius;
}

int vor_boundary_beyond(const struct vor_surface *surface, const float *near, unsigned k,
                        const double x[3])
{
    double seed[3], side[2];
    struct ends ends;

    vor_surface_to_local(surface, x, seed);
    choose_ends(&ends, surface, near, k, seed);
    return empty_side(&ends, surface, seed, side) < 0;
}

/* vor_boundary_spacing where the point nearest to x is known. */
VOR_CLONES static double spacing_at(const float *near, unsigned k, unsigned which)
{
    double best[3] = {INFINITY, INFINITY, INFINITY}, from[3];

    vor_to_doubles(from, &near[3 * (size_t)which]);
    for (unsigned i = 0; i < k; i += VOR_FOURS_LANES) {
        vor_fours d[3], d2;

        vor_fours_ways(d, near, k, i, from);
        vor_fours_squares(&d2, d);
        for (unsigned j = 0; j < VOR_FOURS_LANES && i + j < k; j++) {
            if (i + j == which || d2[j] >= best[2])
                continue;
            best[2] = d2[j];
            for (int at = 2; at > 0 && best[at] < best[at - 1]; at--) {
                double swap = best[at];

                best[at] = best[at - 1];
                best[at - 1] = swap;
            }
        }
    }
    return sqrt(best[2]);
}

double vor_boundary_spacing(const float *near, unsigned k, const double x[3])
{
    unsigned which = 0;

    (void)nearest2(near, k, x, &which);
    return spacing_at(near, k, which);
}

double vor_boundary_foot(const float *near, unsigned k, const double x[3], double foot[3],
                         double way[3])
{
    unsigned which = 0;
    double length = sqrt(nearest2(near, k, x, &which));

    for (unsigned c = 0; c < 3; c++) {
        foot[c] = (double)near[3 * which + c];
        way[c] = length > 0 ? (x[c] - foot[c]) / length : 0;
    }
    return length;
}

/* The place nearest to x on the lines from foot to those of the points within `within` of it. */
static void nearest_on_lines(const float *near, unsigned k, const double foot[3], double within,
                             const double x[3], double out[3])
{
    double from[3] = {x[0] - foot[0], x[1] - foot[1], x[2] - foot[2]};
    double best = vor_dot(from, from);

    memcpy(out, foot, 3 * sizeof *out);
    for (unsigned i = 0; i < k; i++) {
        double to[3] = {(double)near[3 * i] - foot[0], (double)near[3 * i + 1] - foot[1],
                        (double)near[3 * i + 2] - foot[2]};
        double length2 = vor_dot(to, to), along = vor_dot(from, to), share, d2;

        if (!(along > 0) || length2 > within * within)
            continue;
        share = fmin(1, along / length2);
        d2 = vor_dot(from, from) + share * (share * length2 - 2 * along);
        if (!(d2 < best))
            continue;
        best = d2;
        for (int c = 0; c < 3; c++)
            out[c] = foot[c] + share * to[c];
    }
}

int vor_boundary_pull(const float *near, unsigned k, const double foot[3], double spacing,
                      double x[3])
{
    double rim[3], way[3], length, margin = VOR_HOLE_MARGIN * spacing;

    nearest_on_lines(near, k, foot, VOR_RIM_RING * spacing, x, rim);
    for (int c = 0; c < 3; c++)
        way[c] = x[c] - rim[c];
    length = sqrt(vor_dot(way, way));
    if (!(length > margin))
        return 0;
    for (int c = 0; c < 3; c++)
        x[c] = rim[c] + way[c] * (margin / length);
    return 1;
}

VOR_CLONES double vor_boundary_reach(const float *near, unsigned k, const double x[3])
{
    vor_fours most = {0};
    double far2 = 0;

    for (unsigned i = 0; i < k; i += VOR_FOURS_LANES) {
        vor_fours d[3], d2;

        vor_fours_ways(d, near, k, i, x);
        vor_fours_squares(&d2, d);
        most = VOR_FOURS_CHOOSE(d2 > most, d2, most);
    }
    for (int j = 0; j < VOR_FOURS_LANES; j++)
        far2 = most[j] > far2 ? most[j] : far2;
    return sqrt(far2);
}

/* The comparisons are written out: of many points they are most of the time of a run. */
double vor_boundary_regularity(const float *near, unsigned k, double spacing)
{
    double best[VOR_NEIGHBORS_MAX], sum = 0;

    for (unsigned i = 0; i < k; i++)
        best[i] = INFINITY;
    for (unsigned i = 0; i < k; i++) {
        double own = best[i];

        for (unsigned j = i + 1; j < k; j++) {
            double d = vor_distance2f(&near[3 * i], &near[3 * j]);

            own = d < own ? d : own;
            best[j] = d < best[j] ? d : best[j];
        }
        sum += sqrt(own);
    }
    return sum / k / (spacing / 2);
}

/* Whether a direction lies to the left of a (side 1) or to its right (-1) by less than the angle
 * that is to be free. */
static int has_beside(const double direction[][2], unsigned count, double cosine, const double a[2],
                      double side)
{
    for (unsigned j = 0; j < count; j++) {
        const double *b = direction[j];

        if (side * (a[0] * b[1] - a[1] * b[0]) > 0 && a[0] * b[0] + a[1] * b[1] > cosine)
            return 1;
    }
    return 0;
}

int vor_boundary_free_side(const double direction[][2], unsigned count, double cosine,
                           double side[2])
{
    double middle[2] = {0, 0}, length;

    for (unsigned j = 0; j < count; j++)
        for (int turn = 1; turn >= -1; turn -= 2)
            if (!has_beside(direction, count, cosine, direction[j], turn)) {
                middle[0] -= turn * direction[j][1];
                middle[1] += turn * direction[j][0];
            }
    length = sqrt(middle[0] * middle[0] + middle[1] * middle[1]);
    if (!(length > 0))
        return 0;
    side[0] = middle[0] / length;
    side[1] = middle[1] / length;
    return 1;
}

int vor_boundary_within(const float *near, unsigned k, const double x[3], double distance)
{
    unsigned which = 0;

    return nearest2(near, k, x, &which) <= distance * distance;
}

/* The distance that x may have from the nearest point: less where it lies beyond the end of the
 * input. */
static double allowed_distance(const struct vor_border *border, double spacings, const double x[3])
{
    if (vor_boundary_beyond(border->surface, border->near, border->k, x))
        spacings *= VOR_OUTSIDE_BEYOND;
    return spacings * border->spacing;
}

/* The same of x that is `length` from the nearest point. */
static int is_outside(const struct vor_border *border, double spacings, const double x[3],
                      double length)
{
    return length > VOR_OUTSIDE_BEYOND * spacings * border->spacing &&
           length > allowed_distance(border, spacings, x);
}

int vor_boundary_outside(const struct vor_border *border, double spacings, const double x[3])
{
    unsigned which = 0;

    return is_outside(border, spacings, x, sqrt(nearest2(border->near, border->k, x, &which)));
}

int vor_boundary_leaves(const struct vor_border *border, double spacings, const double from[3],
                        const double to[3])
{
    struct vor_border there = *border;
    unsigned which = 0, other = 0;
    double length2 = nearest2(there.near, there.k, to, &which);

    if (length2 <= nearest2(there.near, there.k, from, &other))
        return 0;
    there.spacing = fmin(there.spacing, spacing_at(there.near, there.k, which));
    return is_outside(&there, spacings, to, sqrt(length2));
}

int vor_boundary_restrict(const struct vor_border *border, double spacings, double x[3])
{
    unsigned which = 0;
    double length, allowed;

    if (!vor_boundary_outside(border, spacings, x))
        return 0;
    length = sqrt(nearest2(border->near, border->k, x, &which));
    allowed = allowed_distance(border, spacings, x);
    for (unsigned c = 0; c < 3; c++) {
        double from = (double)border->near[3 * which + c];

        x[c] = from + (x[c] - from) * (allowed / length);
    }
    return 1;
}
