/* The stages of the engine one by one, as the drivers try them: the same bytes for any number of
 * threads; short of memory or cancelled, a clear status and nothing left or written. Whole requests
 * are in tests/property/methods_threads.c and methods_interrupted.c. */
#include "core/base/morton.h"
#include "core/cvt/frozen.h"
#include "core/geom/march.h"
#include "core/input/adjacency.h"
#include "core/input/edges.h"
#include "core/input/islands.h"
#include "core/input/lattice.h"
#include "core/input/loops.h"
#include "core/input/orient.h"
#include "core/input/outliers.h"
#include "core/input/satellites.h"
#include "core/input/thin.h"
#include "core/knn/point_lists.h"
#include "core/mesh/mesh.h"
#include "core/opt/anderson.h"
#include "core/opt/lbfgs.h"
#include "core/output/order.h"
#include "core/seeds/start.h"
#include "tests/support/vt_methods.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 60, MOST = 40000 };

static void hash_domain(struct vt_call *call, const struct vor_domain *domain)
{
    vt_call_hash(call, domain->xyz, 3 * domain->n * sizeof *domain->xyz);
    vt_call_hash(call, domain->source, domain->n * sizeof *domain->source);
}

static vor_status domain(struct vt_call *call)
{
    struct vor_domain *out = (void *)call->out;
    vor_status status = vor_domain_init(out, call->in, call->run, &vt_err);

    if (status == VOR_OK) {
        hash_domain(call, out);
        vor_domain_free(out);
    }
    return status;
}

typedef vor_status (*stage)(struct vt_call *call, struct vor_domain *domain);

/* Runs a stage on the domain of the input. */
static vor_status on_domain(struct vt_call *call, stage run)
{
    struct vor_domain made;
    vor_status status = vor_domain_init(&made, call->in, call->run, &vt_err);

    if (status != VOR_OK)
        return status;
    status = run(call, &made);
    vor_domain_free(&made);
    return status;
}

