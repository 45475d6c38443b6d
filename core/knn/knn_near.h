/** Neighbours of a few queries that are near each other, in a tree of boxes. Behind knn.h only. */
#ifndef VOR_KNN_NEAR_H
#define VOR_KNN_NEAR_H

#include <stddef.h>
#include <stdint.h>

struct vor_boxes;

/** Most queries of one call of vor_knn_search_near. At 8 / 16 / 32: lists of 20 neighbours among
 *  20,000 points 0.70 / 0.66 / 0.72 us each. */
#define VOR_KNN_NEAR_MAX 16

/** Queries for the k nearest points. */
struct vor_knn_near {
    const float *queries; /**< count x 3 */
    size_t count;         /**< 1 .. VOR_KNN_NEAR_MAX */
    unsigned k;
    const float *within; /**< count: as for vor_boxes_search; NULL: not known */
    float guess; /**< how far, squared, the k-th may be, which costs time where it is wrong; set for
                      the next queries. 0: not known */
};

/** How far, squared, the k-th point of a query may be, if the last of `had` is so far in its
 *  vicinity. */
float vor_knn_near_guess(float far2, unsigned had, unsigned k);

/** vor_knn_search_near. */
void vor_boxes_search_near(const struct vor_boxes *boxes, struct vor_knn_near *near,
                           uint32_t *index, float *distance2);

#endif
