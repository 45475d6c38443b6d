/* Points that float between the points of the input around them. */
#include "core/seeds/attach.h"

#include "core/base/linalg.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { RING = 16, SIDE = 40, SEEDS = 30 };

/* A plane with a round hole, around which 16 points stand. */
static void make_hole(struct vor_cloud *cloud)
{
    size_t n = 0;

    vt_cloud_make(cloud, SIDE * SIDE);
    for (int i = 0; i < SIDE * SIDE; i++) {
        int column = i % SIDE, row = i / SIDE;
        double x = (column + 0.5) / SIDE - 0.5, y = (row + 0.5) / SIDE - 0.5;
        double angle = 2 * M_PI * i / RING;

        if (i >= RING && hypot(x, y) < 0.13)
            continue;
        cloud->xyz[3 * n] = (float)(i < RING ? 0.1 * cos(angle) : x);
        cloud->xyz[3 * n + 1] = (float)(i < RING ? 0.1 * sin(angle) : y);
        cloud->xyz[3 * n++ + 2] = 0;
    }
    cloud->n = n;
}

/* The middle of the hole, and how far its points are from there. */
static double middle_of(double middle[3], const struct vor_domain *domain)
{
    double least = INFINITY;

    memset(middle, 0, 3 * sizeof *middle);
    for (size_t i = 0; i < 3 * domain->n; i++)
        middle[i % 3] += (double)domain->xyz[i] / (double)domain->n;
    for (size_t i = 0; i < domain->n; i++) {
        double x[3];

        vor_to_doubles(x, &domain->xyz[3 * i]);
        least = fmin(least, vor_distance2(x, middle));
    }
    return sqrt(least);
}

/* Puts a seed so many radii over the middle of the hole. Says how far it is then from the nearest
 * point, in radii, and whether it was moved. */
static double attached(struct vor_seeds *seeds, double high, int *moved)
{
    struct vor_scratch *scratch = &seeds->scratch[0];
    double x[3], foot[3], way[3], radius = middle_of(x, seeds->domain);

    x[2] += high * radius;
    vor_to_floats(seeds->xyz, x);
    vor_seeds_forget_input(seeds);
    ck_assert_int_ne(vor_seeds_fit(seeds, scratch, 0), VOR_SURFACE_NONE);
    ck_assert(vor_seeds_surrounded(scratch, x));
    *moved = vor_attach_near(seeds, scratch, x);
    return vor_boundary_foot(scratch->here.near, scratch->here.k, x, foot, way) / radius;
}

VT_TEST(a_point_in_the_air_that_the_input_surrounds_comes_down)
{
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
    double radius, middle[3];
    int moved;

    vt_engine_open(&engine, 1);
    make_hole(&cloud);
    vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
    vt_assert_ok(vor_seeds_init(&seeds, &domain, SEEDS, vt_policy, &engine.run, &vt_err));
    seeds.policy.near_input = VOR_NEAR_ALWAYS;
    radius = middle_of(middle, &domain);
    /* Half a spacing of the result is half a radius. */
    seeds.area = radius * radius * SEEDS;
    ck_assert_double_eq_tol(attached(&seeds, 0.5, &moved), 0.5, 1e-3);
    ck_assert(moved);
    ck_assert_double_eq_tol(attached(&seeds, 0.1, &moved), hypot(1, 0.1), 1e-3);
    ck_assert(!moved);
    seeds.area = 0; /* of k-means */
    ck_assert_double_eq_tol(attached(&seeds, 0.5, &moved), hypot(1, 0.5), 1e-3);
    vor_seeds_free(&seeds);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
}
