#include "core/mesh/worst.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"
#include "core/mesh/relax.h"

#include <stdlib.h>
#include <string.h>

/* Strain (mesh/quality.h) above which triangles are made better: that of 45 degrees between edges
 * as long as each other. */
#define BAD ((4 - M_SQRT2) / sqrt(6))

/* The last step of the search is this part of the first: it is halved four times. */
enum { SMALLEST_PART = 1 << 4 };

/* A triangle and its strain. */
struct bad {
    double strain;
    uint32_t triangle;
};

struct worst {
    const struct vor_complex *complex;
    struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    size_t fixed;
    const struct vor_recall *how;
    unsigned char *moved; /* n */
    float *before;        /* n x 7: position, normal and distance to the input before the pass */
    uint32_t *back;       /* n: points that are taken back */
    double *was;          /* n: how bad the triangles around each were before the pass */
    struct bad *bad;      /* a triangle each, `count` are set */
    size_t count;
    vor_status status; /* of what ran on the pool's thread */
    struct vor_error *err;
};

/* Worst first; of as bad ones, the smaller number. */
static int worse_first(const void *a, const void *b)
{
    const struct bad *x = a, *y = b;

    if (x->strain < y->strain || x->strain > y->strain)
        return x->strain > y->strain ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

/* How bad the triangles around point i are: eighth powers of how far their strains are above 1, in
 * sum. */
static double badness_around(const struct worst *worst, uint32_t i)
{
    const struct vor_complex *complex = worst->complex;
    double sum = 0;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];
        double over =
            vor_triangle_strain(worst->seeds->xyz, &complex->triangle[3 * (size_t)at]) - 1;

        over *= over * over * over;
        sum += over * over;
    }
    return sum;
}

/* Whether a triangle around point i has turned over against what it was, as `before` has their
 * normals. */
static int has_turned(const struct worst *worst, uint32_t i, double before[][3])
{
    const struct vor_complex *complex = worst->complex;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];
        double normal[3];

        vor_triangle_normal(normal, worst->seeds->xyz, &complex->triangle[3 * (size_t)at]);
        if (!(vor_dot(normal, before[t]) >
              VOR_TRIANGLE_TURNED * sqrt(vor_dot(normal, normal) * vor_dot(before[t], before[t]))))
            return 1;
    }
    return 0;
}

/* The normals of the triangles around point i, and the mean length of the edges. */
static double normals_of(const struct worst *worst, uint32_t i, double normal[][3])
{
    const struct vor_complex *complex = worst->complex;
    const float *xyz = worst->seeds->xyz;
    double length = 0;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t], other[2];

        vor_triangle_normal(normal[t], xyz, &complex->triangle[3 * (size_t)at]);
        vor_complex_others(complex, at, i, other);
        length += sqrt(vor_distance2f(&xyz[3 * (size_t)i], &xyz[3 * (size_t)other[0]]));
    }
    return length / complex->degree[i];
}

/* Moves point i to where the triangles around it are least bad. */
static void move(struct worst *worst, uint32_t i, unsigned worker)
{
    struct vor_seeds *seeds = worst->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    float *at = &seeds->xyz[3 * (size_t)i];
    double axis[3][3], normal[VOR_AROUND_MOST][3] = {{0}}, best, length;

    if (i + worst->fixed >= seeds->n || !vor_complex_surrounds(worst->complex, i) ||
        vor_seeds_recall(seeds, scratch, i, worst->how) == VOR_SURFACE_NONE)
        return;
    length = normals_of(worst, i, normal);
    vor_relax_axes(axis, worst->complex, seeds->xyz, i);
    best = badness_around(worst, i);
    for (int part = 1; part <= SMALLEST_PART && best > 0; part *= 2) {
        double step = VOR_RELAX_STEP_MAX * length / part;
        float from[3];
        int better = 0;

        memcpy(from, at, sizeof from);
        for (int u = -1; u <= 1; u++)
            for (int v = -1; v <= 1; v++) {
                float before[3];
                double x[3], here;

                if (u == 0 && v == 0)
                    continue;
                memcpy(before, at, sizeof before);
                for (int c = 0; c < 3; c++)
                    x[c] = (double)from[c] + step * (u * axis[0][c] + v * axis[1][c]);
                vor_surface_put(&scratch->onto, x);
                vor_to_floats(at, x);
                here = badness_around(worst, i);
                if (here < best && !has_turned(worst, i, normal)) {
                    best = here;
                    better = 1;
                } else {
                    memcpy(at, before, sizeof before);
                }
            }
        worst->moved[i] |= (unsigned char)better;
    }
}

/* Moves the corners of a triangle, and if it stays bad the points around them. */
static void move_at(struct worst *worst, const uint32_t corner[3], unsigned worker)
{
    const struct vor_complex *complex = worst->complex;

    for (int c = 0; c < 3; c++)
        move(worst, corner[c], worker);
    for (int c = 0; c < 3; c++)
        for (unsigned t = 0;
             t < complex->degree[corner[c]] && vor_triangle_strain(worst->seeds->xyz, corner) > BAD;
             t++) {
            uint32_t at = complex->around[(size_t)corner[c] * VOR_AROUND_MOST + t], other[2];

            vor_complex_others(complex, at, corner[c], other);
            move(worst, other[0], worker);
        }
}

