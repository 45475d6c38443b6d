#include "core/geom/winding.h"

#include "core/base/linalg.h"

#include <string.h>

/* Figures are of white noise of 30,000 points: gains of patches of armadillo (twelve draws) that
 * are wrong, and of patches that are right. */

enum {
    BLOCK = 64,   /* points that far away count as one. Not measured. */
    TASK = 16,    /* blocks of one task */
    SAMPLES = 32, /* places on a patch, and on the rest, where numbers are taken. */
    OTHER = 0,    /* which points there are beside those of two sides: other components */
    REST = 1,
    PATCH = 2
};

/* Distance beyond which a block counts as one, over its radius. */
#define FAR 3.0
/* A patch is turned if that lowers the mean square of how far its numbers are from those of the
 * rest, to less than this share, */
#define SHARE 0.4
/* and by more than this. Wrong patches gain 0.022 to 0.9, the least of them with little support;
 * right ones up to 0.016 with a support of 0.35. */
#define GAIN 0.02
/* And by more than this times the fourth power of the support: of patches that all edges hold,
 * wrong ones gain 0.11 and 0.9, right ones of fandisk with noise 0.041. */
#define GAIN_SURE 0.08
#define PI 3.14159265358979

/* Consecutive points: the middle and the square of the radius, and of the rest and of the patch
 * the sum of normals by area. */
struct block {
    double middle[3], radius2, sum[2][3];
};

/* One patch at work. */
struct winding {
    struct vor_span *span;
    const struct vor_winding_points *points;
    unsigned char *side; /* OTHER, REST or PATCH of each point */
    struct block *block;
    size_t blocks;
    unsigned samples; /* of the patch; as many of the rest follow */
    uint32_t at[2 * SAMPLES];
    double number[2 * SAMPLES][2]; /* what the rest and the patch give there */
};

static void make_block(struct block *out, const struct winding *winding, size_t begin, size_t end)
{
    const float *xyz = winding->points->xyz, *normal = winding->points->normal;

    memset(out, 0, sizeof *out);
    for (size_t i = begin; i < end; i++)
        for (size_t c = 0; c < 3; c++)
            out->middle[c] += (double)xyz[3 * i + c] / (double)(end - begin);
    for (size_t i = begin; i < end; i++) {
        double from[3], area = (double)winding->points->area[i];
        unsigned side = winding->side[i];

        for (size_t c = 0; c < 3; c++) {
            from[c] = (double)xyz[3 * i + c] - out->middle[c];
            if (side != OTHER)
                out->sum[side - 1][c] +=
                    (winding->span->odd[i] ? -area : area) * (double)normal[3 * i + c];
        }
        out->radius2 = fmax(out->radius2, vor_dot(from, from));
    }
}

static void make_blocks(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct winding *winding = ctx;
    size_t n = winding->span->n;

    (void)worker;
    for (size_t b = begin; b < end; b++)
        make_block(&winding->block[b], winding, b * BLOCK,
                   (b + 1) * BLOCK < n ? (b + 1) * BLOCK : n);
}

/* Adds what the points of a block give at point p. */
static void add_near(double number[2], const struct winding *winding, size_t b, uint32_t p)
{
    const struct vor_winding_points *points = winding->points;
    size_t n = winding->span->n, end = (b + 1) * BLOCK < n ? (b + 1) * BLOCK : n;

    for (size_t i = b * BLOCK; i < end; i++) {
        double to[3], normal[3], area = (double)points->area[i], r2;

        if (winding->side[i] == OTHER || i == p)
            continue;
        for (size_t c = 0; c < 3; c++) {
            to[c] = (double)points->xyz[3 * i + c] - (double)points->xyz[3 * (size_t)p + c];
            normal[c] = (double)points->normal[3 * i + c];
        }
        /* What lies nearer than a spacing counts as if it were a spacing away. */
        r2 = fmax(fmax(vor_dot(to, to), (double)points->area[p]), 1e-300);
        number[winding->side[i] - 1] +=
            (winding->span->odd[i] ? -area : area) * vor_dot(to, normal) / (r2 * sqrt(r2));
    }
}

static void take_number(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct winding *winding = ctx;

    (void)worker;
    for (size_t k = begin; k < end; k++) {
        const float *x = &winding->points->xyz[3 * (size_t)winding->at[k]];
        double number[2] = {0, 0};

        for (size_t b = 0; b < winding->blocks; b++) {
            const struct block *block = &winding->block[b];
            double to[3], r2;

            for (int c = 0; c < 3; c++)
                to[c] = block->middle[c] - (double)x[c];
            r2 = vor_dot(to, to);
            if (r2 <= FAR * FAR * block->radius2)
                add_near(number, winding, b, winding->at[k]);
            else
                for (int side = 0; side < 2; side++)
                    number[side] += vor_dot(to, block->sum[side]) / (r2 * sqrt(r2));
        }
        winding->number[k][0] = number[0] / (4 * PI);
        winding->number[k][1] = number[1] / (4 * PI);
    }
}

