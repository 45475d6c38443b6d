/** Four points at once: sums over neighbours by lanes. Each number is of the same terms in the same
 *  order as one by one. For functions with VOR_CLONES. */
#ifndef VOR_GEOM_FOURS_H
#define VOR_GEOM_FOURS_H

#include "core/base/vector.h"

#include <stdint.h>
#include <string.h>

enum { VOR_FOURS_LANES = 4 };
typedef double vor_fours __attribute__((vector_size(8 * VOR_FOURS_LANES)));
typedef int64_t vor_fours_marks __attribute__((vector_size(8 * VOR_FOURS_LANES)));

/** a where the mark is set, else b. */
#define VOR_FOURS_CHOOSE(mark, a, b)                                                               \
    ((vor_fours)(((vor_fours_marks)(a) & (mark)) | ((vor_fours_marks)(b) & ~(mark))))

/** Whether a mark is set. */
VOR_INLINE int vor_fours_any(const vor_fours_marks *of)
{
    return ((*of)[0] | (*of)[1] | (*of)[2] | (*of)[3]) != 0;
}

/** The ways from x to points i to i + 3 of k; those beyond the last are to that one. */
VOR_INLINE void vor_fours_ways(vor_fours way[3], const float *near, unsigned k, unsigned i,
                               const double x[3])
{
    typedef float floats __attribute__((vector_size(4 * VOR_FOURS_LANES)));
    const float *at = &near[3 * (size_t)i];
    float last[3 * VOR_FOURS_LANES];
    floats a, b, c, u, v, w;

    if (k - i < VOR_FOURS_LANES) {
        for (unsigned j = 0; j < VOR_FOURS_LANES; j++)
            memcpy(&last[3 * (size_t)j], &near[3 * (size_t)(i + j < k ? i + j : k - 1)],
                   3 * sizeof *last);
        at = last;
    }
    memcpy(&a, at, sizeof a);
    memcpy(&b, &at[VOR_FOURS_LANES], sizeof b);
    memcpy(&c, &at[2 * (size_t)VOR_FOURS_LANES], sizeof c);
    u = __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 3, 6, 6), c, 0, 1, 2, 5);
    v = __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 4, 7, 7), c, 0, 1, 2, 6);
    w = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 5, 5, 5), c, 0, 1, 4, 7);
    way[0] = __builtin_convertvector(u, vor_fours) - x[0];
    way[1] = __builtin_convertvector(v, vor_fours) - x[1];
    way[2] = __builtin_convertvector(w, vor_fours) - x[2];
}

/** The scalar products of four ways with one. */
VOR_INLINE void vor_fours_along(vor_fours *out, const double one[3], const vor_fours way[3])
{
    *out = one[0] * way[0] + one[1] * way[1] + one[2] * way[2];
}

/** Their squared lengths. */
VOR_INLINE void vor_fours_squares(vor_fours *out, const vor_fours way[3])
{
    *out = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
}

#endif
