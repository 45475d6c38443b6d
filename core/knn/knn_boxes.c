/* A tree of boxes, 8 wide (Wald, Benthin, Boulos 2008, "Getting rid of packets", for rays), over
 * points along the Morton curve. A range of points is cut where the highest bit of its codes
 * changes, the largest part first, until there are 8 parts or none has more than 8 points. So boxes
 * hardly overlap. Also tried: cutting at every 8th, 64th ... point, which needs no codes and is
 * built in a sixth of the time, but makes queries seven times as slow. VOR_CLONES saves a third of
 * a search.
 *
 * The distance to a box is computed by the same operations as that to a point in it, and rounding
 * preserves order: it is never larger, so the answers are exact. Where codes offer no cut
 * (coincident points, points in another order), the range is cut in the middle: worse boxes, the
 * same answers. */
#include "core/knn/knn_boxes.h"

#include "core/base/morton.h"
#include "core/knn/knn_tree.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    LANES = VOR_BOXES_LANES,
    CODED_LEVELS = 64, /* deeper, all codes of a range are equal: they have 63 bits */
    LEVELS_MAX = CODED_LEVELS + 32,
    STACK_MAX = LEVELS_MAX * LANES,
    SUBTREE = 1 << 14, /* points whose nodes one task makes */
    PADDING = 2        /* units behind the last node: LANES may be read from its last row */
};

/* Points begin .. end - 1, to become a node that is `level` below the root. */
struct range {
    size_t begin, end;
    unsigned level;
};

/* A range of at most SUBTREE points whose parent has more: one task makes its nodes. */
struct subtree {
    struct range range;
    size_t first, units; /* its nodes in the tree, the root first */
    unsigned char kind;  /* of the root */
};

struct build {
    struct vor_boxes *boxes;
    const struct vor_run *run;
    const float *xyz;
    size_t n;
    uint64_t *code;
    struct subtree *subtree; /* in the order of their points */
    size_t subtrees;
};

/* Where the next nodes go. When the nodes above the subtrees are made, the subtrees exist already
 * and are attached in turn. */
struct cursor {
    size_t unit;
    const struct subtree *subtree; /* the next one; NULL inside a subtree */
};

