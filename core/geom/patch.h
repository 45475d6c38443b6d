/** The disc that stands for the surface around a seed: a hexagon of radius 1, cut into triangles.
 *
 *  Source: Xiao et al. 2024, Sec. III-B step 3. Departure: the paper meshes polar rings by a
 *  Delaunay triangulation and leaves their number open; here the mesh is fixed, ring i has 6 i
 *  vertices. How many rings are enough is measured in seeds/seeds.c. */
#ifndef VOR_GEOM_PATCH_H
#define VOR_GEOM_PATCH_H

#define VOR_PATCH_SIDES 6

/** Most rings that a disc may have; runs use at most 2, tests of convergence more. */
#define VOR_PATCH_RINGS_MAX 4
#define VOR_PATCH_VERTICES_MAX (1 + 3 * VOR_PATCH_RINGS_MAX * (VOR_PATCH_RINGS_MAX + 1))
#define VOR_PATCH_TRIANGLES_MAX (6 * VOR_PATCH_RINGS_MAX * VOR_PATCH_RINGS_MAX)

/** sin(pi/3): the height of a triangle of the hexagon over its side. An even lattice of spacing s
 *  has one point for each VOR_HEXAGON_HEIGHT s^2. */
#define VOR_HEXAGON_HEIGHT 0.86602540378443865

/** Corners of the hexagon of radius 1, counter-clockwise. They stand in the header so that the
 *  compiler folds them into the loop of begin_flat (cell.c). */
static const double vor_patch_corner[VOR_PATCH_SIDES][2] = {
    {1, 0},  {0.5, VOR_HEXAGON_HEIGHT},   {-0.5, VOR_HEXAGON_HEIGHT},
    {-1, 0}, {-0.5, -VOR_HEXAGON_HEIGHT}, {0.5, -VOR_HEXAGON_HEIGHT}};

/** Vertices, in units of the radius, and triangles as indices of vertices. */
struct vor_disc {
    unsigned vertex_count, triangle_count;
    double vertex[VOR_PATCH_VERTICES_MAX][2];
    unsigned char triangle[VOR_PATCH_TRIANGLES_MAX][3];
};

/** Makes a disc of 6 rings^2 triangles; rings is 0 .. VOR_PATCH_RINGS_MAX. Without triangles it
 *  stands for the tangent plane (vor_cell_begin). Cannot fail. */
void vor_disc_init(struct vor_disc *disc, unsigned rings);

#endif
