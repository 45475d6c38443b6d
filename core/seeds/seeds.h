/** The seeds, their neighbours among themselves, and what every method computes for a seed: local
 *  surface, patch, restricted Voronoi cell.
 *
 *  Functions that take a scratch may run on all threads of the pool, each with its own; only one
 *  thread at a time may ask about seed i, because that may renew its lists. They cannot fail. What
 *  they compute does not depend on the number of threads. */
#ifndef VOR_SEEDS_H
#define VOR_SEEDS_H

#include "core/base/linalg.h"
#include "core/base/run.h"
#include "core/geom/boundary.h"
#include "core/input/domain.h"
#include "core/knn/input_lists.h"
#include "core/knn/point_lists.h"
#include "core/seeds/scratch.h"
#include "core/seeds/stretched.h"
#include "core/seeds/wanted.h"
#include "core/spec.h"

/** Seeds of one task, and of one partial sum. */
#define VOR_SEEDS_BLOCK 256

/** Seeds of one task where each may ask whether it lies in a hole, and nothing is summed. A task
 *  that takes longer than 100 ms keeps who cancels the run waiting: with 500 of 1,000 points in a
 *  fit, the question takes 0.4 ms; with those of 60, 20 us. */
static inline size_t vor_seeds_block(const struct vor_domain *domain)
{
    const unsigned many = 60;

    return domain->known.neighbors.usual > many ? VOR_SEEDS_BLOCK / 16 : VOR_SEEDS_BLOCK;
}

/** Neighbours in the list of each seed. At 14 / 20 / 32: searches on igea 124 / 45 / 45 thousand,
 *  on autzen 280 / 198 / 151 thousand, for 4 bytes a neighbour and seed (3,000 seeds, default
 *  request). */
#define VOR_SEEDS_LISTED 20

/** Most neighbours searched when the list does not secure a cell: cells have about six sides. A
 *  cell that 256 do not secure is cut by those. */
#define VOR_SEEDS_MORE_MAX 256

/** Input spacings that a seed may move before its surface is fitted again. At 0.25 and 1 no figure
 *  of the polish (seeds/repel.c) moves beyond its spread. */
#define VOR_SEEDS_SLACK 0.5

/** Coherence of seeds that are even already, which says how hard the steps of the polish begin.
 * After a start from coarse to fine at 0.5 / 0.83 / 1, a sphere, three seeds: largest gap 0.735 /
 * 0.710 / 0.711 spacings, delta 0.0153 / 0.0152 / 0.0148, eta 0.0052 / 0.0058 / 0.0062. A body at
 * rest of 20,000 points with noise of 0.2 spacings at 0.83 / 0.9 / 1: a point moves by 0.081 /
 * 0.077 / 0.073 spacings from frame to frame, delta 0.0138 / 0.0138 / 0.0147; single runs have
 * 0.0142. */
#define VOR_SEEDS_COHERENT 0.83

/** A seed's last fit. */
struct vor_last_fit {
    struct vor_surface surface;
    float place[3];             /**< where the seed was */
    uint16_t k;                 /**< points that it was or will be fitted to; 0: not known yet */
    uint32_t root;              /**< input point whose list it is to, or VOR_LISTS_NO_ROOT */
    unsigned char interior : 1; /**< no border of the input is near that place */
    unsigned char inside : 1;   /**< the input surrounds that place, if not by near points */
    unsigned char layered : 1;  /**< fitted to one of several sheets */
    unsigned char narrow : 1;   /**< its list of input points has only those of its sheet */
    unsigned char refined : 1;  /**< a finer fit was tried */
};

/** When points of a result are kept near the input. */
enum vor_near {
    VOR_NEAR_NEVER,
    VOR_NEAR_IN_STEPS, /**< while they move, and not once more in the end */
    VOR_NEAR_ALWAYS
};

/** How cells are made, the same for all seeds; chosen once. Whatever the policy, what is known of
 *  the input (its neighbours of a fit, sheets, lists, filters) and the area that spacing is turned
 *  into points with are found with quadrics. */
struct vor_seeds_policy {
    int keep_border; /**< cells end where the input ends, and points stay inside it */
    double widen;    /**< patches are this many times as wide as usual */
    int planes;      /**< fits are planes, and patches octagons; else quadrics and hexagons */
    int still;       /**< the seeds are where they stay, but for a few (knn/input_lists.h) */
    enum vor_near near_input; /**< when points do not stray from the input (vor_attach_near) */
};

struct vor_kept_foot;

