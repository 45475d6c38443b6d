/** Says why a cloud has no surface where a few points far from all others are the cause. */
#ifndef VOR_INPUT_REMOTE_H
#define VOR_INPUT_REMOTE_H

#include "core/cloud/cloud.h"

/** At most one point in so many is remote, an outlier or on an island: of an input of which more
 *  would be, nothing is taken. At 2 and 8 nothing changes on 20 scans and made clouds. */
enum { VOR_REMOTE_FEW = 4 };

/** Points far from all others: those farther than `near` from the middle of most. */
struct vor_remote {
    double middle[3], near; /**< in the cloud's unit, relative as its positions are */
    size_t count;           /**< how many; 0 where they would be more than one in four */
    size_t farthest;        /**< of all points, and how far it is */
    double far;
};

/** Finds those that are so far from the others of a cloud that float32 does not tell these apart
 *  beside them. O(n). Cannot fail. */
void vor_remote_find(struct vor_remote *out, const struct vor_cloud *cloud);

/** Whether point i is one of them. */
int vor_remote_is(const struct vor_remote *remote, const struct vor_cloud *cloud, size_t i);

/** Adds to the sentence in err which point of a cloud is how far from the others, if one is remote;
 *  else leaves err as it is. Positions are relative to an origin, but to one for all of them. err
 * may be NULL. O(n). */
void vor_remote_tell(const struct vor_cloud *cloud, struct vor_error *err);

#endif
