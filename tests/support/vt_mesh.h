/** Triangle meshes whose sharp edges are known, and what a detector of edges has found of them.
 *  Needs no test harness: the benchmark links it too. */
#ifndef VT_MESH_H
#define VT_MESH_H

#include <stddef.h>
#include <stdint.h>

/** Triangles; allocated with malloc. */
struct vt_mesh {
    size_t vertices, faces;
    double *xyz;    /**< vertices x 3 */
    uint32_t *face; /**< faces x 3 */
};

/** Reads a mesh as ../shared/data has them: binary little-endian PLY, float x y z, triangles.
 *  Returns 0, or -1 with *out all zero where the file is anything else. */
int vt_mesh_read(struct vt_mesh *out, const char *path);

void vt_mesh_free(struct vt_mesh *mesh);

double vt_mesh_area(const struct vt_mesh *mesh);

/** n points, even by area, white noise: n x 3. normal (n x 3, or NULL) receives those of their
 *  faces. */
void vt_mesh_sample(float *xyz, float *normal, const struct vt_mesh *mesh, uint64_t seed, size_t n);

/** Segments; allocated with malloc. */
struct vt_segments {
    size_t n;
    double *end; /**< n x 6 */
};

/** The edges between two faces whose normals differ by more than an angle. Returns 0, or -1 where
 *  memory does not suffice. */
int vt_mesh_sharp(struct vt_segments *out, const struct vt_mesh *mesh, double degrees);

void vt_segments_free(struct vt_segments *segments);

double vt_segments_length(const struct vt_segments *segments);

/** How well flagged points agree with true edges. */
struct vt_judged {
    double precision; /**< share of the flagged points that lie within VT_EDGE_REACH spacings of an
                         edge */
    double recall;    /**< share of places on the edges, half a spacing apart, that have a flagged
                           point within VT_EDGE_REACH spacings */
    double share;     /**< share of all points that are flagged */
};

/** Judges n points in the unit of the segments; flag is 0 where a point is not flagged. A measure
 *  without flagged points, or without edges, is 1.
 *
 *  O(flagged segments + flagged places). */
struct vt_judged vt_segments_judge(const struct vt_segments *truth, const double *xyz,
                                   const unsigned char *flag, size_t n, double spacing);

/** Spacings within which a flagged point and an edge belong together. */
#define VT_EDGE_REACH 1.5

#endif
