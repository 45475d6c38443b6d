#include "core/method/scale.h"

#include "core/geom/surface.h"
#include "core/method/sheets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PLACES = 512, BLOCK = 16, STEPS = 6, FIRST = 2, MOST = 150, ROOM = 8 };

#define THICK_SHARE 0.97 /* of the places shall not be thick */
#define THICK 0.19       /* residual over reach: a thick neighbourhood */
#define HELPS 1.25       /* times the least, where no number is enough: more help little */
#define LEVERAGE 3.0     /* of a quadric's height at its middle, times the points it is fitted to */
#define FLUKE 1.1        /* residuals differ by so much without any detail being lost */

static const unsigned ladder[STEPS] = {20, 30, 45, 70, 100, MOST};

struct scale {
    const struct vor_domain *domain;
    unsigned steps, most;           /* of the ladder that the domain has points enough for */
    double residual[STEPS][PLACES]; /* variance about the surface */
    double thickness[STEPS][PLACES];
};

static void fit_place(struct scale *scale, size_t place)
{
    const struct vor_domain *domain = scale->domain;
    size_t at = (size_t)(((double)place + 0.5) / PLACES * (double)domain->n);
    const float *x = &domain->xyz[3 * at];
    float near[3 * MOST] = {0}, own[3 * MOST], distance2[MOST];
    uint32_t index[MOST];

    vor_knn_search(domain->knn, x, 1, scale->most, index, distance2);
    for (unsigned j = 0; j < scale->most; j++)
        memcpy(&near[3 * j], &domain->xyz[3 * (size_t)index[j]], 3 * sizeof *near);
    for (unsigned s = 0; s < scale->steps; s++) {
        struct vor_surface surface;
        double sum = 0;

        memcpy(own, near, 3 * ladder[s] * sizeof *own);
        (void)vor_sheets_fit(&surface, own, domain,
                             (double[3]){(double)x[0], (double)x[1], (double)x[2]}, ladder[s]);
        for (unsigned j = 0; surface.kind != VOR_SURFACE_NONE && j < ladder[s]; j++) {
            double y[3] = {(double)own[3 * j], (double)own[3 * j + 1], (double)own[3 * j + 2]};
            double local[3], off;

            vor_surface_to_local(&surface, y, local);
            off = local[2] - vor_surface_height(&surface, local[0], local[1], NULL);
            sum += off * off;
        }
        scale->residual[s][place] = sum / (ladder[s] - 6);
        scale->thickness[s][place] =
            surface.reach > 0 ? sqrt(scale->residual[s][place]) / surface.reach : 0;
    }
}

static void fit_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    for (size_t place = begin; place < end; place++)
        fit_place(ctx, place);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* The thickness that all but a few places stay below. */
static double thickness_of(struct scale *scale, unsigned step)
{
    qsort(scale->thickness[step], PLACES, sizeof(double), ascending);
    return scale->thickness[step][(size_t)(THICK_SHARE * PLACES)];
}

static double residual_of(const struct scale *scale, unsigned step)
{
    double sum = 0;

    for (size_t place = 0; place < PLACES; place++)
        sum += scale->residual[step][place];
    return sum / PLACES;
}

/* The first step at which neighbourhoods are wider than thick. */
static unsigned wide_step(struct scale *scale)
{
    double thickness[STEPS] = {0}, least = INFINITY;
    unsigned step = 0;

    for (unsigned s = 0; s < scale->steps; s++) {
        thickness[s] = thickness_of(scale, s);
        least = fmin(least, thickness[s]);
    }
    while (thickness[step] > (least > THICK ? HELPS * least : THICK))
        step++;
    /* A shape that is merely coarse: more neighbours lose more than noise would leave. */
    while (step > 0 && residual_of(scale, step) / ladder[step] > residual_of(scale, 0) / ladder[0])
        step--;
    return step;
}

/* From there on, the one with the least error. */
static unsigned best_step(const struct scale *scale, unsigned from)
{
    double noise = residual_of(scale, from), least = INFINITY;
    unsigned best = from;

    for (unsigned s = from; s < scale->steps; s++) {
        double error =
            LEVERAGE * noise / ladder[s] + fmax(0, residual_of(scale, s) - FLUKE * noise);

        if (error < least) {
            least = error;
            best = s;
        }
    }
    return best;
}

/* Fits to the first `steps` of the ladder and finds the best of them. */
static vor_status try_steps(struct scale *scale, unsigned steps, unsigned *best,
                            const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    scale->steps = steps;
    scale->most = ladder[steps - 1];
    status = vor_run_for(run, PLACES, BLOCK, fit_block, scale, err);
    if (status == VOR_OK)
        *best = best_step(scale, wide_step(scale));
    return status;
}

vor_status vor_scale_neighbors(unsigned *k, const struct vor_domain *domain,
                               const struct vor_run *run, struct vor_error *err)
{
    struct scale *scale = vor_calloc(run->memory, 1, sizeof *scale);
    unsigned steps = 0, best = 0;
    vor_status status = VOR_OK;

    if (scale == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the neighbours of %d places", (int)PLACES);
    scale->domain = domain;
    while (steps < STEPS && (size_t)ROOM * ladder[steps] <= domain->n)
        steps++;
    if (steps >= FIRST)
        status = try_steps(scale, FIRST, &best, run, err);
    /* Where the fewest do, and are no thicker than more of them, more need not be tried. */
    if (status == VOR_OK && steps > FIRST && (best > 0 || thickness_of(scale, 0) > THICK))
        status = try_steps(scale, steps, &best, run, err);
    *k = ladder[best];
    vor_free(run->memory, scale);
    return status;
}
