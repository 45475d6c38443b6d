#include "core/input/islands.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"
#include "core/geom/surface.h"
#include "core/input/remote.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Times vor_domain.sparse that parts are clear of each other. By all pairs of points,
 * at 1 / 2 / 4 the small parts of office1 are 90 / 1 / 0, of kitti 9 / 0 / 0, of autzen 13 / 0 / 0:
 * at 1 they are the ragged ends of these scans. */
#define CLEAR 2.0
enum {
    /* Times as many points as a fit takes that a part needs: at half of it, a fit in its middle has
     * just enough. Beside a sphere of 5,000 points, 5,000 asked for, three seeds: at 1, flat parts
     * of 20 to 40 points get up to a fifth more results than they have points, as far as 0.7
     * spacings outside; at 4, parts of 60 and 80 points would be held to their own, which get 77 to
     * 88 results of 80, at most half a spacing outside. */
    FITS = 2,
    BLOCK = 64,       /* islands of one task */
    LOOK_BLOCK = 4096 /* points that one task looks at */
};

#define LARGE UINT32_MAX

struct parts {
    size_t count;        /* all of them */
    size_t small, least; /* those of fewer than `least` points, and that number */
    size_t points;       /* that these hold */
    uint32_t *root;      /* n: the first point of each point's part */
    uint32_t *size;      /* n: of the part that begins there */
};

static void free_parts(struct parts *parts, struct vor_memory *memory)
{
    VOR_FREE_ALL(memory, parts->size, parts->root);
}

/* Looking for lone points and small groups of them. */
struct lone {
    const struct vor_domain *domain;
    double least2;     /* square of the gap around it, at least */
    unsigned char *is; /* n: of enum lone_state */
    atomic_size_t count;
    float *sixth2;   /* n: square of the distance to the sixth neighbour; 0: not looked for yet */
    uint32_t *root;  /* n: a point of the group of each that is LONE */
    uint32_t *group; /* least: the one that grows */
    size_t grown, least;
};

enum lone_state { NOT_LONE, WIDE, /* the gap is */ GROUPED, /* now */ HELD, LONE };

static void free_lone(struct lone *lone, struct vor_memory *memory)
{
    VOR_FREE_ALL(memory, lone->group, lone->root, lone->sixth2, lone->is);
}

/* Whether the next points of the order on both sides lie farther away than is usual: so they do
 * around every lone point, and around few others. */
static int may_be_lone(const struct lone *lone, size_t i)
{
    const struct vor_domain *domain = lone->domain;
    const float *x = &domain->xyz[3 * i];
    double near2 = fmax(domain->usual6 * domain->usual6, lone->least2);

    return (i == 0 || vor_distance2f(x, x - 3) > near2) &&
           (i + 1 == domain->n || vor_distance2f(x, x + 3) > near2);
}

static void lone_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct lone *lone = ctx;
    size_t count = 0;

    for (size_t i = begin; i < end; i++) {
        uint32_t index[2];
        float distance2[2] = {0};

        if (!may_be_lone(lone, i))
            continue;
        vor_knn_search(lone->domain->knn, &lone->domain->xyz[3 * i], 1, 2, index, distance2);
        lone->is[i] = (double)distance2[1] > lone->least2 ? WIDE : NOT_LONE;
        count += lone->is[i];
    }
    atomic_fetch_add(&lone->count, count);
}

/* The nearest neighbours of a point, itself first; returns how many. */
static unsigned look_around(uint32_t *index, float *distance2, struct lone *lone, uint32_t i)
{
    const struct vor_domain *domain = lone->domain;
    unsigned k = domain->n > VOR_PATCH_HEXAGON ? VOR_PATCH_HEXAGON + 1 : (unsigned)domain->n;

    vor_knn_search(domain->knn, &domain->xyz[3 * (size_t)i], 1, k, index, distance2);
    lone->sixth2[i] = distance2[k - 1];
    return k;
}

/* Adds those neighbours of a point to its group that are sparse, too, from the nearest on as far as
 * one that is not. Returns whether the group is held: a neighbour that is not sparse, or of a group
 * that is held, shows that such gaps are usual there, or the group is large enough for a surface.
 */
