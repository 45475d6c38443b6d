/** The spacing that a request with a density wants, at points of the surface and between them.
 *
 *  Values are relative: the spacing wanted at a place over that of as many points spread evenly, so
 *  they have no unit. The density that they stand for is their power -4 (core/input/density.h makes
 *  them). Around a place the field is taken for linear. */
#ifndef VOR_INPUT_FIELD_H
#define VOR_INPUT_FIELD_H

#include "core/base/linalg.h"
#include "core/knn/knn.h"

/** Points that a field around a place is computed of, this one and a metric: four times the
 *  coefficients of what is linear along a surface. */
enum { VOR_FIELD_AROUND = 12 };
/** Over the squared distance of the farthest of them: where weights end. */
#define VOR_FIELD_ENDS2 1.5
/** Of the distance of the farthest: how far from the place the values are used. Half of it is about
 *  one spacing of the field. */
#define VOR_FIELD_REACH 0.5

/** The field; owns everything. All zero: no density was asked for. Lengths are normalised. */
struct vor_field {
    struct vor_memory *memory;
    size_t n;
    float *xyz;          /**< n x 3, in Morton order */
    float *value;        /**< n, > 0 */
    struct vor_knn *knn; /**< over xyz */
    double even;         /**< spacing of as many points spread evenly: the unit of the values */
    double least, most;  /**< of the values */
    double span;         /**< 95th over 5th percentile of the density, over the n points */
};

/** The field around a place. */
struct vor_field_near {
    float at[3]; /**< the place */
    float value;
    float slope[3]; /**< change of the value over a length */
    float reach;    /**< a distance from the place within which it may be used */
};

/** True when a density was asked for. */
static inline int vor_field_is(const struct vor_field *field)
{
    return field->value != NULL;
}

/** field may be all zero. */
void vor_field_free(struct vor_field *field);

/** Computes the field around x from the nearest twelve of its points. O(log n). Cannot fail.
 *  Thread-safe. Depends on nothing but its arguments. */
void vor_field_find(struct vor_field_near *out, const struct vor_field *field, const float x[3]);

/** Value at x, which is near near->at: at least half of the value there, and at most twice. */
static inline double vor_field_value(const struct vor_field_near *near, const float x[3])
{
    double value = (double)near->value, sum = value;

    for (int c = 0; c < 3; c++)
        sum += (double)near->slope[c] * ((double)x[c] - (double)near->at[c]);
    return fmin(fmax(sum, value / 2), 2 * value);
}

#endif
