/** Which input points around one lie on its sheet.
 *
 *  Source: Lv et al. 2022, "Intrinsic and Isotropic Resampling for 3D Point Clouds", Sec. 3.2 and
 *  4.1: a neighbour counts only if it is near along the surface too.
 *  Departure: not by distances from three satellites, which do not tell the faces of a closed thin
 *  plate apart (input/satellites.h has them), but by a bounded walk: a neighbour counts if a way of
 *  at most 1.5 times the straight distance leads to it, along edges whose normals agree.
 *  Normals that the input carries are walked over first, where they face opposite ways
 *  (input/sheet_walk.h).
 *
 *  Each point gets the plane through its nine nearest, then the best of its own and its neighbours'
 *  planes, which near another sheet is mostly one that did not mix the two. Where a surface fits
 *  the nearest points badly, layers are looked for (input/sheets.h) if the input has such, which
 *  also part parallel sheets nearer than the spacing; else a walk is tried, and taken if a surface
 *  fits what it reached far better. The planes of the lists then serve a second round. At last,
 *  lists lose the points that lie over theirs and not beside it: those on the other face of a thin
 *  plate. In regions where few points lie on a surface of even their nearest there is noise, which
 *  walks follow: lists there have the nearest points.
 *
 *  Measured, CPU s and uniformity beside the nearest points alone: input/adjacency.c. */
#ifndef VOR_INPUT_ADJACENCY_H
#define VOR_INPUT_ADJACENCY_H

#include "core/geom/graph.h"
#include "core/input/domain.h"
#include "core/input/sheet_walk.h"

/** Square of the cosine of normals along one line. At 0.75 / 0.97 / 0.9936, waves 2.5 spacings
 * apart are .011 / .033 / .052 spacings off (.076 without), of a plate 2.4 spacings thick 143 / 143
 * / 147 of 6,000 points lie inside (244 without); at 0.75 a gear's mesh and a screw's have holes.
 */
#define VOR_NORMALS_ALIKE 0.97
/** Variance off the surface of a list over that of the nearest points, below which these lie on two
 *  sheets. */
#define VOR_OWN_SHEET 0.25

/** Finds out whether lists pay for fits: whether at eight or more of 1,024 places a second sheet
 *  lies over or crosses that of the point. Creases, noise and steps of depth are none.
 *
 *  @param[out] lists   VOR_LISTS_LOCAL, VOR_LISTS_NONE; VOR_LISTS_FEW where but a spot has sheets
 *  @param[in]  nearby  such spots are looked for: where a second sheet lies over a place, the
 *                      points near it count, too. It pays where triangles are to be made, that
 *                      fits to two sheets spoil
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(log n), on the run's pool. The same answer for any number of threads. */
VOR_NODISCARD vor_status vor_adjacency_probe(enum vor_lists *lists, const struct vor_domain *domain,
                                             int nearby, const struct vor_run *run,
                                             struct vor_error *err);

/** Makes the lists of the domain's points. graph->own is 1 where fits are to be made to the
 *  list; elsewhere the nearest points lie on one surface, or the list helps a fit little. Where
 *  known.lists is VOR_LISTS_FEW, only lists near places where a second sheet lies over are made.
 *
 *  @param[out] out  free with vor_graph_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 94 bytes a point do not fit, and 37 more while it works
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool, most of it where fits to the nearest points are bad. The
 *  same lists for any number of threads. */
VOR_NODISCARD vor_status vor_adjacency_make(struct vor_graph *out, const struct vor_domain *domain,
                                            const struct vor_run *run, struct vor_error *err);

#endif
