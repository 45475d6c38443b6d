#include "core/output/order.h"

#include "core/base/heap.h"
#include "core/base/linalg.h"
#include "core/knn/knn.h"

#include <math.h>
#include <string.h>

/* Points are chosen in rounds. Those of a round are at least that far from all before them: a step
 * of the ladder LAST * spacing / NEARLY^k, the highest below MARGIN of the farthest. Figures are
 * delta of the first tenth, quarter, half and seven tenths of 6,000 points on igea, at a lower, the
 * chosen and a higher value; other seeds move the first by 7 %, the others by 1 %. */

/* At 0.7 / 0.85 / 0.93: 0.146, 0.231, 0.015, 0.013 / 0.097, 0.161, 0.016, 0.014 / 0.090, 0.168,
 * 0.077, 0.016. */
#define NEARLY 0.85
/* At 0.85 / 0.95 / 1: quarter 0.174 / 0.161 / 0.174, half 0.044 / 0.016 / 0.044. */
#define LAST 0.95
/* At 0.9 / 0.98 / 1: quarter 0.173 / 0.161 / 0.164, half 0.017 / 0.016 / 0.016. */
#define MARGIN 0.98

/* Times a round's distance: that at which nearest neighbours should be. At 1.03 / 1.07 / 1.2:
 * quarter 0.158 / 0.161 / 0.177, half 0.019 / 0.016 / 0.049. */
#define WANTED 1.07
/* Times a round's distance: a nearest neighbour farther than that is no worse. At 1.5 / 2 / 4:
 * quarter 0.171 / 0.161 / 0.164; beyond 2 a choice looks at more points for nothing. */
#define BEYOND 2.0

enum {
    /* The next points are chosen from a pool, every stride-th point, which has so many for each one
     * chosen. 16 and 64 change no figure. */
    CHOICE = 32,
    /* Factor by which the pool grows. 2 and 16 change no figure. */
    GROWS = 4,
    /* Points of the first pool at least. At 1024 / 4096 / 16384: quarter 0.169 / 0.161 / 0.164. */
    POOL_LEAST = 4096
};

/* Points of one task: rated or looked up; chosen. */
enum { BLOCK = 1024, TURN = 4096 };

/* Most chosen points that have the next one as their nearest: a point is the nearest of six others
 * at most in the plane, of twelve in space. */
enum { TOLD_MAX = 16 };

/* Cubes beyond that number, from the origin, are one: a double tells those before apart. */
#define CUBES 0x1p52

/* Places of points that are not in the heap: not chosen yet, or chosen. */
#define WAITS VOR_HEAP_WAITS
#define CHOSEN VOR_HEAP_DONE

/* Points by cubes of space, hashed. Those of bucket b are item[start[b]] .. item[start[b + 1] - 1].
 */
struct grid {
    double per_side; /* 1 / side */
    size_t buckets;  /* a power of two */
    uint32_t *start, *item;
};

struct order {
    const float *xyz;
    size_t n;
    const struct vor_run *run;
    uint32_t *out; /* the count points chosen so far */
    size_t count, stride;
    double spacing;
    float *reach;         /* distance to the nearest chosen point */
    float *cost;          /* of points in the heap: less their gain */
    struct vor_heap heap; /* points that are far enough for the round, most gain first */
    struct grid grid;
    double farthest, least; /* from all chosen, in this round */
    struct vor_knn *knn;    /* of the chosen points, while the pool grows */
};

/* Blocks of 4 x 4 x 4 cubes share a stretch of buckets, so that neighbours are mostly near in
 * memory. */
static size_t bucket_of(const struct grid *grid, const int64_t cell[3])
{
    uint64_t h = (uint64_t)(cell[0] >> 2) * UINT64_C(0x9e3779b97f4a7c15);
    size_t low = (size_t)((cell[0] & 3) | (cell[1] & 3) << 2 | (cell[2] & 3) << 4);

    h = (h ^ (h >> 32) ^ (uint64_t)(cell[1] >> 2)) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ (h >> 32) ^ (uint64_t)(cell[2] >> 2)) * UINT64_C(0x94d049bb133111eb);
    return ((size_t)(h >> 32) << 6 | low) & (grid->buckets - 1);
}

