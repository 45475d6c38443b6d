#include "proto/draco/draco_quantize.h"

#include <math.h>
#include <string.h>

enum { BITS_MAX = 30 };

/* Draco rounds by adding a half in float32, which is exact below 2^23 only. */
enum { EXACT_BITS_MAX = 22, EXACT_EXPONENT_MAX = 80 };

int vor_draco_bound(struct vor_draco_column *column, size_t n)
{
    const float *data = column->data;
    unsigned components = column->components;
    float high[16];

    column->bits = 0;
    memcpy(column->low, data, components * sizeof *data);
    memcpy(high, data, components * sizeof *data);
    for (size_t i = 0; i < n; i++, data += components) {
        for (unsigned c = 0; c < components; c++) {
            if (!isfinite(data[c]))
                return 0;
            if (data[c] < column->low[c])
                column->low[c] = data[c];
            if (data[c] > high[c])
                high[c] = data[c];
        }
    }
    column->range = 0;
    for (unsigned c = 0; c < components; c++)
        column->range = fmaxf(column->range, high[c] - column->low[c]);
    if (column->range == 0)
        column->range = 1;
    return isfinite(column->range);
}

/* The exponent of the lowest bit that is set in a finite value other than 0. */
static int lowest_bit(float value)
{
    uint32_t bits, mantissa;
    int exponent;

    memcpy(&bits, &value, sizeof bits);
    exponent = (int)(bits >> 23 & 0xff);
    mantissa = bits & 0x7fffff;
    if (exponent > 0)
        mantissa |= 0x800000;
    else
        exponent = 1;
    return exponent - 150 + __builtin_ctz(mantissa);
}

static int fit_exactly(struct vor_draco_column *column, size_t n)
{
    const float *data = column->data;
    int grid = EXACT_EXPONENT_MAX + 1, bits = 1;
    double steps;

    for (size_t i = 0; i < n * column->components; i++) {
        int bit = data[i] != 0 ? lowest_bit(data[i]) : grid;

        if (bit < grid)
            grid = bit;
    }
    if (grid < -EXACT_EXPONENT_MAX || grid > EXACT_EXPONENT_MAX)
        return 0;
    steps = ldexp((double)column->range, -grid);
    while (bits <= EXACT_BITS_MAX && ldexp(1, bits) - 1 < steps)
        bits++;
    if (bits > EXACT_BITS_MAX)
        return 0;
    column->bits = bits;
    column->range = (float)ldexp(ldexp(1, bits) - 1, grid);
    return 1;
}

void vor_draco_fit_attribute(struct vor_draco_column *column, size_t n)
{
    if (!fit_exactly(column, n))
        column->bits =
            column->kind == VOR_DRACO_NORMAL ? VOR_DRACO_NORMAL_BITS : VOR_DRACO_SCALAR_BITS;
}

/* Where a point lands after a trip through the library, in its own arithmetic. */
static void land(float out[3], const struct vor_draco_column *column, const float *point)
{
    float most = (float)((1 << column->bits) - 1);
    float inverse = most / column->range, delta = column->range / most;

    for (int c = 0; c < 3; c++) {
        float cell = floorf((point[c] - column->low[c]) * inverse + 0.5f);

        out[c] = cell * delta + column->low[c] + 0.0f; /* + 0 turns -0 into 0 */
    }
}

static size_t hash_of(const float point[3])
{
    uint32_t bits[3];
    uint64_t hash = 0;

    memcpy(bits, point, sizeof bits);
    for (int c = 0; c < 3; c++) {
        hash = (hash ^ bits[c]) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 29;
    }
    return (size_t)hash;
}

static int same(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Do two points that differ land on one? slots: mask + 1 of them. */
static int coincide(const struct vor_draco_column *column, size_t n, uint32_t *slots, size_t mask)
{
    const float *xyz = column->data;

    memset(slots, 0xff, (mask + 1) * sizeof *slots);
    for (size_t i = 0; i < n; i++) {
        float here[3] = {0}, there[3] = {0};
        size_t slot;

        land(here, column, xyz + 3 * i);
        for (slot = hash_of(here) & mask; slots[slot] != UINT32_MAX; slot = (slot + 1) & mask) {
            const float *other = xyz + 3 * (size_t)slots[slot];

            land(there, column, other);
            if (!same(here, there))
                continue;
            if (!same(xyz + 3 * i, other))
                return 1;
            break;
        }
        if (slots[slot] == UINT32_MAX)
            slots[slot] = (uint32_t)i;
    }
    return 0;
}

vor_status vor_draco_fit_positions(struct vor_draco_column *column, const struct vor_cloud *cloud,
                                   double spacing, struct vor_error *err)
{
    double wanted;
    size_t capacity = 16;
    uint32_t *slots;

    if (!(spacing > 0) || !isfinite(spacing))
        spacing = column->range / sqrt((double)cloud->n);
    wanted = VOR_DRACO_CELLS_PER_SPACING * (double)column->range / spacing;
    while (capacity / 4 * 3 < cloud->n)
        capacity *= 2;
    slots = vor_malloc(cloud->memory, capacity, sizeof *slots);
    if (slots == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    column->bits = 1;
    while (column->bits < BITS_MAX && ldexp(1, column->bits) - 1 < wanted)
        column->bits++;
    while (column->bits > 0 && coincide(column, cloud->n, slots, capacity - 1))
        column->bits = column->bits < BITS_MAX ? column->bits + 1 : 0;
    vor_free(cloud->memory, slots);
    return VOR_OK;
}
