#include "core/mesh/crowded.h"

#include "core/base/linalg.h"

#include <math.h>

/* Points with an edge to a point; a closed fan names each twice. */
enum { BESIDE = 2 * VOR_AROUND_MOST };

struct crowded {
    struct vor_sheet *sheet;
    const struct vor_complex *complex;
    const struct vor_balls *balls;
};

static unsigned list_beside(const struct vor_complex *complex, uint32_t i, uint32_t beside[BESIDE])
{
    unsigned count = 0;

    for (unsigned k = 0; k < complex->degree[i]; k++, count += 2)
        vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + k], i,
                           &beside[count]);
    return count;
}

/* Whether one or two edges lead from points beside one to point j. */
static int lead(const struct vor_complex *complex, const uint32_t *beside, unsigned count,
                uint32_t j)
{
    uint32_t other[BESIDE];
    unsigned others = list_beside(complex, j, other);

    for (unsigned b = 0; b < count; b++) {
        if (beside[b] == j)
            return 1;
        for (unsigned o = 0; o < others; o++)
            if (other[o] == beside[b])
                return 1;
    }
    return 0;
}

static int is_crowded(const struct crowded *crowded, uint32_t i)
{
    const struct vor_complex *complex = crowded->complex;
    const struct vor_balls *balls = crowded->balls;
    const float *xyz = crowded->sheet->seeds->xyz, *x = &xyz[3 * (size_t)i];
    uint32_t beside[BESIDE];
    unsigned count = list_beside(complex, i, beside);
    double edge = 0;

    for (unsigned b = 0; b < count; b++)
        edge += sqrt(vor_distance2f(x, &xyz[3 * (size_t)beside[b]])) / count;
    for (unsigned k = 0; k < balls->count[i]; k++) {
        uint32_t j = balls->list[(size_t)i * VOR_BALLS_FEW + k];

        if (j != i && complex->degree[j] > 0 &&
            vor_distance2f(x, &xyz[3 * (size_t)j]) < edge * edge &&
            !lead(complex, beside, count, j))
            return 1;
    }
    return 0;
}

static void find_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct crowded *crowded = ctx;

    crowded->sheet->crowded[i] = (unsigned char)is_crowded(crowded, (uint32_t)i);
}

vor_status vor_crowded_find(struct vor_sheet *sheet, const struct vor_complex *complex,
                            const struct vor_balls *balls, const struct vor_run *run,
                            struct vor_error *err)
{
    struct crowded crowded = {sheet, complex, balls};

    if (sheet->graph != NULL)
        return VOR_OK;
    if (sheet->crowded == NULL)
        sheet->crowded = vor_malloc(run->memory, complex->n, 1);
    return sheet->crowded == NULL
               ? vor_fail(err, VOR_E_NOMEM, "%zu points", complex->n)
               : vor_run_rows(run, complex->n, VOR_SEEDS_BLOCK, find_row, &crowded, err);
}