/** n points on the domain, in its normalised coordinates. */
struct vor_seeds {
    const struct vor_domain *domain; /**< surfaces are fitted to it: the whole, or a thinned one */
    const struct vor_domain *whole;  /**< the domain that the seeds end on */
    struct vor_run run; /**< not interrupted by a stop; loops that a stop may end get their own */
    size_t n;
    size_t fixed; /**< the last ones of these, which do not move (seeds/fixed.h) */
    size_t half;  /**< of those, on borders: they have half a cell */
    struct vor_seeds_policy policy;
    int sheets;                 /**< a domain that they are or were made on has sheets */
    struct vor_sheeted sheeted; /**< where fits look for layers: that of the domain with most */
    float *xyz;                 /**< n x 3 */
    float *normal;   /**< n x 3: unit vectors outward, or 0 where there is none, if the method finds
                          normals; else NULL */
    uint32_t *track; /**< n: which points of a sequence they are, if there is an earlier result;
                        else NULL */
    uint32_t unused; /**< then the next number for a point that is born */
    double coherence; /**< VOR_SEEDS_COHERENT times coherence of the request times the share that
                           lives on of the seeds or of the points before, whichever are more, and
                           less where the surface moved
                           (seeds/warm_start.c); VOR_SEEDS_COHERENT after a start from coarse to
                           fine (seeds/coarse.h); 0 else */
    struct vor_input_lists input_lists; /**< candidates among the input, for each seed */
    struct vor_last_fit *last_fit;      /**< n */
    _Atomic unsigned char *way; /**< of each point of the domain: vor_sheets_way there; 0: not known
                                   yet. NULL if seeds are not fewer, or no fit looks for layers */
    _Atomic double *foot; /**< of each point of the domain: spacing of the surface there, negative
                             where its points are irregular; 0: not known yet. NULL if points may
                             leave the input */
    struct vor_point_lists point_lists; /**< neighbours among the seeds */
    struct vor_point_lists_view view;   /**< of xyz, as of the last index */
    struct vor_wanted wanted;           /**< spacing of each seed, where there is a density */
    struct vor_stretched stretched;     /**< metric at each seed, where there is one */
    uint64_t indexed_before; /**< times that lists were made anew before points were added */
    double area; /**< of the surface in squared normalised units, as the start estimated it */
    struct vor_disc flat, disc;  /**< patches, of flat surfaces and of bent ones */
    struct vor_scratch *scratch; /**< one for each thread of the pool */
    struct vor_kept_foot *kept; /**< what vor_attach_near finds (attach.c); NULL: nothing is kept */
};

/** Makes n >= 1 seeds with unset positions. A fit takes as many points as domain->known says, at
 *  most all of the domain. The domain and run's watches must outlive the seeds.
 *
 *  @param[out] out  free with vor_seeds_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM  O(n k) bytes do not fit */
VOR_NODISCARD vor_status vor_seeds_init(struct vor_seeds *out, const struct vor_domain *domain,
                                        size_t n, struct vor_seeds_policy policy,
                                        const struct vor_run *run, struct vor_error *err);

/** The policy of a request: keep_border unless `boundary` is free, planes as `patch` does, patches
 * of the usual width. */
static inline struct vor_seeds_policy vor_seeds_policy_of(const struct vor_spec *spec)
{
    return (struct vor_seeds_policy){
        .keep_border = spec->value[VOR_PARAM_BOUNDARY] != VOR_BOUNDARY_FREE,
        .widen = 1,
        .planes = spec->value[VOR_PARAM_PATCH] == VOR_PATCH_PLANE,
        .near_input =
            vor_process_takes(spec->process, VOR_PARAM_SOUP) ? VOR_NEAR_NEVER : VOR_NEAR_ALWAYS};
}

/** seeds may be all zero. */
void vor_seeds_free(struct vor_seeds *seeds);

/** Forgets the lists of input points and the last fits. O(n). */
void vor_seeds_forget_input(struct vor_seeds *seeds);

/** Fits surfaces to another domain from now on: the whole one, or a thinned one of at least
 *  seeds->input_lists.wide points. Forgets what vor_seeds_forget_input does; the seeds' lists of
 *  each other stay. Where a thinned domain has sheets, fits to the whole look for layers
 *  too, because at the border their neighbours extend farther. O(n + the domain's points).
 *
 *  @retval VOR_E_NOMEM  free the seeds */
VOR_NODISCARD vor_status vor_seeds_onto(struct vor_seeds *seeds, const struct vor_domain *domain,
                                        struct vor_error *err);

/** Takes the seeds' present positions as those that the following calls ask about, makes their
 *  lists of each other anew if too many have moved too far for the old ones, and takes the spacings
 *  wanted and the metric there. Positions must not change while cells are computed.
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n), O(n log n) when the lists are made anew. */
VOR_NODISCARD vor_status vor_seeds_index(struct vor_seeds *seeds, const struct vor_run *run,
                                         struct vor_error *err);

/** How many input points a surface at x is fitted to. */
unsigned vor_seeds_asked(const struct vor_seeds *seeds, const float x[3]);

/** Gathers the input points around seed i in scratch->here and fits its surface, unless these
 *  points gave it before. Returns its kind. O(k), O(k log n) when a list is made anew. */
enum vor_surface_kind vor_seeds_fit(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i);

/** The input point nearest to seed i, which vor_seeds_fit was called for where it is now, on
 *  whichever sheet. O(1); O(log n) where the seed has a sheet of several. */
uint32_t vor_seeds_nearest(const struct vor_seeds *seeds, size_t i);

/** When a last fit may be used again. */
struct vor_recall {
    double slack;   /**< input spacings that a seed may move from its last fit */
    int keep_holes; /**< holes are kept open (vor_attach) */
    int refine;     /**< vor_seeds_refine is tried */
    int lazy;       /**< it also is where the input surrounded the seed, if not by near points */
};

