#include "core/geom/winding.h"

#include "core/base/linalg.h"

#include <string.h>

enum {
    BLOCK = 64,     /* points that far away count as one. Not measured. */
    TASK_SIZE = 16, /* blocks of one task */
    SAMPLES = VOR_WINDING_PLACES,
    PIECES = VOR_SPAN_JOINS + 1,
    BESIDE = 2 * SAMPLES /* points of a whole component beside which numbers are taken */
};

/* Distance beyond which a block counts as one, over its radius. */
#define FAR 3.0
/* What turning a part has to gain, over the product of its share of the area and that of the rest;
 * and VOR_SURE times that and the fourth power of the support. Faces of a wedge and a tetrahedron
 * that all edges hold on the wrong side gain 0.53 and more; small patches that are right, among
 * noise, up to 0.4. */
#define GAIN 0.15

/* Points of one piece that lie together. */
struct block {
    size_t begin, end; /* in member */
    unsigned piece;
    double middle[3], radius2, sum[3]; /* sum: of the normals, by area */
};

/* One component at work. Piece 0 is in no patch, piece j + 1 in that of join j and in none before.
 */
struct winding {
    const struct vor_span *span;
    const struct vor_winding_points *points;
    uint32_t *point;                 /* points, component by component */
    uint32_t *begins;                /* components + 1: in point */
    unsigned char *piece;            /* of each point */
    uint32_t *member;                /* points of the component, piece by piece */
    size_t start[PIECES + 1];        /* in member */
    uint64_t inside[VOR_SPAN_JOINS]; /* the pieces of each patch, a bit each */
    struct block *block;
    size_t blocks;
    double area[PIECES]; /* shares of the whole */
    size_t samples, first[PIECES + 1];
    uint32_t at[PIECES * SAMPLES];          /* of whole components: both ends of each edge */
    float number[PIECES * SAMPLES][PIECES]; /* what each piece gives there */
    size_t besides;
    double beside[BESIDE][2]; /* numbers on both sides of points of the whole component */
};

static void make_block(struct block *block, const struct winding *winding)
{
    const float *xyz = winding->points->xyz, *normal = winding->points->normal;

    for (size_t k = block->begin; k < block->end; k++)
        for (size_t c = 0; c < 3; c++)
            block->middle[c] += (double)xyz[3 * (size_t)winding->member[k] + c] /
                                (double)(block->end - block->begin);
    for (size_t k = block->begin; k < block->end; k++) {
        size_t i = winding->member[k];
        double from[3], area = (double)winding->points->area[i];

        for (size_t c = 0; c < 3; c++) {
            from[c] = (double)xyz[3 * i + c] - block->middle[c];
            block->sum[c] += (winding->span->odd[i] ? -area : area) * (double)normal[3 * i + c];
        }
        block->radius2 = fmax(block->radius2, vor_dot(from, from));
    }
}

static void make_blocks(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct winding *winding = ctx;

    for (size_t b = begin; b < end; b++)
        make_block(&winding->block[b], winding);
}

/* What the points of a block give at x, at or beside point p. */
static double near_number(const struct winding *winding, const struct block *block, size_t p,
                          const double x[3])
{
    const struct vor_winding_points *points = winding->points;
    double number = 0;

    for (size_t k = block->begin; k < block->end; k++) {
        size_t i = winding->member[k];
        double to[3], normal[3], area = (double)points->area[i], r2;

        for (size_t c = 0; c < 3; c++) {
            to[c] = (double)points->xyz[3 * i + c] - x[c];
            normal[c] = (double)points->normal[3 * i + c];
        }
        /* What lies nearer than a spacing counts as if it were a spacing away. */
        r2 = fmax(fmax(vor_dot(to, to), (double)points->area[p]), 1e-200);
        number += (winding->span->odd[i] ? -area : area) * vor_dot(to, normal) / (r2 * sqrt(r2));
    }
    return number;
}

/* What a block gives at x, at or beside point p. */
static double number_of(const struct winding *winding, const struct block *block, size_t p,
                        const double x[3])
{
    double to[3], r2;

    for (int c = 0; c < 3; c++)
        to[c] = block->middle[c] - x[c];
    r2 = vor_dot(to, to);
    return (r2 <= FAR * FAR * block->radius2 ? near_number(winding, block, p, x)
                                             : vor_dot(to, block->sum) / (r2 * sqrt(r2))) /
           (4 * M_PI);
}