static void cell_of(const struct grid *grid, const float x[3], double offset, int64_t cell[3])
{
    for (int c = 0; c < 3; c++) {
        double at = floor(((double)x[c] + offset) * grid->per_side);

        cell[c] = (int64_t)(at < -CUBES ? -CUBES : at > CUBES ? CUBES : at);
    }
}

/* Fills the grid with the pool, or with its chosen points, for searches of about that radius. */
static void fill_grid(struct order *order, double radius, int chosen_only)
{
    struct grid *grid = &order->grid;
    size_t end = (order->n - 1) / order->stride * order->stride;
    int64_t cell[3];

    grid->per_side = 1 / radius;
    memset(grid->start, 0, (grid->buckets + 1) * sizeof *grid->start);
    for (size_t i = 0; i <= end; i += order->stride) {
        if (chosen_only && order->heap.place[i] != CHOSEN)
            continue;
        cell_of(grid, &order->xyz[3 * i], 0, cell);
        grid->start[bucket_of(grid, cell)]++;
    }
    for (size_t b = 1; b <= grid->buckets; b++)
        grid->start[b] += grid->start[b - 1];
    for (size_t i = end + order->stride; i > 0;) {
        i -= order->stride;
        if (chosen_only && order->heap.place[i] != CHOSEN)
            continue;
        cell_of(grid, &order->xyz[3 * i], 0, cell);
        grid->item[--grid->start[bucket_of(grid, cell)]] = (uint32_t)i;
    }
}

typedef void (*visit)(struct order *order, void *ctx, uint32_t i, double distance);

static void visit_cell(struct order *order, const int64_t cell[3], const float x[3], double radius,
                       visit call, void *ctx)
{
    const struct grid *grid = &order->grid;
    size_t b = bucket_of(grid, cell);
    int64_t own[3];

    for (uint32_t k = grid->start[b]; k < grid->start[b + 1]; k++) {
        uint32_t i = grid->item[k];
        const float *y = &order->xyz[3 * (size_t)i];
        double dx = (double)y[0] - x[0], dy = (double)y[1] - x[1], dz = (double)y[2] - x[2];
        double distance2 = dx * dx + dy * dy + dz * dz;

        if (!(distance2 < radius * radius))
            continue;
        cell_of(grid, y, 0, own);
        if (memcmp(own, cell, sizeof own) == 0)
            call(order, ctx, i, sqrt(distance2));
    }
}

