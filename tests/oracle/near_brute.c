/* Lists that are reused against looking at every point, while the queries wander. */
#include "core/knn/near.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { QUERIES = 40, STEPS = 30, K_MAX = 60 };

struct walk {
    struct vor_cloud cloud;
    struct vor_knn *knn;
    struct vor_near near;
    float at[QUERIES][3];
    unsigned k;
};

static void start(struct walk *walk, uint64_t seed, size_t n, unsigned k)
{
    vt_cloud_cube(&walk->cloud, seed, n);
    vt_assert_ok(vor_knn_build(&walk->knn, walk->cloud.xyz, n, &vt_memory, &vt_err));
    vt_assert_ok(
        vor_near_init(&walk->near, QUERIES, k, walk->knn, walk->cloud.xyz, n, &vt_memory, &vt_err));
    walk->k = k;
    for (size_t i = 0; i < QUERIES; i++)
        for (size_t c = 0; c < 3; c++)
            walk->at[i][c] = (float)vt_unit(seed + 1, 3 * i + c);
}

static void end(struct walk *walk)
{
    vor_near_free(&walk->near);
    vor_knn_free(walk->knn);
    vor_cloud_free(&walk->cloud);
    vt_assert_no_leak();
}

static float distance2(const struct walk *walk, uint32_t point, const float x[3])
{
    const float *p = &walk->cloud.xyz[3 * (size_t)point];
    float a = p[0] - x[0], b = p[1] - x[1], c = p[2] - x[2];

    return a * a + b * b + c * c;
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;

    return (x > y) - (x < y);
}

/* One query: distances, sorted, equal the brute ones; the nearest comes first; no point twice. */
static int check_query(struct walk *walk, size_t i)
{
    uint32_t index[K_MAX], brute[K_MAX];
    float found[K_MAX], expected[K_MAX];
    int anew = vor_near_search(&walk->near, i, walk->at[i], index);

    vor_knn_brute(walk->cloud.xyz, walk->cloud.n, walk->at[i], 1, walk->k, brute, expected);
    for (unsigned j = 0; j < walk->k; j++) {
        found[j] = distance2(walk, index[j], walk->at[i]);
        for (unsigned before = 0; before < j; before++)
            ck_assert_uint_ne(index[before], index[j]);
    }
    ck_assert(found[0] == expected[0]);
    qsort(found, walk->k, sizeof *found, ascending);
    for (unsigned j = 0; j < walk->k; j++)
        ck_assert(found[j] == expected[j]);
    return anew;
}

START_TEST(a_wandering_query_finds_what_brute_force_finds)
{
    static const unsigned ks[] = {1, 6, 20, 40, K_MAX};
    struct walk walk;
    size_t made = 0;
    double step = _i % 3 == 0 ? 0.2 : _i % 3 == 1 ? 0.01 : 0.001;

    start(&walk, (uint64_t)_i, 60 + 300 * (size_t)(_i % 4), ks[_i % 5]);
    for (size_t s = 0; s < STEPS; s++)
        for (size_t i = 0; i < QUERIES; i++) {
            made += (size_t)check_query(&walk, i);
            for (size_t c = 0; c < 3; c++)
                walk.at[i][c] +=
                    (float)(step * (vt_unit((uint64_t)_i + 2, (s * QUERIES + i) * 3 + c) - 0.5));
        }
    ck_assert_uint_ge(made, QUERIES);
    if (step <= 0.001) /* or the lists are of no use */
        ck_assert_uint_le(made, QUERIES * STEPS / 2);
    end(&walk);
}
END_TEST

START_TEST(more_neighbours_than_the_reference_has_room_for_are_all_of_it)
{
    struct walk walk;

    start(&walk, 5, 20, 20);
    for (size_t i = 0; i < QUERIES; i++)
        (void)check_query(&walk, i);
    end(&walk);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("near");

    vt_add_loop(suite, a_wandering_query_finds_what_brute_force_finds, 30);
    vt_add(suite, more_neighbours_than_the_reference_has_room_for_are_all_of_it);
    return vt_run(suite);
}
