#include "core/lop/beside.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"
#include "core/lop/weights.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 256 }; /* points of one task */

/* How far from the data of its side a point may lie, and how far around a datum its plane says
 * where the surface is; over the distance to the last of VOR_LOP_AREA_OF neighbours: three quarters
 * of the spacing of the data. */
#define REACH 0.4
/* How far outside of the data around it a point may lie, seen along its normal, over the same. */
#define OUTSIDE 0.15

struct putting {
    struct vor_lop_samples *samples;
    const struct vor_lop_beside *beside;
    size_t first;
};

/* The data around a place but for `self`. */
struct around {
    const struct vor_lop_beside *beside;
    size_t self;
    unsigned k;
    uint32_t index[VOR_LOP_AREA_OF];
    float distance2[VOR_LOP_AREA_OF];
};

static void look(struct around *around, const float *x, struct vor_knn_last *last)
{
    const struct vor_domain *domain = around->beside->domain;

    around->k = domain->n < VOR_LOP_AREA_OF ? (unsigned)domain->n : VOR_LOP_AREA_OF;
    vor_knn_search_next(domain->knn, last, x, around->k, around->index, around->distance2);
}

/* The area around the nearest datum. */
static double area_of(const struct around *around)
{
    return (double)around->beside->data->area[around->index[0]];
}

/* The place of a datum's disc that is nearest to x; returns how far away it is, squared. */
static double foot_of(double foot[3], const float *x, const struct vor_lop_samples *data, size_t at)
{
    double n[3], d[3], height, length, part, away2 = 0;

    vor_to_doubles(n, &data->normal[3 * at]);
    vor_way(d, &data->xyz[3 * at], x);
    height = vor_dot(d, n);
    for (size_t c = 0; c < 3; c++)
        d[c] -= height * n[c];
    length = sqrt(vor_dot(d, d));
    part = fmin(1, REACH * sqrt((double)data->area[at]) / fmax(length, 1e-30));
    for (size_t c = 0; c < 3; c++) {
        foot[c] = (double)data->xyz[3 * at + c] + part * d[c];
        away2 += (foot[c] - (double)x[c]) * (foot[c] - (double)x[c]);
    }
    return away2;
}

/* The place of the hull of points that is nearest to the origin, from the nearest of them on. */
static void nearest_of_hull(double v[3], const double q[][3], unsigned count)
{
    for (unsigned j = 0; j < count; j++)
        if (j == 0 || vor_dot(q[j], q[j]) < vor_dot(v, v))
            memcpy(v, q[j], sizeof q[j]);
    for (unsigned step = 0; step < count; step++) {
        unsigned best = 0;
        double d[3], part;

        for (unsigned j = 1; j < count; j++)
            best = vor_dot(q[j], v) < vor_dot(q[best], v) ? j : best;
        for (size_t c = 0; c < 3; c++)
            d[c] = q[best][c] - v[c];
        part = fmin(fmax(-vor_dot(v, d), 0) / fmax(vor_dot(d, d), 1e-30), 1);
        for (size_t c = 0; c < 3; c++)
            v[c] += part * d[c];
    }
}

/* The vector from x to the hull of the data around it, seen along its normal n: of those of its
 * side, or of all.
 *
 * @return the square of the least height of x over one of their planes; INFINITY if there are none
 */
static double to_hull(double v[3], const struct around *around, const float *x, const float *n,
                      int of_side)
{
    const struct vor_lop_samples *data = around->beside->data;
    double scale = vor_lop_scale(around->beside->sigma_n), q[VOR_LOP_AREA_OF][3], along[3];
    double least = INFINITY;
    unsigned count = 0;

    vor_to_doubles(along, n);
    for (unsigned j = 0; j < around->k; j++) {
        size_t at = around->index[j];
        const float *y = &data->xyz[3 * at], *m = &data->normal[3 * at];
        double *d = q[count], height = 0;

        if (at == around->self || (of_side && !(vor_lop_alike(vor_dotf(n, m), scale) > 0)))
            continue;
        for (size_t c = 0; c < 3; c++) {
            d[c] = (double)y[c] - (double)x[c];
            height += d[c] * (double)m[c];
        }
        least = fmin(least, height * height);
        vor_remove_along(d, along, 0);
        count++;
    }
    nearest_of_hull(v, q, count);
    return least;
}