/* Lists the bad triangles. */
static void list(struct worst *worst)
{
    const struct vor_complex *complex = worst->complex;

    worst->count = 0;
    for (uint32_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * (size_t)t];
        double strain =
            corner[0] == VOR_COMPLEX_GONE ? 0 : vor_triangle_strain(worst->seeds->xyz, corner);

        if (strain > BAD)
            worst->bad[worst->count++] = (struct bad){strain, t};
    }
    qsort(worst->bad, worst->count, sizeof *worst->bad, worse_first);
}

/* One of the seven numbers of point i that a pass changes. */
static float *number_of(const struct worst *worst, uint32_t i, int k)
{
    size_t row = 3 * (size_t)i;

    return k < 3   ? &worst->seeds->xyz[row + (size_t)k]
           : k < 6 ? &worst->sheet->normal[row + (size_t)k - 3]
                   : &worst->sheet->near[i];
}

/* Exchanges what a pass changes of point i with what was before. */
static void exchange(struct worst *worst, uint32_t i)
{
    for (int k = 0; k < 7; k++) {
        float *here = number_of(worst, i, k), now = *here;

        *here = worst->before[7 * (size_t)i + (size_t)k];
        worst->before[7 * (size_t)i + (size_t)k] = now;
    }
}

/* Whether point i is as far from the input as points that hang (vor_attach_hanging), and was not
 * before the pass. */
static int hangs(const struct worst *worst, uint32_t i)
{
    const struct vor_seeds *seeds = worst->seeds;
    double most = VOR_HOLE_INSIDE *
                  fmax(sqrt(seeds->area / (double)seeds->n), seeds->last_fit[i].surface.spacing);

    return (double)worst->sheet->near[i] > most && (double)worst->before[7 * (size_t)i + 6] <= most;
}

/* Takes point i back if it has moved, and hangs or has worse triangles around it than before and
 * than where it was. */
static size_t take_back(struct worst *worst, uint32_t i, size_t count)
{
    double here = hangs(worst, i) ? INFINITY : badness_around(worst, i);

    if (!worst->moved[i] || here <= worst->was[i])
        return count;
    exchange(worst, i);
    if (badness_around(worst, i) >= here) {
        exchange(worst, i);
        return count;
    }
    worst->moved[i] = 0;
    worst->back[count] = i;
    return count + 1;
}

/* Points that were put onto the surface may lie elsewhere than the search looked, and others around
 * them have moved, too: where that has made triangles worse, points go back. */
static void look_again(struct worst *worst)
{
    const struct vor_complex *complex = worst->complex;
    size_t count = 0;

    for (uint32_t i = 0; i < complex->n; i++)
        count = take_back(worst, i, count);
    for (size_t k = 0; k < count; k++)
        for (unsigned t = 0; t < complex->degree[worst->back[k]]; t++) {
            uint32_t at = complex->around[(size_t)worst->back[k] * VOR_AROUND_MOST + t];

            for (int c = 0; c < 3; c++)
                count = take_back(worst, complex->triangle[3 * (size_t)at + (size_t)c], count);
        }
}

/* Looks at the bad triangles once. */
static void improve_on_one(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end,
                           unsigned worker)
{
    struct worst *worst = ctx;

    worst->status = VOR_OK;
    for (uint32_t i = 0; i < worst->complex->n; i++) {
        for (int k = 0; k < 7; k++)
            worst->before[7 * (size_t)i + (size_t)k] = *number_of(worst, i, k);
        worst->was[i] = badness_around(worst, i);
    }
    list(worst);
    for (size_t k = 0; k < worst->count && worst->status == VOR_OK; k++) {
        worst->status = vor_run_answered(vor_run_poll(&worst->seeds->run), worst->err);
        if (worst->status == VOR_OK)
            move_at(worst, &worst->complex->triangle[3 * (size_t)worst->bad[k].triangle], worker);
    }
}

vor_status vor_worst_improve(const struct vor_complex *complex, struct vor_sheet *sheet,
                             struct vor_seeds *seeds, size_t fixed, const struct vor_recall *how,
                             struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct worst worst = {complex, sheet, seeds, fixed, how, .err = err};
    vor_status status = VOR_OK;

    worst.moved = vor_calloc(memory, seeds->n, 1);
    worst.before = vor_malloc(memory, seeds->n, 7 * sizeof *worst.before);
    worst.back = vor_malloc(memory, seeds->n, sizeof *worst.back);
    worst.was = vor_malloc(memory, seeds->n, sizeof *worst.was);
    worst.bad = vor_malloc(memory, complex->count + 1, sizeof *worst.bad);
    if (worst.moved == NULL || worst.before == NULL || worst.back == NULL || worst.was == NULL ||
        worst.bad == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    if (status == VOR_OK)
        status = vor_run_for(&seeds->run, 1, 1, improve_on_one, &worst, err);
    if (status == VOR_OK)
        status = worst.status;
    if (status == VOR_OK)
        status = vor_sheet_put(sheet, seeds, worst.moved, how, err);
    if (status == VOR_OK)
        look_again(&worst);
    VOR_FREE_ALL(memory, worst.bad, worst.was, worst.back, worst.before, worst.moved);
    return status;
}
