/* A radix sort from the top. The first digit is split off by all threads: a histogram for each
 * block of points, then every block moves its own. After it the buckets fit the cache, and each is
 * sorted by one thread. A bucket that holds much of the cloud (one stray point far away makes one)
 * is split by all threads again. Every two points differ in what they are compared by, so that
 * there is only one result, however the work is cut. */
#include "core/base/morton.h"

#include "core/base/bounds.h"

#include <math.h>
#include <string.h>

enum {
    CODE_BITS = 63,
    DIGIT = 12, /* bits of one split by all threads */
    BUCKETS = 1 << DIGIT,
    SMALL_DIGIT = 8, /* bits of one split by one thread */
    SMALL_BUCKETS = 1 << SMALL_DIGIT,
    BLOCK_MIN = 1 << 14, /* points of a block at least */
    BLOCKS_MAX = 64,     /* blocks at most: each has a histogram of BUCKETS */
    BUCKETS_A_TASK = 16,
    BIG_SHARE = 16, /* a bucket of more than 1 / BIG_SHARE of all points is split by all threads */
    INSERTION_MAX = 24 /* points at most that are sorted by insertion */
};

struct grid {
    struct vor_box box;
    double scale;
};

struct entry {
    uint64_t code;
    uint32_t index;
};

struct sorter {
    const float *xyz;
    const struct vor_run *run;
    uint32_t *order;
    uint32_t *count; /* for each block, for each bucket: how many, then where the next one goes */
    uint32_t start[BUCKETS + 1]; /* first of each bucket in the range */
    size_t big;                  /* more entries than this in a bucket are split by all */
    struct grid grid;
};

/* Entries being split by the `width` bits above `shift`. */
struct range {
    struct sorter *sorter;
    struct entry *from, *to;
    uint32_t *order;
    size_t n, block;
    unsigned shift, width;
};

/* Spreads 21 bits to every third of 63. */
static uint64_t spread(uint64_t x)
{
    x = (x | x << 32) & UINT64_C(0x001f00000000ffff);
    x = (x | x << 16) & UINT64_C(0x001f0000ff0000ff);
    x = (x | x << 8) & UINT64_C(0x100f00f00f00f00f);
    x = (x | x << 4) & UINT64_C(0x10c30c30c30c30c3);
    x = (x | x << 2) & UINT64_C(0x1249249249249249);
    return x;
}

static uint64_t encode(const struct grid *grid, const float x[3])
{
    uint64_t code = 0;

    for (int c = 0; c < 3; c++)
        code |= spread((uint64_t)(((double)x[c] - (double)grid->box.low[c]) * grid->scale)) << c;
    return code;
}

static vor_status lay_grid(struct grid *grid, const float *xyz, size_t n, const struct vor_run *run,
                           struct vor_error *err)
{
    double extent = 0;
    vor_status status = vor_bounds(&grid->box, xyz, n, run, err);

    if (status != VOR_OK)
        return status;
    for (int c = 0; c < 3; c++)
        extent = fmax(extent, (double)grid->box.high[c] - (double)grid->box.low[c]);
    grid->scale = extent > 0 ? 2097151 / extent : 0;
    return VOR_OK;
}

/* Order of two points of the same cell: by coordinates, then by index. */
static int precedes(const float *xyz, uint32_t i, uint32_t j)
{
    for (size_t c = 0; c < 3; c++)
        if (xyz[3 * (size_t)i + c] != xyz[3 * (size_t)j + c])
            return xyz[3 * (size_t)i + c] < xyz[3 * (size_t)j + c];
    return i < j;
}

/* Merge sort of entries with the same code, bottom up; the result ends in a. */
static void sort_cell(struct entry *a, struct entry *scratch, size_t n, const float *xyz)
{
    for (size_t width = 1; width < n; width *= 2) {
        for (size_t low = 0; low < n; low += 2 * width) {
            size_t middle = low + width < n ? low + width : n;
            size_t high = low + 2 * width < n ? low + 2 * width : n, i = low, j = middle;

            for (size_t k = low; k < high; k++)
                if (j == high || (i < middle && precedes(xyz, a[i].index, a[j].index)))
                    scratch[k] = a[i++];
                else
                    scratch[k] = a[j++];
        }
        memcpy(a, scratch, n * sizeof *a);
    }
}

