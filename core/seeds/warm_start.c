#include "core/seeds/warm_start.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/base/stat.h"

#include <math.h>
#include <string.h>

enum {
    /* Spacings of the result from an earlier point to the surface, above which the point dies. A
     * bent body of 100,000 points that turns by two degrees a frame: at 3.5 / 10 / 20, 0.90 / 0.98
     * / 0.98 of the points live on. */
    LEFT = 10,
    /* Points that one sum is ahead of the other. At 8 / 16 / 64: the same body of 20,000 points,
     * 0.979 / 0.982 / 0.985 live on, delta 0.023 / 0.025 / 0.042 after 12 to 16 frames. At 4 / 16,
     * 20,000 points at rest with noise of 0.2 spacings: 0.989 / 0.999. */
    BALANCE = 16
};

#define NOBODY UINT32_MAX

/* Points of the earlier result that are on the surface, m of them in Morton order, and first
 * positions, n of them. */
struct warm {
    struct vor_seeds *seeds; /* at the first positions */
    double coherence;        /* of the request */
    const struct vor_previous *previous;
    struct vor_knn *knn; /* over xyz */
    double spacing;      /* of an even spread, normalised */
    double moved;        /* mean of the m: (way to the surface / half a spacing)^2, at most 1 */
    float *doubt;        /* m: (way to the surface / a quarter of a spacing)^2, at most 1 */
    size_t m;
    float *xyz;           /* m x 3 */
    uint32_t *track;      /* m */
    float *room;          /* m: squared distance to the nearest other one; before, as moved */
    uint32_t *count;      /* m: first positions that count for it */
    uint32_t *emptiest;   /* m: the one of these that is farthest from it */
    unsigned char *dead;  /* m */
    uint32_t *nearest;    /* n: point that is nearest */
    float *gap;           /* n: less than 0: square of its distance over the spacing wanted there
                             and, if it is farther, how far points lie off the surface */
    unsigned char *birth; /* n: a point is born there */
};

/* Square of the spacing wanted at x. */
static double spacing2(const struct warm *warm, const float x[3])
{
    const struct vor_field *field = &warm->seeds->whole->field;
    struct vor_field_near near;
    double spacing = warm->spacing;

    if (vor_field_is(field)) {
        vor_field_find(&near, field, x);
        spacing *= (double)near.value;
    }
    return spacing * spacing;
}

/* Puts x onto the surface and inside the input. Returns false if there is no surface. */
static int put(const struct vor_seeds *seeds, struct vor_scratch *scratch, double x[3])
{
    struct vor_place *there = &scratch->there;
    struct vor_border border;

    if (vor_seeds_fit_at(seeds, scratch, there, x) == VOR_SURFACE_NONE)
        return 0;
    vor_surface_put(&there->surface, x);
    if (!seeds->policy.keep_border ||
        vor_boundary_within(there->near, there->k, x, there->surface.spacing))
        return 1;
    if (vor_seeds_fit_at(seeds, scratch, there, x) == VOR_SURFACE_NONE)
        return 0;
    vor_surface_put(&there->surface, x);
    vor_seeds_border(seeds, scratch, there, &border, x);
    (void)vor_boundary_restrict(&border, VOR_OUTSIDE_MOVING, x);
    return 1;
}

/* Puts earlier points onto the surface; one that dies is NAN. */
static void put_row(void *ctx, size_t i, unsigned worker)
{
    const struct warm *warm = ctx;
    const float *from = &warm->previous->xyz[3 * i];
    float *to = &warm->xyz[3 * i];
    double x[3] = {(double)from[0], (double)from[1], (double)from[2]}, moved, bent, wanted2;

    to[0] = NAN;
    /* The domain lies within 1 of the middle. */
    if (vor_run_is_late(&warm->seeds->run) || !(vor_dot(x, x) < LEFT) ||
        !put(warm->seeds, &warm->seeds->scratch[worker], x))
        return;
    vor_to_floats(to, x);
    wanted2 = spacing2(warm, to);
    moved = vor_distance2f(to, from) / wanted2;
    bent = (double)warm->previous->bent[i];
    warm->room[i] = (float)fmin(4 * moved, 1);
    warm->doubt[i] = (float)fmin(16 * (moved + bent * bent / wanted2), 1);
    if (!(moved <= LEFT * LEFT))
        to[0] = NAN;
}

/* Sorts points, their tracks and, if there are any, their doubts along the Morton curve. */
static vor_status sort(float *xyz, uint32_t *track, float *doubt, size_t n,
                       const struct vor_run *run, struct vor_error *err)
{
    uint32_t *order = vor_malloc(run->memory, n, sizeof *order),
             *old = vor_malloc(run->memory, n, sizeof *old);
    float *from = vor_malloc(run->memory, n, 3 * sizeof *from);
    vor_status status;

    if (order == NULL || old == NULL || from == NULL) {
        VOR_FREE_ALL(run->memory, from, old, order);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    }
    memcpy(from, xyz, 3 * n * sizeof *from);
    memcpy(old, track, n * sizeof *old);
    status = vor_morton_order(order, from, n, run, err);
    for (size_t i = 0; status == VOR_OK && i < n; i++) {
        memcpy(&xyz[3 * i], &from[3 * (size_t)order[i]], 3 * sizeof *xyz);
        track[i] = old[order[i]];
    }
    if (doubt != NULL) {
        memcpy(from, doubt, n * sizeof *from);
        for (size_t i = 0; status == VOR_OK && i < n; i++)
            doubt[i] = from[order[i]];
    }
    VOR_FREE_ALL(run->memory, from, old, order);
    return status;
}

