/* Chen 2018, Sec. 4.3.3 and 5.3, Fig. 10b: with p of 8 and the principal directions as axes, points
 * lie in squares along these (rows C6, C7, C8, C15). */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_trace.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { IN = 10000, OUT = 1000 };

/* Half of the length of the tube, whose radius is 1; half of the side of the cube whose edges are
 * rounded with a radius of ROUND. */
#define HALF 2.0
#define CORE 1.0
#define ROUND 0.6

/* How points lie around points. */
struct lie {
    double psi4;   /* mean of the length of the mean of exp(4 i angle) over the four nearest */
    double off;    /* median of the angle between that and the principal directions, in degrees */
    size_t points; /* of which that is */
};

/* The directions of curvature at a point that counts; false for others. */
typedef int (*frame)(const double x[3], double margin, double first[3], double second[3]);

static void make_tube(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_make(cloud, n);
    for (uint64_t i = 0; i < n; i++) {
        double turn = 2 * M_PI * vt_unit(1, 2 * i);

        cloud->xyz[3 * i] = (float)cos(turn);
        cloud->xyz[3 * i + 1] = (float)sin(turn);
        cloud->xyz[3 * i + 2] = (float)(HALF * (2 * vt_unit(1, 2 * i + 1) - 1));
    }
}

static int on_tube(const double x[3], double margin, double first[3], double second[3])
{
    const double around[3] = {-x[1], x[0], 0}, along[3] = {0, 0, 1};

    memcpy(first, around, sizeof around);
    memcpy(second, along, sizeof along);
    return fabs(x[2]) < HALF - margin;
}

/* Points around a cube's skin: those at the distance ROUND from it, drawn in a box around. */
static void make_rounded_cube(struct vor_cloud *cloud, size_t n)
{
    const double thin = 1e-2;

    vt_cloud_make(cloud, n);
    for (uint64_t i = 0, drawn = 0; i < n; drawn++) {
        double d[3], length = 0;

        for (uint64_t c = 0; c < 3; c++) {
            double x = (CORE + ROUND + thin) * (2 * vt_unit(2, 3 * drawn + c) - 1);

            d[c] = fabs(x) > CORE ? x - copysign(CORE, x) : 0;
            cloud->xyz[3 * i + c] = (float)(x - d[c]);
            length += d[c] * d[c];
        }
        length = sqrt(length);
        if (fabs(length - ROUND) > thin)
            continue;
        for (size_t c = 0; c < 3; c++)
            cloud->xyz[3 * i + c] += (float)(ROUND / length * d[c]);
        i++;
    }
}

static int on_fillet(const double x[3], double margin, double first[3], double second[3])
{
    int out = 0, along = 0;
    double normal[3] = {0};

    (void)margin;
    for (int c = 0; c < 3; c++) {
        if (fabs(x[c]) <= CORE) {
            along = c;
            continue;
        }
        normal[c] = x[c] - copysign(CORE, x[c]);
        out++;
    }
    memset(first, 0, 3 * sizeof *first);
    first[along] = 1;
    for (int c = 0; c < 3; c++)
        second[c] =
            first[(c + 1) % 3] * normal[(c + 2) % 3] - first[(c + 2) % 3] * normal[(c + 1) % 3];
    return out == 2;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Sum of exp(4 i angle) over the four points nearest to x. */
static double complex four_fold(const struct vor_cloud *cloud, size_t i, const double first[3],
                                const double second[3])
{
    double near[5], turn[5];
    double complex sum = 0;
    unsigned count = 0;

    for (size_t j = 0; j < cloud->n; j++) {
        double u = 0, v = 0, length2 = 0;
        unsigned k;

        for (size_t c = 0; c < 3; c++) {
            double d = (double)cloud->xyz[3 * j + c] - (double)cloud->xyz[3 * i + c];

            u += d * first[c];
            v += d * second[c];
            length2 += d * d;
        }
        if (j == i || (count == 4 && length2 >= near[3]))
            continue;
        for (k = count; k > 0 && near[k - 1] > length2; k--) {
            near[k] = near[k - 1];
            turn[k] = turn[k - 1];
        }
        near[k] = length2;
        turn[k] = atan2(v, u);
        count += count < 4;
    }
    for (unsigned k = 0; k < count; k++)
        sum += cexp(4 * I * turn[k]) / 4;
    return sum;
}

static struct lie look(const struct vor_cloud *cloud, double margin, frame where)
{
    static double off[OUT];
    struct lie lie = {0, 0, 0};

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3], first[3], second[3], length = 0;
        double complex sum;

        for (size_t c = 0; c < 3; c++)
            x[c] = (double)cloud->xyz[3 * i + c];
        if (!where(x, margin, first, second))
            continue;
        for (int c = 0; c < 3; c++)
            length += second[c] * second[c];
        for (int c = 0; c < 3; c++)
            second[c] /= sqrt(length);
        length = sqrt(first[0] * first[0] + first[1] * first[1] + first[2] * first[2]);
        for (int c = 0; c < 3; c++)
            first[c] /= length;
        sum = four_fold(cloud, i, first, second);
        lie.psi4 += cabs(sum);
        off[lie.points++] = fabs(carg(sum)) / 4 * 180 / M_PI;
    }
    ck_assert_uint_gt(lie.points, 100);
    lie.psi4 /= (double)lie.points;
    qsort(off, lie.points, sizeof *off, by_size);
    lie.off = off[lie.points / 2];
    return lie;
}

