/* Parts of a cloud that are clear of each other, beside those that every pair tells. */
#include "core/base/linalg.h"
#include "core/input/domain.h"
#include "tests/support/vt_engine.h"

static uint32_t top(const uint32_t *root, uint32_t i)
{
    while (root[i] != i)
        i = root[i];
    return i;
}

/* Parts by looking at every pair. */
static void brute_join(uint32_t *root, const float *xyz, size_t n, double distance)
{
    for (uint32_t i = 0; i < n; i++) {
        root[i] = i;
        for (uint32_t j = 0; j < i; j++)
            if (vor_distance2f(&xyz[3 * (size_t)i], &xyz[3 * (size_t)j]) <= distance * distance) {
                uint32_t a = top(root, i), b = top(root, j);

                root[a > b ? a : b] = a < b ? a : b;
            }
    }
    for (uint32_t i = 0; i < n; i++)
        root[i] = top(root, i);
}

/* Blobs of different size and density in the unit cube. */
static void make_blobs(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_cube(cloud, seed, n);
    for (size_t i = 0; i < n; i++) {
        size_t blob = (size_t)(40 * vt_unit(seed + 1, i) * vt_unit(seed + 2, i));

        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] =
                (float)(vt_unit(seed + 3, 3 * blob + c) +
                        0.15 * vt_unit(seed + 4, blob) * ((double)cloud->xyz[3 * i + c] - 0.5));
    }
}

/* Every part is some of those that looking at all pairs finds at the distance, and at nine times
 * that all parts of it lie in one. */
START_TEST(joined_parts_lie_between_those_of_one_distance_and_of_nine)
{
    enum { N = 1500 };
    static const double distances[] = {0.003, 0.01, 0.02, 0.05};
    static uint32_t root[N], near[N], far[N];

    for (size_t d = 0; d < sizeof distances / sizeof *distances; d++) {
        struct vt_engine engine;
        struct vor_cloud in;
        struct vor_domain domain;
        size_t parts, counted = 0;

        make_blobs(&in, (uint64_t)_i, N);
        vt_engine_open(&engine, 2);
        vt_assert_ok(vor_domain_init(&domain, &in, &engine.run, &vt_err));
        ck_assert_uint_eq(domain.n, N);
        brute_join(near, domain.xyz, N, distances[d] * 0.999);
        brute_join(far, domain.xyz, N, distances[d] * 9.001);
        vt_assert_ok(vor_knn_join(root, &parts, domain.knn, distances[d], &engine.run, &vt_err));
        for (uint32_t i = 0; i < N && parts > 1; i++) {
            counted += root[i] == i;
            ck_assert_uint_le(root[i], i);
            ck_assert_uint_eq(root[i], root[near[i]]);
            ck_assert_uint_eq(far[i], far[root[i]]);
        }
        ck_assert_uint_eq(parts > 1 ? counted : 1, parts);
        vor_domain_free(&domain);
        vor_cloud_free(&in);
        vt_engine_close(&engine);
    }
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("join");

    vt_add_loop(suite, joined_parts_lie_between_those_of_one_distance_and_of_nine,
                VT_SOAK_LOOPS(6, 40));
    return vt_run(suite);
}
