/** What is known of an input, and what was done to it, before anything moves on it.
 *
 *  vor_input_prepare (input/input.h) fills it once, one finding after another; after that it is
 *  only read. */
#ifndef VOR_INPUT_CONDITIONING_H
#define VOR_INPUT_CONDITIONING_H

#include "core/geom/surface.h"
#include "core/report.h"

#include <stddef.h>

/** A lattice that the coordinates were rounded to (input/lattice.h). Lengths are normalised. */
struct vor_lattice {
    double cell[3]; /**< sides along x, y and z; 0 for an axis with no lattice, or with too few
                         different values to find one */
    double spacing; /**< mean distance to the nearest other point; 0 where no axis has a cell */
    int matters;    /**< the cells are not small against the spacing: every axis has a cell, of at
                         least EXACT spacings, or few values, and the rms of the cells is more than
                         SMALL spacings (input/lattice.c) */
};

/** Places of the input whose number of neighbours is estimated. Sixteen pools of 32 (POOL in
 *  neighbors.c) fit into them; the estimate costs about 20 ms. */
enum { VOR_NEIGHBORS_PLACES = 512 };

/** Successive ones, which are near each other, that have a box. */
enum { VOR_NEIGHBORS_BATCH = 16, VOR_NEIGHBORS_BOXES = VOR_NEIGHBORS_PLACES / VOR_NEIGHBORS_BATCH };

/** How many input points a surface is fitted to, by where it is (input/neighbors.h). */
struct vor_neighbors {
    unsigned usual, most;                  /**< number for all places together; largest of any */
    unsigned places;                       /**< VOR_NEIGHBORS_PLACES, or 0: `usual` everywhere */
    float xyz[3 * VOR_NEIGHBORS_PLACES];   /**< normalised */
    unsigned char k[VOR_NEIGHBORS_PLACES]; /**< number at each place */
    double low[3][VOR_NEIGHBORS_BOXES];    /**< corners of the boxes */
    double high[3][VOR_NEIGHBORS_BOXES];
};

/** Sets the same number everywhere: 1 .. VOR_NEIGHBORS_MAX (geom/surface.h). */
static inline void vor_neighbors_fix(struct vor_neighbors *out, unsigned k)
{
    out->places = 0;
    out->usual = out->most = k;
}

/** Places of the input that are searched for layers (input/sheets.h). */
enum { VOR_SHEETS_PLACES = 128 };

/** Where one sheet of an input lies over another (input/sheets.h). */
struct vor_sheeted {
    unsigned count;                       /**< places where most of those around have layers */
    unsigned char has[VOR_SHEETS_PLACES]; /**< whether a place is one of them */
    float xyz[3 * VOR_SHEETS_PLACES];     /**< normalised */
};

/** Which lists of neighbours on one sheet the domains of an input have (input/lists.h). */
enum vor_lists {
    VOR_LISTS_NONE,
    VOR_LISTS_LOCAL,     /**< input/adjacency.h */
    VOR_LISTS_FEW,       /**< the same near places with a second sheet, else the nearest points */
    VOR_LISTS_SATELLITES /**< input/satellites.h */
};

/** What became of the holes where they were to be filled (input/holes.h). */
struct vor_holes {
    int asked;                        /**< they were; else all of this is 0 */
    size_t loops, filled, not_closed; /**< in all; of them that were filled, or could not be */
    size_t points;                    /**< that they were filled with */
    struct vor_hole_told told[VOR_HOLES_TOLD];
    unsigned told_count;
};

/** The findings. All zero, with neighbors fixed, means that nothing is known. */
struct vor_conditioning {
    /** Normals of the input that may be used, borrowed from it; NULL: none. */
    const struct vor_attribute *carried;
    size_t distinct;                /**< points that share no place with an earlier one */
    size_t outliers;                /**< points that were dropped, or pulled */
    size_t parts;                   /**< that are clear of each other (input/islands.h) */
    size_t islands, in_islands;     /**< parts that are small, and the points that these hold */
    struct vor_lattice lattice;     /**< that the coordinates were rounded to */
    double pitch[2];                /**< of two lattices that parts of the input have instead, the
                                         narrowest and the widest (vor_regions); or 0 */
    size_t off_lattice;             /**< points that were moved within their cells; if any were,
                                         positions are not exact */
    int seek_sheets;                /**< sheets are looked for, on thinned domains too */
    int sheets;                     /**< the domain has sheets on much of it */
    struct vor_sheeted sheeted;     /**< where fits look for layers */
    enum vor_lists lists;           /**< of neighbours, that every domain of the input has */
    int parted;                     /**< where it has, lists keep to regions (input/regions.h) */
    unsigned hidden;                /**< of VOR_NEIGHBORS_PLACES, those where noise hides the
                                         surface; 0 if they are few (input/noise.h) */
    struct vor_neighbors neighbors; /**< how many points a fit takes */
    struct vor_holes holes;         /**< that were filled */
};

#endif
