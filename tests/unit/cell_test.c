/* The patch and its clipping: areas, centroids and energies known by hand. */
#include "core/base/linalg.h"
#include "core/geom/cell.h"
#include "core/geom/integrate.h"
#include "tests/support/vt.h"

#include <string.h>

enum { SEEDS = 15 };

#define HEXAGON_AREA 2.59807621135331594   /* 3 sqrt(3) / 2 */
#define HEXAGON_ENERGY 1.08253175473054831 /* 5 sqrt(3) / 8 */
#define OCTAGON_AREA 2.82842712474619010   /* 2 sqrt(2) */
#define OCTAGON_ENERGY 1.27614237491539670 /* sqrt(2) (2 + sqrt(1/2)) / 3 */

/* The plane w = height in world axes. */
static struct vor_surface flat(double height)
{
    return (struct vor_surface){.kind = VOR_SURFACE_PLANE,
                                .axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                .c = {height},
                                .reach = 1};
}

static void begin_polygon(struct vor_cell *cell, unsigned sides, unsigned rings,
                          const double seed[3], double radius)
{
    struct vor_surface surface = flat(seed[2]);
    struct vor_disc disc;

    vor_disc_init(&disc, sides, rings);
    vor_cell_begin(cell, &disc, &surface, seed, radius);
}

static void begin_flat(struct vor_cell *cell, unsigned rings, const double seed[3], double radius)
{
    begin_polygon(cell, VOR_PATCH_HEXAGON, rings, seed, radius);
}

static void clip(struct vor_cell *cell, double x, double y, double z)
{
    vor_cell_clip(cell, (double[3]){x, y, z});
}

/* The discs that there are: the sides, the area, and the most rings that fit. */
static const struct {
    unsigned sides, rings_max;
    double area, energy;
} discs[] = {{VOR_PATCH_HEXAGON, VOR_PATCH_RINGS_MAX, HEXAGON_AREA, HEXAGON_ENERGY},
             {VOR_PATCH_OCTAGON, VOR_PATCH_RINGS_MAX - 1, OCTAGON_AREA, OCTAGON_ENERGY}};

enum { DISCS = sizeof discs / sizeof *discs };

VT_TEST_LOOP(an_unclipped_patch_has_the_moments_of_its_polygon, DISCS)
{
    const double seed[3] = {3, -4, 5}, radius = 2;
    struct vor_cell cell;
    struct vor_moments m;

    for (unsigned rings = 0; rings <= discs[_i].rings_max; rings++) {
        begin_polygon(&cell, discs[_i].sides, rings, seed, radius);
        ck_assert(vor_cell_moments(&m, &cell));
        ck_assert_double_eq_tol(m.area, discs[_i].area * 4, 1e-12);
        ck_assert_double_eq_tol(m.energy, discs[_i].energy * 16, 1e-12);
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(m.centroid[c], seed[c], 1e-12);
        ck_assert_double_eq_tol(cell.radius2, 4, 1e-14);
        ck_assert_uint_eq(cell.bisectors, 0);
    }
}

/* Vector: four neighbours one apart leave the unit square; its energy is 1/6. */
VT_TEST(four_neighbours_leave_the_unit_square)
{
    const double seed[3] = {3, -4, 5};
    struct vor_cell cell;
    struct vor_moments m;

    for (unsigned rings = 0; rings <= VOR_PATCH_RINGS_MAX; rings++) {
        begin_flat(&cell, rings, seed, 2);
        clip(&cell, 1, 0, 0);
        clip(&cell, -1, 0, 0);
        clip(&cell, 0, 1, 0);
        clip(&cell, 0, -1, 0);
        ck_assert(vor_cell_moments(&m, &cell));
        ck_assert_double_eq_tol(m.area, 1, 1e-13);
        ck_assert_double_eq_tol(m.energy, 1.0 / 6, 1e-13);
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(m.centroid[c], seed[c], 1e-13);
        ck_assert_double_eq_tol(cell.radius2, 0.5, 1e-13);
        ck_assert_uint_eq(cell.bisectors, 4);
    }
}

