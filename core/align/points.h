/** Points of a cloud with the planes of their neighbours: the finest that is known of its surface.
 *
 *  Samples are means over cubes, which says where a pose may lie. Points say how exactly the clouds
 *  lie on each other against what their own noise leaves, and where one cloud hovers over the
 * inside of what the other one has seen of a surface, which no right pose does. */
#ifndef VOR_ALIGN_POINTS_H
#define VOR_ALIGN_POINTS_H

#include "core/align/samples.h"

/** The plane through the neighbours of a point, which is not one of them. */
struct vor_align_plane {
    float middle[3], normal[3];
    float reach; /**< distance of the farthest neighbour; 0: there is no plane */
    float rough; /**< rms distance of the neighbours */
    float off;   /**< distance of the point */
    int border;  /**< the neighbours leave a side free */
};

/** At most some ten thousand points, in the coordinates of the cloud's samples. Owns its arrays. */
struct vor_align_points {
    struct vor_memory *memory;
    size_t n;
    float *xyz; /**< n x 3 */
    struct vor_align_plane *plane;
    struct vor_knn *knn;
    double reach, rough; /**< medians */
};

/** @param[out] out  free with vor_align_points_free, also on failure
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED. O(n); on the run's pool. */
VOR_NODISCARD vor_status vor_align_points_make(struct vor_align_points *out,
                                               const struct vor_cloud *cloud,
                                               const struct vor_align_samples *samples,
                                               const struct vor_run *run, struct vor_error *err);
void vor_align_points_free(struct vor_align_points *points);

#endif