static int grow(struct lone *lone, uint32_t i)
{
    uint32_t index[VOR_PATCH_HEXAGON + 1], there[VOR_PATCH_HEXAGON + 1];
    float distance2[VOR_PATCH_HEXAGON + 1] = {0}, there2[VOR_PATCH_HEXAGON + 1] = {0};
    unsigned k = look_around(index, distance2, lone, i);

    for (unsigned j = 1; j < k; j++) {
        uint32_t other = index[j];
        int dense, clear;

        if (!(lone->sixth2[other] > 0))
            (void)look_around(there, there2, lone, other);
        dense = (double)lone->sixth2[other] <= lone->least2;
        clear = distance2[j] > (float)(CLEAR * CLEAR) * lone->sixth2[other];
        if (!clear && (dense || lone->is[other] == HELD))
            return 1;
        if (dense)
            return 0;
        if (clear || lone->is[other] == GROUPED || lone->is[other] == LONE)
            continue;
        if (lone->grown + 1 >= lone->least)
            return 1;
        lone->is[other] = GROUPED;
        lone->group[lone->grown++] = other;
    }
    return 0;
}

/* Decides which of those with a wide gap are lone: groups that nothing holds. */
static vor_status group_lone(struct lone *lone, const struct vor_run *run, struct vor_error *err)
{
    size_t n = lone->domain->n;
    vor_status status = VOR_OK;

    status = VOR_MAKE_ALL(run->memory, err, n, VOR_ZEROED(lone->sixth2, n, 1),
                          VOR_ARRAY(lone->root, n, 1), VOR_ARRAY(lone->group, lone->least, 1));
    if (status != VOR_OK)
        return status;
    atomic_store(&lone->count, 0);
    for (size_t i = 0; i < n && status == VOR_OK; i++) {
        int held = 0;

        if (i % LOOK_BLOCK == 0)
            status = vor_run_answered(vor_run_poll(run), err);
        if (lone->is[i] != WIDE)
            continue;
        lone->is[i] = GROUPED;
        lone->group[0] = (uint32_t)i;
        lone->grown = 1;
        for (size_t at = 0; at < lone->grown && !held; at++)
            held = grow(lone, lone->group[at]);
        for (size_t at = 0; at < lone->grown; at++) {
            lone->is[lone->group[at]] = held ? HELD : LONE;
            lone->root[lone->group[at]] = (uint32_t)i;
        }
        atomic_fetch_add(&lone->count, held ? 0 : lone->grown);
    }
    return status;
}

/* Makes each group of lone points a part of its own. */
static void part_lone(struct parts *parts, const struct lone *lone, size_t n)
{
    uint32_t *first = parts->size; /* of those that stay with a root */

    for (size_t i = n; i-- > 0;)
        if (lone->is[i] != LONE)
            first[parts->root[i]] = (uint32_t)i;
    for (size_t i = 0; i < n; i++)
        parts->root[i] = lone->is[i] == LONE ? lone->root[i] : first[parts->root[i]];
    memset(first, 0, n * sizeof *first);
}

/* Sets size, and counts the small parts. */
static vor_status measure_parts(struct parts *parts, const struct lone *lone, size_t n,
                                struct vor_memory *memory, struct vor_error *err)
{
    size_t count = 0;

