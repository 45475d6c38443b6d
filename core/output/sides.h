/** Which side the normals of a result point to. */
#ifndef VOR_OUTPUT_SIDES_H
#define VOR_OUTPUT_SIDES_H

#include "core/input/orient.h"
#include "core/report.h"

/** A result, and what it was made of; all borrowed. */
struct vor_sides_of {
    const struct vor_cloud *in;      /**< the cloud that the domain was made of */
    const struct vor_domain *domain; /**< the whole of it; must outlive the sides */
    const struct vor_spec *spec;     /**< read: normals, inputNormals */
    size_t points;                   /**< of the result */
    double area;                     /**< as vor_orient_how.area */
};

/** What says the side: the nearest carried normal, or the orientation of the input. All zero:
 *  nothing was asked for. */
struct vor_sides {
    const struct vor_domain *domain;
    const struct vor_attribute *carried; /**< the input's normals; NULL if it has none, or the
                                              request ignores them */
    int carried_decide;                  /**< they say the side of fitted normals */
    struct vor_orientation orientation;  /**< else this does */
    int carried_stay; /**< those with a direction take the place of fitted ones */
};

/** True when the request asks for normals with a side: normals is fit or oriented. */
int vor_sides_asked(const struct vor_spec *spec);

/** Finds out what the request needs: with normals=fit and carried normals that all have a direction
 *  nothing more than those; else, and with normals=oriented, orients the domain.
 *
 *  @param[out] out    free with vor_sides_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  As vor_orient. */
VOR_NODISCARD vor_status vor_sides_find(struct vor_sides *out, const struct vor_sides_of *of,
                                        const struct vor_run *run, struct vor_error *err);

/** Tells how the normals face, and warns of parts with one side only. */
void vor_sides_report(struct vor_report *report, const struct vor_sides *sides);

/** sides may be all zero. */
void vor_sides_free(struct vor_sides *sides, struct vor_memory *memory);

/** The normal of a point of the result: the fitted one on its right side, unless those of the input
 *  around it lead elsewhere; with normals=oriented the
 *  carried one of its input point, if that has a direction, on the same side as the fitted one.
 *
 *  @param[in] x       the point, normalised
 *  @param[in] source  the input point nearest to it
 *  @param[in] fitted  unit length
 *
 *  O(log n). Cannot fail. Thread-safe. */
void vor_sides_normal(float out[3], const struct vor_sides *sides, const float x[3],
                      uint32_t source, const double fitted[3]);

#endif
