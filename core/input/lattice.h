/** An input whose coordinates were rounded to a lattice (voxels, octree cells, a codec's
 * quantisation): its cells are found, and its points moved within them onto a smooth surface.
 *
 *  Source: none of the papers; Xiao 2024 Sec. V-C resamples octree-decoded clouds as they are.
 *
 *  Found: along each axis a sample's distinct values are gaps apart that are all multiples of the
 *  cell. Candidates are a few quantiles of the gaps and their halves, thirds and quarters; each is
 *  followed from one value over the whole axis, fitted anew every time the way doubles, and the
 *  largest that has 999 of 1000 values on it is put to all points.
 *
 *  Smoothed: a point lies somewhere in its cell, and where cells are as large as the spacing, that
 *  is most of what is wrong with it. Each goes to the foot on a quadric that its neighbours weigh
 *  less in the farther they are, but stays in its own cell, the box of that size around where it
 *  was. How far cells put points off a plane is known: where neighbours are farther off the quadric
 *  than that, it misses a detail, and half of them are tried. Where no number of them will do, at
 *  an edge, a point stays.
 *
 *  Not done: a decoder that puts points into the corners of cells instead of their middle leaves a
 *  shift of half a cell that nobody can see. */
#ifndef VOR_INPUT_LATTICE_H
#define VOR_INPUT_LATTICE_H

#include "core/input/domain.h"

/** Looks for a lattice. Coordinates may be off it by what float32 rounds off and a hundredth of a
 *  cell, one in a thousand by anything. Fewer than 200 points have none.
 *
 *  Rounding to float32 itself is a lattice too, far from the origin: one that is found, and
 * reported, only where it matters.
 *
 *  @retval VOR_E_NOMEM 100 KB do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n) where there is one, else O(1), a few ms. The same lattice for any number of threads. */
VOR_NODISCARD vor_status vor_lattice_find(struct vor_lattice *out, const struct vor_domain *domain,
                                          const struct vor_run *run, struct vor_error *err);

/** Moves the points of the domain within their cells; its index is made anew. A surface has up
 *  to twice as many neighbours as vor_neighbors_choose finds: weighted, they count for less than
 * half.
 *
 *  @param[out] moved  how many points are elsewhere now
 *
 *  @retval VOR_E_NOMEM 12 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain is to be freed
 *
 *  O(n k), 10 us a point. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lattice_smooth(struct vor_domain *domain, size_t *moved,
                                            const struct vor_lattice *lattice,
                                            const struct vor_run *run, struct vor_error *err);

#endif
