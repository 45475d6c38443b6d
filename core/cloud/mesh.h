/** Most triangles of a polygon: with two corners more, PLY writes their number in one byte. */
#define VOR_MESH_RUN_MOST 253

/** Triangles over the points of a cloud. */
#ifndef VOR_CLOUD_MESH_H
#define VOR_CLOUD_MESH_H

#include "core/base/memory.h"

#include <stddef.h>
#include <stdint.h>

/** Triangles over the points of a cloud, oriented counter-clockwise seen from outside. */
struct vor_mesh {
    struct vor_memory *memory; /**< borrowed; triangle is allocated from it */
    uint32_t *triangle;        /**< count x 3, indices of points */
    size_t count;
    int polygons; /**< triangles that follow each other and share the first point and an edge at it
                       are one polygon; formats without polygons keep the triangles */
};

/** How many triangles from t on are one face: 1 unless the mesh has polygons. t is below count. */
size_t vor_mesh_run(const struct vor_mesh *mesh, size_t t);

/** How many faces it has. O(count). */
size_t vor_mesh_faces(const struct vor_mesh *mesh);

/** Makes a mesh without triangles that allocates from memory. */
void vor_mesh_init(struct vor_mesh *out, struct vor_memory *memory);

/** Frees the triangles and leaves the mesh as vor_mesh_init does. mesh may be all zero. */
void vor_mesh_free(struct vor_mesh *mesh);

#endif