    parts->size = vor_calloc(memory, n, sizeof *parts->size);
    if (parts->size == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    if (parts->count == 1)
        memset(parts->root, 0, n * sizeof *parts->root);
    part_lone(parts, lone, n);
    for (size_t i = 0; i < n; i++)
        parts->size[parts->root[i]]++;
    for (size_t i = 0; i < n; i++) {
        count += parts->size[i] > 0;
        if (parts->size[i] > 0 && parts->size[i] < parts->least) {
            parts->small++;
            parts->points += parts->size[i];
        }
    }
    parts->count = count;
    return VOR_OK;
}

int vor_islands_can_be_told(const struct vor_domain *domain)
{
    return CLEAR * domain->sparse >= VOR_ROUNDED;
}

/* Finds the parts, lone points with a gap around them among them; root and size are set only if
 * there are several. */
static vor_status find_parts(struct parts *parts, const struct vor_domain *domain, double gap,
                             const struct vor_run *run, struct vor_error *err)
{
    double clear = CLEAR * domain->sparse;
    struct lone lone = {.domain = domain, .least2 = gap * gap, .least = parts->least};
    vor_status status;

    parts->count = 1;
    if (!vor_islands_can_be_told(domain))
        return VOR_OK;
    if (VOR_MAKE_ALL(run->memory, err, domain->n, VOR_ARRAY(parts->root, domain->n, 1),
                     VOR_ZEROED(lone.is, domain->n, 1)) != VOR_OK) {
        free_lone(&lone, run->memory);
        return VOR_E_NOMEM;
    }
    status = vor_knn_join(parts->root, &parts->count, domain->knn, clear, run, err);
    if (status == VOR_OK && gap < INFINITY)
        status = vor_run_for(run, domain->n, LOOK_BLOCK, lone_block, &lone, err);
    if (status == VOR_OK && atomic_load(&lone.count) > 0)
        status = group_lone(&lone, run, err);
    if (status == VOR_OK && (parts->count > 1 || atomic_load(&lone.count) > 0))
        status = measure_parts(parts, &lone, domain->n, run->memory, err);
    free_lone(&lone, run->memory);
    return status;
}

/* Lists the points of the small parts, part by part. Afterwards size is LARGE where a large part
 * begins. */
static vor_status list_members(struct vor_islands *islands, struct parts *parts, size_t n,
                               struct vor_memory *memory, struct vor_error *err)
{
    uint32_t next = 0;
    size_t at = 0;

    islands->first = vor_malloc(memory, parts->small + 1, sizeof *islands->first);
    islands->member = vor_malloc(memory, parts->points, sizeof *islands->member);
    if (islands->first == NULL || islands->member == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu islands", parts->small);
    for (size_t i = 0; i < n; i++) {
        uint32_t size = parts->size[i];

        if (size > 0 && size < parts->least) {
            parts->size[i] = islands->first[at++] = next;
            next += size;
        } else if (size > 0) {
            parts->size[i] = LARGE;
        }
    }
    islands->first[at] = next;
    for (size_t i = 0; i < n; i++)
        if (parts->size[parts->root[i]] != LARGE)
            islands->member[parts->size[parts->root[i]]++] = (uint32_t)i;
    islands->count = parts->small;
    return VOR_OK;
}

/* Moves the islands' points to the end of the domain, and cuts them off. */
static vor_status cut_off(struct vor_domain *domain, const struct parts *parts,
                          struct vor_error *err)
{
    struct vor_memory *memory = domain->memory;
    struct vor_islands *islands = &domain->islands;
    size_t rest = domain->n - parts->points, kept = 0;
    float *xyz = vor_malloc(memory, parts->points, 3 * sizeof *xyz);
    uint32_t *source = vor_malloc(memory, parts->points, sizeof *source);