/* Keeps the earlier points that live on. */
static void gather(struct warm *warm)
{
    const struct vor_previous *previous = warm->previous;

    for (size_t i = 0; i < previous->n; i++) {
        if (isnan(warm->xyz[3 * i]))
            continue;
        memmove(&warm->xyz[3 * warm->m], &warm->xyz[3 * i], 3 * sizeof *warm->xyz);
        warm->moved += (double)warm->room[i];
        warm->doubt[warm->m] = warm->doubt[i];
        warm->track[warm->m++] = previous->track[i];
    }
}

static void room_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct warm *warm = ctx;
    uint32_t index[2];
    float distance2[2] = {0, INFINITY};

    vor_knn_search(warm->knn, &warm->xyz[3 * i], 1, warm->m > 1 ? 2 : 1, index, distance2);
    warm->room[i] = distance2[1];
}

static void gap_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct warm *warm = ctx;
    const float *x = warm->seeds->xyz;
    struct vor_scratch *scratch = &warm->seeds->scratch[worker];
    struct vor_place *there = &scratch->there;

    vor_knn_search(warm->knn, &x[3 * begin], end - begin, 1, &warm->nearest[begin],
                   &warm->gap[begin]);
    for (size_t j = begin; j < end; j++) {
        double at[3] = {(double)x[3 * j], (double)x[3 * j + 1], (double)x[3 * j + 2]};
        double far = sqrt(spacing2(warm, &x[3 * j]));

        if ((double)warm->gap[j] > far * far && !vor_run_is_late(&warm->seeds->run) &&
            vor_seeds_fit_at(warm->seeds, scratch, there, at) != VOR_SURFACE_NONE)
            far += sqrt(there->surface.off2);
        warm->gap[j] = -(float)((double)warm->gap[j] / (far * far));
    }
}

/* Counts the first positions. Returns how many of them are clear of all points and are births. */
static size_t count(const struct warm *warm)
{
    size_t births = 0;

    for (size_t j = 0; j < warm->seeds->n; j++) {
        uint32_t i = warm->nearest[j];

        if (warm->gap[j] < -1) {
            warm->birth[j] = 1;
            births++;
            continue;
        }
        if (warm->count[i]++ == 0 || warm->gap[j] < warm->gap[warm->emptiest[i]])
            warm->emptiest[i] = (uint32_t)j;
    }
    return births;
}

/* Lets points be born and die where one sum is ahead of the other. Returns how many more there are
 * then. Doubt is that of the last BALANCE points or so: at each by itself, it would be where points
 * crowd together by chance, and there more die than are born. At rest with noise of 0.2 spacings,
 * 100,000 points, fourth frame, with a doubt of 1 / this: 0.9990 / 0.9999 live on, a point moves by
 * 0.108 / 0.077 spacings, delta is 1.07 / 1.02 times that of a single run. */
static int64_t balance(const struct warm *warm)
{
    int64_t more = 0;
    double ahead = 0, doubt = 1;
    uint32_t place = NOBODY, least = NOBODY;

    for (uint32_t i = 0; i < warm->m; i++) {
        uint32_t emptiest = warm->emptiest[i];

        doubt += ((double)warm->doubt[i] - doubt) / BALANCE;
        ahead += doubt * ((double)warm->count[i] - 1);
        if (warm->count[i] > 0 && (place == NOBODY || warm->gap[emptiest] < warm->gap[place]))
            place = emptiest;
        if (least == NOBODY || warm->room[i] < warm->room[least])
            least = i;
        if (ahead >= BALANCE && place != NOBODY) {
            warm->birth[place] = 1;
            ahead--;
            more++;
        } else if (ahead <= -BALANCE) {
            warm->dead[least] = 1;
            ahead++;
            more--;
        } else {
            continue;
        }
        place = least = NOBODY;
    }
    return more;
}

/* Marks so many more of the n keys that are not marked: the smallest, of equal ones the first. */
static vor_status mark(unsigned char *marks, const float *key, size_t n, size_t wanted,
                       struct vor_memory *memory, struct vor_error *err)
{
    float *sorted = vor_malloc(memory, n, sizeof *sorted), most;
    size_t k = 0, below = 0;

