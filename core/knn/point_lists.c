#include "core/knn/point_lists.h"

#include "core/base/linalg.h"
#include "core/knn/listed.h"

#include <assert.h>
#include <string.h>

/* These decide about searches and never about answers. Counts are of igea, 12,000 points of white
 * noise to 3,000, and autzen to 3,000, default request. */

enum {
    BLOCK = 256, /* points of one task */
    SHARE = 256  /* one point in so many may be a jumper (VOR_POINT_LISTS_JUMPERS_MIN and _MAX) */
};

/* Factor by which a distance in float32 may be off, and more: it has six roundings of 6e-8. */
#define ROUNDING 0.9999
/* Spacings around a jumper whose cells are marked: lists extend to about 2.5. 2 and 8 change no
 * count; less would test jumpers for every point. */
#define GROUND 4.0
/* Normalised: beyond it a jumper marks more than a twentieth of an axis, and the grid is not used.
 */
#define GROUND_MAX 0.1F
/* A list should hold everything within this many times the sixth distance. At 1.2 / 1.4 / 2.8:
 * searches on igea 44 / 45 / 148 thousand, on autzen 171 / 198 / 247 thousand; below it cells
 * search for themselves (VOR_SEEDS_MORE_MAX). */
#define COVERED 1.4

vor_status vor_point_lists_init(struct vor_point_lists *out, size_t n, unsigned listed,
                                struct vor_memory *memory, struct vor_error *err)
{
    struct vor_point_lists lists = {.memory = memory, .n = n, .listed = listed};

    assert(listed < n && listed <= VOR_POINT_LISTS_LISTED_MAX);
    lists.anchor = vor_malloc(memory, n, 3 * sizeof *lists.anchor);
    lists.place = vor_malloc(memory, n, 3 * sizeof *lists.place);
    lists.reach = vor_malloc(memory, n, sizeof *lists.reach);
    lists.list = vor_malloc(memory, n, listed * sizeof *lists.list);
    if (lists.anchor == NULL || lists.place == NULL || lists.reach == NULL || lists.list == NULL) {
        vor_point_lists_free(&lists);
        return vor_fail(err, VOR_E_NOMEM, "lists of %u neighbours for %zu points", listed, n);
    }
    *out = lists;
    return VOR_OK;
}

void vor_point_lists_free(struct vor_point_lists *lists)
{
    vor_knn_free(lists->knn);
    VOR_FREE_ALL(lists->memory, lists->list, lists->reach, lists->place, lists->anchor);
    memset(lists, 0, sizeof *lists);
}

/* Makes the list of point i from the listed + 1 anchors nearest to its place. Among many coincident
 * points i itself may not be one of these. */
static void make_list(struct vor_point_lists *lists, size_t i, const uint32_t *index,
                      const float *distance2)
{
    uint32_t *list = &lists->list[i * lists->listed];
    unsigned at = 0;

    for (unsigned j = 0; j <= lists->listed && at < lists->listed; j++)
        if (index[j] != i)
            list[at++] = index[j];
    lists->reach[i] = lists->listed + 1 < lists->n ? sqrtf(distance2[lists->listed]) : INFINITY;
}

/* Distances that hold as many anchors as a list and its point, from where their last lists were
 * made. */
static void bounds(float within[VOR_KNN_NEAR_MAX], const struct vor_point_lists *lists,
                   const uint32_t *of, size_t count)
{
    for (size_t q = 0; q < count; q++) {
        const float *at = &lists->anchor[3 * (size_t)of[q]];
        const uint32_t *list = &lists->list[(size_t)of[q] * lists->listed];
        float all2[VOR_LISTED_ROOM(VOR_POINT_LISTS_LISTED_MAX)];

        vor_listed_distances(all2, lists->anchor, list, lists->listed, at);
        within[q] = lists->listed > 0 ? sqrtf(vor_listed_largest(all2, lists->listed)) : 0;
    }
}

struct indexing {
    struct vor_point_lists *lists;
    int again; /* there are lists already */
};

