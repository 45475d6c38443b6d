/** The metric that a request asks for, at points of the surface and between them.
 *
 *  How to ask: vor_tensor_find gives the metric at a place as a tensor in space, and the normal
 *  there; vor_metric_restrict and vor_metric_even (geom/metric.h) turn it into the 2 x 2 one in any
 *  two axes of the tangent plane, vor_metric_long_side and vor_metric_aspect read off the direction
 *  of least curvature and by how much cells are longer along it. core/input/anisotropy.h makes the
 *  field, also for those who want its directions alone. */
#ifndef VOR_INPUT_TENSOR_H
#define VOR_INPUT_TENSOR_H

#include "core/geom/metric.h"
#include "core/geom/surface.h"
#include "core/knn/knn.h"

/** The field; owns everything. All zero: no metric was asked for. */
struct vor_tensors {
    struct vor_memory *memory;
    size_t n;
    float *xyz;          /**< n x 3, normalised, in Morton order */
    float *normal;       /**< n x 3: unit normals, of any sign */
    float *tensor;       /**< n x 6: raised from planes (vor_metric_raise) */
    struct vor_knn *knn; /**< over xyz */
    double most;         /**< largest aspect that was allowed */
    double median, high; /**< aspect: median and 95th percentile over the points */
};

/** The metric around a place. */
struct vor_tensor_near {
    float at[3];     /**< the place */
    float reach;     /**< a distance from it within which the rest may be used */
    float normal[3]; /**< of the surface, of any sign */
    float tensor[6]; /**< in space: xx xy xz yy yz zz; determinant 1, and 1 along the normal */
    float aspect;    /**< >= 1 */
};

/** True when a metric was asked for. */
static inline int vor_tensors_are(const struct vor_tensors *tensors)
{
    return tensors->tensor != NULL;
}

/** tensors may be all zero. */
void vor_tensors_free(struct vor_tensors *tensors);

/** Computes the metric around x: the mean of those of the nearest twelve points of the field, in
 *  the plane across the mean of their normals. O(log n). Cannot fail. Thread-safe. Depends on
 *  nothing but its arguments. */
void vor_tensor_find(struct vor_tensor_near *out, const struct vor_tensors *tensors,
                     const float x[3]);

#endif