    if (sorted == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t i = 0; i < n; i++)
        if (!marks[i])
            sorted[k++] = key[i];
    vor_sort_floats(sorted, k);
    most = sorted[wanted - 1];
    while (sorted[below] < most)
        below++;
    vor_free(memory, sorted);
    wanted -= below;
    for (size_t i = 0; i < n; i++)
        if (!marks[i] && (key[i] < most || (key[i] <= most && wanted > 0 && wanted-- > 0)))
            marks[i] = 1;
    return VOR_OK;
}

void vor_warm_start_number(struct vor_seeds *seeds, size_t known)
{
    for (size_t i = known; i < seeds->n; i++)
        seeds->track[i] = seeds->unused++;
}

/* Moves the seeds to the points that live on and to those that are born. */
static vor_status take(struct warm *warm, struct vor_error *err)
{
    struct vor_seeds *seeds = warm->seeds;
    size_t n = 0, living;
    float *xyz = vor_malloc(seeds->run.memory, seeds->n, 3 * sizeof *xyz);
    vor_status status;

    if (xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    for (size_t i = 0; i < warm->m; i++) {
        if (warm->dead[i])
            continue;
        memcpy(&xyz[3 * n], &warm->xyz[3 * i], 3 * sizeof *xyz);
        seeds->track[n++] = warm->track[i];
    }
    living = n;
    for (size_t j = 0; j < seeds->n; j++)
        if (warm->birth[j])
            memcpy(&xyz[3 * n++], &seeds->xyz[3 * j], 3 * sizeof *xyz);
    vor_warm_start_number(seeds, living);
    memcpy(seeds->xyz, xyz, 3 * seeds->n * sizeof *xyz);
    vor_free(seeds->run.memory, xyz);
    status = sort(seeds->xyz, seeds->track, NULL, seeds->n, &seeds->run, err);
    seeds->coherence = VOR_SEEDS_COHERENT * warm->coherence * (1 - warm->moved) * (double)living /
                       fmax((double)seeds->n, (double)warm->previous->n);
    return status;
}

static vor_status start(struct warm *warm, struct vor_error *err)
{
    struct vor_seeds *seeds = warm->seeds;
    struct vor_memory *memory = seeds->run.memory;
    int64_t missing;
    vor_status status = vor_run_rows(&seeds->run, warm->previous->n, vor_seeds_block(seeds->domain),
                                     put_row, warm, err);

    if (status != VOR_OK)
        return status;
    gather(warm);
    warm->moved /= fmax(1, (double)warm->m);
    if (warm->m == 0) {
        vor_warm_start_number(seeds, 0);
        return VOR_OK;
    }
    status = sort(warm->xyz, warm->track, warm->doubt, warm->m, &seeds->run, err);
    VOR_THEN(status, vor_knn_build_sorted(&warm->knn, warm->xyz, warm->m, &seeds->run, err));
    VOR_THEN(status, vor_run_rows(&seeds->run, warm->m, VOR_SEEDS_BLOCK, room_row, warm, err));
    VOR_THEN(status, vor_run_for(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, gap_block, warm, err));
    if (status != VOR_OK)
        return status;
    missing = (int64_t)seeds->n - (int64_t)warm->m - (int64_t)count(warm);
    missing -= balance(warm);
    if (missing > 0)
        status = mark(warm->birth, warm->gap, seeds->n, (size_t)missing, memory, err);
    if (missing < 0)
        status = mark(warm->dead, warm->room, warm->m, (size_t)-missing, memory, err);
    return status == VOR_OK ? take(warm, err) : status;
}

vor_status vor_warm_start(struct vor_seeds *seeds, double coherence, struct vor_error *err)
{
    const struct vor_previous *previous = &seeds->whole->previous;
    struct vor_memory *memory = seeds->run.memory;
    size_t n = seeds->n, m = previous->n;
    struct warm warm = {.seeds = seeds,
                        .coherence = coherence,
                        .previous = previous,
                        .spacing = sqrt(seeds->area / (VOR_HEXAGON_HEIGHT * (double)n))};
    vor_status status;

    seeds->unused = previous->unused;
    seeds->track = vor_malloc(memory, n, sizeof *seeds->track);
    if (seeds->track == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    if (!(coherence > 0 && warm.spacing > 0)) {
        vor_warm_start_number(seeds, 0);
        return VOR_OK;
    }
    status = VOR_MAKE_ALL(
        memory, err, n + m, VOR_ARRAY(warm.xyz, m, 3), VOR_ARRAY(warm.track, m, 1),
        VOR_ARRAY(warm.room, m, 1), VOR_ARRAY(warm.doubt, m, 1), VOR_ZEROED(warm.count, m, 1),
        VOR_ARRAY(warm.emptiest, m, 1), VOR_ZEROED(warm.dead, m, 1), VOR_ARRAY(warm.nearest, n, 1),
        VOR_ARRAY(warm.gap, n, 1), VOR_ZEROED(warm.birth, n, 1));
    VOR_THEN(status, start(&warm, err));
    vor_knn_free(warm.knn);
    VOR_FREE_ALL(memory, warm.birth, warm.gap, warm.nearest, warm.dead, warm.emptiest, warm.count,
                 warm.doubt, warm.room, warm.track, warm.xyz);
    return status;
}
