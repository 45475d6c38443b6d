#include "core/seeds/attach.h"

#include "core/base/linalg.h"
#include "core/geom/boundary.h"
#include "core/seeds/hurried.h"

#include <stdatomic.h>
#include <string.h>

struct attach {
    struct vor_seeds *seeds;
    int onto_whole;             /* the seeds change to the surface of the whole input */
    int keep_holes;             /* seeds in holes go back to the rim */
    int fast;                   /* the run has no time, or other means, for vor_attach_near */
    const unsigned char *stays; /* n, or NULL: these do not hang */
    atomic_size_t beyond;       /* seeds counted so far that are in a hole */
};

/* The run is late: moves seed i to where a result may be, without a fit. */
static void attach_hurried(const struct vor_seeds *seeds, size_t i)
{
    if (seeds->policy.keep_border)
        (void)vor_hurried_hold(&seeds->xyz[3 * i], seeds->domain,
                               VOR_OUTSIDE_IN_RESULT * seeds->domain->sparse);
}

/* Counts the seeds in holes, which vor_seeds_hold would move and are not beyond the end of the
 * input, without moving them. */
static void count_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct attach *attach = ctx;
    struct vor_seeds *seeds = attach->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    const struct vor_place *here = &scratch->here;
    size_t beyond = 0;
    double x[3];

    for (size_t i = begin; i < end && !vor_run_is_late(&seeds->run); i++) {
        vor_seeds_position(seeds, i, x);
        beyond += vor_seeds_fit(seeds, scratch, i) != VOR_SURFACE_NONE &&
                  !vor_boundary_beyond(&here->surface, here->near, here->k, x) &&
                  vor_seeds_hold(seeds, scratch, i, x);
    }
    atomic_fetch_add(&attach->beyond, beyond);
}

/* Whether seeds are kept near the input (vor_attach_near). With sheets, layers part them better;
 * those of k-means, which has no area, are means of input points. */
static int stay_near(const struct vor_seeds *seeds)
{
    return seeds->policy.near_input != VOR_NEAR_NEVER && !seeds->sheets &&
           seeds->n < seeds->domain->n && seeds->area > 0;
}

/* Input points around which each thread keeps what vor_attach_near finds there, as the same few are
 * asked for step after step. Millions of instructions from 1,000 points to 500, mean of a cow, a
 * torus knot, twigs and autzen, with none / 256 / 1,024 / 4,096: 1,969 / 1,787 / 1,756 / 1,744. And
 * points of the largest fit that is kept. */
enum { KEPT_SLOTS = 256, KEPT_SIZE = 100 };

/* What was found around an input point, which depends on that alone. */
struct vor_kept_foot {
    const struct vor_domain *domain; /* of the point; NULL: nothing */
    uint32_t foot[3];                /* its bits */
    unsigned k;
    struct vor_surface surface, plane;
    float near[]; /* room for as many as fits have, at most KEPT_SIZE */
};

/* Points that one has room for. */
static size_t kept_room(const struct vor_seeds *seeds)
{
    return seeds->input_lists.most < KEPT_SIZE ? seeds->input_lists.most : KEPT_SIZE;
}

/* Bytes of one. */
static size_t kept_size(const struct vor_seeds *seeds)
{
    size_t even = (kept_room(seeds) + 1) / 2 * 2;

    return sizeof(struct vor_kept_foot) + even * 3 * sizeof(float);
}

/* Where a point is kept, if it is, by the worker of the scratch. */
static struct vor_kept_foot *kept_at(const struct vor_seeds *seeds,
                                     const struct vor_scratch *scratch, const uint32_t foot[3])
{
    size_t first = (size_t)(scratch - seeds->scratch) * KEPT_SLOTS, hash = 0;

    for (int c = 0; c < 3; c++)
        hash = (hash ^ foot[c]) * UINT64_C(0x9E3779B97F4A7C15);
    return (void *)((char *)seeds->kept + (first + (hash >> 32) % KEPT_SLOTS) * kept_size(seeds));
}

/* vor_seeds_fit_at around an input point in scratch->foot, and the plane through the points nearest
 * to it, or what is kept of that. It counts as a search whether it is kept or not, so that their
 * number does not depend on the threads. */
