/** The seeds, their neighbours among themselves, and what every method computes for one of them:
 * local surface, patch, restricted Voronoi cell. */
#ifndef VOR_METHOD_SEEDS_H
#define VOR_METHOD_SEEDS_H

#include "core/base/run.h"
#include "core/geom/boundary.h"
#include "core/geom/cell.h"
#include "core/geom/surface.h"
#include "core/knn/near.h"
#include "core/method/domain.h"

#define VOR_SEEDS_BLOCK 256    /* seeds a task; also the unit of the sums */
#define VOR_SEEDS_LISTED 20    /* neighbours kept for each seed */
#define VOR_SEEDS_MORE_MAX 256 /* neighbours looked at when those do not secure a cell */

/** Input points around a place, nearest first, and the surface fitted to them. */
struct vor_place {
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;
};

/** Scratch of one worker. */
struct vor_bench {
    uint32_t *near_index; /**< VOR_SEEDS_BLOCK x k: input points near each seed of the block */
    uint32_t *seed_index; /**< VOR_SEEDS_BLOCK x (listed + 1) */
    float *seed_distance2;
    struct vor_place here, there; /**< of the seed at hand, and of where it wants to go */
    struct vor_place foot;        /**< of the input point nearest to one of these */
    struct vor_cell cell;
    double radius; /**< of the patch */
};

/** n points on the domain, in its normalised coordinates. */
struct vor_seeds {
    const struct vor_domain *domain;
    const struct vor_run *run;
    size_t n;
    unsigned k;      /**< input points a surface is fitted to */
    int keep_border; /**< cells end where the input ends; set by vor_seeds_init, may be changed */
    unsigned listed; /**< neighbours in a list: VOR_SEEDS_LISTED or n - 1 */
    float *xyz;      /**< n x 3 */
    uint32_t *list;  /**< n x listed, nearest first, without the seed itself */
    float *distance; /**< n x listed */
    struct vor_near near; /**< candidates among the input, for each seed */
    struct vor_knn *knn;  /**< over xyz as of the last index; NULL before */
    double widen; /**< patches are this many times as wide as usual; 1 after vor_seeds_init */
    double area;  /**< of the surface, from the draw that these seeds were started from */
    struct vor_disc disc, fine; /**< of patches, and of those that bend much */
    struct vor_bench *bench;    /**< one for each thread of the pool */
};

/** n seeds with unset positions; n >= 1; k as in the request, lowered to the size of the domain.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_seeds_init(struct vor_seeds *out, const struct vor_domain *domain,
                                        size_t n, unsigned k, const struct vor_run *run,
                                        struct vor_error *err);

void vor_seeds_free(struct vor_seeds *seeds);

/** Indexes the positions anew; they must not change while cells are computed.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_seeds_index(struct vor_seeds *seeds, struct vor_error *err);

/** Finds the input points near the seeds begin .. end - 1 (one block) and their lists. */
void vor_seeds_search(struct vor_seeds *seeds, struct vor_bench *bench, size_t begin, size_t end);

/** Gathers bench->here for row `row` of the searched block. */
enum vor_surface_kind vor_seeds_fit(const struct vor_seeds *seeds, struct vor_bench *bench,
                                    size_t row);

/** The same for seed i = begin + row, and its cell in bench->cell, unless the kind is NONE. */
enum vor_surface_kind vor_seeds_cell(const struct vor_seeds *seeds, struct vor_bench *bench,
                                     size_t i, size_t row);

/** The mesh for a patch of bench->radius on the surface of bench->here. */
const struct vor_disc *vor_seeds_disc(const struct vor_seeds *seeds, const struct vor_bench *bench);

/** Gathers a place around any x, by a search of its own. */
enum vor_surface_kind vor_seeds_fit_at(const struct vor_seeds *seeds, struct vor_place *place,
                                       const double x[3]);

/** What is known of the border around x, where bench->there was gathered. */
void vor_seeds_border(const struct vor_seeds *seeds, struct vor_bench *bench,
                      struct vor_border *border, const double x[3]);

/** Puts x onto a surface. */
void vor_seeds_project(const struct vor_surface *surface, double x[3]);

/** Position of seed i in double. */
static inline void vor_seeds_position(const struct vor_seeds *seeds, size_t i, double x[3])
{
    for (size_t c = 0; c < 3; c++)
        x[c] = (double)seeds->xyz[3 * i + c];
}

#endif
