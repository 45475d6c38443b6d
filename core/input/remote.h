/** Says why a cloud has no surface where a few points far from all others are the cause. */
#ifndef VOR_INPUT_REMOTE_H
#define VOR_INPUT_REMOTE_H

#include "core/cloud/cloud.h"

/** Adds to the sentence in err which point of a cloud is how far from the others, if it is so far
 *  that float32 does not tell these apart beside it; else leaves err as it is. Positions are
 *  relative to an origin, but to one for all of them. err may be NULL. O(n). */
void vor_remote_tell(const struct vor_cloud *cloud, struct vor_error *err);

#endif
