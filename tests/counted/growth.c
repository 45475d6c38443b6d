/* Work of stages whose loops an input or a parameter makes long: twice the input takes about twice
 * the work, and cancel is asked for in between. Core is compiled to count each branch that it takes
 * (gcc's -fsanitize-coverage=trace-pc), so that no clock judges. */
#include "core/cvt/cvt.h"
#include "core/input/ridges.h"
#include "core/kmeans/kmeans.h"
#include "core/lop/lop.h"
#include "core/output/order.h"
#include "core/remesh/remesh.h"
#include "core/seeds/sites.h"
#include "tests/support/vt_made.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What twice the input may cost: O(n log n), and a little. */
#define DOUBLED 2.3

/* Branches between two questions whether to go on, for each point and beside those: a few passes
 * over all points, and some milliseconds. */
enum { SILENT_EACH = 400, SILENT = 20000000 };

static size_t work, asked, silent;

/* The pool has one thread, for which the caller waits. */
void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
    work++;
}

static enum vor_answer poll(void *ctx)
{
    (void)ctx;
    silent = work - asked > silent ? work - asked : silent;
    asked = work;
    return VOR_CONTINUE;
}

static void begin(void)
{
    work = asked = silent = 0;
}

/* A strip six points wide, whose scalar asks for much at one end. */
static void ribbon(struct vor_cloud *cloud, size_t n)
{
    struct vor_attribute *rho;

    vt_cloud_make(cloud, n);
    vt_assert_ok(vor_cloud_add_attribute(cloud, "rho", VOR_GENERIC, VOR_FLOAT32, 1, &rho, &vt_err));
    for (size_t i = 0; i < n; i++) {
        float *x = &cloud->xyz[3 * i];

        x[0] = (float)((double)(i / 6) + 0.4 * vt_unit(1, i));
        x[1] = (float)((double)(i % 6) + 0.4 * vt_unit(2, i));
        x[2] = (float)(0.04 * vt_unit(3, i));
        ((float *)rho->data)[i] = i < 6 ? 1e8F : 1;
    }
}

/* A square ring six points wide, around a hole that takes many more. */
static void frame(struct vor_cloud *cloud, size_t n)
{
    size_t side = n / 24;

    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        size_t along = i / 6 % side, turn = i / 6 / side;
        double a = (double)along - (double)side / 2 + 0.4 * vt_unit(1, i),
               b = (double)side / 2 - (double)(i % 6) + 0.4 * vt_unit(2, i);
        float *x = &cloud->xyz[3 * i];

        x[0] = (float)(turn == 0 ? a : turn == 1 ? b : turn == 2 ? -a : -b);
        x[1] = (float)(turn == 0 ? b : turn == 1 ? -a : turn == 2 ? -b : a);
        x[2] = 0;
    }
}

/* A sheet folded at every eighth column. */
static void folds(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double along = (double)(i % 128) + 0.4 * vt_unit(1, i), fold = fmod(along, 16);

        cloud->xyz[3 * i] = (float)along;
        cloud->xyz[3 * i + 1] = (float)((double)(i / 128) + 0.4 * vt_unit(2, i));
        cloud->xyz[3 * i + 2] = (float)(fold < 8 ? fold : 16 - fold);
    }
}

/* A ball and a point two million radii away, which is at 1. */
static void far(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_sphere(cloud, 1, n);
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] = i > 2 ? cloud->xyz[i] / 2e6F : i == 0;
}

static vor_status make(struct vt_made *made)
{
    return vt_made_make(made, made->cloud.n / 3);
}

static vor_status put_sites(struct vt_made *made)
{
    struct vor_sites_for wanted = {.n = 64 * made->cloud.n, .borders = 1, .edges = 1};
    struct vor_sites sites = {.memory = NULL};
    vor_status status = make(made);

    wanted.area = sqrt(2) * (double)made->cloud.n / (made->domain.unit * made->domain.unit);
    begin();
    if (status == VOR_OK)
        status = vor_sites_find(&sites, &made->domain, &wanted, &made->engine.run, &vt_err);
    ck_assert_uint_gt(sites.n, made->cloud.n / 4);
    vor_sites_free(&sites);
    return status;
}

static vor_status put_in_order(struct vt_made *made)
{
    const struct vor_cloud *cloud = &made->cloud;
    uint32_t *order = malloc(cloud->n * sizeof *order);
    vor_status status;

    ck_assert_ptr_nonnull(order);
    status =
        vor_order_progressive(order, cloud->xyz, cloud->n, sqrt(4 * M_PI / (double)cloud->n) / 2e6,
                              &made->engine.run, &vt_err);
    free(order);
    return status;
}

/* Spreads points by the method of the request. */
static vor_status spread(struct vt_made *made)
{
    static vor_status (*const run[])(struct vor_seeds *, struct vor_outcome *,
                                     const struct vor_domain *, size_t, const struct vor_spec *,
                                     const struct vor_run *, struct vor_error *) = {
        vor_cvt_run, vor_kmeans_run, vor_wlop_run, vor_ear_run, vor_remesh_run};
    struct vor_seeds seeds = {.n = 0};
    struct vor_outcome told = {.stages = 0};
    vor_status status = make(made);

    begin();
    if (status == VOR_OK)
        status = run[(int)made->engine.spec.value[VOR_PARAM_METHOD]](
            &seeds, &told, &made->domain, made->cloud.n / 3, &made->engine.spec, &made->engine.run,
            &vt_err);
    ck_assert_uint_eq(seeds.n, made->cloud.n / 3);
    vor_seeds_free(&seeds);
    return status;
}

