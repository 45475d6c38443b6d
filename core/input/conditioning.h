/** What was found out about an input, and what was done to it, before anything moves on it.
 *
 *  Filled once, by vor_input_prepare (input/input.h), one finding after another; everybody after
 *  that only reads it. */
#ifndef VOR_INPUT_CONDITIONING_H
#define VOR_INPUT_CONDITIONING_H

#include <stddef.h>

/** A lattice that the coordinates were rounded to (input/lattice.h). Lengths are normalised. */
struct vor_lattice {
    double cell[3]; /**< along x, y and z; 0 where the coordinates are on no lattice, or have fewer
                         values than tell one */
    double spacing; /**< mean distance to the nearest other point; 0 where no axis has a cell */
    int matters;    /**< every axis has a cell or few values; the cells' rms is more than 0.4 of the
                         spacing, and none is below a fifth of it */
};

enum { VOR_NEIGHBORS_PLACES = 512 };

/** How many input points a surface is fitted to, by where it is (input/neighbors.h). */
struct vor_neighbors {
    unsigned usual, most;                /**< of all places taken together; of any */
    unsigned places;                     /**< VOR_NEIGHBORS_PLACES, or 0: `usual` everywhere */
    float xyz[3 * VOR_NEIGHBORS_PLACES]; /**< normalised */
    unsigned char k[VOR_NEIGHBORS_PLACES];
};

/** The fewest that are chosen: enough for a quadric of an exact input. */
#define VOR_NEIGHBORS_FEWEST 20

/** The same number everywhere, 1 to VOR_NEIGHBORS_MAX (geom/surface.h). */
static inline void vor_neighbors_fix(struct vor_neighbors *out, unsigned k)
{
    out->places = 0;
    out->usual = out->most = k;
}

struct vor_conditioning {
    size_t outliers;                /**< points that were dropped */
    struct vor_lattice lattice;     /**< that the coordinates were rounded to */
    size_t off_lattice;             /**< points that were moved within their cells; where there are
                                         any, positions are not exact */
    int sheets;                     /**< fits look for layers */
    struct vor_neighbors neighbors; /**< how many points a fit takes */
};

#endif
