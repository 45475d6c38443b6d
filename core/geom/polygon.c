#include "core/geom/polygon.h"

#include "core/base/linalg.h"
#include <math.h>
#include <string.h>

/* Most edges of a piece that is not halved. */
enum { LEAF_SIZE = 8 };

/* A piece: its edges, and its number, of which the halves' follow. */
struct piece {
    size_t number, begin, end;
};

static struct piece first_half(struct piece of)
{
    return (struct piece){2 * of.number, of.begin, of.begin + (of.end - of.begin) / 2};
}

static struct piece last_half(struct piece of)
{
    return (struct piece){2 * of.number + 1, of.begin + (of.end - of.begin) / 2, of.end};
}

static struct piece whole(const struct vor_polygon *polygon)
{
    return (struct piece){1, 0, polygon->n};
}

static const double *point(const struct vor_polygon *polygon, size_t i)
{
    return &polygon->at[polygon->dims * (i < polygon->n ? i : i - polygon->n)];
}

static double *box_of(const struct vor_polygon *polygon, struct piece piece)
{
    return &polygon->box[2 * polygon->dims * piece.number];
}

/* Makes the box of a piece hold the points from low to high. */
static void widen(const struct vor_polygon *polygon, double *box, const double *low,
                  const double *high)
{
    for (size_t c = 0; c < polygon->dims; c++) {
        box[c] = fmin(box[c], low[c]);
        box[polygon->dims + c] = fmax(box[polygon->dims + c], high[c]);
    }
}

static void make_boxes(const struct vor_polygon *polygon, struct piece piece)
{
    double *box = box_of(polygon, piece);

    for (size_t c = 0; c < polygon->dims; c++) {
        box[c] = INFINITY;
        box[polygon->dims + c] = -INFINITY;
    }
    if (piece.end - piece.begin <= LEAF_SIZE) {
        for (size_t i = piece.begin; i <= piece.end; i++)
            widen(polygon, box, point(polygon, i), point(polygon, i));
        return;
    }
    make_boxes(polygon, first_half(piece));
    make_boxes(polygon, last_half(piece));
    for (int half = 0; half < 2; half++) {
        const double *of = box_of(polygon, half ? last_half(piece) : first_half(piece));

        widen(polygon, box, of, of + polygon->dims);
    }
}

vor_status vor_polygon_init(struct vor_polygon *out, const double *at, size_t n, size_t dims,
                            struct vor_memory *memory, struct vor_error *err)
{
    struct vor_polygon polygon = {.memory = memory, .n = n, .dims = dims, .at = at};
    size_t pieces = 2;

    for (size_t most = n; most > LEAF_SIZE; most = most - most / 2)
        pieces *= 2;
    polygon.box = vor_malloc(memory, pieces, 2 * dims * sizeof *polygon.box);
    if (polygon.box == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu edges", n);
    make_boxes(&polygon, whole(&polygon));
    *out = polygon;
    return VOR_OK;
}

/* How often the line from u crosses a piece; only whether that is odd counts. */
static unsigned crossings(const struct vor_polygon *polygon, struct piece piece, const double u[2])
{
    const double *low = box_of(polygon, piece), *high = low + 2;
    unsigned count = 0;

    if (u[1] < low[1] || u[1] >= high[1] || u[0] >= high[0])
        return 0;
    if (u[0] < low[0])
        return (point(polygon, piece.begin)[1] > u[1]) != (point(polygon, piece.end)[1] > u[1]);
    if (piece.end - piece.begin > LEAF_SIZE)
        return crossings(polygon, first_half(piece), u) + crossings(polygon, last_half(piece), u);
    for (size_t i = piece.begin; i < piece.end; i++) {
        const double *a = point(polygon, i + 1), *b = point(polygon, i);

        count += (a[1] > u[1]) != (b[1] > u[1]) &&
                 u[0] < a[0] + (b[0] - a[0]) * (u[1] - a[1]) / (b[1] - a[1]);
    }
    return count;
}

int vor_polygon_within(const struct vor_polygon *polygon, const double u[2])
{
    return crossings(polygon, whole(polygon), u) % 2 != 0;
}

static double to_box2(const struct vor_polygon *polygon, struct piece piece, const double *x)
{
    const double *low = box_of(polygon, piece), *high = low + polygon->dims;
    double sum = 0;

    for (size_t c = 0; c < polygon->dims; c++) {
        double off = fmax(0, fmax(low[c] - x[c], x[c] - high[c]));

        sum += off * off;
    }
    return sum;
}

/* Takes an edge if it is nearer than the nearest so far. */
static void ask(struct vor_polygon_near *out, const struct vor_polygon *polygon, size_t i,
                const double *x)
{
    const double *p = point(polygon, i), *q = point(polygon, i + 1);
    double length2 = 0, t = 0, sum = 0;

    for (size_t c = 0; c < polygon->dims; c++) {
        length2 += (p[c] - q[c]) * (p[c] - q[c]);
        t += (x[c] - p[c]) * (q[c] - p[c]);
    }
    t = length2 > 0 ? fmax(0, fmin(1, t / length2)) : 0;
    for (size_t c = 0; c < polygon->dims; c++) {
        double off = x[c] - p[c] - t * (q[c] - p[c]);

        sum += off * off;
    }
    if (sum < out->distance2 || (sum <= out->distance2 && i < out->edge))
        *out = (struct vor_polygon_near){i, t, sum};
}

/* Looks through a piece that may have a nearer edge, the nearer half first. */
static void look(struct vor_polygon_near *out, const struct vor_polygon *polygon,
                 struct piece piece, const double *x)
{
    struct piece half[2] = {first_half(piece), last_half(piece)};
    double far[2];

    if (piece.end - piece.begin <= LEAF_SIZE) {
        for (size_t i = piece.begin; i < piece.end; i++)
            ask(out, polygon, i, x);
        return;
    }
    far[0] = to_box2(polygon, half[0], x);
    far[1] = to_box2(polygon, half[1], x);
    for (int turn = 0; turn < 2; turn++) {
        int which = (far[1] < far[0]) != turn;

        if (far[which] <= out->distance2 * (1 + VOR_ROUNDED2))
            look(out, polygon, half[which], x);
    }
}

void vor_polygon_nearest(struct vor_polygon_near *out, const struct vor_polygon *polygon,
                         const double *x)
{
    *out = (struct vor_polygon_near){polygon->n, 0, INFINITY};
    look(out, polygon, whole(polygon), x);
}

void vor_polygon_free(struct vor_polygon *polygon)
{
    vor_free(polygon->memory, polygon->box);
    memset(polygon, 0, sizeof *polygon);
}
