/** Points that move along their surfaces, VOR_GLIDE_LANES at a time: what each waits for is its own
 *  last result, so that four take little longer than one. */
#ifndef VOR_GEOM_GLIDE_H
#define VOR_GEOM_GLIDE_H

#include "core/base/linalg.h"
#include "core/geom/surface.h"

#include <string.h>

enum { VOR_GLIDE_LANES = 4 };

struct vor_glide {
    unsigned count;                                   /**< at most VOR_GLIDE_LANES */
    size_t i[VOR_GLIDE_LANES];                        /**< the caller's */
    const struct vor_surface *along[VOR_GLIDE_LANES]; /**< kind is not NONE */
    double most[VOR_GLIDE_LANES];                     /**< a point moves so far at most */
    double v[VOR_GLIDE_LANES][3];                     /**< where each is to move */
    double x[VOR_GLIDE_LANES][3];                     /**< where each is, in world coordinates */
};

/** Adds point i, at x, which is to move by v along a surface, by `most` at most. Returns whether
 *  there is no room for another one. */
static inline int vor_glide_add(struct vor_glide *glide, const struct vor_surface *along, size_t i,
                                double most, const float x[3], const double v[3])
{
    unsigned j = glide->count++;

    glide->i[j] = i;
    glide->along[j] = along;
    glide->most[j] = most;
    vor_to_doubles(glide->x[j], x);
    memcpy(glide->v[j], v, sizeof glide->v[j]);
    return glide->count == VOR_GLIDE_LANES;
}

/** Moves each x by the part of its v along its surface there, by `most` at most, and onto the
 *  surface: v as vor_surface_normal and vor_surface_put would. O(1). */
void vor_glide_go(struct vor_glide *glide);

#endif
