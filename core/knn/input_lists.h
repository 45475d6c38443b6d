/** Nearest reference points of queries that move a little from call to call. Each query has a list
 *  of candidates, wider than the answer, from which the answer is exact until the query has moved
 *  by the list's margin.
 *
 *  Source: the neighbour lists of molecular dynamics (Verlet 1967, "Computer experiments on
 *  classical fluids"). Most seeds move less than the distance between their neighbours, so an index
 *  for each iteration would find what the last one found. */
#ifndef VOR_KNN_INPUT_LISTS_H
#define VOR_KNN_INPUT_LISTS_H

#include "core/knn/knn.h"

/** Most entries of lists that are made together. */
#define VOR_INPUT_LISTS_TOGETHER 128

/** The lists; owns the arrays, borrows knn and reference. */
struct vor_input_lists {
    struct vor_memory *memory;
    const struct vor_knn *knn;
    const float *reference; /* what knn indexes */
    size_t n, m;            /* queries, reference points */
    unsigned most, wide;    /* most neighbours of an answer; entries of a list for that many */
    int still;              /* queries hardly move */
    uint16_t *k;            /* n: neighbours that each list answers; of a new one that no search
                               has seen, more than any does */
    uint16_t *has;          /* n: entries of each list */
    uint32_t *list;         /* n x wide, the k nearest first */
    float *anchor;          /* n x 3: where the query was when its list was made */
    float *reach;           /* n: points not in the list are at least this far from the anchor; < 0:
                               no list */
    unsigned tried;         /* so many points are, squared, that far from one of them, as a rule */
    float far2;
};

/** What lists are made of. */
struct vor_input_lists_of {
    const struct vor_knn *knn; /**< index of the reference points */
    const float *reference;    /**< m x 3; borrowed, as knn, for the life of the lists */
    size_t m;                  /**< >= most */
    unsigned most;             /**< most neighbours of an answer */
    int still; /**< queries hardly move: lists are as wide as the answers and take two thirds of the
                    time and the memory, but serve no query that moves farther than to its neighbour
                */
};

/** Prepares for n queries; makes no list yet.
 *
 *  @param[out] out  free with vor_input_lists_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM (6 most + 28) n bytes do not fit, of still queries (4 most + 28) n */
VOR_NODISCARD vor_status vor_input_lists_init(struct vor_input_lists *out, size_t n,
                                              const struct vor_input_lists_of *of,
                                              struct vor_memory *memory, struct vor_error *err);

/** Changes the reference points: m others, at least lists->wide. Forgets every list. O(n). */
void vor_input_lists_onto(struct vor_input_lists *lists, const struct vor_knn *knn,
                          const float *reference, size_t m);

/** Frees the lists; they may be all zero. */
void vor_input_lists_free(struct vor_input_lists *lists);

/** What a search tells about its answer. */
enum vor_input_lists_found {
    VOR_INPUT_LISTS_SAME,  /**< the same set of points as in the query's last search */
    VOR_INPUT_LISTS_OTHER, /**< perhaps another set, from the same list */
    VOR_INPUT_LISTS_ANEW   /**< a new list: the index was searched */
};

/** Finds the k <= most nearest reference points of query i, which is at x now. Exact. A list is
 *  made for one k; another k makes it anew.
 *
 *  @param[out] index  vor_input_lists_count points, k but for lists that were narrowed: the nearest
 *                     first, the others in no order; valid until the next search for i
 *
 *  Cannot fail. O(k), O(k log m) with a new list. Different threads may ask for different queries;
 *  the answer depends only on the moves and ks of query i. */
enum vor_input_lists_found vor_input_lists_search(struct vor_input_lists *lists, size_t i,
                                                  const float x[3], unsigned k,
                                                  const uint32_t **index);

/** Searches for the k <= m reference points nearest to any place, without a list: as far as lists
 *  extend as a rule, which takes half of what vor_knn_search does. Thread-safe. */
void vor_input_lists_nearest(const struct vor_input_lists *lists, const float x[3], unsigned k,
                             uint32_t *index, float *distance2);

/** Makes the lists of successive queries together (vor_knn_search_near), if a list has at most
 *  VOR_INPUT_LISTS_TOGETHER entries. The next search for the same k neighbours of one of these, if
 *  it has not moved, has a new list; any other search makes one.
 *
 *  @param[in] xyz  of all queries
 *
 *  O(count k log m), for near queries a third of what the searches take one by one. */
void vor_input_lists_make(struct vor_input_lists *lists, size_t first, size_t count,
                          const float *xyz, unsigned k);

/** Leaves only some of the points around query i to its list, until that is made anew: searches
 * find the nearest of those, and fewer than k where there are fewer.
 *
 *  @param[in] x      where the query is
 *  @param[in] index  count >= 1 points, the nearest first: all that it may find within `reach` of x
 *
 *  i has been searched for. O(k). */
void vor_input_lists_narrow(struct vor_input_lists *lists, size_t i, const float x[3],
                            const uint32_t *index, unsigned count, float reach);

/** How many points the last search for query i found. O(1). */
static inline unsigned vor_input_lists_count(const struct vor_input_lists *lists, size_t i)
{
    return lists->has[i] < lists->k[i] ? lists->has[i] : lists->k[i];
}

/** Finds the reference points nearest to any x near query i, as far as the list of i holds them for
 *  certain.
 *
 *  @param[out] index  room for k; nearest first
 *
 *  @return how many there are, at most k
 *
 *  O(k^2) at worst, without a search. */
unsigned vor_input_lists_around(const struct vor_input_lists *lists, size_t i, const float x[3],
                                unsigned k, uint32_t *index);

/** The reference point nearest to x, which is at one: mostly in the list of i, else a search finds
 *  it. O(k), O(log m) if not listed. */
uint32_t vor_input_lists_at(const struct vor_input_lists *lists, size_t i, const double x[3]);

/** The reference point that was nearest to query i in its last search, of those that its list was
 *  left; there has been one: lists->reach[i] >= 0. */
static inline uint32_t vor_input_lists_first(const struct vor_input_lists *lists, size_t i)
{
    return lists->list[i * lists->wide];
}

#endif