/** The last fit of seed i, refined if that was asked for, if it may be used again; else NULL. */
static inline const struct vor_surface *vor_seeds_last(const struct vor_seeds *seeds, size_t i,
                                                       const struct vor_recall *how)
{
    const struct vor_last_fit *last = &seeds->last_fit[i];
    double most = how->slack * last->surface.spacing;

    return (last->interior || (last->inside && how->lazy)) && (last->refined || !how->refine) &&
                   vor_distance2f(&seeds->xyz[3 * i], last->place) <= most * most
               ? &last->surface
               : NULL;
}

/** vor_seeds_fit, or the last fit if that found the seed inside the input with no border near it
 *  (or how->lazy) and the seed has moved by at most how->slack since. Where the input is irregular
 *  and holes are kept, a side that the nearest points leave empty by chance is no border, nor are
 *  holes (recall.c). Sets scratch->interior: then only scratch->here.surface is valid,
 *  scratch->here.near is not. scratch->onto is the surface to move along, refined if how->refine
 *  asks for it. */
enum vor_surface_kind vor_seeds_recall(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                       size_t i, const struct vor_recall *how);

/** vor_surface_refine of *surface, a copy of that of scratch->here around seed i, if k allows it.
 *  A plane is not refined: what it is off shows the curvature, not an edge. Returns whether the
 *  surface was replaced. */
int vor_seeds_refine(const struct vor_seeds *seeds, const struct vor_scratch *scratch, size_t i,
                     struct vor_surface *surface);

/** Makes lists for the calls that follow, of seeds near each other together: as the searches that
 *  they spare, in a third of the time. What is computed is the same, unless input points are
 *  equally far. vor_seeds_input_ahead is for vor_seeds_fit of seeds `begin` to before `end`, those
 *  never fitted before; vor_seeds_crowd_ahead for vor_seeds_crowd of `count` seeds. */
void vor_seeds_input_ahead(struct vor_seeds *seeds, size_t begin, size_t end);
void vor_seeds_crowd_ahead(struct vor_seeds *seeds, struct vor_scratch *scratch,
                           const uint32_t *who, size_t count);

/** Gathers the seeds around seed i in scratch->crowd, as of the last index
 *  (vor_point_lists_crowd). */
void vor_seeds_crowd(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i);

/** The same for seeds within `distance` (normalised; with a metric, in that), in no order
 *  (vor_point_lists_within). */
void vor_seeds_within(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                      double distance);

/** Makes the cell of seed i in scratch->cell, from scratch->here and scratch->crowd: at once, or by
 *  clipping a patch of the surface, or if `flat` of the tangent plane. With a metric, in that of
 * the seed: scratch->crowd then has the seeds that are nearest in it and their distances there,
 * scratch->stretch is what takes the cell's corners to them. */
void vor_seeds_clip(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i, int flat);

/** vor_seeds_fit, and unless its kind is NONE vor_seeds_crowd and vor_seeds_clip. */
enum vor_surface_kind vor_seeds_cell(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                     size_t i);

/** Gathers the input points around any place x in scratch->there or scratch->foot by a search, and
 *  fits a surface. Returns its kind. O(k log n). */
enum vor_surface_kind vor_seeds_fit_at(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                                       struct vor_place *place, const double x[3]);

/** Whether the input surrounds x, which is near the place that scratch->here was gathered around.
 *  O(k). */
int vor_seeds_surrounded(const struct vor_scratch *scratch, const double x[3]);

/** A tangential offset of about `length` by which seed i sees a coincident seed j, so that the two
 *  move apart: opposite for (j, i). Depends on i and j alone. */
void vor_seeds_part(size_t i, size_t j, double length, double offset[2]);

/** Sums of the counters over the workers. O(threads). */
struct vor_counts vor_seeds_counts(const struct vor_seeds *seeds);

/** Fills *border for x from scratch->here or scratch->there (`place`), which was gathered around x.
 *  Searches once (scratch->foot) when x is farther than a spacing from the input. */
void vor_seeds_border(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                      const struct vor_place *place, struct vor_border *border, const double x[3]);

/** HOLE in geom/boundary.h. If x lies too far into a hole of a regular input, or beyond its edge,
 *  moves it towards the nearest input points (vor_boundary_pull). scratch->here was gathered around
 *  seed i, and x is near it. Returns whether x was moved. */
int vor_seeds_hold(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                   double x[3]);

/** How many seeds move: the first ones. */
static inline size_t vor_seeds_moving(const struct vor_seeds *seeds)
{
    return seeds->n - seeds->fixed;
}

/** Whether surfaces are fitted to the whole domain. */
static inline int vor_seeds_on_whole(const struct vor_seeds *seeds)
{
    return seeds->domain == seeds->whole;
}

/** Position of seed i in double. */
static inline void vor_seeds_position(const struct vor_seeds *seeds, size_t i, double x[3])
{
    for (size_t c = 0; c < 3; c++)
        x[c] = (double)seeds->xyz[3 * i + c];
}

#endif
