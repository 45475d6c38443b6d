/** Separates sheets that lie one above the other within a neighbourhood: points on several parallel
 *  quadrics with nothing in between.
 *
 *  Source: none of the papers fits to one sheet. Xiao 2024 Sec. III-B takes the nearest points,
 *  whichever sheet they are on; Lv 2022 Sec. 3.2 and 4.1 reject neighbours across a thin sheet by
 *  geodesic distances.
 *  Departure from Lv: by shape, not by distances. Where two sheets of white noise are nearer to
 *  each other than their spacing, any neighbour graph has edges from one to the other everywhere,
 *  and the paper's satellites do not separate them.
 *
 *  The algorithm splits the heights over the tangent plane in two, fits the quadric that both parts
 *  share by least squares, takes the heights over that quadric and splits them again, until nothing
 *  changes. The parts are layers if
 *  - the empty gap between them is wide compared with how far points lie off their own layer; noise
 *    leaves no such gap,
 *  - each part lies over another one, not beside it as the terraces of a staircase do.
 *
 *  Measured on 20,000 points of white noise on each of two squares or spheres, 5,000 out, default
 *  request, gaps of half an input spacing to three, and of one to two with noise of a tenth of the
 *  gap: at most one point lies off both sheets by more than a tenth of the gap, away from the
 *  border. Without layers, on flat sheets at gaps of one and two, every point did. Three sheets and
 *  more within one neighbourhood are mostly not separated. */
#ifndef VOR_GEOM_LAYERS_H
#define VOR_GEOM_LAYERS_H

#include "core/geom/surface.h"

/** Most layers that are separated. More gaps than that are noise: then there is one layer. */
enum { VOR_LAYERS_MAX = 8 };

/** Square of the share of the spacing that points may be off their surface (rms) and still lie on
 *  one layer: 0.08. It saves looking for layers in exact inputs. At 0.04 / 0.08 / 0.16: shell
 *  7.3e-4 / 7.4e-4 / 7.8e-4 (layers.c). */
#define VOR_LAYERS_POSSIBLE2 0.0064

struct vor_layers {
    unsigned count;                      /**< 1: no layers were found */
    unsigned char of[VOR_NEIGHBORS_MAX]; /**< the layer of each point, from below */
    struct vor_surface frame;            /**< frame of shape and height, whose lengths are over
                                              its reach */
    double shape[5];                     /**< coefficients of u, v, uu, uv, vv that layers share */
    double height[VOR_LAYERS_MAX];       /**< constant term of each layer, ascending */
};

/** True when the points may lie on more than one layer: their rms distance from the surface that
 *  was fitted to them is more than 0.08 spacings. O(1). */
static inline int vor_layers_possible(const struct vor_surface *surface)
{
    return surface->off2 > VOR_LAYERS_POSSIBLE2 * surface->spacing * surface->spacing;
}

/** Looks for layers among points. Tries a few tangent planes: that of all points, then those of the
 *  nearest few.
 *
 *  @param[out] out   count is 1 and all of `of` 0 when no layers were found
 *  @param[in]  near  k x 3 floats, nearest first
 *  @param[in]  k     at most VOR_NEIGHBORS_MAX; fewer than 8 have no layers
 *
 *  Cannot fail. O(k^2). Depends on nothing but its arguments. */
void vor_layers_find(struct vor_layers *out, const float *near, unsigned k);

/** Looks for layers among points as vor_layers_find does, but starts from the shape of layers that
 *  were found nearby, and tries nothing else: a tenth of the cost where it finds none.
 *
 *  @param[in] like  has at least two layers
 *
 *  @return whether layers were found
 *
 *  Cannot fail. Costs as one tangent plane of vor_layers_find. Depends on nothing but its
 *  arguments. */
int vor_layers_find_like(struct vor_layers *out, const struct vor_layers *like, const float *near,
                         unsigned k);

/** Index of the layer nearest to x, in world coordinates; 0 where there is only one. O(1). */
unsigned vor_layers_nearest(const struct vor_layers *layers, const double x[3]);

#endif
