/** The smooth sides of the surface around a hole that lies across creases: each is carried on into
 *  the hole by itself, up to where it meets the others (input/fill.h). */
#ifndef VOR_INPUT_HOLE_SIDES_H
#define VOR_INPUT_HOLE_SIDES_H

#include "core/input/band.h"

/** Most sides: those that meet at the corner of a box. */
#define VOR_HOLE_SIDES 3

/** Finds the side that each point of a band lies on, by normals of the domain's lists
 *  (input/adjacency.h): the normals along the loop form two or three groups, each of them in one
 *  piece of the loop, and from piece to piece the normal jumps. Along a smooth surface it turns.
 *
 *  @param[out] side  band->count: 0 .. sides - 1
 *
 *  @return how many sides there are: 1 where the surface is smooth, the band is not laid out by
 *          projection, or the lists have no normals
 *
 *  O(points of the band). Cannot fail. Depends on nothing but its arguments. */
unsigned vor_hole_sides_find(unsigned char *side, const struct vor_band *band,
                             const struct vor_domain *domain);

#endif
