/* A radix sort from the top. The first digit is split off by all threads: a histogram for each
 * block of points, then every block moves its own, with their indices. After it the buckets fit the
 * cache, and each is sorted by one thread, where it is. A bucket that holds much of the cloud (one
 * stray point far away makes one) is split by all threads again. Every two points differ in what
 * they are compared by, so that there is only one result, however the work is cut. */
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
    BIG_SHARE = 8,  /* a bucket of more than 1 / BIG_SHARE of a thread's points is split by all */
    BIG_MIN = 1024, /* unless it has no more than that */
    INSERTION_MAX = 24 /* points at most that are sorted by insertion */
};

struct grid {
    struct vor_box box;
    double scale;
};

struct entry {
    uint64_t code;
    uint32_t index; /* in its bucket */
};

/* Points and which of the input they are. */
struct piece {
    float *xyz;
    uint32_t *index;
};

struct sorter {
    const float *xyz; /* the input; its points become (x - shift) * scale */
    const double *shift;
    double scale;
    const struct vor_run *run;
    uint32_t *count; /* for each block, for each bucket: how many, then where the next one goes */
    size_t big;      /* more points than this in a bucket are split by all */
    struct entry *entry; /* for each thread twice `most` */
    uint32_t *place;     /* for each thread `most` */
    size_t most, room;   /* points of a bucket now; of all threads at most */
    struct grid grid;
};

/* Points being split by the `width` bits above `shift`. */
struct range {
    struct sorter *sorter;
    struct piece from; /* NULL: the input */
    struct piece to;
    struct piece home; /* one of these, where they are in the end */
    size_t n, block;
    unsigned shift, width;
    uint32_t start[BUCKETS + 1]; /* first of each bucket */
};

static struct piece behind(struct piece piece, size_t first)
{
    return (struct piece){piece.xyz + 3 * first, piece.index + first};
}

static void put(const struct piece *to, size_t at, const float x[3], uint32_t index)
{
    for (size_t c = 0; c < 3; c++)
        to->xyz[3 * at + c] = x[c];
    to->index[at] = index;
}

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

static float moved(double x, double shift, double scale)
{
    return (float)((x - shift) * scale);
}

static vor_status lay_grid(struct grid *grid, const struct sorter *of, size_t n,
                           struct vor_error *err)
{
    double extent = 0;
    vor_status status = vor_bounds(&grid->box, of->xyz, n, of->run, err);

