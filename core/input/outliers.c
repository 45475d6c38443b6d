#include "core/input/outliers.h"

#include <stdatomic.h>
#include <string.h>

/* Figures are of igea, 12,000 points of white noise and 60 in its box at random, denoised to 3,000:
 * rms distance to the true surface in 1e-4 of its diagonal (spread 0.1), and points dropped. Some
 * of the 60 lie near the surface. */
enum {
    /* Nearest points that a point points to. At 10 / 20 / 40: rms 5.9 / 5.4 / 5.8, dropped 554 / 41
     * / 35. */
    NEIGHBORS = 20,
    /* A point that fewer others point to is an outlier. At 3 / 6 / 12: rms 5.2 / 5.4 / 5.1, dropped
     * 40 / 41 / 130; a point at a border has about 10. */
    POINTED = 6,
    /* Most searches. Here the first finds all; two outliers side by side need another. */
    LOOKS = 3,
    /* Fewer points have no outliers: 20 neighbours are then a tenth of all. */
    LEAST = 200,
    /* If more than one point in so many would go, none does. At 2 and 8 nothing changes here. */
    QUARTER = 4,
    BLOCK = 4096, /* points of one task */
    BATCH = 64    /* points of one call of the index */
};

/* One search of all points. */
struct look {
    const struct vor_domain *domain;
    _Atomic uint32_t *pointed; /* how many points have this one among their nearest */
};

static void point_batch(const struct look *look, size_t begin, size_t count)
{
    uint32_t index[BATCH * (NEIGHBORS + 1)];
    float distance2[BATCH * (NEIGHBORS + 1)];

    vor_knn_search(look->domain->knn, &look->domain->xyz[3 * begin], count, NEIGHBORS + 1, index,
                   distance2);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j <= NEIGHBORS; j++) {
            uint32_t other = index[i * (NEIGHBORS + 1) + j];

            if (other != begin + i)
                atomic_fetch_add_explicit(&look->pointed[other], 1, memory_order_relaxed);
        }
}

static void point_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    for (size_t i = begin; i < end; i += BATCH)
        point_batch(ctx, i, end - i < BATCH ? end - i : BATCH);
}

static size_t count_lonely(const struct look *look)
{
    size_t lonely = 0;

    for (size_t i = 0; i < look->domain->n; i++)
        lonely += atomic_load_explicit(&look->pointed[i], memory_order_relaxed) < POINTED;
    return lonely;
}

static void remove_lonely(struct vor_domain *domain, const struct look *look)
{
    size_t kept = 0;

    for (size_t i = 0; i < domain->n; i++) {
        if (atomic_load_explicit(&look->pointed[i], memory_order_relaxed) < POINTED)
            continue;
        memmove(&domain->xyz[3 * kept], &domain->xyz[3 * i], 3 * sizeof *domain->xyz);
        domain->source[kept++] = domain->source[i];
    }
    domain->n = kept;
}

/* Searches once; *lonely is the number of points it dropped. */
static vor_status drop(struct vor_domain *domain, size_t *lonely, const struct vor_run *run,
                       struct vor_error *err)
{
    struct look look = {.domain = domain};
    vor_status status;

    *lonely = 0;
    if (domain->n < LEAST)
        return VOR_OK;
    look.pointed = vor_calloc(run->memory, domain->n, sizeof *look.pointed);
    if (look.pointed == NULL)
        return vor_fail(err, VOR_E_NOMEM, "looking for outliers among %zu points", domain->n);
    status = vor_run_for(run, domain->n, BLOCK, point_block, &look, err);
    if (status == VOR_OK)
        *lonely = count_lonely(&look);
    if (*lonely > domain->n / QUARTER)
        *lonely = 0;
    if (*lonely > 0)
        remove_lonely(domain, &look);
    vor_free(run->memory, look.pointed);
    if (*lonely == 0)
        return status;
    vor_knn_free(domain->knn);
    domain->knn = NULL;
    return vor_knn_build_sorted(&domain->knn, domain->xyz, domain->n, run, err);
}

vor_status vor_outliers_drop(struct vor_domain *domain, size_t *dropped, const struct vor_run *run,
                             struct vor_error *err)
{
    vor_status status = VOR_OK;
    size_t lonely = 1;

    *dropped = 0;
    for (int look = 0; look < LOOKS && status == VOR_OK && lonely > 0; look++) {
        status = drop(domain, &lonely, run, err);
        *dropped += lonely;
    }
    return status;
}
