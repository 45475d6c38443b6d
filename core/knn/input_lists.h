/** Nearest reference points of queries that move a little from call to call: each query keeps a
 * list of candidates, wide enough that the answer can be read off it until the query has moved by
 * the list's margin (the neighbour lists of molecular dynamics: Verlet 1967). */
#ifndef VOR_KNN_INPUT_LISTS_H
#define VOR_KNN_INPUT_LISTS_H

#include "core/knn/knn.h"

struct vor_input_lists {
    struct vor_memory *memory;
    const struct vor_knn *knn;
    const float *reference; /* what knn indexes */
    size_t n, m;            /* queries, reference points */
    unsigned most, wide;    /* neighbours at most; those that a list of so many has */
    uint16_t *k;            /* n: how many are wanted of a list */
    uint32_t *list;         /* n x wide, the k nearest first */
    float *anchor;          /* n x 3: where the query was when its list was made */
    float
        *reach; /* every point beyond the list is at least this far from the anchor; < 0: no list */
};

/** For n queries of up to `most` nearest of m reference points (m x 3 floats, most <= m), without
 * lists yet.
 *
 *  @retval VOR_E_NOMEM (6 most + 26) n bytes do not fit */
VOR_NODISCARD vor_status vor_input_lists_init(struct vor_input_lists *out, size_t n, unsigned most,
                                              const struct vor_knn *knn, const float *reference,
                                              size_t m, struct vor_memory *memory,
                                              struct vor_error *err);

/** From now on the neighbours are those among m other reference points, at least as many as a list
 * holds; every list is forgotten. */
void vor_input_lists_onto(struct vor_input_lists *lists, const struct vor_knn *knn,
                          const float *reference, size_t m);

/** lists may be all zero. */
void vor_input_lists_free(struct vor_input_lists *lists);

/** What a search found out. */
enum vor_input_lists_found {
    VOR_INPUT_LISTS_SAME,  /**< the set is the one of the query's last search */
    VOR_INPUT_LISTS_OTHER, /**< it may not be */
    VOR_INPUT_LISTS_ANEW   /**< nor is the list: the index was searched */
};

/** The k <= most nearest reference points of query i, now at x. Exact. A list is made for one k,
 * and made anew for another. What comes out depends on the query's own moves and ks only, not on
 * who asks when: different queries may be asked by different threads.
 *
 *  @param[out] index  k points in any order but the nearest first; valid until the next search for
 *                     i */
enum vor_input_lists_found vor_input_lists_search(struct vor_input_lists *lists, size_t i,
                                                  const float x[3], unsigned k,
                                                  const uint32_t **index);

/** The reference points nearest to any x near query i, nearest first, as far as the list of i
 * surely holds them: as many as that, k at most. */
unsigned vor_input_lists_around(const struct vor_input_lists *lists, size_t i, const float x[3],
                                unsigned k, uint32_t *index);

/** The reference point that was nearest to query i in its last search. */
static inline uint32_t vor_input_lists_first(const struct vor_input_lists *lists, size_t i)
{
    return lists->list[i * lists->wide];
}

#endif
