/** Evening out (the stage `polish` of a run): short-range repulsion between neighbours on the local
 *  quadrics, after a method has spread the points. Nearest-neighbour distances become far more even
 *  than in a centroidal Voronoi tessellation.
 *
 *  Source: none of the papers. Each step moves a point along the tangent plane by the sum of
 *  (h/d)^(2S) over its neighbours at distance d, with h the mean spacing, adds a share of its last
 *  step, and projects it onto the quadric; a step is at most 5 % of h. S rises from 4 to 14, and
 *  steps get shorter: soft repulsion by long steps grows regions of one orientation, hard repulsion
 *  by short ones evens the distances out. Where the input has sheets, or nothing holds points at
 * its border, all steps are short. Where the process joins the points by triangles, and the input
 * has no sheets and there is no metric, S rises to 8, and steps stay long, so that more points have
 * six neighbours; distances are less even. Repulsion alone opens gaps where regions meet. So every
 * few steps the farthest corner of each point's Voronoi cell is found; where that is farther away
 * than in a lattice, the point is pulled towards it. With evenness=cover, points move towards the
 *  centroids of their cells in the second half of the steps, instead of away from each other, and
 *  smaller gaps pull; the last positions are kept. That is Lloyd's iteration, from a start with
 *  large regions of one orientation: fewer places are far from all points than after either alone
 *  (sphere of 200,000 random points to 5,072, farther than 0.64 spacings: 712 by spacing, 4 by
 *  cover; largest gap 0.73 and 0.65 spacings, eta 0.95 and 0.68 %, delta 0.016 and 0.041). Points
 * at the border are not pushed out, and a point more than VOR_OUTSIDE_EVENING spacings from the
 * input moves along it or towards it, not farther away. In the second half of the steps the
 * surfaces of an exact input keep its edges (vor_surface_refine); an input whose points were moved
 * off a lattice is not exact.
 *
 *  With a density (input/density.h) h and all other lengths are those of the spacing wanted at the
 *  place, and for the force of two points the larger of both; how even the points are is measured
 *  likewise (seeds/wanted.h).
 *
 *  With a metric (input/anisotropy.h) distances, steps and gaps are measured in it: forces still
 * act along the offset of two points, which is what evens them out in the metric.
 *
 *  Gaps (seeds/gaps.h) are looked for every third step, every twelfth step around a point with no
 *  gap near it, or every sixth where all steps are short, and for triangles. In the last two
 *  fifths of the steps those with a gap near look in each step, as pulls of a place where a gap no
 *  longer is leave some as wide as they are; after them, what is still wide is narrowed once.
 *  Neither where all steps are short, nor for triangles, nor with evenness=cover. Away from the
 * border a surface is used again until its seed has moved half a spacing of the input, a tenth in
 * the last 16 steps. In two steps of three it also is, so far, where the input surrounds the seed
 * but no point of it is near, as happens all over a cloud of white noise. Not for triangles, whose
 * shortest edges it makes shorter (bunny to 500, 12 seeds: least over mean distance 0.45 / 0.39,
 * spread 0.05), and not where all steps are short (two sheets half a spacing apart, rms distance to
 * them 0.0012 / 0.0018 spacings). */
#ifndef VOR_SEEDS_REPEL_H
#define VOR_SEEDS_REPEL_H

#include "core/base/linalg.h"
#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

enum {
    /** The exponent S at the first step. At 2 / 4 / 8: six on igea 0.819 / 0.812 / 0.793, delta the
     *  same (repel.c says on what figures are). */
    VOR_REPEL_SOFT = 4,
    /** The same at the last one, for even distances. At 7 / 14 / 28: igea 0.0235 / 0.0176 / 0.0129,
     *  bunny 0.0244 / 0.0185 / 0.0138; six 0.825 / 0.812 / 0.765 and 0.810 / 0.783 / 0.734. */
    VOR_REPEL_HARD = 14
};

/** Step over the sum of forces, times 2 S, at the last step. Figures are of a sphere of 200,000
 *  random points to 5,072 and of fandisk, 110,000 random points to 5,000: delta at 0.1 / 0.2 / 0.3
 * is 0.0172 / 0.0164 / 0.0165 and 0.0228 / 0.0216 / 0.0213, the largest gap 0.713 / 0.711 / 0.720
 * and 1.19 / 1.22 / 1.27 spacings. The first step has 1; at 0.6 / 1 / 1.4: six 0.905 / 0.912 /
 * 0.912 and 0.859 / 0.884 / 0.874, gap 0.705 / 0.711 / 0.724 and 1.20 / 1.22 / 1.21. */
