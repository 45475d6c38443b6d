/* Forces of four points at once against the same sums point by point, bit by bit. */
#include "core/seeds/forces.h"
#include "tests/support/vt.h"

enum { SEEDS = 60, POINTS = 41 };

/* The same operations in the same order, without vectors. */
static int sum_plainly(float sum[3], const struct vor_forces *how, const float *at,
                       const uint32_t *list, unsigned count)
{
    float total[VOR_FORCES_BATCH][3] = {{0}};
    int apart = 1;

    for (unsigned j = 0; j < count; j++) {
        const float *b = &at[4 * list[j]];
        float d[3] = {at[0] - b[0], at[1] - b[1], at[2] - b[2]};
        float d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], h = fmaxf(b[3], at[3]);
        float h2 = how->h2 * (h * h), base = h2 / d2, weight = 1;

        for (unsigned power = how->power; power > 0; power >>= 1, base *= base)
            weight *= power & 1 ? base : 1;
        weight = d2 <= how->reach2 * h2 ? fminf(weight, how->most) : 0;
        apart &= d2 > how->overlap2 * (how->h2 * (at[3] * at[3]));
        for (int c = 0; c < 3; c++)
            total[j % VOR_FORCES_BATCH][c] += weight * d[c];
    }
    for (int c = 0; c < 3; c++)
        sum[c] = (total[0][c] + total[2][c]) + (total[1][c] + total[3][c]);
    return apart;
}

VT_TEST_LOOP(four_points_at_once_give_the_bits_of_one_by_one, SEEDS)
{
    uint64_t seed = (uint64_t)_i;
    struct vor_forces how = {0.01f, 2.25f, 0.01f, 50, 4 + (unsigned)_i % 11};
    float at[4 * POINTS], sum[3], expected[3];
    uint32_t list[POINTS - 1];
    unsigned count = VOR_FORCES_BATCH * (1 + (unsigned)_i % 10);

    for (uint64_t e = 0; e < 4 * POINTS; e++)
        at[e] =
            (float)(e % 4 == 3 ? 1 + (double)(_i % 2) * vt_unit(seed, e) : 0.4 * vt_unit(seed, e));
    for (uint32_t j = 0; j + 1 < POINTS; j++)
        list[j] = POINTS - 1 - j;
    for (int c = 0; _i % 7 == 0 && c < 3; c++) /* one coincides */
        at[4 * list[count - 1] + (unsigned)c] = at[c];
    ck_assert_int_eq(vor_forces_sum(sum, &how, at, 0, list, count),
                     sum_plainly(expected, &how, at, list, count));
    for (int c = 0; c < 3; c++)
        ck_assert(sum[c] == expected[c]);
}
