/** Which way the input's surface faces: normals of its points with consistent signs.
 *
 *  Source: Huang 2009 ("Consolidation of unorganized point clouds"), as Huang 2013 Sec. 3 takes it,
 *  after Hoppe 1992: a normal is fitted to each point, and its sign spreads along a minimum
 *  spanning tree of the neighbour graph.
 *
 *  Departure: what an edge carries over is the normal mirrored at the plane midway between both
 *  ends (Koenig and Gumhold 2009, "Consistent propagation of normal orientations in point clouds"),
 *  not the normal itself: on a circular arc the two mirror each other, so that creases of 90
 *  degrees and thin parts keep their sides. An edge along a normal costs most, so that noise and
 *  nearby sheets are crossed last. Without the mirror 15,212 of 30,000 points of a plate 1 x 1 x
 *  0.02 are on the wrong side, with it 3 or fewer (three draws).
 *  Departure: where the surface is closed, all edges between two patches vote, winding numbers turn
 *  patches that edges cannot tell (geom/span.h, geom/winding.h), neighbours outvote single points,
 *  and a few points that were cut off join what is beside them. On open scans this did harm, and so
 *  it did where noise makes fits take more points than lists have (igea655k_noisy 7 of 10,000
 *  results instead of 0): both keep the first signs. Where the numbers say that the surface is not
 *  closed, signs are spread anew, across the points last that lie off their own fit, as beside an
 *  edge sharper than 90 degrees; these are kept if they close it better by a quarter. Without, of
 *  prisms with an edge of 70 and of 50 degrees 29 and 38 % of the points face inward, with it fewer
 *  than 0.5 %. Votes are not taken where they close it worse. All of this is done once
 *  more with edges by the planes of their ends (input/propagate.h), where these contradict any, and
 *  taken where it closes a component better by a quarter, or, if it stays open, where the numbers
 *  jump less by a quarter between its signs and the first. Inward without and with it, of inputs of
 *  10,000 to 22,000 points: a wedge 178 and 3, a screw 634 and 7, a gear 356 and 0, bodies nearly
 *  in contact, with noise, 4,769 and 7.
 *  Departure: where a list has both faces of a thin part, as at the rim of a blade, one height fits
 *  neither: a quadratic in x, y and z does, whose gradient says which points face alike
 *  (input/back.h). Edges are by it wherever a strip of points has it, in components where as
 *  many have as make a rim; where that leaves a component open, signs are spread once without.
 * Inward of 80,000 points where edges were by it for whole components or not at all, and so:
 * ellipsoids 5,001 and 57, foils 14,235 and 62, rounded plates 23 and 3; ellipsoids with noise of
 * 0.05 spacings 36,328 and 981. Departure: with noise, and where a surface is open, regions are
 * turned that three quarters of the edges around them contradict (geom/flip.h). Points on the wrong
 * side, of clouds with noise of 0.3 spacings, without and with it: a bore through a block 157 and
 * 10 of 5,921 (294 and 0 of 12,695), a gear's tooth 53 and 8 of 3,230, of sheets above each other
 * 97 and 3 of 7,282, 408 and 2 of 6,219. Measured, of 30,000 points of white noise those whose
 * normal leads into the face they were drawn from, and in brackets those of which all faces within
 * a spacing agree on it; the others lie on blades and creases, where the fit is that of another
 * face. Armadillo, ten draws: 12 to 57 (0 in five, 1 to 35 on fingers in the others, 75 in all);
 * igea and fandisk 1 (0); torus and knots of tube 0.4, 0.2 and 0.12: 0. The cow, whose tail lies
 * along its body, 400 to 1,200, before 1,200 to 1,400. Departure: each connected component then
 * faces away from its own inside. A closed surface has more of its normals, by area, leading away
 * from its middle than towards it: the flux of x minus the middle through it is three times its
 * volume. The same goes for a dome. Where that flux is small against the sum of the normals, as on
 * a terrain, the component faces upward: the largest coordinate of the sum of its normals is made
 * positive. A point's area counts by the share of its neighbours that have it among theirs: five
 * strays ten radii from a sphere of 4,000 points had more than the sphere, which then faced inward.
 * Departure: a surface with one side only, such as a Moebius band, is counted. */
#ifndef VOR_INPUT_ORIENT_H
#define VOR_INPUT_ORIENT_H

#include "core/input/domain.h"

/** Points with normals. All zero: none. */
struct vor_orientation {
    struct vor_domain thin; /**< the points; n is 0 if they are those of the domain itself */
    float *normal;          /**< a unit vector for each point */
    unsigned char *back;    /**< of each, an enum vor_back_at (input/back.h) */
    size_t components;      /**< connected components */
    size_t one_sided;       /**< those among them that have one side only */
};

/** What decides besides the points. */
struct vor_orient_how {
    size_t points; /**< of the result: a denser input is thinned */
    double area;   /**< of the surface, in squared normalised units; 0: nothing is thinned */
    int plain;     /**< there is one sheet in each place: lists have the nearest points, and nothing
                        walks along the surface to make them, which noise makes it do everywhere */
    const struct vor_attribute *carried; /**< normals of the domain's input; where three quarters of
                                              those of a component agree, that side is taken. Those
                                              that are zero or not finite do not count. Or NULL */
};

/** Orients the domain, or a thinned copy of it. The domain must outlive *out.
 *
 *  Thinned is what has more than VOR_THIN_EACH points for each one of the result, and where fits
 * take more than VOR_NEIGHBORS_FEWEST points, so many times more as to make up for it; normals are
 *  fitted to all points of the domain in any case.
 *
 *  @param[out] out  free with vor_orientation_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 186 bytes for each point that is left do not fit: the graph's 94, and 92
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same bytes for any number of threads. Measured on one thread,
 *  us a point: armadillo, 5,000,000 points thinned for a result of 100,000, 3.2 and 11 bytes;
 * 30,000 points, of which all are left, 20 (torus) to 60 (armadillo), nearly all of it the lists of
 * neighbours. */
VOR_NODISCARD vor_status vor_orient(struct vor_orientation *out, const struct vor_domain *domain,
                                    const struct vor_orient_how *how, const struct vor_run *run,
                                    struct vor_error *err);

/** Adds up, over the oriented points around x (normalised, of the same domain), which side `normal`
 *  is on: positive where it agrees with theirs, the nearest on its sheet first.
 *
 *  @param[in,out] normal  where the surface bends back on itself (input/back.h), what is fitted to
 *                         both faces has it in the end; elsewhere it stays as it is
 *  @param[out]    toward  the sum of their normals; there, the gradient's direction with their sign
 *  @param[in,out] last     of a row of places near each other
 *
 *  O(log n). */
double vor_orientation_side(const struct vor_orientation *orientation,
                            const struct vor_domain *domain, const float x[3], double normal[3],
                            double toward[3], struct vor_knn_last *last);

/** orientation may be all zero. */
static inline void vor_orientation_free(struct vor_orientation *orientation,
                                        struct vor_memory *memory)
{
    VOR_FREE_ALL(memory, orientation->back, orientation->normal);
    orientation->normal = NULL;
    orientation->back = NULL;
    vor_domain_free(&orientation->thin);
}

#endif