static void take_numbers(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct winding *winding = ctx;

    for (size_t k = begin; k < end; k++) {
        double x[3];

        vor_to_doubles(x, &winding->points->xyz[3 * (size_t)winding->at[k]]);
        for (size_t b = 0; b < winding->blocks; b++)
            winding->number[k][winding->block[b].piece] +=
                (float)number_of(winding, &winding->block[b], winding->at[k], x);
    }
}

/* Takes numbers on both sides of points of a component that is one piece, a spacing off: at three,
 * 1,180 of 10,000 points of a noisy blade are turned inward. */
static void take_beside(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct winding *winding = ctx;
    const struct vor_winding_points *points = winding->points;
    size_t count = winding->start[PIECES];

    for (size_t k = begin; k < end; k++) {
        size_t p = winding->member[k * count / winding->besides];
        double off = sqrt((double)points->area[p]);

        for (int side = 0; side < 2; side++) {
            double x[3], number = 0;

            for (size_t c = 0; c < 3; c++)
                x[c] = (double)points->xyz[3 * p + c] +
                       (side ? -off : off) * (double)points->normal[3 * p + c];
            for (size_t b = 0; b < winding->blocks; b++)
                number += number_of(winding, &winding->block[b], p, x);
            winding->beside[k][side] = number;
        }
    }
}

/* Takes numbers at both ends of edges. */
static void take_ends(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct winding *winding = ctx;

    for (size_t k = begin; k < end; k++)
        for (int side = 0; side < 2; side++) {
            size_t p = winding->at[2 * k + (size_t)side];
            double x[3], number = 0;

            vor_to_doubles(x, &winding->points->xyz[3 * p]);
            for (size_t b = 0; b < winding->blocks; b++)
                number += number_of(winding, &winding->block[b], p, x);
            winding->beside[k][side] = number;
        }
}

/* Lists every step-th edge of the component at work that the other signs turn. Returns how many it
 * has of these, which begin at so many points. */
static size_t list_turned(size_t *points, struct winding *winding, size_t step)
{
    const struct vor_graph *graph = winding->points->graph;
    const unsigned char *odd = winding->span->odd, *other = winding->points->other;
    size_t count = 0;

    *points = 0;
    for (size_t k = 0; k < winding->start[PIECES]; k++) {
        uint32_t i = winding->member[k];
        size_t before = count;

        for (unsigned a = 0; a < graph->count[i]; a++) {
            uint32_t j = graph->list[(size_t)i * graph->most + a];

            if ((odd[i] ^ odd[j]) == (other[i] ^ other[j]))
                continue;
            if (step > 0 && count % step == 0) {
                winding->at[2 * (count / step)] = i;
                winding->at[2 * (count / step) + 1] = j;
            }
            count++;
        }
        *points += count > before;
    }
    return count;
}

/* Finds how far numbers differ over edges that the other signs turn. */
static vor_status find_jump(struct vor_winding_found *out, struct winding *winding,
                            const struct vor_run *run, struct vor_error *err)
{
    size_t points, all = list_turned(&points, winding, 0), step = (all + BESIDE - 1) / BESIDE;
    vor_status status;

    if (all == 0)
        return VOR_OK;
    out->seam = (double)points / sqrt((double)winding->start[PIECES]);
    (void)list_turned(&points, winding, step);
    winding->besides = (all + step - 1) / step;
    status = vor_run_for(run, winding->besides, 1, take_ends, winding, err);
    for (size_t k = 0; k < winding->besides && status == VOR_OK; k++) {
        double jump = winding->beside[k][0] - winding->beside[k][1];

        out->jump += jump * jump / (double)winding->besides;
    }
    return status;
}

/* Mean square of how far the numbers beside the surface are from 0 or from that inside. */
static double stray(const struct winding *winding, double inside)
{
    double sum = 0;

    for (size_t k = 0; k < winding->besides; k++)
        for (int side = 0; side < 2; side++) {
            double out = winding->beside[k][side], in = out - inside;

            sum += fmin(out * out, in * in);
        }
    return sum / (double)(2 * winding->besides);
}

