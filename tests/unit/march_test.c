/* Distances along a surface, over the plain nearest neighbours. */
#include "core/geom/march.h"
#include "core/input/domain.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SHAPES = 4, SEEDS = 2, N = 20000, MOST = 20 };

/* Sheets of the fold are so many spacings apart: lists of 20 reach over 2.5. */
#define APART 8

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_graph graph;
    struct vor_march march;
    float *far;
};

/* bed->cloud is there already; most: entries of a list. */
static void start(struct bed *bed, unsigned threads, unsigned most)
{
    uint32_t index[MOST + 1];
    float distance2[MOST + 1];

    vt_engine_open(&bed->engine, threads);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_graph_init(&bed->graph, bed->domain.n, most, &vt_memory, &vt_err));
    for (size_t i = 0; i < bed->domain.n; i++) {
        vor_knn_search(bed->domain.knn, &bed->domain.xyz[3 * i], 1, most + 1, index, distance2);
        memcpy(&bed->graph.list[i * most], &index[1], most * sizeof *index);
        bed->graph.count[i] = (unsigned char)most;
    }
    vt_assert_ok(vor_graph_keep_mutual(&bed->graph, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_march_init(&bed->march, &bed->graph, bed->domain.xyz, &vt_err));
    bed->far = vor_malloc(&vt_memory, bed->domain.n, sizeof *bed->far);
}

static void end(struct bed *bed)
{
    vor_free(&vt_memory, bed->far);
    vor_march_free(&bed->march);
    vor_graph_free(&bed->graph);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
}

static void march(struct bed *bed, uint32_t source)
{
    vt_assert_ok(vor_march_from(&bed->march, bed->far, &source, 1, &bed->engine.run, &vt_err));
}

/* Lv 2022, Sec. 3.2: the distances are those along the surface. Beyond ten spacings none is off by
 * 10 %, and their mean error is below 1 %. */
VT_TEST_LOOP(distances_are_those_along_the_surface, VT_ONCE(SHAPES *VT_SOAK_LOOPS(1, SEEDS)))
{
    static const int shapes[] = {VT_SQUARE, VT_BALL, VT_CYLINDER, VT_FOLD};
    uint64_t seed = (uint64_t)_i / SHAPES;
    const struct vt_metric *metric = &vt_metrics[shapes[_i % SHAPES]];
    double spacing = vt_spacing(metric, N), gap = APART * spacing, worst = 0, sum = 0;
    uint32_t source = (uint32_t)(vt_unit(77, seed) * N);
    double from[3], to[3], exact;
    struct bed bed;
    size_t count = 0;

    metric->make(&bed.cloud, seed, N, gap);
    start(&bed, 2, MOST);
    march(&bed, source);
    vor_cloud_position(&bed.cloud, bed.domain.source[source], from);
    for (size_t i = 0; i < bed.domain.n; i++) {
        vor_cloud_position(&bed.cloud, bed.domain.source[i], to);
        exact = metric->along(from, to, gap);
        if (exact > 10 * spacing) {
            double off = fabs((double)bed.far[i] * bed.domain.unit / exact - 1);

            worst = fmax(worst, off);
            sum += off;
            count++;
        }
    }
    ck_assert_uint_gt(count, N / 2);
    ck_assert_msg(worst <= 0.1 && sum <= 0.01 * (double)count, "%s: off by %.2f %%, mean %.2f %%",
                  metric->name, 100 * worst, 100 * sum / (double)count);
    end(&bed);
}

VT_TEST_LOOP(points_that_no_chain_leads_to_are_infinitely_far, SEEDS)
{
    struct bed bed;
    size_t reached = 0;

    vt_metrics[VT_SPHERES].make(&bed.cloud, (uint64_t)_i, 4000, 0.5);
    start(&bed, 2, MOST);
    march(&bed, 0);
    for (size_t i = 0; i < bed.domain.n; i++) {
        reached += bed.far[i] < INFINITY;
        ck_assert((bed.far[i] < INFINITY) ==
                  ((bed.domain.xyz[3 * i] < 0) == (bed.domain.xyz[0] < 0)));
    }
    ck_assert_uint_eq(reached, 2000);
    end(&bed);
}

VT_TEST_LOOP(several_sources_are_the_nearest_of_each, SEEDS)
{
    uint32_t sources[2] = {10, 900};
    struct bed bed;
    float *first;

    vt_cloud_square(&bed.cloud, (uint64_t)_i, 2000);
    start(&bed, 2, MOST);
    march(&bed, sources[0]);
    first = bed.far;
    bed.far = vor_malloc(&vt_memory, bed.domain.n, sizeof *bed.far);
    march(&bed, sources[1]);
    for (size_t i = 0; i < bed.domain.n; i++)
        first[i] = fminf(first[i], bed.far[i]);
    vt_assert_ok(vor_march_from(&bed.march, bed.far, sources, 2, &bed.engine.run, &vt_err));
    for (size_t i = 0; i < bed.domain.n; i++)
        ck_assert(bed.far[i] <= first[i] && bed.far[i] >= 0.96F * first[i]);
    vor_free(&vt_memory, first);
    end(&bed);
}
