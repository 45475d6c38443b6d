#include "core/seeds/aspects.h"

#include "core/base/stat.h"
#include "core/geom/integrate.h"

struct measure {
    struct vor_seeds *seeds;
    float *aspect, *off; /* n each */
};

/* Adds the second moments of a triangle in the plane about the origin: of a triangle with corners
 * a, b, c and their sum s, area / 12 times (a a' + b b' + c c' + s s'). */
static void add_triangle(double second[3], const double *const corner[3])
{
    const double *a = corner[0], *b = corner[1], *c = corner[2];
    double s[2] = {a[0] + b[0] + c[0], a[1] + b[1] + c[1]};
    double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;

    second[0] += area / 12 * (a[0] * a[0] + b[0] * b[0] + c[0] * c[0] + s[0] * s[0]);
    second[1] += area / 12 * (a[0] * a[1] + b[0] * b[1] + c[0] * c[1] + s[0] * s[1]);
    second[2] += area / 12 * (a[1] * a[1] + b[1] * b[1] + c[1] * c[1] + s[1] * s[1]);
}

/* Aspect of a cell in the tangent plane; 0 for one without area. */
static double aspect_of(const struct vor_cell *cell)
{
    struct vor_moments moments;
    double second[3] = {0, 0, 0}, mean, half, apart, x, y;

    if (!vor_cell_moments(&moments, cell))
        return 0;
    for (unsigned i = 0; i < cell->count; i++) {
        const struct vor_polygon *piece = &cell->piece[i];

        for (unsigned j = 2; j < piece->count; j++)
            add_triangle(second, (const double *const[3]){piece->vertex[0], piece->vertex[j - 1],
                                                          piece->vertex[j]});
    }
    x = moments.centroid[0] - cell->seed[0];
    y = moments.centroid[1] - cell->seed[1];
    second[0] -= moments.area * x * x;
    second[1] -= moments.area * x * y;
    second[2] -= moments.area * y * y;
    mean = (second[0] + second[2]) / 2;
    half = (second[0] - second[2]) / 2;
    apart = sqrt(half * half + second[1] * second[1]);
    return mean > apart ? sqrt((mean + apart) / (mean - apart)) : 0;
}

static void measure_row(void *ctx, size_t i, unsigned worker)
{
    const struct measure *measure = ctx;
    struct vor_seeds *seeds = measure->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    double wanted = (double)seeds->stretched.near[i].aspect, aspect = 0;

    if (vor_seeds_fit(seeds, scratch, i) != VOR_SURFACE_NONE) {
        vor_seeds_crowd(seeds, scratch, i);
        vor_seeds_clip(seeds, scratch, i, 1);
        aspect = aspect_of(&scratch->cell);
    }
    measure->aspect[i] = (float)aspect;
    measure->off[i] = (float)fabs(aspect / wanted - 1);
}

vor_status vor_seeds_aspects(struct vor_aspects *out, struct vor_seeds *seeds,
                             struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct measure measure = {seeds, vor_malloc(memory, seeds->n, sizeof *measure.aspect),
                              vor_malloc(memory, seeds->n, sizeof *measure.off)};
    vor_status status;

    if (measure.aspect == NULL || measure.off == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    else
        status = vor_seeds_index(seeds, &seeds->run, err);
    VOR_THEN(status,
             vor_run_rows(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, measure_row, &measure, err));
    if (status == VOR_OK) {
        vor_sort_floats(measure.aspect, seeds->n);
        vor_sort_floats(measure.off, seeds->n);
        out->median = vor_quantile(measure.aspect, seeds->n, 0.5);
        out->off_median = vor_quantile(measure.off, seeds->n, 0.5);
        out->off_high = vor_quantile(measure.off, seeds->n, 0.9);
    }
    VOR_FREE_ALL(memory, measure.off, measure.aspect);
    return status;
}
