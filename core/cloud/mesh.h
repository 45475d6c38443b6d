/** Triangles that join the points of a cloud. */
#ifndef VOR_CLOUD_MESH_H
#define VOR_CLOUD_MESH_H

#include "core/base/memory.h"

#include <stddef.h>
#include <stdint.h>

/** Triangles over the points of a cloud, oriented counter-clockwise seen from outside. */
struct vor_mesh {
    struct vor_memory *memory; /**< borrowed */
    uint32_t *triangle;        /**< count x 3, indices of points */
    size_t count;
};

/** Makes a mesh without triangles that allocates from memory. */
void vor_mesh_init(struct vor_mesh *out, struct vor_memory *memory);

/** Frees the triangles and leaves the mesh as vor_mesh_init does. mesh may be all zero. */
void vor_mesh_free(struct vor_mesh *mesh);

#endif
