/** Anderson acceleration of a fixed-point iteration over one long vector.
 *
 *  Source: Xiao et al. 2024, Sec. IV-C, Eq. 7 to 11; Walker and Ni 2011. The mixing weights
 *  minimise |sum alpha_j D_j|^2 with sum alpha_j = 1 over the last m + 1 residuals; they come from
 *  the matrix of the residuals' dot products, so that the long vectors are only read. The mix is of
 *  the iterates after their projection.
 *  Departure: a ridge of 1e-9 of the trace keeps the weights finite when residuals become parallel.
 */
#ifndef VOR_OPT_ANDERSON_H
#define VOR_OPT_ANDERSON_H

#include "core/base/run.h"

/** Largest window; the paper uses 4. */
#define VOR_ANDERSON_MAX 16

/** The last pairs (Y, G(Y)) and their weights. */
struct vor_anderson {
    struct vor_memory *memory;
    size_t length;                         /**< floats of one vector */
    unsigned window, depth, newest;        /**< m; pairs stored; slot of the last one */
    float *image[VOR_ANDERSON_MAX + 1];    /**< G(Y) */
    float *residual[VOR_ANDERSON_MAX + 1]; /**< G(Y) - Y */
    double gram[VOR_ANDERSON_MAX + 1][VOR_ANDERSON_MAX + 1];
    double weight[VOR_ANDERSON_MAX + 1]; /**< of image[0 .. depth - 1] in the mix */
    double *partial;                     /**< dot products by blocks, of one push */
};

/** Prepares for vectors of `length` floats and a window m = 1 .. VOR_ANDERSON_MAX.
 *
 *  @param[out] out  free with vor_anderson_free
 *
 *  @retval VOR_E_NOMEM 8 (m + 1) length bytes do not fit; nothing is left allocated */
VOR_NODISCARD vor_status vor_anderson_init(struct vor_anderson *out, size_t length, unsigned window,
                                           struct vor_memory *memory, struct vor_error *err);

/** Frees the vectors. */
void vor_anderson_free(struct vor_anderson *anderson);

/** Adds the pair (Y, G(Y)), which replaces the oldest when the window is full, and computes the
 *  weights of the pairs.
 *
 *  @param[in] y, g  length floats each; copied
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(m length), on the run's pool. Sums run over fixed blocks in order: the same bits for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_anderson_push(struct vor_anderson *anderson, const float *y,
                                           const float *g, const struct vor_run *run,
                                           struct vor_error *err);

#endif
