#include "core/seeds/former.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

struct former {
    struct vor_seeds *seeds;
    struct vor_knn *knn; /* over the former points */
    const float *xyz;    /* these */
    float *normal;       /* n x 3: at the seed; then how far it goes */
    float *way;          /* n: along it to the former points */
    float *error2;       /* n: mean square of the fit's; 0: not known */
};

static void look_row(void *ctx, size_t i, unsigned worker)
{
    const struct former *former = ctx;
    struct vor_seeds *seeds = former->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    const struct vor_surface *surface = &scratch->here.surface;
    double x[3], local[3], normal[3], way = 0;
    float distance2;
    uint32_t nearest;

    if (vor_run_is_late(&seeds->run) || vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE)
        return;
    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(surface, x, local);
    vor_surface_normal(surface, local, normal);
    vor_knn_search(former->knn, &seeds->xyz[3 * i], 1, 1, &nearest, &distance2);
    for (size_t c = 0; c < 3; c++)
        way += ((double)former->xyz[3 * (size_t)nearest + c] - x[c]) * normal[c];
    vor_to_floats(&former->normal[3 * i], normal);
    former->way[i] = (float)way;
    former->error2[i] = 0; /* mean square error of the fit at its middle */
    if (surface->kind == VOR_SURFACE_QUADRIC && scratch->here.k > VOR_QUADRIC_TERMS)
        former->error2[i] = (float)(4 * surface->off2 / (scratch->here.k - VOR_QUADRIC_TERMS));
}

static void weigh_row(void *ctx, size_t i, unsigned worker)
{
    const struct former *former = ctx;
    struct vor_seeds *seeds = former->seeds;
    const struct vor_crowd *crowd = &seeds->scratch[worker].crowd;
    double way = (double)former->way[i], way2 = way * way, error2 = (double)former->error2[i];
    double sum = 1 / error2, share = 0;

    if (error2 > 0 && fabs(way) > 0) {
        vor_seeds_crowd(seeds, &seeds->scratch[worker], i);
        for (unsigned j = 0; j < crowd->count; j++) {
            double other = (double)former->way[crowd->index[j]];

            way2 += other * other;
            sum += 1 / (double)former->error2[crowd->index[j]];
        }
        way2 /= 1 + crowd->count;
        error2 = (1 + crowd->count) / sum;
        share = fmin(seeds->coherence * error2 / fmax(way2, error2), sqrt(error2) / fabs(way));
    }
    for (size_t c = 0; c < 3; c++)
        former->normal[3 * i + c] *= (float)(share * way);
}

static vor_status weigh(struct former *former, struct vor_error *err)
{
    struct vor_seeds *seeds = former->seeds;
    size_t moving = vor_seeds_moving(seeds);
    vor_status status = vor_seeds_index(seeds, &seeds->run, err);

    VOR_THEN(status, vor_run_rows(&seeds->run, moving, vor_seeds_block(seeds->domain), look_row,
                                  former, err));
    VOR_THEN(status, vor_run_rows(&seeds->run, moving, VOR_SEEDS_BLOCK, weigh_row, former, err));
    for (size_t j = 0; status == VOR_OK && j < 3 * moving; j++)
        seeds->xyz[j] += former->normal[j];
    return status;
}

vor_status vor_former_weigh(struct vor_seeds *seeds, struct vor_error *err)
{
    const struct vor_previous *previous = &seeds->whole->previous;
    struct vor_memory *memory = seeds->run.memory;
    struct former former = {.seeds = seeds};
    float *xyz;
    size_t m = 0;
    vor_status status;

    if (seeds->track == NULL || !(seeds->coherence > 0) || !vor_seeds_on_whole(seeds))
        return VOR_OK;
    former.xyz = xyz = vor_malloc(memory, previous->n, 3 * sizeof *xyz);
    former.normal = vor_calloc(memory, seeds->n, 3 * sizeof *former.normal);
    former.way = vor_calloc(memory, seeds->n, sizeof *former.way);
    former.error2 = vor_calloc(memory, seeds->n, sizeof *former.error2);
    if (xyz == NULL || former.normal == NULL || former.way == NULL || former.error2 == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n + previous->n);
    } else {
        for (size_t i = 0; i < previous->n; i++) { /* the domain lies within 1 of the middle */
            const float *x = &previous->xyz[3 * i];

            if (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < 4)
                memcpy(&xyz[3 * m++], x, 3 * sizeof *x);
        }
        status = m > 0 ? vor_knn_build_along(&former.knn, xyz, m, &seeds->run, err) : VOR_OK;
        if (status == VOR_OK && m > 0)
            status = weigh(&former, err);
    }
    vor_knn_free(former.knn);
    VOR_FREE_ALL(memory, former.error2, former.way, former.normal, xyz);
    return status;
}