#define ON_DOMAIN(name)                                                                            \
    static vor_status name##_of(struct vt_call *call, struct vor_domain *domain);                  \
    static vor_status name(struct vt_call *call)                                                   \
    {                                                                                              \
        return on_domain(call, name##_of);                                                         \
    }                                                                                              \
    static vor_status name##_of(struct vt_call *call, struct vor_domain *domain)

static vor_status take_lists(struct vt_call *call, vor_status status)
{
    struct vor_graph *graph = (void *)call->out;

    if (status == VOR_OK) {
        for (size_t i = 0; i < graph->n; i++)
            vt_call_hash(call, &graph->list[i * graph->most], graph->count[i] * sizeof(uint32_t));
        vt_call_hash(call, graph->normal, 3 * graph->n * sizeof *graph->normal);
        vor_graph_free(graph);
    }
    return status;
}

ON_DOMAIN(adjacency)
{
    return take_lists(call, vor_adjacency_make((void *)call->out, domain, call->run, &vt_err));
}

ON_DOMAIN(satellites)
{
    return take_lists(call, vor_satellites_make((void *)call->out, domain, call->run, &vt_err));
}

ON_DOMAIN(edges)
{
    struct vor_edges *out = (void *)call->out;
    vor_status status = vor_edges_find(out, domain, call->run, &vt_err);

    if (status == VOR_OK) {
        ck_assert_uint_gt(out->flagged, 0);
        vt_call_hash(call, out->flag, out->n);
        vt_call_hash(call, out->strength, out->n * sizeof *out->strength);
        vt_call_hash(call, out->direction, 3 * out->n * sizeof *out->direction);
        vt_call_hash(call, out->foot, 3 * out->n * sizeof *out->foot);
        vor_edges_free(out);
    }
    return status;
}

ON_DOMAIN(loops)
{
    struct vor_loops *out = (void *)call->out;
    vor_status status = vor_loops_find(out, domain, call->run, &vt_err);

    if (status == VOR_OK) {
        ck_assert_uint_gt(out->count, 0);
        vt_call_hash(call, out->point, out->points * sizeof *out->point);
        vor_loops_free(out);
    }
    return status;
}

ON_DOMAIN(orient)
{
    const struct vor_orient_how how = {.points = SEEDS};
    struct vor_orientation *out = (void *)call->out;
    vor_status status = vor_orient(out, domain, &how, call->run, &vt_err);

    if (status == VOR_OK) {
        vt_call_hash(call, out->normal, 3 * domain->n * sizeof *out->normal);
        vor_orientation_free(out, &vt_memory);
    }
    return status;
}

ON_DOMAIN(lattice)
{
    struct vor_lattice found;
    size_t moved = 0;
    vor_status status = vor_lattice_find(&found, domain, call->run, &vt_err);

    if (status == VOR_OK)
        status = vor_lattice_smooth(domain, &moved, &found, call->run, &vt_err);
    ck_assert(status != VOR_OK || moved > 0);
    vt_call_hash(call, &moved, sizeof moved);
    hash_domain(call, domain);
    return status;
}

ON_DOMAIN(outliers)
{
    struct vor_outliers out = {.memory = call->run->memory};
    vor_status status = vor_outliers_take(&out, domain, 1, call->run, &vt_err);

    if (status == VOR_OK) {
        ck_assert_uint_gt(out.n, 0);
        vt_call_hash(call, out.source, out.n * sizeof *out.source);
        hash_domain(call, domain);
    }
    vor_outliers_free(&out);
    return status;
}

ON_DOMAIN(islands)
{
    vor_status status = vor_islands_take(domain, 0, call->run, &vt_err);

    ck_assert(status != VOR_OK || domain->n < call->in->n);
    hash_domain(call, domain);
    return status;
}

ON_DOMAIN(thin)
{
    struct vor_domain *out = (void *)call->out;
    vor_status status = vor_domain_thin(out, domain, 0.1, call->run, &vt_err);

    if (status == VOR_OK) {
        hash_domain(call, out);
        vor_domain_free(out);
    }
    return status;
}

ON_DOMAIN(start)
{
    struct vor_seeds *out = (void *)call->out;
    struct vor_spec spec;
    vor_status status;

    vor_spec_init(&spec);
    status = vor_start_seeds(out, domain, SEEDS, &spec, call->run, &vt_err);
    if (status == VOR_OK) {
        vt_call_hash(call, out->xyz, 3 * out->n * sizeof *out->xyz);
        vor_seeds_free(out);
    }
    return status;
}

/* Value and gradient of the energy while cells stand still. */
static vor_status evaluate(struct vt_call *call, struct vor_frozen *frozen)
{
    double y[2 * SEEDS], gradient[2 * SEEDS], value = 0;
    vor_status status = vor_frozen_set(frozen, 8, y, call->run, &vt_err);

    if (status == VOR_OK)
        status = vor_frozen_at(frozen, y, &value, gradient, &vt_err);
    if (status == VOR_OK) {
        vt_call_hash(call, &value, sizeof value);
        vt_call_hash(call, gradient, sizeof gradient);
    }
    return status;
}

ON_DOMAIN(frozen)
{
    struct vor_frozen made = {NULL};
    struct vor_seeds seeds;
    struct vor_spec spec;
    vor_status status;

    vor_spec_init(&spec);
    status = vor_start_seeds(&seeds, domain, SEEDS, &spec, call->run, &vt_err);
    if (status != VOR_OK)
        return status;
    status = vor_frozen_init(&made, &seeds, 1, &vt_err);
    if (status == VOR_OK)
        status = evaluate(call, &made);
    vor_frozen_free(&made);
    vor_seeds_free(&seeds);
    return status;
}

ON_DOMAIN(mesh)
{
    const struct vor_mesh_how how = {.moves = 1};
    struct vor_report report = {.delta = 0};
    struct vor_seeds seeds;
    struct vor_mesh made;
    struct vor_spec spec;
    vor_status status;

    vor_spec_init(&spec);
    domain->known.lists = VOR_LISTS_LOCAL;
    status = vor_start_seeds(&seeds, domain, SEEDS, &spec, call->run, &vt_err);
    if (status != VOR_OK)
        return status;
    vor_mesh_init(&made, &vt_memory);
    seeds.normal = vor_calloc(call->run->memory, SEEDS, 3 * sizeof *seeds.normal);
    for (size_t i = 0; i < SEEDS && seeds.normal != NULL; i++)
        seeds.normal[3 * i + 2] = 1;
    status = seeds.normal != NULL ? vor_seeds_index(&seeds, call->run, &vt_err)
                                  : vor_fail(&vt_err, VOR_E_NOMEM, "normals");
    if (status == VOR_OK)
        status = vor_mesh_make(&made, &report, &seeds, &how, &vt_err);
    ck_assert((status == VOR_OK) == (made.count > 0));
    vt_call_hash(call, made.triangle, 3 * made.count * sizeof *made.triangle);
    vor_mesh_free(&made);
    vor_seeds_free(&seeds);
    return status;
}

ON_DOMAIN(march)
{
    static float far[MOST];
    const uint32_t source = 0;
    struct vor_march made = {NULL};
    struct vor_graph graph;
    vor_status status = vor_adjacency_make(&graph, domain, call->run, &vt_err);

    if (status != VOR_OK)
        return status;
    status = vor_march_init(&made, &graph, domain->xyz, &vt_err);
    if (status == VOR_OK)
        status = vor_march_from(&made, far, &source, 1, call->run, &vt_err);
    vt_call_hash(call, far, domain->n * sizeof *far);
    vor_march_free(&made);
    vor_graph_free(&graph);
    return status;
}

ON_DOMAIN(tree)
{
    struct vor_knn **out = (void *)call->out;
    uint32_t nearest[8];
    float distance2[8];
    vor_status status = vor_knn_build_sorted(out, domain->xyz, domain->n, call->run, &vt_err);

    if (status == VOR_OK) {
        vor_knn_search(*out, call->in->xyz, 1, 8, nearest, distance2);
        vt_call_hash(call, distance2, sizeof distance2);
        vor_knn_free(*out);
    }
    return status;
}

static vor_status flann(struct vt_call *call)
{
    struct vor_knn **out = (void *)call->out;
    vor_status status = vor_knn_build(out, call->in->xyz, call->in->n, &vt_memory, &vt_err);

    if (status == VOR_OK)
        vor_knn_free(*out);
    return status;
}

ON_DOMAIN(point_lists)
{
    struct vor_point_lists made;
    vor_status status = vor_point_lists_init(&made, domain->n, 20, &vt_memory, &vt_err);

    if (status != VOR_OK)
        return status;
    status = vor_point_lists_index(&made, domain->xyz, call->run, &vt_err);
    vor_point_lists_free(&made);
    return status;
}

static uint32_t order[MOST];

static vor_status morton(struct vt_call *call)
{
    vor_status status = vor_morton_order(order, call->in->xyz, call->in->n, call->run, &vt_err);

    vt_call_hash(call, order, call->in->n * sizeof *order);
    return status;
}

static vor_status progressive(struct vt_call *call)
{
    size_t n = call->in->n;
    double spacing = n == MOST ? 0.006 : 0;
    vor_status status = vor_order_progressive(order, call->in->xyz, n, spacing, call->run, &vt_err);

    vt_call_hash(call, order, n * sizeof *order);
    return status;
}

static vor_status anderson(struct vt_call *call)
{
    struct vor_anderson made;
    vor_status status = vor_anderson_init(&made, 3 * call->in->n, 4, &vt_memory, &vt_err);

    if (status == VOR_OK)
        vor_anderson_free(&made);
    return status;
}

static vor_status lbfgs(struct vt_call *call)
{
    struct vor_lbfgs made;
    vor_status status = vor_lbfgs_init(&made, 3 * call->in->n, &vt_memory, &vt_err);

    if (status == VOR_OK)
        vor_lbfgs_free(&made);
    return status;
}

static void make_strewn(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < 3 * n / 30; i++)
        cloud->xyz[i] *= (float)(2 + vt_unit(seed, i / 3));
}

