/* Metrics of planes and of space, the curvature that they are made of, cells clipped in them. */
#include "core/geom/curvature.h"
#include "core/geom/metric.h"
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 200, N = 20000, PLACES = 500, K = 32 };

/* A number from -1 to 1. */
static double draw(uint64_t seed, uint64_t index)
{
    return 2 * vt_unit(seed, index) - 1;
}

static void draw_normal(double normal[3], uint64_t seed)
{
    double length = 0;

    for (uint64_t c = 0; c < 3; c++) {
        normal[c] = vt_normal(seed, c);
        length += normal[c] * normal[c];
    }
    for (int c = 0; c < 3; c++)
        normal[c] /= sqrt(length);
}

/* A tensor of determinant 1 with that aspect and long side. */
static void with_aspect(double plane[3], double aspect, double turn)
{
    double u = cos(turn), v = sin(turn);

    plane[0] = u * u / aspect + v * v * aspect;
    plane[1] = u * v * (1 / aspect - aspect);
    plane[2] = v * v / aspect + u * u * aspect;
}

VT_TEST_LOOP(a_tensor_of_a_plane_survives_space, SEEDS)
{
    uint64_t seed = (uint64_t)_i;
    double normal[3], axis[2][3], plane[3], back[3], g[6], d[3];

    draw_normal(normal, seed);
    vor_metric_axes(axis, normal);
    for (int a = 0; a < 2; a++) {
        ck_assert_double_eq_tol(vor_dot(axis[a], normal), 0, 1e-12);
        ck_assert_double_eq_tol(vor_dot(axis[a], axis[a]), 1, 1e-12);
    }
    ck_assert_double_eq_tol(vor_dot(axis[0], axis[1]), 0, 1e-12);
    vor_cross(d, axis[0], axis[1]);
    ck_assert_double_eq_tol(vor_dot(d, normal), 1, 1e-12);
    with_aspect(plane, 1 + 5 * vt_unit(seed, 9), 3 * draw(seed, 8));
    vor_metric_raise(g, plane, axis, normal);
    vor_metric_restrict(back, g, axis);
    for (int c = 0; c < 3; c++)
        ck_assert_double_eq_tol(back[c], plane[c], 1e-12);
    ck_assert_double_eq_tol(vor_metric_length2(g, normal), 1, 1e-12);
    ck_assert_double_eq_tol(vor_metric_length2(g, axis[0]), plane[0], 1e-12);
}

VT_TEST_LOOP(a_tensor_is_scaled_and_capped_and_keeps_its_directions, SEEDS)
{
    uint64_t seed = (uint64_t)_i;
    double aspect = 1 + 9 * vt_unit(seed, 1), most = 1 + 9 * vt_unit(seed, 2);
    double turn = 3 * draw(seed, 3), scale = exp(20 * draw(seed, 4)), wanted = fmin(aspect, most);
    double plane[3], side[2];

    with_aspect(plane, aspect, turn);
    for (int c = 0; c < 3; c++)
        plane[c] *= scale;
    ck_assert(vor_metric_even(plane, most));
    ck_assert_double_eq_tol(plane[0] * plane[2] - plane[1] * plane[1], 1, 1e-9);
    ck_assert_double_eq_tol(vor_metric_aspect(plane), wanted, 1e-9 * wanted);
    vor_metric_long_side(side, plane);
    ck_assert_double_eq_tol(fabs(side[0] * cos(turn) + side[1] * sin(turn)), 1,
                            1e-10 / (wanted - 1));
}

VT_TEST(a_tensor_that_is_not_positive_becomes_that_of_all_directions)
{
    double planes[][3] = {{1, 2, 1}, {0, 0, 0}, {-1, 0, -1}, {1, 0, 0}, {NAN, 0, 1}};

    for (size_t i = 0; i < sizeof planes / sizeof planes[0]; i++) {
        ck_assert(!vor_metric_even(planes[i], 6));
        ck_assert(planes[i][0] == 1 && planes[i][1] == 0 && planes[i][2] == 1);
    }
}

/* Curvatures k and l along axes turned by 0.4: cells are longer where it bends less, whatever the
 * signs. */
VT_TEST(curvature_asks_for_the_root_of_the_ratio_of_its_sizes)
{
    const struct {
        double k, l, aspect;
    } cases[] = {{9, 1, 3},  {-9, 1, 3},       {9, -1, 3}, {-9, -1, 3},  {100, 1, 6},  {4, 4, 1},
                 {4, -4, 1}, {1e-9, 1e-12, 1}, {0, 0, 1},  {0.04, 0, 2}, {-0.04, 0, 2}};

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double u = cos(0.4), v = sin(0.4), k = cases[i].k, l = cases[i].l, plane[3], side[2];
        double bend[3] = {k * u * u + l * v * v, (k - l) * u * v, k * v * v + l * u * u};

        vor_metric_of_bend(plane, bend, 0.01, 6);
        ck_assert_double_eq_tol(vor_metric_aspect(plane), cases[i].aspect, 1e-9);
        ck_assert_double_eq_tol(plane[0] * plane[2] - plane[1] * plane[1], 1, 1e-9);
        vor_metric_long_side(side, plane);
        if (cases[i].aspect > 1)
            ck_assert_double_eq_tol(fabs(side[0] * v - side[1] * u), 1, 1e-9);
    }
}

/* On a torus: the tensor has the curvature of the tube across and that of the circle along it. */
VT_TEST(the_curvature_tensor_has_the_curvatures_of_a_torus_in_their_directions)
{
    struct vor_cloud cloud;
    struct vor_knn *knn;

    vt_cloud_torus(&cloud, 1, N);
    vt_assert_ok(vor_knn_build(&knn, cloud.xyz, N, &vt_memory, &vt_err));
    for (size_t i = 0; i < PLACES; i++) {
        const float *x = &cloud.xyz[3 * i];
        double away = hypot((double)x[0], (double)x[1]), bend[6], normal[3], sign;
        double along[3] = {-(double)x[1] / away, (double)x[0] / away, 0}, tube[3];
        double up[3] = {(double)x[0] * (1 - 1 / away), (double)x[1] * (1 - 1 / away), (double)x[2]};
        uint32_t index[K];
        float distance2[K], near[3 * K];
        struct vor_surface surface;

        vor_knn_search(knn, x, 1, K, index, distance2);
        for (unsigned j = 0; j < K; j++)
            memcpy(&near[3 * j], &cloud.xyz[3 * (size_t)index[j]], 3 * sizeof *near);
        vor_surface_fit(&surface, near, K);
        ck_assert(vor_curvature_tensor(bend, normal, &surface, near, K));
        sign = vor_dot(normal, up) / VT_TORUS_TUBE;
        ck_assert_double_eq_tol(fabs(sign), 1, 1e-4);
        vor_cross(tube, along, normal);
        sign = sign > 0 ? -1 : 1;
        ck_assert_double_eq_tol(sign * vor_metric_length2(bend, tube), 1 / VT_TORUS_TUBE, 0.01);
        ck_assert_double_eq_tol(sign * vor_metric_length2(bend, along),
                                (away - 1) / VT_TORUS_TUBE / away, 0.01);
        ck_assert_double_eq_tol(vor_metric_length2(bend, normal), 0, 1e-9);
    }
    vor_knn_free(knn);
    vor_cloud_free(&cloud);
}
