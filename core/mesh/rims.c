#include "core/mesh/rims.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"

#include <assert.h>
#include <string.h>

/* Most edges of loops at a point: two for each fan, which has a triangle at least. */
enum { ENDS = 2 * VOR_AROUND_MOST };

/* An edge of a loop as seen from one end. */
struct end {
    uint32_t to;
    int opens;    /* the gap is counter-clockwise of it */
    double angle; /* grows with the angle from the first axis, 0 .. 4 */
};

/* Edges with one triangle by points: those of point i are first[i] .. first[i + 1] - 1. */
struct trace {
    const struct vor_complex *complex;
    const struct vor_sheet *sheet;
    uint32_t *first, *to, *pair; /* pair: the edge at the same point that a loop goes on along */
    unsigned char *seen;
    size_t arcs;
};

/* The neighbours of point i that it has one triangle with, and the third corners of these. */
static unsigned ends_of(const struct vor_complex *complex, uint32_t i, uint32_t to[ENDS],
                        uint32_t third[ENDS])
{
    unsigned found = 0;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t other[2], thirds[2];

        vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + t], i, other);
        for (int o = 0; o < 2; o++)
            if (vor_complex_edge(complex, i, other[o], thirds) == 1) {
                to[found] = other[o];
                third[found++] = other[1 - o];
            }
    }
    return found;
}

/* A number that grows with the angle of (x, y): 0 .. 4. */
static double angle(const double d[2])
{
    double length = fabs(d[0]) + fabs(d[1]), y = length > 0 ? d[1] / length : 0;

    if (d[0] < 0)
        return 2 - y;
    return d[1] < 0 ? 4 + y : y;
}

static void look(double out[2], const struct vor_sheet *sheet, const struct vor_frame *frame,
                 uint32_t i, uint32_t j)
{
    const float *a = &sheet->seeds->xyz[3 * (size_t)i], *b = &sheet->seeds->xyz[3 * (size_t)j];
    double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                   (double)b[2] - (double)a[2]};

    out[0] = vor_dot(frame->axis[0], d);
    out[1] = vor_dot(frame->axis[1], d);
}

/* Sorts the ends at a point around it. */
static void sort_ends(struct end *end, unsigned count)
{
    for (unsigned a = 1; a < count; a++) {
        struct end moved = end[a];
        unsigned b = a;

        for (; b > 0 && (end[b - 1].angle > moved.angle ||
                         (end[b - 1].angle == moved.angle && end[b - 1].to > moved.to));
             b--)
            end[b] = end[b - 1];
        end[b] = moved;
    }
}

/* Pairs the ends at point i: each that opens a gap with the next, which closes it, where they take
 * turns. Where they do not, as at the tip of a cone, in their order. */
static void pair_ends(struct trace *trace, uint32_t i, const uint32_t *to, const uint32_t *third,
                      unsigned count)
{
    struct vor_frame frame;
    struct end end[ENDS];
    uint32_t *first = &trace->to[trace->first[i]], *pair = &trace->pair[trace->first[i]];
    unsigned from = 0;

    vor_frame_of(&frame, &trace->sheet->normal[3 * (size_t)i]);
    for (unsigned e = 0; e < count; e++) {
        double a[2], b[2];

        look(a, trace->sheet, &frame, i, to[e]);
        look(b, trace->sheet, &frame, i, third[e]);
        end[e] = (struct end){to[e], a[0] * b[1] - a[1] * b[0] < 0, angle(a)};
    }
    sort_ends(end, count);
    for (unsigned e = 0; e < count; e++)
        first[e] = end[e].to;
    for (unsigned e = 1; e < count; e++)
        from = end[e].opens == end[e - 1].opens ? count : from;
    if (from == 0 && !end[0].opens)
        from = 1;
    from = from == count ? 0 : from;
    for (unsigned e = 0; e < count; e += 2) {
        unsigned a = (from + e) % count, b = (from + e + 1) % count;

        pair[a] = trace->first[i] + b;
        pair[b] = trace->first[i] + a;
    }
}

static vor_status begin(struct trace *trace, struct vor_error *err)
{
    struct vor_memory *memory = trace->complex->memory;
    size_t n = trace->complex->n;
    uint32_t to[ENDS], third[ENDS];

    trace->first = vor_malloc(memory, n + 1, sizeof *trace->first);
    if (trace->first == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t i = 0; i < n; i++) {
        trace->first[i] = (uint32_t)trace->arcs;
        trace->arcs += ends_of(trace->complex, (uint32_t)i, to, third);
    }
    trace->first[n] = (uint32_t)trace->arcs;
    trace->to = vor_malloc(memory, trace->arcs, sizeof *trace->to);
    trace->pair = vor_malloc(memory, trace->arcs, sizeof *trace->pair);
    trace->seen = vor_calloc(memory, trace->arcs, 1);
    if (trace->to == NULL || trace->pair == NULL || trace->seen == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu edges", trace->arcs);
    return VOR_OK;
}

/* The edge from the other end. */
static uint32_t twin(const struct trace *trace, uint32_t from, uint32_t arc)
{
    uint32_t other = trace->to[arc], at = trace->first[other];

    while (trace->to[at] != from) {
        at++;
        assert(at < trace->first[other + 1]);
    }
    return at;
}

static void walk(struct vor_rims *rims, struct trace *trace, uint32_t from, uint32_t arc)
{
    size_t at = rims->start[rims->count];

    while (!trace->seen[arc]) {
        uint32_t back = twin(trace, from, arc);

        rims->point[at++] = from;
        trace->seen[arc] = trace->seen[back] = 1;
        from = trace->to[arc];
        arc = trace->pair[back];
    }
    rims->start[++rims->count] = at;
}

static vor_status walk_all(struct vor_rims *rims, struct trace *trace, struct vor_error *err)
{
    size_t edges = trace->arcs / 2;

    rims->start = vor_malloc(rims->memory, edges / 3 + 2, sizeof *rims->start);
    rims->point = vor_malloc(rims->memory, edges, sizeof *rims->point);
    if (rims->start == NULL || rims->point == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu edges", edges);
    rims->start[0] = 0;
    for (size_t i = 0; i < trace->complex->n; i++)
        for (uint32_t arc = trace->first[i]; arc < trace->first[i + 1]; arc++)
            if (!trace->seen[arc])
                walk(rims, trace, (uint32_t)i, arc);
    return VOR_OK;
}

vor_status vor_rims_find(struct vor_rims *out, const struct vor_complex *complex,
                         const struct vor_sheet *sheet, struct vor_error *err)
{
    struct vor_rims rims = {.memory = complex->memory};
    struct trace trace = {.complex = complex, .sheet = sheet};
    vor_status status = begin(&trace, err);

    if (status == VOR_OK) {
        uint32_t to[ENDS], third[ENDS];

        for (size_t i = 0; i < trace.complex->n; i++) {
            unsigned count = ends_of(trace.complex, (uint32_t)i, to, third);

            if (count > 0)
                pair_ends(&trace, (uint32_t)i, to, third, count);
        }
        status = walk_all(&rims, &trace, err);
    }
    VOR_FREE_ALL(complex->memory, trace.seen, trace.pair, trace.to, trace.first);
    if (status == VOR_OK)
        *out = rims;
    else
        vor_rims_free(&rims);
    return status;
}

void vor_rims_free(struct vor_rims *rims)
{
    VOR_FREE_ALL(rims->memory, rims->point, rims->start);
    memset(rims, 0, sizeof *rims);
}
