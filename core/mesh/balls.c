#include "core/mesh/balls.h"

#include "core/base/linalg.h"
#include "core/geom/stretch.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Points nearest to point i on its sheet, itself first. */
static unsigned search(const struct vor_balls *balls, uint32_t i, unsigned around, uint32_t *index,
                       float *far2)
{
    const struct vor_seeds *seeds = balls->sheet->seeds;
    unsigned found = seeds->n < around ? (unsigned)seeds->n : around, count = 0;
    float distance2[VOR_BALLS_MANY];

    vor_knn_search(balls->knn, &seeds->xyz[3 * (size_t)i], 1, found, index, distance2);
    *far2 = found < seeds->n ? distance2[found - 1] : INFINITY;
    for (unsigned k = 0; k < found; k++)
        if (!balls->parts || vor_sheet_leads(balls->sheet, i, index[k]))
            index[count++] = index[k];
    return count;
}

static void list_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct vor_balls *balls = ctx;

    balls->count[i] = (unsigned char)search(balls, (uint32_t)i, VOR_BALLS_FEW,
                                            &balls->list[i * VOR_BALLS_FEW], &balls->far2[i]);
}

vor_status vor_balls_make(struct vor_balls *out, const struct vor_sheet *sheet,
                          const struct vor_run *run, struct vor_error *err)
{
    const struct vor_seeds *seeds = sheet->seeds;
    vor_status status;

    memset(out, 0, sizeof *out);
    out->sheet = sheet;
    out->parts = sheet->graph != NULL && seeds->domain->known.sheets;
    out->list = vor_malloc(run->memory, seeds->n, VOR_BALLS_FEW * sizeof *out->list);
    out->count = vor_malloc(run->memory, seeds->n, 1);
    out->far2 = vor_malloc(run->memory, seeds->n, sizeof *out->far2);
    if (out->list == NULL || out->count == NULL || out->far2 == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    status = vor_knn_build(&out->knn, seeds->xyz, seeds->n, run->memory, err);
    return status == VOR_OK ? vor_run_rows(run, seeds->n, VOR_SEEDS_BLOCK, list_row, out, err)
                            : status;
}

void vor_balls_free(struct vor_balls *balls)
{
    struct vor_memory *memory;

    if (balls->sheet == NULL)
        return;
    memory = balls->sheet->seeds->run.memory;
    VOR_FREE_ALL(memory, balls->list, balls->count, balls->far2);
    vor_knn_free(balls->knn);
    memset(balls, 0, sizeof *balls);
}

/* Sets x to the offset of each point around from point `first`, in its metric. */
static void set_offsets(struct vor_balls *balls, uint32_t first)
{
    const struct vor_seeds *seeds = balls->sheet->seeds;
    struct vor_surface flat = {.kind = VOR_SURFACE_PLANE};
    struct vor_stretch stretch;
    struct vor_frame frame;
    int stretched = vor_stretched_are(&seeds->stretched);

    if (stretched) {
        vor_frame_of(&frame, &balls->sheet->normal[3 * (size_t)first]);
        memcpy(flat.axis, frame.axis, sizeof flat.axis);
        vor_stretch_init(&stretch, &flat, seeds->stretched.near[first].tensor);
        balls->far2_around *= stretch.least * stretch.least;
    }
    for (unsigned i = 0; i < balls->around; i++) {
        double *x = balls->x[i], d[3];

        for (size_t c = 0; c < 3; c++)
            x[c] = d[c] = (double)seeds->xyz[3 * (size_t)balls->index[i] + c] -
                          (double)seeds->xyz[3 * (size_t)first + c];
        if (!stretched)
            continue;
        for (int c = 0; c < 3; c++)
            x[c] = vor_dot(frame.axis[c], d);
        vor_stretch_local(&stretch, x);
    }
}

void vor_balls_look(struct vor_balls *balls, uint32_t i, unsigned around)
{
    float far2 = balls->far2[i];

    if (balls->asked == around && balls->of == i)
        return;
    balls->of = i;
    balls->asked = around;
    balls->around = balls->count[i];
    if (around == VOR_BALLS_FEW)
        memcpy(balls->index, &balls->list[(size_t)i * VOR_BALLS_FEW],
               balls->around * sizeof *balls->index);
    else
        balls->around = search(balls, i, around, balls->index, &far2);
    balls->far2_around = (double)far2;
    set_offsets(balls, i);
}

const double *vor_balls_find(const struct vor_balls *balls, uint32_t point)
{
    for (unsigned i = 0; i < balls->around; i++)
        if (balls->index[i] == point)
            return balls->x[i];
    return NULL;
}

/* The middle of the circle through the origin, b and c, and a unit normal there. Returns its
 * squared radius; INFINITY where they lie on a line. */
static double circle(double middle[3], double normal[3], const double *b, const double *c)
{
    double u[3], v[3], area2, bb = vor_dot(b, b), cc = vor_dot(c, c);

    vor_cross(normal, b, c);
    area2 = vor_dot(normal, normal);
    if (!(area2 > VOR_ROUNDED * bb * cc))
        return INFINITY;
    vor_cross(u, normal, b);
    vor_cross(v, c, normal);
    for (int d = 0; d < 3; d++) {
        middle[d] = (cc * u[d] + bb * v[d]) / (2 * area2);
        normal[d] /= sqrt(area2);
    }
    return vor_dot(middle, middle);
}

/* The middle of a ball lies on the line through that of the circle, along the normal: each other
 * point leaves a ray of the line. */
double vor_balls_radius2(const struct vor_balls *balls, const double *b, const double *c,
                         double most2)
{
    double normal[3], middle[3] = {0, 0, 0}, low = -INFINITY, high = INFINITY, t,
                      bb = vor_dot(b, b);
    double radius2 = circle(middle, normal, b, c);

    if (!(radius2 < most2) || !(4 * radius2 <= balls->far2_around))
        return INFINITY;
    for (unsigned i = 0; i < balls->around && low <= high; i++) {
        const double *x = balls->x[i];
        double from[3], power, up;

        if (x == c || x == b || !(vor_dot(x, x) > 0))
            continue;
        for (int d = 0; d < 3; d++)
            from[d] = x[d] - middle[d];
        power = vor_dot(from, from) - radius2 + VOR_ROUNDED * bb;
        up = vor_dot(from, normal);
        if (up * up <= VOR_ROUNDED * VOR_ROUNDED * bb)
            low = power < 0 ? INFINITY : low;
        else if (up > 0)
            high = fmin(high, power / (2 * up));
        else
            low = fmax(low, power / (2 * up));
    }
    if (low > high)
        return INFINITY;
    t = fmax(low, fmin(high, 0));
    radius2 += t * t;
    return radius2 < most2 && 4 * radius2 <= balls->far2_around ? radius2 : INFINITY;
}