/* Points are taken along the index, so that those of one search are near each other. */
static void index_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct indexing *indexing = ctx;
    struct vor_point_lists *lists = indexing->lists;
    const uint32_t *order = vor_knn_order(lists->knn);
    unsigned width = lists->listed + 1;
    uint32_t index[VOR_KNN_NEAR_MAX * (VOR_POINT_LISTS_LISTED_MAX + 1)];
    float distance2[VOR_KNN_NEAR_MAX * (VOR_POINT_LISTS_LISTED_MAX + 1)];
    float query[3 * VOR_KNN_NEAR_MAX], within[VOR_KNN_NEAR_MAX];
    struct vor_knn_near near = {query, 0, width, indexing->again ? within : NULL, 0};

    for (size_t from = begin; from < end; from += near.count) {
        near.count = end - from < VOR_KNN_NEAR_MAX ? end - from : VOR_KNN_NEAR_MAX;
        for (size_t i = 0; i < near.count; i++)
            memcpy(&query[3 * i], &lists->anchor[3 * (size_t)order[from + i]], 3 * sizeof *query);
        if (indexing->again)
            bounds(within, lists, &order[from], near.count);
        vor_knn_search_near(lists->knn, &near, index, distance2);
        for (size_t i = 0; i < near.count; i++)
            make_list(lists, order[from + i], &index[i * width], &distance2[i * width]);
    }
}

static double mean_spacing(const struct vor_point_lists *lists)
{
    double sum = 0;

    if (lists->listed == 0)
        return 0;
    for (size_t i = 0; i < lists->n; i++)
        sum += sqrt(vor_distance2f(&lists->anchor[3 * i],
                                   &lists->anchor[3 * (size_t)lists->list[i * lists->listed]]));
    return sum / (double)lists->n;
}

void vor_point_lists_forget(struct vor_point_lists *lists)
{
    vor_knn_free(lists->knn);
    lists->knn = NULL;
}

vor_status vor_point_lists_index(struct vor_point_lists *lists, const float *xyz,
                                 const struct vor_run *run, struct vor_error *err)
{
    struct indexing indexing = {lists, lists->knn != NULL};
    vor_status status;

    vor_point_lists_forget(lists);
    memcpy(lists->anchor, xyz, 3 * lists->n * sizeof *xyz);
    memcpy(lists->place, xyz, 3 * lists->n * sizeof *xyz);
    status = vor_knn_build_along(&lists->knn, lists->anchor, lists->n, run, err);
    VOR_THEN(status, vor_run_for(run, lists->n, BLOCK, index_block, &indexing, err));
    if (status != VOR_OK) {
        vor_point_lists_forget(lists); /* they are not whole */
        return status;
    }
    lists->spacing = mean_spacing(lists);
    lists->indexed++;
    return VOR_OK;
}

/* The cell of a coordinate: 64 cells over -1 .. 1, where all points except jumpers are. Does not
 * decrease with x. */
static unsigned cell_of(float x)
{
    return x <= -1 ? 0 : x >= 1 ? 63 : (unsigned)((x + 1) * 31.999f);
}

/* Marks every cell that is, at least in part, within `ground` of a jumper along each axis. */
static void mark(struct vor_point_lists_view *view, const float at[3])
{
    unsigned low[3], high[3];

    for (int c = 0; c < 3; c++) {
        low[c] = cell_of(at[c] - view->ground);
        high[c] = cell_of(at[c] + view->ground);
    }
    for (unsigned x = low[0]; x <= high[0]; x++)
        for (unsigned y = low[1]; y <= high[1]; y++)
            view->cells[64 * x + y] |= (~UINT64_C(0) >> (63 - high[2])) & (~UINT64_C(0) << low[2]);
}