static struct lie spread(const struct vor_cloud *in, const char *name, const char *value,
                         frame where, struct vor_report *report)
{
    struct vt_engine engine;
    struct vor_cloud out;
    struct lie lie;

    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", OUT);
    vt_engine_set(&engine, "metric", "lp");
    vt_engine_set(&engine, name, value);
    vt_engine_resample(&engine, &out, report, in);
    lie = look(&out, 3 * report->spacing_mean, where);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return lie;
}

/* Measured with p of 2 and of 8: tube psi4 0.44 and 0.88, off 22 and 1.6 degrees; fillets 0.47 and
 * 0.92, 21 and 1.8 degrees. */
VT_TEST_FIGURES(fig_10b_points_lie_in_squares_along_the_directions_of_curvature, 2)
{
    struct vor_report report;
    struct vor_cloud in;
    struct lie two, eight;
    frame where = _i == 0 ? on_tube : on_fillet;

    if (_i == 0)
        make_tube(&in, IN);
    else
        make_rounded_cube(&in, IN);
    two = spread(&in, "p", "2", where, &report);
    ck_assert_uint_eq(report.polish_steps, 0);
    eight = spread(&in, "p", "8", where, &report);
    ck_assert_msg(eight.psi4 >= 1.8 * two.psi4, "%.3f, %.3f", eight.psi4, two.psi4);
    ck_assert_msg(eight.off <= 5, "%.1f", eight.off);
    ck_assert_uint_eq(report.polish_steps, 0);
    vor_cloud_free(&in);
}

VT_TEST(the_report_says_that_each_inner_loop_lowered_the_energy)
{
    struct vor_report report;
    struct vor_cloud in;

    make_tube(&in, IN);
    (void)spread(&in, "iterations", "8", on_tube, &report);
    ck_assert(report.has_descent);
    ck_assert_uint_eq(report.iterations, 8);
    ck_assert_int_eq(report.stopped, VOR_STOPPED_ITERATIONS);
    ck_assert_uint_gt(report.descent_steps, 0);
    ck_assert_uint_le(report.descent_steps, 8 * 5);
    ck_assert_uint_gt(report.descent_evaluations, report.descent_steps);
    ck_assert_double_lt(report.descent_worst, 1);
    ck_assert_double_gt(report.descent_worst, 0);
    ck_assert_double_ge(report.descent_aspect, 1);
    ck_assert_double_lt(report.descent_aspect, 2);
    vor_cloud_free(&in);
}

/* Sec. 5.3, Fig. 10a: Euclidean cells whose energy is that of the curvature become longer along the
 * tube, but by far not by as much as the metric says. Measured, asked for 4 and for 1: 2.4, 1.07.
 */
VT_TEST_FIGURES(fig_10a_euclidean_cells_stretch_less_than_their_metric, 2)
{
    struct vor_report report;
    struct vor_cloud in, out;

    make_tube(&in, IN);
    vt_resample(&out, &report, &in, "points=%d cells=euclid metric=%s maxAspect=4", OUT,
                _i ? "anisotropic" : "isotropic");
    ck_assert_uint_eq(report.polish_steps, 0);
    ck_assert_double_lt(report.descent_worst, 1);
    ck_assert_double_gt(report.descent_aspect, _i ? 1.8 : 1);
    ck_assert_double_lt(report.descent_aspect, _i ? 3.5 : 1.15);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}

/* Row C7: of both criteria the one that is met first ends it. */
VT_TEST_LOOP(a_run_ends_when_points_hardly_move_or_after_its_iterations, 3)
{
    static const char *const ways[3][2] = {
        {"metric", "isotropic"}, {"metric", "lp"}, {"cells", "euclid"}};
    const char *const stop[2] = {_i % 3 == 0 ? "0.15" : "0.3", "1e-9"};

    for (int k = 0; k < 2; k++) {
        struct vor_report report;
        struct vor_cloud in, out;
        struct vt_engine engine;
        struct vt_trace trace;
        double spacing;

        vt_cloud_sphere(&in, 1, 3000);
        vt_engine_open(&engine, 2);
        vt_ask_set(&engine, "points=300 polish=0 iterations=30");
        vt_engine_set(&engine, ways[_i][0], ways[_i][1]);
        vt_engine_set(&engine, "moveStop", stop[k]);
        vt_trace_attach(&trace, &engine);
        vt_engine_resample(&engine, &out, &report, &in);
        spacing = sqrt(4 * M_PI / (0.8660254 * 300));
        ck_assert_int_eq(report.stopped, k == 0 ? VOR_STOPPED_MOVE : VOR_STOPPED_ITERATIONS);
        if (k == 0) { /* the area is estimated within a few percent */
            const struct vor_record *last = &trace.record[trace.count - 1];

            ck_assert_uint_lt(report.iterations, 30);
            ck_assert_double_le(last->max_move, 1.05 * atof(stop[k]) * spacing);
            ck_assert_double_gt(trace.record[1].max_move, atof(stop[k]) * spacing);
        } else {
            ck_assert_uint_eq(report.iterations, 30);
        }
        vor_cloud_free(&out);
        vor_cloud_free(&in);
        vt_engine_close(&engine);
    }
}
