/** The disc that stands for the surface around a seed: a hexagon or octagon of radius 1, cut into
 *  triangles.
 *
 *  Source: Xiao et al. 2024, Sec. III-B step 3. Departure: the paper meshes polar rings by a
 *  Delaunay triangulation and leaves their number open; here the mesh is fixed, ring i of a
 *  hexagon has 6 i vertices. How many rings are enough is measured in seeds/seeds.c. The octagon is
 *  that of Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 * methods", Sec. 4.2. */
#ifndef VOR_GEOM_PATCH_H
#define VOR_GEOM_PATCH_H

#include <math.h>

/** Sides of a disc; and points around one of an even spread: the spacing of an input is told at its
 *  sixth neighbour, that of samples by the mean distance to six. */
#define VOR_PATCH_HEXAGON 6
#define VOR_PATCH_OCTAGON 8

/** Most rings that a hexagon may have; runs use 1, tests of convergence more. An octagon
 * may have one less, as its triangles must fit too. */
#define VOR_PATCH_RINGS_MAX 4
#define VOR_PATCH_VERTICES_MAX (1 + 3 * VOR_PATCH_RINGS_MAX * (VOR_PATCH_RINGS_MAX + 1))
#define VOR_PATCH_TRIANGLES_MAX (6 * VOR_PATCH_RINGS_MAX * VOR_PATCH_RINGS_MAX)

/** sin(pi/3): the height of a triangle of the hexagon over its side. An even lattice of spacing s
 *  has one point for each VOR_HEXAGON_HEIGHT s^2. */
#define VOR_HEXAGON_HEIGHT 0.86602540378443865

/** Points of such a lattice within one spacing of a place: pi / VOR_HEXAGON_HEIGHT. */
#define VOR_HEXAGON_WITHIN (M_PI / VOR_HEXAGON_HEIGHT)

/** Mean distance of a result's points to their nearest ones over the spacing of such a lattice:
 * that of sites. At 1 / 0.97, 1,500 points on a square: distance of sites over that mean
 * inside 1.06 / 1.03; on half an armadillo 1.045. */
#define VOR_HEXAGON_APART 0.97

/** Corners of the hexagon of radius 1, counter-clockwise. They stand in the header so that the
 *  compiler folds them into the loop of begin_flat (cell.c). */
static const double vor_patch_corner[VOR_PATCH_HEXAGON][2] = {
    {1, 0},  {0.5, VOR_HEXAGON_HEIGHT},   {-0.5, VOR_HEXAGON_HEIGHT},
    {-1, 0}, {-0.5, -VOR_HEXAGON_HEIGHT}, {0.5, -VOR_HEXAGON_HEIGHT}};

/** Corners of the octagon of radius 1, likewise. */
static const double vor_patch_octagon[VOR_PATCH_OCTAGON][2] = {
    {1, 0},  {M_SQRT1_2, M_SQRT1_2},   {0, 1},  {-M_SQRT1_2, M_SQRT1_2},
    {-1, 0}, {-M_SQRT1_2, -M_SQRT1_2}, {0, -1}, {M_SQRT1_2, -M_SQRT1_2}};

/** Vertices, in units of the radius, and triangles as indices of vertices. */
struct vor_disc {
    unsigned sides; /**< VOR_PATCH_HEXAGON or VOR_PATCH_OCTAGON */
    unsigned vertex_count, triangle_count;
    double vertex[VOR_PATCH_VERTICES_MAX][2];
    unsigned char triangle[VOR_PATCH_TRIANGLES_MAX][3];
};

/** Makes a disc of sides * rings^2 triangles; rings is 0 .. VOR_PATCH_RINGS_MAX, one less for an
 *  octagon. Without triangles it stands for the tangent plane (vor_cell_begin). Cannot fail. */
void vor_disc_init(struct vor_disc *disc, unsigned sides, unsigned rings);

#endif
