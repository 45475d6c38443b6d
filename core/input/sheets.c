#include "core/input/sheets.h"

#include "core/geom/layers.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
    BLOCK = 4,    /* places of one task */
    PLACES = 128, /* places of the input that are searched for layers */
    /* Points around a place. At 25 / 50 / 100 shell (geom/layers.c) is 7.3e-4 / 7.4e-4 / 12.4e-4:
     * 100 points of it bend too much. */
    AROUND = 50,
    /* Places with layers that make an input one with sheets. Measured: inputs with two sheets have
     * 118 to 128, others at most 8, a scan of an office with its walls twice 36. At 1 / 48 /
     * 96: shell 7.4e-4 / 7.4e-4 / 12.4e-4 (it has fewer than 96), CPU of fandisk 7.5 / 0.6 / 0.6 s,
     * of autzen 25 / 1.4 / 1.4 s. */
    LEAST = 48
};

/* Least and most points that are searched for layers around a seed. At 38 / 75 / 150: shell 5.7e-4
 * / 7.4e-4 / 8.5e-4, but at 38 the squares get 150 neighbours, as noise would. */
enum { WIDE_LEAST = 75, WIDE_MAX = VOR_NEIGHBORS_MAX };

/* Times the neighbours of a fit that are searched for layers: enough for a fit to each of two
 * sheets. At 1.5 / 2.25 / 4: shell 7.3e-4 / 7.4e-4 / 6.8e-4, but at 4 the squares get 150
 * neighbours. */
#define WIDE 2.25

/* Attempts, in order, until one finds layers: among that share of the nearest points, of which
 * every stride-th is taken so that about so many are left. The first has enough points of each of
 * two sheets for a fit of its own. With one / two / all five: shell 8.6e-4 / 8.6e-4 / 7.4e-4,
 * points off both squares 6 / 0 / 0. */
static const struct {
    double share;
    unsigned points;
} attempts[] = {{0.67, 50}, {1, 75}, {0.46, 34}, {0.83, 62}, {0.56, 42}};
enum { ATTEMPTS = sizeof attempts / sizeof *attempts };

static unsigned least(unsigned a, size_t b)
{
    return a < b ? a : (unsigned)b;
}

/* Looks for layers among the first k points, of which it takes about `points` at equal steps. */
static void find_layers(struct vor_layers *out, const float *near, unsigned k, unsigned points)
{
    float some[3 * VOR_NEIGHBORS_MAX];
    unsigned stride = (k + points - 1) / points, count = (k + stride - 1) / stride;

    for (unsigned j = 0; j < count; j++)
        memcpy(&some[3 * j], &near[3 * j * stride], 3 * sizeof *some);
    vor_layers_find(out, some, count);
}

static void copy(float *near, const struct vor_domain *domain, const uint32_t *index, unsigned k)
{
    for (unsigned j = 0; j < k; j++)
        memcpy(&near[3 * j], &domain->xyz[3 * (size_t)index[j]], 3 * sizeof *near);
}

/* The k nearest points of x, nearest first. */
static void search(float *near, const struct vor_domain *domain, const float x[3], unsigned k)
{
    float distance2[VOR_NEIGHBORS_MAX];
    uint32_t index[VOR_NEIGHBORS_MAX];

    vor_knn_search(domain->knn, x, 1, k, index, distance2);
    copy(near, domain, index, k);
}

unsigned vor_sheets_list(uint32_t *list, const struct vor_domain *domain, const double x[3],
                         unsigned k)
{
    float query[3] = {(float)x[0], (float)x[1], (float)x[2]}, wide[3 * VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX];
    uint32_t index[VOR_NEIGHBORS_MAX];
    unsigned want = (unsigned)fmax(WIDE * k, WIDE_LEAST), taken = 0, own;
    unsigned most = least(want < WIDE_MAX ? want : WIDE_MAX, domain->n);
    struct vor_layers layers = {.count = 1};

    memset(wide, 0, sizeof wide); /* clang-analyzer cannot see that most >= 1 */
    vor_knn_search(domain->knn, query, 1, most, index, distance2);
    copy(wide, domain, index, most);
    for (unsigned i = 0; i < ATTEMPTS && layers.count == 1; i++)
        find_layers(&layers, wide, (unsigned)(attempts[i].share * most), attempts[i].points);
    if (layers.count == 1)
        return 0;
    own = vor_layers_nearest(&layers, x);
    for (unsigned j = 0; j < most && taken < k; j++) {
        double at[3] = {(double)wide[3 * j], (double)wide[3 * j + 1], (double)wide[3 * j + 2]};

        if (vor_layers_nearest(&layers, at) == own)
            list[taken++] = index[j];
    }
    return taken;
}

int vor_sheets_gather(float *near, const struct vor_domain *domain, const double x[3], unsigned k)
{
    uint32_t list[VOR_NEIGHBORS_MAX];
    unsigned n = vor_sheets_list(list, domain, x, k);

    if (n == 0)
        return 0;
    copy(near, domain, list, n);
    for (unsigned j = n; j < k; j++)
        memcpy(&near[3 * j], &near[3 * (j - n)], 3 * sizeof *near);
    return 1;
}

int vor_sheets_fit(struct vor_surface *out, float *near, const struct vor_domain *domain,
                   const double x[3], unsigned k)
{
    vor_surface_fit(out, near, k);
    if (!domain->known.sheets || !vor_layers_possible(out) ||
        !vor_sheets_gather(near, domain, x, k))
        return 0;
    vor_surface_fit(out, near, k);
    return 1;
}

struct survey {
    const struct vor_domain *domain;
    atomic_uint layered;
};

static void survey_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct survey *survey = ctx;
    const struct vor_domain *domain = survey->domain;
    unsigned k = least(AROUND, domain->n);
    float near[3 * AROUND];
    struct vor_surface surface;
    struct vor_layers layers;

    (void)worker;
    for (size_t place = begin; place < end; place++) {
        size_t at = (size_t)(((double)place + 0.5) / PLACES * (double)domain->n);

        search(near, domain, &domain->xyz[3 * at], k);
        vor_surface_fit(&surface, near, k);
        if (!vor_layers_possible(&surface))
            continue;
        vor_layers_find(&layers, near, k);
        if (layers.count > 1)
            atomic_fetch_add(&survey->layered, 1);
    }
}

vor_status vor_sheets_find(int *out, const struct vor_domain *domain, const struct vor_run *run,
                           struct vor_error *err)
{
    struct survey survey = {.domain = domain};
    vor_status status = vor_run_for(run, PLACES, BLOCK, survey_block, &survey, err);

    *out = status == VOR_OK && atomic_load(&survey.layered) >= LEAST;
    return status;
}
