/** Triangles that are added one by one, such that they stay a manifold, and which of them meet at a
 *  point. */
#ifndef VOR_MESH_COMPLEX_H
#define VOR_MESH_COMPLEX_H

#include "core/base/memory.h"

#include <stdint.h>

/** Most triangles that meet at a point. On an even result it is five to seven. */
enum { VOR_AROUND_MOST = 20 };

/** In the place of a triangle's first point: it was taken away. */
#define VOR_COMPLEX_GONE UINT32_MAX

/** Triangles over n points. No edge has more than two; only vor_complex_takes says whether the
 *  triangles at a point stay one fan. */
struct vor_complex {
    struct vor_memory *memory;
    size_t n;
    uint32_t *triangle; /**< room x 3, of which `count` are set */
    size_t count, room;
    uint32_t *around;      /**< n x VOR_AROUND_MOST: the triangles at each point */
    unsigned char *degree; /**< n: how many */
};

/** Makes a complex of n points without triangles.
 *
 *  @param[out] out  free with vor_complex_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 105 bytes a point do not fit */
VOR_NODISCARD vor_status vor_complex_init(struct vor_complex *out, size_t n,
                                          struct vor_memory *memory, struct vor_error *err);

/** complex may be all zero. */
void vor_complex_free(struct vor_complex *complex);

/** Adds a triangle of three different points, each with fewer than VOR_AROUND_MOST.
 *
 *  @retval VOR_E_NOMEM  the complex is as it was */
VOR_NODISCARD vor_status vor_complex_add(struct vor_complex *complex, const uint32_t corner[3],
                                         struct vor_error *err);

/** Takes triangle t away. O(1). */
void vor_complex_remove(struct vor_complex *complex, uint32_t t);

/** Adds a triangle at the number of one that was taken away, each corner with fewer than
 *  VOR_AROUND_MOST. O(1). */
void vor_complex_put(struct vor_complex *complex, uint32_t t, const uint32_t corner[3]);

/** Replaces the edge from a to b, which two triangles have, by that between their third corners, as
 *  vor_complex_edge tells them, which have no edge yet and each fewer than VOR_AROUND_MOST
 *  triangles. The two triangles keep their numbers, and face as they did. O(1). */
void vor_complex_flip(struct vor_complex *complex, uint32_t a, uint32_t b, const uint32_t third[2]);

/** Whether all stays a manifold of the same kind if the edge from a to b shrinks to a point: its
 *  ends have no neighbours in common but the third corners of its triangles, it does not join two
 *  loops, and no point has too many or too few triangles then. O(1). */
int vor_complex_collapses(const struct vor_complex *complex, uint32_t a, uint32_t b);

/** Shrinks the edge from a to b: the triangles of b get a in its place, those of the edge go, and b
 *  has none. Returns how many went; their numbers are the first that b's list has. O(1). */
unsigned vor_complex_collapse(struct vor_complex *complex, uint32_t a, uint32_t b);

/** Puts point `middle`, which has no triangles, on the edge from a to b: its triangles are halved.
 *  Their third corners have fewer than VOR_AROUND_MOST. The halves get the numbers of `spare`
 *  triangles that went, which the list of `middle` has.
 *
 *  @retval VOR_E_NOMEM  a triangle is missing */
VOR_NODISCARD vor_status vor_complex_split(struct vor_complex *complex, uint32_t a, uint32_t b,
                                           uint32_t middle, unsigned spare, struct vor_error *err);

/** How many triangles have the edge from a to b, and the third corners of the first two. */
unsigned vor_complex_edge(const struct vor_complex *complex, uint32_t a, uint32_t b,
                          uint32_t third[2]);

/** The other two corners of triangle t, which has corner a. */
static inline void vor_complex_others(const struct vor_complex *complex, uint32_t t, uint32_t a,
                                      uint32_t other[2])
{
    const uint32_t *corner = &complex->triangle[3 * (size_t)t];

    other[0] = corner[0] == a ? corner[1] : corner[0];
    other[1] = corner[2] == a ? corner[1] : corner[2];
}

/** The triangle other than t that has the edge from a to b; t itself where there is none. */
uint32_t vor_complex_across(const struct vor_complex *complex, uint32_t t, uint32_t a, uint32_t b);

/** Whether triangle t alone has the edge from its corner c on. */
int vor_complex_is_open(const struct vor_complex *complex, size_t t, int c);

/** Whether a triangle of such corners runs from a to b. */
int vor_complex_runs(const uint32_t corner[3], uint32_t a, uint32_t b);

/** Whether all stays a manifold with the triangle: none of its edges has two already, and the
 *  triangles at each corner are parts of one fan, which closes only with the last of them. O(1). */
int vor_complex_takes(const struct vor_complex *complex, const uint32_t corner[3]);

/** Whether triangles surround point i: it has some, and each of its edges has two. O(1). */
int vor_complex_surrounds(const struct vor_complex *complex, uint32_t i);

/** Numbers the fans at a point, runs of triangles of which each shares an edge at the point with
 *  the next: 0, 1 ... in `fan`, as the point's triangles come. Returns how many there are. */
unsigned vor_complex_fans(const struct vor_complex *complex, uint32_t i,
                          unsigned char fan[VOR_AROUND_MOST]);

/** Takes away triangles at points with several fans, those of all fans but the largest, until there
 *  are none such. O(n), and O(1) for each that is taken away. */
void vor_complex_prune(struct vor_complex *complex);

#endif
