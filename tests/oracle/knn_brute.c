/* Oracle: the index against a look at every point. Distances are compared, not indices: points at
 * equal distance come in any order. */
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 16, SHAPES = 5 };

static float lay(int shape, uint64_t seed, size_t i, size_t c)
{
    double u = vt_unit(seed, 3 * i + c);

    switch (shape) {
    case 0:
        return (float)u;
    case 1: /* clusters, a ten-thousandth wide */
        return (float)(vt_unit(seed + 1000, 3 * (i % 7) + c) + 1e-4 * u);
    case 2: /* planar */
        return c == 2 ? 0.25f : (float)u;
    case 3: /* every place three times */
        return (float)vt_unit(seed, 3 * (i / 3) + c);
    default: /* on a coarse lattice: many ties */
        return (float)floor(5 * u);
    }
}

static void check_row(const float *xyz, size_t n, const float *query, const uint32_t *index,
                      const float *found, const float *expected, unsigned k)
{
    static unsigned char seen[3000];

    memset(seen, 0, n);
    for (unsigned j = 0; j < k; j++) {
        double d2 = 0;

        ck_assert_uint_lt(index[j], n);
        ck_assert_msg(!seen[index[j]], "point %u is there twice", index[j]);
        seen[index[j]] = 1;
        for (size_t c = 0; c < 3; c++)
            d2 += pow((double)xyz[3 * (size_t)index[j] + c] - (double)query[c], 2);
        ck_assert_double_le(fabs((double)found[j] - (double)expected[j]),
                            1e-6 * (double)expected[j]);
        ck_assert_double_le(fabs((double)found[j] - d2), 1e-6 * d2);
    }
}

static void compare(int shape, uint64_t seed, size_t n, unsigned k)
{
    enum { QUERIES = 10 };
    float *xyz = vor_malloc(&vt_memory, n, 3 * sizeof *xyz), query[3 * QUERIES];
    uint32_t *index = vor_malloc(&vt_memory, QUERIES, 2 * k * sizeof *index);
    float *distance2 = vor_malloc(&vt_memory, QUERIES, 2 * k * sizeof *distance2);
    struct vor_knn *knn;

    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] = lay(shape, seed, i / 3, i % 3);
    for (size_t q = 0; q < QUERIES; q++)
        for (size_t c = 0; c < 3; c++) /* half of them points, half anywhere */
            query[3 * q + c] =
                q % 2 ? xyz[3 * (q * 37 % n) + c] : (float)(3 * vt_unit(seed + 5, 3 * q + c) - 1);
    vt_assert_ok(vor_knn_build(&knn, xyz, n, &vt_memory, &vt_err));
    vor_knn_search(knn, query, QUERIES, k, index, distance2);
    vor_knn_brute(xyz, n, query, QUERIES, k, index + QUERIES * k, distance2 + QUERIES * k);
    for (size_t q = 0; q < QUERIES; q++)
        check_row(xyz, n, &query[3 * q], &index[q * k], &distance2[q * k],
                  &distance2[(QUERIES + q) * k], k);
    vor_knn_free(knn);
    vor_free(&vt_memory, distance2);
    vor_free(&vt_memory, index);
    vor_free(&vt_memory, xyz);
    vt_assert_no_leak();
}

START_TEST(the_index_finds_what_a_look_at_every_point_finds)
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 1 + (size_t)vor_rng_below(seed, 11, 0, 3000);

    if (_i < 5)
        n = (size_t)_i + 1;
    for (int shape = 0; shape < SHAPES; shape++) {
        compare(shape, seed, n, 1);
        compare(shape, seed, n, n < 2 ? 1 : 2);
        compare(shape, seed, n, (unsigned)(n < 21 ? n : 21));
        compare(shape, seed, n, (unsigned)(1 + vor_rng_below(seed, 12, 0, n)));
    }
}
END_TEST

START_TEST(every_point_is_found_when_all_are_asked_for)
{
    for (int shape = 0; shape < SHAPES; shape++)
        compare(shape, 99, 700, 700);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("knn_brute");

    vt_add_loop(suite, the_index_finds_what_a_look_at_every_point_finds, SEEDS);
    vt_add(suite, every_point_is_found_when_all_are_asked_for);
    return vt_run(suite);
}
