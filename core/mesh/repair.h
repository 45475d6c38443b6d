/** Repairs triangulations: removes dislocations, pairs of points with five and seven triangles, and
 *  other points that have not six, which no motion of points removes.
 *
 *  Around each such point a patch of two rings is remeshed on trial: an edge is collapsed or split
 *  or neither, then edges are flipped until no flip brings points nearer to six triangles. Where
 *  that is so, the points of the patch are moved (mesh/relax.h), and where its triangles are better
 *  then, the patch is replaced. Collapses and splits are made in pairs: the point that goes comes
 *  back at the split. So dislocations that are near each other annihilate; a lone one stays.
 *
 *  Source: Lv, Lin and Zhao 2022, Sec. 4.1, after Botsch and Kobbelt 2004, for the operations.
 *  Departure: they are made where they pay, by the strain of the triangles, instead of wherever an
 *  edge is long or short. Points on creases take part, and move along the creases; edges across
 *  creases may be flipped, as no points lie on the creases themselves. On fandisk to 10,000 points
 *  39 have eight triangles and more without repair, 1 with it, 6 where points on creases stay.
 *
 *  Departure: results that are only points are not repaired. Without a mesh, energy and distances
 *  count, and fewer cells without six sides do not lower them. Around each of the twelve
 *  disclinations of a curved crystal, dislocations in a row (a scar) take up stress: in the ground
 *  state .41 R / a of them on a sphere of radius R with spacing a, R / a = sqrt(n sqrt(3) / (8 pi))
 *  (Bowick, Nelson, Travesset 2000; Bausch et al. 2003, "Grain boundary scars and spherical
 *  crystallography"), 196 cells without six sides of 5,072. Measured (eta, delta, of those cells;
 *  cvt, default polish, mean of three seeds): sphere 161, .0051, .0154; with polish=400 170, .0044,
 *  .0143; the icosahedral lattice after 150 Lloyd steps 12, .0046, .0306. Seeds that start
 *  from coarse to fine have no more of the cells that cost: before they did, 469 on the sphere.
 *
 *  For the same reason a repair leaves most of them. On a torus without disclinations, rows along
 *  the tube's meridians that keep their distance begin and end at 8 pi r / a dislocations, which
 *  for radii 1 and r = .4 and 10,000 points are 235; in the ground state fivefold disclinations
 *  outside and sevenfold ones inside take the place of some (Giomi and Bowick 2008, "Elastic theory
 *  of defects in toroidal crystals"). Longer polish does not remove them either. Points without six
 *  triangles, and eta, at polish=120 / 400 / 1500: sphere 144, .0047 / 142, .0045 / 144, .0045,
 *  repaired 136, .0040 / 138, .0038 / 136, .0038; torus to 10,000 268, .0051 / 271, .0048 / 270,
 *  .0048, repaired 224, .0045 / 236, .0042 / 228, .0041; igea to 20,000 586, .0071 / 572, .0066 /
 *  550, .0062, repaired 482, .0067 / 500, .0064 / 486, .0059. */
#ifndef VOR_MESH_REPAIR_H
#define VOR_MESH_REPAIR_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Repairs a triangulation. It stays a manifold with the same loops and parts; points on loops
 * stay.
 *
 *  @param[in,out] sheet  its normals become those where the points are
 *  @param[in,out] seeds  those of the sheet; their lists are not renewed; their spacing is even
 *  @param[in]     fixed  that many of the last ones stay
 *  @param[in]     how    last fits are used again, finer ones where it says so
 *
 *  @retval VOR_E_NOMEM  3 bytes a seed and 48 a point with faults do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n), and 0.2 ms a point with faults, mostly on one thread. The same triangles for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_repair(struct vor_complex *complex, struct vor_sheet *sheet,
                                    struct vor_seeds *seeds, size_t fixed,
                                    const struct vor_recall *how, struct vor_error *err);

#endif
