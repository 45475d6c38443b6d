#include "core/input/band.h"

#include "core/base/linalg.h"
#include "core/geom/metric.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { BLOCK = 1024 }; /* points of one task */

/* Share of the band's points that may be steeper, or over the hole. Borders are ragged. */
#define FOLD_SHARE 0.1

vor_status vor_band_search_init(struct vor_band_search *out, size_t n, struct vor_memory *memory,
                                struct vor_error *err)
{
    struct vor_band_search search = {.seen = vor_calloc(memory, n, sizeof *search.seen),
                                     .point = vor_malloc(memory, n, sizeof *search.point),
                                     .from = vor_malloc(memory, n, sizeof *search.from)};

    if (search.seen == NULL || search.point == NULL || search.from == NULL) {
        vor_band_search_free(&search, memory);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    }
    *out = search;
    return VOR_OK;
}

void vor_band_search_free(struct vor_band_search *search, struct vor_memory *memory)
{
    VOR_FREE_ALL(memory, search->from, search->point, search->seen);
    memset(search, 0, sizeof *search);
}

/* Takes a point once. */
static void take(struct vor_band_search *search, size_t *count, uint32_t point, uint32_t from)
{
    if (search->seen[point] == search->searches)
        return;
    search->seen[point] = search->searches;
    search->point[*count] = point;
    search->from[(*count)++] = from;
}

/* Takes the points of the loop, and those that lists lead to from there, up to `width` from the
 * loop's point that they began at. Returns how many. */
static size_t spread(struct vor_band_search *search, const struct vor_domain *domain,
                     const uint32_t *loop, size_t rim, double width)
{
    const struct vor_graph *graph = &domain->graph;
    size_t count = 0;

    search->searches++;
    for (size_t i = 0; i < rim; i++)
        take(search, &count, loop[i], loop[i]);
    for (size_t at = 0; at < count; at++) {
        const uint32_t *list = &graph->list[search->point[at] * (size_t)graph->most];
        uint32_t from = search->from[at];

        for (unsigned j = 0; j < graph->count[search->point[at]]; j++)
            if (vor_distance2f(&domain->xyz[3 * (size_t)list[j]], &domain->xyz[3 * (size_t)from]) <=
                width * width)
                take(search, &count, list[j], from);
    }
    return count;
}

/* The middle of a loop, and the frame whose third axis is normal to the plane over which the loop
 * has the most area. False where it has none. */
static int find_frame(struct vor_band *band, double axis[3][3], const struct vor_domain *domain,
                      const uint32_t *loop)
{
    double area[3] = {0, 0, 0}, length;

    memset(band->middle, 0, sizeof band->middle);
    for (size_t i = 0; i < band->rim; i++)
        for (size_t c = 0; c < 3; c++)
            band->middle[c] += (double)domain->xyz[3 * (size_t)loop[i] + c] / (double)band->rim;
    for (size_t i = 0; i < band->rim; i++) {
        const float *p = &domain->xyz[3 * (size_t)loop[i]],
                    *q = &domain->xyz[3 * (size_t)loop[(i + 1) % band->rim]];
        double a[3], b[3], cross[3];

        for (int c = 0; c < 3; c++) {
            a[c] = (double)p[c] - band->middle[c];
            b[c] = (double)q[c] - band->middle[c];
        }
        vor_cross(cross, a, b);
        for (int c = 0; c < 3; c++)
            area[c] += cross[c];
    }
    length = sqrt(vor_dot(area, area));
    if (!(length > 0))
        return 0;
    for (int c = 0; c < 3; c++)
        axis[2][c] = area[c] / length;
    vor_metric_axes(axis, axis[2]);
    memcpy(band->up, axis[2], sizeof band->up);
    return 1;
}

static void project(double out[2], const struct vor_band *band, double axis[3][3], const float *p)
{
    double d[3];

    for (int c = 0; c < 3; c++)
        d[c] = (double)p[c] - band->middle[c];
    out[0] = vor_dot(axis[0], d);
    out[1] = vor_dot(axis[1], d);
}

/* Whether the normal of a point points another way than that of the loop, either way up, so that
 * the band folds; that of a point without one does not. */
static int is_steep(const struct vor_domain *domain, uint32_t point, const double up[3])
{
    double own[3];

    vor_to_doubles(own, domain->graph.normal + 3 * (size_t)point);
    return vor_dot(own, own) > 0 && fabs(vor_dot(own, up)) < VOR_SAME_WAY;
}

/* A band being laid out. */
struct lay {
    struct vor_band *band;
    const struct vor_domain *domain;
    const uint32_t *loop;
    double axis[3][3];
    double *rim;                /* rim x 3: the loop in space */
    double *along;              /* rim + 1: length of the loop before each of its points */
    struct vor_polygon polygon; /* of rim */
    atomic_size_t steep, over;
};

static void flat_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct lay *lay = ctx;
    struct vor_band *band = lay->band;
    size_t steep = 0, over = 0;

    for (size_t i = begin; i < end; i++) {
        project(&band->at[2 * i], band, lay->axis, &lay->domain->xyz[3 * (size_t)band->point[i]]);
        steep += (size_t)is_steep(lay->domain, band->point[i], lay->axis[2]);
        over += (size_t)(i >= band->rim && vor_polygon_within(&band->polygon, &band->at[2 * i]));
    }
    atomic_fetch_add(&lay->steep, steep);
    atomic_fetch_add(&lay->over, over);
}

/* Lays the band out by projection; *folds says that it folds there. */
static vor_status lay_flat(struct lay *lay, int *folds, const struct vor_run *run,
                           struct vor_error *err)
{
    struct vor_band *band = lay->band;
    vor_status status;

