/** Neighbours among points that all move a little from call to call. Each point has a list of
 *  candidates around the place where the list was made, from which answers are exact until points
 *  have moved too far. The few points that move farther (jumpers) are tested one by one, so that
 *  one of them does not make all lists anew.
 *
 *  Source: the neighbour lists of molecular dynamics (Verlet 1967, "Computer experiments on
 *  classical fluids"); jumpers are not in it.
 *
 *  Lists are made anew when positions say so, never by the clock, the thread or the order of the
 *  questions, and only the thread that asks for a point writes to its list. So a run uses the same
 *  lists for any number of threads, and counts the same searches. */
#ifndef VOR_KNN_POINT_LISTS_H
#define VOR_KNN_POINT_LISTS_H

#include "core/base/run.h"
#include "core/knn/knn.h"

/** Most neighbours in a list. */
#define VOR_POINT_LISTS_LISTED_MAX 128

/** Spacings that a point may move before it is a jumper. At 0.15 / 0.3 / 0.6: searches on igea 59 /
 *  45 / 65 thousand, lists made 12 / 7 / 3 times, on autzen 252 / 198 / 253 thousand, 56 / 28 / 12
 *  times. */
#define VOR_POINT_LISTS_FAR 0.3

/** Jumpers that lists of any size allow before all are made anew; with more points one in 256, at
 *  most JUMPERS_MAX. At 32 / 64 / 128, autzen to 3,000: lists made 31 / 28 / 23 times, searches 209
 *  / 198 / 181 thousand; but each point near a jumper tests all of them. */
#define VOR_POINT_LISTS_JUMPERS_MIN 64
#define VOR_POINT_LISTS_JUMPERS_MAX 1024

/** Cells of a grid of 64 to each side, one bit for each, by words. */
#define VOR_POINT_LISTS_CELLS (64 * 64)

/** The lists; owns everything. */
struct vor_point_lists {
    struct vor_memory *memory;
    size_t n;
    unsigned listed;     /* neighbours in a list */
    struct vor_knn *knn; /* over the anchors; NULL before the first index */
    float *anchor;       /* n x 3: the positions as of the last index */
    float *place;        /* n x 3: where each point was when its list was made */
    float *reach;   /* n: anchors of points not in the list are at least this far from the place */
    uint32_t *list; /* n x listed */
    double spacing; /* mean distance to the nearest neighbour, as of the last index */
    uint64_t indexed; /* times the anchors were indexed */
};

/** The positions that questions are about, beside the anchors. */
struct vor_point_lists_view {
    const float *xyz; /**< n x 3 */
    double drift;     /**< every point except the jumpers is within this of its anchor */
    unsigned jumpers;
    uint32_t jumper[VOR_POINT_LISTS_JUMPERS_MAX];
    float jumped[3][VOR_POINT_LISTS_JUMPERS_MAX]; /**< where they are */
    float ground; /**< the cells of a grid within this of a jumper, along each axis, are marked; 0:
                       the grid is not used */
    uint64_t cells[VOR_POINT_LISTS_CELLS]; /**< the marks */
};

/** Prepares lists of `listed` neighbours for n points; there are none before the first
 *  vor_point_lists_index.
 *
 *  @param[out] out     free with vor_point_lists_free; untouched on failure
 *  @param[in]  listed  less than n, at most VOR_POINT_LISTS_LISTED_MAX
 *
 *  @retval VOR_E_NOMEM (4 listed + 28) n bytes do not fit */
VOR_NODISCARD vor_status vor_point_lists_init(struct vor_point_lists *out, size_t n,
                                              unsigned listed, struct vor_memory *memory,
                                              struct vor_error *err);

/** Frees the lists; they may be all zero. */
void vor_point_lists_free(struct vor_point_lists *lists);

/** Forgets all lists. O(1). */
void vor_point_lists_forget(struct vor_point_lists *lists);

/** Makes the positions xyz (n x 3) the anchors, and every list anew. On failure there are no lists.
 *
 *  @retval VOR_E_NOMEM the index does not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n); the searches run on the run's pool. */
VOR_NODISCARD vor_status vor_point_lists_index(struct vor_point_lists *lists, const float *xyz,
                                               const struct vor_run *run, struct vor_error *err);

/** Compares positions with the anchors. Points that moved by more than `far` spacings are jumpers.
 *
 *  @param[out] out  refers to xyz
 *
 *  @return false, and *out must not be used, when there are no lists or too many jumpers
 *
 *  O(n). */
int vor_point_lists_look(struct vor_point_lists_view *out, const struct vor_point_lists *lists,
                         const float *xyz, double far);

/** Neighbours of a point, nearest first. */
struct vor_crowd {
    unsigned count;
    uint32_t index[VOR_POINT_LISTS_LISTED_MAX + VOR_POINT_LISTS_JUMPERS_MAX];
    float distance2[VOR_POINT_LISTS_LISTED_MAX + VOR_POINT_LISTS_JUMPERS_MAX];
    double sure; /**< every point that is not listed is at least this far away; may be negative */
};

/** Gathers the neighbours of point i in the view, without i itself. Makes the list of i anew if it
 *  does not hold for certain everything to a little beyond the sixth nearest: only one thread at a
 *  time may ask for i.
 *
 *  @return number of searches done: 0 or 1
 *
 *  O(listed + jumpers), and a search. */
unsigned vor_point_lists_crowd(struct vor_crowd *out, struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, size_t i);

/** Makes the lists of points near each other anew, together (vor_knn_search_near): those that
 *  vor_point_lists_crowd would make anew.
 *
 *  @param[in] who  `count` of the points
 *
 *  @return number of searches done
 *
 *  O(count listed), and a third of what the searches take one by one. */
unsigned vor_point_lists_renew(struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, const uint32_t *who,
                               size_t count);

/** The neighbours within `distance`, in no order, if the list holds them all for certain; else
 *  vor_point_lists_crowd. */
unsigned vor_point_lists_within(struct vor_crowd *out, struct vor_point_lists *lists,
                                const struct vor_point_lists_view *view, size_t i, double distance);

/** The list of point i, without i itself, if it holds all neighbours within `distance` for certain
 *  and no jumper is there; else NULL. O(1) where no jumper is near. */
const uint32_t *vor_point_lists_all(const struct vor_point_lists *lists,
                                    const struct vor_point_lists_view *view, size_t i,
                                    double distance);

/** The list of point i and all jumpers, without i itself, in no order: a jumper may be there twice.
 *  out->distance2 is not set. O(listed + jumpers). */
void vor_point_lists_candidates(struct vor_crowd *out, const struct vor_point_lists *lists,
                                const struct vor_point_lists_view *view, size_t i);

/** Distance from point i to its nearest neighbour, or -1 if the list cannot answer for certain.
 *  O(listed + jumpers). */
double vor_point_lists_nearest(const struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, size_t i);

/** Searches for the `width` <= n points whose anchors are nearest to where point i is now; i is
 *  among them, jumpers may be missing.
 *
 *  @param[out] index      width points
 *  @param[out] distance2  width floats of scratch
 *
 *  @return a distance that all other points except the jumpers have at least; infinite if there are
 *          none */
double vor_point_lists_wide(const struct vor_point_lists *lists,
                            const struct vor_point_lists_view *view, size_t i, unsigned width,
                            uint32_t *index, float *distance2);

#endif