static enum vor_surface_kind fit_foot(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                                      const double foot[3], struct vor_surface *plane)
{
    const float at[3] = {(float)foot[0], (float)foot[1], (float)foot[2]};
    struct vor_place *place = &scratch->foot;
    struct vor_kept_foot *kept;
    uint32_t bits[3];
    unsigned few;

    memcpy(bits, at, sizeof bits);
    kept = seeds->kept != NULL ? kept_at(seeds, scratch, bits) : NULL;
    if (kept != NULL && kept->domain == seeds->domain &&
        memcmp(kept->foot, bits, sizeof bits) == 0) {
        scratch->queries++;
        place->k = kept->k;
        place->surface = kept->surface;
        *plane = kept->plane;
        memcpy(place->near, kept->near, 3 * kept->k * sizeof *place->near);
        return place->surface.kind;
    }
    if (vor_seeds_fit_at(seeds, scratch, place, foot) == VOR_SURFACE_NONE)
        return VOR_SURFACE_NONE;
    few = place->k < VOR_NEIGHBORS_FEWEST / 2 ? place->k : VOR_NEIGHBORS_FEWEST / 2;
    vor_surface_fit_as(plane, place->near, few, VOR_SURFACE_PLANE);
    if (kept != NULL && place->k <= kept_room(seeds)) {
        kept->domain = seeds->domain;
        memcpy(kept->foot, bits, sizeof bits);
        kept->k = place->k;
        kept->surface = place->surface;
        kept->plane = *plane;
        memcpy(kept->near, place->near, 3 * place->k * sizeof *place->near);
    }
    return place->surface.kind;
}

/* How far from the input seeds may lie whatever it is like, if they are fewer than its points: half
 * their spacing. At .5 / .6 input spacings off the surface, scans of a saddle and a prism: .098,
 * .085 / .100, .095. */
static double least_allowed(const struct vor_seeds *seeds)
{
    return sqrt(seeds->area / (double)seeds->n) / 2;
}

double vor_attach_allowed(const struct vor_seeds *seeds)
{
    return stay_near(seeds) && seeds->policy.near_input == VOR_NEAR_ALWAYS ? least_allowed(seeds)
                                                                           : INFINITY;
}

/* Moves x, `length` from its nearest input point, onto the plane through the points nearest to
 * that, if it is then half as far from the input or nearer: a surface fitted to the points of two
 * sheets, or of both sides of an edge, lies in the air between them. `around` was gathered around
 * that input point. Returns whether x was moved. */
static int land(const struct vor_place *around, const struct vor_surface *plane, double length,
                double x[3])
{
    double y[3] = {x[0], x[1], x[2]};

    if (plane->kind == VOR_SURFACE_NONE)
        return 0;
    vor_surface_put(plane, y);
    if (!vor_boundary_within(around->near, around->k, y, length / 2))
        return 0;
    memcpy(x, y, sizeof y);
    return 1;
}

/* Moves x, if it is too far beyond the end of the input, straight towards its nearest input point.
 * Where the points around that fill little of the disc that they span, they lie on scan lines,
 * whose gaps are no end. Returns whether x was moved. */
static int draw_in(const struct vor_place *around, double least, double x[3])
{
    const struct vor_surface *surface = &around->surface;
    double foot[3], way[3], length = vor_boundary_foot(around->near, around->k, x, foot, way);
    double disc = sqrt(M_PI / around->k) * surface->reach; /* spacing if they filled it */
    double most = fmax(least, VOR_OUTSIDE_BEYOND * disc);

    if (length <= most || surface->spacing < disc / 2 ||
        vor_boundary_goes_on(around->near, around->k, foot, way, INFINITY))
        return 0;
    for (int c = 0; c < 3; c++)
        x[c] = foot[c] + most * way[c];
    return 1;
}

/* Moves x, which the input surrounds, straight towards its nearest input point, to `least` from it
 * or to where x is VOR_HOLE_MARGIN times that off the surface around it, whichever is farther. A
 * plane in place of that surface takes points of coarse spheres for ones in the air. Returns
 * whether x was moved. */
static int lower(const struct vor_place *around, double least, double x[3])
{
    double foot[3], way[3], length = vor_boundary_foot(around->near, around->k, x, foot, way);
    double high = fabs(vor_surface_above(&around->surface, x)), low = VOR_HOLE_MARGIN * least, most;

    if (length <= least || high <= low)
        return 0;
    most = fmax(least, length * (low / high));
    for (int c = 0; c < 3; c++)
        x[c] = foot[c] + most * way[c];
    return 1;
}