/* Calls a function for each point of the grid within radius of x, in a fixed order. */
static void around(struct order *order, const float x[3], double radius, visit call, void *ctx)
{
    int64_t low[3], high[3], at[3];

    cell_of(&order->grid, x, -radius, low);
    cell_of(&order->grid, x, radius, high);
    for (at[0] = low[0]; at[0] <= high[0]; at[0]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
                visit_cell(order, at, x, radius, call, ctx);
}

static void add_gain(struct order *order, uint32_t i, double gain)
{
    order->cost[i] -= (float)gain;
    vor_heap_move(&order->heap, i);
}

/* Squared deviation of a distance from the wanted one, over the round's distance. */
static double misfit(const struct order *order, double distance)
{
    double off = distance / order->least - WANTED;

    return off * off;
}

static double horizon(const struct order *order)
{
    return BEYOND * order->least;
}

/* Gain when a chosen point, whose nearest is `reach` away, gets a neighbour at a distance. */
static double gain_of(const struct order *order, double reach, double distance)
{
    reach = fmin(reach, horizon(order));
    return distance < reach ? misfit(order, reach) - misfit(order, distance) : 0;
}

static void sum_gain(struct order *order, void *ctx, uint32_t i, double distance)
{
    *(double *)ctx += gain_of(order, (double)order->reach[i], distance);
}

/* Rates a point of the heap, from the grid of the chosen. */
static void rate_row(void *ctx, size_t k, VOR_UNUSED unsigned worker)
{
    struct order *order = ctx;
    uint32_t i = order->heap.item[k];
    double sum = -misfit(order, (double)order->reach[i]);

    if (vor_run_is_late(order->run))
        return; /* no rating is read any more: choose_all */
    around(order, &order->xyz[3 * (size_t)i], horizon(order), sum_gain, &sum);
    order->cost[i] = -(float)sum;
}

/* A chosen point that has got a nearer neighbour. */
struct told {
    uint32_t i;
    double from, to;
};

/* The point just chosen, and what it changes. */
struct choice {
    uint32_t i;
    double reach;
    unsigned count;
    struct told told[TOLD_MAX];
};

static void see_told(struct order *order, void *ctx, uint32_t i, double distance)
{
    const struct told *told = ctx;

    if (order->heap.place[i] < CHOSEN)
        add_gain(order, i,
                 gain_of(order, told->to, distance) - gain_of(order, told->from, distance));
}

static void see_choice(struct order *order, void *ctx, uint32_t i, double distance)
{
    struct choice *choice = ctx;
    double reach = (double)order->reach[i];

    if (!(distance < reach) || i == choice->i)
        return;
    order->reach[i] = (float)distance;
    if (order->heap.place[i] == CHOSEN) {
        if (choice->count < TOLD_MAX)
            choice->told[choice->count++] = (struct told){i, reach, distance};
    } else if (order->heap.place[i] != WAITS) {
        if (distance < order->least) {
            vor_heap_remove(&order->heap, i);
            order->heap.place[i] = WAITS;
            return;
        }
        add_gain(order, i,
                 gain_of(order, choice->reach, distance) + misfit(order, reach) -
                     misfit(order, distance));
    }
}

static void choose(struct order *order, uint32_t i)
{
    struct choice choice = {.i = i, .reach = (double)order->reach[i]};

    vor_heap_remove(&order->heap, i);
    order->out[order->count++] = i;
    around(order, &order->xyz[3 * (size_t)i], fmax(horizon(order), order->farthest * (1 + 0x1p-20)),
           see_choice, &choice);
    for (unsigned k = 0; k < choice.count; k++) {
        struct told *told = &choice.told[k];

        around(order, &order->xyz[3 * (size_t)told->i], fmin(told->from, horizon(order)), see_told,
               told);
    }
}

/* Collects the points that can be chosen in this round, not rated yet, and fills the grid with
 * those chosen. */
static void begin_round(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct order *order = ctx;

    order->farthest = 0;
    for (size_t i = 0; i < order->n; i += order->stride)
        if (order->heap.place[i] == WAITS)
            order->farthest = fmax(order->farthest, (double)order->reach[i]);
    order->heap.count = 0;
    if (!(order->farthest > 0))
        return;
    order->least = LAST * (order->spacing > 0 ? order->spacing : order->farthest);
    while (order->least < MARGIN * NEARLY * order->farthest)
        order->least /= NEARLY;
    while (order->least > MARGIN * order->farthest)
        order->least *= NEARLY;
    for (size_t i = 0; i < order->n; i += order->stride)
        if (order->heap.place[i] == WAITS && (double)order->reach[i] >= order->least)
            order->heap.item[order->heap.count++] = (uint32_t)i;
    fill_grid(order, horizon(order), 1);
}

static void build_heap(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct order *order = ctx;
    size_t all = order->heap.count;

    fill_grid(order, horizon(order), 0);
    for (order->heap.count = 0; order->heap.count < all;) {
        size_t at = order->heap.count++;

        vor_heap_sift(&order->heap, at, order->heap.item[at]);
    }
}

static void choose_some(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct order *order = ctx;

    for (size_t k = 0; k < TURN && order->heap.count > 0; k++)
        choose(order, order->heap.item[0]);
}

/* Runs a task on one thread of the pool. */
static vor_status on_one(struct order *order, vor_row_task task, struct vor_error *err)
{
    return vor_run_rows(order->run, 1, 1, task, order, err);
}

static void look_up_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct order *order = ctx;
    uint32_t index;
    float distance2;

    for (size_t i = begin * order->stride; i < end * order->stride && i < order->n;
         i += order->stride) {
        if (order->heap.place[i] == CHOSEN)
            continue;
        vor_knn_search(order->knn, &order->xyz[3 * i], 1, 1, &index, &distance2);
        order->reach[i] = sqrtf(distance2);
    }
}