/* Vector: [-1/2, 1] x [-1/2, 1/2]; energy = ((1 + 1/8) / 3 + 1.5 / 12). */
VT_TEST(an_uneven_rectangle_has_its_centroid_off_the_seed)
{
    const double seed[3] = {0, 0, 0};
    struct vor_cell cell;
    struct vor_moments m;

    begin_flat(&cell, 3, seed, 4);
    clip(&cell, 2, 0, 0);
    clip(&cell, -1, 0, 0);
    clip(&cell, 0, 1, 0);
    clip(&cell, 0, -1, 0);
    ck_assert(vor_cell_moments(&m, &cell));
    ck_assert_double_eq_tol(m.area, 1.5, 1e-13);
    ck_assert_double_eq_tol(m.centroid[0], 0.25, 1e-13);
    ck_assert_double_eq_tol(m.centroid[1], 0, 1e-13);
    ck_assert_double_eq_tol(m.energy, (1 + 0.125) / 3 + 1.5 / 12, 1e-13);
    ck_assert_double_eq_tol(cell.radius2, 1.25, 1e-13);
}

/* Vector: six neighbours of a hexagonal lattice with spacing 1 leave area sqrt(3) / 2. */
VT_TEST(six_neighbours_leave_the_cell_of_a_hexagonal_lattice)
{
    const double seed[3] = {0, 0, 0}, side = 1 / sqrt(3);
    struct vor_cell cell;
    struct vor_moments m;

    begin_flat(&cell, 2, seed, 1);
    for (int i = 0; i < 6; i++)
        clip(&cell, cos(M_PI / 3 * i), sin(M_PI / 3 * i), 0);
    ck_assert(vor_cell_moments(&m, &cell));
    ck_assert_double_eq_tol(m.area, sqrt(3) / 2, 1e-13);
    ck_assert_double_eq_tol(m.energy, HEXAGON_ENERGY * pow(side, 4), 1e-13);
    ck_assert_double_eq_tol(cell.radius2, side * side, 1e-13);
}

VT_TEST(a_neighbour_too_far_to_cut_changes_nothing)
{
    const double seed[3] = {0, 0, 0};
    struct vor_cell cell, before;

    begin_flat(&cell, 2, seed, 1);
    memcpy(&before, &cell, sizeof cell);
    clip(&cell, 2.001, 0, 0);
    ck_assert(memcmp(&before, &cell, sizeof cell) == 0);
    ck_assert(!vor_cell_secure(&cell, 3.999) && vor_cell_secure(&cell, 4));
    clip(&cell, 1.999, 0, 0);
    ck_assert_uint_eq(cell.bisectors, 1);
}

/* The surface lies ten below the seed, and a neighbour lies on it: nothing is left. */
VT_TEST(a_seed_far_off_its_surface_may_have_no_cell)
{
    const double seed[3] = {0, 0, 10};
    struct vor_surface surface = flat(0);
    struct vor_disc disc;
    struct vor_cell cell;
    struct vor_moments m;
    double local[3];

    vor_disc_init(&disc, VOR_PATCH_HEXAGON, 2);
    vor_cell_begin(&cell, &disc, &surface, seed, 1);
    ck_assert_double_eq_tol(cell.radius2, 101, 1e-12);
    clip(&cell, 0, 0, -10);
    ck_assert_uint_eq(cell.count, 0);
    ck_assert(!vor_cell_moments(&m, &cell));
    vor_cell_sample(&cell, 0, 1, (const double[1][3]){{0.5, 0.5, 0.5}}, &local);
    ck_assert(memcmp(local, seed, sizeof local) == 0);
}