int vor_attach_near(const struct vor_seeds *seeds, struct vor_scratch *scratch, double x[3])
{
    const struct vor_place *here = &scratch->here, *around = &scratch->foot;
    double foot[3], way[3], length, least = least_allowed(seeds);
    struct vor_surface plane;
    int moved;

    if (!stay_near(seeds))
        return 0;
    length = vor_boundary_foot(here->near, here->k, x, foot, way);
    if (length <= least || fit_foot(seeds, scratch, foot, &plane) == VOR_SURFACE_NONE)
        return 0;
    moved = land(around, &plane, length, x);
    if (!vor_seeds_surrounded(scratch, x))
        return draw_in(around, least, x) || moved;
    return lower(around, least, x) || moved;
}

/* Moves a seed to where a result may be. */
static void attach_row(void *ctx, size_t i, unsigned worker)
{
    const struct attach *attach = ctx;
    struct vor_seeds *seeds = attach->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct vor_border border;
    int moved = attach->onto_whole;
    double x[3];

    if (vor_run_is_late(&seeds->run)) {
        attach_hurried(seeds, i);
        return;
    }
    vor_seeds_position(seeds, i, x);
    if (vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE)
        return;
    if (attach->onto_whole)
        vor_surface_put(&scratch->here.surface, x);
    if (seeds->policy.keep_border) {
        moved |= !attach->fast && vor_attach_near(seeds, scratch, x);
        vor_seeds_border(seeds, scratch, &scratch->here, &border, x);
        moved |= attach->keep_holes && vor_seeds_hold(seeds, scratch, i, x);
        moved |= vor_boundary_restrict(&border, VOR_OUTSIDE_IN_RESULT, x);
    }
    for (size_t c = 0; moved && c < 3; c++)
        seeds->xyz[3 * i + c] = (float)x[c];
}

vor_status vor_attach(struct vor_seeds *seeds, int *keep_holes, struct vor_error *err)
{
    struct attach attach = {.seeds = seeds};
    size_t moving = vor_seeds_moving(seeds);
    vor_status status;

    *keep_holes = 0;
    if (!seeds->policy.keep_border)
        return VOR_OK;
    if (stay_near(seeds) && seeds->kept == NULL) {
        seeds->kept = vor_calloc(seeds->run.memory, vor_pool_threads(seeds->run.pool) * KEPT_SLOTS,
                                 kept_size(seeds));
        if (seeds->kept == NULL)
            return vor_fail(err, VOR_E_NOMEM, "surfaces around input points");
    }
    status =
        vor_run_for(&seeds->run, moving, vor_seeds_block(seeds->domain), count_block, &attach, err);
    if (status != VOR_OK)
        return status;
    attach.keep_holes =
        !vor_run_is_late(&seeds->run) && (double)attach.beyond <= VOR_GAPS_SHARE * (double)seeds->n;
    *keep_holes = attach.keep_holes;
    return vor_run_rows(&seeds->run, moving, vor_seeds_block(seeds->domain), attach_row, &attach,
                        err);
}

vor_status vor_attach_fast(struct vor_seeds *seeds, struct vor_error *err)
{
    struct attach attach = {.seeds = seeds, .fast = 1};

    if (!seeds->policy.keep_border)
        return VOR_OK;
    return vor_run_rows(&seeds->run, vor_seeds_moving(seeds), vor_seeds_block(seeds->domain),
                        attach_row, &attach, err);
}

/* Whether the input point that was nearest to seed i in its last search, if there was one, is near
 * enough: spares another. */
static int lies_near(const struct vor_seeds *seeds, size_t i, double near2)
{
    size_t first;

    if (seeds->input_lists.reach[i] < 0)
        return 0;
    first = vor_input_lists_first(&seeds->input_lists, i);
    return vor_distance2f(&seeds->domain->xyz[3 * first], &seeds->xyz[3 * i]) <= near2;
}

