#include "core/mesh/facing.h"

#include "core/base/linalg.h"
#include "core/geom/winding.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Mean of the winding numbers on an open component for it to face outward: on a closed surface it
 * is 0.5, on a half sphere 0.18, on a flat sheet 0. */
#define OUTWARD 0.05

struct turning {
    struct vor_complex *complex;
    const float *xyz;
    uint32_t *queue; /* triangles of the component, in the order in which they were reached */
    size_t queued;
    int open; /* the component has an edge with one triangle */
    unsigned char *reached;
};

static void turn(uint32_t corner[3])
{
    uint32_t second = corner[1];

    corner[1] = corner[2];
    corner[2] = second;
}

/* Reaches the triangles beside triangle t, and turns them alike. Returns whether one that was
 * reached before faces the other way. */
static int reach_from(struct turning *turning, uint32_t t)
{
    struct vor_complex *complex = turning->complex;
    int contrary = 0;

    for (int c = 0; c < 3; c++) {
        const uint32_t *corner = &complex->triangle[3 * (size_t)t];
        uint32_t a = corner[c], b = corner[(c + 1) % 3], u = vor_complex_across(complex, t, a, b);
        uint32_t *beside = &complex->triangle[3 * (size_t)u];

        if (u == t) {
            turning->open = 1;
            continue;
        }
        if (turning->reached[u]) {
            contrary |= vor_complex_runs(beside, a, b);
            continue;
        }
        turning->reached[u] = 1;
        turning->queue[turning->queued++] = u;
        if (vor_complex_runs(beside, a, b))
            turn(beside);
    }
    return contrary;
}

/* The middle of triangle q of the component, and its normal of twice its area in length. */
static void take(const struct turning *turning, size_t q, double x[3], double normal[3])
{
    const uint32_t *corner = &turning->complex->triangle[3 * (size_t)turning->queue[q]];

    for (size_t c = 0; c < 3; c++) {
        x[c] = 0;
        for (int k = 0; k < 3; k++)
            x[c] += (double)turning->xyz[3 * (size_t)corner[k] + c] / 3;
    }
    vor_triangle_normal(normal, turning->xyz, corner);
}

/* The mean winding number of the component at places on it. */
static double winding_of(const struct turning *turning)
{
    size_t places = turning->queued < VOR_WINDING_PLACES ? turning->queued : VOR_WINDING_PLACES;
    double sum = 0;

    for (size_t k = 0; k < places; k++) {
        size_t at = k * turning->queued / places;
        double x[3], to[3], n[3];

        take(turning, at, x, n);
        for (size_t q = 0; q < turning->queued; q++) {
            double r2;

            take(turning, q, to, n);
            for (int c = 0; c < 3; c++)
                to[c] -= x[c];
            r2 = fmax(vor_dot(to, to), sqrt(vor_dot(n, n)) / 2); /* large beside its distance */
            sum += r2 > 0 ? vor_dot(to, n) / 2 / (r2 * sqrt(r2)) : 0;
        }
    }
    return sum / (4 * M_PI * (double)places);
}

/* Whether the triangles of the component face inward, or where that is not clear downward. */
static int faces_inward(const struct turning *turning)
{
    double sum[3] = {0, 0, 0}, volume = 0, number, x[3], n[3];
    int largest = 0;

    for (size_t q = 0; q < turning->queued; q++) {
        take(turning, q, x, n);
        volume += vor_dot(x, n);
        for (int c = 0; c < 3; c++)
            sum[c] += n[c];
    }
    if (!turning->open)
        return volume < 0;
    number = winding_of(turning);
    if (fabs(number) > OUTWARD)
        return number < 0;
    for (int c = 1; c < 3; c++)
        largest = fabs(sum[c]) > fabs(sum[largest]) ? c : largest;
    return sum[largest] < 0;
}

static void turn_component(struct turning *turning, struct vor_facing *told, uint32_t first)
{
    int contrary = 0;

    turning->queue[0] = first;
    turning->queued = 1;
    turning->open = 0;
    turning->reached[first] = 1;
    for (size_t q = 0; q < turning->queued; q++)
        contrary |= reach_from(turning, turning->queue[q]);
    told->components++;
    told->one_sided += contrary != 0;
    if (turning->xyz == NULL || !faces_inward(turning))
        return;
    for (size_t q = 0; q < turning->queued; q++)
        turn(&turning->complex->triangle[3 * (size_t)turning->queue[q]]);
}

vor_status vor_facing_turn(struct vor_complex *complex, struct vor_facing *told, const float *xyz,
                           struct vor_error *err)
{
    struct turning turning = {.complex = complex, .xyz = xyz};
    vor_status status = VOR_OK;

    memset(told, 0, sizeof *told);
    turning.queue = vor_malloc(complex->memory, complex->count, sizeof *turning.queue);
    turning.reached = vor_calloc(complex->memory, complex->count, 1);
    if (turning.queue == NULL || turning.reached == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu triangles", complex->count);
    else
        for (size_t t = 0; t < complex->count; t++)
            if (!turning.reached[t] && complex->triangle[3 * t] != VOR_COMPLEX_GONE)
                turn_component(&turning, told, (uint32_t)t);
    VOR_FREE_ALL(complex->memory, turning.reached, turning.queue);
    return status;
}
