/** Finds where one cloud may lie on another, without a first guess.
 *
 *  Pairs of samples of the cloud are laid on pairs of the reference that are as far apart and whose
 *  oriented normals lie alike, which gives a pose each; the few samples of the cloud say how much
 *  of it then lies on the reference.
 *
 *  Source: Drost et al. 2010, "Model globally, match locally" (pairs of oriented points by distance
 *  and three angles). Departure: poses are not voted for but tried. Departure from Lv et al. 2022,
 *  Sec. 5, which turns clouds about their centroids by a grid of angles: with a part of one
 *  missing, the centroids do not meet. */
#ifndef VOR_ALIGN_MATCH_H
#define VOR_ALIGN_MATCH_H

#include "core/align/pose.h"
#include "core/align/samples.h"

/** The nearest of samples by place: cubes up to `reach` from them. Owns nearest. */
struct vor_align_grid {
    struct vor_memory *memory;
    const struct vor_align_samples *samples;
    double low[3], edge, reach;
    size_t wide[3];
    uint32_t *nearest; /**< UINT32_MAX where no sample is within reach */
};

/** @retval VOR_E_NOMEM. O(samples). */
VOR_NODISCARD vor_status vor_align_grid_make(struct vor_align_grid *out,
                                             const struct vor_align_samples *samples, double reach,
                                             struct vor_error *err);
void vor_align_grid_free(struct vor_align_grid *grid);

/** About the nearest sample to x; UINT32_MAX where none is within reach. O(1). */
static inline uint32_t vor_align_grid_at(const struct vor_align_grid *grid, const double x[3])
{
    size_t at = 0;

    for (int c = 0; c < 3; c++) {
        double cell = (x[c] - grid->low[c]) / grid->edge;

        if (!(cell >= 0 && cell < (double)grid->wide[c]))
            return UINT32_MAX;
        at = at * grid->wide[c] + (size_t)cell;
    }
    return grid->nearest[at];
}

/** A pose and how well it fits, 0 to 1. flip: the normals of the cloud face the other way. */
struct vor_align_candidate {
    struct vor_pose pose;
    double score;
    int flip;
    uint32_t query; /**< number of the pair of the cloud that it came from */
};

enum { VOR_ALIGN_CANDIDATES = 48 };

/** Cosine of normals that count as alike. */
#define VOR_ALIGN_ALIKE 0.6

/** Finds up to VOR_ALIGN_CANDIDATES poses, the best first, no two alike.
 *
 *  @param[in] both  the normals of the cloud may face the other way
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  On the run's pool; work is bounded. The same poses for any number of threads. */
VOR_NODISCARD vor_status vor_align_match(struct vor_align_candidate out[VOR_ALIGN_CANDIDATES],
                                         unsigned *count, const struct vor_align_samples *cloud,
                                         const struct vor_align_grid *reference, int both,
                                         const struct vor_run *run, struct vor_error *err);

#endif