/* A random cell: a bowl clipped by random bisectors. */
static void random_cell(struct vor_cell *cell, uint64_t seed, double offset[12][3])
{
    struct vor_surface surface = flat(0.1);
    struct vor_disc disc;

    surface.kind = VOR_SURFACE_QUADRIC;
    for (uint64_t c = 0; c < 3; c++)
        surface.c[3 + c] = 0.6 * vt_unit(seed, c) - 0.3;
    surface.reach = 10;
    vor_disc_init(&disc, VOR_PATCH_HEXAGON, 3);
    vor_cell_begin(cell, &disc, &surface, (double[3]){0.1, -0.2, 0.1}, 1);
    for (uint64_t i = 0; i < 12; i++) {
        double angle = 2 * M_PI * vt_unit(seed, 10 + 3 * i);
        double length = 0.8 + 1.2 * vt_unit(seed, 11 + 3 * i);

        offset[i][0] = length * cos(angle);
        offset[i][1] = length * sin(angle);
        offset[i][2] = 0.4 * vt_unit(seed, 12 + 3 * i) - 0.2;
        vor_cell_clip(cell, offset[i]);
    }
}

VT_TEST_LOOP(a_sample_lies_in_the_cell, SEEDS)
{
    double offset[12][3];
    struct vor_cell cell;
    struct vor_moments m;

    random_cell(&cell, (uint64_t)_i, offset);
    ck_assert(vor_cell_moments(&m, &cell));
    for (uint64_t s = 0; s < 500; s++) {
        double unit[3], local[3];

        for (uint64_t c = 0; c < 3; c++)
            unit[c] = vt_unit((uint64_t)_i + 77, 3 * s + c);
        vor_cell_sample(&cell, m.area, 1, &unit, &local);
        for (int c = 0; c < 3; c++)
            local[c] -= cell.seed[c];
        ck_assert_double_le(vor_dot(local, local), cell.radius2 * (1 + 1e-12));
        for (int i = 0; i < 12; i++)
            ck_assert_double_le(vor_dot(local, offset[i]),
                                vor_dot(offset[i], offset[i]) / 2 + 1e-12);
    }
}

/* The order in which bisectors cut does not matter, and one that cut does not cut again. */
VT_TEST_LOOP(a_cell_depends_on_its_bisectors_but_not_on_their_order, SEEDS)
{
    double offset[12][3];
    struct vor_surface surface = flat(0);
    struct vor_disc disc;
    struct vor_cell cell, other;
    struct vor_moments a, b;
    unsigned cuts;

    random_cell(&cell, (uint64_t)_i, offset);
    vor_disc_init(&disc, VOR_PATCH_HEXAGON, 3);
    vor_cell_begin(&cell, &disc, &surface, (double[3]){0, 0, 0}, 1);
    vor_cell_begin(&other, &disc, &surface, (double[3]){0, 0, 0}, 1);
    for (int i = 0; i < 12; i++) {
        vor_cell_clip(&cell, offset[i]);
        vor_cell_clip(&other, offset[11 - i]);
    }
    ck_assert(vor_cell_moments(&a, &cell) && vor_cell_moments(&b, &other));
    ck_assert_double_eq_tol(a.area, b.area, 1e-12);
    ck_assert_double_eq_tol(a.energy, b.energy, 1e-12);
    ck_assert_double_eq_tol(cell.radius2, other.radius2, 1e-12);
    for (int c = 0; c < 3; c++)
        ck_assert_double_eq_tol(a.centroid[c], b.centroid[c], 1e-12);
    cuts = cell.bisectors;
    clip(&cell, 10, 10, 0);
    ck_assert_uint_eq(cell.bisectors, cuts);
}

enum { AROUND = 12 };

/* Seeds around one, no two of them near each other, on a surface that bends by so much. */
struct ring {
    struct vor_surface surface;
    float xyz[3 * (AROUND + 1)];
    uint32_t index[AROUND];
    struct vor_cell_around around;
};

static void place(struct ring *ring, size_t i, double u, double v)
{
    ring->xyz[3 * i] = (float)u;
    ring->xyz[3 * i + 1] = (float)v;
    ring->xyz[3 * i + 2] = (float)vor_surface_height(&ring->surface, u, v, NULL);
}

