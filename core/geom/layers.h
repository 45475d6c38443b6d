/** Sheets that lie one above the other, told apart within a neighbourhood: points on several
 *  parallel quadrics with nothing in between.
 *
 *  Source: none of the papers fits to one sheet; Xiao 2024 Sec. III-B takes the nearest points
 *  whichever sheet they are on. Lv 2022 Sec. 3.2 and 4.1 reject neighbours across a thin sheet by
 *  geodesic distances.
 *
 *  Departure from Lv: by shape, not by distances. White noise on two sheets nearer than its spacing
 *  has edges of any graph across everywhere, and the satellites of the paper do not part them.
 *
 *  Heights over the tangent plane are parted in two, the quadric that both parts share is found by
 *  least squares, heights are taken over it and parted again, until nothing changes. What has come
 *  of it are layers where
 *  - what is empty between them is wide against what the points are off their own layer: noise
 *    leaves no such gap,
 *  - each lies over another one, not beside it as the terraces of a staircase do. */
#ifndef VOR_GEOM_LAYERS_H
#define VOR_GEOM_LAYERS_H

#include "core/geom/surface.h"

enum { VOR_LAYERS_MAX = 8 };

struct vor_layers {
    unsigned count;                      /**< 1 where no layers can be told apart */
    unsigned char of[VOR_NEIGHBORS_MAX]; /**< the layer of each point, from below */
    struct vor_surface frame;            /**< of what follows; lengths over its reach */
    double shape[5];                     /**< that the layers share: u, v, uu, uv, vv */
    double height[VOR_LAYERS_MAX];       /**< of each, ascending */
};

/** True where points are so far off the surface fitted to them, 0.08 of their spacing rms, that
 * they may lie on more than one. */
static inline int vor_layers_possible(const struct vor_surface *surface)
{
    return surface->off2 > 0.0064 * surface->spacing * surface->spacing;
}

/** Tells layers apart among k points (k x 3 floats), nearest first. A few tangent planes are tried,
 *  of all the points and of the nearest alone. O(k log k), and O(k^2) where there are layers.
 *  Depends on nothing but its arguments. */
void vor_layers_find(struct vor_layers *out, const float *near, unsigned k);

/** The layer nearest to x; 0 where there is one. */
unsigned vor_layers_nearest(const struct vor_layers *layers, const double x[3]);

#endif
