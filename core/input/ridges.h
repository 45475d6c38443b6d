/** Lines along the sharp edges of an input (input/edges.h): from foot to foot of the points that
 * lie on them.
 *
 *  A line begins at a foot that no line went along yet, and goes half a spacing at a time the way
 *  that the edge runs there, back onto the mean of the feet around. It ends where no foot lies
 *  ahead whose edge runs that way, at a corner or where the edge fades out, or where it comes back
 *  to its beginning, or to another of its places. */
#ifndef VOR_INPUT_RIDGES_H
#define VOR_INPUT_RIDGES_H

#include "core/input/edges.h"

/** Spacings of the input between places of a line that follows an edge or a border. */
#define VOR_RIDGES_STEP 0.5

/** A line: places from -> to, one after another. */
struct vor_ridge {
    size_t first, count; /**< its places: xyz[3 first] on */
    int closed;          /**< the last place is followed by the first */
    double spacing;      /**< of the input where it begins */
};

struct vor_ridges {
    struct vor_memory *memory;
    size_t count;            /**< lines: in the order of the points that they began at */
    struct vor_ridge *ridge; /**< count */
    double *xyz;             /**< places x 3, normalised */
    size_t places;
};

/** Follows the edges of a domain.
 *
 *  @param[out] out  free with vor_ridges_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 88 bytes a flagged point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_poll answers, asked along each line
 *
 *  O(m log m) in the flagged points, one thread. The same lines for any number of threads. */
VOR_NODISCARD vor_status vor_ridges_follow(struct vor_ridges *out, const struct vor_domain *domain,
                                           const struct vor_edges *edges, const struct vor_run *run,
                                           struct vor_error *err);

/** ridges may be all zero. */
void vor_ridges_free(struct vor_ridges *ridges);

#endif
