#include "core/base/morton.h"

#include <math.h>
#include <string.h>

struct entry {
    uint64_t code;
    uint32_t index;
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

static void encode(struct entry *entries, const float *xyz, size_t n)
{
    float low[3] = {xyz[0], xyz[1], xyz[2]}, high[3] = {xyz[0], xyz[1], xyz[2]};
    double extent = 0, scale;

    for (size_t i = 3; i < 3 * n; i++) {
        low[i % 3] = fminf(low[i % 3], xyz[i]);
        high[i % 3] = fmaxf(high[i % 3], xyz[i]);
    }
    for (int c = 0; c < 3; c++)
        extent = fmax(extent, (double)high[c] - (double)low[c]);
    scale = extent > 0 ? 2097151 / extent : 0;
    for (size_t i = 0; i < n; i++) {
        entries[i].code = 0;
        for (size_t c = 0; c < 3; c++)
            entries[i].code |= spread((uint64_t)(((double)xyz[3 * i + c] - (double)low[c]) * scale))
                               << c;
        entries[i].index = (uint32_t)i;
    }
}

/* One pass of a stable radix sort by 11 bits. */
static void pass(struct entry *to, const struct entry *from, size_t n, int shift)
{
    size_t count[2048] = {0}, sum = 0;

    for (size_t i = 0; i < n; i++)
        count[from[i].code >> shift & 2047]++;
    for (size_t i = 0; i < 2048; i++) {
        size_t here = count[i];

        count[i] = sum;
        sum += here;
    }
    for (size_t i = 0; i < n; i++)
        to[count[from[i].code >> shift & 2047]++] = from[i];
}

/* Order of two points of the same cell: by coordinates, then by index. */
static int precedes(const float *xyz, uint32_t i, uint32_t j)
{
    for (size_t c = 0; c < 3; c++)
        if (xyz[3 * (size_t)i + c] != xyz[3 * (size_t)j + c])
            return xyz[3 * (size_t)i + c] < xyz[3 * (size_t)j + c];
    return i < j;
}

/* Merge sort, bottom up; the result ends in a. */
static void sort_run(struct entry *a, struct entry *scratch, size_t n, const float *xyz)
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

static void sort_equal_codes(struct entry *a, struct entry *scratch, size_t n, const float *xyz)
{
    for (size_t begin = 0, end; begin < n; begin = end) {
        for (end = begin + 1; end < n && a[end].code == a[begin].code; end++)
            continue;
        if (end - begin > 1)
            sort_run(a + begin, scratch, end - begin, xyz);
    }
}

vor_status vor_morton_order(uint32_t *order, const float *xyz, size_t n, struct vor_memory *memory,
                            struct vor_error *err)
{
    struct entry *a = vor_malloc(memory, n, sizeof *a);
    struct entry *b = vor_malloc(memory, n, sizeof *b);
    vor_status status = VOR_OK;

    if (a == NULL || b == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "sorting %zu points", n);
        goto done;
    }
    encode(a, xyz, n);
    for (int shift = 0; shift < 63; shift += 11) {
        struct entry *swap = a;

        pass(b, a, n, shift);
        a = b;
        b = swap;
    }
    sort_equal_codes(a, b, n, xyz);
    for (size_t i = 0; i < n; i++)
        order[i] = a[i].index;
done:
    vor_free(memory, b);
    vor_free(memory, a);
    return status;
}