    if (xyz == NULL || source == NULL) {
        VOR_FREE_ALL(memory, source, xyz);
        return vor_fail(err, VOR_E_NOMEM, "%zu islands", parts->small);
    }
    vor_gather(xyz, domain->xyz, islands->member, parts->points);
    for (size_t i = 0; i < parts->points; i++) {
        source[i] = domain->source[islands->member[i]];
        islands->member[i] = (uint32_t)(rest + i);
    }
    for (size_t i = 0; i < domain->n; i++)
        if (parts->size[parts->root[i]] == LARGE) {
            memmove(&domain->xyz[3 * kept], &domain->xyz[3 * i], 3 * sizeof *xyz);
            domain->source[kept++] = domain->source[i];
        }
    memcpy(&domain->xyz[3 * rest], xyz, parts->points * 3 * sizeof *xyz);
    memcpy(&domain->source[rest], source, parts->points * sizeof *source);
    domain->n = rest;
    VOR_FREE_ALL(memory, source, xyz);
    return VOR_OK;
}

static void forget(struct vor_domain *domain)
{
    VOR_FREE_ALL(domain->memory, domain->islands.first, domain->islands.member);
    memset(&domain->islands, 0, sizeof domain->islands);
}

static vor_status index_again(struct vor_domain *domain, const struct vor_run *run,
                              struct vor_error *err)
{
    vor_graph_free(&domain->graph); /* its lists are of other points */
    vor_knn_free(domain->knn);
    domain->knn = NULL;
    return vor_domain_index(domain, run, err);
}

/* Takes the small parts, of which there are some, out of the domain. */
static vor_status take_out(struct vor_domain *domain, struct parts *parts,
                           const struct vor_run *run, struct vor_error *err)
{
    struct vor_islands *islands = &domain->islands;
    vor_status status = list_members(islands, parts, domain->n, domain->memory, err);

    islands->points = parts->points;
    if (status != VOR_OK || parts->points == domain->n)
        return status;
    status = cut_off(domain, parts, err);
    if (status != VOR_OK)
        return status;
    status = vor_domain_check(domain, run, err);
    if (status == VOR_E_DEGENERATE) {
        domain->n += parts->points;
        forget(domain);
    } else if (status != VOR_OK) {
        return status;
    }
    return index_again(domain, run, err);
}

vor_status vor_islands_take(struct vor_domain *domain, double target, const struct vor_run *run,
                            struct vor_error *err)
{
    struct parts parts = {.least = (size_t)FITS * domain->known.neighbors.usual};
    double n = (double)domain->n, coarser = target > 0 && target < n ? sqrt(n / target) : 1;
    vor_status status = find_parts(&parts, domain, CLEAR * coarser * domain->usual6, run, err);