/* The first point of the second part when a range of at least two points is cut. */
static size_t cut(const uint64_t *code, struct range range)
{
    size_t low = range.begin, high = range.end - 1;
    uint64_t first = code[low], last = code[high], bit;

    if (first >= last || range.level >= CODED_LEVELS)
        return low + (range.end - low) / 2;
    bit = UINT64_C(1) << (63 - __builtin_clzll(first ^ last));
    last &= ~(bit - 1);
    while (high - low > 1) { /* code[low] < last <= code[high], in any order of the points */
        size_t middle = low + (high - low) / 2;

        if (code[middle] < last)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* Cuts a range into the children of a node: child j is at[j] .. at[j + 1] - 1. Returns how many. */
static unsigned divide(size_t at[LANES + 1], const uint64_t *code, struct range range)
{
    unsigned parts = 1;

    at[0] = range.begin;
    at[1] = range.end;
    while (parts < LANES) {
        unsigned fullest = 0;
        size_t middle;

        for (unsigned j = 1; j < parts; j++)
            fullest = at[j + 1] - at[j] > at[fullest + 1] - at[fullest] ? j : fullest;
        if (at[fullest + 1] - at[fullest] <= LANES)
            break;
        middle = cut(code, (struct range){at[fullest], at[fullest + 1], range.level});
        memmove(&at[fullest + 2], &at[fullest + 1], (parts - fullest) * sizeof *at);
        at[fullest + 1] = middle;
        parts++;
    }
    return parts;
}

static size_t units_of(unsigned lanes)
{
    return (lanes * (size_t)VOR_BOXES_LANE + VOR_BOXES_UNIT - 1) / VOR_BOXES_UNIT;
}

/* Counts the units of the nodes of a range, without parts of at most `least` points. */
static size_t count_units(const uint64_t *code, struct range range, size_t least)
{
    size_t at[LANES + 1];
    unsigned parts = divide(at, code, range);
    size_t units = units_of(parts);

    for (unsigned j = 0; j < parts; j++)
        if (at[j + 1] - at[j] > least)
            units += count_units(code, (struct range){at[j], at[j + 1], range.level + 1}, least);
    return units;
}

/* Counts the subtrees of a range larger than SUBTREE, and lists them if build->subtree has memory.
 */
static void list_subtrees(struct build *build, struct range range)
{
    size_t at[LANES + 1];
    unsigned parts = divide(at, build->code, range);

    for (unsigned j = 0; j < parts; j++) {
        struct range part = {at[j], at[j + 1], range.level + 1};

        if (part.end - part.begin > SUBTREE) {
            list_subtrees(build, part);
        } else if (part.end - part.begin > LANES) {
            if (build->subtree != NULL)
                build->subtree[build->subtrees].range = part;
            build->subtrees++;
        }
    }
}

static void count_subtrees(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct build *build = ctx;

    for (size_t i = begin; i < end; i++)
        build->subtree[i].units = count_units(build->code, build->subtree[i].range, LANES);
}

static void make_leaf(const struct build *build, const struct vor_boxes_node *node, unsigned lane,
                      size_t begin, size_t end)
{
    const float *xyz = &build->xyz[3 * begin];
    size_t n = end - begin;

    for (size_t c = 0; c < 3; c++) {
        float low = xyz[c], high = low;

        for (size_t i = 0; i < n; i++) {
            float x = xyz[3 * i + c];

            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        node->low[c * node->lanes + lane] = low;
        node->high[c * node->lanes + lane] = high;
    }
    node->child[lane] = (uint32_t)begin;
    node->kind[lane] = (unsigned char)n;
}

/* Makes the box of a node a lane of its parent. */
static void hang(const struct vor_boxes *boxes, const struct vor_boxes_node *node, size_t lane,
                 size_t at, unsigned char kind)
{
    struct vor_boxes_node below = vor_boxes_node_at(boxes, at, kind);

    for (size_t c = 0; c < 3; c++) {
        const float *lows = below.low + c * below.lanes, *highs = below.high + c * below.lanes;
        float low = lows[0], high = highs[0];

        for (size_t j = 1; j < below.lanes; j++) {
            low = lows[j] < low ? lows[j] : low;
            high = highs[j] > high ? highs[j] : high;
        }
        node->low[c * node->lanes + lane] = low;
        node->high[c * node->lanes + lane] = high;
    }
    node->child[lane] = (uint32_t)at;
    node->kind[lane] = kind;
}

/* Makes the node of a range at the cursor, and those below it behind it. Returns its kind. */
static unsigned char make_node(const struct build *build, struct range range, struct cursor *next)
{
    const struct vor_boxes *boxes = build->boxes;
    size_t part[LANES + 1];
    unsigned parts = divide(part, build->code, range);
    unsigned char kind = (unsigned char)(LANES + parts);
    struct vor_boxes_node node = vor_boxes_node_at(boxes, next->unit, kind);

    assert(range.level < LEVELS_MAX);
    next->unit += units_of(parts);
    for (unsigned j = 0; j < parts; j++) {
        size_t n = part[j + 1] - part[j];

        if (n <= LANES) {
            make_leaf(build, &node, j, part[j], part[j + 1]);
        } else if (next->subtree != NULL && n <= SUBTREE) {
            hang(boxes, &node, j, next->subtree->first, next->subtree->kind);
            next->subtree++;
        } else {
            size_t child = next->unit;
            struct range below = {part[j], part[j + 1], range.level + 1};

            hang(boxes, &node, j, child, make_node(build, below, next));
        }
    }
    return kind;
}

static void make_subtrees(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct build *build = ctx;

    for (size_t i = begin; i < end; i++) {
        struct subtree *subtree = &build->subtree[i];
        struct cursor next = {subtree->first, NULL};

        subtree->kind = make_node(build, subtree->range, &next);
        assert(next.unit == subtree->first + subtree->units);
    }
}

/* Finds the subtrees, and their places after the nodes above them. */
static vor_status plan(struct build *build, size_t *units, struct vor_error *err)
{
    struct range all = {0, build->n, 0};
    vor_status status = vor_morton_codes(build->code, build->xyz, build->n, build->run, err);

    if (status != VOR_OK)
        return status;
    list_subtrees(build, all);
    build->subtree = vor_malloc(build->run->memory, build->subtrees, sizeof *build->subtree);
    if (build->subtree == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", build->n);
    build->subtrees = 0;
    list_subtrees(build, all);
    status = vor_run_for(build->run, build->subtrees, 1, count_subtrees, build, err);
    *units = count_units(build->code, all, SUBTREE);
    for (size_t i = 0; status == VOR_OK && i < build->subtrees; i++) {
        build->subtree[i].first = *units;
        *units += build->subtree[i].units;
    }
    return status;
}

static vor_status make_tree(struct build *build, struct vor_error *err)
{
    struct vor_boxes *boxes = build->boxes;
    struct cursor next = {.unit = 0};
    vor_status status = plan(build, &boxes->units, err);

    if (status != VOR_OK)
        return status;
    boxes->node = vor_malloc(boxes->memory, boxes->units + PADDING, VOR_BOXES_UNIT);
    if (boxes->node == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", build->n);
    memset(boxes->node + VOR_BOXES_UNIT * boxes->units, 0, (size_t)PADDING * VOR_BOXES_UNIT);
    status = vor_run_for(build->run, build->subtrees, 1, make_subtrees, build, err);
    if (status != VOR_OK)
        return status;
    next.subtree = build->subtree;
    boxes->root = make_node(build, (struct range){0, build->n, 0}, &next);
    return VOR_OK;
}

vor_status vor_boxes_build(struct vor_boxes **out, const float *xyz, size_t n,
                           const struct vor_run *run, struct vor_error *err)
{
    struct build build = {.run = run, .xyz = xyz, .n = n};
    vor_status status;

    if (VOR_MAKE_ALL(run->memory, err, n, VOR_ZEROED(build.boxes, 1, 1),
                     VOR_ARRAY(build.code, n, 1)) != VOR_OK) {
        VOR_FREE_ALL(run->memory, build.boxes, build.code);
        return VOR_E_NOMEM;
    }
    build.boxes->memory = run->memory;
    build.boxes->n = n;
    build.boxes->xyz = xyz;
    for (size_t i = n > LANES ? n - LANES : 0; i < n; i++)
        memcpy(&build.boxes->tail[3 * (i + LANES - n)], &xyz[3 * i], 3 * sizeof *xyz);
    status = make_tree(&build, err);
    VOR_FREE_ALL(run->memory, build.subtree, build.code);
    if (status == VOR_OK)
        *out = build.boxes;
    else
        vor_boxes_free(build.boxes);
    return status;
}

void vor_boxes_free(struct vor_boxes *boxes)
{
    if (boxes == NULL)
        return;
    VOR_FREE_ALL(boxes->memory, boxes->node, boxes);
}

/* A box that may hold a nearer point: of a node or of a leaf, by `kind`. */
struct visit {
    float distance2;
    uint32_t at, kind;
};

/* The k nearest so far. */
struct found {
    uint32_t *index;
    float *distance2;
    unsigned count, k;
    float worst; /* squared distance that a point must be nearer than */
};

/* From so many nearest points on, the place of another one is found by halves, and those behind it
 * are moved at once. 500 of 20,000 points of a random sphere take 67 us one by one, 47 us so, 150
 * 10.8 and 11.4; with WIDE at 32 or 64, 150 take 12.3. */
enum { WIDE = 128 };

/* Up to WIDE nearest points so far, sorted, behind an infinitely near one and before infinitely far
 * ones. */
struct kept {
    float distance2[1 + WIDE + LANES];
    uint32_t index[1 + WIDE + LANES];
};

/* Inserts a point among `count` that are sorted, behind those that are as far: lanes from the last
 * to its place become the point before theirs, or this one. */
VOR_INLINE void insert_kept(struct kept *kept, unsigned count, uint32_t i, float d2)
{
    const vor_lanes this2 = d2 - (vor_lanes){0};
    const vor_marks this = (int32_t)i - (vor_marks){0};

    for (unsigned at = count / LANES * LANES;; at -= LANES) {
        vor_lanes_at *to2 = (vor_lanes_at *)&kept->distance2[1 + at];
        vor_marks_at *to = (vor_marks_at *)&kept->index[1 + at];
        vor_lanes before2 = *(const vor_lanes_at *)&kept->distance2[at];
        vor_marks before = *(const vor_marks_at *)&kept->index[at];
        vor_marks stays = *to2 <= this2, follows = before2 <= this2;
        float first2 = kept->distance2[at];

        before = (this & follows) | (before & ~follows);
        *to = (*to & stays) | (before & ~stays);
        before = ((vor_marks)this2 & follows) | ((vor_marks)before2 & ~follows);
        *to2 = (vor_lanes)(((vor_marks)*to2 & stays) | (before & ~stays));
        if (first2 <= d2)
            return;
    }
}

/* Makes room at the place of a distance among `count` that are sorted; behind those that are equal.
 * Returns it. */
VOR_INLINE unsigned make_room(struct found *found, unsigned count, float distance2)
{
    unsigned low = 0, high = count;

    while (low < high) {
        unsigned middle = (low + high) / 2;

        if (distance2 < found->distance2[middle])
            high = middle;
        else
            low = middle + 1;
    }
    memmove(&found->distance2[low + 1], &found->distance2[low], (count - low) * sizeof distance2);
    memmove(&found->index[low + 1], &found->index[low], (count - low) * sizeof *found->index);
    return low;
}

VOR_INLINE void insert(struct found *found, struct kept *kept, uint32_t i, float distance2)
{
    unsigned at = found->count < found->k ? found->count++ : found->k - 1;

    if (found->k > WIDE) {
        at = make_room(found, at, distance2);
        found->distance2[at] = distance2;
        found->index[at] = i;
    } else
        insert_kept(kept, at, i, distance2);
    if (found->count == found->k)
        found->worst = found->k > WIDE ? found->distance2[found->k - 1] : kept->distance2[found->k];
}

/* Lists those of the first n lanes that are nearer than worst, without a branch for each. Returns
 * how many. */
VOR_INLINE unsigned nearer(unsigned lane[LANES], const float distance2[LANES], unsigned n,
                           float worst)
{
    unsigned count = 0;

    for (unsigned j = 0; j < n; j++) {
        lane[count] = j;
        count += distance2[j] < worst;
    }
    return count;
}

VOR_INLINE void search_leaf(struct found *found, struct kept *kept, const struct vor_boxes *boxes,
                            struct visit visit, const float q[3])
{
    const float *xyz = vor_boxes_leaf(boxes, visit.at);
    float distance2[LANES];
    unsigned lane[LANES], count;

    for (size_t j = 0; j < LANES; j++) { /* results beyond the leaf are not used */
        float x = xyz[3 * j] - q[0], y = xyz[3 * j + 1] - q[1], z = xyz[3 * j + 2] - q[2];

        distance2[j] = x * x + y * y + z * z;
    }
    count = nearer(lane, distance2, visit.kind, found->worst);
    for (unsigned i = 0; i < count; i++)
        if (distance2[lane[i]] < found->worst)
            insert(found, kept, visit.at + lane[i], distance2[lane[i]]);
}

/* Pushes the boxes of a node that may hold a nearer point on the stack, the nearest on top. Returns
 * how many. */
VOR_INLINE unsigned open_node(struct visit *stack, const struct vor_boxes_node *node,
                              const float q[3], float worst)
{
    float distance2[LANES];
    unsigned lane[LANES] = {0}, count;

    vor_boxes_distances(distance2, node->low, node->high, node->lanes, q, q);
    count = nearer(lane, distance2, node->lanes, worst);
    for (unsigned i = 0; i < count; i++) {
        unsigned j = lane[i], at = i;

        for (; at > 0 && stack[at - 1].distance2 < distance2[j]; at--)
            stack[at] = stack[at - 1];
        stack[at] = (struct visit){distance2[j], node->child[j], node->kind[j]};
    }
    return count;
}

/* Finds the k nearest of those within a squared distance. Returns how many there are. */
VOR_CLONES static unsigned search(const struct vor_boxes *boxes, const float query[3],
                                  struct found found)
{
    struct visit stack[STACK_MAX];
    unsigned high = 1, some = found.k > WIDE ? 0 : found.k;
    struct kept kept;

    kept.distance2[0] = -INFINITY;
    for (unsigned at = 0; at <= some; at += LANES)
        *(vor_lanes_at *)&kept.distance2[1 + at] = INFINITY - (vor_lanes){0};
    stack[0] = (struct visit){0, 0, boxes->root};
    while (high > 0) {
        struct visit visit = stack[--high];

        if (visit.distance2 >= found.worst)
            continue;
        if (visit.kind <= LANES) {
            search_leaf(&found, &kept, boxes, visit, query);
        } else {
            struct vor_boxes_node node = vor_boxes_node_at(boxes, visit.at, visit.kind);

            high += open_node(&stack[high], &node, query, found.worst);
        }
    }
    memcpy(found.distance2, &kept.distance2[1], some * sizeof *found.distance2);
    memcpy(found.index, &kept.index[1], some * sizeof *found.index);
    return found.count;
}

void vor_boxes_search(const struct vor_boxes *boxes, const float query[3], unsigned k, float within,
                      uint32_t *index, float *distance2)
{
    struct found found = {index, distance2, 0, k, vor_boxes_wider(within)};

    if (search(boxes, query, found) == k)
        return;
    found.worst = INFINITY;
    (void)search(boxes, query, found);
}
