/** Anderson acceleration of a fixed-point iteration over one long vector.
 *
 *  Source: Xiao et al. 2024, Sec. IV-C, Eq. 7 to 11; Walker and Ni 2011. The mixing weights
 * minimise |sum alpha_j D_j|^2 with sum alpha_j = 1 over the last m + 1 residuals; they come from
 * the matrix of the residuals' dot products, so that the long vectors are only read. What is mixed
 * are the iterates after their projection. Departure: a ridge of 1e-9 of the trace keeps the
 * weights finite when residuals become parallel. */
#ifndef VOR_OPT_ANDERSON_H
#define VOR_OPT_ANDERSON_H

#include "core/base/run.h"

#define VOR_ANDERSON_MAX 16

struct vor_anderson {
    struct vor_memory *memory;
    size_t length;                         /**< floats of one vector */
    unsigned window, depth, newest;        /**< m; vectors held, slot of the last one */
    float *image[VOR_ANDERSON_MAX + 1];    /**< G(Y) */
    float *residual[VOR_ANDERSON_MAX + 1]; /**< G(Y) - Y */
    double gram[VOR_ANDERSON_MAX + 1][VOR_ANDERSON_MAX + 1];
    double weight[VOR_ANDERSON_MAX + 1]; /**< of image[0 .. depth - 1] in the mix */
    double *partial;                     /**< sums of blocks */
};

/** For vectors of `length` floats and window m = 1 .. VOR_ANDERSON_MAX.
 *
 *  @retval VOR_E_NOMEM 8 (m + 1) length bytes do not fit; nothing is left allocated */
VOR_NODISCARD vor_status vor_anderson_init(struct vor_anderson *out, size_t length, unsigned window,
                                           struct vor_memory *memory, struct vor_error *err);

void vor_anderson_free(struct vor_anderson *anderson);

/** Adds the pair (Y, G(Y)) and finds the weights of the vectors held. Parallel; sums run over fixed
 *  blocks in order.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for */
VOR_NODISCARD vor_status vor_anderson_push(struct vor_anderson *anderson, const float *y,
                                           const float *g, const struct vor_run *run,
                                           struct vor_error *err);

#endif