static size_t pool_of(const struct order *order)
{
    return (order->n - 1) / order->stride + 1;
}

/* Finds the distance of each point of the pool to the chosen ones. */
static vor_status look_up(struct order *order, struct vor_error *err)
{
    float *xyz = vor_malloc(order->run->memory, order->count, 3 * sizeof *xyz);
    vor_status status;

    if (xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", order->count);
    vor_gather(xyz, order->xyz, order->out, order->count);
    status = vor_knn_build(&order->knn, xyz, order->count, order->run->memory, err);
    VOR_THEN(status, vor_run_for(order->run, pool_of(order), BLOCK, look_up_block, order, err));
    vor_knn_free(order->knn);
    vor_free(order->run->memory, xyz);
    order->knn = NULL;
    return status;
}

/* The points not chosen yet, once the time is over: those of wide strides first. Points near each
 * other have near indices, so that beginnings are still on all of the surface. */
static void choose_hurried(struct order *order)
{
    size_t stride = 1;

    while (stride < order->n)
        stride *= 2;
    for (; stride > 0; stride /= 2)
        for (size_t i = 0; i < order->n; i += stride) {
            if (order->heap.place[i] == CHOSEN)
                continue;
            order->heap.place[i] = CHOSEN;
            order->out[order->count++] = (uint32_t)i;
        }
}

static vor_status choose_all(struct order *order, struct vor_error *err)
{
    vor_status status;

    order->out[order->count++] = 0;
    order->heap.place[0] = CHOSEN;
    order->reach[0] = INFINITY;
    status = look_up(order, err);
    while (status == VOR_OK && !vor_run_is_late(order->run)) {
        status = on_one(order, begin_round, err);
        if (status != VOR_OK)
            break;
        if (order->stride > 1 &&
            (order->heap.count == 0 || order->count * CHOICE > pool_of(order))) {
            order->stride /= GROWS;
            status = look_up(order, err);
        } else if (order->heap.count == 0) {
            break;
        } else {
            status = vor_run_rows(order->run, order->heap.count, BLOCK, rate_row, order, err);
            if (status == VOR_OK && !vor_run_is_late(order->run))
                status = on_one(order, build_heap, err);
            while (status == VOR_OK && order->heap.count > 0 && !vor_run_is_late(order->run))
                status = on_one(order, choose_some, err);
        }
    }
    if (status == VOR_OK && vor_run_is_late(order->run))
        choose_hurried(order);
    for (size_t i = 0; i < order->n && status == VOR_OK; i++)
        if (order->heap.place[i] != CHOSEN)
            order->out[order->count++] = (uint32_t)i;
    return status;
}

static vor_status begin(struct order *order, struct vor_error *err)
{
    struct vor_memory *memory = order->run->memory;
    size_t n = order->n;

    order->grid.buckets = 64;
    while (order->grid.buckets < n)
        order->grid.buckets *= 2;
    if (VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(order->reach, n, 1), VOR_ARRAY(order->cost, n, 1),
                     VOR_ARRAY(order->heap.place, n, 1), VOR_ARRAY(order->heap.item, n, 1),
                     VOR_ARRAY(order->grid.item, n, 1),
                     VOR_ARRAY(order->grid.start, order->grid.buckets + 1, 1)) != VOR_OK)
        return VOR_E_NOMEM;
    order->stride = 1;
    while (n / order->stride >= GROWS * POOL_LEAST)
        order->stride *= GROWS;
    order->heap.key = order->cost;
    for (size_t i = 0; i < n; i++)
        order->heap.place[i] = WAITS;
    return VOR_OK;
}

vor_status vor_order_progressive(uint32_t *out, const float *xyz, size_t n, double spacing,
                                 const struct vor_run *run, struct vor_error *err)
{
    struct order order = {.xyz = xyz, .n = n, .run = run, .out = out, .spacing = spacing};
    vor_status status = begin(&order, err);

    VOR_THEN(status, choose_all(&order, err));
    VOR_FREE_ALL(run->memory, order.grid.start, order.grid.item, order.heap.item, order.heap.place,
                 order.cost, order.reach);
    return status;
}