int vor_point_lists_look(struct vor_point_lists_view *out, const struct vor_point_lists *lists,
                         const float *xyz, double far)
{
    double limit2 = far * lists->spacing * far * lists->spacing, drift2 = 0;
    unsigned allowed = (unsigned)fmin(fmax((double)lists->n / SHARE, VOR_POINT_LISTS_JUMPERS_MIN),
                                      VOR_POINT_LISTS_JUMPERS_MAX);

    out->xyz = xyz;
    out->jumpers = 0;
    out->ground = (float)(GROUND * lists->spacing);
    if (out->ground > GROUND_MAX)
        out->ground = 0;
    memset(out->cells, 0, sizeof out->cells);
    if (lists->knn == NULL)
        return 0;
    for (size_t i = 0; i < lists->n; i++) {
        double moved2 = vor_distance2f(&xyz[3 * i], &lists->anchor[3 * i]);

        if (moved2 <= limit2) {
            drift2 = moved2 > drift2 ? moved2 : drift2;
            continue;
        }
        if (out->jumpers == allowed)
            return 0;
        for (size_t c = 0; c < 3; c++)
            out->jumped[c][out->jumpers] = xyz[3 * i + c];
        out->jumper[out->jumpers++] = (uint32_t)i;
        mark(out, &xyz[3 * i]);
    }
    out->drift = sqrt(drift2);
    return 1;
}

/* A distance that all points except the jumpers and those of i's list have at least from where i is
 * now. */
static double sure_of(const struct vor_point_lists *lists, const struct vor_point_lists_view *view,
                      size_t i)
{
    double moved = sqrt(vor_distance2f(&view->xyz[3 * i], &lists->place[3 * i]));

    return (double)lists->reach[i] * ROUNDING - moved - view->drift;
}

static float distance2(const struct vor_point_lists_view *view, size_t i, size_t j)
{
    const float *a = &view->xyz[3 * i], *b = &view->xyz[3 * j];
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];

    return x * x + y * y + z * z;
}

/* Inserts j where its distance belongs among the first `at`. */
static void insert(struct vor_crowd *crowd, unsigned at, uint32_t j, float d2)
{
    for (; at > 0 && d2 < crowd->distance2[at - 1]; at--) {
        crowd->distance2[at] = crowd->distance2[at - 1];
        crowd->index[at] = crowd->index[at - 1];
    }
    crowd->distance2[at] = d2;
    crowd->index[at] = j;
}

/* Sorts the list by present distances. It stays sorted, because the order hardly changes until the
 * next question. */
static void sort_list(struct vor_crowd *out, struct vor_point_lists *lists,
                      const struct vor_point_lists_view *view, size_t i)
{
    uint32_t *list = &lists->list[i * lists->listed];
    float all2[VOR_LISTED_ROOM(VOR_POINT_LISTS_LISTED_MAX)];

    out->count = lists->listed;
    vor_listed_distances(all2, view->xyz, list, lists->listed, &view->xyz[3 * i]);
    for (unsigned j = 0; j < lists->listed; j++)
        insert(out, j, list[j], all2[j]);
    memcpy(list, out->index, lists->listed * sizeof *list);
    out->sure = sure_of(lists, view, i);
}

static int holds(const struct vor_crowd *crowd, uint32_t j)
{
    for (unsigned at = 0; at < crowd->count; at++)
        if (crowd->index[at] == j)
            return 1;
    return 0;
}

VOR_INLINE float jumper_distance2(const struct vor_point_lists_view *view, const float at[3],
                                  unsigned j)
{
    float x = view->jumped[0][j] - at[0], y = view->jumped[1][j] - at[1],
          z = view->jumped[2][j] - at[2];

    return x * x + y * y + z * z;
}

/* Whether a jumper, i included, is nearer to i than the limit. */
VOR_CLONES static int near_jumper(const struct vor_point_lists_view *view, size_t i, float limit2)
{
    const float *at = &view->xyz[3 * i];
    int found = 0;

    if (limit2 * 1.01f < view->ground * view->ground &&
        !((view->cells[64 * cell_of(at[0]) + cell_of(at[1])] >> cell_of(at[2])) & 1))
        return 0;
    for (unsigned j = 0; j < view->jumpers; j++)
        found |= jumper_distance2(view, at, j) <= limit2;
    return found;
}

