/** The faces of a PLY file as triangles. */
#ifndef VOR_PROTO_PLY_FACES_H
#define VOR_PROTO_PLY_FACES_H

#include "core/base/memory.h"
#include "proto/ply/ply_body.h"

/** What is known while faces are read. */
struct vor_ply_faces {
    struct vor_memory *memory; /**< borrowed */
    uint64_t vertices;         /**< of the file; an index is below */
    size_t most;               /**< triangles that there may be */
    size_t count, capacity;
    uint32_t *triangles; /**< count x 3 indices, from memory; the caller frees them */
    int tells_apart;     /**< make faces such that vor_mesh_run finds them, and set polygons */
    int polygons;        /**< a face has more than three corners */
    size_t first;        /**< triangle of the face that is being read */
    int is_strip;        /**< the element that is being read holds strips, else polygons */
    uint64_t corners;    /**< since the polygon or the strip began */
    uint32_t corner[2];  /**< of a polygon the first and the last one, of a strip the last two */
};

/** The number of the list of indices among the properties of an element that holds faces: of `face`
 *  vertex_indices or vertex_index, of `tristrips` the same. -1 for other elements. */
int vor_ply_face_list(const struct vor_ply_element *element);

/** Adds the triangles of an element that vor_ply_face_list finds a list in, and moves past it.
 *
 *  A polygon becomes a fan around its first corner, or around the second if tells_apart says so and
 *  it would continue the fan before; one of fewer than three corners, none. In a
 *  strip every index from the third one on makes a triangle with the two before it, turned so that
 *  all face one way, and -1 begins anew.
 *
 *  @retval VOR_E_FORMAT the element cannot be read; its indices are no integers; or one is out of
 *                       range, with byte_offset
 *  @retval VOR_E_LIMIT  more triangles, or rows, than faces->most
 *  @retval VOR_E_NOMEM
 *
 *  Cost: one pass; memory for the rows that the element declares, and no more than twice that for
 *  the triangles read so far. */
VOR_NODISCARD vor_status vor_ply_faces_read(struct vor_ply_faces *faces, struct vor_ply_body *body,
                                            const struct vor_ply_element *element,
                                            struct vor_error *err);

#endif