/* Finds the disc nearest to x.
 *
 * @return its datum; SIZE_MAX if there is none */
static size_t nearest_disc(double foot[3], const struct around *around, const float *x)
{
    size_t datum = SIZE_MAX;
    double least = INFINITY;

    for (unsigned j = 0; j < around->k; j++) {
        double there[3], away2 = foot_of(there, x, around->beside->data, around->index[j]);

        if (around->index[j] == around->self || !(away2 < least))
            continue;
        least = away2;
        datum = around->index[j];
        memcpy(foot, there, sizeof there);
    }
    return datum;
}

/* Moves a point on its own plane to where a place lies over it. */
static void move_along(float *x, const float *n, const double place[3])
{
    double d[3], along[3];

    vor_to_doubles(along, n);
    for (size_t c = 0; c < 3; c++)
        d[c] = place[c] - (double)x[c];
    vor_remove_along(d, along, 0);
    for (size_t c = 0; c < 3; c++)
        x[c] = (float)((double)x[c] + d[c]);
}

/* Whether no data of its side are around a point. */
static int hangs(const struct around *around, const float *x, const float *n)
{
    double v[3] = {0}, height2 = to_hull(v, around, x, n, 1);

    return height2 + vor_dot(v, v) > REACH * REACH * area_of(around);
}

int vor_lop_beside_hangs(const float *x, const float *n, const struct vor_lop_beside *beside)
{
    struct around around = {.beside = beside, .self = SIZE_MAX};
    struct vor_knn_last none = {.k = 0};

    if (beside->data == NULL)
        return 0;
    look(&around, x, &none);
    return hangs(&around, x, n);
}

void vor_lop_beside_land(float *x, float *n, const struct vor_lop_beside *beside, size_t self,
                         struct vor_knn_last *last)
{
    struct around around = {.beside = beside, .self = self};
    double foot[3] = {0};
    const float *m;
    size_t datum;

    look(&around, x, last);
    if (!hangs(&around, x, n))
        return;
    datum = nearest_disc(foot, &around, x);
    if (datum == SIZE_MAX)
        return;
    m = &beside->data->normal[3 * datum];
    /* Data between two sides less than 60 degrees apart may have planes of neither. */
    if (vor_dotf(n, m) > VOR_SAME_WAY) {
        if (self == SIZE_MAX)
            move_along(x, n, foot);
        return;
    }
    vor_to_floats(x, foot);
    memcpy(n, m, 3 * sizeof *n);
}

size_t vor_lop_beside_face(float *x, const struct vor_lop_beside *beside, struct vor_knn_last *last)
{
    uint32_t datum;
    float distance2;
    double foot[3];

    vor_knn_search_next(beside->domain->knn, last, x, 1, &datum, &distance2);
    (void)foot_of(foot, x, beside->data, datum);
    vor_to_floats(x, foot);
    return datum;
}

static void put_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct putting *putting = ctx;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = putting->first + begin; i < putting->first + end; i++) {
        float *x = &putting->samples->xyz[3 * i], *n = &putting->samples->normal[3 * i];
        struct around around = {.beside = putting->beside, .self = SIZE_MAX};
        double v[3] = {0};

        vor_lop_beside_land(x, n, putting->beside, SIZE_MAX, &last);
        look(&around, x, &last);
        (void)to_hull(v, &around, x, n, 0);
        if (vor_dot(v, v) > OUTSIDE * OUTSIDE * area_of(&around))
            for (size_t c = 0; c < 3; c++)
                x[c] = (float)((double)x[c] + v[c]);
    }
}

vor_status vor_lop_beside_put(struct vor_lop_samples *samples, size_t first,
                              const struct vor_lop_beside *beside, const struct vor_run *run,
                              struct vor_error *err)
{
    struct putting putting = {samples, beside, first};

    if (beside->data == NULL)
        return VOR_OK;
    return vor_run_for(run, samples->n - first, BLOCK, put_block, &putting, err);
}
