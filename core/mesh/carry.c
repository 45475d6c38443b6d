#include "core/mesh/carry.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"

#include <math.h>
#include <string.h>

struct carrying {
    struct vor_seeds *seeds;
    const struct vor_complex *complex;
    const float *before; /* n x 3 */
    const float *found;  /* n x 3: the normals there */
};

/* The sum of the normals of the triangles at point i, as large as they are. */
static void face(double facing[3], const struct carrying *carrying, size_t i)
{
    const struct vor_complex *complex = carrying->complex;

    memset(facing, 0, 3 * sizeof *facing);
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[i * VOR_AROUND_MOST + t];
        double normal[3];

        vor_triangle_normal(normal, carrying->seeds->xyz, &complex->triangle[3 * (size_t)at]);
        for (int c = 0; c < 3; c++)
            facing[c] += normal[c];
    }
}

/* How far point i is off the place where the normal of point j was found: across its plane,
 * squared, times away. Degrees off the truth by this / by all of the 16 nearest such places:
 * fandisk to 4,000 1.10 / 1.09, armadillo to 30,000 6.58 / 6.85, cow 7.95 / 8.09, noisy fandisk
 * 5.15 / 5.12. Among those, by the square of neither / by the former over the latter / by the
 * former alone: 1.23, 1.05, 1.00; 6.64, 6.93, 6.74; 8.16, 8.30, 8.14; 5.25, 5.05, 5.06. */
static double off(const struct carrying *carrying, size_t i, size_t j, const double normal[3])
{
    double way[3], across;

    vor_way(way, &carrying->before[3 * j], &carrying->seeds->xyz[3 * i]);
    across = vor_dot(way, normal);
    return across * across * sqrt(vor_dot(way, way));
}

static void carry_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct carrying *carrying = ctx;
    const struct vor_complex *complex = carrying->complex;

    for (size_t i = begin; i < end; i++) {
        const float *own = &carrying->found[3 * i];
        double facing[3], least = INFINITY;

        if (vor_dotf(own, own) <= 0)
            continue;
        face(facing, carrying, i);
        for (unsigned c = 0; c < 3u * complex->degree[i]; c++) {
            uint32_t at = complex->around[i * VOR_AROUND_MOST + c / 3];
            size_t j = complex->triangle[3 * (size_t)at + c % 3];
            double normal[3], now;

            vor_to_doubles(normal, &carrying->found[3 * j]);
            now = off(carrying, i, j, normal);
            if (vor_dot(normal, facing) > 0 && now < least) {
                least = now;
                vor_to_floats(&carrying->seeds->normal[3 * i], normal);
            }
        }
    }
}

vor_status vor_carry_normals(struct vor_seeds *seeds, const struct vor_complex *complex,
                             const float *before, struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    float *found = vor_malloc(memory, seeds->n, 3 * sizeof *found);
    struct carrying carrying = {seeds, complex, before, found};
    vor_status status;

    if (found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    memcpy(found, seeds->normal, 3 * seeds->n * sizeof *found);
    status = vor_run_for(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, carry_block, &carrying, err);
    vor_free(memory, found);
    return status;
}
