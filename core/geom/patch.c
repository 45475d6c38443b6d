#include "core/geom/patch.h"

#include <assert.h>
#include <string.h>

/* Index of vertex number `step` of a ring: 0 .. 6 ring - 1, counter-clockwise. */
static unsigned ring_vertex(unsigned ring, unsigned step)
{
    if (ring == 0)
        return 0;
    return 1 + 3 * ring * (ring - 1) + step % (6 * ring);
}

static void add_triangle(struct vor_disc *disc, unsigned a, unsigned b, unsigned c)
{
    unsigned char *t = disc->triangle[disc->triangle_count++];

    t[0] = (unsigned char)a;
    t[1] = (unsigned char)b;
    t[2] = (unsigned char)c;
}

void vor_disc_init(struct vor_disc *disc, unsigned rings)
{
    assert(rings <= VOR_PATCH_RINGS_MAX);
    memset(disc, 0, sizeof *disc);
    disc->vertex_count = 1;
    for (unsigned ring = 1; ring <= rings; ring++) {
        for (unsigned side = 0; side < 6; side++) {
            const double *a = vor_patch_corner[side], *b = vor_patch_corner[(side + 1) % 6];

            for (unsigned i = 0; i < ring; i++) {
                double t = (double)i / ring, r = (double)ring / rings;
                double *vertex = disc->vertex[disc->vertex_count++];

                vertex[0] = r * (a[0] + t * (b[0] - a[0]));
                vertex[1] = r * (a[1] + t * (b[1] - a[1]));
            }
        }
        for (unsigned side = 0; side < 6; side++)
            for (unsigned i = 0; i < ring; i++) {
                unsigned outer = side * ring + i, inner = side * (ring - 1) + i;

                add_triangle(disc, ring_vertex(ring, outer), ring_vertex(ring, outer + 1),
                             ring_vertex(ring - 1, inner));
                if (i + 1 < ring)
                    add_triangle(disc, ring_vertex(ring, outer + 1),
                                 ring_vertex(ring - 1, inner + 1), ring_vertex(ring - 1, inner));
            }
    }
}