/* Adds the jumpers that are nearer than what the crowd holds for certain. */
static void add_jumpers(struct vor_crowd *crowd, const struct vor_point_lists_view *view, size_t i)
{
    const float *at = &view->xyz[3 * i];
    double limit2 = crowd->sure < 0 ? INFINITY : crowd->sure * crowd->sure;

    if (view->jumpers == 0 || (crowd->sure >= 0 && !near_jumper(view, i, (float)limit2 * 1.001f)))
        return;
    for (unsigned j = 0; j < view->jumpers; j++) {
        float d2 = jumper_distance2(view, at, j);

        /* Farther jumpers may have nearer points, not listed, before them. */
        if ((double)d2 < limit2 && view->jumper[j] != i && !holds(crowd, view->jumper[j]))
            insert(crowd, crowd->count++, view->jumper[j], d2);
    }
}

/* Whether a list that holds all within `sure` has to be made anew, of which the sixth nearest is
 * that far. */
static int is_poor(double sure, float sixth2)
{
    return !(sure > 0 && sure * sure > COVERED * COVERED * (double)sixth2);
}

/* Whether that of point i has to be. As it is nearly sorted, its first six mostly tell. */
static int has_poor(const struct vor_point_lists *lists, const struct vor_point_lists_view *view,
                    size_t i)
{
    const uint32_t *list = &lists->list[i * lists->listed];
    double sure = sure_of(lists, view, i);
    float six2[6] = {0}, all2[VOR_LISTED_ROOM(VOR_POINT_LISTS_LISTED_MAX)];

    vor_listed_distances(all2, view->xyz, list, lists->listed, &view->xyz[3 * i]);
    for (unsigned j = 0; j < lists->listed; j++) {
        float d2 = all2[j];
        unsigned at = j < 6 ? j : 5;

        if (j == 6 && !is_poor(sure, six2[5]))
            return 0;
        if (j >= 6 && d2 >= six2[5])
            continue;
        for (; at > 0 && d2 < six2[at - 1]; at--)
            six2[at] = six2[at - 1];
        six2[at] = d2;
    }
    return is_poor(sure, six2[5]);
}

/* Makes lists anew of points near each other where they are, and moves their places there. */
static void make_anew(struct vor_point_lists *lists, const struct vor_point_lists_view *view,
                      const uint32_t *who, size_t count)
{
    uint32_t index[VOR_KNN_NEAR_MAX * (VOR_POINT_LISTS_LISTED_MAX + 1)];
    float found2[VOR_KNN_NEAR_MAX * (VOR_POINT_LISTS_LISTED_MAX + 1)];
    float query[3 * VOR_KNN_NEAR_MAX], within[VOR_KNN_NEAR_MAX];
    unsigned width = lists->listed + 1;
    struct vor_knn_near near = {query, count, width, within, 0};

    for (size_t i = 0; i < count; i++) {
        const float *at = &view->xyz[3 * (size_t)who[i]];
        float *place = &lists->place[3 * (size_t)who[i]];

        within[i] = lists->reach[who[i]] + sqrtf((float)vor_distance2f(place, at));
        memcpy(&query[3 * i], at, 3 * sizeof *at);
        memcpy(place, at, 3 * sizeof *at);
    }
    vor_knn_search_near(lists->knn, &near, index, found2);
    for (size_t i = 0; i < count; i++)
        make_list(lists, who[i], &index[i * width], &found2[i * width]);
}

unsigned vor_point_lists_renew(struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, const uint32_t *who,
                               size_t count)
{
    uint32_t poor[VOR_KNN_NEAR_MAX];
    unsigned some = 0, all = 0;

    for (size_t i = 0; i < count && lists->listed >= 6; i++) {
        if (has_poor(lists, view, who[i]) &&
            vor_distance2f(&lists->place[3 * (size_t)who[i]], &view->xyz[3 * (size_t)who[i]]) > 0)
            poor[some++] = who[i];
        if (some == VOR_KNN_NEAR_MAX || (some > 0 && i + 1 == count)) {
            make_anew(lists, view, poor, some);
            all += some;
            some = 0;
        }
    }
    return all;
}