static void make_ring(struct ring *ring, uint64_t seed, double bend)
{
    memset(ring, 0, sizeof *ring);
    ring->surface = flat(0);
    ring->surface.kind = VOR_SURFACE_QUADRIC;
    ring->surface.reach = 10;
    for (uint64_t c = 0; c < 5; c++)
        ring->surface.c[1 + c] = bend * (vt_unit(seed, c) - 0.5);
    place(ring, 0, 0, 0);
    for (uint64_t j = 0; j < AROUND; j++) {
        double angle = M_PI / 3 * ((double)(j % 6) + 0.5 * vt_unit(seed, 20 + j));
        double length = (j < 6 ? 0.9 : 1.1) + 0.2 * vt_unit(seed, 40 + j);

        place(ring, (size_t)(j + 1), length * cos(angle), length * sin(angle));
        ring->index[j] = (uint32_t)(j + 1);
        if (bend <= 0) /* off the plane, as those of another sheet are */
            ring->xyz[3 * (j + 1) + 2] = (float)(1.6 * vt_unit(seed, 60 + j) - 0.8);
    }
    ring->around = (struct vor_cell_around){ring->xyz, 0, ring->index, AROUND, bend > 0};
}

/* Moments of the cell that clipping the patch gives. */
static void clipped(struct vor_moments *out, const struct ring *ring, unsigned rings)
{
    const double seed[3] = {0};
    struct vor_disc disc;
    struct vor_cell cell;

    vor_disc_init(&disc, VOR_PATCH_HEXAGON, rings);
    vor_cell_begin(&cell, &disc, &ring->surface, seed, 1.1);
    for (size_t j = 0; j < AROUND; j++)
        (void)vor_cell_clip_by(&cell, ring->surface.axis, ring->xyz, 0, &ring->index[j], 1);
    ck_assert(vor_cell_moments(out, &cell));
}

/* The slow twin clips a patch by all seeds; where that bends, of as many triangles as there may
 * be: the two are then of different triangles. */
VT_TEST_LOOP(a_wrapped_cell_is_the_clipped_one, 3 * SEEDS)
{
    const double seed[3] = {0}, bend = _i % 3 * 0.3, exact = bend > 0 ? 0.03 : 1e-6;
    struct vor_cell cell;
    struct vor_moments wrap, clip;
    struct ring ring;

    make_ring(&ring, (uint64_t)_i, bend);
    ck_assert(vor_cell_wrap(&cell, &ring.surface, seed, 0.95, &ring.around));
    ck_assert_uint_eq(cell.count, bend > 0 ? cell.bisectors : 1);
    ck_assert(vor_cell_moments(&wrap, &cell));
    clipped(&clip, &ring, bend > 0 ? VOR_PATCH_RINGS_MAX : 0);
    ck_assert_double_eq_tol(wrap.area, clip.area, exact * clip.area);
    ck_assert_double_eq_tol(wrap.energy, clip.energy, 2 * exact * clip.energy);
    for (int c = 0; c < 3; c++)
        ck_assert_double_eq_tol(wrap.centroid[c], clip.centroid[c], exact);
}

VT_TEST(a_cell_that_reaches_too_far_is_not_wrapped)
{
    const double seed[3] = {0};
    struct vor_cell cell;
    struct ring ring;

    make_ring(&ring, 1, 0);
    ck_assert(!vor_cell_wrap(&cell, &ring.surface, seed, 0.5, &ring.around));
    for (ring.around.count = 0; ring.around.count < 3; ring.around.count++) /* open to a side */
        ck_assert(!vor_cell_wrap(&cell, &ring.surface, seed, 1e9, &ring.around));
    ring.around.count = AROUND;
    memcpy(&ring.xyz[3], ring.xyz, 3 * sizeof *ring.xyz); /* coincides with it */
    ck_assert(!vor_cell_wrap(&cell, &ring.surface, seed, 0.95, &ring.around));
}
