#include "core/input/coarsen.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/plane.h"
#include "core/input/neighbors.h"
#include "core/input/outliers.h"

#include <math.h>
#include <string.h>

enum {
    PLACES = VOR_NEIGHBORS_PLACES, /* at equal steps along the order: is there a surface? */
    MOST = VOR_LADDER_LAST,        /* neighbours that planes are put through */
    /* Points that are left at least. */
    LEAST = VOR_NEIGHBORS_ROOM * MOST
};

/* Variance across a plane over that in all, above which its points show no surface; a ball of them
 * has 0.33. The least median of any number is 0.185 of the fandisk of coarsen.h, and 0.166, 0.119,
 * 0.089 and 0.085 after one to four times; 0.063 of fandisk with noise of 0.5 %, 0.052 of igea of
 * 655,000 points with noise of 1 %, 0.04 of kitti. */
#define THICK 0.1

static const unsigned ladder[VOR_LADDER_STEPS] = VOR_LADDER;

/* The median flatness of planes through k neighbours. */
static double flatness_of(const struct vor_domain *domain, unsigned k)
{
    double flatness[PLACES];

    for (size_t place = 0; place < PLACES; place++) {
        size_t at = (size_t)(((double)place + 0.5) / PLACES * (double)domain->n);
        uint32_t index[MOST];
        float distance2[MOST];
        struct vor_plane plane;

        vor_knn_search(domain->knn, &domain->xyz[3 * at], 1, k, index, distance2);
        vor_plane_fit(&plane, domain->xyz, index, k);
        flatness[place] = (double)plane.flatness;
    }
    vor_sort_doubles(flatness, PLACES);
    return flatness[PLACES / 2];
}

/* Whether no number of neighbours shows a surface. Where the nearest few do, what is thick is a
 * thin part: 0.05 of a vase whose walls are 2.6 spacings apart, 0.1 and more at any other number;
 * with noise of 1.5 spacings and more they have 0.13. */
static int is_thick(const struct vor_domain *domain)
{
    if (flatness_of(domain, VOR_NEIGHBORS_EXACT) <= THICK)
        return 0;
    for (unsigned step = 0; step < VOR_LADDER_STEPS; step++)
        if (flatness_of(domain, ladder[step]) <= THICK)
            return 0;
    return 1;
}

/* Takes every second point. Noise that asks for that hides sheets from one another. */
static vor_status take(struct vor_domain *out, const struct vor_domain *in,
                       const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain domain = {
        .memory = run->memory, .n = in->n / 2, .unit = in->unit, .known = in->known};
    vor_status status;

    memcpy(domain.shift, in->shift, sizeof domain.shift);
    if (VOR_MAKE_ALL(run->memory, err, in->n, VOR_ARRAY(domain.xyz, domain.n, 3),
                     VOR_ARRAY(domain.source, domain.n, 1)) != VOR_OK) {
        vor_domain_free(&domain);
        return VOR_E_NOMEM;
    }
    for (size_t i = 0; i < domain.n; i++) {
        memcpy(&domain.xyz[3 * i], &in->xyz[6 * i], 3 * sizeof *domain.xyz);
        domain.source[i] = in->source[2 * i];
    }
    domain.known.sheets = domain.known.seek_sheets = domain.known.parted = 0;
    domain.known.sheeted.count = 0;
    domain.known.lists = VOR_LISTS_NONE;
    status = vor_domain_index(&domain, run, err);
    if (status == VOR_OK)
        *out = domain;
    else
        vor_domain_free(&domain);
    return status;
}

vor_status vor_domain_halve(struct vor_domain *out, const struct vor_domain *in,
                            const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain domain = {.n = 0};
    vor_status status = VOR_OK;

    if (in->n / 2 < LEAST)
        return VOR_OK;
    status = take(&domain, in, run, err);
    VOR_THEN(status, vor_neighbors_choose(&domain.known.neighbors, &domain, run, err));
    if (status == VOR_OK)
        *out = domain;
    else
        vor_domain_free(&domain);
    return status;
}

vor_status vor_domain_coarsen(struct vor_domain *out, const struct vor_domain *in,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain domain = {.n = 0}, fewer;
    const struct vor_domain *now = in;
    size_t dropped;
    vor_status status = VOR_OK;

    while (status == VOR_OK && now->n / 2 >= LEAST && is_thick(now)) {
        status = take(&fewer, now, run, err);
        if (status != VOR_OK)
            break;
        vor_domain_free(&domain);
        domain = fewer;
        now = &domain;
    }
    if (status == VOR_OK && domain.n > 0 && !is_thick(&domain)) {
        status = vor_outliers_drop(&domain, &dropped, run, err);
        VOR_THEN(status, vor_neighbors_choose(&domain.known.neighbors, &domain, run, err));
    } else {
        vor_domain_free(&domain); /* of a ball of points */
    }
    if (status == VOR_OK)
        *out = domain;
    else
        vor_domain_free(&domain);
    return status;
}
