/** Neighbours among points that all move a little from call to call. Each point keeps a list of
 * candidates around the place where the list was made; the answer can be read off it for as long as
 * nobody has moved too far (the neighbour lists of molecular dynamics: Verlet 1967). The few points
 * that jump are looked at apart, so that one of them does not cost everybody a new list. */
#ifndef VOR_KNN_POINT_LISTS_H
#define VOR_KNN_POINT_LISTS_H

#include "core/base/run.h"
#include "core/knn/knn.h"

#define VOR_POINT_LISTS_LISTED_MAX 32  /* neighbours in a list */
#define VOR_POINT_LISTS_JUMPERS_MIN 64 /* jumpers that a set of lists of any size puts up with */
#define VOR_POINT_LISTS_JUMPERS_MAX                                                                \
    1024 /* and one of any size at most; in between one point in 256 */

/** Cells of a grid of 64 to each side, one bit for each, by words. */
#define VOR_POINT_LISTS_CELLS (64 * 64)

struct vor_point_lists {
    struct vor_memory *memory;
    size_t n;
    unsigned listed;     /* neighbours in a list */
    struct vor_knn *knn; /* over the anchors; NULL before the first index */
    float *anchor;       /* n x 3: the positions as of the last index */
    float *place;        /* n x 3: where each point was when its list was made */
    float *reach;     /* n: the anchors of all others but the list are at least this far from it */
    uint32_t *list;   /* n x listed */
    double spacing;   /* mean distance to the nearest neighbour, as of the last index */
    uint64_t indexed; /* times the anchors were indexed */
};

/** The positions that a question is about. */
struct vor_point_lists_view {
    const float *xyz; /**< n x 3 */
    double drift;     /**< no point but the jumpers is farther than this from its anchor */
    unsigned jumpers;
    uint32_t jumper[VOR_POINT_LISTS_JUMPERS_MAX];
    float jumped[3][VOR_POINT_LISTS_JUMPERS_MAX]; /**< where they are */
    float ground; /**< around each of them, so far to all sides (0: not at all) ... */
    uint64_t cells[VOR_POINT_LISTS_CELLS]; /**< ... the cells of a grid are marked */
};

/** Lists for n points; listed < n, and at most VOR_POINT_LISTS_LISTED_MAX.
 *
 *  @retval VOR_E_NOMEM (4 listed + 28) n bytes do not fit */
VOR_NODISCARD vor_status vor_point_lists_init(struct vor_point_lists *out, size_t n,
                                              unsigned listed, struct vor_memory *memory,
                                              struct vor_error *err);

/** lists may be all zero. */
void vor_point_lists_free(struct vor_point_lists *lists);

/** Makes xyz the anchors, and every list anew.
 *
 *  @retval VOR_E_NOMEM the index does not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for */
VOR_NODISCARD vor_status vor_point_lists_index(struct vor_point_lists *lists, const float *xyz,
                                               const struct vor_run *run, struct vor_error *err);

/** How far xyz is from the anchors: points that moved more than `far` spacings are jumpers. False
 * when there are too many of them for the lists to be of use. O(n). */
int vor_point_lists_look(struct vor_point_lists_view *out, const struct vor_point_lists *lists,
                         const float *xyz, double far);

/** Neighbours of a point, nearest first. */
struct vor_crowd {
    unsigned count;
    uint32_t index[VOR_POINT_LISTS_LISTED_MAX + VOR_POINT_LISTS_JUMPERS_MAX];
    float distance2[VOR_POINT_LISTS_LISTED_MAX + VOR_POINT_LISTS_JUMPERS_MAX];
    double sure; /**< every point not among them is at least this far */
};

/** Neighbours of point i as the view has it; never i itself. Where its list does not surely hold
 * everything a little beyond the sixth nearest, it is made anew: only one thread may ask for i at a
 * time.
 *
 *  @return number of searches done */
unsigned vor_point_lists_crowd(struct vor_crowd *out, struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, size_t i);

/** As vor_point_lists_crowd, but content with the neighbours within `distance`, in no order, where
 * the list surely holds them all. */
unsigned vor_point_lists_within(struct vor_crowd *out, struct vor_point_lists *lists,
                                const struct vor_point_lists_view *view, size_t i, double distance);

/** Distance from point i to its nearest neighbour, where the list tells, else -1. */
double vor_point_lists_nearest(const struct vor_point_lists *lists,
                               const struct vor_point_lists_view *view, size_t i);

/** The points whose anchors are the `width` (<= n) nearest to where point i is now, itself among
 * them, in index, distance2 being scratch; jumpers may be missing. Returns how far every other
 * point but the jumpers is at least: infinite where there is none. */
double vor_point_lists_wide(const struct vor_point_lists *lists,
                            const struct vor_point_lists_view *view, size_t i, unsigned width,
                            uint32_t *index, float *distance2);

#endif