/* Moves a seed that is too far from all of the input. */
static void end_row(void *ctx, size_t i, unsigned worker)
{
    const struct attach *attach = ctx;
    struct vor_seeds *seeds = attach->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct vor_place *here = &scratch->here;
    struct vor_border border;
    double near = VOR_OUTSIDE_BEYOND * VOR_OUTSIDE_IN_RESULT * seeds->domain->sparse, x[3];
    int late = vor_run_is_late(&seeds->run), moved;

    near = fmin(near, vor_attach_allowed(seeds));
    if (!late && lies_near(seeds, i, near * near))
        return;
    vor_seeds_position(seeds, i, x);
    if (late || vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE) {
        attach_hurried(seeds, i);
        return;
    }
    moved = vor_attach_near(seeds, scratch, x);
    border = (struct vor_border){&here->surface, here->near, here->k, seeds->domain->sparse};
    if (vor_boundary_restrict(&border, VOR_OUTSIDE_IN_RESULT, x) || moved)
        vor_to_floats(&seeds->xyz[3 * i], x);
}

/* Runs a task over all seeds that move, if the border is kept. */
static vor_status attach_all(struct vor_seeds *seeds, vor_row_task task, const unsigned char *stays,
                             struct vor_error *err)
{
    struct attach attach = {.seeds = seeds, .stays = stays};

    if (!seeds->policy.keep_border)
        return VOR_OK;
    return vor_run_rows(&seeds->run, vor_seeds_moving(seeds), VOR_SEEDS_BLOCK, task, &attach, err);
}

vor_status vor_attach_last(struct vor_seeds *seeds, struct vor_error *err)
{
    return attach_all(seeds, end_row, NULL, err);
}

/* Moves seed i, if it hangs steeply above the points nearest to it, which are at hand, back to
 * them.
 */
static void hold_steep(struct vor_seeds *seeds, const struct vor_place *here, size_t i, double most)
{
    double x[3], foot[3], way[3], up[3] = {0}, distance;

    vor_seeds_position(seeds, i, x);
    distance = vor_boundary_foot(here->near, here->k, x, foot, way);
    most = fmax(most, here->surface.spacing);
    for (int a = 0; a < 3; a++)
        up[a] = vor_dot(here->surface.axis[a], way);
    if (distance <= VOR_HOLE_INSIDE * most || fabs(up[2]) <= VOR_SAME_WAY ||
        vor_boundary_goes_on(here->near, here->k, foot, way, INFINITY))
        return;
    for (int c = 0; c < 3; c++)
        x[c] = foot[c] + VOR_HOLE_MARGIN * most * way[c];
    vor_to_floats(&seeds->xyz[3 * i], x);
}

/* Gathers the points nearest to seed i, where the input has sheets those of its own. Those of its
 * list may be of one side of a crease alone. Returns NULL if they lie on a line. */
static const struct vor_place *nearest_of(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                          size_t i)
{
    const struct vor_domain *domain = seeds->domain;
    struct vor_place *there = &scratch->there;
    uint32_t index[VOR_NEIGHBORS_FEWEST];
    float distance2[VOR_NEIGHBORS_FEWEST];

    if (seeds->sheets)
        return vor_seeds_fit(seeds, scratch, i) != VOR_SURFACE_NONE ? &scratch->here : NULL;
    there->k = domain->n < VOR_NEIGHBORS_FEWEST ? (unsigned)domain->n : VOR_NEIGHBORS_FEWEST;
    vor_input_lists_nearest(&seeds->input_lists, &seeds->xyz[3 * i], there->k, index, distance2);
    vor_gather(there->near, domain->xyz, index, there->k);
    vor_surface_fit_as(&there->surface, there->near, there->k, VOR_SURFACE_PLANE);
    return there->surface.kind != VOR_SURFACE_NONE ? there : NULL;
}

/* Moves a seed that hangs steeply above the input. */
static void steep_row(void *ctx, size_t i, unsigned worker)
{
    const struct attach *attach = ctx;
    struct vor_seeds *seeds = attach->seeds;
    double spacing = sqrt(seeds->area / (double)seeds->n);
    double near = VOR_HOLE_INSIDE * fmax(spacing, seeds->last_fit[i].surface.spacing);
    const struct vor_place *here;

    if (vor_run_is_late(&seeds->run) || lies_near(seeds, i, near * near))
        return;
    here = nearest_of(seeds, &seeds->scratch[worker], i);
    if (here != NULL)
        hold_steep(seeds, here, i, spacing);
}

vor_status vor_attach_steep(struct vor_seeds *seeds, struct vor_error *err)
{
    return attach_all(seeds, steep_row, NULL, err);
}

/* Whether points within VOR_RIM_RING times the distance from x to the nearest lie more to one side
 * of it than those of a half plane do from its straight end. */