/* Lists the points of component c, by pieces: those of its patches if asked for, else one. */
static void list_members(struct winding *winding, size_t c, int patches)
{
    const struct vor_span *span = winding->span;
    size_t at[PIECES + 1] = {0};

    memset(winding->inside, 0, sizeof winding->inside);
    for (size_t k = winding->begins[c]; k < winding->begins[c + 1]; k++)
        winding->piece[winding->point[k]] = 0;
    for (unsigned j = 0; patches && j < span->joins; j++) {
        uint32_t p = span->join[j].first;

        for (uint32_t k = 0; span->component[p] == c && k < span->join[j].count; k++) {
            if (winding->piece[p] == 0)
                winding->piece[p] = (unsigned char)(j + 1);
            winding->inside[j] |= 1ULL << winding->piece[p];
            if (k + 1 < span->join[j].count)
                p = span->next[p];
        }
    }
    for (size_t k = winding->begins[c]; k < winding->begins[c + 1]; k++)
        at[winding->piece[winding->point[k]] + 1]++;
    for (unsigned p = 0; p < PIECES; p++)
        at[p + 1] += at[p];
    memcpy(winding->start, at, sizeof at);
    for (size_t k = winding->begins[c]; k < winding->begins[c + 1]; k++)
        winding->member[at[winding->piece[winding->point[k]]]++] = winding->point[k];
}

/* Cuts the pieces into blocks, and chooses samples. */
static void cut(struct winding *winding)
{
    double whole = 0;

    winding->blocks = winding->samples = 0;
    memset(winding->area, 0, sizeof winding->area);
    for (unsigned p = 0; p < PIECES; p++) {
        size_t begin = winding->start[p], end = winding->start[p + 1];
        size_t samples = end - begin < SAMPLES ? end - begin : SAMPLES;

        for (size_t k = begin; k < end; k++)
            winding->area[p] += (double)winding->points->area[winding->member[k]];
        for (size_t k = begin; k < end; k += BLOCK)
            winding->block[winding->blocks++] =
                (struct block){.begin = k, .end = k + BLOCK < end ? k + BLOCK : end, .piece = p};
        winding->first[p] = winding->samples;
        for (size_t k = 0; k < samples; k++)
            winding->at[winding->samples++] = winding->member[begin + k * (end - begin) / samples];
        winding->first[p + 1] = winding->samples;
        whole += winding->area[p];
    }
    for (unsigned p = 0; p < PIECES; p++)
        winding->area[p] /= fmax(whole, 1e-300);
}

/* Where the numbers stand if the pieces of a set are turned. */
static struct vor_winding_found found_with(const struct winding *winding, uint64_t turned)
{
    double mean = 0, square = 0, miss;
    float sign[PIECES];

    for (unsigned p = 0; p < PIECES; p++)
        sign[p] = turned >> p & 1 ? -1 : 1;
    for (unsigned p = 0; p < PIECES; p++) {
        size_t first = winding->first[p], last = winding->first[p + 1];

        for (size_t k = first; k < last; k++) {
            double weight = winding->area[p] / (double)(last - first);
            float number = 0;

            for (unsigned q = 0; q < PIECES; q++)
                number += sign[q] * winding->number[k][q];
            mean += weight * (double)number;
            square += weight * (double)number * (double)number;
        }
    }
    miss = fmax(0, .5 - fabs(mean));
    return (struct vor_winding_found){mean, square - mean * mean + miss * miss, 0, 0, 0};
}

/* Adds to the pieces that are turned those whose turning gains most. Returns whether there are any.
 */
static int turn_best(uint64_t *turned, struct vor_winding_found *found,
                     const struct winding *winding)
{
    struct vor_winding_found best = *found;
    uint64_t with = *turned;

    for (unsigned m = 0; m < winding->span->joins + PIECES; m++) {
        int patch = m < winding->span->joins; /* or a single piece */
        uint64_t pieces = patch ? winding->inside[m] : 1ULL << (m - winding->span->joins);
        double support = patch ? winding->span->join[m].support : 1, share = 0, least;
        struct vor_winding_found now;

        for (unsigned p = 0; p < PIECES; p++)
            share += pieces >> p & 1 ? winding->area[p] : 0;
        /* What turning them has to gain, for it to be done against the edges. */
        least = GAIN * share * (1 - share) * fmax(1, VOR_SURE * vor_power(support, 4));
        if (pieces == 0 || least <= 0)
            continue;
        now = found_with(winding, *turned ^ pieces);
        if (found->apart - now.apart > least && now.apart < best.apart) {
            best = now;
            with = *turned ^ pieces;
        }
    }
    if (with == *turned)
        return 0;
    *turned = with;
    *found = best;
    return 1;
}

