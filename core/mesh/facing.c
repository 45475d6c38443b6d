#include "core/mesh/facing.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Flux over that of as much area that faces straight away from the middle: below it, the sum of the
 * normals of an open component decides. A half sphere has 0.5 about the middle of its points, a
 * flat sheet 0. */
#define FLUX 0.1

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

static void middle_of(const struct turning *turning, const uint32_t *corner, double out[3])
{
    for (size_t c = 0; c < 3; c++) {
        out[c] = 0;
        for (int k = 0; k < 3; k++)
            out[c] += (double)turning->xyz[3 * (size_t)corner[k] + c] / 3;
    }
}

/* Whether the triangles of the component face inward, or where that is not clear downward. */
static int faces_inward(const struct turning *turning)
{
    double middle[3] = {0, 0, 0}, sum[3] = {0, 0, 0}, weight = 0, flux = 0, most = 0, x[3], n[3];
    int largest = 0;

    for (size_t q = 0; q < turning->queued; q++) {
        const uint32_t *corner = &turning->complex->triangle[3 * (size_t)turning->queue[q]];
        double area;

        middle_of(turning, corner, x);
        vor_triangle_normal(n, turning->xyz, corner);
        area = sqrt(vor_dot(n, n));
        for (int c = 0; c < 3; c++) {
            middle[c] += area * x[c];
            sum[c] += n[c];
        }
        weight += area;
    }
    for (size_t q = 0; q < turning->queued; q++) {
        const uint32_t *corner = &turning->complex->triangle[3 * (size_t)turning->queue[q]];

        middle_of(turning, corner, x);
        vor_triangle_normal(n, turning->xyz, corner);
        for (int c = 0; c < 3; c++)
            x[c] -= weight > 0 ? middle[c] / weight : 0;
        flux += vor_dot(x, n);
        most += sqrt(vor_dot(x, x) * vor_dot(n, n));
    }
    if (!turning->open || fabs(flux) > FLUX * most)
        return flux < 0;
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
    if (!faces_inward(turning))
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
    vor_free(complex->memory, turning.reached);
    vor_free(complex->memory, turning.queue);
    return status;
}
