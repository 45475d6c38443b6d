/** Squared distances to the points of a list, four at a time. */
#ifndef VOR_KNN_LISTED_H
#define VOR_KNN_LISTED_H

#include "core/base/vector.h"

#include <stdint.h>
#include <string.h>

/** Lists are taken in steps of so many points. */
enum { VOR_LISTED_STEP = 4 };

/** Numbers that an array for `count` squared distances has. */
#define VOR_LISTED_ROOM(count) (((count) + VOR_LISTED_STEP - 1) / VOR_LISTED_STEP * VOR_LISTED_STEP)

typedef float vor_listed __attribute__((vector_size(4 * VOR_LISTED_STEP)));
typedef float vor_listed_at
    __attribute__((vector_size(4 * VOR_LISTED_STEP), aligned(4), may_alias));
typedef int32_t vor_listed_marks __attribute__((vector_size(4 * VOR_LISTED_STEP)));

/** a where the mark is set, else b. */
#define VOR_LISTED_CHOOSE(mark, a, b)                                                              \
    ((vor_listed)(((vor_listed_marks)(a) & (mark)) | ((vor_listed_marks)(b) & ~(mark))))

/** Squared distances from x to the points list[0] to list[3], each as one by one. */
VOR_INLINE void vor_listed_four(vor_listed *out, const float *xyz, const uint32_t *list,
                                const float x[3])
{
    typedef float two __attribute__((vector_size(8)));
    const float *a = &xyz[3 * (size_t)list[0]], *b = &xyz[3 * (size_t)list[1]];
    const float *c = &xyz[3 * (size_t)list[2]], *d = &xyz[3 * (size_t)list[3]];
    vor_listed u, v, w = {a[2], b[2], c[2], d[2]}, first, second;
    two of[VOR_LISTED_STEP];

    memcpy(&of[0], a, sizeof of[0]);
    memcpy(&of[1], b, sizeof of[1]);
    memcpy(&of[2], c, sizeof of[2]);
    memcpy(&of[3], d, sizeof of[3]);
    first = __builtin_shufflevector(of[0], of[1], 0, 1, 2, 3);
    second = __builtin_shufflevector(of[2], of[3], 0, 1, 2, 3);
    u = __builtin_shufflevector(first, second, 0, 2, 4, 6) - x[0];
    v = __builtin_shufflevector(first, second, 1, 3, 5, 7) - x[1];
    w -= x[2];
    *out = u * u + v * v + w * w;
}

/** Squared distances from x to the points of a list, and beyond them up to VOR_LISTED_ROOM(count)
 *  those to the last one again. */
VOR_INLINE void vor_listed_distances(float *distance2, const float *xyz, const uint32_t *list,
                                     unsigned count, const float x[3])
{
    for (unsigned j = 0; j < count; j += VOR_LISTED_STEP) {
        uint32_t last[VOR_LISTED_STEP];
        const uint32_t *these = &list[j];
        vor_listed four;

        if (count - j < VOR_LISTED_STEP) {
            for (unsigned i = 0; i < VOR_LISTED_STEP; i++)
                last[i] = list[j + i < count ? j + i : count - 1];
            these = last;
        }
        vor_listed_four(&four, xyz, these, x);
        *(vor_listed_at *)&distance2[j] = four;
    }
}

/** The largest of n >= 1 numbers. */
VOR_INLINE float vor_listed_largest(const float *of, unsigned n)
{
    float most = of[0];

    if (n >= VOR_LISTED_STEP) {
        vor_listed far = *(const vor_listed_at *)of;

        for (unsigned j = n % VOR_LISTED_STEP; j < n; j += VOR_LISTED_STEP) {
            vor_listed here = *(const vor_listed_at *)&of[j];

            far = VOR_LISTED_CHOOSE(here > far, here, far);
        }
        for (int i = 0; i < VOR_LISTED_STEP; i++)
            most = far[i] > most ? far[i] : most;
        return most;
    }
    for (unsigned j = 1; j < n; j++)
        most = of[j] > most ? of[j] : most;
    return most;
}

/** The place of the first of the least of n >= 1 numbers. */
VOR_INLINE unsigned vor_listed_first(const float *of, unsigned n)
{
    float least = of[0];
    unsigned at = 0;

    if (n >= VOR_LISTED_STEP) {
        vor_listed near = *(const vor_listed_at *)of;

        for (unsigned j = n % VOR_LISTED_STEP; j < n; j += VOR_LISTED_STEP) {
            vor_listed here = *(const vor_listed_at *)&of[j];

            near = VOR_LISTED_CHOOSE(here < near, here, near);
        }
        for (int i = 0; i < VOR_LISTED_STEP; i++)
            least = near[i] < least ? near[i] : least;
    }
    for (unsigned j = 1; n < VOR_LISTED_STEP && j < n; j++)
        least = of[j] < least ? of[j] : least;
    while (of[at] > least)
        at++;
    return at;
}

#endif