static int is_beside_all(const struct vor_place *here, const double x[3], double distance)
{
    double sum[3] = {0};
    unsigned count = 0;

    for (size_t j = 0; j < here->k; j++) {
        double to[3], length;

        for (size_t c = 0; c < 3; c++)
            to[c] = (double)here->near[3 * j + c] - x[c];
        length = sqrt(vor_dot(to, to));
        if (length > VOR_RIM_RING * distance)
            continue;
        count++;
        for (int c = 0; c < 3; c++)
            sum[c] += to[c] / length;
    }
    return sqrt(vor_dot(sum, sum)) > 2 / M_PI * count;
}

/* Moves a seed that hangs in the air. */
static void hanging_row(void *ctx, size_t i, unsigned worker)
{
    const struct attach *attach = ctx;
    struct vor_seeds *seeds = attach->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    const struct vor_place *here = &scratch->here;
    double x[3], foot[3], way[3], distance, most = sqrt(seeds->area / (double)seeds->n);

    if ((attach->stays != NULL && attach->stays[i]) || vor_run_is_late(&seeds->run) ||
        lies_near(seeds, i, VOR_HOLE_INSIDE * VOR_HOLE_INSIDE * most * most) ||
        vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE)
        return;
    vor_seeds_position(seeds, i, x);
    most = fmax(most, here->surface.spacing);
    distance = vor_boundary_foot(here->near, here->k, x, foot, way);
    if (distance <= VOR_HOLE_INSIDE * most || !is_beside_all(here, x, distance))
        return;
    for (int c = 0; c < 3; c++)
        x[c] = foot[c] + VOR_HOLE_MARGIN * most * way[c];
    vor_to_floats(&seeds->xyz[3 * i], x);
}

vor_status vor_attach_hanging(struct vor_seeds *seeds, const unsigned char *stays,
                              struct vor_error *err)
{
    return attach_all(seeds, hanging_row, stays, err);
}

vor_status vor_attach_to_whole(struct vor_seeds *seeds, int keep_holes, struct vor_error *err)
{
    struct attach attach = {.seeds = seeds, .onto_whole = 1, .keep_holes = keep_holes};
    vor_status status;

    if (vor_seeds_on_whole(seeds))
        return VOR_OK;
    status = vor_seeds_onto(seeds, seeds->whole, err);
    if (status != VOR_OK)
        return status;
    return vor_run_rows(&seeds->run, vor_seeds_moving(seeds), vor_seeds_block(seeds->domain),
                        attach_row, &attach, err);
}

/* Room around the box of fewer points than a fit takes, in its largest side: a sphere sampled so
 * sparsely bulges as far. */
#define BOX_ROOM 0.1

/* The middle of the box around the points and half its sides with room. */
static void box_of(const struct vor_domain *domain, double middle[3], double half[3])
{
    double side = 0;

    for (size_t c = 0; c < 3; c++) {
        double low = INFINITY, high = -INFINITY;

        for (size_t i = 0; i < domain->n; i++) {
            double x = (double)domain->xyz[3 * i + c];

            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        middle[c] = (low + high) / 2;
        half[c] = (high - low) / 2;
        side = fmax(side, high - low);
    }
    for (int c = 0; c < 3; c++)
        half[c] += BOX_ROOM * side;
}

/* Towards the middle, and not each coordinate by itself, which would put many into one corner.
 * Fewer points than a fit takes do not say how a surface goes on beyond them: a quadric fitted to
 * all of them bends to wherever it likes, up to 0.9 of the largest side of their box away from it.
 */
void vor_attach_to_box(struct vor_seeds *seeds)
{
    double middle[3], half[3];

    if (!seeds->policy.keep_border || seeds->whole->n >= VOR_NEIGHBORS_FEWEST)
        return;
    box_of(seeds->whole, middle, half);
    for (size_t i = 0; i < vor_seeds_moving(seeds); i++) {
        double x[3], share = 1;

        vor_seeds_position(seeds, i, x);
        for (int c = 0; c < 3; c++)
            if (fabs(x[c] - middle[c]) > half[c])
                share = fmin(share, half[c] / fabs(x[c] - middle[c]));
        for (size_t c = 0; share < 1 && c < 3; c++)
            seeds->xyz[3 * i + c] = (float)(middle[c] + share * (x[c] - middle[c]));
    }
}