    for (size_t i = 0; i < band->rim; i++)
        project(&band->outline[2 * i], band, lay->axis,
                &lay->domain->xyz[3 * (size_t)lay->loop[i]]);
    status = vor_polygon_init(&band->polygon, band->outline, band->rim, 2, band->memory, err);
    VOR_THEN(status, vor_run_for(run, band->count, BLOCK, flat_block, lay, err));
    *folds = !((double)atomic_load(&lay->steep) <= FOLD_SHARE * (double)band->count &&
               (double)atomic_load(&lay->over) <= FOLD_SHARE * (double)band->count);
    return status;
}

/* Unit vector at a share of a full turn, 0 .. 1. Sums of Taylor, exact to rounding, because the
 * bits of libm's sine differ between machines. */
static void turn(double share, double out[2])
{
    double x = 2 * M_PI * (share - 0.5), term = 1, sum[2] = {0, 0};

    for (int k = 0; k < 30; k++) {
        sum[k % 2] += (k / 2) % 2 != 0 ? -term : term;
        term *= x / (k + 1);
    }
    out[0] = sum[0];
    out[1] = sum[1];
}

static void unroll_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct lay *lay = ctx;
    struct vor_band *band = lay->band;
    double length = lay->along[band->rim], way[2];
    const float *p = &lay->domain->xyz[3 * (size_t)band->point[i]];
    double x[3] = {(double)p[0], (double)p[1], (double)p[2]};
    struct vor_polygon_near near;
    size_t next;

    vor_polygon_nearest(&near, &lay->polygon, x);
    next = (near.edge + 1) % band->rim;
    turn((lay->along[near.edge] +
          near.t * sqrt(vor_distance2f(&lay->domain->xyz[3 * (size_t)lay->loop[near.edge]],
                                       &lay->domain->xyz[3 * (size_t)lay->loop[next]]))) /
             length,
         way);
    for (size_t c = 0; c < 2; c++)
        band->at[2 * i + c] = (length / (2 * M_PI) + sqrt(near.distance2)) * way[c];
}

/* Sets how long the loop is before each of its points, and makes it a circle. */
static void unroll_rim(struct lay *lay)
{
    struct vor_band *band = lay->band;
    double length, way[2];

    lay->along[0] = 0;
    for (size_t i = 0; i < band->rim; i++) {
        const float *p = &lay->domain->xyz[3 * (size_t)lay->loop[i]],
                    *q = &lay->domain->xyz[3 * (size_t)lay->loop[(i + 1) % band->rim]];

        vor_to_doubles(&lay->rim[3 * i], p);
        lay->along[i + 1] = lay->along[i] + sqrt(vor_distance2f(p, q));
    }
    length = lay->along[band->rim];
    for (size_t i = 0; i < band->rim; i++) {
        turn(lay->along[i] / length, way);
        for (size_t c = 0; c < 2; c++)
            band->outline[2 * i + c] = length / (2 * M_PI) * way[c];
    }
}

/* Lays the band out around a circle. */
static vor_status unroll(struct lay *lay, const struct vor_run *run, struct vor_error *err)
{
    struct vor_band *band = lay->band;
    vor_status status;

    status = VOR_MAKE_ALL(band->memory, err, band->rim, VOR_ARRAY(lay->rim, band->rim, 3),
                          VOR_ARRAY(lay->along, band->rim + 1, 1));
    if (status != VOR_OK)
        return status;
    band->unrolled = 1;
    unroll_rim(lay);
    vor_polygon_free(&band->polygon);
    status = vor_polygon_init(&band->polygon, band->outline, band->rim, 2, band->memory, err);
    VOR_THEN(status, vor_polygon_init(&lay->polygon, lay->rim, band->rim, 3, band->memory, err));
    return status == VOR_OK ? vor_run_rows(run, band->count, BLOCK, unroll_row, lay, err) : status;
}

/* Lays the band out, flat unless it folds there. */
static vor_status lay_out(struct vor_band *band, const struct vor_domain *domain,
                          const uint32_t *loop, const struct vor_run *run, struct vor_error *err)
{
    struct lay lay = {.band = band, .domain = domain, .loop = loop};
    int folds = !find_frame(band, lay.axis, domain, loop);
    vor_status status = folds ? VOR_OK : lay_flat(&lay, &folds, run, err);

    if (status == VOR_OK && folds)
        status = unroll(&lay, run, err);
    vor_polygon_free(&lay.polygon);
    VOR_FREE_ALL(band->memory, lay.along, lay.rim);
    return status;
}

vor_status vor_band_find(struct vor_band *out, struct vor_band_search *search,
                         const struct vor_domain *domain, const struct vor_loops *loops,
                         size_t which, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_loop *of = &loops->loop[which];
    const uint32_t *loop = &loops->point[of->first];
    struct vor_band band = {.memory = domain->memory, .rim = of->count};
    vor_status status;

    band.count = spread(search, domain, loop, of->count, VOR_BAND_WIDTH * of->spacing);
    status = VOR_MAKE_ALL(band.memory, err, of->count, VOR_ARRAY(band.point, band.count, 1),
                          VOR_ARRAY(band.outline, band.rim, 2), VOR_ARRAY(band.at, band.count, 2));
    if (status == VOR_OK) {
        memcpy(band.point, search->point, band.count * sizeof *band.point);
        status = lay_out(&band, domain, loop, run, err);
    }
    if (status == VOR_OK)
        *out = band;
    else
        vor_band_free(&band);
    return status;
}

void vor_band_free(struct vor_band *band)
{
    vor_polygon_free(&band->polygon);
    VOR_FREE_ALL(band->memory, band->at, band->outline, band->point);
    memset(band, 0, sizeof *band);
}