#define VOR_REPEL_GAIN 0.2
/** Share of the last step that is added to the next: at the first step and at the last one. At 0.8
 * / 0.9 / 0.95 at the first: six 0.909 / 0.912 / 0.910 and 0.874 / 0.884 / 0.894, gap 0.702 / 0.711
 * / 0.729 of the sphere. At 0.7 / 0.8 / 0.9 at the last: delta 0.0170 / 0.0164 / 0.0160 and 0.0242
 * / 0.0216 / 0.0198, gap 0.697 / 0.711 / 0.853 of the sphere. The pull is 1 less this; at 0.75 / 1
 * / 1.5 of that: delta 0.0163 / 0.0164 / 0.0169 and 0.0201 / 0.0216 / 0.0243, gap 0.738 / 0.711 /
 * 0.701 of the sphere. At the last, all steps that a force causes add up to what it asks for. */
#define VOR_REPEL_MOMENTUM_FIRST 0.9
#define VOR_REPEL_MOMENTUM_LAST (1 - VOR_REPEL_GAIN)

/** How points repel each other in a step. */
struct vor_repel_pace {
    unsigned power;  /**< S */
    double gain;     /**< step over the sum of forces, times 2 S */
    double momentum; /**< share of the last step that is added to the next */
    double pull;     /**< share of the excess of a gap that a point is pulled by */
};

/** The pace of step `done` of `steps`: S rises to `hard`; long steps let grains of one orientation
 *  grow, short ones even distances out. The pull keeps its share of all that moves a point. */
static inline struct vor_repel_pace vor_repel_pace_at(unsigned hard, unsigned done, unsigned steps)
{
    unsigned of = steps > 1 ? steps - 1 : 1;
    double part = (double)done / of;
    double momentum =
        VOR_REPEL_MOMENTUM_FIRST + (VOR_REPEL_MOMENTUM_LAST - VOR_REPEL_MOMENTUM_FIRST) * part;

    return (struct vor_repel_pace){VOR_REPEL_SOFT + (hard - VOR_REPEL_SOFT) * done / of,
                                   1 + (VOR_REPEL_GAIN - 1) * part, momentum, 1 - momentum};
}

/** Longest step, in spacings. At 0.025 / 0.05 / 0.1: autzen 0.117 / 0.103 / 0.094 (spread 6 %), its
 *  searches 171 / 198 / 233 thousand, largest distance on fandisk 4.4e-3 / 4.5e-3 / 5.9e-3. */
#define VOR_REPEL_STEP_MAX 0.05
/** Largest (h/d)^(2S) of a pair where triangles follow, and in lop/even. Steps are bounded, so 25
 *  and 100 move no figure. */
#define VOR_REPEL_FORCE_MAX 50.0

/** The same; without triangles that of half a spacing. From where it is reached, far points repel
 *  more than near ones, and crowded points pair: 50 is reached at 0.87 spacings. At 0.1 / 0.5 / 0.7
 *  / 0.87, scan of a building to 10,000, which is crowded where it is sparse: 0.113 / 0.112 / 0.136
 *  / 0.141. With triangles, which are made by the processes that take soup, 3 of 20 tetrahedra are
 *  not closed at 0.5; at 50 all are. */
static inline float vor_repel_most(const struct vor_spec *spec, unsigned power)
{
    return vor_process_takes(spec->process, VOR_PARAM_SOUP) ? (float)VOR_REPEL_FORCE_MAX
                                                            : (float)vor_power(4, power);
}

/** What follows a method: attaches the seeds to the input, evens them out, and attaches them to the
 *  whole of it (seeds/attach.h). seeds->xyz ends as the most even positions of all, those before
 *  the first step included, with wide gaps narrowed unless delta or eta has ended the steps; with
 *  evenness=cover as the last ones, if that half is reached. The steps end at the number that the
 * request allows, at its delta or seconds, or when the watch says so. None is made where the
 * request allows none or the caller stopped the run.
 *
 *  @param[in,out] told  what the method did so far; this stage is added, stopped may change
 *  @param[in]     spec  read: polish, evenness, delta, seconds
 *  @param[in]     run   may be stopped
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM  68 n bytes do not fit
 *
 *  O(steps n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_polish(struct vor_seeds *seeds, struct vor_outcome *told,
                                    const struct vor_spec *spec, const struct vor_run *run,
                                    struct vor_error *err);

#endif
