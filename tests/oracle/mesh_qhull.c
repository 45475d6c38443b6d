/* Oracle: the corners of a flat cell are triangles of the Delaunay triangulation in its tangent
 * plane, as qhull finds it. A neighbour at offset (u, v) along the plane and w off it is lifted to
 * the height u^2 + v^2 + w^2; the lower convex hull of these is the triangulation, weighted where
 * w is not 0, as bisectors in space cut the plane. The only door to libqhull. */
#include "core/mesh/fan.h"
#include "core/mesh/quality.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <libqhull_r/qhull_ra.h>

#include <math.h>
#include <string.h>

enum { IN = 6000, SEEDS = 700, AROUND = 60, TRIANGLES = 40 };

/* Least distance of seeds, in spacings of a lattice of as many: drawn at random, they reach 0.77.
 */
#define APART 0.65

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_sheet sheet;
    struct vor_fans fans;
};

/* Seeds about evenly apart: of input points in a random order those that no other is near. */
static void open_bed(struct bed *bed, const struct vt_metric *metric, uint64_t seed)
{
    double apart = APART * vt_spacing(metric, SEEDS);
    size_t n = 0;

    vt_engine_open(&bed->engine, 2);
    metric->make(&bed->cloud, seed, IN, 0);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    apart /= bed->domain.unit;
    vt_assert_ok(
        vor_seeds_init(&bed->seeds, &bed->domain, SEEDS, vt_policy, &bed->engine.run, &vt_err));
    for (uint64_t draw = 0; n < SEEDS && draw < 40 * SEEDS; draw++) {
        const float *x = &bed->domain.xyz[3 * vor_rng_below(seed, 3, draw, IN)];
        size_t near = 0;

        while (near < n && vor_distance2f(x, &bed->seeds.xyz[3 * near]) > apart * apart)
            near++;
        if (near == n)
            memcpy(&bed->seeds.xyz[3 * n++], x, 3 * sizeof *x);
    }
    ck_assert_uint_eq(n, SEEDS);
    vt_assert_ok(vor_seeds_index(&bed->seeds, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_sheet_find(&bed->sheet, &bed->seeds, NULL, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_fans_make(&bed->fans, &bed->sheet, &bed->seeds, &bed->engine.run, &vt_err));
}

static void close_bed(struct bed *bed)
{
    vor_fans_free(&bed->fans);
    vor_sheet_free(&bed->sheet);
    vor_seeds_free(&bed->seeds);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
    vt_assert_no_leak();
}

/* The seeds near seed i that may be joined to it, itself first, in its plane: u, v and the height
 * they are lifted to. In units of the distance to the farthest. */
static int lift(const struct bed *bed, uint32_t i, uint32_t *index, double *lifted)
{
    const float *xyz = bed->seeds.xyz;
    double near[SEEDS], limit = INFINITY;
    struct vor_frame frame;
    int n = 0;

    for (uint32_t j = 0; j < SEEDS; j++)
        near[j] = vor_distance2f(&xyz[3 * i], &xyz[3 * j]);
    for (int taken = 0; taken < AROUND; taken++) { /* the AROUND-th smallest */
        double next = INFINITY;

        for (uint32_t j = 0; j < SEEDS; j++)
            if ((taken == 0 || near[j] > limit) && near[j] < next)
                next = near[j];
        limit = next;
    }
    vor_frame_of(&frame, &bed->sheet.normal[3 * i]);
    index[n++] = i;
    memset(lifted, 0, 3 * sizeof *lifted);
    for (uint32_t j = 0; j < SEEDS; j++) {
        double d[3];

        if (j == i || near[j] > limit || !vor_sheet_joins(&bed->sheet, i, j))
            continue;
        for (size_t c = 0; c < 3; c++)
            d[c] = ((double)xyz[3 * j + c] - (double)xyz[3 * i + c]) / sqrt(limit);
        lifted[3 * n] = vor_dot(frame.axis[0], d);
        lifted[3 * n + 1] = vor_dot(frame.axis[1], d);
        lifted[3 * n + 2] = vor_dot(d, d);
        index[n++] = j;
    }
    return n;
}

/* The triangles at point 0 of the lower convex hull: pairs of the other two corners. Returns how
 * many there are. */
static unsigned lower_hull(double *lifted, int n, int pair[TRIANGLES][2])
{
    qhT memory, *qh = &memory;
    facetT *facet;
    vertexT *vertex, **vertexp;
    unsigned found = 0;
    int left, total;

    QHULL_LIB_CHECK
    qh_zero(qh, stderr);
    ck_assert_int_eq(qh_new_qhull(qh, 3, n, lifted, 0, "qhull Qt", NULL, stderr), 0);
    FORALLfacets
    {
        int at_0 = 0, others = 0, other[3];

        if (facet->normal[2] >= 0)
            continue;
        FOREACHvertex_(facet->vertices)
        {
            int id = qh_pointid(qh, vertex->point);

            at_0 |= id == 0;
            if (id != 0 && others < 3)
                other[others++] = id;
        }
        if (!at_0)
            continue;
        ck_assert_int_eq(others, 2);
        ck_assert_uint_lt(found, TRIANGLES);
        memcpy(pair[found++], other, sizeof *pair);
    }
    qh_freeqhull(qh, !qh_ALL);
    qh_memfreeshort(qh, &left, &total);
    ck_assert_int_eq(left, 0);
    return found;
}

/* Whether a neighbour cut every edge of the cell of seed i: no corner is of its patch. */
static int is_whole(const struct bed *bed, uint32_t i)
{
    for (unsigned e = 0; e < bed->fans.count[i]; e++)
        if (bed->fans.neighbor[i * VOR_FAN_MOST + e] == VOR_FAN_OPEN)
            return 0;
    return bed->fans.count[i] > 0;
}

START_TEST(corners_of_flat_cells_are_delaunay_triangles_of_the_tangent_plane)
{
    static const int shapes[] = {VT_SQUARE, VT_BALL, VT_CYLINDER};
    const struct vt_metric *metric = &vt_metrics[shapes[_i % 3]];
    double lifted[3 * AROUND + 3];
    uint32_t index[AROUND + 1];
    int pair[TRIANGLES][2];
    struct bed bed;
    unsigned whole = 0;

    open_bed(&bed, metric, (uint64_t)_i);
    for (uint32_t i = 0; i < SEEDS; i++) {
        unsigned found;

        if (!is_whole(&bed, i))
            continue;
        found = lower_hull(lifted, lift(&bed, i, index, lifted), pair);
        ck_assert_uint_eq(found, bed.fans.count[i]);
        for (unsigned t = 0; t < found; t++)
            if (!vor_fans_has(&bed.fans, i, index[pair[t][0]], index[pair[t][1]]))
                ck_abort_msg("%s: the cell of %u has no corner of %u and %u", metric->name, i,
                             index[pair[t][0]], index[pair[t][1]]);
        whole++;
    }
    ck_assert_uint_gt(whole, SEEDS / 2);
    close_bed(&bed);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("mesh_qhull");

    vt_add_loop(suite, corners_of_flat_cells_are_delaunay_triangles_of_the_tangent_plane,
                VT_SOAK_LOOPS(3, 30));
    return vt_run(suite);
}
