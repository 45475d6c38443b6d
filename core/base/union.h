/** Disjoint sets of numbers. The root of a set is its smallest number; parent[i] <= i leads to it,
 *  and is i at first. */
#ifndef VOR_BASE_UNION_H
#define VOR_BASE_UNION_H

#include <stdint.h>

/** The root of the set of i; halves the path on the way. */
static inline uint32_t vor_union_root(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/** The same where differs[i] says whether i is of another sign than parent[i]; *odd says whether it
 *  is of another than the root. */
static inline uint32_t vor_union_root_odd(uint32_t *parent, unsigned char *differs, uint32_t i,
                                          unsigned *odd)
{
    *odd = 0;
    while (parent[i] != i) {
        differs[i] ^= differs[parent[i]];
        parent[i] = parent[parent[i]];
        *odd ^= differs[i];
        i = parent[i];
    }
    return i;
}

/** Joins the sets of i and j. */
static inline void vor_union_join(uint32_t *parent, uint32_t i, uint32_t j)
{
    uint32_t a = vor_union_root(parent, i), b = vor_union_root(parent, j);

    parent[a < b ? b : a] = a < b ? a : b;
}

#endif
