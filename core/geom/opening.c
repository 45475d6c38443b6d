#include "core/geom/opening.h"

#include "core/base/linalg.h"
#include "core/geom/metric.h"

#include <assert.h>

/* What grows with the angle of (x, y) and is 4 after a whole turn, without a function of libm. */
static double angle_of(const double direction[2])
{
    double x = direction[0], y = direction[1], sum = fabs(x) + fabs(y);

    if (y >= 0)
        return x >= 0 ? y / sum : 1 - x / sum;
    return x < 0 ? 2 - y / sum : 3 + x / sum;
}

/* Directions that a neighbour forbids, counter-clockwise from `first` to `last`. */
struct range {
    unsigned neighbour;
    double first[2], last[2]; /* unit vectors */
    double from, to;          /* their angles, 0 <= from < 4, from <= to < from + 4 */
};

struct ranges {
    double axis[2][3]; /* of the plane */
    unsigned count;
    struct range range[VOR_OPENING_NEAR];
};

/* Adds what a neighbour at (u, v) forbids: a half turn less at a distance of 0, nothing at two
 * radii. cos and sin: of half the range. */
static void add_range(struct ranges *ranges, unsigned neighbour, double u, double v, double radius)
{
    double distance = sqrt(u * u + v * v), cosine = distance / (2 * radius), sine;
    struct range *range = &ranges->range[ranges->count];

    if (!(distance > 0) || cosine >= 1)
        return;
    sine = sqrt(1 - cosine * cosine);
    u /= distance;
    v /= distance;
    range->neighbour = neighbour;
    range->first[0] = u * cosine + v * sine;
    range->first[1] = v * cosine - u * sine;
    range->last[0] = u * cosine - v * sine;
    range->last[1] = v * cosine + u * sine;
    range->from = angle_of(range->first);
    range->to = angle_of(range->last);
    if (range->to < range->from)
        range->to += 4;
    ranges->count++;
}

/* Whether another range goes on where range i ends. Of two that end together the first does not. */
static int goes_on(const struct ranges *ranges, unsigned i)
{
    double end = ranges->range[i].to;

    for (unsigned j = 0; j < ranges->count; j++) {
        const struct range *other = &ranges->range[j];
        double at = end >= other->from + 4 ? end - 4 : end < other->from ? end + 4 : end;

        if (j != i && (at < other->to || (at <= other->to && j < i)))
            return 1;
    }
    return 0;
}

/* The range that begins first after range i ends; *width is how far from there. */
static unsigned next_of(const struct ranges *ranges, unsigned i, double *width)
{
    double end = ranges->range[i].to;
    unsigned next = i;

    *width = 8;
    for (unsigned j = 0; j < ranges->count; j++) {
        double gap = ranges->range[j].from - end;

        gap += gap < -4 ? 8 : gap < 0 ? 4 : 0;
        if (gap < *width) {
            *width = gap;
            next = j;
        }
    }
    return next;
}

static void set_opening(struct vor_opening *out, const struct ranges *ranges, unsigned from,
                        unsigned to, const double x[3], double radius)
{
    const double *begin = ranges->range[from].last, *end = ranges->range[to].first;
    double across[2] = {end[1] - begin[1], begin[0] - end[0]}; /* a quarter turn from end - begin */
    double length = sqrt(across[0] * across[0] + across[1] * across[1]);

    out->end[0] = ranges->range[from].neighbour;
    out->end[1] = ranges->range[to].neighbour;
    for (int c = 0; c < 3; c++) {
        double u = ranges->axis[0][c], v = ranges->axis[1][c];

        out->middle[0][c] = x[c] + radius * (begin[0] * u + begin[1] * v);
        out->middle[1][c] = x[c] + radius * (end[0] * u + end[1] * v);
        out->outward[c] =
            length > 0 ? (across[0] * u + across[1] * v) / length : begin[0] * u + begin[1] * v;
    }
}

/* Collects the openings, the widest first. */
static unsigned collect(struct vor_opening *out, const struct ranges *ranges, const double x[3],
                        double radius)
{
    double widths[VOR_OPENINGS] = {0};
    unsigned count = 0;

    for (unsigned i = 0; i < ranges->count; i++) {
        double width;
        unsigned next, at;

        if (goes_on(ranges, i))
            continue;
        next = next_of(ranges, i, &width);
        for (at = count; at > 0 && width > widths[at - 1]; at--)
            if (at < VOR_OPENINGS) {
                widths[at] = widths[at - 1];
                out[at] = out[at - 1];
            }
        if (at == VOR_OPENINGS)
            continue;
        widths[at] = width;
        set_opening(&out[at], ranges, i, next, x, radius);
        count += count < VOR_OPENINGS;
    }
    return count;
}

unsigned vor_openings_find(struct vor_opening out[VOR_OPENINGS], const float *near, unsigned k,
                           const double x[3], const double normal[3], double radius)
{
    struct ranges ranges = {.count = 0};

    assert(k <= VOR_OPENING_NEAR);
    vor_metric_axes(ranges.axis, normal);
    for (unsigned j = 0; j < k; j++) {
        double d[3] = {(double)near[3 * j] - x[0], (double)near[3 * j + 1] - x[1],
                       (double)near[3 * j + 2] - x[2]};

        add_range(&ranges, j, vor_dot(d, ranges.axis[0]), vor_dot(d, ranges.axis[1]), radius);
    }
    return collect(out, &ranges, x, radius);
}
