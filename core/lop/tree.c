#include "core/lop/tree.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    /* Times that the cube is halved at most: to a step of a float near 1. */
    DEPTH_MAX = FLT_MANT_DIG,
    OCTANTS = 8,
    /* Nodes that wait while the tree is walked: seven on each level, and the eight of the last. */
    WAITING_MAX = 7 * DEPTH_MAX + OCTANTS + 1,
    ROOM_FIRST = 64
};

/* What a node holds: nothing, a leaf (this bit and its number), or the number of eight nodes. */
#define EMPTY 0U
#define LEAF 0x80000000U
#define NO_LEAF UINT32_MAX
/* Coordinate of lanes that hold no point. */
#define NOWHERE 1e15F
struct vor_lop_leaf {
    uint32_t count;
    uint32_t next; /* more points of a cell that cannot be split; NO_LEAF */
    uint32_t index[VOR_LOP_LANES];
    float xyz[3][VOR_LOP_LANES], normal[3][VOR_LOP_LANES];
};

/* A cell of the cube. */
struct cell {
    uint32_t node; /* what its node holds */
    double half;   /* of its side */
    double middle[3];
};

static vor_status grow(void **array, size_t *room, size_t size, size_t want,
                       struct vor_memory *memory, struct vor_error *err)
{
    size_t wanted = want > 2 * *room ? want : 2 * *room;
    void *more;

    if (want <= *room)
        return VOR_OK;
    more = wanted < LEAF ? vor_realloc(memory, *array, wanted, size) : NULL;
    if (more == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", want);
    *array = more;
    *room = wanted;
    return VOR_OK;
}

static vor_status room_for(struct vor_lop_tree *tree, size_t nodes, size_t leaves,
                           struct vor_error *err)
{
    void *node = tree->node, *leaf = tree->leaf;
    vor_status status =
        grow(&node, &tree->room_nodes, sizeof *tree->node, tree->nodes + nodes, tree->memory, err);

    tree->node = node;
    VOR_THEN(status, grow(&leaf, &tree->room_leaves, sizeof *tree->leaf, tree->leaves + leaves,
                          tree->memory, err));
    tree->leaf = leaf;
    return status;
}

vor_status vor_lop_tree_init(struct vor_lop_tree *out, struct vor_memory *memory,
                             struct vor_error *err)
{
    vor_status status;