/* Says which side each point is on, and chooses the samples. Returns whether there are some of the
 * rest. */
static int choose(struct winding *winding, const struct vor_span_join *join)
{
    const struct vor_span *span = winding->span;
    uint32_t p = join->first;
    size_t next = 0;

    winding->samples = join->count < SAMPLES ? join->count : SAMPLES;
    for (size_t i = 0; i < span->n; i++)
        winding->side[i] = span->first[i] == span->first[p] ? REST : OTHER;
    for (uint32_t k = 0; k < join->count; k++, p = span->next[p]) {
        winding->side[p] = PATCH;
        if (next < winding->samples && k >= (uint64_t)next * join->count / winding->samples)
            winding->at[next++] = p;
    }
    for (unsigned k = 0; k < winding->samples; k++) {
        size_t i = (uint64_t)k * span->n / winding->samples, tried = 0;

        while (winding->side[i] != REST && tried++ < span->n)
            i = (i + 1) % span->n;
        if (winding->side[i] != REST)
            return 0;
        winding->at[winding->samples + k] = (uint32_t)i;
    }
    return 1;
}

/* Whether the numbers say that the patch faces the wrong way. */
static int is_wrong(const struct winding *winding, double support)
{
    double wanted = 0, now = 0, turned = 0, support2 = support * support, whole;
    unsigned n = winding->samples;

    for (unsigned k = n; k < 2 * n; k++)
        wanted += (winding->number[k][0] + winding->number[k][1]) / n;
    for (unsigned k = 0; k < n; k++) {
        double rest = winding->number[k][0] - wanted, patch = winding->number[k][1];

        now += (rest + patch) * (rest + patch) / n;
        turned += (rest - patch) * (rest - patch) / n;
    }
    whole = fmax(0.25, wanted * wanted);
    return turned < SHARE * now &&
           now - turned > 4 * whole * fmax(GAIN, GAIN_SURE * support2 * support2);
}

static vor_status judge(struct winding *winding, const struct vor_span_join *join,
                        const struct vor_run *run, struct vor_error *err)
{
    uint32_t p = join->first;
    vor_status status;

    if (!choose(winding, join))
        return VOR_OK;
    status = vor_run_for(run, winding->blocks, TASK, make_blocks, winding, err);
    if (status == VOR_OK)
        status = vor_run_for(run, 2 * (size_t)winding->samples, 1, take_number, winding, err);
    if (status == VOR_OK && is_wrong(winding, join->support))
        for (uint32_t k = 0; k < join->count; k++, p = winding->span->next[p])
            winding->span->odd[p] ^= 1;
    return status;
}

static vor_status begin(struct winding *winding, struct vor_span *span,
                        const struct vor_winding_points *points, const struct vor_run *run,
                        struct vor_error *err)
{
    *winding = (struct winding){.span = span, .points = points};
    winding->blocks = (span->n - 1) / BLOCK + 1;
    winding->side = vor_malloc(run->memory, span->n, sizeof *winding->side);
    winding->block = vor_malloc(run->memory, winding->blocks, sizeof *winding->block);
    if (winding->side == NULL || winding->block == NULL)
        return vor_fail(err, VOR_E_NOMEM, "winding numbers of %zu points", span->n);
    return VOR_OK;
}

static void end(struct winding *winding, const struct vor_run *run)
{
    vor_free(run->memory, winding->block);
    vor_free(run->memory, winding->side);
}

vor_status vor_winding_turn(struct vor_span *span, const struct vor_winding_points *points,
                            const struct vor_run *run, struct vor_error *err)
{
    struct winding winding;
    vor_status status = begin(&winding, span, points, run, err);

    for (unsigned k = 0; k < span->joins && status == VOR_OK; k++)
        status = judge(&winding, &span->join[k], run, err);
    end(&winding, run);
    return status;
}

vor_status vor_winding_mean(double *out, struct vor_span *span,
                            const struct vor_winding_points *points, const struct vor_run *run,
                            struct vor_error *err)
{
    struct winding winding;
    size_t samples = span->n < 2 * SAMPLES ? span->n : 2 * SAMPLES;
    double mean = 0;
    vor_status status = begin(&winding, span, points, run, err);

    if (status == VOR_OK) {
        memset(winding.side, REST, span->n);
        for (size_t k = 0; k < samples; k++)
            winding.at[k] = (uint32_t)(k * span->n / samples);
        status = vor_run_for(run, winding.blocks, TASK, make_blocks, &winding, err);
    }
    if (status == VOR_OK)
        status = vor_run_for(run, samples, 1, take_number, &winding, err);
    for (size_t k = 0; k < samples && status == VOR_OK; k++)
        mean += winding.number[k][0] / (double)samples;
    end(&winding, run);
    if (status == VOR_OK)
        *out = mean;
    return status;
}
