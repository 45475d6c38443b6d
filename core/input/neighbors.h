/** Chooses the number of neighbours per region, the input points that a local surface is fitted to:
 *  few where the input is exact, so that no detail is rounded off, more where it is noisy or on a
 *  lattice.
 *
 *  Source: none of the papers; Xiao 2024 Sec. V-D leaves the number to the caller, and too few on a
 *  noisy cloud is worse than no denoising. At places spread over the input a surface is fitted to
 *  20, 30, 45, 70, 100 and 150 neighbours. A neighbourhood that is nearly as thick as it is wide
 *  shows no surface. Where more than one place in thirty has such a one, more neighbours are taken
 *  until that is no longer so or more of them help little; but not where the residual grows faster
 *  than that of points that fill a ball, as with detail or another sheet, nor where the nearest ten
 *  lie on a surface: what is thick there is a thin part. From there the number goes up while that
 *  lowers the error: 3 s^2 / k, what noise of variance s^2 leaves in a fit to k points, plus the
 *  growth of the residual, which is detail that is lost.
 *
 *  That is the usual number. Each place then estimates the same from itself and the 31 places
 *  nearest to it, and takes another number where that gains enough: fewer if neighbourhoods are
 *  clearly thin and at most a third of the error is left, more if at most seven tenths are left.
 *  Few places estimate the noise worse than all places together, and too few neighbours do more
 *  harm than too many.
 *
 *  Measured, rms distance to the true surface with one number for all and with one per region: igea
 *  with noise on one half 1.16e-3 and 0.99e-3, with noise that grows across it 1.20e-3 and 0.97e-3;
 *  bunny with noise on one half 0.96e-3 and 0.84e-3; where noise is the same everywhere, 2 % more
 *  to 3 % less. Most clouds without noise get one number, 20. Also tried: regions that decide by
 *  themselves alone, which gains another 5 % on such halves and loses 10 % where noise is the same
 *  everywhere; pools of 16 and 64 places; a number for each lattice point's smoothing (no gain). */
#ifndef VOR_INPUT_NEIGHBORS_H
#define VOR_INPUT_NEIGHBORS_H

#include "core/input/domain.h"

/** The numbers that are tried, each about half as large again as the one before; the last is the
 *  paper's for noise (Xiao 2024, Fig. 13). */
enum { VOR_LADDER_LAST = 150 };
#define VOR_LADDER                                                                                 \
    {                                                                                              \
        VOR_NEIGHBORS_FEWEST, 30, 45, 70, 100, VOR_LADDER_LAST                                     \
    }
enum { VOR_LADDER_STEPS = sizeof((unsigned[])VOR_LADDER) / sizeof(unsigned) };

enum {
    /** Neighbours that tell a thin part from a noisy one: noise makes them thick too. */
    VOR_NEIGHBORS_EXACT = 10,
    /** Times the number of neighbours chosen that a fit takes which weights them by (1 - d^2)^3:
     * they count for less than half. At 1 / 2 / 4, figures of input/mls.c 0.409, 0.418, 0.022 /
     * 0.344, 0.342, 0.031 / 0.373, 0.383, 0.042, for half and twice the time; of
     * input/lattice.c 24.2 / 23.7 / 24.9 and 14.2 / 13.5 / 13.8. */
    VOR_NEIGHBORS_WEIGHTED = 2,
    /** A step is tried if a domain has so many times its points: a fit to more than an eighth of
     *  the input shows no detail. At 4 / 8 / 16 no figure of neighbors.c moves. */
    VOR_NEIGHBORS_ROOM = 8,
    /** Places that decide for one of them. At 16 / 32 / 64: noise 15.2 / 15.5 / 15.3, half 13.4
     *  / 13.5 / 13.5 (neighbors.c). */
    VOR_NEIGHBORS_POOL = 32
};

/** A place and those nearest to it, VOR_NEIGHBORS_POOL in all, the nearest first; of two as near,
 * the first.
 *
 *  @param[in] xyz  VOR_NEIGHBORS_PLACES x 3 */
void vor_neighbors_pool(uint16_t pool[VOR_NEIGHBORS_POOL], const float *xyz, size_t place);

/** Chooses 20 to 150 neighbours per region. The domain is indexed; known.sheets says whether fits
 *  look for layers.
 *
 *  @param[out] out  set on success
 *
 *  @retval VOR_E_NOMEM 110 KB do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(log n), about 20 ms, on the run's pool. The same numbers for any number of threads. */
VOR_NODISCARD vor_status vor_neighbors_choose(struct vor_neighbors *out,
                                              const struct vor_domain *domain,
                                              const struct vor_run *run, struct vor_error *err);

/** The number at x (normalised): that of the nearest place. 0.1 us, nothing where all are the same.
 */
unsigned vor_neighbors_at(const struct vor_neighbors *neighbors, const float x[3]);

/** Lets fits to a share of a domain's points reach as far as those to all of them: takes as many
 *  fewer, no less than VOR_NEIGHBORS_FEWEST. */
void vor_neighbors_fewer(struct vor_neighbors *neighbors, double share);

#endif