/* A third of the points are said twice. */
static void make_doubled(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_cube(cloud, seed, n);
    memcpy(&cloud->xyz[n / 3 * 6], cloud->xyz, n / 3 * 3 * sizeof *cloud->xyz);
}

static void make_rounded(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] = 0.125F * floorf(8 * cloud->xyz[i]);
}

static void make_sheets(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sheets(cloud, seed, n, 0.02);
}

static const struct vt_row rows[] = {
    {"domain", domain, make_doubled, MOST, 2000, NULL, 0},
    {"adjacency", adjacency, make_sheets, 4000, 300, NULL, 0},
    {"satellites", satellites, make_sheets, 4000, 300, NULL, 0},
    {"edges", edges, vt_cloud_box, 6000, 500, NULL, 0},
    {"loops", loops, vt_cloud_square, 4000, 400, NULL, 0},
    {"orient", orient, vt_cloud_torus, 4000, 400, NULL, 0},
    {"lattice", lattice, make_rounded, 4000, 600, NULL, 0},
    {"outliers", outliers, make_strewn, 6000, 400, NULL, 0},
    {"islands", islands, vt_cloud_island, 6000, 400, NULL, 0},
    {"thin", thin, vt_cloud_box, MOST, 1000, NULL, 0},
    {"start", start, vt_cloud_box, 6000, 500, NULL, 0},
    {"frozen", frozen, vt_cloud_torus, 4000, 500, NULL, 0},
    {"mesh", mesh, make_sheets, 4000, 600, NULL, 0},
    {"march", march, vt_cloud_torus, 4000, 400, NULL, 0},
    {"index", tree, vt_cloud_cube, MOST, 2000, NULL, 0},
    {"progressive order", progressive, vt_cloud_box, MOST, 300, NULL, 0},
    {"Morton order", morton, vt_cloud_cube, MOST, 300, NULL, 0},
    {"point lists", point_lists, vt_cloud_cube, 0, 300, NULL, 0},
    {"index by FLANN", flann, vt_cloud_cube, 0, 2000, NULL, 1},
    {"Anderson's window", anderson, vt_cloud_cube, 0, 100, NULL, 1},
    {"L-BFGS vectors", lbfgs, vt_cloud_cube, 0, 100, NULL, 1},
};

_Static_assert(sizeof(struct vor_seeds) <= sizeof(((struct vt_call *)0)->out),
               "what comes out fits");

enum { ROWS = sizeof rows / sizeof *rows };

VT_TEST_LOOP(one_and_three_threads_give_the_same_bytes, ROWS)
{
    if (rows[_i].many > 0)
        vt_drive_threads(&rows[_i]);
}

VT_TEST_LOOP(each_allocation_may_fail, ROWS)
{
    vt_drive_failures(&rows[_i]);
}

VT_TEST_LOOP(a_cancel_leaves_nothing, ROWS)
{
    vt_drive_answers(&rows[_i]);
}