static void sort_few(struct entry *a, size_t n, const float *xyz)
{
    for (size_t i = 1; i < n; i++) {
        struct entry entry = a[i];
        size_t at = i;

        while (at > 0 &&
               (entry.code < a[at - 1].code ||
                (entry.code == a[at - 1].code && precedes(xyz, entry.index, a[at - 1].index)))) {
            a[at] = a[at - 1];
            at--;
        }
        a[at] = entry;
    }
}

static size_t digit(const struct entry *entry, unsigned shift, unsigned width)
{
    return (size_t)(entry->code >> shift) & (((size_t)1 << width) - 1);
}

/* Sorts entries that differ in their lowest `left` bits only, by one thread. Each of a and scratch
 * may end as anything: what counts is the order. */
static void sort_bucket(const struct sorter *sorter, struct entry *a, struct entry *scratch,
                        size_t n, unsigned left, uint32_t *order)
{
    uint32_t next[SMALL_BUCKETS] = {0};
    unsigned width = left < SMALL_DIGIT ? left : SMALL_DIGIT, shift = left - width;
    uint32_t sum = 0;

    if (n <= INSERTION_MAX || left == 0) {
        if (n <= INSERTION_MAX)
            sort_few(a, n, sorter->xyz);
        else
            sort_cell(a, scratch, n, sorter->xyz);
        for (size_t i = 0; i < n; i++)
            order[i] = a[i].index;
        return;
    }
    for (size_t i = 0; i < n; i++)
        next[digit(&a[i], shift, width)]++;
    for (size_t i = 0; i < (size_t)1 << width; i++) {
        sum += next[i];
        next[i] = sum - next[i];
    }
    for (size_t i = 0; i < n; i++)
        scratch[next[digit(&a[i], shift, width)]++] = a[i];
    for (size_t i = 0, begin = 0; i < (size_t)1 << width; i++) {
        if (next[i] > begin)
            sort_bucket(sorter, scratch + begin, a + begin, next[i] - begin, shift, order + begin);
        begin = next[i];
    }
}

static void encode_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct range *range = ctx;

    for (size_t i = begin; i < end; i++) {
        range->from[i].code = encode(&range->sorter->grid, &range->sorter->xyz[3 * i]);
        range->from[i].index = (uint32_t)i;
    }
}

static void count_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct range *range = ctx;
    uint32_t *count = &range->sorter->count[begin / range->block * BUCKETS];

    memset(count, 0, BUCKETS * sizeof *count);
    for (size_t i = begin; i < end; i++)
        count[digit(&range->from[i], range->shift, range->width)]++;
}

static void move_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct range *range = ctx;
    uint32_t *next = &range->sorter->count[begin / range->block * BUCKETS];

    for (size_t i = begin; i < end; i++)
        range->to[next[digit(&range->from[i], range->shift, range->width)]++] = range->from[i];
}

static void sort_buckets(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct range *range = ctx;
    const struct sorter *sorter = range->sorter;

    for (size_t i = begin; i < end; i++) {
        size_t first = sorter->start[i], n = sorter->start[i + 1] - first;

        if (n > 0 && (n <= sorter->big || range->shift == 0))
            sort_bucket(sorter, range->to + first, range->from + first, n, range->shift,
                        range->order + first);
    }
}

/* Histograms become places: those of a bucket follow each other, block by block. */
static void sum_counts(struct range *range)
{
    uint32_t *count = range->sorter->count, sum = 0;
    size_t blocks = (range->n + range->block - 1) / range->block;

    for (size_t i = 0; i < BUCKETS; i++) {
        range->sorter->start[i] = sum;
        for (size_t b = 0; b < blocks; b++) {
            uint32_t here = count[b * BUCKETS + i];

            count[b * BUCKETS + i] = sum;
            sum += here;
        }
    }
    range->sorter->start[BUCKETS] = sum;
}

static size_t block_of(size_t n)
{
    size_t block = (n + BLOCKS_MAX - 1) / BLOCKS_MAX;

    return block > BLOCK_MIN ? block : BLOCK_MIN;
}

