/** Where an input ends: the closed rows of points around its holes and along its outer borders.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 5.5, which takes border points from the point cloud library: those with a wide
 *  angle between two neighbours that follow each other around them.
 *  Departure: by empty discs (geom/opening.h), which see holes of five spacings. Following the disc
 *  from point to point gives the loops, as in Bernardini et al. 1999, "The ball-pivoting algorithm
 *  for surface reconstruction".
 *
 *  A point is on the border if an empty disc of VOR_LOOPS_RADIUS spacings can touch it in its
 *  tangent plane. The disc, turned around the point, stops at the next border point on either side.
 *  Two points that stop the same disc at each other follow each other. Ends that are left over,
 * where tangent planes differ, are joined if their discs lie near each other. Rows that close are
 * loops.
 *
 *  Neighbours beyond a crease are unfolded about it into the tangent plane of the point: seen from
 * a sharp edge, the other side would lie over the hole in this one. Discs are folded back.
 *
 *  Neighbours that lie over the sheet of a point are left out, so that a sheet near to a border
 * does not hide it: those off its tangent plane where the normals say that the surface does not
 * bend there. Lists of neighbours (input/adjacency.h) lend their normals where the input is not
 * noisy; which points they hold does not matter, because they stop at creases, where nothing ends.
 *
 *  Measured on 40 balls of 20,000 points of white noise: none has a loop; of holes of 10 spacings
 * all 40 are found, 1.01 times as long as they are (deviation .03), of 5 spacings 39, .93 times
 * (.07). Half of armadillo, 80,000 points, has the four loops of its cut, cow, fandisk, igea and
 * the double shell none, bunny five holes. Two armadillos through each other have four that are
 * none, where they meet. Terrain with trees (autzen) and scan lines (kitti) have most rows open. */
#ifndef VOR_INPUT_LOOPS_H
#define VOR_INPUT_LOOPS_H

#include "core/input/domain.h"

/** Radius of the empty disc, in spacings of the input there (that of a square lattice as dense). At
 *  2.1 / 2.2 / 2.25 / 2.4: balls with a loop 2 of 20 / 1 of 20 / 0 of 40 / 0 of 20, holes of five
 *  spacings found 20 of 20 / 20 of 20 / 39 of 40 / 16 of 20. */
#define VOR_LOOPS_RADIUS 2.25

/** Turns from which on a loop is a hole, because then the surface lies around it. A hole in a plane
 *  has 1, the end of a tube 0, the outer border of a plane -1; on a ball, 0.3 is a hole of 72
 * degrees around its middle. Without knowing what should be there, this is what tells a hole from a
 * border that was meant: the cuts of half an armadillo have -0.2 to 0.2, the holes in bunny's base
 * 0.36 to 0.83. The length says nothing: small tubes have short ends. */
#define VOR_LOOPS_HOLE_TURNS 0.3

/** Points of a loop, of a row that does not close, and sites of a loop, from which on it counts: a
 *  shorter one is no wider than a spacing. */
enum { VOR_LOOPS_LEAST = 3 };

/** Sine of the angle between two normals from which on a crease lies between their points. */
#define VOR_LOOPS_CREASE 0.5

/** A loop. Lengths and positions are in normalised units (struct vor_domain). */
struct vor_loop {
    size_t first, count; /**< its points: point[first] .. point[first + count - 1] of the loops,
                            each beside the one before it, the last beside the first */
    double length;    /**< of the border, which lies VOR_LOOPS_BEYOND spacings beyond the points */
    double turns;     /**< how often the loop winds around what is not there, as seen along the
                           surface */
    double centre[3]; /**< mean of the line through its points, by length */
    double spacing;   /**< of the input along it */
};

struct vor_loops {
    struct vor_memory *memory;
    size_t count;          /**< loops */
    struct vor_loop *loop; /**< count: the longest first */
    uint32_t *point;       /**< numbers of the domain's points */
    size_t points;         /**< of all loops */
    size_t open;           /**< rows of three or more points that do not close */
};

/** Finds the loops of a domain.
 *
 *  @param[out] out     free with vor_loops_free; untouched on failure
 *  @param[in]  domain  indexed; read: xyz, knn, known.sheets, normals of graph if there are any
 *
 *  @retval VOR_E_NOMEM  5 bytes a point do not fit, and at worst 1,000 more for each that may be on
 * a border
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_loops_find(struct vor_loops *out, const struct vor_domain *domain,
                                        const struct vor_run *run, struct vor_error *err);

/** loops may be all zero. */
void vor_loops_free(struct vor_loops *loops);

#endif
