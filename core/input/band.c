#include "core/input/band.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

/* Cosine of 66 degrees: the largest angle between the normal of a point and that of the loop at
 * which the point lies over the plane without a fold. */
#define FOLD_COSINE 0.4

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
        return vor_fail(err, VOR_E_NOMEM, "what lies around the holes of %zu points", n);
    }
    *out = search;
    return VOR_OK;
}

void vor_band_search_free(struct vor_band_search *search, struct vor_memory *memory)
{
    vor_free(memory, search->from);
    vor_free(memory, search->point);
    vor_free(memory, search->seen);
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
    int least = 0;

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
    for (int c = 0; c < 3; c++) {
        axis[2][c] = area[c] / length;
        least = fabs(area[c]) < fabs(area[least]) ? c : least;
    }
    memset(axis[1], 0, sizeof axis[1]);
    axis[1][least] = 1;
    vor_cross(axis[0], axis[1], axis[2]);
    length = sqrt(vor_dot(axis[0], axis[0]));
    for (int c = 0; c < 3; c++)
        axis[0][c] /= length;
    vor_cross(axis[1], axis[2], axis[0]);
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

/* Whether the normal of a point is nearly in the plane; a point without one is not. */
static int is_steep(const struct vor_domain *domain, uint32_t point, const double up[3])
{
    double own[3];

    for (size_t c = 0; c < 3; c++)
        own[c] = (double)domain->graph.normal[3 * (size_t)point + c];
    return vor_dot(own, own) > 0 && fabs(vor_dot(own, up)) < FOLD_COSINE;
}

/* Lays the band out by projection. False where it folds there. */
static int lay_flat(struct vor_band *band, double axis[3][3], const struct vor_domain *domain,
                    const uint32_t *loop)
{
    size_t steep = 0, over = 0;

    for (size_t i = 0; i < band->rim; i++)
        project(&band->outline[2 * i], band, axis, &domain->xyz[3 * (size_t)loop[i]]);
    for (size_t i = 0; i < band->count; i++) {
        project(&band->at[2 * i], band, axis, &domain->xyz[3 * (size_t)band->point[i]]);
        steep += (size_t)is_steep(domain, band->point[i], axis[2]);
        over += (size_t)(i >= band->rim && vor_band_within(band, &band->at[2 * i]));
    }
    return (double)steep <= FOLD_SHARE * (double)band->count &&
           (double)over <= FOLD_SHARE * (double)band->count;
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

/* Nearest place to a point on the loop: how far it is, and at which length along the loop. */
static double nearest_on(double *along, const struct vor_domain *domain, const uint32_t *loop,
                         size_t rim, const float *x)
{
    double best2 = INFINITY, before = 0;

    for (size_t i = 0; i < rim; i++) {
        const float *p = &domain->xyz[3 * (size_t)loop[i]],
                    *q = &domain->xyz[3 * (size_t)loop[(i + 1) % rim]];
        double length2 = vor_distance2f(p, q), t = 0, d2 = 0;

        for (int c = 0; c < 3; c++)
            t += ((double)x[c] - (double)p[c]) * ((double)q[c] - (double)p[c]);
        t = length2 > 0 ? fmax(0, fmin(1, t / length2)) : 0;
        for (int c = 0; c < 3; c++) {
            double d = (double)x[c] - (double)p[c] - t * ((double)q[c] - (double)p[c]);

            d2 += d * d;
        }
        if (d2 < best2) {
            best2 = d2;
            *along = before + t * sqrt(length2);
        }
        before += sqrt(length2);
    }
    return sqrt(best2);
}

/* Lays the band out around a circle. */
static void unroll(struct vor_band *band, const struct vor_domain *domain, const uint32_t *loop)
{
    double length = 0, along = 0, way[2];

    band->unrolled = 1;
    for (size_t i = 0; i < band->rim; i++)
        length += sqrt(vor_distance2f(&domain->xyz[3 * (size_t)loop[i]],
                                      &domain->xyz[3 * (size_t)loop[(i + 1) % band->rim]]));
    for (size_t i = 0; i < band->rim; i++) {
        turn(along / length, way);
        for (size_t c = 0; c < 2; c++)
            band->outline[2 * i + c] = length / (2 * M_PI) * way[c];
        along += sqrt(vor_distance2f(&domain->xyz[3 * (size_t)loop[i]],
                                     &domain->xyz[3 * (size_t)loop[(i + 1) % band->rim]]));
    }
    for (size_t i = 0; i < band->count; i++) {
        double far =
            nearest_on(&along, domain, loop, band->rim, &domain->xyz[3 * (size_t)band->point[i]]);

        turn(along / length, way);
        for (size_t c = 0; c < 2; c++)
            band->at[2 * i + c] = (length / (2 * M_PI) + far) * way[c];
    }
}

vor_status vor_band_find(struct vor_band *out, struct vor_band_search *search,
                         const struct vor_domain *domain, const uint32_t *loop,
                         const struct vor_loop *of, struct vor_error *err)
{
    struct vor_band band = {.memory = domain->memory, .rim = of->count};
    double axis[3][3];

    band.count = spread(search, domain, loop, of->count, VOR_BAND_WIDTH * of->spacing);
    band.point = vor_malloc(band.memory, band.count, sizeof *band.point);
    band.outline = vor_malloc(band.memory, band.rim, 2 * sizeof *band.outline);
    band.at = vor_malloc(band.memory, band.count, 2 * sizeof *band.at);
    if (band.point == NULL || band.outline == NULL || band.at == NULL) {
        vor_band_free(&band);
        return vor_fail(err, VOR_E_NOMEM, "what lies around a hole of %zu points", of->count);
    }
    memcpy(band.point, search->point, band.count * sizeof *band.point);
    if (!find_frame(&band, axis, domain, loop) || !lay_flat(&band, axis, domain, loop))
        unroll(&band, domain, loop);
    *out = band;
    return VOR_OK;
}

int vor_band_within(const struct vor_band *band, const double u[2])
{
    int within = 0;

    for (size_t i = 0, j = band->rim - 1; i < band->rim; j = i++) {
        const double *a = &band->outline[2 * i], *b = &band->outline[2 * j];

        if ((a[1] > u[1]) != (b[1] > u[1]) &&
            u[0] < a[0] + (b[0] - a[0]) * (u[1] - a[1]) / (b[1] - a[1]))
            within = !within;
    }
    return within;
}

void vor_band_free(struct vor_band *band)
{
    if (band->memory == NULL)
        return;
    vor_free(band->memory, band->at);
    vor_free(band->memory, band->outline);
    vor_free(band->memory, band->point);
    memset(band, 0, sizeof *band);
}
