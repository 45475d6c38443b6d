#include "core/seeds/forces.h"

#include "core/base/vector.h"

#include <assert.h>
#include <string.h>

typedef float lanes __attribute__((vector_size(4 * VOR_FORCES_BATCH)));
typedef int32_t marks __attribute__((vector_size(4 * VOR_FORCES_BATCH)));

VOR_INLINE lanes load(const float *at, size_t i)
{
    lanes out;

    memcpy(&out, &at[VOR_FORCES_BATCH * i], sizeof out);
    return out;
}

/* a where marked, else b. */
VOR_INLINE lanes choose(marks mark, lanes a, lanes b)
{
    return (lanes)(((marks)a & mark) | ((marks)b & ~mark));
}

/* Of four points, one after the other, makes x, y, z and the spacing of all. */
VOR_INLINE void transpose(lanes out[4], const lanes in[4])
{
    lanes a = __builtin_shufflevector(in[0], in[2], 0, 4, 1, 5);
    lanes b = __builtin_shufflevector(in[1], in[3], 0, 4, 1, 5);
    lanes c = __builtin_shufflevector(in[0], in[2], 2, 6, 3, 7);
    lanes d = __builtin_shufflevector(in[1], in[3], 2, 6, 3, 7);

    out[0] = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    out[1] = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    out[2] = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    out[3] = __builtin_shufflevector(c, d, 2, 6, 3, 7);
}

VOR_CLONES int vor_forces_sum(float sum[3], const struct vor_forces *how, const float *at, size_t i,
                              const uint32_t *list, unsigned count)
{
    const lanes zero = {0}, most = how->most - zero, own = load(at, i);
    float overlap2 = how->overlap2 * (how->h2 * (own[3] * own[3]));
    lanes total[3] = {zero, zero, zero};
    marks near = {0};

    assert(count % VOR_FORCES_BATCH == 0);
    for (unsigned j = 0; j < count; j += VOR_FORCES_BATCH) {
        lanes other[4] = {load(at, list[j]), load(at, list[j + 1]), load(at, list[j + 2]),
                          load(at, list[j + 3])};
        lanes b[4], d[3], d2, h2, base, weight = 1 - zero;
        marks within;
        uint64_t any[2];

        transpose(b, other);
        for (int c = 0; c < 3; c++)
            d[c] = own[c] - b[c];
        d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        h2 = choose(b[3] > own[3] - zero, b[3], own[3] - zero);
        h2 = how->h2 * (h2 * h2);
        within = d2 <= how->reach2 * h2;
        memcpy(any, &within, sizeof any);
        if ((any[0] | any[1]) == 0) /* they add 0 */
            continue;
        base = h2 / d2;
        for (unsigned power = how->power; power > 0; power >>= 1) {
            if (power & 1)
                weight *= base;
            base *= base;
        }
        weight = choose(weight < most, weight, most);
        weight = choose(within, weight, zero);
        near |= d2 <= overlap2;
        for (int c = 0; c < 3; c++)
            total[c] += weight * d[c];
    }
    for (int c = 0; c < 3; c++)
        sum[c] = (total[c][0] + total[c][2]) + (total[c][1] + total[c][3]);
    return !(near[0] | near[1] | near[2] | near[3]);
}
