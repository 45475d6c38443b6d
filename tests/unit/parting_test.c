/* Groups by pairs that join and part. */
#include "core/geom/parting.h"

#include "core/base/rng.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { SIDE = 40, N = 2 * SIDE * SIDE, MIDDLE = SIDE * SIDE / 2 + SIDE / 2 };

enum { JOINING = 5, PARTING = 4, PAIRS = JOINING + PARTING };

/* Two square lattices over each other, of which each node has bonds to neighbors on the same one
 * and ones that part it from those over it and beside that; of each kind a share is wrong. */
static size_t lattices(struct vor_bond *bond, uint64_t seed, double wrong)
{
    static const uint32_t step[PAIRS][3] = {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 0, 0}, {0, 2, 0},
                                            {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    size_t count = 0;

    for (uint32_t i = 0; i < N; i++)
        for (uint64_t k = 0; k < PAIRS; k++) {
            uint32_t at = i % (SIDE * SIDE), x = at % SIDE + step[k][0], y = at / SIDE + step[k][1];
            uint32_t layer = i / (SIDE * SIDE) + step[k][2];
            double strength = 0.5 + 0.4 * vor_rng_unit(seed, 1, PAIRS * i + k);
            int lies = vor_rng_unit(seed, 2, PAIRS * i + k) < wrong;

            if (x < SIDE && y < SIDE && layer < 2)
                bond[count++] =
                    (struct vor_bond){i, (layer * SIDE + y) * SIDE + x,
                                      (float)((k >= JOINING) != lies ? -strength : strength)};
        }
    return count;
}

static vor_status part(uint32_t *group, uint64_t seed, double wrong, int backwards)
{
    static struct vor_bond bond[PAIRS * N];
    struct vt_engine engine;
    vor_status status;
    size_t count = lattices(bond, seed, wrong);

    for (size_t e = 0; backwards && e < count / 2; e++) {
        struct vor_bond held = bond[e];

        bond[e] = bond[count - 1 - e];
        bond[count - 1 - e] = held;
    }
    vt_engine_open(&engine, 1);
    status = vor_parting_make(group, N, bond, count, &engine.run, &vt_err);
    vt_engine_close(&engine);
    return status;
}

START_TEST(two_lattices_are_two_groups_though_some_pairs_are_wrong)
{
    uint32_t group[N];
    size_t strange = 0;

    vt_assert_ok(part(group, (uint64_t)_i, _i == 0 ? 0 : 0.02, 0));
    for (uint32_t i = 0; i < N; i++)
        strange += group[i] != group[i < SIDE * SIDE ? MIDDLE : SIDE * SIDE + MIDDLE];
    ck_assert_uint_ne(group[MIDDLE], group[SIDE * SIDE + MIDDLE]);
    ck_assert_msg(strange <= (_i == 0 ? 0 : N / 25), "%zu nodes in another group", strange);
    vt_assert_no_leak();
}
END_TEST

START_TEST(the_order_of_the_pairs_does_not_matter)
{
    uint32_t forth[N], back[N];

    vt_assert_ok(part(forth, (uint64_t)_i, 0.1, 0));
    vt_assert_ok(part(back, (uint64_t)_i, 0.1, 1));
    ck_assert(memcmp(forth, back, sizeof forth) == 0);
}
END_TEST

START_TEST(those_that_were_parted_never_become_one)
{
    struct vor_bond bond[] = {{0, 1, -0.9F}, {1, 2, 0.8F}, {0, 2, 0.7F}, {2, 3, 0.1F}};
    struct vt_engine engine;
    uint32_t group[5];

    vt_engine_open(&engine, 1);
    vt_assert_ok(vor_parting_make(group, 5, bond, 4, &engine.run, &vt_err));
    vt_engine_close(&engine);
    ck_assert_uint_eq(group[0], 0);
    ck_assert_uint_eq(group[1], 1);
    ck_assert_uint_eq(group[2], 1);
    ck_assert_uint_eq(group[3], 1);
    ck_assert_uint_eq(group[4], 4);
}
END_TEST

static vor_status try_part(void *ctx)
{
    return part(ctx, 1, 0, 0);
}

START_TEST(memory_that_ends_is_an_error)
{
    uint32_t group[N];

    vt_fail_each(try_part, group);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("parting");

    vt_add_loop(suite, two_lattices_are_two_groups_though_some_pairs_are_wrong, 8);
    vt_add_loop(suite, the_order_of_the_pairs_does_not_matter, 4);
    vt_add(suite, those_that_were_parted_never_become_one);
    vt_add(suite, memory_that_ends_is_an_error);
    return vt_run(suite);
}
