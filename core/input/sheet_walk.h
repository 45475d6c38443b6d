/** Walks to the points that lie on one sheet with a point: over normals of planes fitted around the
 *  points, or over those that the input carries. */
#ifndef VOR_INPUT_SHEET_WALK_H
#define VOR_INPUT_SHEET_WALK_H

#include "core/geom/walk.h"
#include "core/input/domain.h"

/** Neighbours that a point has at most. */
#define VOR_ADJACENT VOR_NEIGHBORS_FEWEST
/** Fewest points of a list, and those that a surface goes through. At 8 / 10 / 13: cow 0.062 /
 * 0.063 / 0.064, room 0.0446 / 0.0459 / 0.0489 (adjacency.c). */
enum { VOR_ADJACENT_FEWEST = 8 };

/** Sines of the steepest edge of a walk (vor_walk.arc), the first to be tried first. */
enum { VOR_SHEET_ARCS = 2 };
extern const double vor_sheet_arcs[VOR_SHEET_ARCS];

/** Fits a surface to the points nearest to point i, next in a row of searches.
 *
 *  @return whether it fits so badly that they may lie on several sheets
 *
 *  One search. Cannot fail; nor can the others. Thread-safe. */
int vor_sheet_walk_begin(struct vor_surface *plain, const struct vor_domain *domain, uint32_t i,
                         struct vor_knn_last *last);

/** Gathers the points for a walk from point i. One search. */
void vor_sheet_walk_gather(struct vor_walk *walk, const struct vor_domain *domain, uint32_t i);

/** Takes the first k points that the walk reached, or fewer; returns how many. */
unsigned vor_sheet_walk_take(const struct vor_walk *walk, unsigned k, uint32_t *index);

/** Walks over the normals of the walk, with each arc, until what is reached is a sheet of its own.
 *
 *  @param[out] own    surface of that sheet
 *  @param[in]  plain  that of the nearest points
 *  @param[out] index  room for VOR_ADJACENT: points of the sheet
 *
 *  @return how many they are; 0: none is a sheet of its own */
unsigned vor_sheet_walk_go(struct vor_walk *walk, struct vor_surface *own,
                           const struct vor_surface *plain, const struct vor_domain *domain,
                           uint32_t *index);

/** As vor_sheet_walk_go, over the normals that the input carries: what faces the other way is
 *  another sheet, however near. None is found where a point has no normal, where no points face the
 *  other way, or where one of these lies on the sheet's surface: signs say nothing there. */
unsigned vor_sheet_walk_carried(struct vor_walk *walk, struct vor_surface *own,
                                const struct vor_surface *plain, const struct vor_domain *domain,
                                uint32_t *index);

/** Whether those of the nearest that the walk left out lie far off the n points of the sheet, and
 *  over them. O(n). */
int vor_sheet_walk_left_over(const struct vor_walk *walk, const struct vor_surface *own,
                             const struct vor_domain *domain, const uint32_t *index, unsigned n);

#endif