unsigned vor_point_lists_crowd(struct vor_crowd *out, struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, size_t i)
{
    const uint32_t who = (uint32_t)i;
    unsigned searches = 0;

    sort_list(out, lists, view, i);
    if (out->count >= 6 && is_poor(out->sure, out->distance2[5]) &&
        vor_distance2f(&lists->place[3 * i], &view->xyz[3 * i]) > 0) {
        make_anew(lists, view, &who, 1);
        sort_list(out, lists, view, i);
        searches = 1;
    }
    add_jumpers(out, view, i);
    return searches;
}

unsigned vor_point_lists_within(struct vor_crowd *out, struct vor_point_lists *lists,
                                const struct vor_point_lists_view *view, size_t i, double distance)
{
    const uint32_t *list = &lists->list[i * lists->listed];
    float all2[VOR_LISTED_ROOM(VOR_POINT_LISTS_LISTED_MAX)];

    out->sure = sure_of(lists, view, i);
    if (out->sure < distance)
        return vor_point_lists_crowd(out, lists, view, i);
    out->sure = distance;
    out->count = 0;
    vor_listed_distances(all2, view->xyz, list, lists->listed, &view->xyz[3 * i]);
    for (unsigned j = 0; j < lists->listed; j++) {
        out->index[out->count] = list[j];
        out->distance2[out->count] = all2[j];
        out->count += (double)all2[j] < distance * distance;
    }
    add_jumpers(out, view, i);
    return 0;
}

const uint32_t *vor_point_lists_all(const struct vor_point_lists *lists,
                                    const struct vor_point_lists_view *view, size_t i,
                                    double distance)
{
    if (sure_of(lists, view, i) < distance ||
        (view->jumpers > 0 && near_jumper(view, i, (float)(distance * distance) * 1.001f)))
        return NULL;
    return &lists->list[i * lists->listed];
}

void vor_point_lists_candidates(struct vor_crowd *out, const struct vor_point_lists *lists,
                                const struct vor_point_lists_view *view, size_t i)
{
    out->sure = sure_of(lists, view, i);
    out->count = lists->listed;
    memcpy(out->index, &lists->list[i * lists->listed], lists->listed * sizeof *out->index);
    for (unsigned j = 0; j < view->jumpers; j++)
        if (view->jumper[j] != i)
            out->index[out->count++] = view->jumper[j];
}

double vor_point_lists_nearest(const struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, size_t i)
{
    const uint32_t *list = &lists->list[i * lists->listed];
    float best = INFINITY, all2[VOR_LISTED_ROOM(VOR_POINT_LISTS_LISTED_MAX)];
    double found;

    vor_listed_distances(all2, view->xyz, list, lists->listed, &view->xyz[3 * i]);
    if (lists->listed > 0)
        best = all2[vor_listed_first(all2, lists->listed)];
    if (view->jumpers > 0 && near_jumper(view, i, best))
        for (unsigned j = 0; j < view->jumpers; j++)
            if (view->jumper[j] != i) {
                float d2 = distance2(view, i, view->jumper[j]);

                best = d2 < best ? d2 : best;
            }
    found = sqrt((double)best);
    return found <= sure_of(lists, view, i) ? found : -1;
}

double vor_point_lists_wide(const struct vor_point_lists *lists,
                            const struct vor_point_lists_view *view, size_t i, unsigned width,
                            uint32_t *index, float *found2)
{
    vor_knn_search(lists->knn, &view->xyz[3 * i], 1, width, index, found2);
    if (width == lists->n)
        return INFINITY;
    return sqrt((double)found2[width - 1]) * ROUNDING - view->drift;
}