struct row {
    const char *name;
    void (*cloud)(struct vor_cloud *cloud, size_t n);
    vor_status (*stage)(struct vt_made *made);
    size_t n;
    const char *set[8]; /* parameters and values */
};

static const struct row rows[] = {
    {"density",
     ribbon,
     make,
     4000,
     {"density", "attribute:rho", "contrast", "100", "grading", "0.001"}},
    {"a hole of a long rim", ribbon, make, 8000, {"boundary", "fill", "holes", "1"}},
    {"sites on edges", folds, put_sites, 4000, {NULL}},
    {"an order beside a far point", far, put_in_order, 8000, {NULL}},
    {"k-means", ribbon, spread, 4000, {"method", "kmeans", "iterations", "5", "polish", "0"}},
    {"projection", ribbon, spread, 4000, {"method", "wlop", "rounds", "1", "polish", "5"}},
    {"iterations", folds, spread, 4000, {"iterations", "3", "polish", "5"}},
    {"remeshing", ribbon, spread, 4000, {"method", "isotropic", "iterations", "3", "polish", "0"}},
};

static const struct row wide_hole = {
    "a wide hole", frame, make, 2400, {"boundary", "fill", "holes", "2"}};

static double read_work(void *ctx)
{
    (void)ctx;
    return (double)work;
}

/* Runs a stage, which is late after so much work; 0 for never. Returns how much it did. */
static size_t work_of(struct vt_made *made, const struct row *row, size_t n, size_t late)
{
    const struct vor_watch watch = {.poll = poll, .clock = read_work};

    memset(made, 0, sizeof *made);
    vt_engine_open(&made->engine, 1);
    made->engine.run.watch = &watch;
    made->engine.run.late = (double)late;
    row->cloud(&made->cloud, n);
    vt_engine_count(&made->engine, "points", n / 3);
    for (size_t i = 0; row->set[i] != NULL; i += 2)
        vt_engine_set(&made->engine, row->set[i], row->set[i + 1]);
    begin();
    vt_assert_ok(row->stage(made));
    (void)poll(NULL);
    made->engine.run.watch = NULL;
    return asked;
}

static size_t all_work_of(const struct row *row, size_t n)
{
    struct vt_made made;
    size_t all = work_of(&made, row, n, 0);

    printf("# %s: %zu points, %zu branches, %zu in silence\n", row->name, n, all, silent);
    ck_assert_msg(silent <= SILENT + SILENT_EACH * n, "%s: %zu branches in silence", row->name,
                  silent);
    vt_made_close(&made);
    return all;
}

VT_TEST_LOOP(twice_the_points_take_twice_the_work, sizeof rows / sizeof *rows)
{
    const struct row *row = &rows[_i];
    size_t before = all_work_of(row, row->n), after = all_work_of(row, 4 * row->n);

    ck_assert_msg((double)after <= DOUBLED * DOUBLED * (double)before,
                  "%s: %zu branches, then %zu of four times the points", row->name, before, after);
}

VT_TEST(a_hole_stays_open_once_the_time_is_over)
{
    struct vt_made made;
    size_t all = all_work_of(&wide_hole, wide_hole.n);
    size_t some = work_of(&made, &wide_hole, wide_hole.n, all / 2);

    ck_assert_msg(some < all * 3 / 4, "%zu of %zu branches", some, all);
    ck_assert_uint_eq(made.domain.known.holes.filled, 0);
    ck_assert_uint_eq(made.domain.known.holes.not_closed, 1);
    vt_made_close(&made);
}

/* A straight edge that runs into a circle: the line ends where it comes back to itself. */
VT_TEST(a_line_follows_an_edge_once)
{
    enum { TAIL = 100, ROUND = 400, N = TAIL + ROUND, ACROSS = 5 };
    const double radius = ROUND / (2 * M_PI);
    struct vt_made made = {.domain = {.n = 0}};
    struct vor_edges edges = {.n = N, .flagged = N};
    unsigned char flag[N];
    float way[3 * N] = {0}, foot[3 * N] = {0};
    struct vor_ridges ridges;

    vt_engine_open(&made.engine, 1);
    vt_cloud_make(&made.cloud, ACROSS * N);
    for (size_t i = 0; i < N; i++) {
        double s = (double)i - TAIL, angle = s > 0 ? s / radius : 0;

        flag[i] = 1;
        way[3 * i] = (float)cos(angle);
        way[3 * i + 1] = (float)sin(angle);
        foot[3 * i] = (float)(s > 0 ? radius * sin(angle) : s);
        foot[3 * i + 1] = (float)(radius * (1 - cos(angle)));
        for (size_t j = 0; j < ACROSS; j++) {
            memcpy(&made.cloud.xyz[3 * (ACROSS * i + j)], &foot[3 * i], 3 * sizeof *foot);
            made.cloud.xyz[3 * (ACROSS * i + j) + 2] = (float)j;
        }
    }
    vt_assert_ok(vor_domain_init(&made.domain, &made.cloud, &made.engine.run, &vt_err));
    for (size_t i = 0; i < 3 * N; i++)
        foot[i] = (float)((double)foot[i] / made.domain.unit);
    edges.flag = flag;
    edges.direction = way;
    edges.foot = foot;
    vt_assert_ok(vor_ridges_follow(&ridges, &made.domain, &edges, &made.engine.run, &vt_err));
    ck_assert_uint_eq(ridges.count, 1);
    ck_assert_double_eq_tol((double)ridges.places * ridges.ridge->spacing / 2 * made.domain.unit, N,
                            N / 20);
    vor_ridges_free(&ridges);
    vt_made_close(&made);
}