/* Splits n entries by all threads and sorts what comes of it. from and to change roles with every
 * level. */
static vor_status sort_range(struct range *range, struct vor_error *err)
{
    const struct vor_run *run = range->sorter->run;
    size_t big[BIG_SHARE], big_n[BIG_SHARE], bigs = 0;
    vor_status status = vor_run_for(run, range->n, range->block, count_block, range, err);

    if (status != VOR_OK)
        return status;
    sum_counts(range);
    status = vor_run_for(run, range->n, range->block, move_block, range, err);
    if (status == VOR_OK)
        status = vor_run_for(run, BUCKETS, BUCKETS_A_TASK, sort_buckets, range, err);
    for (size_t i = 0; i < BUCKETS && range->shift > 0; i++) { /* the next level needs `start` */
        size_t first = range->sorter->start[i], n = range->sorter->start[i + 1] - first;

        if (n <= range->sorter->big)
            continue;
        big[bigs] = first;
        big_n[bigs++] = n;
    }
    for (size_t i = 0; i < bigs && status == VOR_OK; i++) {
        struct range next = {.sorter = range->sorter,
                             .from = range->to + big[i],
                             .to = range->from + big[i],
                             .order = range->order + big[i],
                             .n = big_n[i],
                             .block = block_of(big_n[i]),
                             .width = range->shift < DIGIT ? range->shift : DIGIT};

        next.shift = range->shift - next.width;
        status = sort_range(&next, err);
    }
    return status;
}

static vor_status sort_all(struct sorter *sorter, struct entry *a, struct entry *b, size_t n,
                           struct vor_error *err)
{
    struct range all = {.sorter = sorter,
                        .from = a,
                        .to = b,
                        .order = sorter->order,
                        .n = n,
                        .block = block_of(n),
                        .shift = CODE_BITS - DIGIT,
                        .width = DIGIT};
    vor_status status = lay_grid(&sorter->grid, sorter->xyz, n, sorter->run, err);

    if (status != VOR_OK)
        return status;
    sorter->big = n / BIG_SHARE > BLOCK_MIN ? n / BIG_SHARE : BLOCK_MIN;
    status = vor_run_for(sorter->run, n, all.block, encode_block, &all, err);
    if (status != VOR_OK)
        return status;
    if (n > BLOCK_MIN)
        return sort_range(&all, err);
    sort_bucket(sorter, a, b, n, CODE_BITS, sorter->order);
    return VOR_OK;
}

vor_status vor_morton_order(uint32_t *order, const float *xyz, size_t n, const struct vor_run *run,
                            struct vor_error *err)
{
    size_t blocks = (n + block_of(n) - 1) / block_of(n);
    struct sorter *sorter = vor_malloc(run->memory, 1, sizeof *sorter);
    struct entry *a = vor_malloc(run->memory, n, sizeof *a);
    struct entry *b = vor_malloc(run->memory, n, sizeof *b);
    uint32_t *count = vor_malloc(run->memory, blocks, BUCKETS * sizeof *count);
    vor_status status;

    if (sorter == NULL || a == NULL || b == NULL || count == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
        goto done;
    }
    sorter->xyz = xyz;
    sorter->run = run;
    sorter->order = order;
    sorter->count = count;
    status = sort_all(sorter, a, b, n, err);
done:
    VOR_FREE_ALL(run->memory, count, b, a, sorter);
    return status;
}

struct codes {
    struct grid grid;
    const float *xyz;
    uint64_t *code;
};

static void code_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct codes *codes = ctx;

    for (size_t i = begin; i < end; i++)
        codes->code[i] = encode(&codes->grid, &codes->xyz[3 * i]);
}

vor_status vor_morton_codes(uint64_t *code, const float *xyz, size_t n, const struct vor_run *run,
                            struct vor_error *err)
{
    struct codes codes = {.xyz = xyz, .code = code};
    vor_status status = lay_grid(&codes.grid, xyz, n, run, err);

    return status == VOR_OK ? vor_run_for(run, n, BLOCK_MIN, code_block, &codes, err) : status;
}
