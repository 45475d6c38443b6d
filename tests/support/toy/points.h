/** Which points of a cloud count, and what is near: the parameters that the toy's processes share.
 */
#ifndef VOR_TOY_POINTS_H
#define VOR_TOY_POINTS_H

#include "core/cloud/cloud.h"
#include "core/spec.h"

#include <math.h>

/** A box around points; low > high where there is none. */
struct toy_box {
    double low[3], high[3];
};

#define TOY_NO_BOX                                                                                 \
    {                                                                                              \
        {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY},                         \
    }

void toy_box_add(struct toy_box *box, const double x[3]);

/** Finds the attribute that points must have to count; *out is NULL where all do.
 *
 *  @retval VOR_E_PARAM  the cloud has no such attribute */
VOR_NODISCARD vor_status toy_find_among(const struct vor_attribute **out,
                                        const struct vor_cloud *cloud, const struct vor_spec *spec,
                                        struct vor_error *err);

/** Whether any byte of the attribute's value is set; among may be NULL, then yes. */
int toy_counts(const struct vor_attribute *among, size_t i);

/** Whether lengths are taken along axis c, where points lie in the box. */
int toy_has_axis(const struct vor_spec *spec, const struct toy_box *box, unsigned c);

/** The distance that is near: the one given, else `usual`. */
double toy_nearby(const struct vor_spec *spec, double usual);

/** Whether that distance is near; NAN is not. */
int toy_is_near(const struct vor_spec *spec, double distance, double nearby);

#endif
