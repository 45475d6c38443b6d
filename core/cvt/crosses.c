#include "core/cvt/crosses.h"

#include "core/base/linalg.h"

#include <string.h>

enum { BLOCK = 256 }; /* seeds of one task */

/* From which on the surface says where a cross lies: the square of the difference of its curvatures
 * over the variance of the points about it, times their number and the fourth power of their reach.
 * Points spread over a disc determine the part u^2 - v^2 of a quadric to 6, the square of the
 * difference is 16 times that, and there are two such parts. At a quarter
 * of it the four-fold order psi4 with p of 8 (tests/paper/chen2018_lp_test.c, without noise and
 * with a tenth of the result's spacing) is 0.888 on the tube and 0.928 on fillets instead of 0.888
 * and 0.919; seeds move both by 0.02. */
#define SURE (6 * 16 * 2 * VOR_SURE * VOR_SURE)

vor_status vor_crosses_init(struct vor_crosses *out, size_t n, struct vor_memory *memory,
                            struct vor_error *err)
{
    struct vor_crosses crosses = {.memory = memory, .n = n};

    if (VOR_MAKE_ALL(memory, err, n, VOR_ZEROED(crosses.own, n, 3), VOR_ZEROED(crosses.now, n, 2),
                     VOR_ZEROED(crosses.next, n, 2), VOR_ZEROED(crosses.kept, n, 3)) != VOR_OK) {
        vor_crosses_free(&crosses);
        return VOR_E_NOMEM;
    }
    *out = crosses;
    return VOR_OK;
}

void vor_crosses_free(struct vor_crosses *crosses)
{
    VOR_FREE_ALL(crosses->memory, crosses->kept, crosses->next, crosses->now, crosses->own);
    memset(crosses, 0, sizeof *crosses);
}

/* The square of a unit vector as a complex number: twice its angle. */
static void doubled(double out[2], double x, double y)
{
    out[0] = x * x - y * y;
    out[1] = 2 * x * y;
}

/* A unit vector of half the angle. */
static void halved(double out[2], double x, double y)
{
    if (x >= 0) {
        out[0] = sqrt((1 + x) / 2);
        out[1] = y / (2 * out[0]);
    } else {
        out[1] = copysign(sqrt((1 - x) / 2), y);
        out[0] = y / (2 * out[1]);
    }
}

/* The traceless part of the second fundamental form in the tangents of axes: half of the difference
 * of the curvatures, at twice the angle of the greater one. */
static void apart(double out[2], const struct vor_surface *surface, const double at[3],
                  const double axes[9])
{
    const double *c = surface->c;
    double g[2], e[2][2], steep, u[3];

    (void)vor_surface_height(surface, at[0], at[1], g);
    steep = sqrt(1 + g[0] * g[0] + g[1] * g[1]);
    for (int t = 0; t < 2; t++)
        for (int d = 0; d < 2; d++)
            e[t][d] = vor_dot(surface->axis[d], &axes[3 * t]);
    for (int t = 0; t < 3; t++) {
        const double *a = e[t / 2], *b = e[(t + 1) / 2]; /* 00, 01, 11 */

        u[t] = 2 * c[3] * a[0] * b[0] + c[4] * (a[0] * b[1] + a[1] * b[0]) + 2 * c[5] * a[1] * b[1];
    }
    out[0] = (u[0] - u[2]) / (2 * steep);
    out[1] = u[1] / steep;
}

/* Weight of what the surface says, whose curvatures differ by twice `half`, beside the mean of the
 * crosses around. */
static double weight_of(const struct vor_surface *surface, unsigned k, double half)
{
    double reach2 = surface->reach * surface->reach;

    return fmax(0, 1 - SURE * surface->off2 / (4 * half * half * k * reach2 * reach2));
}