    domain->known.parts = parts.count;
    if (status == VOR_OK && parts.points > 0)
        status = take_out(domain, &parts, run, err);
    domain->known.islands = domain->islands.count;
    domain->known.in_islands = domain->islands.points;
    free_parts(&parts, run->memory);
    return status;
}

static int all_are_islands(const struct vor_domain *domain)
{
    return domain->islands.count > 0 && domain->islands.member[0] < domain->n;
}

vor_status vor_islands_add(struct vor_domain *domain, const struct vor_outliers *points,
                           const struct vor_run *run, struct vor_error *err)
{
    struct vor_memory *memory = domain->memory;
    struct vor_islands *islands = &domain->islands;
    size_t at = domain->n + (all_are_islands(domain) ? 0 : islands->points), n = points->n;
    float *xyz = vor_realloc(memory, domain->xyz, at + n, 3 * sizeof *xyz);
    uint32_t *source = vor_realloc(memory, domain->source, at + n, sizeof *source);
    uint32_t *first = vor_realloc(memory, islands->first, islands->count + n + 1, sizeof *first);
    uint32_t *member = vor_realloc(memory, islands->member, islands->points + n, sizeof *member);

    domain->xyz = xyz != NULL ? xyz : domain->xyz;
    domain->source = source != NULL ? source : domain->source;
    islands->first = first != NULL ? first : islands->first;
    islands->member = member != NULL ? member : islands->member;
    if (xyz == NULL || source == NULL || first == NULL || member == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu outliers", n);
    memcpy(&xyz[3 * at], points->xyz, 3 * n * sizeof *xyz);
    memcpy(&source[at], points->source, n * sizeof *source);
    for (size_t i = 0; i < n; i++) {
        first[islands->count++] = (uint32_t)islands->points;
        member[islands->points++] = (uint32_t)(at + i);
    }
    first[islands->count] = (uint32_t)islands->points;
    domain->known.islands += n;
    domain->known.in_islands += n;
    return index_again(domain, run, err);
}

vor_status vor_islands_count(struct vor_domain *domain, const struct vor_run *run,
                             struct vor_error *err)
{
    struct parts parts = {.least = (size_t)FITS * domain->known.neighbors.usual};
    vor_status status = find_parts(&parts, domain, INFINITY, run, err);

    domain->known.parts = parts.count;
    domain->known.islands = parts.small;
    domain->known.in_islands = parts.points;
    free_parts(&parts, run->memory);
    return status;
}

vor_status vor_islands_drop(struct vor_domain *domain, const struct vor_run *run,
                            struct vor_error *err)
{
    struct parts parts = {.least = VOR_NEIGHBORS_FEWEST};
    vor_status status = find_parts(&parts, domain, INFINITY, run, err);

    if (status == VOR_OK && parts.points > 0 && parts.points <= domain->n / VOR_REMOTE_FEW)
        status = take_out(domain, &parts, run, err);
    domain->known.outliers += domain->islands.points;
    forget(domain);
    free_parts(&parts, run->memory);
    return status;
}

size_t vor_islands_share(const struct vor_domain *domain, size_t n)
{
    uint64_t points = domain->islands.points, share;

    if (all_are_islands(domain))
        return n <= domain->n ? n : 0;
    share = (uint64_t)n * points / (domain->n + points);
    return (size_t)(share < points ? share : points);
}

size_t vor_islands_beside(const struct vor_domain *domain, size_t n)
{
    uint64_t points = domain->islands.points, share = (uint64_t)n * points / domain->n;

    if (all_are_islands(domain))
        return 0;
    return (size_t)(share < points ? share : points);
}

/* Islands being given their points. */
struct placing {
    const struct vor_domain *domain;
    size_t share;
    float *xyz;
};

static const float *member(const struct placing *placing, size_t i)
{
    return &placing->domain->xyz[3 * (size_t)placing->domain->islands.member[i]];
}

/* How many points the islands before this one get. Islands are in Morton order, so that those that
 * get one more than others are spread over all of them. */
static size_t share_before(const struct placing *placing, size_t island)
{
    const struct vor_islands *islands = &placing->domain->islands;
    uint64_t sum = (uint64_t)placing->share * islands->first[island];

    return (size_t)((sum + islands->points / 2) / islands->points);
}

/* Places `wanted` points at those of an island. */
static void place_island(const struct placing *placing, size_t island, size_t at, size_t wanted)
{
    const uint32_t *first = placing->domain->islands.first + island;
    size_t count = first[1] - first[0], best = 0;
    double far2[FITS * VOR_NEIGHBORS_MAX];
    float mean[3];
    double sum[3] = {0, 0, 0};

    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += (double)member(placing, first[0] + i)[c];
    for (size_t c = 0; c < 3; c++)
        mean[c] = (float)(sum[c] / (double)count);
    for (size_t i = 0; i < count; i++) {
        far2[i] = vor_distance2f(member(placing, first[0] + i), mean);
        best = far2[i] < far2[best] ? i : best;
    }
    for (size_t i = 0; i < count; i++)
        far2[i] = INFINITY;
    for (size_t j = 0; j < wanted; j++) {
        const float *x = member(placing, first[0] + best);

        memcpy(&placing->xyz[3 * (at + j)], x, 3 * sizeof *x);
        best = 0;
        for (size_t i = 0; i < count; i++) {
            far2[i] = fmin(far2[i], vor_distance2f(member(placing, first[0] + i), x));
            best = far2[i] > far2[best] ? i : best;
        }
    }
}

static void place_row(void *ctx, size_t island, VOR_UNUSED unsigned worker)
{
    const struct placing *placing = ctx;
    size_t at = share_before(placing, island), next = share_before(placing, island + 1);

    if (next > at)
        place_island(placing, island, at, next - at);
}

vor_status vor_islands_place(float *xyz, const struct vor_domain *domain, size_t share,
                             const struct vor_run *run, struct vor_error *err)
{
    struct placing placing = {domain, share, xyz};

    return vor_run_rows(run, domain->islands.count, BLOCK, place_row, &placing, err);
}

vor_status vor_islands_return(struct vor_domain *domain, const struct vor_run *run,
                              struct vor_error *err)
{
    size_t points = all_are_islands(domain) ? 0 : domain->islands.points;

    forget(domain);
    if (points == 0)
        return VOR_OK;
    domain->n += points;
    return index_again(domain, run, err);
}
