/** Finds the lattice that coordinates were rounded to (voxels, octree cells, a codec's
 *  quantisation), and moves the points within their cells onto a smooth surface.
 *
 *  Source: none of the papers; Xiao 2024 Sec. V-C resamples octree-decoded clouds as they are.
 *
 *  Finding: along each axis the gaps between a sample's different values are multiples of the cell.
 *  Candidates are a few quantiles of the gaps. Each is followed from one value over the whole axis
 *  and fitted again whenever the distance has doubled. The largest one that nearly all of the
 *  sample fits is checked against all points.
 *
 *  Smoothing: where cells are as large as the spacing, the rounding is most of a point's error.
 *  Each point moves to its foot on a quadric fitted to its neighbours, weighted by distance, but
 *  stays in its own cell, the box of that size around its old position. The variance that cells add
 *  to a plane is known. Where neighbours are farther off the quadric than that, it misses a detail,
 *  and half as many neighbours are tried; where no number fits, at an edge, the point stays.
 *
 *  Measured, rms distance to the true surface over the diagonal, without and with smoothing: igea
 *  in an octree of 6, 7 and 8 bits 1.24e-3, 6.7e-4, 4.4e-4 and 1.16e-3, 6.3e-4, 4.1e-4; a cow at 7
 *  bits 2.2e-3 and 1.4e-3. What is left is closer to exact, so vor_neighbors_choose takes fewer
 *  neighbours. Also tried, no better: wider kernels, more rounds, quartics, less weight for cells
 *  that the surface misses.
 *
 *  Not done: a decoder that puts points into the corners of cells instead of their middle shifts
 *  the cloud by half a cell, which the points do not show. */
#ifndef VOR_INPUT_LATTICE_H
#define VOR_INPUT_LATTICE_H

#include "core/input/domain.h"

/** Of a cell: in the end a value may be off its level by that much, and by rounding, which may be
 * as much, or it hides the cell. 0.002 and 0.1 change nothing; uniform values are within it once in
 *  fifty. */
#define VOR_ON_LEVEL 0.01

/** Looks for a lattice. Coordinates may be off it by the rounding of float32 and a hundredth of a
 *  cell, one in 200 by any distance. Fewer than 200 points have none.
 *
 *  Far from the origin float32 itself rounds to a lattice; it is reported only if it matters.
 *
 *  @retval VOR_E_NOMEM 100 KB do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n) if the sample is on a lattice, else O(1); a few ms. The same lattice for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_lattice_find(struct vor_lattice *out, const struct vor_domain *domain,
                                          const struct vor_run *run, struct vor_error *err);

/** Of the spacing: smaller cells leave a point where it is. What there is to gain is then little,
 * and the cloud's own detail is in the way. */
#define VOR_CELL_SMALL 0.1

enum { VOR_LATTICE_BLOCK = 256 /**< points of a region with a lattice of its own */ };

/** Lattices of regions: of consecutive points of a domain, or of the input where more have one. */
struct vor_regions {
    size_t many, n;    /**< points of a region; regions */
    int by_source;     /**< points are consecutive in the input */
    double (*cell)[3]; /**< of each; all zero where none is known or was looked for */
    size_t eligible;   /**< points in regions with a lattice */
    double widest[3];  /**< cells, of all that were found */
    double pitch[2];   /**< the narrowest and the widest cells, where these differ along each axis:
                            along the one where they differ least; else 0 */
};

/** The region of point i. */
static inline size_t vor_region_of(const struct vor_regions *regions,
                                   const struct vor_domain *domain, size_t i)
{
    return (regions->by_source ? domain->source[i] : i) / regions->many;
}

/** Looks for the lattices of regions, in pairs of which one begins at every `step`-th, for a domain
 *  that has none as a whole. One counts where it has cells along each axis, as a codec's has, these
 *  are not small, and the next region has the same: few points may be on one by chance. Where
 *  clouds of different lattices overlap, only regions in the order of the input have one, if the
 *  clouds follow each other there.
 *
 *  @param[out] out  zeroed; out->cell is to be freed, on failure too
 *
 *  @retval VOR_E_NOMEM 100 KB, and 4 bytes for each point of those that are looked at, do not
 *          fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  20 us a region that has none, 500 us in the order of the input. The same lattices for any number
 * of threads. */
VOR_NODISCARD vor_status vor_lattice_find_regions(struct vor_regions *out,
                                                  const struct vor_domain *domain, size_t step,
                                                  const struct vor_run *run, struct vor_error *err);

/** Sets pitch to that of vor_regions, from few regions. Fails as vor_lattice_find_regions. */
VOR_NODISCARD vor_status vor_lattice_survey(double pitch[2], const struct vor_domain *domain,
                                            const struct vor_run *run, struct vor_error *err);

/** Whether a lattice has cells along each axis, and for restoring: whether they are not small. */
int vor_lattice_is_full(const struct vor_lattice *lattice);
int vor_lattice_is_wide(const struct vor_lattice *lattice);

/** Moves the points of the domain within their cells and indexes them again.
 *
 *  @param[out] moved  how many points have a new position
 *
 *  @retval VOR_E_NOMEM 12 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain is to be freed
 *
 *  O(n k), 3 us of CPU a point, on the run's pool. The same points for any number of threads.
 */
VOR_NODISCARD vor_status vor_lattice_smooth(struct vor_domain *domain, size_t *moved,
                                            const struct vor_lattice *lattice,
                                            const struct vor_run *run, struct vor_error *err);

#endif