/* Takes the numbers on component c. */
static vor_status measure(struct winding *winding, size_t c, int patches, const struct vor_run *run,
                          struct vor_error *err)
{
    vor_status status;

    list_members(winding, c, patches);
    cut(winding);
    memset(winding->number, 0, winding->samples * sizeof *winding->number);
    status = vor_run_for(run, winding->blocks, TASK_SIZE, make_blocks, winding, err);
    VOR_THEN(status, vor_run_for(run, winding->samples, 1, take_numbers, winding, err));
    return status;
}

/* Lists the points component by component, in their order. */
static void sort_points(struct winding *winding)
{
    const struct vor_span *span = winding->span;
    uint32_t *first = winding->begins;

    for (size_t i = 0; i < span->n; i++)
        first[span->component[i] + 1]++;
    for (size_t c = 0; c < span->components; c++)
        first[c + 1] += first[c];
    for (size_t i = 0; i < span->n; i++)
        winding->point[first[span->component[i]]++] = (uint32_t)i;
    memmove(&first[1], first, span->components * sizeof *first);
    first[0] = 0;
}

static vor_status begin(struct winding **out, const struct vor_span *span,
                        const struct vor_winding_points *points, const struct vor_run *run,
                        struct vor_error *err)
{
    struct vor_memory *memory = run->memory;
    struct winding *winding = *out = vor_calloc(memory, 1, sizeof *winding);

    if (winding == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", span->n);
    winding->span = span;
    winding->points = points;
    if (VOR_MAKE_ALL(memory, err, span->n, VOR_ARRAY(winding->point, span->n, 1),
                     VOR_ZEROED(winding->begins, span->components + 1, 1),
                     VOR_ARRAY(winding->piece, span->n, 1), VOR_ARRAY(winding->member, span->n, 1),
                     VOR_ARRAY(winding->block, span->n / BLOCK + PIECES, 1)) != VOR_OK)
        return VOR_E_NOMEM;
    sort_points(winding);
    return VOR_OK;
}

static void end(struct winding *winding, const struct vor_run *run)
{
    if (winding == NULL)
        return;
    VOR_FREE_ALL(run->memory, winding->block, winding->member, winding->piece, winding->begins,
                 winding->point, winding);
}

/* Turns the pieces of component c that face the wrong way. */
static vor_status turn_component(struct winding *winding, struct vor_span *span, size_t c,
                                 const struct vor_run *run, struct vor_error *err)
{
    vor_status status = measure(winding, c, 1, run, err);
    struct vor_winding_found found;
    uint64_t turned = 0;

    if (status != VOR_OK)
        return status;
    found = found_with(winding, 0);
    while (turn_best(&turned, &found, winding))
        ;
    for (size_t k = 0; k < winding->start[PIECES]; k++)
        span->odd[winding->member[k]] ^= turned >> winding->piece[winding->member[k]] & 1;
    return VOR_OK;
}

vor_status vor_winding_turn(struct vor_span *span, const struct vor_winding_points *points,
                            const struct vor_run *run, struct vor_error *err)
{
    struct winding *winding;
    vor_status status = begin(&winding, span, points, run, err);

    for (unsigned j = 0; j < span->joins && status == VOR_OK; j++) {
        unsigned before = 0;

        while (span->component[span->join[before].first] != span->component[span->join[j].first])
            before++;
        if (before == j)
            status = turn_component(winding, span, span->component[span->join[j].first], run, err);
    }
    end(winding, run);
    return status;
}

vor_status vor_winding_find(struct vor_winding_found *out, const struct vor_span *span,
                            const struct vor_winding_points *points, const struct vor_run *run,
                            struct vor_error *err)
{
    struct winding *winding;
    vor_status status = begin(&winding, span, points, run, err);

    for (size_t c = 0; c < span->components && status == VOR_OK; c++) {
        size_t count = winding->begins[c + 1] - winding->begins[c];

        out[c] = (struct vor_winding_found){0, 0, 0, 0, 0};
        if (count < points->least)
            continue;
        status = measure(winding, c, 0, run, err);
        winding->besides = count < BESIDE ? count : BESIDE;
        VOR_THEN(status, vor_run_for(run, winding->besides, 1, take_beside, winding, err));
        if (status != VOR_OK)
            continue;
        out[c] = found_with(winding, 0);
        out[c].stray = stray(winding, out[c].mean < 0 ? -1 : 1);
        if (points->other != NULL)
            status = find_jump(&out[c], winding, run, err);
    }
    end(winding, run);
    return status;
}
