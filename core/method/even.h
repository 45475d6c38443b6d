/** How even a candidate is, from the lists of the iterate it came from. */
#ifndef VOR_METHOD_EVEN_H
#define VOR_METHOD_EVEN_H

#include "core/metrics/uniformity.h"
#include "core/method/seeds.h"

/** Uniformity of the positions xyz (seeds->n x 3), to which every seed came by a move of at most
 *  max_move from its position at the last index. Exact: the nearest neighbour is looked for in the
 *  seed's list, and wherever a seed from beyond the list could have come nearer, by a wider search.
 *
 *  @param[out] nearest  distance of every seed to its nearest neighbour, n floats
 *
 *  Lengths in normalised units. Returns other than VOR_CONTINUE when the watch ended it. */
VOR_NODISCARD enum vor_answer vor_even_measure(struct vor_uniformity *out, float *nearest,
                                               const struct vor_seeds *seeds, const float *xyz,
                                               double max_move);

#endif
