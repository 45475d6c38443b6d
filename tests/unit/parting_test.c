/* Groups by pairs that join and part. */
#include "core/geom/parting.h"
#include "tests/support/vt_engine.h"

enum { SIDE = 40, SHEET = SIDE * SIDE, N = 2 * SHEET, MIDDLE = SHEET / 2 + SIDE / 2 };
enum { JOINING = 5, PAIRS = 9 };

/* Two square lattices over each other, of which each node has bonds to neighbors on the same one
 * and ones that part it from those over it and beside that; of each kind a share is wrong. */
static size_t lattices(struct vor_bond *bond, uint64_t seed, double wrong)
{
    static const uint32_t step[PAIRS][3] = {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 0, 0}, {0, 2, 0},
                                            {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    size_t count = 0;

    for (uint32_t i = 0; i < N; i++)
        for (uint32_t k = 0; k < PAIRS; k++) {
            uint32_t x = i % SIDE + step[k][0], y = i % SHEET / SIDE + step[k][1];
            uint32_t layer = i / SHEET + step[k][2];
            float strength = (float)(0.5 + 0.4 * vor_rng_unit(seed, 1, PAIRS * i + k));
            int lies = vor_rng_unit(seed, 2, PAIRS * i + k) < wrong;

            if (x < SIDE && y < SIDE && layer < 2)
                bond[count++] = (struct vor_bond){i, (layer * SIDE + y) * SIDE + x,
                                                  (k >= JOINING) != lies ? -strength : strength};
        }
    return count;
}

VT_TEST_LOOP(two_lattices_are_two_groups_though_some_pairs_are_wrong, 3)
{
    static struct vor_bond bond[PAIRS * N];
    static uint32_t group[N];
    size_t strange = 0, count = lattices(bond, (uint64_t)_i, _i == 0 ? 0 : 0.02);
    struct vt_engine engine;

    vt_engine_open(&engine, 1);
    vt_assert_ok(vor_parting_make(group, N, bond, count, &engine.run, &vt_err));
    vt_engine_close(&engine);
    for (uint32_t i = 0; i < N; i++)
        strange += group[i] != group[i < SHEET ? MIDDLE : SHEET + MIDDLE];
    ck_assert_uint_ne(group[MIDDLE], group[SHEET + MIDDLE]);
    ck_assert_msg(strange <= (_i == 0 ? 0 : N / 25), "%zu nodes in another group", strange);
}
