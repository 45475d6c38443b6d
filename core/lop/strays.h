/** Samples far from all others: outliers of the input that the projection drew nowhere.
 *
 *  Source: none of the papers. Insertion would put others between such a sample and its neighbours.
 */
#ifndef VOR_LOP_STRAYS_H
#define VOR_LOP_STRAYS_H

#include "core/lop/samples.h"

/** Neighbour whose distance tells a stray, once its square is twice that of the median: at a border
 * too an even spread has four as near as anywhere. fandisk, 163,000 points with noise of up to 2 %
 * of the diagonal and outliers (tests/by_hand/bench/ear_clouds.py), to 40,000: at 1.42 / 1.6 times
 * the median / all stay, 0 / 1 / 29 points farther off than the noise. */
enum { VOR_LOP_STRAY_OF = 4 };

/** Drops the strays; the others keep their order. At least half of the samples stay.
 *
 *  @param[in,out] samples  one or more
 *
 *  @retval VOR_E_NOMEM  8 bytes a sample, and an index of them, do not fit; *samples is as it was
 *
 *  O(n log n), on the calling thread. */
VOR_NODISCARD vor_status vor_lop_strays_drop(struct vor_lop_samples *samples,
                                             struct vor_error *err);

#endif