    if (status != VOR_OK)
        return status;
    for (int c = 0; c < 3; c++) { /* rounding preserves order: this is the box of moved points */
        grid->box.low[c] = moved((double)grid->box.low[c], of->shift[c], of->scale);
        grid->box.high[c] = moved((double)grid->box.high[c], of->shift[c], of->scale);
    }
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

/* Merge sort of points with the same code, bottom up; the result ends in a. */
static void sort_cell(uint32_t *a, uint32_t *scratch, size_t n, const float *xyz)
{
    for (size_t width = 1; width < n; width *= 2) {
        for (size_t low = 0; low < n; low += 2 * width) {
            size_t middle = low + width < n ? low + width : n;
            size_t high = low + 2 * width < n ? low + 2 * width : n, i = low, j = middle;

            for (size_t k = low; k < high; k++)
                if (j == high || (i < middle && precedes(xyz, a[i], a[j])))
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

static size_t digit(uint64_t code, unsigned shift, unsigned width)
{
    return (size_t)(code >> shift) & (((size_t)1 << width) - 1);
}

/* Sorts entries that differ in their lowest `left` bits only, by one thread. Each of a and scratch
 * may end as anything: what counts is the order. */
static void sort_bucket(const float *xyz, struct entry *a, struct entry *scratch, size_t n,
                        unsigned left, uint32_t *order)
{
    uint32_t next[SMALL_BUCKETS] = {0};
    unsigned width = left < SMALL_DIGIT ? left : SMALL_DIGIT, shift = left - width;
    uint32_t sum = 0;

    if (n <= INSERTION_MAX || left == 0) {
        if (n <= INSERTION_MAX)
            sort_few(a, n, xyz);
        for (size_t i = 0; i < n; i++)
            order[i] = a[i].index;
        if (n > INSERTION_MAX)
            sort_cell(order, (void *)scratch, n, xyz);
        return;
    }
    for (size_t i = 0; i < n; i++)
        next[digit(a[i].code, shift, width)]++;
    for (size_t i = 0; i < (size_t)1 << width; i++) {
        sum += next[i];
        next[i] = sum - next[i];
    }
    for (size_t i = 0; i < n; i++)
        scratch[next[digit(a[i].code, shift, width)]++] = a[i];
    for (size_t i = 0, begin = 0; i < (size_t)1 << width; i++) {
        if (next[i] > begin)
            sort_bucket(xyz, scratch + begin, a + begin, next[i] - begin, shift, order + begin);
        begin = next[i];
    }
}

/* Point i of a range. Returns its digit. */
static size_t take(const struct range *range, size_t i, float x[3])
{
    const struct sorter *sorter = range->sorter;

    for (size_t c = 0; c < 3; c++)
        x[c] = range->from.xyz != NULL
                   ? range->from.xyz[3 * i + c]
                   : moved((double)sorter->xyz[3 * i + c], sorter->shift[c], sorter->scale);
    return digit(encode(&sorter->grid, x), range->shift, range->width);
}

static void count_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct range *range = ctx;
    uint32_t *count = &range->sorter->count[begin / range->block * BUCKETS];
    float x[3];

    memset(count, 0, BUCKETS * sizeof *count);
    for (size_t i = begin; i < end; i++)
        count[take(range, i, x)]++;
}

static void move_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct range *range = ctx;
    uint32_t *next = &range->sorter->count[begin / range->block * BUCKETS];
    float x[3];

    for (size_t i = begin; i < end; i++) {
        size_t at = next[take(range, i, x)]++;

        put(&range->to, at, x, range->from.xyz != NULL ? range->from.index[i] : (uint32_t)i);
    }
}

/* Sorts n points, which differ in their lowest `left` bits only, by one thread, from where they are
 * to where they go, which may be the same. */
static void sort_piece(const struct sorter *sorter, struct piece from, size_t n, unsigned left,
                       struct piece to, unsigned worker)
{
    struct entry *entry = &sorter->entry[2 * worker * sorter->most];
    uint32_t *place = &sorter->place[worker * sorter->most];
    struct piece moved = {(void *)entry, (void *)(entry + n)}; /* where the entries were */
    const float *xyz = from.xyz;

    for (size_t i = 0; i < n; i++)
        entry[i] = (struct entry){encode(&sorter->grid, &xyz[3 * i]), (uint32_t)i};
    sort_bucket(xyz, entry, entry + n, n, left, place);
    for (size_t i = 0; i < n; i++)
        put(&moved, i, &xyz[3 * (size_t)place[i]], from.index[place[i]]);
    for (size_t i = 0; i < n; i++)
        put(&to, i, moved.xyz + 3 * i, moved.index[i]);
}

static void sort_buckets(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct range *range = ctx;

    for (size_t i = begin; i < end; i++) {
        size_t first = range->start[i], n = range->start[i + 1] - first;

        if (n > 0 && n <= range->sorter->big)
            sort_piece(range->sorter, behind(range->to, first), n, range->shift,
                       behind(range->home, first), worker);
    }
}

/* Histograms become places: those of a bucket follow each other, block by block. */
static void sum_counts(struct range *range)
{
    uint32_t *count = range->sorter->count, sum = 0;
    size_t blocks = vor_blocks_of(range->n, range->block);

    for (size_t i = 0; i < BUCKETS; i++) {
        range->start[i] = sum;
        for (size_t b = 0; b < blocks; b++) {
            uint32_t here = count[b * BUCKETS + i];

            count[b * BUCKETS + i] = sum;
            sum += here;
        }
    }
    range->start[BUCKETS] = sum;
}

static size_t block_of(size_t n)
{
    size_t block = vor_blocks_of(n, BLOCKS_MAX);

    return block > BLOCK_MIN ? block : BLOCK_MIN;
}

/* Makes room for each of so many threads to sort n points. */
static vor_status make_room(struct sorter *sorter, size_t n, size_t threads, struct vor_error *err)
{
    struct vor_memory *memory = sorter->run->memory;

    sorter->most = n;
    if (n * threads <= sorter->room)
        return VOR_OK;
    VOR_FREE_ALL(memory, sorter->entry, sorter->place);
    sorter->room = n * threads;
    sorter->entry = vor_malloc(memory, sorter->room, 2 * sizeof *sorter->entry);
    sorter->place = vor_malloc(memory, sorter->room, sizeof *sorter->place);
    return sorter->entry != NULL && sorter->place != NULL
               ? VOR_OK
               : vor_fail(err, VOR_E_NOMEM, "%zu points", n);
}

/* Sorts the buckets that are not split once more. */
static vor_status sort_small(struct range *range, struct vor_error *err)
{
    struct sorter *sorter = range->sorter;
    size_t most = 0;
    vor_status status;

    for (size_t i = 0; i < BUCKETS; i++) {
        size_t n = range->start[i + 1] - range->start[i];

        most = n > most && n <= sorter->big ? n : most;
    }
    status = make_room(sorter, most, vor_pool_threads(sorter->run->pool), err);
    if (status != VOR_OK)
        return status;
    return vor_run_for(sorter->run, BUCKETS, BUCKETS_A_TASK, sort_buckets, range, err);
}

static vor_status sort_range(struct range *range, struct vor_error *err);

/* Sorts a big bucket: splits it by its next digit, or if there is none by one thread. */
static vor_status sort_big(const struct range *range, size_t first, size_t n, struct vor_error *err)
{
    struct vor_memory *memory = range->sorter->run->memory;
    struct piece other = {NULL, NULL};
    struct range next = {.sorter = range->sorter,
                         .from = behind(range->to, first),
                         .home = behind(range->home, first),
                         .n = n,
                         .block = block_of(n),
                         .width = range->shift < DIGIT ? range->shift : DIGIT};
    vor_status status;

    next.shift = range->shift - next.width;
    if (next.width == 0) {
        status = make_room(range->sorter, n, 1, err);
        if (status == VOR_OK)
            sort_piece(range->sorter, next.from, n, 0, next.home, 0);
        return status;
    }
    if (range->from.xyz != NULL) {
        next.to = behind(range->from, first);
        return sort_range(&next, err);
    }
    other.xyz = vor_malloc(memory, n, 3 * sizeof *other.xyz);
    other.index = vor_malloc(memory, n, sizeof *other.index);
    next.to = other;
    status = other.xyz != NULL && other.index != NULL ? sort_range(&next, err)
                                                      : vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    VOR_FREE_ALL(memory, other.xyz, other.index);
    return status;
}

/* Splits n points by all threads and sorts what comes of it. from and to change roles with every
 * level. */
static vor_status sort_range(struct range *range, struct vor_error *err)
{
    const struct vor_run *run = range->sorter->run;
    vor_status status = vor_run_for(run, range->n, range->block, count_block, range, err);

    if (status != VOR_OK)
        return status;
    sum_counts(range);
    status = vor_run_for(run, range->n, range->block, move_block, range, err);
    VOR_THEN(status, sort_small(range, err));
    for (size_t i = 0; i < BUCKETS && status == VOR_OK; i++) {
        size_t first = range->start[i], n = range->start[i + 1] - first;

        if (n > range->sorter->big)
            status = sort_big(range, first, n, err);
    }
    return status;
}

static vor_status sort_all(struct sorter *sorter, struct piece home, size_t n,
                           struct vor_error *err)
{
    struct range all = {.sorter = sorter,
                        .to = home,
                        .home = home,
                        .n = n,
                        .block = block_of(n),
                        .shift = CODE_BITS - DIGIT,
                        .width = DIGIT};
    size_t share = n / BIG_SHARE / vor_pool_threads(sorter->run->pool);
    vor_status status = lay_grid(&sorter->grid, sorter, n, err);

    if (status == VOR_OK && n <= BLOCK_MIN) {
        float x[3];

        status = make_room(sorter, n, 1, err);
        for (size_t i = 0; i < n; i++) {
            (void)take(&all, i, x);
            put(&home, i, x, (uint32_t)i);
        }
        if (status == VOR_OK)
            sort_piece(sorter, home, n, CODE_BITS, home, 0);
        return status;
    }
    if (status != VOR_OK)
        return status;
    sorter->big = share > BIG_MIN ? share : BIG_MIN;
    sorter->count = vor_malloc(sorter->run->memory, vor_blocks_of(n, all.block),
                               BUCKETS * sizeof *sorter->count);
    return sorter->count != NULL ? sort_range(&all, err)
                                 : vor_fail(err, VOR_E_NOMEM, "%zu points", n);
}

vor_status vor_morton_sort(float *sorted, uint32_t *order, const struct vor_morton_input *in,
                           const struct vor_run *run, struct vor_error *err)
{
    struct sorter sorter = {.xyz = in->xyz, .shift = in->shift, .scale = in->scale, .run = run};
    vor_status status = sort_all(&sorter, (struct piece){sorted, order}, in->n, err);

    VOR_FREE_ALL(run->memory, sorter.count, sorter.entry, sorter.place);
    return status;
}

vor_status vor_morton_order(uint32_t *order, const float *xyz, size_t n, const struct vor_run *run,
                            struct vor_error *err)
{
    struct vor_morton_input in = {.xyz = xyz, .n = n, .scale = 1};
    float *sorted = vor_malloc(run->memory, n, 3 * sizeof *sorted);
    vor_status status = sorted != NULL ? vor_morton_sort(sorted, order, &in, run, err)
                                       : vor_fail(err, VOR_E_NOMEM, "%zu points", n);

    vor_free(run->memory, sorted);
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
    struct sorter as_they_are = {
        .xyz = xyz, .shift = (const double[3]){0, 0, 0}, .scale = 1, .run = run};
    vor_status status = lay_grid(&codes.grid, &as_they_are, n, err);

    return status == VOR_OK ? vor_run_for(run, n, BLOCK_MIN, code_block, &codes, err) : status;
}
