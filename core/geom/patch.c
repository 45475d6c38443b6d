#include "core/geom/patch.h"

#include <assert.h>
#include <string.h>

/* Index of vertex number `step` of a ring: 0 .. sides ring - 1, counter-clockwise. */
static unsigned ring_vertex(unsigned sides, unsigned ring, unsigned step)
{
    if (ring == 0)
        return 0;
    return 1 + sides / 2 * ring * (ring - 1) + step % (sides * ring);
}

static void add_triangle(struct vor_disc *disc, unsigned a, unsigned b, unsigned c)
{
    unsigned char *t = disc->triangle[disc->triangle_count++];

    t[0] = (unsigned char)a;
    t[1] = (unsigned char)b;
    t[2] = (unsigned char)c;
}

/* Adds the vertices of a ring on the side from corner a to corner b. */
static void add_vertices(struct vor_disc *disc, unsigned ring, unsigned rings, const double a[2],
                         const double b[2])
{
    for (unsigned i = 0; i < ring; i++) {
        double t = (double)i / ring, r = (double)ring / rings;
        double *vertex = disc->vertex[disc->vertex_count++];

        vertex[0] = r * (a[0] + t * (b[0] - a[0]));
        vertex[1] = r * (a[1] + t * (b[1] - a[1]));
    }
}

/* Adds the triangles between a side of a ring and the ring within it. */
static void add_triangles(struct vor_disc *disc, unsigned ring, unsigned side)
{
    unsigned sides = disc->sides;

    for (unsigned i = 0; i < ring; i++) {
        unsigned outer = side * ring + i, inner = side * (ring - 1) + i;

        add_triangle(disc, ring_vertex(sides, ring, outer), ring_vertex(sides, ring, outer + 1),
                     ring_vertex(sides, ring - 1, inner));
        if (i + 1 < ring)
            add_triangle(disc, ring_vertex(sides, ring, outer + 1),
                         ring_vertex(sides, ring - 1, inner + 1),
                         ring_vertex(sides, ring - 1, inner));
    }
}

void vor_disc_init(struct vor_disc *disc, unsigned sides, unsigned rings)
{
    const double(*corner)[2] = sides == VOR_PATCH_OCTAGON ? vor_patch_octagon : vor_patch_corner;

    assert(sides == VOR_PATCH_HEXAGON || sides == VOR_PATCH_OCTAGON);
    assert(sides * rings * rings <= VOR_PATCH_TRIANGLES_MAX);
    memset(disc, 0, sizeof *disc);
    disc->sides = sides;
    disc->vertex_count = 1;
    for (unsigned ring = 1; ring <= rings; ring++) {
        for (unsigned side = 0; side < sides; side++)
            add_vertices(disc, ring, rings, corner[side], corner[(side + 1) % sides]);
        for (unsigned side = 0; side < sides; side++)
            add_triangles(disc, ring, side);
    }
}