    *out = (struct vor_lop_tree){.memory = memory};
    status = room_for(out, ROOM_FIRST, ROOM_FIRST, err);
    if (status != VOR_OK)
        return status;
    while (out->nodes < OCTANTS)
        out->node[out->nodes++] = 0;
    return VOR_OK;
}

void vor_lop_tree_free(struct vor_lop_tree *tree)
{
    VOR_FREE_ALL(tree->memory, tree->leaf, tree->node);
    *tree = (struct vor_lop_tree){0};
}

/* The eighth of a cell that a point lies in. */
static unsigned octant_of(const double middle[3], const float x[3])
{
    return (unsigned)((double)x[0] >= middle[0]) | (unsigned)((double)x[1] >= middle[1]) << 1 |
           (unsigned)((double)x[2] >= middle[2]) << 2;
}

/* Moves to the middle of an eighth, `quarter` of the cell's side away along each axis. */
VOR_INLINE void to_octant(double middle[3], unsigned octant, double quarter)
{
    for (int c = 0; c < 3; c++)
        middle[c] += octant >> c & 1 ? quarter : -quarter;
}

static uint32_t new_leaf(struct vor_lop_tree *tree)
{
    struct vor_lop_leaf *leaf = &tree->leaf[tree->leaves];

    leaf->count = 0;
    leaf->next = NO_LEAF;
    for (unsigned lane = 0; lane < VOR_LOP_LANES; lane++) {
        leaf->index[lane] = 0;
        for (int c = 0; c < 3; c++) {
            leaf->xyz[c][lane] = NOWHERE;
            leaf->normal[c][lane] = 0;
        }
    }
    return (uint32_t)tree->leaves++;
}

static void put(struct vor_lop_leaf *leaf, uint32_t index, const float xyz[3],
                const float normal[3])
{
    leaf->index[leaf->count] = index;
    for (int c = 0; c < 3; c++) {
        leaf->xyz[c][leaf->count] = xyz[c];
        leaf->normal[c][leaf->count] = normal[c];
    }
    leaf->count++;
}

/* Makes the full leaf in `node` eight cells, with the points in leaves of those. */
static void split(struct vor_lop_tree *tree, size_t node, const double middle[3])
{
    struct vor_lop_leaf old = tree->leaf[tree->node[node] & ~LEAF];
    uint32_t spare = tree->node[node] & ~LEAF, *child = &tree->node[tree->nodes];

    memset(child, 0, OCTANTS * sizeof *child);
    tree->node[node] = (uint32_t)(tree->nodes / OCTANTS);
    tree->nodes += OCTANTS;
    for (unsigned lane = 0; lane < VOR_LOP_LANES; lane++) {
        float x[3] = {old.xyz[0][lane], old.xyz[1][lane], old.xyz[2][lane]};
        float normal[3] = {old.normal[0][lane], old.normal[1][lane], old.normal[2][lane]};
        unsigned octant = octant_of(middle, x);

        if (child[octant] == EMPTY && spare != NO_LEAF) { /* the old leaf serves again */
            size_t end = tree->leaves;

            tree->leaves = spare;
            child[octant] = LEAF | new_leaf(tree);
            tree->leaves = end;
            spare = NO_LEAF;
        } else if (child[octant] == EMPTY) {
            child[octant] = LEAF | new_leaf(tree);
        }
        put(&tree->leaf[child[octant] & ~LEAF], old.index[lane], x, normal);
    }
}

/* The leaf with room for one more point of a cell that cannot be split. */
static struct vor_lop_leaf *last_of(struct vor_lop_tree *tree, uint32_t leaf)
{
    while (tree->leaf[leaf].count == VOR_LOP_LANES) {
        if (tree->leaf[leaf].next == NO_LEAF) {
            uint32_t more = new_leaf(tree);

            tree->leaf[leaf].next = more;
        }
        leaf = tree->leaf[leaf].next;
    }
    return &tree->leaf[leaf];
}

vor_status vor_lop_tree_add(struct vor_lop_tree *tree, uint32_t index, const float xyz[3],
                            const float normal[3], struct vor_error *err)
{
    double middle[3] = {0}, half = 1;
    size_t node;
    unsigned depth = 1;
    vor_status status =
        room_for(tree, (size_t)DEPTH_MAX * OCTANTS, (size_t)DEPTH_MAX * OCTANTS, err);

    if (status != VOR_OK)
        return status;
    node = octant_of(middle, xyz);
    for (;; depth++) {
        to_octant(middle, (unsigned)(node % OCTANTS), half / 2);
        half /= 2;
        if (tree->node[node] == EMPTY)
            tree->node[node] = LEAF | new_leaf(tree);
        if (tree->node[node] & LEAF) {
            if (depth == DEPTH_MAX || tree->leaf[tree->node[node] & ~LEAF].count < VOR_LOP_LANES)
                break;
            split(tree, node, middle);
        }
        node = (size_t)tree->node[node] * OCTANTS + octant_of(middle, xyz);
    }
    put(last_of(tree, tree->node[node] & ~LEAF), index, xyz, normal);
    return VOR_OK;
}

vor_status vor_lop_tree_build(struct vor_lop_tree *out, const struct vor_lop_samples *samples,
                              const struct vor_run *run, struct vor_error *err)
{
    vor_status status = vor_lop_tree_init(out, samples->memory, err);

    for (size_t i = 0; i < samples->n && status == VOR_OK; i++) {
        if (i % VOR_LOP_POLL_EVERY == 0)
            status = vor_run_answered(vor_run_poll(run), err);
        VOR_THEN(status, vor_lop_tree_add(out, (uint32_t)i, &samples->xyz[3 * i],
                                          &samples->normal[3 * i], err));
    }
    return status;
}

/* A walk over the leaves whose cells come within a radius of a place. */
struct walk {
    const struct vor_lop_tree *tree;
    double low[3], high[3];
    unsigned waiting;
    struct cell cell[WAITING_MAX];
};

/* The eighths of a cell that the walk is about, a bit each. */
VOR_INLINE unsigned touched(const struct walk *walk, const double middle[3])
{
    static const unsigned lower[3] = {0x55, 0x33, 0x0F};
    unsigned all = 0xFF;

    for (int c = 0; c < 3; c++) {
        all &= walk->high[c] < middle[c] ? lower[c] : 0xFF;
        all &= walk->low[c] >= middle[c] ? ~lower[c] : 0xFF;
    }
    return all;
}

/* Lets the eighths of a split cell wait that the walk is about. */
VOR_INLINE void enter(struct walk *walk, const uint32_t *child, double half, const double middle[3])
{
    for (unsigned left = touched(walk, middle); left != 0; left &= left - 1) {
        unsigned octant = (unsigned)__builtin_ctz(left);
        struct cell *cell = &walk->cell[walk->waiting];

        if (child[octant] == EMPTY)
            continue;
        cell->node = child[octant];
        cell->half = half / 2;
        for (int c = 0; c < 3; c++)
            cell->middle[c] = middle[c];
        to_octant(cell->middle, octant, half / 2);
        walk->waiting++;
    }
}

/* Begins where more than one eighth is touched. */
VOR_INLINE void begin(struct walk *walk, const struct vor_lop_tree *tree, const float x[3],
                      double radius)
{
    /* Wider by what distances in float are rounded. */
    double wide = radius * (1 + VOR_ROUNDED) + VOR_ROUNDED2, middle[3] = {0}, half = 1;
    const uint32_t *child = tree->node;

    walk->tree = tree;
    walk->waiting = 0;
    for (int c = 0; c < 3; c++) {
        walk->low[c] = (double)x[c] - wide;
        walk->high[c] = (double)x[c] + wide;
    }
    for (;;) {
        unsigned all = touched(walk, middle), octant = (unsigned)__builtin_ctz(all);

        if ((all & (all - 1)) != 0 || child[octant] == EMPTY || (child[octant] & LEAF))
            break;
        half /= 2;
        to_octant(middle, octant, half);
        child = &tree->node[(size_t)child[octant] * OCTANTS];
    }
    enter(walk, child, half, middle);
}

/* The next leaf, or NULL. */
VOR_INLINE const struct vor_lop_leaf *next(struct walk *walk)
{
    while (walk->waiting > 0) {
        struct cell cell = walk->cell[--walk->waiting];

        if (cell.node & LEAF)
            return &walk->tree->leaf[cell.node & ~LEAF];
        enter(walk, &walk->tree->node[(size_t)cell.node * OCTANTS], cell.half, cell.middle);
    }
    return NULL;
}

/* The same for what follows a leaf that could not be split. */
VOR_INLINE const struct vor_lop_leaf *follow(struct walk *walk, const struct vor_lop_leaf *leaf)
{
    return leaf->next != NO_LEAF ? &walk->tree->leaf[leaf->next] : next(walk);
}

/* Squares of the distances from x to the points of a leaf; huge where a lane holds none. */
VOR_INLINE void distances2(float *restrict d2, const struct vor_lop_leaf *leaf, const float x[3])
{
    float x0 = x[0], x1 = x[1], x2 = x[2];

    for (unsigned lane = 0; lane < VOR_LOP_LANES; lane++) {
        float dx = x0 - leaf->xyz[0][lane], dy = x1 - leaf->xyz[1][lane],
              dz = x2 - leaf->xyz[2][lane];

        d2[lane] = dx * dx + dy * dy + dz * dz;
    }
}

VOR_INLINE void gather_leaf(struct vor_lop_gathered *out, const struct vor_lop_leaf *leaf,
                            const float x[3], float radius2)
{
    float d2[VOR_LOP_LANES];
    unsigned inside[VOR_LOP_LANES], count = 0, at = out->count;

    distances2(d2, leaf, x);
    for (unsigned lane = 0; lane < VOR_LOP_LANES; lane++) { /* without branches */
        inside[count] = lane;
        count += (lane < leaf->count) & (d2[lane] <= radius2);
    }
    for (unsigned i = 0; i < count && at < VOR_LOP_GATHERED_MAX; i++, at++) {
        unsigned lane = inside[i];

        out->index[at] = leaf->index[lane];
        out->distance2[at] = d2[lane];
        for (int c = 0; c < 3; c++) {
            out->xyz[c][at] = leaf->xyz[c][lane];
            out->normal[c][at] = leaf->normal[c][lane];
        }
    }
    out->count = at;
}

VOR_CLONES void vor_lop_tree_gather(struct vor_lop_gathered *out, const struct vor_lop_tree *tree,
                                    const float x[3], double radius)
{
    struct walk walk;

    out->count = 0;
    begin(&walk, tree, x, radius);
    for (const struct vor_lop_leaf *leaf = next(&walk); leaf != NULL; leaf = follow(&walk, leaf))
        gather_leaf(out, leaf, x, (float)(radius * radius));
}

/* Lowers least[lane] to the square of the distance from a base to the line through the point in the
 * lane, along its normal, for the points of `lanes` lanes that count. */
VOR_INLINE void to_lines2(float *restrict least, const struct vor_lop_base *base,
                          const float *const xyz[3], const float *const normal[3], unsigned lanes)
{
    float x = base->xyz[0], y = base->xyz[1], z = base->xyz[2], radius2 = (float)base->radius2;
    float ax = base->end[0][0], ay = base->end[0][1], az = base->end[0][2];
    float bx = base->end[1][0], by = base->end[1][1], bz = base->end[1][2];

    for (unsigned lane = 0; lane < lanes; lane++) {
        float dx = x - xyz[0][lane], dy = y - xyz[1][lane], dz = z - xyz[2][lane];
        float nx = normal[0][lane], ny = normal[1][lane], nz = normal[2][lane];
        float d2 = dx * dx + dy * dy + dz * dz, along = nx * dx + ny * dy + nz * dz;
        float a = nx * ax + ny * ay + nz * az, b = nx * bx + ny * by + nz * bz;
        float off2 = d2 - along * along, facing = a > b ? a : b;

        off2 = off2 > 0 ? off2 : 0;
        off2 = d2 <= radius2 ? off2 : INFINITY;
        off2 = facing >= (float)-VOR_SAME_WAY ? off2 : INFINITY;
        least[lane] = off2 < least[lane] ? off2 : least[lane];
    }
}

/* The smallest of the lanes. */
VOR_INLINE double least_of(const float least[VOR_LOP_LANES])
{
    float all = least[0];

    for (unsigned lane = 1; lane < VOR_LOP_LANES; lane++)
        all = least[lane] < all ? least[lane] : all;
    return (double)all;
}

VOR_CLONES double vor_lop_tree_clearance2(const struct vor_lop_tree *tree,
                                          const struct vor_lop_base *base, double most)
{
    float least[VOR_LOP_LANES];
    struct walk walk;

    for (unsigned lane = 0; lane < VOR_LOP_LANES; lane++)
        least[lane] = (float)most;
    begin(&walk, tree, base->xyz, sqrt(base->radius2));
    for (const struct vor_lop_leaf *leaf = next(&walk); leaf != NULL; leaf = follow(&walk, leaf)) {
        const float *xyz[3] = {leaf->xyz[0], leaf->xyz[1], leaf->xyz[2]};
        const float *normal[3] = {leaf->normal[0], leaf->normal[1], leaf->normal[2]};

        to_lines2(least, base, xyz, normal, VOR_LOP_LANES);
    }
    return least_of(least);
}

VOR_CLONES double vor_lop_gathered_clearance2(const struct vor_lop_gathered *gathered,
                                              const struct vor_lop_base *base, double most)
{
    float least[VOR_LOP_LANES];

    for (unsigned lane = 0; lane < VOR_LOP_LANES; lane++)
        least[lane] = (float)most;
    for (unsigned i = 0; i < gathered->count; i += VOR_LOP_LANES) {
        const float *xyz[3] = {&gathered->xyz[0][i], &gathered->xyz[1][i], &gathered->xyz[2][i]};
        const float *normal[3] = {&gathered->normal[0][i], &gathered->normal[1][i],
                                  &gathered->normal[2][i]};
        unsigned left = gathered->count - i;

        if (left >= VOR_LOP_LANES)
            to_lines2(least, base, xyz, normal, VOR_LOP_LANES);
        else
            to_lines2(least, base, xyz, normal, left);
    }
    return least_of(least);
}