void vor_crosses_set(struct vor_crosses *crosses, size_t i, const struct vor_cross_fit *fit,
                     const double axes[9])
{
    double *own = &crosses->own[3 * i], *now = &crosses->now[2 * i], half[2] = {0}, length, x, y;
    const float *kept = &crosses->kept[3 * i];
    double before[3] = {(double)kept[0], (double)kept[1], (double)kept[2]}, sure;

    if (fit->surface->kind == VOR_SURFACE_QUADRIC)
        apart(half, fit->surface, fit->at, axes);
    length = sqrt(half[0] * half[0] + half[1] * half[1]);
    own[0] = own[1] = own[2] = 0;
    if (length > 0) {
        own[2] = weight_of(fit->surface, fit->k, length);
        doubled(own, half[0] / length, half[1] / length);
        own[0] *= own[2];
        own[1] *= own[2];
    }
    now[0] = own[0] / (1 + own[2]);
    now[1] = own[1] / (1 + own[2]);
    x = vor_dot(&axes[0], before);
    y = vor_dot(&axes[3], before);
    length = sqrt(x * x + y * y);
    sure = sqrt(vor_dot(before, before));
    if (!(length > 0))
        return;
    doubled(now, x / length, y / length);
    doubled(now, now[0], now[1]);
    now[0] *= sure;
    now[1] *= sure;
}

/* Adds the cross of seed j as it is in the plane of seed i: its first tangent is laid into that
 * plane. */
static void add_cross(double sum[2], const double *axes, const double *now, size_t i, size_t j)
{
    const double *a = &axes[9 * i], *b = &axes[9 * j];
    double x = vor_dot(a, b), y = vor_dot(a + 3, b), length = sqrt(x * x + y * y), turn[2];
    double c = now[2 * j], s = vor_dot(a + 6, b + 6) < 0 ? -now[2 * j + 1] : now[2 * j + 1];

    if (!(length > 0))
        return;
    doubled(turn, x / length, y / length);
    doubled(turn, turn[0], turn[1]);
    sum[0] += c * turn[0] - s * turn[1];
    sum[1] += c * turn[1] + s * turn[0];
}

struct round {
    struct vor_crosses *crosses;
    const double *axes;
    const uint32_t *near;
    unsigned width, take;
};

static void round_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct round *round = ctx;
    struct vor_crosses *crosses = round->crosses;

    for (size_t i = begin; i < end; i++) {
        const double *own = &crosses->own[3 * i];
        double sum[2] = {0};

        for (unsigned j = 0; j < round->take; j++)
            add_cross(sum, round->axes, crosses->now, i, round->near[i * round->width + j]);
        for (size_t d = 0; d < 2; d++)
            crosses->next[2 * i + d] =
                (own[d] + sum[d] / (round->take > 0 ? round->take : 1)) / (1 + own[2]);
    }
}

vor_status vor_crosses_smooth(struct vor_crosses *crosses, const double *axes, const uint32_t *near,
                              unsigned width, unsigned take, const struct vor_run *run,
                              struct vor_error *err)
{
    struct round round = {crosses, axes, near, width, take};
    double *last = crosses->now;
    vor_status status = vor_run_for(run, crosses->n, BLOCK, round_block, &round, err);

    crosses->now = crosses->next;
    crosses->next = last;
    return status;
}

void vor_crosses_turn(struct vor_crosses *crosses, size_t i, double axes[9])
{
    const double *now = &crosses->now[2 * i];
    double length = sqrt(now[0] * now[0] + now[1] * now[1]), way[2] = {1, 0}, first[3];

    if (length > 0) {
        halved(way, now[0] / length, now[1] / length);
        halved(way, way[0], way[1]);
    }
    for (int c = 0; c < 3; c++)
        first[c] = way[0] * axes[c] + way[1] * axes[3 + c];
    vor_cross(&axes[3], &axes[6], first);
    memcpy(axes, first, sizeof first);
    for (size_t c = 0; c < 3; c++)
        crosses->kept[3 * i + c] = (float)(length * first[c]);
}
